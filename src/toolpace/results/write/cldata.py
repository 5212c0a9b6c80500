"""A tool path as cutter-location data (APT)."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from toolpace.common.errors import printable
from toolpace.common.units import MILLIMETRE, MINUTE
from toolpace.programs.toolpath import ToolPath

TIP, AXIS, FEED = 9, 12, 9
"""Decimals of mm, of a direction's parts, and of mm/min or motions a minute."""


def cldata_text(toolpath: ToolPath, note: str = "") -> str:
    """The statements, one a line, in mm; read again they are the same points, feeds, stops and dwells.

    Rotary joints, where the tool path names them, are left to whoever reads it: another machine has others.
    """
    head = [f"PPRINT {printable(line)[:60]}" for line in note.splitlines()]
    return "\n".join([*head, "UNITS/MM", "MULTAX", *_statements(toolpath), "FINI", ""])


def _statements(toolpath: ToolPath) -> Iterator[str]:
    feed, begun = "", -1
    for i in range(len(toolpath)):
        if toolpath.operation[i] != begun:
            begun = int(toolpath.operation[i])
            yield from _operation(toolpath, begun)
        if i > 0 and not toolpath.rapid[i]:
            wanted = _feed(toolpath, i)
            if wanted != feed:
                yield wanted
            feed = wanted
        elif i > 0:
            yield "RAPID"
        numbers = [_plain(each / MILLIMETRE, TIP) for each in toolpath.tip[i]]
        numbers += [_plain(each, AXIS) for each in toolpath.axis[i]]
        yield f"GOTO/{','.join(numbers)}"
        if toolpath.dwell[i] > 0.0 or (toolpath.stop[i] and 0 < i < len(toolpath) - 1):
            yield f"DELAY/{_plain(float(toolpath.dwell[i]), FEED)}"


def _operation(toolpath: ToolPath, number: int) -> Iterator[str]:
    operation = toolpath.operations[number]
    name = "".join(c for c in printable(operation.name) if c not in "$,/").strip()
    tool = "".join(c for c in printable(operation.tool) if c not in "$,/").strip()
    if name or tool:
        yield f"TOOL PATH/{name or f'OPERATION-{number + 1}'}" + (f",TOOL,{tool}" if tool else "")


def _feed(toolpath: ToolPath, i: int) -> str:
    """FEDRAT of the way to a point: its feed, or the inverse of its least time."""
    if np.isfinite(toolpath.feed[i]):
        return f"FEDRAT/{_plain(float(toolpath.feed[i]) / MILLIMETRE * MINUTE, FEED)},MMPM"
    return f"FEDRAT/INVERS,{_plain(MINUTE / float(toolpath.least_time[i]), FEED)}"


def _plain(value: float, decimals: int) -> str:
    text = f"{value:.{decimals}f}".rstrip("0")
    return "0." if text in ("-0.", "0.") else text
