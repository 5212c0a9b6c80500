"""TOOL CALL: tool, axis, speed, feed; what cuts and what is cut: TOOL DEF, BLK FORM."""

from __future__ import annotations

import re
from typing import Any

from toolpace.common.errors import UsageError
from toolpace.common.units import MINUTE, WIDEST_TOOL
from toolpace.programs.reading.arcs import ROUNDING
from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.expressions import BlockError
from toolpace.programs.reading.heidenhain.contour.straight_lines import Step
from toolpace.programs.reading.heidenhain.frames import Frames
from toolpace.programs.reading.heidenhain.parameters import Parameters, UnsetError, evaluate
from toolpace.programs.reading.heidenhain.state import State
from toolpace.programs.reading.heidenhain.words import VALUE, signed
from toolpace.programs.stock_figures import Solid, StockFigures, WorkpieceFigures
from toolpace.programs.tool_figures import ToolFigures

_TOOL = re.compile(r"\s*(?:\"([^\"]*)\"|(QS[0-9]+)|(Q[LR]?[0-9]+)|([0-9]+(?:\.[0-9]+)?))?")
_WORD = re.compile(r"\s*(?:([UVWXYZ])(?![-+0-9.,Q])|(DL|DR2|DR|VC|S|F)\s*(" + VALUE + ")?)")
_NUMBER = re.compile(r"\s*([0-9]+(?:\.[0-9]+)?)(?![0-9])")
_FIGURE = re.compile(r"\s([LR])\s*(" + VALUE + ")")
DEFINED = (
    "L of TOOL DEF is passed over, and R tells what is cut only, as of a flat end mill: lengths and radii of tools are "
    "those of the set-up sheet"
)
_BLANK = re.compile(r"FORM\s*(?:(0\.[12])|(CYLINDER))\b(.*)")
_CORNER = re.compile(r"\s*(I?)([XYZ])(?:\s*(" + VALUE + "))?")
_CYLINDER = re.compile(r"\s*(?:([XYZ])(?![-+0-9.,Q])|(DIST|RI|DI|R|D|L)\s*(" + VALUE + "))")
BLANK_NOT_READ = "this BLK FORM is not read: tell the stock on the set-up sheet ([stock])"
CYLINDER_TOP = "BLK FORM CYLINDER: its upper end lies by DIST above the datum (not confirmed)"
DELTAS = ("DL", "DR", "DR2")
MOST_DELTA, MOST_TOOL = 999.9999, 32767.9
"""Of an oversize (TNC7; 99.9999 on older ones), and of a tool's number ("Input format and unit of TNC functions")."""


class Tools:
    """Compiles TOOL CALL."""

    def __init__(self, control: Control, state: State, frames: Frames, parameters: Parameters) -> None:
        self.control, self.state, self.frames, self.parameters = control, state, frames, parameters
        self.least: list[float] | None = None
        """Corner of BLK FORM 0.1 [m]."""

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
            for name in DELTAS:
                if abs(figures.get(name, 0.0)) > MOST_DELTA:
                    raise BlockError(f"{name} of TOOL CALL is not between -999.9999 and 999.9999: correct it")
            deltas = [figures[name] for name in DELTAS if name in figures]
            if tool or deltas:
                self.state.oversize = any(deltas)
                self.change(tool or self.control.tool, figures)
            if "VC" in figures:
                self.control.refuse("VC of TOOL CALL", "write the spindle speed S")
            if "S" in figures:
                self.control.turn_spindle(max(figures["S"], 0.0) / MINUTE)
            if figures.get("F"):
                self.state.tool_feed = figures["F"]
                self.control.feed.set(figures["F"], self.state.feed_unit, self.control.line)

        return run

    def defined(self, text: str) -> None:
        """TOOL DEF: which tool is next moves nothing; what it tells of a tool is on the set-up sheet here."""
        findings = self.control.findings
        findings.ignored("TOOL DEF")
        words = dict(_FIGURE.findall(text))
        if words:
            findings.assumed(DEFINED)
        try:
            values = {name: evaluate(signed(value, self.parameters)) for name, value in words.items()}
        except (BlockError, UnsetError):
            return
        number, radius = _NUMBER.match(text), values.get("R", 0.0) * self.state.unit
        if number and 0.0 < radius <= 0.5 * WIDEST_TOOL:
            line = f"{self.control.source.name}:{self.control.line}: TOOL DEF"
            assumed = ("TOOL DEF tells the radius alone: the tool is taken as a flat end mill",)
            tool = ToolFigures("flat", 2.0 * radius, source=line, assumed=assumed)
            findings.tool_shapes[f"{float(number[1]):g}"] = tool

    def blank(self, text: str) -> Step:
        """BLK: the stock, by two corners or as a cylinder; other forms are passed over, and said."""
        findings = self.control.findings
        found = _BLANK.fullmatch(text)

        def run() -> None:
            solid = None
            try:
                if found and found[1]:
                    solid = self.corner(found[1] == "0.1", found[3])
                elif found and found[2]:
                    solid = self.cylinder(found[3])
                else:
                    self._pass_over_blank()
            except (UsageError, BlockError, UnsetError):
                # what is only drawn stops no control
                self._pass_over_blank()
            if solid is not None:
                findings.workpiece = WorkpieceFigures(StockFigures(solid))

        return run

    def _pass_over_blank(self) -> None:
        self.control.findings.ignored("BLK")
        self.control.findings.assumed(BLANK_NOT_READ)

    def corner(self, is_least: bool, text: str) -> Solid | None:
        """BLK FORM 0.1 and 0.2: the least and the most corner; the second makes the box of them."""
        words = {found[2]: (found[1], found[3]) for found in _CORNER.finditer(text) if found[3]}
        least = self.least
        if is_least:
            self.least = None
        if len(words) < 3 or _CORNER.sub("", text).strip() or (not is_least and least is None):
            self._pass_over_blank()
            return None
        values = [evaluate(signed(words[letter][1], self.parameters)) * self.state.unit for letter in "XYZ"]
        if is_least:
            self.least = values
            return None
        assert least is not None
        most = [low + value if words[letter][0] else value for letter, low, value in zip("XYZ", least, values)]
        (x0, y0, z0), (x1, y1, z1) = least, most
        return self._solid(box=((x0, y0, z0), (x1, y1, z1)))

    def cylinder(self, text: str) -> Solid | None:
        """BLK FORM CYLINDER Z R50 L105 DIST+5: its length, and by how much it is shifted along its axis."""
        axis, values = "", {}
        for found in _CYLINDER.finditer(text):
            axis = found[1] or axis
            if found[2]:
                values[found[2]] = evaluate(signed(found[3], self.parameters)) * self.state.unit
        hollow = values.get("RI", 0.0) or values.get("DI", 0.0)
        diameter = values.get("D", 2.0 * values.get("R", 0.0))
        if not axis or hollow or _CYLINDER.sub("", text).strip() or not (diameter > 0.0 and values.get("L", 0.0) > 0.0):
            self._pass_over_blank()
            return None
        self.control.findings.assumed(CYLINDER_TOP)
        top = values.get("DIST", 0.0)
        lower, upper = ([0.0, 0.0, 0.0] for _ in range(2))
        lower["XYZ".index(axis)], upper["XYZ".index(axis)] = top - values["L"], top
        (x0, y0, z0), (x1, y1, z1) = lower, upper
        return self._solid(cylinder=((x0, y0, z0), (x1, y1, z1), diameter))

    def _solid(self, **shape: Any) -> Solid:
        """A body in the datum in force. Raises UsageError where it is none."""
        control = self.control
        return Solid(**shape, frame=control.frame_of_stock(), source=f"{control.source.name}:{control.line}: BLK FORM")

    def axis(self, letter: str) -> None:
        """The tool axis; it sets the plane of arcs, turns and cycles."""
        if letter not in "XYZ":
            self.control.refuse(f"TOOL CALL with tool axis {letter}", "write X, Y or Z for the tool axis")
            return
        axis = "XYZ".index(letter)
        if self.control.poses.machine is not None and abs(self.control.datum.lift[axis]) < 1.0 - ROUNDING:
            self.control.findings.assumed(
                f"TOOL CALL with tool axis {letter} sets the plane of arcs, turns and cycles; the tool stands as the "
                "machine holds it, and its length counts along it"
            )
        self.state.tool_axis = axis

    def name(self, found: re.Match[str]) -> str:
        """Number or name of the tool; "" where the block has none."""
        if found[1] is not None:
            return found[1].strip()
        if found[2]:
            return self.parameters.text(found[2])
        if not found[3] and not found[4]:
            return ""
        number = self.parameters.get(found[3]) if found[3] else float(found[4])
        if not 0.0 <= number <= MOST_TOOL:
            raise BlockError(f"tool {number:g} is not between 0 and {MOST_TOOL:g}: correct its number")
        return f"{number:g}"

    def change(self, tool: str, figures: dict[str, float]) -> None:
        """Take it, and reckon with its length and oversize; 0 is none, whose length is zero."""
        control = self.control
        if control.stage is not None and control.stage.compensates:
            raise BlockError("TOOL CALL under RL or RR is not read: write R0 before it")
        if self.state.tip_mode:
            # "Before positioning with M91 or M92 and before a TOOL CALL block, reset M128"
            cure = "write M129 or FUNCTION RESET TCPM before, and switch it on again behind"
            control.refuse("TOOL CALL of a tool under M128", cure)
            return
        self.state.radius_oversize = figures.get("DR", 0.0) * self.state.unit
        table = {name.upper(): name for name in control.setup.tools}
        tool = table.get(tool, tool)
        if tool != control.tool or tool == "0":
            control.change_tool(tool)
        if tool and (doubt := control.setup.length_doubt(tool)):
            control.findings.assumed(doubt)
        control.set_length(None if tool == "0" else tool, figures.get("DL", 0.0) * self.state.unit)
        listed = control.setup.tool(tool)
        if listed is None or listed.radius is None:
            if "Q108" not in map(str.upper, control.setup.variables):
                self.parameters.shared.pop("Q108", None)
        else:
            # "Q108: radius R of the tool table, plus DR of TOOL CALL" (Q parameters that the control assigns)
            self.parameters.set("Q108", listed.radius / self.state.unit + figures.get("DR", 0.0))
        self.state.came_from = []
