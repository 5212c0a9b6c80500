"""Play a G93 stream on a real LinuxCNC, under its guard and the own limits of the machine; its log against the plan."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from testbed.linuxcnc.configuration import Configuration
from testbed.linuxcnc.run import LinuxCNCError, Log, run_program
from toolpace.common.arrays import Floats, Ints
from toolpace.controls.export import PlannedMotion
from toolpace.machine.limits import Limits
from toolpace.machine.machine import Machine

FILES = ("guard.hal", "limits.hal")
PATH = 60.0
"""MAX_LINEAR_VELOCITY of the control [mm/s]: limits as a machine has them, none that are lifted."""
SPEEDS = (2, 1, 1)
"""Times real time. A computer that is too busy leaves the queue empty: joints stand at once, and the guard stops them.
Then the stream is played again, slower; what the guard stops without a reason it stops each time."""
STOPPED = "motion stopped by enable input"
"""What LinuxCNC says where the guard stops it."""
PAD = 2.0
"""Time at rest before a stream [s]; each second of it puts half a second of blocks into the queue."""
MOVED = 2e-5
"""By which a joint has left where it stood, so fast by then that the cycle is told [m or rad]."""
BEHIND = 100
"""Cycles behind the last set-point that are looked at: what comes late is late there."""
EVERY = 5
"""Of the set-points, those by which the log is put in place."""


@dataclass(frozen=True)
class Streamed:
    """How a log compares with set-points, one a servo cycle, after one fixed shift."""

    cycles: int
    """By which the motion took longer than planned."""
    slides: float
    """Largest difference of a linear joint in any cycle [m]."""
    turns: float
    """Largest difference of a rotary joint in any cycle [rad]."""
    usage: float
    """Largest share of a joint's limit of velocity, acceleration or jerk: a block is two cycles of even speed, so that
    differences are taken over two cycles, in both phases."""


def configuration(machine: Machine, cycle: float, tip: bool = False) -> Configuration:
    """The machine with its own limits."""
    made = Configuration.tip(machine, PATH) if tip else Configuration.joints(machine, PATH)
    return replace(made, cycle=cycle)


def play_stream(
    out: Path, machine: Machine, cycle: float, *, tip: bool = False, stream: str | None = None, to_the_end: bool = True
) -> Log:
    """The log of the stream in the folder of an export, or of another text in its place, under the guard."""
    text = (out / "stream.ngc").read_text() if stream is None else stream
    # nobody stands beside it who puts the next tool in and presses start
    text = text.replace("\nM0\n", "\nG4 P0.3\n")
    guard = tuple((out / name).read_text() for name in FILES)
    for speed in SPEEDS:
        log = run_program(text, configuration(machine, cycle, tip), speed=speed, hal=guard, to_the_end=False)
        if log.ended or not to_the_end:
            return log
        if STOPPED not in log.messages:
            break
    raise LinuxCNCError(f"the stream was stopped behind line {log.line.max()}: {'; '.join(log.messages)}")


def against(log: Log, motion: PlannedMotion, rows: slice = slice(None)) -> Streamed:
    """The log of a stream of a plan whose set-points are a servo cycle apart, or of some of them."""
    joints, points = log.of(motion.joints), motion.setpoints.q[rows]
    shift = _shift(joints, points)
    off = np.abs(joints[shift : shift + len(points)] - points)
    linear = ~np.array(motion.rotary)
    here = joints[shift : shift + len(points) + BEHIND]
    return Streamed(
        int(_span(here, points) - _span(points, points)),
        float(off[:, linear].max()),
        float(off[:, ~linear].max(initial=0.0)),
        max(usage(here[phase::2], motion.machine.limits, 2.0 * motion.dt) for phase in (0, 1)),
    )


def usage(joints: Floats, limits: Limits, step: float) -> float:
    """Largest share of a limit, by differences of positions (n, m) `step` [s] apart."""
    kinds = (limits.velocity, limits.acceleration, limits.jerk)
    return max(
        float((np.abs(np.diff(joints, n=order, axis=0)).max(axis=0) / step**order / limit).max())
        for order, limit in enumerate(kinds, start=1)
    )


def _shift(joints: Floats, points: Floats) -> int:
    """Cycles by which a log (n, m) lies behind set-points (k, m)."""
    last = len(joints) - len(points) + 1
    worst = [np.abs(joints[at : at + len(points) : EVERY] - points[::EVERY]).max() for at in range(last)]
    return int(np.argmin(worst))


def _span(joints: Floats, points: Floats) -> int:
    """Cycles from leaving the first set-point to reaching the last."""
    left: Ints = np.flatnonzero((np.abs(joints - points[0]) > MOVED).any(axis=1))
    away: Ints = np.flatnonzero((np.abs(joints - points[-1]) > MOVED).any(axis=1))
    return int(away[-1] - left[0])
