"""Joint motion from a path and states (s, ds/dt, ...) on it, and its utilisation of the limits."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from toolpace.common.arrays import Bools, Floats
from toolpace.common.value_objects import ByValue, one_line
from toolpace.machine.limits import KINDS, Limits
from toolpace.motion.laws import TimeLaw
from toolpace.path.axis_run import AxisRun


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
    motion = Motion(*(np.empty(path.shape[1:]) for _ in range(4)))
    put_joint_motion(path, state, motion, slice(None))
    return motion


def put_joint_motion(path: Floats, state: Floats, motion: Motion, rows: slice | Bools) -> None:
    """The same, put into some rows of a motion."""
    q, q1, q2, q3 = path
    v, a, j = (state[i][:, None] for i in (1, 2, 3))
    motion.q[rows] = q
    motion.qd[rows] = q1 * v
    motion.qdd[rows] = q2 * v**2 + q1 * a
    motion.qddd[rows] = q3 * v**3 + 3.0 * q2 * v * a + q1 * j


LEAST_JUMP = 1e-6
"""Jump of an acceleration, as a share of its limit, below which it is rounding."""
CHUNK = 100_000
"""Jumps that are worked out at once, to keep memory low."""


@dataclass(frozen=True, eq=False, repr=False)
class Usage(ByValue):
    """Peak value over limit, over continuous time: of the feed cap, and by joint of each limit.

    The jerk of a joint whose acceleration jumps is infinite.
    """

    feed: float
    velocity: dict[str, float]
    acceleration: dict[str, float]
    jerk: dict[str, float]

    @property
    def worst(self) -> float:
        """The largest of all."""
        return max(self.feed, *self.velocity.values(), *self.acceleration.values(), *self.jerk.values())

    def __repr__(self) -> str:
        peaks = [f"{kind} {max(getattr(self, kind).values(), default=0.0):.6g}" for kind in KINDS]
        return one_line(self, f"of feed {self.feed:.6g}", *peaks)


def limit_ratios(run: AxisRun, limits: Limits, state: Floats, right: Floats) -> Floats:
    """(n, 1 + 3 m) value over limit: feed, then velocity, acceleration and jerk of each joint.

    `right` (n,) is 0 where the state belongs to the left side of a break.
    """
    return ratios_along(run, limits, state, right)[0]


def ratios_along(run: AxisRun, limits: Limits, state: Floats, right: Floats) -> tuple[Floats, Floats]:
    """The same, and the path (4, n, m) there."""
    from toolpace.kernels.motion import usage

    s = np.clip(np.where(right > 0.0, state[0], np.nextafter(state[0], -np.inf)), run.s0, run.s1)
    path, cap = run.with_cap(s)
    path = np.ascontiguousarray(path)
    ratio: Floats = usage.ratios(path, state, cap, limits.velocity, limits.acceleration, limits.jerk)
    return ratio, path


def jerk_jumps(run: AxisRun, limits: Limits, law: TimeLaw) -> npt.NDArray[np.bool_]:
    """(m,) joints with a jerk limit whose acceleration jumps, so that no number bounds their jerk."""
    s, jump = law.jumps
    noise = np.where(np.isfinite(limits.acceleration), LEAST_JUMP * limits.acceleration, 0.0)
    marks = np.zeros(len(limits), dtype=np.bool_)
    for i in range(0, len(s), CHUNK):
        size = np.abs(run.evaluate(s[i : i + CHUNK])[1]) * jump[i : i + CHUNK, None]
        marks |= (size > noise).any(axis=0)
    return marks & np.isfinite(limits.jerk)
