"""Joint positions and time derivatives from a path and states (s, ds/dt, ...) on it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from toolpace.common.arrays import Bools, Floats
from toolpace.common.value_objects import ByValue, one_line


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
