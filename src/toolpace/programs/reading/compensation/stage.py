"""The stage at which motions wait for their compensation, and the rules by which controls differ in it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NoReturn

from toolpace.programs.reading.arcs import PLANE_AXES, Arc
from toolpace.programs.reading.compensation.elements import Element, Line, Turn, arc_of, element_of
from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.control.moves import Rate

ARC, MEETING, LINES = "arc", "meeting", "lines"
"""Outside corners: an arc about the corner; the point where the offset ways meet; that point, or two points at the
tool's radius beyond the ends of both ways where it would lie farther."""
ACROSS, AROUND, TOUCHING = "across", "around", "touching"
"""The first and the last point: across the contour's end; as at any other corner, where that is an outside one; or,
where the way comes from behind the contour, along a line that touches the circle of the tool's radius about its end,
and round that as round a corner."""
CENTRE, CONTOUR, INSIDE = "centre", "contour", "inside"
"""What F is the speed of on arcs: the tool's centre; the point that cuts; that on arcs that the tool goes inside of."""


@dataclass
class Laid:
    """A motion of the centre whose end waits for the next element."""

    row: int
    start: list[float]
    words: list[float]
    """At its start and its end (3 + rotary); of the start the coordinate across the plane counts."""
    path: Element | None
    """Of the centre; None where nothing moves in the plane."""
    along: complex = 0j
    """Direction of the program's element at its end."""
    sweep: float = 0.0
    """Of the program's element, where it is an arc [rad]."""


class OffsetStage:
    """Follows a contour at a side of it, at the distance of a radius."""

    compensates = True
    """Whether the contour is another way than the centre's, or modes of the control forbid what they forbid then."""

    def __init__(self, control: Control, side: int, radius: float, plane: int) -> None:
        """side: 1 left of the contour, -1 right. radius [m]. plane: 0 XY, 1 ZX, 2 YZ."""
        self.control, self.side, self.radius, self.plane = control, side, radius, plane
        self.first, self.second = PLANE_AXES[plane]
        self.at = self.point(control.words)
        """Where the centre is, in the plane."""
        self.begun = self.at
        """Where the first of the motions that wait begins."""
        self.waiting: list[Laid] = []

    @property
    def kept(self) -> list[float]:
        """Words (3 + rotary) of where the machine is: axes that are not named stay."""
        return self.control.reached()

    def point(self, words: list[float]) -> complex:
        """The plane's coordinates of words (3 + rotary)."""
        return complex(words[self.first], words[self.second])

    def fail(self, message: str) -> NoReturn:
        """ProgramError at the block at hand."""
        self.control.source.fail(message, self.control.line)

    def element(self, start: list[float], end: list[float], arc: Arc | None) -> Element | None:
        """What a motion of the program is in the plane; ProgramError where it is an arc in another plane."""
        found = element_of(start, end, arc, self.plane)
        if arc is not None and found is None:
            self.fail("under cutter compensation arcs lie in its plane: write G40 before an arc in another one")
        return found

    # Rows

    def add(
        self, end: complex, start: list[float], words: list[float], path: Element | None, rate: Rate, kind: float
    ) -> Laid:
        """Lay a motion of the centre to a point of the plane; its other coordinates go from those of start to words."""
        control = self.control
        laid = Laid(len(control.moves), start, self._at(words, end), path)
        control.lay(laid.words, rate, kind, self._arc(laid))
        self.at = end
        return laid

    def wait(self, laid: Laid, begun: complex) -> None:
        """Leave the end of a motion open, which begins at a point."""
        self.waiting, self.begun = [laid], begun

    def move_end(self, end: complex) -> None:
        """Move the ends of all motions that wait to a point, and settle them."""
        control = self.control
        for laid in self.waiting:
            laid.words, laid.path = self._at(laid.words, end), self.trimmed(laid, end)
            control.relay(laid.row, laid.words, self._arc(laid))
        self.at = end
        self.waiting = []

    def trimmed(self, laid: Laid, end: complex) -> Element | None:
        """The way of a motion that waits, to another end."""
        if isinstance(laid.path, Turn):
            return laid.path.between(self.begun, end)
        return None if laid.path is None else Line(self.begun, end)

    def _at(self, words: list[float], point: complex) -> list[float]:
        found = list(words)
        found[self.first], found[self.second] = point.real, point.imag
        return found

    def _arc(self, laid: Laid) -> Arc | None:
        if not isinstance(laid.path, Turn):
            return None
        return arc_of(laid.path, laid.start, laid.words, self.plane)


class Leaving:
    """Behind the word that ends a compensation, up to the straight motion that leads back to the program's points."""

    compensates = False
    cure = "an arc cannot lead away from a compensated contour: write a straight motion behind G40"

    def __init__(self, stage: OffsetStage) -> None:
        self.control, self.stage = stage.control, stage

    @property
    def kept(self) -> list[float]:
        """Words (3 + rotary) of where the machine is: axes that are not named stay."""
        return self.control.reached()

    def move(self, start: list[float], end: list[float], arc: Arc | None, rate: Rate, kind: float) -> None:
        """A straight motion in the plane goes to its own end; another one beside it. Raises ProgramError."""
        if arc is not None:
            self.stage.fail(self.cure)
        if self.stage.point(start) == self.stage.point(end):
            self.stage.add(self.stage.point(self.control.reached()), start, end, None, rate, kind)
            return
        self.control.stage = None
        self.control.lay(end, rate, kind)

    def redirect(self, end: list[float]) -> None:
        """Nothing waits for a corner here."""
        self.stage.fail("a corner behind the end of a compensation is not read: write it out")

    def other_motion(self, what: str) -> None:
        """The machine goes on from where it is, and coordinates change about it; holes and splines need their place."""
        if what in ("a cycle of holes", "a spline"):
            self.stage.fail(f"{what} behind the end of a compensation: write a straight motion in the plane before it")


def as_speed(rate: Rate, start: list[float], end: list[float], arc: Arc | None, least: float = 0.0) -> Rate:
    """A rate that is the time of a program's motion as the speed that comes of it along that motion.

    least: speed that is not gone below [m/s].
    """
    if not rate.time:
        return rate
    length = math.dist(start[:3], end[:3]) if arc is None else arc.length()
    turned = math.dist(start[3:], end[3:])
    return Rate(max(length / rate.time, least) or math.inf, turned / rate.time or math.inf)


@dataclass(frozen=True)
class Rules:
    """Of one control, with the words that are in force."""

    outside: str = ARC
    """ARC, MEETING or LINES."""
    ends: str = ACROSS
    """ACROSS, AROUND or TOUCHING."""
    feed: str = CENTRE
    """CENTRE, CONTOUR or INSIDE."""
    most_met: float = math.pi
    """Turn of an outside corner [rad] up to which ways meet; beyond, there is an arc."""
    slight: float = 0.0
    """Turn [rad] up to which an outside corner has no arc: the ways meet."""
    said_of_limits: str = ""
    """What is taken for granted where a corner is read by one of these two."""
    shifts: bool = False
    """Whether a block that begins or ends it without a motion moves the tool across the contour's end."""
    most_idle: int = 1
    """Blocks that move nothing in the plane which may stand between two elements."""
    looks_ahead: int = 0
    """Elements within which the control leaves out what lies between two crossings of the way; 0 where it does not."""
    gouge: str = "the control stops with an alarm"
    """What the control does where the tool does not fit."""
    assumed: str = ""
    """What is taken for granted wherever compensation is read."""

    def share_of_feed(self, path: Element, side: int, radius: float) -> float:
        """Speed of the centre of a tool of a radius [m] at a side of an element (1 left, -1 right), as a share of F."""
        if self.feed == CENTRE or not isinstance(path, Turn):
            return 1.0
        inner = path.holds(side)
        if self.feed == INSIDE and not inner:
            return 1.0
        return 1.0 + (-radius if inner else radius) / path.radius
