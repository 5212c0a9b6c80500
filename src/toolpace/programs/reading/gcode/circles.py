"""Arcs of word-address blocks."""

from __future__ import annotations

import math

from toolpace.common.units import INCH, MILLIMETRE
from toolpace.programs.reading.arcs import MOST_TURNS, PLANE_AXES, Arc, ArcError, Tolerance, centre_of_radius, plane_arc
from toolpace.programs.reading.control.control import FARTHEST, Control
from toolpace.programs.reading.controllers.controller import Controller
from toolpace.programs.reading.expressions import BlockError
from toolpace.programs.reading.gcode.modal import Modal
from toolpace.programs.reading.gcode.program.words import RefusedError, near_whole

FULL = 360.0
"""A turn [deg]."""
THREE_DECIMALS = 2e-6
"""Of a radius or a coordinate that is written with three decimals [m]."""
FITTING = 1e-4
"""Most difference of radii [m] at which a centre is one."""
Sense = tuple[bool, float]
"""What I, J, K are: whether a position, and the sign of a distance."""
POSITION: Sense = (True, 1.0)
SENSES: tuple[Sense, ...] = (POSITION, (False, 1.0), (False, -1.0))
_CENTRES = ((("I", 0), ("J", 1)), (("K", 2), ("I", 0)), (("J", 1), ("K", 2)))


class ArcReader:
    """Reads I, J, K, R and P in the plane in force."""

    def __init__(self, control: Control, state: Modal, by: Controller) -> None:
        self.control, self.state = control, state
        self.centres = by.option("arc_centre", "by mode")
        """By mode (distances from the start, or positions), or "fitting": what makes both radii equal."""
        self.sense: Sense | None = None
        """What I, J, K are in an arc that they fit in one way only."""
        self.full = by.option("rs274_checks", False)
        """Whether ends on one ray from the centre make a full circle."""
        self.counts_turns = by.option("arc_turns", False)
        """Whether P of an arc counts its turns."""
        self.radii = {unit: _radii(by, unit) for unit in (MILLIMETRE, INCH)}
        reach = by.option("arc_reach_mm", 0.0) * MILLIMETRE
        self.reach = Tolerance(reach, 0.0) if reach else Tolerance()

    def arc(self, arc_words: dict[str, float], start: list[float], target: list[float]) -> Arc:
        """The arc from `start` to `target` (3,), in the program's coordinates."""
        state = self.state
        plane = self._plane(arc_words)
        clockwise = state.motion == "arc clockwise"
        tolerance = self.radii[state.unit]
        if arc_words.get("P", 1.0) != 1.0 and not self.counts_turns:
            raise RefusedError(f"P{arc_words.pop('P'):g} of an arc", "write each turn as an arc of its own")
        self._full_turn(arc_words, start, target)
        turns = near_whole(arc_words.pop("P", 1.0), 1e-3)
        if turns != int(turns) or not 1 <= turns <= MOST_TURNS:
            raise BlockError(f"P{turns:g} of an arc counts its turns: write a whole number from 1 to {MOST_TURNS}")
        if "R" in arc_words:
            radius = arc_words.pop("R") * state.unit
            if any(arc_words.values()) or (self.full and arc_words):
                raise BlockError("an arc has R, or I, J, K, not both: remove one")
            self._refuse_far(radius, "R")
            centre = centre_of_radius(start, target, radius, plane, clockwise, self.reach)
            tolerance = Tolerance()
        elif self.centres == "fitting":
            centre = self._fitting_centre(arc_words, start, target, plane)
        else:
            centre = self._centre(arc_words, start, plane, state.arc_absolute, 1.0)
        return plane_arc(start, target, centre, plane, clockwise, int(turns), full=self.full, tolerance=tolerance)

    def _full_turn(self, arc_words: dict[str, float], start: list[float], target: list[float]) -> None:
        """Take B5= of MillPlus, the angle of the arc: a full circle, which posts write with it."""
        turned = arc_words.pop("B5", None)
        if turned is not None and (abs(turned) != FULL or math.dist(start, target) > 0.0):
            raise BlockError("B5= of an arc is read as B5=360 without X, Y, Z: write the end of the arc")

    def _plane(self, arc_words: dict[str, float]) -> int:
        """The plane in force; where centres are fitted, that of the two letters that are given."""
        letters = tuple(letter for letter in "IJK" if letter in arc_words)
        if self.centres == "fitting" and len(letters) == 2:
            return (("I", "J"), ("I", "K"), ("J", "K")).index((letters[0], letters[1]))
        return self.state.plane

    def _centre(
        self, arc_words: dict[str, float], start: list[float], plane: int, absolute: bool, sign: float
    ) -> list[float]:
        """Centre from I, J, K; a word that is not there is zero as a distance, but missing as a position."""
        state = self.state
        centre = list(start[:3])
        wanted = _CENTRES[plane]
        letters = [letter for letter, _ in wanted]
        if not any(letter in arc_words for letter in letters):
            cure = f"write {letters[0]} and {letters[1]}, or R; for a straight way G0 or G1, since G2 stays in force"
            raise BlockError(f"the arc lacks its centre: {cure}")
        for letter, slot in wanted:
            value = arc_words.get(letter)
            if value is None:
                if absolute:
                    raise BlockError(f"the arc lacks {letter}: under G90.1 both centre coordinates are needed")
                continue
            self._refuse_far(value * state.unit, letter)
            centre[slot] = sign * value * state.unit + (0.0 if absolute else centre[slot])
        extra = next((letter for letter, value in arc_words.items() if letter not in letters and value), None)
        if extra is not None:
            name = ("G17", "G18", "G19")[plane]
            raise BlockError(f"{extra} has no meaning for an arc in the plane of {name}: check the plane")
        return centre

    def _fitting_centre(
        self, arc_words: dict[str, float], start: list[float], target: list[float], plane: int
    ) -> list[float]:
        """The centre that lies equally far from both ends, of those that the words may mean."""
        first, second = PLANE_AXES[plane]
        complete = all(letter in arc_words for letter, _ in _CENTRES[plane])
        found: dict[Sense, tuple[float, list[float]]] = {}
        for sense in SENSES:
            absolute, sign = sense
            if absolute and not complete:
                continue
            centre = self._centre(arc_words, start, plane, absolute, sign)
            radii = [math.hypot(end[first] - centre[first], end[second] - centre[second]) for end in (start, target)]
            found[sense] = abs(radii[1] - radii[0]), centre
        best = min(off for off, _ in found.values())
        if best > FITTING:
            raise ArcError(
                "the arc's centre is equally far from both ends neither as a position nor as a distance from the "
                "start: correct I, J, K"
            )
        self.control.findings.assumed("I, J, K of arcs mean what makes both radii equal: a position, or a distance")
        fits = {sense: centre for sense, (off, centre) in found.items() if off <= best + THREE_DECIMALS}
        return self._fit(fits, math.dist(start, target) < THREE_DECIMALS)

    def _fit(self, fits: dict[Sense, list[float]], full: bool) -> list[float]:
        """The centre (3,) that is meant, of those that fit by what I, J, K may be: as in the arcs before."""
        if len(fits) == 1:
            self.sense = next(iter(fits))
        centres = list(fits.values())
        if max(math.dist(centre, centres[0]) for centre in centres) < THREE_DECIMALS:
            return centres[0]
        if self.sense in fits:
            return fits[self.sense]
        if full and POSITION in fits:
            self.control.findings.assumed("I, J, K of a full circle are a position, where no other arc tells")
            return fits[POSITION]
        raise ArcError(
            "I, J, K of the arc fit as a position and as a distance from the start, and no arc before tells which is "
            "meant: write R"
        )

    def _refuse_far(self, value: float, letter: str) -> None:
        if not abs(value) <= FARTHEST * self.state.unit:
            raise BlockError(f"{letter} is beyond {FARTHEST:g}: correct the number")


def _radii(by: Controller, unit: float) -> Tolerance:
    """How far radii may differ in a program of this unit [m]."""
    least = by.option("arc_radii_inch", 0.0) * INCH if unit == INCH else 0.0
    least = least or by.option("arc_radii_mm", 0.01) * MILLIMETRE
    times = by.option("arc_radii_times", 0.0)
    smallest = by.option("arc_radius_least_mm", 1e-6) * MILLIMETRE
    return Tolerance(least, by.option("arc_radii_percent", 0.1) / 100, times * least if times else math.inf, smallest)
