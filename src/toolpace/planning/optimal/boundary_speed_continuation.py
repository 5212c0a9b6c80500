"""Continuation in the boundary speeds, where a solve between ends in motion fails.

k times the speed:  z, z' and z'' are k^2 times as much, jerk is k^3 times as much;  slow enough, all is within limits
  k <- so slow that a start is well within all limits
  repeat until k = 1
      the ends at k times their speed:  solve, from the last answer at the new speed
      found: k grows, to twice as much at most;   not found: it grows by less
"""

from __future__ import annotations

from copy import copy

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.planning.optimal.problem import Problem
from toolpace.planning.optimal.solve import Stalled, attempted, pinned, slower, solve, well_inside

FASTER = 2.0
"""How many times as fast the ends become from one solve to the next, at most."""
GROWTH = 1.5
"""Power by which that grows after a solve that found a way; after one that did not, its root is taken."""
MOST_TRIES, MOST_IN_VAIN = 24, 4
"""Solves after which no way is looked for, in all and of those that found none: each may take its most steps."""
LOSS, SPREAD = 0.03, 0.03
"""How a solve starts: the last answer, so much slower, and its first gap relative to the duration."""


def solve_whole(problem: Problem, c: Floats, spread: float, idle: float = 0.0) -> Floats:
    """Coefficients of the fastest z of a run as a whole, as `solve` finds them. Raises Stalled.

    With an end in motion, what is within the limits counts however far from the optimum it is, since nothing slower
    would be: the way to the end would be another one.
    """
    try:
        return solve(problem, c, spread, idle=idle)
    except Stalled as stall:
        found = from_lower_boundary_speeds(problem, c) if stall.within is None else stall.within
        if found is None:
            raise
        return found


def from_lower_boundary_speeds(problem: Problem, c: Floats) -> Floats | None:
    """Coefficients within the limits, by a start c; None where no way was found."""
    begin = pinned(problem, c.copy())
    inside = well_inside(problem, begin)
    if not (inside > 0.0).all():
        return None
    speed, faster = float(np.sqrt(inside.max() / begin.max())), FASTER
    now, in_vain = found_at(problem, speed, inside, 1.0), 0
    for _ in range(MOST_TRIES):
        if now is None or speed == 1.0 or in_vain == MOST_IN_VAIN:
            break
        wanted = min(speed * faster, 1.0)
        scale = (wanted / speed) ** 2
        found = found_at(problem, wanted, slower(problem, scale * now, LOSS + 1.0 - 1.0 / scale), SPREAD)
        if found is None:
            faster, in_vain = faster**0.5, in_vain + 1
        else:
            now, speed, faster = found, wanted, min(faster**GROWTH, FASTER)
    return now if speed == 1.0 else None


def found_at(problem: Problem, speed: float, start: Floats, first_gap: float) -> Floats | None:
    """Coefficients within the limits with the ends at this share of their speed; None where none were found."""
    attempt = attempted(with_ends_at(problem, speed), start, first_gap)
    return attempt.c if attempt is not None and (attempt.optimal or attempt.holds) else None


def with_ends_at(problem: Problem, speed: float) -> Problem:
    """The problem with its ends in motion at this share of their speed."""
    part = copy(problem)
    part.fixed = problem.fixed * speed**2
    return part
