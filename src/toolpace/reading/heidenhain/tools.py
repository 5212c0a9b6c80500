"""TOOL CALL: another tool, its axis, its speed and its feed."""

from __future__ import annotations

import re

from toolpace.reading.control.control import Control
from toolpace.reading.coordinates.tool_lengths import NOT_LISTED
from toolpace.reading.heidenhain.contour.motion import Step
from toolpace.reading.heidenhain.frames import Frames
from toolpace.reading.heidenhain.klartext.expressions import evaluate
from toolpace.reading.heidenhain.klartext.parameters import BlockError, Parameters
from toolpace.reading.heidenhain.klartext.words import VALUE, signed
from toolpace.reading.heidenhain.state import State
from toolpace.units import MINUTE

_TOOL = re.compile(r"\s*(?:\"([^\"]*)\"|(QS[0-9]+)|(Q[LR]?[0-9]+)|([0-9]+(?:\.[0-9]+)?))?")
_WORD = re.compile(r"\s*(?:([UVWXYZ])(?![-+0-9.,Q])|(DL|DR2|DR|VC|S|F)\s*(" + VALUE + ")?)")


class Tools:
    """Compiles TOOL CALL."""

    def __init__(self, control: Control, state: State, frames: Frames, parameters: Parameters) -> None:
        self.control, self.state, self.frames, self.parameters = control, state, frames, parameters

    def compile(self, text: str) -> Step:
        """What stands behind TOOL CALL. Raises BlockError."""
        found = _TOOL.match(text)
        assert found is not None
        letter, words = "", {}
        at = found.end()
        while text[at:].strip():
            match = _WORD.match(text, at)
            if match is None:
                raise BlockError(f"'{text[at:].strip()[:20]}' is not read in TOOL CALL: check its spelling")
            at = match.end()
            if match[1]:
                letter = match[1]
            elif match[3]:
                words[match[2]] = signed(match[3], self.parameters)

        def run() -> None:
            if letter:
                self.axis(letter)
            figures = {name: evaluate(value) for name, value in words.items()}
            tool = self.name(found)
            if tool or "DL" in figures or "DR" in figures:
                self.change(tool or self.control.tool, figures)
            if "VC" in figures:
                self.control.findings.refused("VC of TOOL CALL", self.control.line, "write the spindle speed S")
            if "S" in figures:
                self.control.feed.spindle = max(figures["S"], 0.0) / MINUTE
            if figures.get("F"):
                self.state.tool_feed = figures["F"]
                self.control.feed.set(figures["F"], self.state.feed_unit, self.control.line)

        return run

    def axis(self, letter: str) -> None:
        """The tool axis; it sets the plane of arcs, turns and cycles."""
        if letter not in "XYZ":
            cure = "write X, Y or Z for the tool axis"
            self.control.findings.refused(f"TOOL CALL with tool axis {letter}", self.control.line, cure)
            return
        self.state.tool_axis = "XYZ".index(letter)

    def name(self, found: re.Match[str]) -> str:
        """Number or name of the tool; "" where the block has none."""
        if found[1] is not None:
            return found[1].strip()
        if found[2]:
            return self.parameters.text(found[2])
        if found[3]:
            return f"{self.parameters.get(found[3]):g}"
        return f"{float(found[4]):g}" if found[4] else ""

    def change(self, tool: str, figures: dict[str, float]) -> None:
        """Take it, and reckon with its length and oversize; 0 is none, whose length is zero."""
        control = self.control
        if control.stage is not None and control.stage.compensates:
            raise BlockError("TOOL CALL under RL or RR is not read: write R0 before it")
        self.state.oversize = figures.get("DR", 0.0) * self.state.unit
        table = {name.upper(): name for name in control.setup.tools}
        tool = table.get(tool, tool)
        if tool != control.tool or tool == "0":
            control.change_tool(tool)
        if tool and tool not in control.setup.tools and control.setup.tools:
            control.findings.assumed(NOT_LISTED.format(tool))
        control.set_length(None if tool == "0" else tool, figures.get("DL", 0.0) * self.state.unit)
        known = control.setup.tool(tool)
        if known is None or known.radius is None:
            if "Q108" not in map(str.upper, control.setup.variables):
                self.parameters.shared.pop("Q108", None)
        else:
            # "Q108: radius R of the tool table, plus DR of TOOL CALL" (Q parameters that the control assigns)
            self.parameters.set("Q108", known.radius / self.state.unit + figures.get("DR", 0.0))
        self.state.came_from = []
