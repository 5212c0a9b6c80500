"""Places of a program by name: an operation, a tool, blocks."""

from __future__ import annotations

import re

import numpy as np

from toolpace.common.arrays import Bools
from toolpace.common.errors import UsageError, did_you_mean
from toolpace.programs.toolpath import ToolPath

_BLOCKS = re.compile(r"(N?)(\d{1,9})(?:-(N?)(\d{1,9}))?", re.IGNORECASE)


def points_of(place: str, toolpath: ToolPath) -> Bools:
    """(n,) whether the way to each point belongs to an operation, a tool or blocks. Raises UsageError."""
    named = [operation.name.casefold() == place.casefold() for operation in toolpath.operations]
    if not any(named):
        named = [f"t{operation.tool}".casefold() == place.casefold() for operation in toolpath.operations]
    if any(named) and place:
        found: Bools = np.array(named)[toolpath.operation]
        return found
    blocks = _BLOCKS.fullmatch(place)
    if blocks is None:
        raise UsageError(f"tolerance of '{place[:40]}': {unknown(place, toolpath)}")
    mark, first, second_mark, last = blocks.groups()
    ends = [int(first), int(last or first)]
    if mark or second_mark:
        ends = [line_of(number, toolpath, last=k > 0) for k, number in enumerate(ends)]
    inside: Bools = (toolpath.block >= ends[0]) & (toolpath.block <= ends[1])
    if not inside[1:].any():
        raise UsageError(
            f"tolerance of '{place[:40]}': {toolpath.source or 'the program'} moves nothing in these blocks"
        )
    return inside


def unknown(place: str, toolpath: ToolPath) -> str:
    """What to say of a place that there is not."""
    names = dict.fromkeys(operation.name for operation in toolpath.operations if operation.name)
    tools = dict.fromkeys(f"T{operation.tool}" for operation in toolpath.operations if operation.tool)
    known = [*names, *tools]
    if not known:
        return "the program names no operation and no tool; give blocks, like N100-N250, or lines, like 120-250"
    return f"no such operation, tool or block in {toolpath.source or 'the program'}; {did_you_mean(place, known)}"


def line_of(number: int, toolpath: ToolPath, *, last: bool) -> int:
    """The line of the first or last block with an N word. Raises UsageError where there is none."""
    lines = toolpath.numbered[toolpath.numbered[:, 0] == number, 1]
    if not len(lines):
        hint = "" if len(toolpath.numbered) else ": its blocks have no numbers; give lines, like 120-250"
        raise UsageError(f"{toolpath.source or 'the program'} has no block N{number}{hint}")
    return int(lines[-1 if last else 0])
