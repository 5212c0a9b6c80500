"""The tool whose bending a plan compensates: its file beside plan.json, and what plan.json says of it."""

from __future__ import annotations

import hashlib
from pathlib import Path

from toolpace.common.errors import UsageError
from toolpace.cutting.bending.compensated_program import BendingCompensation
from toolpace.cutting.tool_file import tool_bytes, tool_of_bytes
from toolpace.machine.cutting_tool import CuttingTool
from toolpace.results.write.plan_json import PLAN, BendingRecord

TOOL = "tool.toml"
"""Its name beside plan.json."""


def bending_record(aimed: BendingCompensation) -> BendingRecord:
    """What plan.json says of it."""
    sha256 = hashlib.sha256(aimed.tool.data).hexdigest()
    return BendingRecord(TOOL, sha256, 1e3 * aimed.largest, 1e6 * aimed.change, aimed.rounds)


def bent_tool(folder: Path, record: BendingRecord | None) -> CuttingTool | None:
    """The tool of a plan, from the file in its folder; None where none bends.

    Raises UsageError where plan.json and the file differ.
    """
    file = folder / TOOL
    there = file.exists()
    if record is None and not there:
        return None
    if record is None or record.tool_file != TOOL or not there:
        said = "nothing of a tool that bends" if record is None else f"tool_file {record.tool_file!r:.80}"
        raise UsageError(
            f"{folder / PLAN}: says {said}, and {TOOL} is {'' if there else 'not '}there; plan again to write it anew"
        )
    data = tool_bytes(file)
    if hashlib.sha256(data).hexdigest() != record.sha256:
        raise UsageError(f"{file}: is not the tool file that the plan was made with (sha256); plan again")
    return tool_of_bytes(data, str(file))
