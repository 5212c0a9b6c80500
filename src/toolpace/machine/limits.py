"""Velocity, acceleration and jerk limits of joints."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from toolpace.common.arrays import Floats, Ints, numbers
from toolpace.common.errors import UsageError
from toolpace.common.units import ask_about_unit
from toolpace.common.value_objects import ByValue, named, one_line
from toolpace.machine.limit_curves import CurvedLimit, check_curves
from toolpace.machine.rows import Rows

KINDS = ("velocity", "acceleration", "jerk")
MOTORS = ("force", "torque")
"""What limits of motors are named, of linear and of rotary joints: "force X", "torque A"."""
CONTINUOUS = "continuous "
"""What stands before that where a motor's continuous rating is meant."""

MOST_SCALED = 20.0
"""Factor of limits that is not asked about: percents are more."""


@dataclass(frozen=True, eq=False, repr=False)
class Limits(ByValue):
    """Symmetric limits of m joints, each positive; inf where nothing limits.

    A number stands for all joints. Without names the joints are called q1, q2, ... Where a limit of a joint is a curve
    over its speed, the least value of the curve stands in the array: who knows constants only is on the safe side.
    """

    velocity: Floats
    """(m,) most |q'| [m/s or rad/s]."""
    acceleration: Floats
    """(m,) most |q''| [m/s^2 or rad/s^2]."""
    jerk: Floats
    """(m,) most |q'''| [m/s^3 or rad/s^3]."""
    joints: tuple[str, ...] = ()
    """Names of the joints."""
    rows: tuple[Rows, ...] = ()
    """Limits of one's own, beside those of the joints."""
    curves: tuple[CurvedLimit, ...] = ()
    """Limits of acceleration and jerk that fall with the speed of their joint."""
    origin: Limits | None = None
    """Of limits that are `over_speed`: those that they were made of."""

    def __init__(
        self,
        velocity: npt.ArrayLike,
        acceleration: npt.ArrayLike,
        jerk: npt.ArrayLike,
        joints: Sequence[str] | None = None,
        rows: Sequence[Rows] = (),
        curves: Sequence[CurvedLimit] = (),
        origin: Limits | None = None,
    ) -> None:
        values = [
            np.atleast_1d(numbers(value, f"limits: {kind}", ("m",), (), finite=False)).copy()
            for kind, value in zip(KINDS, (velocity, acceleration, jerk))
        ]
        count = len(joints) if joints else max(len(value) for value in values)
        names = tuple(joints) if joints else tuple(f"q{i + 1}" for i in range(count))
        check_curves(curves, names)
        for kind, value in zip(KINDS, values):
            if value.ndim != 1 or len(value) not in (1, count):
                raise UsageError(f"limits: {kind} has shape {value.shape} for {count} joints ({', '.join(names)})")
            limit = np.ascontiguousarray(np.broadcast_to(value, count)).copy()
            for curve in curves:
                if curve.kind == kind:
                    limit[names.index(curve.joint)] = curve.least
            for name, figure in zip(names, limit):
                if not figure > 0.0:
                    raise UsageError(f"limits: {kind} of joint {name} is {figure:g}; give a positive number (or inf)")
            limit.flags.writeable = False
            object.__setattr__(self, kind, limit)
        object.__setattr__(self, "joints", names)
        object.__setattr__(self, "rows", tuple(rows))
        object.__setattr__(self, "curves", tuple(curves))
        object.__setattr__(self, "origin", origin)
        self._check_rows()

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
        if self.origin is not None:
            return self.origin.scaled(velocity, acceleration, jerk).over_speed()
        factors = {"velocity": velocity, "acceleration": acceleration, "jerk": jerk}
        each = {kind: np.broadcast_to(factor, len(self)) for kind, factor in factors.items()}
        curves = []
        for curve in self.curves:
            j = self.joints.index(curve.joint)
            curves.append(curve.scaled(float(each["velocity"][j]), float(each[curve.kind][j])))
        return Limits(
            self.velocity * velocity, self.acceleration * acceleration, self.jerk * jerk, self.joints, self.rows, curves
        )

    @property
    def constants(self) -> Limits:
        """The limits for who knows constants only: with the least value of each curve."""
        return self.origin or self

    @property
    def largest(self) -> Limits:
        """The limits with the largest value of each curve, which none may exceed at any speed; no rows."""
        top = self.over_speed()
        return Limits(top.velocity, top.acceleration, top.jerk, self.joints)

    def over_speed(self) -> Limits:
        """The limits with the largest value of each curve, and the rest of it as rows; themselves without curves."""
        if not self.curves:
            return self
        largest, rows = {kind: getattr(self, kind).copy() for kind in KINDS}, list(self.rows)
        for curve in self.curves:
            j = self.joints.index(curve.joint)
            largest[curve.kind][j] = curve.largest
            if curve.largest > curve.least:
                rows.append(curve.rows(j, float(self.velocity[j])))
        velocity, acceleration, jerk = largest.values()
        return Limits(velocity, acceleration, jerk, self.joints, rows, origin=self)

    def _check_rows(self) -> None:
        for each in self.rows:
            if not isinstance(each, Rows):
                raise UsageError(f"limits: {type(each).__name__} in place of rows; give tp.Rows(...)")
            if [*self.names, "nothing", "dwell"].count(each.name) > 1:
                raise UsageError(f"limits: rows named '{each.name}', as another limit is; give another name")

    @property
    def names(self) -> list[str]:
        """ "feed", "velocity X", ..., then the rows of one's own: every limit, as it is named where it binds."""
        of_joints = [f"{kind} {joint}" for kind in KINDS for joint in self.joints]
        return ["feed", *of_joints, *(rows.name for rows in self.rows)]

    @property
    def orders(self) -> Ints:
        """(k,) of each of the names: 0 of speed, 1 of acceleration, 2 of jerk."""
        m = len(self)
        return np.array([0] * (1 + m) + [1] * m + [2] * m + [rows.order for rows in self.rows])

    @property
    def depend_on_speed(self) -> bool:
        """Whether some row's limits depend on the speed."""
        return any(rows.lines is not None for rows in self.rows)

    @property
    def half(self) -> int:
        """How many rows of acceleration a place has in an optimisation problem, and as many of jerk."""
        return len(self) + max(sum(rows.width for rows in self.rows if rows.order == order) for order in (1, 2))
