"""The moves of a program that cut, and the cut of the tool in each."""

from __future__ import annotations

import numpy as np

from toolpace.common.arrays import Bools, Ints
from toolpace.common.errors import UsageError, did_you_mean
from toolpace.machine.cutting_tool import Cut, CuttingTool
from toolpace.programs.toolpath import ToolPath


def cuts_of(tool: CuttingTool) -> list[Cut]:
    """The cuts of a tool: first that of all operations that are not named, then those of these that are."""
    return [tool.cut, *(cut for cut in tool.operations.values() if cut is not None)]


def cut_of_way(tool: CuttingTool, toolpath: ToolPath) -> Ints:
    """(n,) which of `cuts_of` acts on the way to each point; -1 for none: rapids, ways without a feed, other tools.

    Raises UsageError where the program does not have the operations or tools that the file names, or nothing cuts.
    """
    names = [operation.name for operation in toolpath.operations]
    tools = [operation.tool for operation in toolpath.operations]
    program = toolpath.source or "the program"
    for what, wanted, there in (("operation", tool.operations, names), ("tool", tool.only, tools)):
        for name in wanted:
            if name not in there:
                known = [each for each in there if each]
                hint = did_you_mean(name, known) if known else f"it names no {what}s: leave that out"
                raise UsageError(f"{tool.source}: {program} has no {what} '{name}'; {hint}")
    order = [name for name, cut in tool.operations.items() if cut is not None]
    of_operation = np.array(
        [
            -1 if tool.only and called not in tool.only
            else 0 if name not in tool.operations
            else 1 + order.index(name) if name in order
            else -1
            for name, called in zip(names, tools)
        ]
    )  # fmt: skip
    found = np.where(at_feed(toolpath), of_operation[toolpath.operation], -1)
    if not (found >= 0).any():
        raise UsageError(
            f"{tool.source}: nothing of {program} cuts with this tool, so nothing bends: its ways are rapids, "
            "have no feed, or are of other tools"
        )
    return np.asarray(found, dtype=np.int64)


def at_feed(toolpath: ToolPath) -> Bools:
    """(n,) whether the way to each point is cut: neither a rapid, nor without feed and time, nor without length."""
    ruled = np.isfinite(toolpath.feed) | (toolpath.least_time > 0.0)
    return np.asarray(ruled & ~toolpath.rapid & (toolpath.way_length > 0.0))
