"""Set-up sheets from TOML, and back; and a sheet to fill in, from what a program uses.

Lengths are in mm and angles in deg unless a table [units] says otherwise.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeVar

from toolpace.common.errors import ReachError, UsageError, printable
from toolpace.common.files.toml import TableFile, toml_key, toml_text, toml_value
from toolpace.common.units import MILLIMETRE
from toolpace.programs.reading.coordinates.kinematics import Kinematics, Poses
from toolpace.programs.reading.coordinates.setup import (
    LONGEST_CHANGE,
    STAND_IN,
    ZERO_CURE,
    Position,
    SetUp,
    Tool,
    offset_name,
    tool_name,
)
from toolpace.programs.reading.coordinates.work_coordinates import Datum
from toolpace.programs.reading.findings import Used
from toolpace.programs.reading.points import FARTHEST
from toolpace.programs.reading.setup_tables.quantities import ANGLES, LENGTHS, MOST_TURN
from toolpace.programs.reading.setup_tables.tools import (
    ToolTables,
    lines_to_fill_in,
    spindle_table,
    tool_table,
    tool_table_to_fill_in,
)
from toolpace.programs.reading.setup_tables.workpiece import STOCK_TO_FILL_IN, WorkpieceTables, workpiece_tables
from toolpace.programs.stock_figures import WorkpieceFigures
from toolpace.programs.tool_figures import ToolFigures

FILE = TableFile("set-up sheet", longest=1_000_000)
LETTERS = "XYZABCUVW"
TABLES = (
    "units", "offsets", "references", "machine_zero", "tools", "part", "start", "variables", "times", "stock",
    "finished_part", "fixtures", "spindle",
)  # fmt: skip
MOST_REFERENCES = 4
LONGEST_NAME = 100
"""Characters of a heading or a variable."""
Key = TypeVar("Key")
Value = TypeVar("Value")
HEAD = """\
# Set-up sheet of {program}{machine}.
# The figures are those that are taken without a sheet: put in those of the machine, and give it with --setup FILE.
# A table that is taken out has its stand-in again.
# With work offsets, words where no tool length counts (G49, D0) are those of the spindle nose, as on the control;
# without them they are those of the machine's own tool.

[units]
length = "mm"  # or "m", "in"
angle = "deg"  # or "rad"
"""
ZERO = "Joint positions (as the machine file counts them) at which the machine's own display shows zero."
OFFSET = "Origin of the work offset in machine coordinates, as the control's table of offsets has it."
REFERENCE = "Reference point of {word}, in machine coordinates."
TOOL = "From the spindle nose to the tip, as the control's tool table has it; with `radius` where G41 or RL is used."
_OUT_OF_TRAVEL = re.compile(r" its limit of \S+ mm")


def load_setup(path: str | Path) -> SetUp:
    """The set-up sheet in a file. Raises UsageError naming file, key and cure."""
    return setup_of_text(FILE.text(path), str(path), Path(path).parent)


def setup_of_text(text: str, source: str = "set-up sheet", folder: Path | None = None) -> SetUp:
    """A set-up sheet from its text; `source` names it in messages. Raises UsageError.

    folder: what names of meshes count from; None: the folder of the process.
    """
    return setup_of_table(FILE.table(text, source), source, folder)


def setup_of_table(table: Mapping[str, object], source: str, folder: Path | None = None) -> SetUp:
    """A set-up sheet from its tables, as they stand in the file. Raises UsageError."""
    sheet = _Sheet(source, table, "the sheet", TABLES)
    sheet.folder = folder or Path()
    return sheet.read()


def setup_text(setup: SetUp) -> str:
    """The text of a sheet that reads as exactly this set-up, in metres and radians."""
    tools = {name: tool_table(tool) for name, tool in setup.tools.items()}
    tables: dict[str, Mapping[str, object]] = {
        "offsets": {name: dict(place) for name, place in setup.offsets.items()},
        "references": {str(number): dict(place) for number, place in setup.references.items()},
        "machine_zero": dict(setup.machine_zero),
        "tools": tools,
        "part": {name: list(vector) for name, vector in setup.part.items()},
        "start": dict(setup.start),
        "variables": dict(setup.variables),
        "times": {"tool_change": setup.tool_change} if setup.tool_change else {},
        **workpiece_tables(setup.workpiece),
        "spindle": spindle_table(setup.spindle),
    }
    filled = {name: table for name, table in tables.items() if table}
    return toml_text({"units": {"length": "m", "angle": "rad"}, **filled})


def setup_in(machine: object) -> SetUp:
    """The set-up sheet in the file of a machine; an empty one where there is none. Raises UsageError."""
    table = getattr(machine, "setup", None)
    source = str(getattr(machine, "source", "") or getattr(machine, "name", "") or "machine file")
    return setup_of_table(table, f"{source}: [setup]", Path(source).parent) if table else SetUp()


def check_setup(setup: SetUp, machine: Kinematics) -> None:
    """Raise UsageError where the sheet names an axis that the machine does not have, or clamps the part elsewhere."""
    source = setup.source or "set-up sheet"
    slots = Poses(machine).slots()
    places: dict[str, Position] = {f"offsets.{name}": place for name, place in setup.offsets.items()}
    places |= {f"references.{number}": place for number, place in setup.references.items()}
    places |= {"machine_zero": setup.machine_zero, "start": setup.start}
    for name, place in places.items():
        for letter in place:
            if letter not in slots:
                raise UsageError(
                    f"{source}: [{name}] {letter}: machine '{machine.name}' has no axis {letter}, its axes are "
                    f"{', '.join(slots)}; remove the line, or choose the right machine"
                )
    mounted = getattr(machine, "mounted", None)
    if setup.part and mounted is not None and mounted(**setup.part) != machine:
        raise UsageError(
            f"{source}: [part] clamps the part elsewhere than machine '{machine.name}' has it; "
            "read and plan with machine.mounted(**setup.part)"
        )


class _Sheet(ToolTables, WorkpieceTables):
    """One reading of one sheet."""

    def read(self) -> SetUp:
        return SetUp(
            source=self.source,
            offsets=self.named("offsets", offset_name, self.position),
            references=self.named("references", self.number_of_reference, self.position),
            machine_zero=self.position("[machine_zero]", self.table("machine_zero")),
            tools=self.named("tools", tool_name, self.tool),
            start=self.position("[start]", self.table("start")),
            variables=self.variables(),
            part=self.part(),
            tool_change=self.tool_change(),
            workpiece=self.workpiece(),
            spindle=self.spindle(),
        )

    def named(
        self, name: str, key_of: Callable[[str], Key], value_of: Callable[[str, Mapping[str, object]], Value]
    ) -> dict[Key, Value]:
        """The tables of a table, by what their headings mean."""
        found: dict[Key, Value] = {}
        for heading, value in self.table(name).items():
            place = f"[{name}.{heading[:40]}]"
            self.short(f"[{name}]", heading)
            key = key_of(heading)
            if not isinstance(value, dict):
                self.fail(f"[{name}]", f"{heading[:40]} = {value!r:.40} is not a table; write it under {place}")
            if key in found:
                self.fail(place, f"stands twice, as {key} in another way of writing; keep one")
            found[key] = value_of(place, value)
        return found

    def short(self, place: str, name: str) -> None:
        if len(name) > LONGEST_NAME:
            self.fail(place, f"has the name '{name[:40]}...', of {len(name)} characters; {LONGEST_NAME} are the most")

    def variables(self) -> dict[str, float]:
        found = {}
        for name, value in self.table("variables").items():
            self.short("[variables]", name)
            found[name] = self.number("[variables]", name, value)
        return found

    def number_of_reference(self, heading: str) -> int:
        if heading not in map(str, range(1, MOST_REFERENCES + 1)):
            self.fail(
                f"[references.{heading[:40]}]", f"is not 1 to {MOST_REFERENCES}; 1 is G28's, the others are G30's by P"
            )
        return int(heading)

    def position(self, place: str, table: Mapping[str, object]) -> dict[str, float]:
        found = {}
        for letter, value in table.items():
            if len(letter) != 1 or letter not in LETTERS:
                self.fail(place, f"has the key '{letter[:40]}'; write axis letters, like X = 12.5")
            if letter in "ABC":
                found[letter] = self.quantity(place, letter, value, self.angle, ANGLES, MOST_TURN)
            else:
                found[letter] = self.quantity(place, letter, value, self.length, LENGTHS, FARTHEST)
        return found

    def part(self) -> dict[str, tuple[float, float, float]]:
        table = self.table("part")
        self.refuse_unknown_keys("[part]", table, ("origin", "x", "z"))
        return {
            key: self.place_of("[part]", key, value, FARTHEST)
            if key == "origin"
            else self.direction_of("[part]", key, value)
            for key, value in table.items()
        }

    def tool_change(self) -> float:
        times = self.table("times")
        self.refuse_unknown_keys("[times]", times, ("tool_change",))
        found = self.number("[times]", "tool_change", times.get("tool_change", 0.0), "seconds")
        if not 0.0 <= found <= LONGEST_CHANGE:
            self.fail("[times]", f"tool_change = {found:g} is not between 0 and {LONGEST_CHANGE:g} s: correct it")
        return found


@contextmanager
def with_cure_of_zero(assumed: Sequence[str]) -> Iterator[None]:
    """Where a linear joint leaves its travel: name the sheet first where machine zero is a stand-in of the reader.

    assumed: what the reader took for granted. Raises the ReachError of the context, with that cure.
    """
    try:
        yield
    except ReachError as error:
        reason, _, cure = str(error).rpartition("; ")
        if not _OUT_OF_TRAVEL.search(reason) or not any(STAND_IN in sentence for sentence in assumed):
            raise
        raise ReachError(f"{reason}; {ZERO_CURE} (else {cure})") from error


def with_program_figures(setup: SetUp, shapes: Mapping[str, ToolFigures], workpiece: WorkpieceFigures) -> SetUp:
    """The set-up with the shapes of tools, and the stock, that a program tells and the sheet does not."""
    tools = dict(setup.tools)
    for name, figures in shapes.items():
        tool = tools.get(tool_name(name), Tool())
        if tool.figures is None:
            tools[tool_name(name)] = replace(tool, figures=tool.completed(figures), added={})
    return replace(setup, tools=tools, workpiece=workpiece if setup.workpiece.stock is None else setup.workpiece)


def setup_sheet(
    program: str,
    used: Used,
    machine: Kinematics | None,
    setup: SetUp,
    tip_at_feed: Sequence[tuple[float, float]] | None = None,
) -> str:
    """The text of a sheet (TOML) with all that the program uses, one line a figure.

    machine: tells the axes and the stand-ins; None: X, Y and Z at zero. setup: figures of a sheet that there is.
    tip_at_feed: (3, 2) least and most of X, Y and Z of the tip where it moves at feed [m].
    """
    poses = Poses(machine)
    own, filled = Datum(poses, SetUp()), Datum(poses, setup)
    parts = [HEAD.format(program=printable(program), machine=f" on {machine.name}" if machine is not None else "")]
    if used.machine_zero or used.offsets or used.references or setup.machine_zero:
        parts.append(_table("machine_zero", ZERO, _by_letter(poses, filled.zero)))
    for offset in dict.fromkeys([*used.offsets, *setup.offsets]):
        wanted = setup.offsets.get(offset)
        figures = _by_letter(poses, _origin(own, filled)) | dict(wanted or {})
        parts.append(_table(f"offsets.{toml_key(offset)}", OFFSET, figures))
    for number in dict.fromkeys([*used.references, *setup.references]):
        said = REFERENCE.format(word="G28" if number == 1 else f"G30 P{number}")
        parts.append(_table(f"references.{number}", said, filled.reference(number)))
    for name in dict.fromkeys(map(tool_name, [*used.tools, *setup.tools])):
        tool = setup.tool(name)
        table: dict[str, Any] = tool_table_to_fill_in(tool, own.own_length)
        lines = [f"# {TOOL}", f"[tools.{toml_key(name)}]", *(f"{key} = {toml_value(table[key])}" for key in table)]
        parts.append("\n".join(lines) + "\n" + lines_to_fill_in(table))
    parts.append(_workpiece(setup, tip_at_feed))
    return "\n".join(parts)


def _workpiece(setup: SetUp, tip_at_feed: Sequence[tuple[float, float]] | None) -> str:
    """The tables of the workpiece, in mm; lines to fill in where there is no stock."""
    tables = workpiece_tables(setup.workpiece, MILLIMETRE)
    if "stock" in tables:
        return toml_text(tables)
    corners = [", ".join(f"{each[end] * 1e3:.6g}" for each in tip_at_feed) for end in (0, 1)] if tip_at_feed else []
    extent = f"\n# At feed the tip of the tool goes from [{corners[0]}] to [{corners[1]}]." if corners else ""
    return STOCK_TO_FILL_IN.format(extent=extent) + (f"\n{toml_text(tables)}" if tables else "")


def _origin(own: Datum, filled: Datum) -> list[float]:
    """Machine coordinates of the stand-in of a work offset: the origin of the part, with no tool."""
    joints = [a - own.own_length * float(b) for a, b in zip(own.home, own.lift)]
    values = [*joints, *[0.0] * len(own.poses.rotary)]
    return [a - b for a, b in zip(values, filled.zero)]


def _by_letter(poses: Poses, values: list[float]) -> dict[str, float]:
    return {letter: values[slot] for letter, slot in poses.slots().items()}


def _table(heading: str, said: str, figures: Mapping[str, float]) -> str:
    lines = [f"# {said}", f"[{heading}]"]
    for key, value in figures.items():
        shown = math.degrees(value) if key in ("A", "B", "C") else value * 1e3
        lines.append(f"{key} = {round(shown, 9) + 0.0!r}")
    return "\n".join(lines) + "\n"
