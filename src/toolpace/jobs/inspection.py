"""The inspection of a program on machines: which can follow it within their travels; its JSON, and a set-up sheet.

A smooth path swings about the points of the program: by a hundredth of a millimetre where the tool only moves, and by
millimetres where it stands near the pole far out, since a table that turns a little there moves all of it. So what
comes close to the end of travel is fitted, some thousand points of it, and what is far from it is not, to be quick.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from toolpace.common.errors import printable
from toolpace.common.units import DEGREE, MILLIMETRE
from toolpace.programs.reading.inspection import Inspection

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from toolpace.common.arrays import Bools
    from toolpace.machine.machine import Machine
    from toolpace.programs.reading.coordinates.setup import SetUp
    from toolpace.programs.reading.inspection import Candidate
    from toolpace.programs.toolpath import ToolPath

NEAR = 0.02
"""Share of its travel from the end of which a joint is close to it."""
AROUND = 40
"""Points before and behind those that are close, so that the fit has its way there."""
MOST_FITTED = 5000
"""Points that are fitted for one machine, lest a program that works next to the ends take as long as to plan it."""


def follow_as_planned(machine: Candidate, toolpath: ToolPath) -> None:
    """Raise ReachError where the machine cannot follow the program, or the smooth path leaves its travel."""
    from toolpace.common.errors import PathError
    from toolpace.judge.figures import DEFAULT_AXIS_DEG, DEFAULT_TIP_MM
    from toolpace.machine.machine import Machine
    from toolpace.path.axis_path import AxisPath, check_travel
    from toolpace.path.path import Path

    assert isinstance(machine, Machine)
    tolerances = DEFAULT_TIP_MM * MILLIMETRE, DEFAULT_AXIS_DEG * DEGREE
    rotary = machine.choose_rotary(toolpath)
    q = machine.joints_at(toolpath.tip, rotary, toolpath.tool_length)
    low, high = machine.travel.T
    room = NEAR * np.where(np.isfinite(high - low), high - low, 0.0)
    close = ((q - low < room) | (high - q < room)).any(axis=1)
    posted = replace(toolpath, rotary=rotary, rotary_joints=tuple(machine.geometry.rotary_joints))
    fitted = 0
    for first, last in _stretches(close):
        part = posted.part(first, min(last, first + MOST_FITTED - fitted))
        fitted += len(part)
        try:
            path = Path.fit(part, *tolerances, machine)
        except PathError:
            continue  # nothing moves there, or no path fits, which `plan` will say
        check_travel(AxisPath.follow(path, machine), toolpath.source)
        if fitted >= MOST_FITTED:
            return


def _stretches(close: Bools) -> list[tuple[int, int]]:
    """First and last point of each stretch about the points (n,) that are close; what touches is one."""
    points = np.flatnonzero(close)
    heads = np.flatnonzero(np.diff(points, prepend=-np.inf) > 2 * AROUND)
    ends = [*heads[1:], len(points)]
    last = len(close) - 1
    return [
        (max(int(points[head]) - AROUND, 0), min(int(points[end - 1]) + AROUND, last)) for head, end in zip(heads, ends)
    ]


def sheet_to_fill_in(
    found: Sequence[Inspection], machines: Sequence[Machine], present: Callable[[Machine | None], SetUp]
) -> str:
    """The text of a set-up sheet with all that programs use, on the machine that they were read for; `present` tells
    what there is already, on a machine."""
    from toolpace.programs.reading.findings import Used
    from toolpace.programs.reading.setup_file import setup_sheet, with_program_figures

    used = Used()
    for each in found:
        used.offsets |= each.used.offsets
        used.references |= each.used.references
        used.tools |= each.used.tools | dict.fromkeys(each.tools)
        used.machine_zero |= each.used.machine_zero
    names = [name for each in found for name in (each.read_on, *each.machines) if name]
    machine = next((each for name in names for each in machines if each.name == name), None)
    setup = present(machine)
    for each in found:
        setup = with_program_figures(setup, each.shapes, each.workpiece)
    tips = [each.tip_at_feed for each in found if each.tip_at_feed is not None]
    tip = [(min(each[k][0] for each in tips), max(each[k][1] for each in tips)) for k in range(3)] if tips else None
    return setup_sheet(", ".join(each.program for each in found), used, machine, setup, tip)


def inspection_record(found: Inspection) -> dict[str, object]:
    """An entry of JSON: lengths in mm, angles in deg."""
    return {
        "program": printable(found.program),
        "dialect": found.dialect,
        "reason": printable(found.reason),
        "blocks": found.blocks,
        "five_axis_blocks": found.five_axis_blocks,
        "refused": [
            {"word": printable(each.word), "line": each.line, "count": each.count, "cure": printable(each.cure)}
            for each in found.refused
        ],
        "needs": [printable(sentence) for sentence in found.needs],
        "ignored": {printable(word): count for word, count in found.ignored.items()},
        "assumed": [printable(sentence) for sentence in found.assumed],
        "machines": list(found.machines),
        "not_on": {name: printable(why) for name, why in found.not_on.items()},
        "read_on": found.read_on,
        "arcs": found.arcs,
        "rapids": found.rapids,
        "stops": found.stops,
        "dwells": found.dwells,
        "dwell_s": found.dwell_s,
        "tools": [printable(tool) for tool in found.tools],
        "tip_mm": None if found.tip is None else [[value * 1e3 for value in each] for each in found.tip],
        "tilt_deg": None if found.tilt is None else [math.degrees(value) for value in found.tilt],
        "rotary_deg": {name: [math.degrees(value) for value in each] for name, each in found.rotary.items()},
    }
