"""Rotary joint positions along a tool path: the choice of solution, of turns, and of positions at the pole."""

from __future__ import annotations

import math

import numpy as np

from toolpace.common.arrays import Bools, Floats, Ints
from toolpace.common.errors import ReachError
from toolpace.machine import kinematics
from toolpace.machine.geometry import Geometry
from toolpace.machine.unreachable import check_travel, rotary_jump, tilt_out_of_travel, unreachable_tilt
from toolpace.programs.toolpath import ToolPath

TURN = 2.0 * math.pi
POLE_TOLERANCE = 1e-4
"""Angle to the pole within which the first joint of a program's axis is free [rad]: axes written with four decimals."""
TRAVEL_PENALTY = 1e5
"""Cost of a point at which a linear joint would leave its travel; far below that of a jump while cutting."""


def choose_rotary(geometry: Geometry, toolpath: ToolPath, pole_tolerance: float = POLE_TOLERANCE) -> Floats:
    """Rotary positions (n, 2) [rad], unwound, in the order of `geometry.rotary`.

    A program that names the rotary positions itself is taken at its word. Otherwise the least rotary motion
    is chosen among both solutions and all turns within travel. Where the tool axis comes within
    `pole_tolerance` [rad] of the pole, the first joint is free: it turns evenly between its values on both
    sides, and the axis may be off by up to that tolerance (rounded programs scatter about the pole by as
    much). Raises ReachError.
    """
    given = _given(geometry, toolpath)
    if given is None:
        given = _chosen(geometry, toolpath, pole_tolerance)
    check_travel(geometry, kinematics.joints_at(geometry, toolpath.tip, given), toolpath.block, toolpath.source)
    return given


def _given(geometry: Geometry, toolpath: ToolPath) -> Floats | None:
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
            lowest = low + np.mod(solutions[:, :, joint] - low + 1e-9, TURN) - 1e-9
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
        low = math.ceil((travel[joint, 0] - math.pi) / TURN - 1e-9)
        high = math.floor((travel[joint, 1] + math.pi) / TURN + 1e-9)
        used = max(float(np.ptp(np.unwrap(solutions[:, side, joint]))) for side in range(2))
        most = math.ceil(used / TURN) + 2
        centre = min(max(0, low), high)
        low, high = max(low, centre - most), min(high, centre + most)
        first[joint], slots[joint] = low, high - low + 1
    return first, slots
