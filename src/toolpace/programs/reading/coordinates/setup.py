"""The set-up sheet: offsets, references, machine zero, tools, workpiece."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from toolpace.common.units import FARTHEST_PART, LONGEST_TOOL, METRES, SECONDS, refuse_other_unit
from toolpace.programs.spindle_figures import SpindleFigures
from toolpace.programs.stock_figures import WorkpieceFigures
from toolpace.programs.tool_figures import ToolFigures

Position = Mapping[str, float]
"""Machine coordinates by axis letter [m, rad]; an axis that is not there is not known."""
STAND_IN = "the upper ends of the travel of X, Y and Z"
"""Where machine zero and reference points are, where no sheet tells it."""
OFFSETS_UNSAID = "no set-up sheet tells work offsets: the origin of the part stands for every work offset (preset)"
ZERO_UNSAID = f"the set-up sheet does not say where machine zero is: it is taken to be at {STAND_IN}, 1 mm inside"
ZERO_CURE = (
    "say on a set-up sheet where machine zero and reference points are ([machine_zero]): inspect --write-setup FILE "
    "writes one to fill in"
)
"""What to do where a machine leaves its travel, and machine zero is a stand-in."""
_P_WORD = re.compile(r"(?<=[0-9])[ \t]*P[ \t]*(?=[0-9])")


LONGEST_CHANGE = 3600.0
"""Of a tool [s]."""


@dataclass(frozen=True)
class Tool:
    """A line of the tool table."""

    length: float | None = None
    """From the spindle nose to the tip [m]; None where the sheet does not tell it: as the machine's own."""
    radius: float | None = None
    """That the control compensates [m]; None where the sheet does not tell it."""
    corner_radius: float | None = None
    """Of the ball or the torus at its tip (R2 of Heidenhain's tool table) [m]; None where nothing tells it."""
    figures: ToolFigures | None = None
    """Its shape, for what it cuts; None where the sheet does not tell it."""
    added: Mapping[str, Any] = field(default_factory=dict)
    """Figures of a sheet without a diameter, by the fields of ToolFigures: of a tool whose shape the program tells."""

    def __post_init__(self) -> None:
        for name in ("length", "radius", "corner_radius"):
            if (figure := getattr(self, name)) is not None:
                refuse_other_unit(figure, LONGEST_TOOL, f"tool: {name}", METRES)

    def completed(self, told: ToolFigures | None) -> ToolFigures | None:
        """Its shape; where the sheet has no diameter that of the program with what the sheet adds. Raises UsageError
        where both contradict each other."""
        if self.figures is not None or told is None or not self.added:
            return self.figures or told
        return replace(told, **self.added)

    def control_figures(self) -> dict[str, float]:
        """What the control's own table would have of it, by the key of the sheet [m]."""
        values = {"length": self.length, "radius": self.radius, "corner_radius": self.corner_radius}
        return {key: figure for key, figure in values.items() if figure is not None}


@dataclass(frozen=True)
class SetUp:
    """A set-up sheet. All is optional: what is missing has a stand-in, which the reader names in what it assumed.

    Machine coordinates count from the machine's zero; the joints of the machine file count from their own, and
    `machine_zero` tells where the one is in the other.
    """

    source: str = ""
    """The file, for messages."""
    offsets: Mapping[str, Position] = field(default_factory=dict)
    """Work offsets by name (G54, G54.1 P1, ...): machine coordinates of their origin, without a tool."""
    references: Mapping[int, Position] = field(default_factory=dict)
    """Reference points by number: 1 is G28's, 2 to 4 are those of G30."""
    machine_zero: Position = field(default_factory=dict)
    """Joint positions at which the machine's coordinates are zero; elsewhere the end of travel."""
    tools: Mapping[str, Tool] = field(default_factory=dict)
    """Tools by number or name."""
    start: Position = field(default_factory=dict)
    """Where the machine stands before the program."""
    variables: Mapping[str, float] = field(default_factory=dict)
    """Variables of the controller that are set before the program, by name."""
    part: Mapping[str, tuple[float, float, float]] = field(default_factory=dict)
    """Where the part is clamped: `origin` [m], `x` and `z` directions; see Machine.mounted."""

    tool_change: float = 0.0
    """Time that the machine takes to change a tool [s]."""
    workpiece: WorkpieceFigures = field(default_factory=WorkpieceFigures)
    """Stock, finished part and fixtures, as far as it tells of them."""
    spindle: SpindleFigures = field(default_factory=SpindleFigures)
    """What the machine's spindle gives."""

    def __post_init__(self) -> None:
        # machine coordinates of linear axes; those of rotary ones may be any angle
        places = {**self.offsets, "machine_zero": self.machine_zero, "start": self.start}
        for name, place in (*places.items(), *((f"reference {k}", each) for k, each in self.references.items())):
            for axis, figure in place.items():
                if axis in ("X", "Y", "Z"):
                    refuse_other_unit(figure, FARTHEST_PART, f"set-up: {axis} of {name}", METRES)
        for figure in self.part.get("origin", ()):
            refuse_other_unit(figure, FARTHEST_PART, "set-up: origin of part", METRES)
        refuse_other_unit(self.tool_change, LONGEST_CHANGE, "set-up: tool_change", SECONDS)

    @property
    def lacks_zero(self) -> bool:
        """Whether it does not say where machine zero is in each of X, Y and Z."""
        return not {"X", "Y", "Z"} <= set(self.machine_zero)

    @property
    def tells_lengths(self) -> bool:
        """Whether it tells the length of any tool: without one all are as long as the machine's own."""
        return any(tool.length is not None for tool in self.tools.values())

    def length_doubt(self, tool: str) -> str:
        """A sentence on what is taken for the length of a tool, where the sheet tells those of others only; else ""."""
        found = self.tool(tool)
        if not self.tells_lengths or (found is not None and found.length is not None):
            return ""
        lacks = "is not on the set-up sheet" if found is None else "has no length on the set-up sheet"
        return f"tool {tool} {lacks}: it is as long as the machine's own"

    def figures_of(self, tool: str, told: ToolFigures | None = None) -> ToolFigures | None:
        """The shape of a tool, of the only one of the sheet where the program names none (""); told: what the program
        tells of it, which the sheet goes before. Raises UsageError where the two together contradict each other."""
        only = not tool and len(self.tools) == 1
        found = next(iter(self.tools.values())) if only else self.tool(tool)
        return told if found is None else found.completed(told)

    def tool(self, name: str) -> Tool | None:
        """The line of a tool, however its number is written (5, 05); None where there is none."""
        return self.tools.get(tool_name(name))


def tool_name(written: str) -> str:
    """A tool's name as the table has it: numbers without leading zeros."""
    name = " ".join(written.split())
    return str(int(name)) if name.isascii() and name.isdigit() and len(name) < 20 else name


def offset_name(heading: str) -> str:
    """The name of a work offset as readers call it: G54, "G54.1 P12"."""
    return _P_WORD.sub(" P", " ".join(heading.upper().split()))
