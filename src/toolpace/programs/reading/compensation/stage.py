"""The stage between contour and moves, which delays each move until the next element is known."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NoReturn

from toolpace.programs.reading.compensation.elements import AXES, Element, Line, Turn, arc_of, element_of
from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.control.moves import Rate
from toolpace.programs.reading.curves.arcs import Arc


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
        self.first, self.second = AXES[plane]
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
