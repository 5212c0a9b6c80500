"""Tool lengths of cutter-location data and tables, from operations and set-up sheet."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from toolpace.common.arrays import Floats, Ints
from toolpace.programs.reading.coordinates.kinematics import Kinematics
from toolpace.programs.reading.coordinates.setup import SetUp
from toolpace.programs.reading.findings import Findings
from toolpace.programs.reading.source import Source
from toolpace.programs.toolpath import Operation

NOT_LISTED = "tool {} is not on the set-up sheet: it is as long as the machine's own"
ONLY_TOOL = "the program names no tool: {}, the only one of the set-up sheet, is in the spindle"
NO_SHEET = (
    "no set-up sheet tells the lengths of tools: each is as long as the machine's own, {:g} mm on {} ([tools] of "
    "--setup FILE tells others)"
)
NO_TOOL = "the program names no tool, and the set-up sheet has several: it is as long as the machine's own"


def told_lengths(lengths: Floats, machine: Kinematics | None) -> Floats | None:
    """Lengths (n,) of tools [m] as a tool path tells them; None where all are as long as the machine's own, whatever
    that is, and without a machine, where nobody knows."""
    return None if machine is None or (lengths == float(machine.tool_length)).all() else lengths


class ToolLengths:
    """The tool table of a set-up sheet, and the machine's own tool for what is not on it."""

    def __init__(self, source: Source, setup: SetUp, machine: Kinematics | None, findings: Findings) -> None:
        self.source, self.setup, self.machine, self.findings = source, setup, machine, findings

    def lists(self, tool: str) -> bool:
        """Whether the sheet has this number or name."""
        return self.setup.tool(tool) is not None

    def along(self, operations: Sequence[Operation], operation: Ints, line: Ints) -> Floats | None:
        """(n,) length of the tool in the spindle on the way to each point [m], from its operation (n,).

        None where the sheet lists no tools. `line` (n,) is for messages. Raises ProgramError where the sheet does not
        list a tool, and no machine tells another length.
        """
        self.findings.used.tools.update(dict.fromkeys(each.tool for each in operations if each.tool))
        if not self.setup.tools:
            if self.machine is not None:
                self.findings.assumed(NO_SHEET.format(float(self.machine.tool_length) * 1e3, self.machine.name))
            return None
        lengths = np.array([self._of(each.tool) for each in operations])
        unknown = np.isnan(lengths)[operation]
        if unknown.all():
            return None
        if unknown.any():
            at = int(np.argmax(unknown))
            self.source.fail(
                f"tool {operations[operation[at]].tool or 'without a name'} is not on the set-up sheet, and without a "
                "machine its length is not known: list it there, or give the machine",
                int(line[at]),
            )
        return lengths[operation] if self.machine is None else told_lengths(lengths[operation], self.machine)

    def _of(self, tool: str) -> float:
        """Length of a tool [m]; nan where nothing tells it."""
        tools = self.setup.tools
        if not tool and len(tools) == 1:
            (only,) = tools
            self.findings.assumed(ONLY_TOOL.format(only))
            return tools[only].length
        found = self.setup.tool(tool)
        if found is not None:
            return found.length
        self.findings.assumed(NOT_LISTED.format(tool) if tool else NO_TOOL)
        return np.nan if self.machine is None else float(self.machine.tool_length)
