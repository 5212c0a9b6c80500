"""Drilling cycles of MillPlus: G81 to G86, called by G79.

After the post-processors for MillPlus (Autodesk's, and what NX writes): no manual of it is public.
"""

from __future__ import annotations

from contextlib import nullcontext

from toolpace.common.units import MINUTE
from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.control.cycles import FEED_OUT, RAPID_OUT, Drilling, drill
from toolpace.programs.reading.gcode.modal import Modal
from toolpace.programs.reading.gcode.motion import MotionReader
from toolpace.programs.reading.gcode.program.words import Handler, Numbers, WordError


class SurfaceHoles:
    """The cycle that is defined, and the surface."""

    def __init__(self, control: Control, state: Modal, motion: MotionReader) -> None:
        self.control, self.state, self.motion = control, state, motion
        self.words: Numbers = {}
        self.stops, self.out = False, RAPID_OUT
        self.surface: float | None = None

    def handlers(self) -> dict[str, Handler]:
        """What carries out each meaning."""
        return {
            "define drill": self.drill,
            "define peck": self.peck,
            "define tap": self.tap,
            "define bore": self.bore,
            "define bore and stop": self.bore_and_stop,
            "run cycle": self.run,
        }

    def _define(self, numbers: Numbers, *, stops: bool = False, out: str = RAPID_OUT) -> None:
        letters = [letter for letter in ("X", "Y", "Z", "B", "I", "J", "K", "K1", "I1", "F2") if letter in numbers]
        self.words = {letter: numbers.pop(letter) for letter in letters}
        self.stops, self.out = stops, out

    def drill(self, numbers: Numbers, word: str) -> None:
        """G81: in at feed, out at rapid."""
        self._define(numbers)

    def peck(self, numbers: Numbers, word: str) -> None:
        """G83: I first peck (K on older ones), J less each time, back to the clearance after each."""
        self._define(numbers)
        self.words["peck"] = self.words.pop("K", 0.0)
        self.words["less"] = self.words.pop("I", 0.0)
        self.words["break"] = self.words.pop("J", 0.0)

    def tap(self, numbers: Numbers, word: str) -> None:
        """G84: in, reverse, out; J is the pitch, by which the feed follows the spindle."""
        self._define(numbers, stops=True, out=FEED_OUT)

    def bore(self, numbers: Numbers, word: str) -> None:
        """G85: in and out at feed; F2= is that of the way out."""
        self._define(numbers, out=FEED_OUT)

    def bore_and_stop(self, numbers: Numbers, word: str) -> None:
        """G86: in at feed, the spindle stops, out at rapid."""
        self._define(numbers, stops=True)

    def run(self, numbers: Numbers, word: str) -> None:
        """G79: the cycle at X, Y; Z is the surface, and stays."""
        control, unit, words = self.control, self.state.unit, self.words
        if "Z" not in words or "Y" not in words:
            raise WordError(f"{word} runs a cycle, and none is defined: write G81 Y.. Z.. before it")
        target, _ = self.motion.target(numbers)
        numbers_have_surface = "Z" in numbers
        if numbers_have_surface or self.surface is None:
            self.surface = target[2]
        for letter in list(numbers):
            numbers.pop(letter)
        top = self.surface + words["Y"] * unit
        cycle = Drilling(
            top=top,
            bottom=self.surface + words["Z"] * unit,
            back=top + max(words.get("B", 0.0) * unit, 0.0),
            peck=words.get("peck", 0.0) * unit,
            peck_less=words.get("less", 0.0) * unit,
            chip_break=words.get("break", 0.0) * unit,
            dwell=words.get("X", 0.0),
            out=self.out,
            out_speed=words.get("F2", 0.0) * unit / MINUTE,
            stops=self.stops,
        )
        control.findings.assumed(f"B of a cycle is how far the tool goes back above the clearance Y ({word})")
        taps = self.stops and self.out == FEED_OUT
        thread = words.get("J", 0.0) * unit * control.feed.spindle if taps else 0.0
        with control.feed.held(thread) if thread > 0.0 else nullcontext():
            drill(control, cycle, target)
