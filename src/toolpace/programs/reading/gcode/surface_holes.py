"""Drilling cycles of MillPlus: G81 to G86, called by G79.

After the post-processors for MillPlus (Autodesk's, and what NX writes): no manual of it is public.
"""

from __future__ import annotations

from contextlib import nullcontext

from toolpace.common.units import MINUTE
from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.control.cycles import FEED_OUT, RAPID_OUT, Drilling, drill
from toolpace.programs.reading.expressions import BlockError
from toolpace.programs.reading.gcode.modal import Modal
from toolpace.programs.reading.gcode.motion import MotionReader
from toolpace.programs.reading.gcode.program.words import Handler, Numbers

LETTERS = ("X", "Y", "Z", "B", "I", "J", "K", "K1", "I1", "F2")
"""Words of a cycle that is defined."""


class SurfaceHoles:
    """The cycle that is defined, and the surface."""

    def __init__(self, control: Control, state: Modal, motion: MotionReader) -> None:
        self.control, self.state, self.motion = control, state, motion
        self.words: Numbers = {}
        self.stops, self.out = False, RAPID_OUT
        self.surface: float | None = None

    def handlers(self) -> dict[str, Handler]:
        """What carries out each meaning: G81 drills, G84 taps (J is the pitch, by which the feed follows the spindle),
        G85 feeds in and out (F2= is the feed out), and G86 stops the spindle below."""
        return {
            "define drill": self._define(),
            "define peck": self.peck,
            "define tap": self._define(stops=True, out=FEED_OUT),
            "define bore": self._define(out=FEED_OUT),
            "define bore and stop": self._define(stops=True),
            "run cycle": self.run,
        }

    def _define(self, *, stops: bool = False, out: str = RAPID_OUT) -> Handler:
        def define(numbers: Numbers, word: str) -> None:
            self.words = {letter: numbers.pop(letter) for letter in LETTERS if letter in numbers}
            self.stops, self.out = stops, out

        return define

    def peck(self, numbers: Numbers, word: str) -> None:
        """G83: I first peck (K on older ones), J less each time, back to the clearance after each."""
        self._define()(numbers, word)
        self.words["peck"] = self.words.pop("K", 0.0)
        self.words["less"] = self.words.pop("I", 0.0)
        self.words["break"] = self.words.pop("J", 0.0)

    def run(self, numbers: Numbers, word: str) -> None:
        """G79: the cycle at X, Y; Z is the surface, and stays."""
        control, unit, words = self.control, self.state.unit, self.words
        if "Z" not in words or "Y" not in words:
            raise BlockError(f"{word} runs a cycle, and none is defined: write G81 Y.. Z.. before it")
        target, _ = self.motion.target(numbers)
        if "Z" in numbers or self.surface is None:
            self.surface = target[2]
        numbers.clear()
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
