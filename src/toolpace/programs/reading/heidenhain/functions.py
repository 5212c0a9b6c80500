"""FUNCTION TCPM, TRANS, PRESET: newer forms of M functions and cycles."""

from __future__ import annotations

import re
from collections.abc import Callable

from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.expressions import BlockError
from toolpace.programs.reading.heidenhain.contour.straight_lines import Step
from toolpace.programs.reading.heidenhain.cycles import Cycles
from toolpace.programs.reading.heidenhain.frames import Frames
from toolpace.programs.reading.heidenhain.machine import MachineFunctions
from toolpace.programs.reading.heidenhain.parameters import Parameters, evaluate
from toolpace.programs.reading.heidenhain.words import VALUE, signed

_TCPM = re.compile(
    r"TCPM(?:\s+(?:F\s+(?:TCP|CONT)|AXIS\s+(?:POS|SPAT)|PATHCTRL\s+(?:AXIS|VECTOR)"
    r"|REFPNT\s+(?:TIP-TIP|TIP-CENTER|CENTER-CENTER)|F\s*(?:MAX|" + VALUE + ")))*"
)
_DWELL = re.compile(r"DWELL\s+(TIME|REV)\s*(" + VALUE + ")")
_PRESET = re.compile(r"SELECT\s*#?\s*(" + VALUE + r")(\s+KEEP TRANS)?(?:\s+WP)?")
HARMLESS = ("MODE MILL", "S-PULSE", "COUNT", "FEED DWELL RESET", "RESET FEED", "RESET S-PULSE")


class ModeFunctions:
    """Compiles them."""

    def __init__(
        self, control: Control, machine: MachineFunctions, frames: Frames, cycles: Cycles, parameters: Parameters
    ) -> None:
        self.control, self.machine, self.frames = control, machine, frames
        self.cycles, self.parameters = cycles, parameters

    def function(self, text: str) -> Step:
        """FUNCTION. Raises BlockError."""
        text = " ".join(text.split())
        if text.startswith("TCPM"):
            return self.tip_mode(text)
        if text == "RESET TCPM":
            return lambda: self.machine.tip_mode(False)
        if found := _DWELL.fullmatch(text):
            value, turns = signed(found[2], self.parameters), found[1] == "REV"
            return lambda: self.dwell(evaluate(value), turns)
        if text in ("PROG PATH IS CONTOUR", "PROG PATH IS OFF"):
            return lambda: self.path_is_contour(text.endswith("CONTOUR"))
        if text.startswith(HARMLESS):
            name = "FUNCTION " + text
            return lambda: self.control.findings.ignored(name)
        return self.refused(f"FUNCTION {text[:20]}", "leave it out if it moves nothing, or export for milling")

    def path_is_contour(self, on: bool) -> None:
        """LN is the surface itself from here on, or again where the tool goes."""
        self.machine.state.path_is_contour = on
        self.control.findings.ignored("FUNCTION PROG PATH")

    def dwell(self, value: float, turns: bool) -> None:
        """Wait for seconds or turns of the spindle."""
        if turns:
            if self.control.feed.spindle <= 0.0:
                raise BlockError("a dwell in turns needs the spindle speed: write S in TOOL CALL")
            value /= self.control.feed.spindle
        self.control.dwell(value)

    def tip_mode(self, text: str) -> Step:
        """FUNCTION TCPM with what it chooses. Raises BlockError."""
        if _TCPM.fullmatch(text) is None:
            raise BlockError(f"'{text[:60]}' has a word that FUNCTION TCPM does not have: check its spelling")
        if "REFPNT TIP-CENTER" in text:
            return self.refused(
                "FUNCTION TCPM REFPNT TIP-CENTER",
                "where the tip is while the tool turns about its centre is not known here: write REFPNT TIP-TIP, or "
                "CENTER-CENTER with X Y Z of the centre",
            )
        spatial, centre = "AXIS SPAT" in text, "REFPNT CENTER-CENTER" in text

        def run() -> None:
            if "F CONT" in text:
                self.control.findings.assumed("FUNCTION TCPM F CONT: F is the speed of the tip on the part")
            if "PATHCTRL VECTOR" in text:
                self.control.findings.assumed("PATHCTRL VECTOR: rotary axes turn in proportion, as with PATHCTRL AXIS")
            tool = self.control.setup.tool(self.control.tool)
            corner = None if tool is None else tool.corner_radius
            if centre and corner is None:
                cure = "give the tool's corner_radius on the set-up sheet (R2, by which the centre is above the tip)"
                self.control.refuse("FUNCTION TCPM REFPNT CENTER-CENTER", cure)
            self.machine.tip_mode(True, corner if centre and corner is not None else 0.0)
            self.machine.spatial_angles(spatial)

        return run

    def trans(self, text: str) -> Step:
        """TRANS DATUM, MIRROR, ROTATION, SCALE."""
        text = " ".join(text.split())
        kind, _, rest = text.partition(" ")
        cycles = self.cycles
        forms: dict[str, Callable[[str], Step]] = {
            "MIRROR": lambda rest: cycles.mirror(rest.removeprefix("AXIS")),
            "ROTATION": cycles.rotate,
            "SCALE": cycles.scale,
        }
        if kind == "DATUM" and rest == "RESET":
            return self.frames.reset_shift
        if kind == "DATUM" and rest.startswith("AXIS"):
            return cycles.shift(rest.removeprefix("AXIS"))
        if kind in forms:
            made = forms[kind]
            return made({"MIRROR": "", "ROTATION": "ROT+0", "SCALE": "SCL 1"}[kind] if rest == "RESET" else rest)
        return self.refused(f"TRANS {text[:20]}", "write TRANS DATUM AXIS with the shift of each axis")

    def preset(self, text: str) -> Step:
        """PRESET SELECT: as cycle 247; with KEEP TRANS what the program shifts, mirrors, turns and scales stays."""
        found = _PRESET.fullmatch(text)
        if found is None:
            return self.refused(f"PRESET {text[:20]}", "write PRESET SELECT #1, or CYCL DEF 247 with Q339")
        value, keeps = signed(found[1], self.parameters), found[2] is not None
        return lambda: self.cycles.preset({339: evaluate(value)}, keeps=keeps)

    def refused(self, word: str, cure: str) -> Step:
        """A step that notes a refused word."""
        return lambda: self.control.refuse(word, cure)
