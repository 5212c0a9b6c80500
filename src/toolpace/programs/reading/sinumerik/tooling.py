"""Tools: T, D, tool change, length, radius."""

from __future__ import annotations

from toolpace.common.units import INCH, MINUTE
from toolpace.programs.reading.compensation.stage import OffsetStage
from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.options import PROGRAM, ReadOptions
from toolpace.programs.reading.sinumerik.state import State
from toolpace.programs.reading.sinumerik.syntax.values import Axis, ValueFault, shown
from toolpace.programs.reading.sinumerik.word_values import Words, number

LENGTH_STAYS = (
    "the length of the tool stays along Z under G18 and G19, as posts count on it (SD42940 = 17; else it is along Y, X)"
)


class Tooling:
    """The tool that is selected, the one in the spindle, and what of them counts."""

    def __init__(self, control: Control, state: State, options: ReadOptions) -> None:
        self.control, self.state = control, state
        self.as_programmed = options.compensation == PROGRAM
        self.selected = ""
        self.at_once = False
        """Whether T changes the tool, since the program has no M6."""
        self.edge = 1
        control.set_length("")

    def take(self, words: Words) -> None:
        """T, D and S of a block."""
        given = words.pop("T", None)
        if given is not None:
            value = given.value
            if isinstance(value, (tuple, bool, Axis)):
                raise ValueFault(f'T is the number or the name of a tool, not {shown(value)}: write T5 or T="MILL"')
            self.selected = value.strip() if isinstance(value, str) else f"{value:g}"
            if self.at_once:
                self.change()
        edge = number(words, "D")
        if edge is not None:
            if edge != round(edge) or edge < 0.0:
                raise ValueFault(f"D{edge:g} is no number of a cutting edge (alarm 14090): write D1, or D0 for none")
            self._refuse_within(f"D{edge:g}")
            self.edge = round(edge)
            if self.edge > 1 and self.control.setup.tools:
                self.control.findings.assumed(f"D{self.edge} has the length that the sheet tells of the tool")
            self.control.set_length(None if self.edge == 0 else "")
        overshoot = number(words, "DISC")
        if overshoot is not None:
            self._refuse_within("DISC")
            self.state.overshoot = overshoot
        allowance = number(words, "OFFN")
        if allowance is not None:
            self._refuse_within("OFFN")
            if allowance and self.state.unit == INCH and self.state.feed_unit is None:
                raise ValueFault("OFFN under G70: whether it is in inches is not told; write G700 or G71")
            self.state.allowance = allowance * self.state.unit
        spindle = number(words, "S")
        if spindle is not None:
            self.control.feed.spindle = spindle / MINUTE

    def change(self, *, edge_told: bool = False) -> None:
        """Put the selected tool into the spindle; its first edge counts then, unless D stands in the block."""
        self._refuse_within("a change of the tool")
        self.control.change_tool(self.selected)
        if self.edge == 0 and not edge_told:
            self.edge = 1
            self.control.set_length("")

    def _refuse_within(self, what: str) -> None:
        if isinstance(self.control.stage, OffsetStage):
            raise ValueFault(f"{what} while the radius is compensated is not read: write G40 before it")

    @property
    def radius(self) -> float | None:
        """Of the tool in the spindle [m], zero where its contour is the programmed one; None: unknown."""
        if self.as_programmed or self.edge == 0:
            return 0.0
        found = self.control.setup.tools.get(self.control.tool)
        return None if found is None else found.radius

    def plane_changed(self) -> None:
        """Say where the length of the tool lies under G18 and G19."""
        if self.state.plane and self.edge and not self.control.coordinates.tip_mode:
            self.control.findings.assumed(LENGTH_STAYS)
