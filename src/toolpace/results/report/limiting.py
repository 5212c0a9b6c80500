"""The limit that holds the motion back at each time."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from toolpace.common.arrays import Floats, Ints
from toolpace.machine.limits import KINDS

if TYPE_CHECKING:
    from toolpace.motion.trajectory import Trajectory

BINDING = 0.99
"""Share of a limit from which it is shown as binding."""
NOTHING = -1
"""Stands where nothing binds, in place of the number of a limit."""


def limit_names(joints: tuple[str, ...]) -> list[str]:
    """What can bind, as `Trajectory.limited_by` names it: "feed", "velocity X", ..."""
    return ["feed", *(f"{kind} {joint}" for kind in KINDS for joint in joints)]


def binding(trajectory: Trajectory, t: Floats) -> Ints:
    """(n,) at each time t [s] the number (in `limit_names`) of the limit that is used most, NOTHING where none
    binds."""
    motion = trajectory.at(t)
    limits = trajectory.limits
    shares = [np.abs(v) / getattr(limits, kind) for v, kind in zip((motion.qd, motion.qdd, motion.qddd), KINDS)]
    ratios = np.column_stack((_feed_share(trajectory, t), *shares))
    most = ratios.argmax(axis=1)
    found: Ints = np.where(ratios[np.arange(len(t)), most] >= BINDING, most, NOTHING)
    return found


def _feed_share(trajectory: Trajectory, t: Floats) -> Floats:
    """(n,) path speed over its cap, which stands for the feed and for the least time of a block."""
    share = np.zeros(len(t))
    run = trajectory.run_at(t)
    for k in np.unique(run):
        law, of_run = trajectory.laws[k], run == k
        local = t[of_run] - trajectory.starts[k]
        s, speed, *_ = law.at(np.clip(local, 0.0, law.duration))
        axis_run = trajectory.axis_path.runs[k]
        share[of_run] = np.where(
            local <= law.duration, speed / axis_run.speed_cap(np.clip(s, axis_run.s0, axis_run.s1)), 0.0
        )
    return share
