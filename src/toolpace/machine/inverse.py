"""The rotary joint positions along a whole tool path: which solution, which turn, what to do at the pole."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from toolpace.arrays import Bools, Floats, Ints
from toolpace.errors import ReachError
from toolpace.machine.refusals import check_travel, place, tilt_out_of_travel, unreachable_tilt
from toolpace.toolpath import ToolPath

if TYPE_CHECKING:
    from toolpace.machine.machine import Machine


TURN = 2.0 * math.pi
TRAVEL_PENALTY = 1e5
"""Cost of a point at which a linear joint would leave its travel; far below that of a jump while cutting."""


def choose_rotary(machine: Machine, toolpath: ToolPath, pole_tolerance: float = 1e-4) -> Floats:
    """Rotary positions (n, 2) [rad], unwound, in the order of `machine.rotary`.

    A program that names the rotary positions itself is taken at its word. Otherwise the least rotary motion
    is chosen among both solutions and all turns within travel. Where the tool axis comes within
    `pole_tolerance` [rad] of the pole, the first joint is free: it turns evenly between its values on both
    sides, and the axis may be off by up to that tolerance (rounded programs scatter about the pole by as
    much). Raises ReachError.
    """
    given = _given(machine, toolpath)
    if given is None:
        given = _chosen(machine, toolpath, pole_tolerance)
    check_travel(machine, machine.joints_at(toolpath.tip, given), toolpath.block, toolpath.source)
    return given


def _given(machine: Machine, toolpath: ToolPath) -> Floats | None:
    names = [machine.joints[joint] for joint in machine.rotary]
    if toolpath.rotary is None or set(toolpath.rotary_joints) != set(names):
        return None
    return np.ascontiguousarray(toolpath.rotary[:, [toolpath.rotary_joints.index(name) for name in names]])


def _chosen(machine: Machine, toolpath: ToolPath, pole_tolerance: float) -> Floats:
    from toolpace.kernels.kinematics import poles

    axis = np.ascontiguousarray(toolpath.axis)
    frame, travel = machine.geometry.frame, np.ascontiguousarray(machine.travel[machine.rotary])
    solutions, pole = machine.rotary_solutions(axis, pole_tolerance)
    lost = np.isnan(solutions).any(axis=(1, 2))
    if lost.any():
        first = int(np.argmax(lost))
        raise unreachable_tilt(machine, axis[first], int(toolpath.block[first]), toolpath.source)
    rotary = np.empty((len(axis), 2))
    points = np.flatnonzero(~pole)
    if len(points):
        rotary[points] = _fixed(machine, toolpath, solutions[points], points)
    poles.settle_poles(frame, axis, np.ascontiguousarray(toolpath.tip), pole, travel, pole_tolerance, rotary)
    return rotary


def _fixed(machine: Machine, toolpath: ToolPath, solutions: Floats, points: Ints) -> Floats:
    """Rotary positions (k, 2) at the points that are no poles."""
    from toolpace.kernels.kinematics import branches, states

    travel = np.ascontiguousarray(machine.travel[machine.rotary])
    endless: Bools = np.asarray(np.isinf(travel[:, 0]) | np.isinf(travel[:, 1]))
    penalty = _penalty(machine, toolpath, solutions, points, travel, endless)
    first_turn, slots = _turns(solutions, travel, endless)
    chosen, jumps = np.empty((len(points), 2)), np.zeros(len(points), dtype=np.bool_)
    bridged = np.diff(points, prepend=points[0] - 1) > 1
    ways = np.isinf(toolpath.feed[: points[-1] + 1])
    rapid: Bools = np.asarray(np.logical_or.reduceat(ways, np.r_[0, points[:-1] + 1]), dtype=np.bool_)
    axis = np.ascontiguousarray(toolpath.axis[points])
    path = states.Points(axis, solutions, penalty, bridged, rapid)
    branches.choose(
        machine.geometry.frame, path, states.Turns(travel, endless, first_turn, slots), chosen, jumps
    )
    cut = jumps & ~rapid
    if cut.any():
        raise _broken(machine, toolpath, points, chosen, int(np.argmax(cut)))
    return chosen


def _penalty(
    machine: Machine, toolpath: ToolPath, solutions: Floats, points: Ints, travel: Floats, endless: Bools
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
        raise tilt_out_of_travel(machine, solutions[first], int(toolpath.block[points[first]]), toolpath.source)
    tip = np.ascontiguousarray(toolpath.tip[points])
    for side in range(2):
        try:
            q = machine.joints_at(tip, solutions[:, side])
        except ReachError:
            continue
        inside = (q >= machine.travel[:, 0] - 1e-9) & (q <= machine.travel[:, 1] + 1e-9)
        penalty[~inside[:, machine.linear].all(axis=1), side] += TRAVEL_PENALTY
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


def _broken(machine: Machine, toolpath: ToolPath, points: Ints, chosen: Floats, at: int) -> ReachError:
    names = [machine.joints[joint] for joint in machine.rotary]
    before, after = np.degrees(chosen[at - 1]), np.degrees(chosen[at])
    travel = ", ".join(
        f"{name} {math.degrees(low):g} .. {math.degrees(high):g} deg"
        for name, (low, high) in zip(names, machine.travel[machine.rotary])
        if math.isfinite(low)
    )
    line = int(toolpath.block[points[at]])
    return ReachError(
        f"{place(toolpath.source, line)}the rotary joints run out of travel ({travel}): between lines "
        f"{int(toolpath.block[points[at - 1]])} and {line} they would have to jump from "
        f"{names[0]} {before[0]:.3f} {names[1]} {before[1]:.3f} to {names[0]} {after[0]:.3f} {names[1]} "
        f"{after[1]:.3f} deg while cutting; split the program there with a retract (rapid), or give the "
        "joint more travel, or wrap = true"
    )
