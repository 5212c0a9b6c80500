"""Inverse kinematics between points whose solution is already chosen, on the same branch.

Away from its pole and from the edge of reach a solution is a continuous function of the tool axis. So between two
points on one solution that solution is meant. Between two points on different ones the solutions change at the pole
or at the edge of reach: where the joints move least on the whole.
"""

from __future__ import annotations

import math

import numpy as np

from toolpace.common.arrays import Bools, Floats, Ints
from toolpace.machine import kinematics
from toolpace.machine.geometry import Geometry
from toolpace.machine.inverse import POLE_TOLERANCE, settle, solutions_along
from toolpace.machine.unreachable import check_travel, rotary_jump
from toolpace.programs.toolpath import ToolPath

TURN = 2.0 * math.pi
EQUAL = 1e-9
"""Ways of the joints that differ by less count as equal [rad]."""
STRAY = 1e-3
"""How far joints that move in proportion may leave the great circle beside its length, as in the choice [rad]."""


def rotary_between(
    geometry: Geometry, toolpath: ToolPath, known: Ints, rotary: Floats, pole_tolerance: float = POLE_TOLERANCE
) -> Floats:
    """Rotary positions (n, 2) [rad] along a tool path, those (k, 2) at its points `known` (k,) having been chosen.

    `known` ascends from the first point to the last. At the pole the first joint turns evenly between its values on
    both sides, as in the choice. Raises ReachError where the branch does not hold between the known points: where a
    joint leaves its travel, or the rotary joints would have to jump while cutting.
    """
    solutions, pole = solutions_along(geometry, toolpath, pole_tolerance)
    at = np.arange(len(toolpath))
    cell = np.clip(np.searchsorted(known, at, side="right") - 1, 0, max(len(known) - 2, 0))
    after = np.minimum(cell + 1, len(known) - 1)
    # At the pole the first joint is free, and says nothing about the solution: what lies next to it does.
    left = np.where(pole[known[cell]] & ~pole[known[after]], after, cell)
    right = np.where(pole[known[after]] & ~pole[known[cell]], cell, after)
    share = (at - known[cell]) / np.maximum(known[after] - known[cell], 1)
    even = rotary[left] + share[:, None] * (rotary[right] - rotary[left])
    unwound = solutions + TURN * np.round((even[:, None] - solutions) / TURN)
    taken = nearest_solution(solutions[known], rotary)
    side = taken[left]
    for k in np.unique(cell[taken[left] != taken[right]]):
        inner = slice(int(known[k]) + 1, int(known[k + 1]))
        side[inner] = _least_motion(unwound[inner], rotary[k : k + 2], int(taken[k]), int(taken[k + 1]))
    chosen = np.ascontiguousarray(unwound[at, side])
    chosen[known] = rotary
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
    turn = np.abs(np.remainder(np.diff(solutions, axis=0) + np.pi, TURN) - np.pi).max(axis=(1, 2), initial=0.0)
    chord = np.linalg.norm(np.diff(axis, axis=0), axis=1)
    turn = np.where(pole[1:] | pole[:-1], np.minimum(chord / pole_tolerance, np.pi), turn)
    return np.where((pole[1:] & pole[:-1]) | np.isnan(turn), 0.0, turn)


def nearest_solution(solutions: Floats, rotary: Floats) -> Ints:
    """(n,) 0 or 1: which of both solutions (n, 2, 2) the rotary positions (n, 2) are, whatever the turn."""
    off = np.abs(np.remainder(rotary[:, None] - solutions + np.pi, TURN) - np.pi).sum(axis=2)
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
