"""Corners between straight moves: rounded by a tangent arc, or chamfered."""

from __future__ import annotations

import math
from contextlib import nullcontext
from typing import NamedTuple

from toolpace.programs.reading.arcs import PLANE_AXES, ROUNDING, plane_arc
from toolpace.programs.reading.control.control import Control

ROUND, SIDES, EDGE = "round", "sides", "edge"
"""What the size of a corner is: the radius, how much of both lines is cut away, or the length of the new edge."""


class CornerError(ValueError):
    """A corner that cannot be; the message says why and what to write."""


class Corner(NamedTuple):
    """A corner at the end of the last motion, which waits for the straight way behind it."""

    name: str
    """As it is written."""
    kind: str
    size: float
    """[m]"""
    came_from: list[float]
    """Words (3 + rotary) where the last motion began; empty where it was not straight."""
    moves: int
    """How many motions there were before it."""
    line: int
    feed: tuple[float, float] | None = None
    """Its own speed [m/s] and rotation [rad/s]."""


def lay(control: Control, corner: Corner, target: list[float], plane: int) -> bool:
    """Lay a corner before the straight way to the target (3 + rotary) begins; False where it is none of the plane.

    Raises CornerError.
    """
    before, at = corner.came_from, control.words
    if corner.moves != len(control.moves) or not before or len(control.moves) < 2:
        return False  # something else has moved in between
    if control.moved_in != control.placement:
        return False  # where the last motion began is told in other coordinates
    first, second = PLANE_AXES[plane]
    others = [k for k in range(len(at)) if k not in (first, second)]
    if any(abs(at[k] - before[k]) > ROUNDING or abs(at[k] - target[k]) > ROUNDING for k in others):
        return False
    along, ahead = ((b[first] - a[first], b[second] - a[second]) for a, b in ((before, at), (at, target)))
    lengths = math.hypot(*along), math.hypot(*ahead)
    turn = math.atan2(along[0] * ahead[1] - along[1] * ahead[0], along[0] * ahead[0] + along[1] * ahead[1])
    if min(lengths) < ROUNDING or abs(turn) < ROUNDING or not corner.size:
        return True
    cut = _cut(corner, abs(turn) / 2.0)
    if cut > min(lengths) + ROUNDING:
        raise CornerError(
            f"the {corner.name} before this block takes {cut * 1e3:.6g} mm of both lines, and the shorter one has "
            f"{min(lengths) * 1e3:.6g} mm: make it smaller"
        )
    start, end = list(at), list(at)
    for k, axis in enumerate((first, second)):
        start[axis] -= along[k] * cut / lengths[0]
        end[axis] += ahead[k] * cut / lengths[1]
    control.redirect([start])
    with control.feed.held(*corner.feed) if corner.feed else nullcontext():
        if corner.kind != ROUND:
            control.straight(end, 0, rapid=False)
        else:
            side = math.copysign(corner.size, turn)
            centre = list(start[:3])
            centre[first] -= along[1] * side / lengths[0]
            centre[second] += along[0] * side / lengths[0]
            control.arc(end, 0, plane_arc(start, end, centre, plane, turn < 0.0))
    return True


def _cut(corner: Corner, half: float) -> float:
    """How much of both lines a corner takes [m], by half the turn between them [rad]."""
    if corner.kind == ROUND:
        return corner.size * math.tan(half)
    return corner.size if corner.kind == SIDES else corner.size / (2.0 * math.cos(half))


class Corners:
    """The corner that waits for the way behind it, where the block that ends at it names it."""

    def __init__(self, control: Control, cure: str, *, refuses_empty: bool = False) -> None:
        """cure: what to write where a corner does not stand between two straight ways. refuses_empty: whether that is
        refused of one without a size, too."""
        self.control, self.cure, self.refuses_empty = control, cure, refuses_empty
        self.waiting: Corner | None = None

    def put(
        self, name: str, kind: str, size: float, came_from: list[float], feed: tuple[float, float] | None = None
    ) -> None:
        """A corner at the end of the last motion, perhaps with a feed of its own. Raises CornerError."""
        if not 0.0 <= size <= 100.0:
            raise CornerError(f"the size of {name} must be a length from 0 on: correct it")
        control = self.control
        self.waiting = Corner(name, kind, size, came_from, len(control.moves), control.line, feed)

    def before(self, target: list[float], plane: int) -> None:
        """A straight way to the target (3 + rotary) comes next. Raises CornerError."""
        if self.waiting is not None and lay(self.control, self.waiting, target, plane):
            self.waiting = None
        self.refuse()

    def refuse(self) -> None:
        """Another motion comes next, or none: the corner that waits is not read."""
        corner, self.waiting = self.waiting, None
        if corner is not None and (corner.size or self.refuses_empty):
            self.control.findings.refused(corner.name, corner.line, self.cure)
