"""Rotary joint positions along a tool path: solution, turns and positions at the pole, chosen or between chosen points.

Away from its pole and from the edge of reach a solution is a continuous function of the tool axis. So between two
points on one solution that solution is meant. Between two points on different ones the solutions change at the pole
or at the edge of reach: where the joints move least on the whole.
"""

from __future__ import annotations

import math

import numpy as np

from toolpace.common.arrays import Bools, Floats, Ints
from toolpace.common.errors import ReachError
from toolpace.machine import kinematics
from toolpace.machine.geometry import Geometry
from toolpace.machine.unreachable import check_travel, rotary_jump, tilt_out_of_travel, unreachable_tilt
from toolpace.programs.toolpath import ToolPath

POLE_TOLERANCE = 1e-4
"""Angle to the pole within which the first joint of a program's axis is free [rad]: axes written with four decimals."""
TRAVEL_PENALTY = 1e5
"""Cost of a point at which a linear joint would leave its travel; far below that of a jump while cutting."""
EQUAL = 1e-9
"""Ways of the joints that differ by less count as equal [rad]."""
STRAY = 1e-3
"""How far joints that move in proportion may leave the great circle beside its length, as in the choice [rad]."""


def choose_rotary(geometry: Geometry, toolpath: ToolPath, pole_tolerance: float = POLE_TOLERANCE) -> Floats:
    """Rotary positions (n, 2) [rad], unwound, in the order of `geometry.rotary`.

    A program that names the rotary positions itself is taken at its word. Otherwise the least rotary motion
    is chosen among both solutions and all turns within travel. Where the tool axis comes within
    `pole_tolerance` [rad] of the pole, the first joint is free: it turns evenly between its values on both
    sides, and the axis may be off by up to that tolerance (rounded programs scatter about the pole by as
    much). Raises ReachError.
    """
    rotary = _of_program(geometry, toolpath)
    if rotary is None:
        rotary = _chosen(geometry, toolpath, pole_tolerance)
    check_travel(geometry, kinematics.joints_at(geometry, toolpath.tip, rotary), toolpath.block, toolpath.source)
    return rotary


def _of_program(geometry: Geometry, toolpath: ToolPath) -> Floats | None:
    names = [geometry.joints[joint] for joint in geometry.rotary]
    if toolpath.rotary is None or set(toolpath.rotary_joints) != set(names):
        return None
    return np.ascontiguousarray(toolpath.rotary[:, [toolpath.rotary_joints.index(name) for name in names]])


def _chosen(geometry: Geometry, toolpath: ToolPath, pole_tolerance: float) -> Floats:
    solutions, pole = solutions_along(geometry, toolpath, pole_tolerance)
    rotary = np.empty((len(pole), 2))
    points = np.flatnonzero(~pole)
    if len(points):
        rotary[points] = _fixed(geometry, toolpath, solutions[points], points)
    settle(geometry, toolpath, pole, pole_tolerance, rotary)
    return rotary


def solutions_along(geometry: Geometry, toolpath: ToolPath, pole_tolerance: float) -> tuple[Floats, Bools]:
    """Both solutions (n, 2, 2) at each point, and which lie at the pole (n,). Raises ReachError where there is none."""
    solutions, pole = kinematics.rotary_solutions(geometry, toolpath.axis, pole_tolerance)
    lost = np.isnan(solutions).any(axis=(1, 2))
    if lost.any():
        first = int(np.argmax(lost))
        raise unreachable_tilt(geometry, toolpath.axis[first], int(toolpath.block[first]), toolpath.source)
    return solutions, pole


def settle(geometry: Geometry, toolpath: ToolPath, pole: Bools, pole_tolerance: float, rotary: Floats) -> None:
    """Fill in the rotary positions (n, 2) at poles (n,): the first joint turns evenly between both sides."""
    from toolpace.kernels.kinematics import poles

    axis, tip = np.ascontiguousarray(toolpath.axis), np.ascontiguousarray(toolpath.tip)
    travel = np.ascontiguousarray(geometry.travel[geometry.rotary])
    poles.settle_poles(geometry.frame, axis, tip, pole, travel, pole_tolerance, rotary)


def _fixed(geometry: Geometry, toolpath: ToolPath, solutions: Floats, points: Ints) -> Floats:
    """Rotary positions (k, 2) at the points that are no poles."""
    from toolpace.kernels.kinematics import branches

    travel = np.ascontiguousarray(geometry.travel[geometry.rotary])
    endless: Bools = np.asarray(np.isinf(travel[:, 0]) | np.isinf(travel[:, 1]))
    penalty = _penalty(geometry, toolpath, solutions, points, travel, endless)
    first_turn, slots = _turns(solutions, travel, endless)
    chosen, jumps = np.empty((len(points), 2)), np.zeros(len(points), dtype=np.bool_)
    bridged = np.diff(points, prepend=points[0] - 1) > 1
    ways = np.isinf(toolpath.feed[: points[-1] + 1])
    rapid: Bools = np.asarray(np.logical_or.reduceat(ways, np.r_[0, points[:-1] + 1]), dtype=np.bool_)
    axis = np.ascontiguousarray(toolpath.axis[points])
    path = branches.Points(axis, solutions, penalty, bridged, rapid)
    branches.choose(geometry.frame, path, branches.Turns(travel, endless, first_turn, slots), chosen, jumps)
    cut = jumps & ~rapid
    if cut.any():
        at = int(np.argmax(cut))
        blocks = int(toolpath.block[points[at - 1]]), int(toolpath.block[points[at]])
        raise rotary_jump(geometry, chosen[at - 1], chosen[at], blocks, toolpath.source)
    return chosen


def _penalty(
    geometry: Geometry, toolpath: ToolPath, solutions: Floats, points: Ints, travel: Floats, endless: Bools
) -> Floats:
    """(k, 2) inf where a solution lies outside rotary travel; a cost where a linear joint leaves its own."""
    penalty = np.zeros(solutions.shape[:2])
    for joint in range(2):
        if not endless[joint]:
            low, high = travel[joint]
            # The lowest position at or above the lower end; a hair below it counts as on it.
            lowest = low + np.mod(solutions[:, :, joint] - low + 1e-9, math.tau) - 1e-9
            penalty[lowest > high + 1e-9] = np.inf
    out = np.isinf(penalty).all(axis=1)
    if out.any():
        first = int(np.argmax(out))
        raise tilt_out_of_travel(geometry, solutions[first], int(toolpath.block[points[first]]), toolpath.source)
    tip = np.ascontiguousarray(toolpath.tip[points])
    for side in range(2):
        try:
            q = kinematics.joints_at(geometry, tip, solutions[:, side])
        except ReachError:
            continue
        inside = (q >= geometry.travel[:, 0] - 1e-9) & (q <= geometry.travel[:, 1] + 1e-9)
        penalty[~inside[:, geometry.linear].all(axis=1), side] += TRAVEL_PENALTY
    return penalty


def _turns(solutions: Floats, travel: Floats, endless: Bools) -> tuple[Ints, Ints]:
    """First whole turn (2,) and number of turns (2,) to consider; no more than the path can use."""
    first, slots = np.zeros(2, dtype=np.int64), np.ones(2, dtype=np.int64)
    for joint in range(2):
        if endless[joint]:
            continue
        low = math.ceil((travel[joint, 0] - math.pi) / math.tau - 1e-9)
        high = math.floor((travel[joint, 1] + math.pi) / math.tau + 1e-9)
        used = max(float(np.ptp(np.unwrap(solutions[:, side, joint]))) for side in range(2))
        most = math.ceil(used / math.tau) + 2
        centre = min(max(0, low), high)
        low, high = max(low, centre - most), min(high, centre + most)
        first[joint], slots[joint] = low, high - low + 1
    return first, slots


def rotary_between(
    geometry: Geometry, toolpath: ToolPath, fixed: Ints, rotary: Floats, pole_tolerance: float = POLE_TOLERANCE
) -> Floats:
    """Rotary positions (n, 2) [rad] along a tool path, those (k, 2) at its points `fixed` (k,) having been chosen.

    `fixed` ascends from the first point to the last. At the pole the first joint turns evenly between its values on
    both sides, as in the choice. Raises ReachError where the branch does not hold between the known points: where a
    joint leaves its travel, or the rotary joints would have to jump while cutting.
    """
    solutions, pole = solutions_along(geometry, toolpath, pole_tolerance)
    at = np.arange(len(toolpath))
    cell = np.clip(np.searchsorted(fixed, at, side="right") - 1, 0, max(len(fixed) - 2, 0))
    after = np.minimum(cell + 1, len(fixed) - 1)
    # At the pole the first joint is free, and says nothing about the solution: what lies next to it does.
    left = np.where(pole[fixed[cell]] & ~pole[fixed[after]], after, cell)
    right = np.where(pole[fixed[after]] & ~pole[fixed[cell]], cell, after)
    share = (at - fixed[cell]) / np.maximum(fixed[after] - fixed[cell], 1)
    even = rotary[left] + share[:, None] * (rotary[right] - rotary[left])
    unwound = solutions + math.tau * np.round((even[:, None] - solutions) / math.tau)
    taken = nearest_solution(solutions[fixed], rotary)
    side = taken[left]
    for k in np.unique(cell[taken[left] != taken[right]]):
        inner = slice(int(fixed[k]) + 1, int(fixed[k + 1]))
        side[inner] = _least_motion(unwound[inner], rotary[k : k + 2], int(taken[k]), int(taken[k + 1]))
    chosen = np.ascontiguousarray(unwound[at, side])
    chosen[fixed] = rotary
    settle(geometry, toolpath, pole, pole_tolerance, chosen)
    _check_jumps(geometry, toolpath, pole, chosen)
    check_travel(geometry, kinematics.joints_at(geometry, toolpath.tip, chosen), toolpath.block, toolpath.source)
    return chosen


def turn_between(geometry: Geometry, axis: Floats, pole_tolerance: float = POLE_TOLERANCE) -> Floats:
    """(n - 1,) most turn of a rotary joint from one tool axis (n, 3) to the next on either solution [rad].

    Where the axis passes close to its pole, the first rotary joint turns far on a short way, and between points far
    apart the other solution looks nearer. A choice is sound where all these turns are small. From a pole to a point
    off it the first joint may turn by as much as the axis moves, in pole tolerances; from pole to pole it is free.
    """
    solutions, pole = kinematics.rotary_solutions(geometry, axis, pole_tolerance)
    turn = np.abs(np.remainder(np.diff(solutions, axis=0) + np.pi, math.tau) - np.pi).max(axis=(1, 2), initial=0.0)
    chord = np.linalg.norm(np.diff(axis, axis=0), axis=1)
    turn = np.where(pole[1:] | pole[:-1], np.minimum(chord / pole_tolerance, np.pi), turn)
    return np.where((pole[1:] & pole[:-1]) | np.isnan(turn), 0.0, turn)


def nearest_solution(solutions: Floats, rotary: Floats) -> Ints:
    """(n,) 0 or 1: which of both solutions (n, 2, 2) the rotary positions (n, 2) are, whatever the turn."""
    off = np.abs(np.remainder(rotary[:, None] - solutions + np.pi, math.tau) - np.pi).sum(axis=2)
    return np.asarray(off[:, 1] < off[:, 0], dtype=np.int64)


def _least_motion(unwound: Floats, ends: Floats, before: int, after: int) -> Ints:
    """Solution (m,) of the points between two `ends` (2, 2), from `before` to `after` at the place of least motion.

    Of equal places the middle one is taken.
    """
    count = len(unwound)
    place = np.arange(count + 1)
    side = np.where(np.arange(count) < place[:, None], before, after)
    ways = np.empty((count + 1, count + 2, 2))
    ways[:, 0], ways[:, -1] = ends
    ways[:, 1:-1] = unwound[np.arange(count), side]
    motion = np.abs(np.diff(ways, axis=1)).sum(axis=(1, 2))
    least = np.flatnonzero(motion <= motion.min() + EQUAL)
    return np.asarray(side[least[len(least) // 2]], dtype=np.int64)


def _check_jumps(geometry: Geometry, toolpath: ToolPath, pole: Bools, rotary: Floats) -> None:
    """Raise ReachError where joints moving in proportion leave the great circle while cutting, no pole at hand."""
    axis = toolpath.axis
    between = axis[1:] + axis[:-1]
    between /= np.maximum(np.linalg.norm(between, axis=1), 1e-12)[:, None]
    middle = kinematics.axis_at(geometry, 0.5 * (rotary[1:] + rotary[:-1]))
    off = np.linalg.norm(middle - between, axis=1)
    chord = np.linalg.norm(np.diff(axis, axis=0), axis=1)
    jump = (off > chord + STRAY) & np.isfinite(toolpath.feed[1:]) & ~pole[1:] & ~pole[:-1]
    if jump.any():
        at = int(np.argmax(jump))
        blocks = int(toolpath.block[at]), int(toolpath.block[at + 1])
        raise rotary_jump(geometry, rotary[at], rotary[at + 1], blocks, toolpath.source)
