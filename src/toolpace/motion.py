"""The motion of the joints from a path and a state on it, and how it stands to the limits."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from toolpace.arrays import Floats
from toolpace.axispath.run import AxisRun
from toolpace.machine.limits import Limits


@dataclass(frozen=True)
class Motion:
    """Joint positions and three time derivatives, each (n, joints) [m or rad, s]."""

    q: Floats
    qd: Floats
    qdd: Floats
    qddd: Floats


def joint_motion(path: Floats, state: Floats) -> Motion:
    """The chain rule: path derivatives (4, n, joints) and a state (4, n) of s give the motion of the joints."""
    q, q1, q2, q3 = path
    v, a, j = (state[i][:, None] for i in (1, 2, 3))
    return Motion(q, q1 * v, q2 * v**2 + q1 * a, q3 * v**3 + 3.0 * q2 * v * a + q1 * j)


def limit_ratios(run: AxisRun, limits: Limits, state: Floats, right: Floats) -> Floats:
    """(n, 1 + 3 m) value over limit: feed, then velocity, acceleration and jerk of each joint.

    `right` (n,) is 0 where the state belongs to the left side of a break.
    """
    from toolpace.kernels.motion import usage

    s = np.clip(np.where(right > 0.0, state[0], np.nextafter(state[0], -np.inf)), run.s0, run.s1)
    ratio: Floats = usage.ratios(
        run.evaluate(s), state, run.speed_cap(s), limits.velocity, limits.acceleration, limits.jerk
    )
    return ratio
