"""Limits of a joint that fall with its speed, in straight pieces, as those of motors do."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from toolpace.common.arrays import Floats, numbers
from toolpace.common.errors import UsageError
from toolpace.common.value_objects import ByValue, one_line
from toolpace.machine.rows import ORDERS, Rows

SIDES = {
    "at any": ("at any",),
    "speeding up": ("speeding_up", "braking"),
    "upwards": ("upwards", "downwards"),
}
"""What curves of a limit are for: one for all motion; one for speeding up and one for braking; one for acceleration in
the joint's positive direction, which carries a weight up, and one for acceleration in the other."""
CURVE = "curve "
"""What stands before the joint in the name of such a limit."""
ALIKE = 1e-12
"""Share of a limit up to which two lines meet at a corner."""
MOST_CORNERS = 64


@dataclass(frozen=True, eq=False, repr=False)
class LimitCurve(ByValue):
    """A limit over the speed of a joint: straight between its corners, the last value beyond them.

    Raises UsageError where the speeds do not begin at zero and ascend, and where the limit is not positive or rises.
    """

    speed: Floats
    """(k,) of the joint, from 0 [m/s or rad/s]."""
    limit: Floats
    """(k,) at these speeds [m/s^2 or m/s^3, or rad]."""

    def __init__(self, corners: npt.ArrayLike, name: str = "limit over speed") -> None:
        """Take the corners (k, 2), [speed, limit] each; `name` begins a message."""
        table = numbers(corners, name, ("k", 2), cure="give corners like [[0, 5], [0.3, 5], [0.5, 2]]")
        if not 1 <= len(table) <= MOST_CORNERS:
            raise UsageError(f"{name} has {len(table)} corners; give 1 to {MOST_CORNERS} of [speed, limit]")
        speed, limit = np.ascontiguousarray(table.T)
        if speed[0] != 0.0:
            raise UsageError(f"{name} begins at speed {speed[0]:g}; give the limit at speed 0 first")
        for (v0, a0), (v1, a1) in pairwise(table.tolist()):
            if not v1 > v0:
                raise UsageError(f"{name}: speed {v1:g} comes after {v0:g}; give speeds that ascend")
            if a1 > a0:
                raise UsageError(f"{name} rises from {a0:g} to {a1:g} at speed {v1:g}; give one that falls, or stays")
        if not limit[-1] > 0.0:
            raise UsageError(f"{name} is {limit[-1]:g} at speed {speed[-1]:g}; give limits above zero")
        for key, value in (("speed", speed), ("limit", limit)):
            value.flags.writeable = False
            object.__setattr__(self, key, value)

    def __repr__(self) -> str:
        return one_line(self, f"{len(self.speed)} corners", f"{self.largest:g} to {self.least:g}")

    @property
    def least(self) -> float:
        """At high speed: what any speed leaves."""
        return float(self.limit[-1])

    @property
    def largest(self) -> float:
        """At rest."""
        return float(self.limit[0])

    def at(self, speed: Floats) -> Floats:
        """The limit at speeds (n,), of either sign."""
        limit: Floats = np.interp(np.abs(speed), self.speed, self.limit)
        return limit

    def scaled(self, speed: float, limit: float) -> LimitCurve:
        """With speeds and limits times a factor."""
        return LimitCurve(np.stack([self.speed * speed, self.limit * limit], axis=1))

    def lines(self, most: float, top: float) -> Floats:
        """(pieces, choices, 2) height at rest and fall with speed of lines: of the largest of each piece's choices the
        least is the curve, at speeds up to `most`, as far as it lies below `top`.

        The choices of a piece are the lines that lie nowhere above the curve over that piece (Ovchinnikov 2002): it
        alone, where the curve is concave. All pieces of a part that is convex have the same, and are one.
        """
        v, a = self.speed, self.limit
        fall = np.append((a[:-1] - a[1:]) / np.diff(v), 0.0)
        height = a + fall * v
        ends = np.append(v[1:], np.inf)
        used = np.flatnonzero((v < most) & ~((fall == 0.0) & (height >= top)))
        if not len(used):
            used = np.array([0])
        pieces: list[frozenset[int]] = []
        for j in used.tolist():
            at = np.array([v[j], ends[j] if np.isfinite(ends[j]) else v[j]])
            own = (height[j] - fall[j] * at) * (1.0 + ALIKE)
            pieces.append(frozenset(i for i in used.tolist() if i == j or (height[i] - fall[i] * at <= own).all()))
        # one that has all choices of another lies nowhere below it
        fewest = [one for one in dict.fromkeys(pieces) if not any(other < one for other in pieces)]
        choices = [sorted(one) for one in fewest]
        width = max(map(len, choices))
        which = np.array([row + row[:1] * (width - len(row)) for row in choices])
        return np.stack([height[which], fall[which]], axis=2)


@dataclass(frozen=True, eq=False, repr=False)
class CurvedLimit(ByValue):
    """The acceleration or jerk limit of one joint as one curve over its speed, or two."""

    joint: str
    kind: str
    """"acceleration" or "jerk"."""
    curves: tuple[LimitCurve, ...]
    """One, or two for what `sides` says."""
    sides: str = "at any"
    """"at any", "speeding up" (and braking), or "upwards" (and downwards): see SIDES."""

    def __post_init__(self) -> None:
        if self.kind not in ORDERS:
            raise UsageError(f"limit of {self.joint} over speed: kind is {self.kind!r}; give 'acceleration' or 'jerk'")
        if self.sides not in SIDES or len(self.curves) != len(SIDES.get(self.sides, ())):
            raise UsageError(
                f"{self.kind} of {self.joint} over speed: {len(self.curves)} curves for {self.sides!r}; give one "
                "'at any' speed, or two of 'speeding up' and braking, or of 'upwards' and downwards"
            )
        if self.kind == "jerk" and self.sides != "at any":
            raise UsageError(f"jerk of {self.joint} over speed: give one curve for all motion")

    def __repr__(self) -> str:
        return one_line(self, f"{self.kind} of {self.joint}", *map(repr, self.curves))

    @property
    def name(self) -> str:
        """As it stands in what limits a motion, beside "acceleration X", its largest value."""
        return f"{self.kind} {CURVE}{self.joint}"

    @property
    def least(self) -> float:
        """What any speed leaves on either side."""
        return min(curve.least for curve in self.curves)

    @property
    def largest(self) -> float:
        """The most that there is at any speed on either side."""
        return max(curve.largest for curve in self.curves)

    def scaled(self, speed: float, limit: float) -> CurvedLimit:
        """With speeds and limits times a factor."""
        curves = tuple(curve.scaled(speed, limit) for curve in self.curves)
        return CurvedLimit(self.joint, self.kind, curves, self.sides)

    def at(self, speed: Floats, pushed: Floats) -> Floats:
        """The limit at speeds (n,) of the joint for an acceleration or jerk with the signs of `pushed` (n,)."""
        first, last = self.curves[0].at(speed), self.curves[-1].at(speed)
        side = pushed * speed if self.sides == "speeding up" else pushed
        limit: Floats = np.where(side >= 0.0, first, last)
        return limit

    def rows(self, number: int, velocity: float) -> Rows:
        """The limit as rows of the joint `number`: what lies below its largest value, which limits it at any speed."""
        lines = [curve.lines(velocity, self.largest) for curve in self.curves]
        pieces, choices = (max(each.shape[axis] for each in lines) for axis in (0, 1))
        # what has fewer repeats its last piece, and the first choice of each
        filled = []
        for each in lines:
            wide = np.concatenate([each, np.repeat(each[:, :1], choices - each.shape[1], axis=1)], axis=1)
            filled.append(np.concatenate([wide, np.repeat(wide[-1:], pieces - len(wide), axis=0)]))
        return Rows(
            self.name, "", self.largest, JointDerivatives(number, ORDERS[self.kind]), self.kind,
            lines=JointLines(number, np.stack([filled[0], filled[-1]]), self.sides == "speeding up"), pieces=pieces,
        )  # fmt: skip


@dataclass(frozen=True)
class JointDerivatives:
    """Coefficients of the acceleration or jerk of a joint along a path, as `Rows` asks for them."""

    joint: int
    order: int

    def __call__(self, q: Floats) -> Floats:
        """(n, 2) or (n, 3) from the joints q (4, n, joints)."""
        first, second, third = q[1:, :, self.joint]
        if self.order == ORDERS["acceleration"]:
            return np.stack([first / 2.0, second], axis=1)
        return np.stack([first / 2.0, 1.5 * second, third], axis=1)


@dataclass(frozen=True)
class JointLines:
    """Lines of a joint's limit over ds/dt, as `Rows` asks for them."""

    joint: int
    lines: Floats
    """(2, pieces, choices, 2) of both curves: height at rest, and fall with the speed of the joint."""
    by_direction: bool
    """Whether the first curve is for acceleration along the joint's motion; else for positive acceleration."""

    def __call__(self, q: Floats) -> tuple[Floats, Floats]:
        """(n, 1, pieces, choices, 2) above and below zero, from the joints q (4, n, joints)."""
        slope = q[1, :, self.joint]
        scale = np.stack([np.ones_like(slope), np.abs(slope)], axis=1)
        first, last = (side * scale[:, None, None, None, :] for side in self.lines)
        if not self.by_direction:
            return first, last
        forth = (slope >= 0.0)[:, None, None, None, None]
        return np.where(forth, first, last), np.where(forth, last, first)


def check_curves(curves: Sequence[CurvedLimit], joints: Sequence[str]) -> None:
    """Raise UsageError for what is no curve of these joints, or the second of a kind."""
    seen = set()
    for each in curves:
        if not isinstance(each, CurvedLimit):
            raise UsageError(f"limits: {type(each).__name__} in place of a curve; give tp.CurvedLimit(...)")
        if each.joint not in joints:
            raise UsageError(f"limits: curve of joint {each.joint}; the joints are {', '.join(joints)}")
        if (each.joint, each.kind) in seen:
            raise UsageError(f"limits: two curves of the {each.kind} of {each.joint}; give one")
        seen.add((each.joint, each.kind))
