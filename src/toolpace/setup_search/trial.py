"""The evaluation of one clamping: moved to where it fits, and its estimated duration.

The plan is a cheap one: the smooth path has wider tolerances, limits hold at the nodes of its mesh alone, and no bound
is worked out. Where the pace falls to next to nothing between two nodes, which a whole plan mends, the cell counts as
passed at the pace of its ends. What all this does to the order of clampings is measured in docs/notebook/clamping.md.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.common.errors import ReachError, ToolpaceError
from toolpace.machine.machine import Machine
from toolpace.programs.toolpath import ToolPath
from toolpace.setup_search.choices import Zone
from toolpace.setup_search.clamping import Clamping
from toolpace.setup_search.feasible_position import TORN, feasible_position

WIDER = 10.0
"""Tolerances of the cheap plan over those that were asked for."""
BEYOND = 1e6
"""Cost [s] of a clamping with which the program is not within travel, times one and its shortfall."""
FORBIDDEN = 1.0
"""Shortfall of a path that lies in a forbidden zone all along."""


@dataclass(frozen=True)
class Task:
    """What all trials have in common: the program as tips and tool axes, the machine, what is asked for."""

    toolpath: ToolPath
    machine: Machine
    centre: Floats
    """(3,) of the program, in the part's frame [m]."""
    box: Floats
    """(3, 2) shifts that are allowed [m]."""
    tip_tolerance: float
    """[m]"""
    axis_tolerance: float
    """[rad]"""
    forbidden: tuple[Zone, ...] = ()


@dataclass(frozen=True)
class Trial:
    """What came of a clamping."""

    clamping: Clamping
    """Where it fits, or falls short the least."""
    cost: float
    """About the duration [s]; from BEYOND on, what it falls short by."""

    @property
    def fits(self) -> bool:
        """Whether the program lies within all travels and outside of all zones."""
        return self.cost < BEYOND


def tried(task: Task, clamping: Clamping) -> Trial:
    """Try a clamping, at the nearest place to its own at which it fits."""
    try:
        found = feasible_position(clamping, task.machine, task.toolpath, task.centre, task.box)
    except ToolpaceError:
        return Trial(clamping, beyond(TORN))
    return tried_there(task, found.clamping) if found.fits else Trial(found.clamping, beyond(found.shortfall))


def tried_there(task: Task, clamping: Clamping) -> Trial:
    """Try a clamping where it is."""
    from toolpace.path.axis_path import AxisPath, check_travel
    from toolpace.path.path import Path
    from toolpace.planning.planner import plan

    try:
        machine = clamping.on(task.machine, task.centre)
        rotary = machine.choose_rotary(task.toolpath)
        joints = machine.joints_at(task.toolpath.tip, rotary, task.toolpath.tool_length)
        entered = zones_entered(machine, task.forbidden, joints)
        if entered > 0.0:
            return Trial(clamping, beyond(FORBIDDEN * entered))
        path = Path.fit(task.toolpath, WIDER * task.tip_tolerance, WIDER * task.axis_tolerance, machine)
        axis_path = AxisPath.follow(path, machine)
        check_travel(axis_path)
        motion = plan(axis_path, machine, bound=False, guard=False)
        return Trial(clamping, motion.duration - sum(law.lost_in_dips() for law in motion.laws))
    except ReachError:
        return Trial(clamping, beyond(0.0))
    except ToolpaceError:
        return Trial(clamping, beyond(TORN))


def beyond(shortfall: float) -> float:
    """The cost of a clamping that falls short."""
    return BEYOND * (1.0 + shortfall)


def zones_entered(machine: Machine, zones: tuple[Zone, ...], q: Floats) -> float:
    """Share of the ways between joint positions (n, joints) that enter a forbidden zone."""
    if not zones or len(q) < 2:
        return 0.0
    entered = np.any([zone.entered(machine.joints, q) for zone in zones], axis=0)
    return float(entered.mean())


def as_tips_and_axes(toolpath: ToolPath) -> ToolPath:
    """A program in joint words as tips and tool axes: another clamping asks for other joints."""
    return replace(toolpath, rotary=None, rotary_joints=())


def centre_of(toolpath: ToolPath) -> Floats:
    """(3,) the middle of the box about the program's tips, in the part's frame [m]."""
    middle = 0.5 * (toolpath.tip.min(axis=0) + toolpath.tip.max(axis=0))
    assert math.isfinite(float(middle.sum()))
    return np.asarray(middle)
