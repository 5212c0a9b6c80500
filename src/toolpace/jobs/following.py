"""A check whether a machine can follow a program within its travels.

A smooth path swings about the points of the program: by a hundredth of a millimetre where the tool only moves, and by
millimetres where it stands near the pole far out, since a table that turns a little there moves all of it. So what
comes close to the end of travel is fitted, some thousand points of it, and what is far from it is not, to be quick.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from toolpace.common.units import DEGREE, MILLIMETRE

if TYPE_CHECKING:
    from toolpace.common.arrays import Bools
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
