"""The evaluation of one clamping: moved to the nearest place within all travels, and its estimated duration.

For a direction of clamping, a tool and a solution the rotary joints along the program are known, and do not depend
on where the part is. Every linear joint is then affine in the part's shift d: q = a + J d at each point. So the
shifts within all travels are a convex polytope, and the nearest to a wished one is had from a linear program

    least |d - wish|_1 + HEAVY e   such that   low + MARGIN - e <= a + J d <= high - MARGIN + e,   e >= 0, d in its box

whose rows are put in as they are found to be passed. Where e > 0 is left, there is no such place, and e says by how
much.

The plan is a cheap one: the smooth path has wider tolerances, limits hold at the nodes of its mesh alone, and no bound
is worked out. Where the pace falls to next to nothing between two nodes, which a whole plan mends, the cell counts as
passed at the pace of its ends. What all this does to the order of clampings is measured in docs/notebook/clamping.md.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from toolpace.common.arrays import Bools, Floats
from toolpace.common.errors import ReachError, ToolpaceError
from toolpace.machine import kinematics
from toolpace.machine.geometry import Geometry
from toolpace.machine.inverse import choose_rotary
from toolpace.machine.machine import Machine
from toolpace.programs.toolpath import ToolPath
from toolpace.setup_search.choices import Zone
from toolpace.setup_search.clamping import Clamping

MARGIN = 2e-4
"""Kept from the ends of travel [m]: a smooth path swings about the points of its program."""
HEAVY = 1e3
"""Weight of what is beyond travel against the way to the wished place."""
VIOLATED = 1e-7
"""By how much a row is passed that is put in [m]."""
MOST_ITERATIONS = 40
"""Of putting in rows, at most."""
TURNED = 10.0
"""Shortfall [m] of a direction that the rotary joints do not reach, beside that of its angles [rad]: more than any of a
place."""
TORN = 5.0
"""Shortfall of a program along which the rotary joints would have to jump."""
WIDER = 10.0
"""Tolerances of the cheap plan over those that were asked for."""
BEYOND = 1e6
"""Cost [s] of a clamping with which the program is not within travel, times one and its shortfall."""
FORBIDDEN = 1.0
"""Shortfall of a path that lies in a forbidden zone all along."""


@dataclass(frozen=True)
class FeasiblePosition:
    """A clamping moved to where it is within travel, or by how much none is."""

    clamping: Clamping
    shortfall: float
    """0 within all travels; else [m] beyond them at the best place, and more where the rotary joints do not reach."""

    @property
    def fits(self) -> bool:
        """Whether the program lies within all travels."""
        return self.shortfall <= VIOLATED


def feasible_position(
    clamping: Clamping, machine: Machine, toolpath: ToolPath, centre: Floats, box: Floats
) -> FeasiblePosition:
    """The clamping at the nearest place in the box (3, 2) [m] within all travels; `machine` as it is without it."""
    on = clamping.on(machine, centre)
    toolpath = toolpath.with_tool(on.tool_length)
    free = without_linear_travel(on.geometry)
    try:
        rotary = choose_rotary(free, toolpath)
    except ReachError:
        return FeasiblePosition(clamping, rotary_shortfall(on.geometry, toolpath))
    wish = np.array(clamping.shift)
    try:
        base = linear_joints(on, free, toolpath, rotary)
        jacobian = [linear_joints(_moved(on, e), free, toolpath, rotary) - base for e in np.eye(3)]
    except ReachError:
        return FeasiblePosition(clamping, TORN)
    travel = on.geometry.travel[on.linear]
    move, beyond = nearest_within(base, np.stack(jacobian, axis=2), travel, wish, box)
    x, y, z = (float(each) for each in wish + move)
    return FeasiblePosition(replace(clamping, shift=(x, y, z)), beyond)


def without_linear_travel(geometry: Geometry) -> Geometry:
    """The geometry with linear joints that go anywhere."""
    travel = geometry.travel.copy()
    travel[geometry.linear] = [-math.inf, math.inf]
    return replace(geometry, travel=travel)


def linear_joints(machine: Machine, free: Geometry, toolpath: ToolPath, rotary: Floats) -> Floats:
    """(n, 3) linear joints along a program on a machine, whatever their travel. Raises ReachError where they cannot."""
    geometry = replace(free, frame=machine.geometry.frame.copy())
    return np.asarray(kinematics.joints_at(geometry, toolpath.tip, rotary)[:, machine.linear])


def _moved(machine: Machine, shift: Floats) -> Machine:
    """The machine with the part moved by a shift (3,) [m]."""
    x, y, z = (float(each) for each in np.array(machine.file.chain.workpiece_origin) + shift)
    return machine.mounted((x, y, z))


def nearest_within(base: Floats, jacobian: Floats, travel: Floats, wish: Floats, box: Floats) -> tuple[Floats, float]:
    """The move (3,) [m] from a wish (3,) that brings joints base (n, 3) + ways (n, 3, 3) @ move into travel (3, 2).

    Returns it with what is left beyond travel [m]; wish + move lies in the box (3, 2).
    """
    from scipy.optimize import linprog

    ends = np.concatenate([base - (travel[:, 1] - MARGIN), (travel[:, 0] + MARGIN) - base]).ravel()
    slopes = np.concatenate([jacobian, -jacobian]).reshape(-1, 3)
    real = np.isfinite(ends)
    ends, slopes = ends[real], slopes[real]
    reach = box - wish[:, None]
    move = np.clip(np.zeros(3), reach[:, 0], reach[:, 1])
    beyond, rows = 0.0, np.zeros(len(ends), dtype=np.bool_)
    for _ in range(MOST_ITERATIONS):
        past = ends + slopes @ move
        worst = _worst_of(past, rows, beyond)
        if not worst.any():
            break
        rows |= worst
        # moves d = plus - minus, and e: least |d|_1 + HEAVY e
        matrix = np.column_stack([slopes[rows], -slopes[rows], -np.ones(int(rows.sum()))])
        bounds = [(max(low, 0.0), max(high, 0.0)) for low, high in reach]
        bounds += [(max(-high, 0.0), max(-low, 0.0)) for low, high in reach]
        found = linprog([*[1.0] * 6, HEAVY], matrix, -ends[rows], bounds=[*bounds, (0.0, None)], method="highs")
        if found.x is None:
            break
        move, beyond = np.asarray(found.x[:3] - found.x[3:6]), float(found.x[6])
    return move, max(float((ends + slopes @ move).max(initial=0.0)), 0.0)


def _worst_of(past: Floats, rows: Bools, beyond: float) -> Bools:
    """Which rows are to be put in: the most passed of those that are not in, a few at a time."""
    violation = np.where(rows, -math.inf, past - beyond)
    worst = np.zeros(len(past), dtype=np.bool_)
    worst[np.argsort(violation)[-12:]] = True
    return np.asarray(worst & (violation > VIOLATED))


def rotary_shortfall(geometry: Geometry, toolpath: ToolPath) -> float:
    """By how much the rotary joints fall short of the tool axes: the worst point, on its better solution."""
    solutions, pole = kinematics.rotary_solutions(geometry, toolpath.axis)
    travel = geometry.travel[geometry.rotary]
    short = np.zeros(solutions.shape)
    for joint in range(2):
        low, high = travel[joint]
        if math.isfinite(low) and math.isfinite(high):
            lowest = low + np.mod(solutions[:, :, joint] - low, 2.0 * math.pi)
            # past the high end, or short of the low one from the turn below
            short[:, :, joint] = np.minimum(np.maximum(lowest - high, 0.0), low + 2.0 * math.pi - lowest)
            short[:, :, joint] = np.where(lowest <= high, 0.0, short[:, :, joint])
    short[pole, :, 0] = 0.0
    lost = np.isnan(solutions).any(axis=(1, 2))
    if lost.any():
        return TURNED + math.pi + float(lost.mean())
    worst = float(short.sum(axis=2).min(axis=1).max())
    return TURNED + worst if worst > 0.0 else TORN


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
