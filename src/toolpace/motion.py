"""The motion of the joints from a path and a state on it, and how it stands to the limits."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from toolpace.arrays import Floats
from toolpace.axispath.run import AxisRun
from toolpace.description import one_line
from toolpace.equality import ByValue
from toolpace.machine.limits import Limits


@dataclass(frozen=True, eq=False, repr=False)
class Motion(ByValue):
    """Joint positions and three time derivatives [m or rad, s]: (joints,) at one time, (n, joints) at n times."""

    q: Floats
    """Positions."""
    qd: Floats
    """Velocities."""
    qdd: Floats
    """Accelerations."""
    qddd: Floats
    """Jerks."""

    def __repr__(self) -> str:
        times = "one time" if self.q.ndim == 1 else f"{len(self.q)} times"
        return one_line(self, f"of {self.q.shape[-1]} joints at {times}")


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
