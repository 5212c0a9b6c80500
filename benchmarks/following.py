"""The live follower: what it makes of a tool that bends, when it gets unstable, and how long a step takes.

python -m benchmarks.following        writes benchmarks/results/following.md
"""

from __future__ import annotations

import math
import time

import numpy as np

from benchmarks.follow_steps import kernel_times, ruckig_times
from benchmarks.machine import RESULTS, written_by
from benchmarks.running_means import beside_the_tracker
from benchmarks.tables import Table
from testbed.followed.cases import CASES, RESERVES, case
from testbed.followed.holds import PLACES, hold_times
from testbed.followed.plant import Plant, below, critical, followed, grows, largest_root
from toolpace.common.arrays import Floats
from toolpace.deflection.following import Follower
from toolpace.deflection.following.settings import Figures
from toolpace.machine.machine import Machine
from toolpace.motion.trajectory import Trajectory
from toolpace.path.path import Path
from toolpace.planning.planner import plan

GAINS, DELAYS, RHOS = (0.05, Figures.gain, 0.1), (0, 2, 4, 6, 8, 10), (0.0, 0.3, 0.6, 0.9)
TURN = 10
"""Set-points of a turn of the spindle: what runout does is none in a mean over it."""
SLOW = 20.0
"""What the drives can be asked to follow is below this [Hz]."""


def figures_of(error: Floats, plant: Plant, period: float) -> list[float]:
    """After 100 ms, mean over a turn; then rms from there on: mean over a turn, below 20 Hz, and of all [um]."""
    mean = np.stack([np.convolve(column, np.full(TURN, 1.0 / TURN), "same") for column in error.T], axis=1)
    begin = int((plant.start + 0.1) / period)
    parts = (mean, below(error[begin:], SLOW, period), error[begin:])
    rms = [1e6 * float(np.sqrt((part[-len(error) + begin :][:-TURN] ** 2).sum(axis=1).mean())) for part in parts]
    return [1e6 * float(np.linalg.norm(mean[begin])), *rms]


def plant_table(trajectory: Trajectory, machine: Machine) -> Table:
    """The plant that was asked for, with its rho told and not told."""
    heads = ["gain", "rho told", "after 100 ms, a turn's mean", "rms of a turn's mean", "rms below 20 Hz", "rms of all"]
    table = Table(
        "Error of the tip [um]: bending 100 um with rho 0.3, runout 15 um, noise 2 um, dead time 4 ms, lag 5 ms", heads
    )
    plant = Plant()
    count = int(trajectory.duration / 1e-3)
    blind = Follower(trajectory, machine)
    error, _ = followed(blind, plant, count, measured=False)
    table.lines.append(["no correction", "", *(f"{x:.1f}" for x in figures_of(error, plant, 1e-3))])
    for gain in GAINS:
        for told in (0.3, 0.0):
            follower = Follower(trajectory, machine, delay=plant.lag, gain=gain, rho=told)
            error, _ = followed(follower, plant, count)
            table.lines.append([f"{gain:g}", f"{told:g}", *(f"{x:.1f}" for x in figures_of(error, plant, 1e-3))])
    return table


def delay_table(trajectory: Trajectory, machine: Machine, gain: float) -> Table:
    """Over dead time and rho; rho not told, and told."""
    heads = ["dead time [ms]", *(f"rho {rho:g}" for rho in RHOS), *(f"rho {rho:g}, told" for rho in RHOS)]
    table = Table(
        f"Error after 100 ms, a turn's mean, and rms of a turn's mean from then on [um], gain {gain:g}", heads
    )
    for delay in DELAYS:
        line = [f"{delay}"]
        for told in (False, True):
            for rho in RHOS:
                plant = Plant(rho=rho, dead_time=1e-3 * delay)
                told_rho = rho if told else 0.0
                # what it settles at is bending / (1 - rho)
                follower = Follower(
                    trajectory,
                    machine,
                    delay=plant.lag,
                    gain=gain,
                    rho=told_rho,
                    max_correction=2e-3,
                    patience=math.inf,
                )
                error, _ = followed(follower, plant, 3500)
                line.append("{:.1f}, {:.1f}".format(*figures_of(error, plant, 1e-3)[:2]))
        table.lines.append(line)
    return table


def stability_table(trajectory: Trajectory, machine: Machine) -> tuple[Table, float]:
    """Gain from which the loop grows: by its characteristic polynomial, and by the kernel at small signals."""
    heads = ["set-points late", "of these known", "rho", "rho told", "predicted", "found", "off by [%]"]
    follower = Follower(trajectory, machine)
    table, worst = Table("Gain from which small signals grow", heads), 0.0
    cases = [(d, 0, 0.0, 0.0) for d in (1, 2, 3, 5, 7, 10)]
    cases += [(10, 6, 0.0, 0.0), (6, 10, 0.0, 0.0), (5, 0, 0.3, 0.0), (5, 0, 0.0, 0.3), (1, 1, 0.3, 0.0)]
    cases += [(1, 1, 0.9, 0.0), (5, 5, 0.6, 0.0), (5, 5, 0.0, 0.6), (4, 4, 0.2, 0.9)]
    for row in cases:
        late, known, rho, told = row
        predicted = critical(lambda gain, row=row: largest_root(gain, *row) > 1.0, 1e-3, 2.0, 30)
        found = critical(lambda gain, row=row: grows(follower, gain, *row), 1e-3, 2.0, 11)
        off = 100.0 * (found / predicted - 1.0)
        worst = max(worst, abs(off))
        table.lines.append(
            [f"{late}", f"{known}", f"{rho:g}", f"{told:g}", f"{predicted:.4f}", f"{found:.4f}", f"{off:+.1f}"]
        )
    return table, worst


def hold_table() -> Table:
    """How soon the path stands after a hold, by motion and reserve."""
    heads = ["motion", *(f"reserve {reserve:g}" for reserve in RESERVES)]
    table = Table(f"Time from a feed of 0 to a pace of 0, median and worst of {PLACES} places [s]", heads)
    for name in CASES:
        times = [hold_times(case(name, reserve), reserve) for reserve in RESERVES]
        table.lines.append([name, *(f"{np.median(each):.2f}, {each.max():.2f}" for each in times)])
    return table


def main() -> None:
    """All tables, on the terminal and in benchmarks/results."""
    began = time.process_time()
    machine = Machine.load("paper-ab")
    trajectory = plan(Path.paper_arc(), machine.reserved(0.1), bound=False)
    stability, worst = stability_table(trajectory, machine)
    tables = [plant_table(trajectory, machine), *(delay_table(trajectory, machine, gain) for gain in GAINS), stability]
    tables += [hold_table(), kernel_times(), ruckig_times(), beside_the_tracker()]
    for table in tables:
        table.show()
    print(f"stability: at most {worst:.1f} % off; {time.process_time() - began:.0f} s of CPU time")
    text = (
        "# The live follower\n\n"
        f"{written_by('python -m benchmarks.following')} The machine was shared with other jobs meanwhile.\n\n"
        "The path is the study's arc on `paper-ab`, planned with a tenth of the limits in reserve. Runout turns 100\n"
        "times a second: no axis follows it, and none shall; a mean over a turn is free of it.\n\n"
    )
    (RESULTS / "following.md").write_text(text + "\n".join(table.markdown() for table in tables))


if __name__ == "__main__":
    main()
