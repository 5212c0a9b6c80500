"""The table of operations and tools in the report, and the assumptions of the reader."""

from __future__ import annotations

from html import escape
from typing import TYPE_CHECKING

from toolpace.common.errors import printable
from toolpace.common.units import format_time
from toolpace.motion.operation_times import OperationTime, operation_times

if TYPE_CHECKING:
    from toolpace.motion.trajectory import Trajectory
    from toolpace.programs.toolpath import ToolPath

MOST = 200
"""Operations that are listed; of more, those that take longest are, in the order of the program."""
HEADINGS = ("Operation", "Tool", "Time", "Cutting", "Rapid", "Dwell", "Stops")


def operations_section(trajectory: Trajectory, toolpath: ToolPath | None) -> str:
    """A table of operations, and what was assumed and skipped; empty where there is no program."""
    if toolpath is None:
        return ""
    told = _table(operation_times(trajectory, toolpath)) + _assumed(toolpath)
    return f'<section class="panel"><h2>Operations</h2>{told}</section>' if told else ""


def _table(times: list[OperationTime]) -> str:
    if not times:
        return ""
    longest = sorted(range(len(times)), key=lambda k: -times[k].time)[:MOST]
    shown = [times[k] for k in sorted(longest)]
    rest = len(times) - len(shown)
    rows = "".join(_row(each.name or "", each.tool, each, "") for each in shown)
    total = OperationTime(
        "", "", sum(each.cutting for each in times), sum(each.rapid for each in times),
        sum(each.dwell for each in times), sum(each.stops for each in times),
    )  # fmt: skip
    rows += _row(f"all, and {rest} shorter ones" if rest else "all", "", total, ' class="ok"')
    head = "".join(f"<th>{heading}</th>" for heading in HEADINGS)
    return (
        f'<div class="scroll"><table class="checks"><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table></div>'
    )


def _row(name: str, tool: str, each: OperationTime, kind: str) -> str:
    cells = [printable(name), printable(tool), *map(_time, (each.time, each.cutting, each.rapid, each.dwell))]
    shown = "".join(f"<td>{escape(cell)}</td>" for cell in (*cells, str(each.stops)))
    return f"<tr{kind}>{shown}</tr>"


def _time(seconds: float) -> str:
    return format_time(seconds) if seconds else "-"


def _assumed(toolpath: ToolPath) -> str:
    """Sentences, folded away."""
    if not toolpath.assumed:
        return ""
    items = "".join(f"<li>{escape(printable(sentence))}</li>" for sentence in toolpath.assumed)
    heading = f"Assumed of the program ({len(toolpath.assumed)})"
    return f"<details><summary>{heading}</summary><ul>{items}</ul></details>"
