"""Velocity, acceleration and jerk limits of joints."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from toolpace.common.arrays import Floats, numbers
from toolpace.common.errors import UsageError
from toolpace.common.units import ask_about_unit
from toolpace.common.value_objects import ByValue, named, one_line

KINDS = ("velocity", "acceleration", "jerk")


MOST_SCALED = 20.0
"""Factor of limits that is not asked about: percents are more."""


@dataclass(frozen=True, eq=False, repr=False)
class Limits(ByValue):
    """Symmetric limits of m joints, each positive; inf where nothing limits.

    A number stands for all joints. Without names the joints are called q1, q2, ...
    """

    velocity: Floats
    """(m,) most |q'| [m/s or rad/s]."""
    acceleration: Floats
    """(m,) most |q''| [m/s^2 or rad/s^2]."""
    jerk: Floats
    """(m,) most |q'''| [m/s^3 or rad/s^3]."""
    joints: tuple[str, ...] = ()
    """Names of the joints."""

    def __init__(
        self,
        velocity: npt.ArrayLike,
        acceleration: npt.ArrayLike,
        jerk: npt.ArrayLike,
        joints: Sequence[str] | None = None,
    ) -> None:
        values = [
            np.atleast_1d(numbers(value, f"limits: {kind}", ("m",), (), finite=False)).copy()
            for kind, value in zip(KINDS, (velocity, acceleration, jerk))
        ]
        count = len(joints) if joints else max(len(value) for value in values)
        names = tuple(joints) if joints else tuple(f"q{i + 1}" for i in range(count))
        for kind, value in zip(KINDS, values):
            if value.ndim != 1 or len(value) not in (1, count):
                raise UsageError(f"limits: {kind} has shape {value.shape} for {count} joints ({', '.join(names)})")
            limit = np.ascontiguousarray(np.broadcast_to(value, count)).copy()
            for name, figure in zip(names, limit):
                if not figure > 0.0:
                    raise UsageError(f"limits: {kind} of joint {name} is {figure:g}; give a positive number (or inf)")
            limit.flags.writeable = False
            object.__setattr__(self, kind, limit)
        object.__setattr__(self, "joints", names)

    def __len__(self) -> int:
        return len(self.joints)

    def __repr__(self) -> str:
        return one_line(self, f"of {named(self.joints)}")

    def scaled(self, velocity: float = 1.0, acceleration: float = 1.0, jerk: float = 1.0) -> Limits:
        """The same limits times a factor of each kind."""
        for name, factor in (("velocity", velocity), ("acceleration", acceleration), ("jerk", jerk)):
            cure = "give a factor: 120 percent is 1.2"
            # factors of each joint are no percents
            if np.ndim(factor) == 0:
                ask_about_unit(factor, MOST_SCALED, f"limits: factor of {name}", cure)
        return Limits(self.velocity * velocity, self.acceleration * acceleration, self.jerk * jerk, self.joints)
