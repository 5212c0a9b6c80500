"""Executes the axis words of a G-code block: straight ways, arcs, helices."""

from __future__ import annotations

from typing import NoReturn

from toolpace.reading.arcs import Arc, centre_of_radius, plane_arc
from toolpace.reading.control.control import Control
from toolpace.reading.control.feed import INVERSE
from toolpace.reading.gcode import codes
from toolpace.reading.gcode.modal import Modal
from toolpace.units import DEGREE

FARTHEST = 1e6
"""Most of an axis word [mm, inch or deg]: a kilometre is a slip, and unbounded numbers lose their digits."""
MOST_TURNS = 1000
"""Most whole turns of an arc (P): more is a slip, and would fill memory with points."""
_CENTRES = ((("I", 0), ("J", 1)), (("K", 2), ("I", 0)), (("J", 1), ("K", 2)))


class MotionReader:
    """Turns axis words into moves, from the state the controller is in."""

    def __init__(self, control: Control, state: Modal) -> None:
        self.source, self.control, self.state = control.source, control, state

    def execute(self, numbers: dict[str, float], number: float | None, stop: bool, line: int) -> None:
        """Move to the axis words of a block."""
        state, control = self.state, self.control
        motion, slots = state.motion, control.slots
        arc_words = {}
        if motion == 20 or motion == 30:
            arc_words = {letter: numbers.pop(letter) for letter in "IJKRP" if letter in numbers}
        target = list(control.words)
        named = 0
        for letter, value in numbers.items():
            slot = slots.get(letter)
            if slot is None:
                self._refuse_word(letter, value, line)
            if not -FARTHEST <= value <= FARTHEST:
                self.source.fail(f"{letter}{value:g} is beyond {FARTHEST:g}: correct the number", line)
            scaled = value * (state.unit if slot < 3 else DEGREE)
            target[slot] = scaled if state.absolute else target[slot] + scaled
            if slot < 3:
                named |= 1 << slot
        if motion is None:
            self.source.fail("axis words without a motion: write G0, G1, G2 or G3 before them", line)
        if not len(control.moves) and not state.absolute:
            # Distances start somewhere: at zero, as on a controller that was never told its place.
            control.begin_here()
        if motion >= 20:
            control.arc(target, named, self._arc(arc_words, target, line), number)
        else:
            if motion == 0 and number is not None and control.feed.mode == INVERSE:
                control.findings.ignored("F with G0 under G93")
            control.straight(target, named, rapid=motion == 0, number=number)
        if stop:
            control.stop()

    def _arc(self, arc_words: dict[str, float], target: list[float], line: int) -> Arc:
        """The arc to `target`, in the program's coordinates."""
        state, start = self.state, self.control.words
        clockwise = state.motion == 20
        turns = arc_words.pop("P", 1.0)
        if turns != int(turns) or not 1 <= turns <= MOST_TURNS:
            self.source.fail(
                f"P{turns:g} of an arc counts its turns: write a whole number from 1 to {MOST_TURNS}", line
            )
        if "R" in arc_words:
            radius = arc_words.pop("R") * state.unit
            if arc_words:
                self.source.fail("an arc has R, or I, J, K, not both: remove one", line)
            self._refuse_far(radius, "R", line)
            centre = centre_of_radius(start, target, radius, state.plane, clockwise)
        else:
            centre = self._centre(arc_words, line)
        return plane_arc(start, target, centre, state.plane, clockwise, int(turns))

    def _centre(self, arc_words: dict[str, float], line: int) -> list[float]:
        """Centre from I, J, K; a word that is not there is zero as a distance, but missing as a position."""
        state = self.state
        centre = self.control.words[:3]
        wanted = _CENTRES[state.plane]
        letters = [letter for letter, _ in wanted]
        if not any(letter in arc_words for letter in letters):
            self.source.fail(f"the arc lacks its centre: write {letters[0]} and {letters[1]}, or R", line)
        for letter, slot in wanted:
            value = arc_words.pop(letter, None)
            if value is None:
                if state.arc_absolute:
                    self.source.fail(f"the arc lacks {letter}: under G90.1 both centre coordinates are needed", line)
                continue
            self._refuse_far(value * state.unit, letter, line)
            centre[slot] = value * state.unit + (0.0 if state.arc_absolute else centre[slot])
        if arc_words:
            extra, plane = next(iter(arc_words)), ("G17", "G18", "G19")[state.plane]
            self.source.fail(f"{extra} has no meaning for an arc in the plane of {plane}: check the plane", line)
        return centre

    def _refuse_far(self, value: float, letter: str, line: int) -> None:
        if not abs(value) <= FARTHEST * self.state.unit:
            self.source.fail(f"{letter} is beyond {FARTHEST:g}: correct the number", line)

    def _refuse_word(self, letter: str, value: float, line: int) -> NoReturn:
        fail = self.source.fail
        if letter in codes.WORD_USES:
            fail(
                f"{letter} has no use in this block, it belongs to {codes.WORD_USES[letter]}: remove it",
                line,
            )
        if letter in "ABC" or (letter in "UVW" and self.control.poses.machine is not None):
            self.control.slot(letter)
        if letter == "E":
            fail("E has no meaning here: write numbers without exponent, like 0.00001", line)
        fail(f"word {letter} is not known here and might move something: remove it", line)
