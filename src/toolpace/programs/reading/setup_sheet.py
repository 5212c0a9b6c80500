"""A set-up sheet to fill in, from what a program uses."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager

from toolpace.common.errors import ReachError, printable
from toolpace.common.files.toml import toml_key
from toolpace.programs.reading.coordinates.kinematics import Kinematics, Poses
from toolpace.programs.reading.coordinates.placement import Datum
from toolpace.programs.reading.coordinates.setup import STAND_IN, ZERO_CURE, SetUp, tool_name
from toolpace.programs.reading.findings import Used

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


def setup_sheet(program: str, used: Used, machine: Kinematics | None, given: SetUp) -> str:
    """The text of a sheet (TOML) with all that the program uses, one line a figure.

    machine: tells the axes and the stand-ins; None: X, Y and Z at zero. given: figures that are known already.
    """
    poses = Poses(machine)
    own, filled = Datum(poses, SetUp()), Datum(poses, given)
    parts = [HEAD.format(program=printable(program), machine=f" on {machine.name}" if machine is not None else "")]
    if used.machine_zero or used.offsets or used.references or given.machine_zero:
        parts.append(_table("machine_zero", ZERO, _by_letter(poses, filled.zero)))
    for offset in dict.fromkeys([*used.offsets, *given.offsets]):
        wanted = given.offsets.get(offset)
        figures = _by_letter(poses, _origin(own, filled)) | dict(wanted or {})
        parts.append(_table(f"offsets.{toml_key(offset)}", OFFSET, figures))
    for number in dict.fromkeys([*used.references, *given.references]):
        said = REFERENCE.format(word="G28" if number == 1 else f"G30 P{number}")
        parts.append(_table(f"references.{number}", said, filled.reference(number)))
    for name in dict.fromkeys(map(tool_name, [*used.tools, *given.tools])):
        tool = given.tool(name)
        figures = {"length": own.own_length} if tool is None else tool.figures()
        parts.append(_table(f"tools.{toml_key(name)}", TOOL, figures))
    return "\n".join(parts)


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
