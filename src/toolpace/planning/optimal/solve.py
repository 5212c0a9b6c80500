"""Solutions of a problem by the interior-point kernel, with restarts, reliefs, and continuation in boundary speeds.

Continuation, where a solve between ends in motion fails:

k times the speed:  z, z' and z'' are k^2 times as much, jerk is k^3 times as much;  slow enough, all is within limits
  k <- so slow that a start is well within all limits
  repeat until k = 1
      the ends at k times their speed:  solve, from the last answer at the new speed
      found: k grows, to twice as much at most;   not found: it grows by less

Limits that depend on the speed are made linear at the speeds of the start, from inside; then at those of what is found,
until that takes no less time (successive convex approximation; Marks and Wright 1978).
"""

from __future__ import annotations

from collections.abc import Iterator
from copy import copy
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.kernels.motion import cubic_spline
from toolpace.kernels.optimal import limit_rows, newton, solver
from toolpace.planning.optimal.problem import OnMesh, Problem

TOLERANCE = 1e-6
"""Gap and gradient at which a solve ends, relative to the duration."""
GOOD_ENOUGH = 1e-4
"""Gap up to which a solve that ended by rounding is not tried again."""
ACCEPTABLE = 3e-3
"""Gap up to which the best of several such solves is taken."""
STEEP = 0.1
"""Weight of the scaled gradient beside the gap, where either tells how far a point is from the optimum."""
AGREE = 1e-7
"""Relative difference of the times up to which two such solves, from different starts, have found the same optimum:
on a very fine mesh the gradient is rounding."""
BROKEN_BY = 1e-6
"""Usage beyond 1 of such a solve; what is more is seen between the nodes and mended there."""
MOST_STEPS = 400
"""Where jerk alone holds a run, next to no velocity limit does, and nodes are close, steps are short for long:
positioning moves take 200 to 300. Ended before, the same is done again from three slower starts."""
MARGIN = 0.01
"""A start closer than this share to a limit has that limit relaxed at first."""
LIMITS = ("a velocity limit or the feed", "an acceleration limit", "a jerk limit")
"""What the columns of usage and of peaks are called."""
FASTER = 2.0
"""How many times as fast the ends become from one solve to the next, at most."""
GROWTH = 1.5
"""Power by which that grows after a solve that found a way; after one that did not, its root is taken."""
MOST_TRIES, MOST_IN_VAIN = 24, 4
"""Solves after which no way is looked for, in all and of those that found none: each may take its most steps."""
SETTLED, MOST_LINEAR = 1e-7, 30
"""Share of the time that a solve gains with limits made linear anew, below which the next would gain nothing, and the
most of such solves."""
LOSS, SPREAD = 0.03, 0.03
"""How a solve starts: the last answer, so much slower, and its first gap relative to the duration."""


class Stalled(Exception):
    """The core found no point within the limits; `place` is the parameter where one is broken most, `limit` its name.
    Or none near the optimum: `within` are coefficients of one that is far from it.

    Between two rests there always is such a point: a motion slow enough.
    """

    def __init__(self, place: float, limit: str, within: Floats | None = None) -> None:
        super().__init__(f"{limit} is exceeded near s = {place:.9g}")
        self.place, self.limit, self.within = place, limit, within


def start_from(mesh: OnMesh, s: Floats, z: Floats, share: float) -> Floats:
    """Coefficients of about `share` of the speeds z (k,) at s (k,), with the ends as they must be."""
    return pinned(mesh, share * np.interp(cubic_spline.control_points(mesh.nodes), s, z**0.75) ** (4.0 / 3.0))


def pinned(mesh: OnMesh, c: Floats) -> Floats:
    """The coefficients with those at the ends of the run as rest, or the state given there, asks for."""
    for k, (one, two) in enumerate(((0, 1), (-1, -2))):
        if mesh.end[k] == newton.REST:
            c[two] = c[one] * mesh.ratio[k]
        else:
            c[one], c[two] = mesh.fixed[0 if k == 0 else 3], mesh.fixed[1 if k == 0 else 2]
    return c


def slower(mesh: OnMesh, c: Floats, loss: float, taper: tuple[int, int] | None = None) -> Floats:
    """c with the share `loss` of z taken away, but less and less towards an end in motion, which stays as it is.

    `taper` gives the number of coefficients in which the loss comes and goes; half of the stretch without it.
    """
    far = np.arange(len(c), dtype=np.float64)
    length = taper or (len(c) // 2, len(c) // 2)
    share = np.ones(len(c))
    for k, distance in enumerate((far, far[::-1])):
        if mesh.end[k] == newton.MOVING:
            share = np.minimum(share, np.clip((distance - 1.0) / max(length[k], 1), 0.0, 1.0))
    return c * (1.0 - loss * share * share * (3.0 - 2.0 * share))


@dataclass(frozen=True)
class Attempt:
    """What one start came to."""

    c: Floats
    """(n + 2,) coefficients."""
    optimal: bool
    """Whether the method came to its end."""
    time: float = np.inf
    """The sum of weight / speed over the nodes [s]; like what follows, worked out where it did not."""
    open: float = 0.0
    """How far it is from the optimum: the gap, or a share of the gradient where that is more."""
    used: Floats | None = None
    """(points, 3) usage of cap, acceleration and jerk rows."""

    @property
    def holds(self) -> bool:
        """Whether it is within the limits."""
        return self.used is not None and bool(self.used.max() <= 1.0 + BROKEN_BY)


def solve(problem: Problem, c: Floats, spread: float, once: bool = False, idle: float = 0.0) -> Floats:
    """Coefficients of the fastest z, started from c with a first gap of `spread`. Raises Stalled.

    `once` and `idle` are as `solve_linear` has them. Limits that depend on the speed are made linear at the speeds of
    c, and then of what is found. Where limits fall with the speed it lies within them, and no solve but the first can
    end slower than it began. Where they rise it may lie outside, by the square of the change; the next solve mends it.
    """
    found = solve_linear(problem.about(c), c, spread, once, idle)
    if problem.lines is None:
        return found
    last = best = LinearSolution(found, problem.time(found), problem.exceeded_by(found))
    for _ in range(MOST_LINEAR):
        try:
            found = solve_linear(problem.about(last.c), slower(problem, last.c, LOSS), SPREAD, once=True)
        except Stalled:
            break
        before, last = last, LinearSolution(found, problem.time(found), problem.exceeded_by(found))
        best = min(best, last, key=lambda each: each.time * (1.0 + each.over))
        if last.time >= (1.0 - SETTLED) * before.time and last.over >= before.over - BROKEN_BY:
            break
    return best.c


class LinearSolution(NamedTuple):
    """What a solve found with limits that depend on the speed made linear."""

    c: Floats
    time: float
    """The sum of weight / speed over the nodes [s]."""
    over: float
    """By how much these limits themselves are exceeded, as a share of the largest."""


def solve_linear(problem: Problem, c: Floats, spread: float, once: bool = False, idle: float = 0.0) -> Floats:
    """Coefficients of the fastest z, started from c with a first gap of `spread`. Raises Stalled.

    A start from which the core does not come to its end is followed by slower ones, between two rests at last by one
    within all limits at the nodes, which is as good as the answer gets where the core does not move from it. `once`: by
    none, where something else can be tried. `idle`: limits of which the first start uses less all around a point
    are not held there, where what is found is looked at, and held in a further solve.
    """
    rests = bool((problem.end == newton.REST).all())
    attempts: list[Attempt] = []
    for begin, first_gap in starts_from(problem, c, spread, rests, once):
        attempt = attempted(problem, begin, first_gap, idle)
        idle = 0.0
        if attempt is None:
            continue
        if attempt.optimal:
            return attempt.c
        attempts.append(attempt)
        if attempt.holds and agreed([one for one in attempts if one.holds]):
            break
    holding = [attempt for attempt in attempts if attempt.holds and attempt.open < np.inf]
    best = min(holding, key=lambda attempt: attempt.open, default=None)
    if best is not None and (rests or best.open <= ACCEPTABLE):
        return best.c
    if best is None and rests and (begin > 0.0).all():
        return begin
    raise stalled(problem, attempts, None if best is None else best.c)


def starts_from(problem: Problem, c: Floats, spread: float, rests: bool, once: bool) -> Iterator[tuple[Floats, float]]:
    """Starts one after the other, with the first gap of each: c, and unless it is the only one, slower ones."""
    yield c, spread
    if once:
        return
    for loss in (0.6, 0.9):
        yield slower(problem, c, loss), 1.0
    if rests:
        yield well_inside(problem, c), 1.0


def attempted(problem: Problem, begin: Floats, first_gap: float, idle: float = 0.0) -> Attempt | None:
    """What the core makes of one start; None where z has fallen to nothing, which is no start."""
    relief = reliefs(problem, begin)
    if not np.isfinite(relief).all():
        return None
    solution = solver.maximise_speed(
        problem.as_points(), problem.as_ends(), begin.copy(), relief, first_gap, idle, TOLERANCE, MOST_STEPS
    )
    found, gap, gradient = solution.c, solution.gap, solution.gradient
    if solution.status == solver.OPTIMAL:
        return Attempt(found, optimal=True)
    used, z = limit_rows.usage(problem.as_points(), found)
    with np.errstate(invalid="ignore", divide="ignore"):
        time = float((problem.weight / np.sqrt(z)).sum())
    open_ = max(gap, STEEP * gradient)
    return Attempt(found, False, time, open_ if open_ < np.inf else np.inf, used)


def agreed(holding: list[Attempt]) -> bool:
    """Whether further starts would find nothing better: one is good enough, or the last two agree."""
    least = min(attempt.open for attempt in holding)
    times = [attempt.time for attempt in holding[-2:]]
    same = len(times) == 2 and abs(times[1] - times[0]) < AGREE * times[1]
    return least < GOOD_ENOUGH or (least < ACCEPTABLE and same)


def stalled(problem: Problem, attempts: list[Attempt], within: Floats | None) -> Stalled:
    """Where the last attempt passes a limit most; with what is within them, if there is anything."""
    used = attempts[-1].used if attempts else None
    if used is None:
        return Stalled(float(problem.nodes[0]), "some limit", within)
    worst, kind = divmod(int(np.argmax(used)), used.shape[1])
    return Stalled(float(problem.nodes[problem.node[worst]]), LIMITS[kind], within)


def well_inside(problem: Problem, c: Floats) -> Floats:
    """The coefficients lowered together until half of every limit is left, which two rests allow; zeros where z is."""
    used = row_usage(problem, c)
    if not np.isfinite(used).all():
        return np.zeros(len(c))
    cap, acceleration, jerk = used.max(axis=0)
    inside: Floats = c / (2.0 * max(cap, acceleration, jerk ** (2.0 / 3.0), 0.5))
    return inside


def row_usage(problem: Problem, c: Floats) -> Floats:
    """(points, 3) largest value over limit of cap, acceleration and jerk rows; c (n,); infinite where z <= 0."""
    return limit_rows.usage(problem.as_points(), c)[0]


def reliefs(problem: Problem, c: Floats) -> Floats:
    """(points, 3) by how much cap, acceleration and jerk rows must be relaxed for c to lie inside them."""
    used, z = limit_rows.usage(problem.as_points(), c)
    natural = np.stack([problem.cap, np.ones_like(z), 1.0 / np.sqrt(np.maximum(z, 1e-300))], axis=1)
    relief: Floats = relief_of(used) * natural
    return relief


def relief_of(used: Floats) -> Floats:
    """By how much a limit that is used so much must be relaxed, relative to it."""
    excess = used - (1.0 - MARGIN)
    relief: Floats = np.where(excess > 0.0, 1.5 * excess + MARGIN, 0.0)
    return relief


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
    inside = well_inside(problem.about(begin), begin)
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
    attempt = attempted(with_ends_at(problem, speed).about(start), start, first_gap)
    return attempt.c if attempt is not None and (attempt.optimal or attempt.holds) else None


def with_ends_at(problem: Problem, speed: float) -> Problem:
    """The problem with its ends in motion at this share of their speed."""
    part = copy(problem)
    part.fixed = problem.fixed * speed**2
    return part
