"""
Follow a disturbed run
======================

The tool bends while it cuts. A follower takes what is measured of the tip, with noise and late, and gives set-points
that aim off, each millisecond, within every limit: the path is planned with a tenth of the limits in reserve, and the
correction moves with that tenth.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import toolpace as tp
from toolpace.deflection.following import SetPoint, Status
from toolpace.results.report import follow_report, limit_shares

reserve, lag, late = 0.1, 5, 4  # set-points by which the drives come late, and the measurements
machine = tp.Machine.load("paper-ab")
trajectory = tp.plan(tp.Path.paper_arc(), machine.reserved(reserve))

# %%
# A tool that bends by 100 micrometres from 0.5 s to 3 s and then the other way, and a third more as the command goes
# against it; a runout of 15 micrometres; noise. The sensor gives what was 4 ms before, the drives are 5 ms behind.


def run(corrected: bool) -> tuple[list[SetPoint], np.ndarray]:
    """Set-points, and what the tip is off by at each of them (n, 3) [m]."""
    random = np.random.default_rng(1)
    follower = tp.Follower(trajectory, machine, reserve=reserve, delay=lag * 1e-3, gain=0.1, rho=0.3)
    setpoints, measured, errors = [], [], []
    while not setpoints or Status.ENDED not in setpoints[-1].status:
        k = len(setpoints)
        time = k * follower.period
        on_path, tip = np.zeros(3), np.zeros(3)
        if k > lag:
            now = setpoints[k - 1 - lag]
            on_path, tip = machine.forward(np.stack([now.q - now.correction[0], now.q]))[0]
        bending = np.array([100e-6, 0.0, 40e-6]) * (0.0 if time < 0.5 else 1.0 if time < 3.0 else -0.6)
        runout = 15e-6 * (time >= 0.5) * np.array([np.cos(628.0 * time), np.sin(628.0 * time), 0.0])
        error = (1.0 - 0.3) * (tip - on_path) + bending + runout
        errors.append(error)
        measured.append(tp.Measurement(time, tip=on_path + error + 2e-6 * random.normal(size=3)))
        arrived = measured[k - late] if corrected and k > lag + late else None
        setpoints.append(follower.step(arrived, feed=0.5 if 4.0 < time < 4.6 else 1.0))
    return setpoints, np.array(errors)


setpoints, with_correction = run(True)
_, without = run(False)
n = min(len(without), len(with_correction))

# %%
# What is left of the error, and what path and correction use of the limits of jerk.

t = np.array([each.t for each in setpoints])
used = limit_shares(setpoints, machine)
figure, (left, right) = plt.subplots(1, 2, figsize=(12, 4.5), layout="constrained")
for error, name in ((without, "without correction"), (with_correction, "with correction")):
    left.plot(t[:n], 1e6 * np.linalg.norm(error[:n], axis=1), linewidth=0.8, label=name)
left.set(xlabel="time [s]", ylabel="error of the tip [µm]")
for row, name in zip(used["jerk"], ("path", "correction", "both")):
    right.plot(t, 100.0 * row, linewidth=0.8, label=name)
right.axhline(100.0, color="black", linestyle="--", linewidth=0.8)
right.set(xlabel="time [s]", ylabel="jerk, of the limit [%]")
for panel in (left, right):
    panel.legend()
    panel.grid(alpha=0.3)
plt.show()

# %%
# A page that plays the run.

folder = Path(tempfile.mkdtemp())
follow_report(
    folder / "followed.html",
    setpoints[:n],
    machine,
    {"with correction": with_correction[:n], "without correction": without[:n]},
    "The study's arc with a tool that bends",
)
print(f"{len(setpoints)} set-points, most of a limit {max(row[2].max() for row in used.values()):.4f}")
