"""The joints that a follower moves: of a machine, or with limits alone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from toolpace.common.arrays import Bools, Floats, Ints
from toolpace.common.errors import UsageError
from toolpace.kernels.follow.layout import JOINTS
from toolpace.machine.limits import KINDS, Limits
from toolpace.machine.machine import Machine, check_machine


@dataclass(frozen=True, eq=False)
class FollowedJoints:
    """The joints as a law has them: five columns, of which the first `used` are there; the others stand."""

    used: int
    limits: Floats
    """(3, 5) velocity, acceleration and jerk; inf for what is not there."""
    machine: Machine | None
    """None where only limits are known: nothing can be measured of a tool then, nor corrected."""
    frame: Floats
    """(27,) of the kinematic chain; zeros without a machine."""
    group: Ints
    """(3,)"""
    place: Ints
    """(5,)"""

    @property
    def is_rotary(self) -> Bools:
        """(5,)"""
        return self.machine.is_rotary if self.machine is not None else np.zeros(JOINTS, dtype=bool)

    @property
    def travel(self) -> Floats:
        """(5, 2) lowest and highest position [m or rad]."""
        everywhere = np.tile([-np.inf, np.inf], (JOINTS, 1))
        return self.machine.travel if self.machine is not None else everywhere

    def padded(self, values: Floats) -> Floats:
        """Values (n, used) with columns of zeros to (n, 5)."""
        return np.pad(values, ((0, 0), (0, JOINTS - self.used)))


def followed_joints_of(given: Machine | Limits, joints: tuple[str, ...]) -> FollowedJoints:
    """The joints of a machine or of limits that a trajectory of some `joints` is followed with. Raises UsageError."""
    if not isinstance(given, Limits):
        check_machine(given, "follower", "a Machine, or Limits")
    whose = "limits" if isinstance(given, Limits) else f"machine {given.name}"
    of_names = isinstance(given, Limits) and given.joints == tuple(f"q{i + 1}" for i in range(len(given)))
    if given.joints != joints and not (of_names and len(given.joints) == len(joints)):
        cure = "limits of the same joints" if isinstance(given, Limits) else "the machine that it was planned on"
        raise UsageError(
            f"follower: the trajectory moves {', '.join(joints)}, {whose} has {', '.join(given.joints)}; give {cure}"
        )
    if len(joints) > JOINTS:
        raise UsageError(f"follower: the trajectory moves {len(joints)} joints; at most {JOINTS} can be followed")
    limits = given if isinstance(given, Limits) else given.limits
    for kind in KINDS[1:]:
        for joint, limit in zip(joints, getattr(limits, kind)):
            if not np.isfinite(limit):
                raise UsageError(f"follower: {joint} has no limit of {kind}; give {whose} one")
    rows = np.full((3, JOINTS), np.inf)
    rows[:, : len(joints)] = [limits.velocity, limits.acceleration, limits.jerk]
    if isinstance(given, Limits):
        return FollowedJoints(len(joints), rows, None, np.zeros(27), np.zeros(3, dtype=np.int64), np.arange(JOINTS))
    chain = given.geometry
    return FollowedJoints(JOINTS, rows, given, chain.frame.ravel(), chain.group, chain.place)
