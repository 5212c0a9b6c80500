"""Solving a problem, or a stretch of it, with the interior-point core."""

from __future__ import annotations

import itertools
import os
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from toolpace.kernels import cubic, speed
from toolpace.plan.problem import Problem

Floats = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]

TOLERANCE = 1e-6
"""Gap and gradient at which a solve ends, relative to the duration."""
GOOD_ENOUGH = 1e-4
"""Gap up to which a solve that ended by rounding is not tried again."""
ACCEPTABLE = 3e-3
"""Gap up to which the best of several such solves is taken."""
STEEP = 0.1
"""Weight of the scaled gradient beside the gap, where either tells how far a point is from the optimum."""
BROKEN_BY = 1e-6
"""Usage beyond 1 of such a solve; what is more is seen between the nodes and mended there."""
MOST_STEPS = 250
MARGIN = 0.01
"""A start closer than this share to a limit has that limit relaxed at first."""
MEND_RAMPS = 7.0
"""How far a mended place may move its surroundings, in times in which an acceleration builds up."""
LEAST_LEFT = 0.7
"""Least share of a coefficient that mending leaves: limits move by little, and so must the motion."""
WIDER = 4.0
"""How much wider a stretch is made that finds no way."""
WINDOW = 8_000
"""Nodes that are solved in one piece, unless what joins two pieces would be wider."""
SEAM_RAMPS = 60.0
"""Half the width of the stretch over the seam between two windows."""
SEAM_LOSS = 0.1
MOST_MENDED = 0.3
"""Share of the nodes beyond which mending is no cheaper than solving anew."""


class Stalled(Exception):
    """The core found no point within the limits; `place` is the parameter where they are broken most."""

    def __init__(self, place: float) -> None:
        super().__init__(f"stuck near s = {place:.9g}")
        self.place = place


def start_from(problem: Problem, s: Floats, z: Floats, share: float) -> Floats:
    """Coefficients of about `share` of the speeds z (k,) at s (k,), with the ends as they must be."""
    return pinned(problem, share * np.interp(cubic.control_points(problem.nodes), s, z**0.75) ** (4.0 / 3.0))


def pinned(problem: Problem, c: Floats) -> Floats:
    """The coefficients with those at the ends of the run as rest, or the state given there, asks for."""
    for k, (one, two) in enumerate(((0, 1), (-1, -2))):
        if problem.end[k] == speed.REST:
            c[two] = c[one] * problem.ratio[k]
        else:
            c[one], c[two] = problem.fixed[0 if k == 0 else 3], problem.fixed[1 if k == 0 else 2]
    return c


def slower(problem: Problem, c: Floats, loss: float, taper: tuple[int, int] | None = None) -> Floats:
    """c with the share `loss` of z taken away, but less and less towards an end in motion, which stays as it is.

    `taper` gives the number of coefficients in which the loss comes and goes; half of the stretch without it.
    """
    far = np.arange(len(c), dtype=np.float64)
    length = taper or (len(c) // 2, len(c) // 2)
    share = np.ones(len(c))
    for k, distance in enumerate((far, far[::-1])):
        if problem.end[k] == speed.MOVING:
            share = np.minimum(share, np.clip((distance - 1.0) / max(length[k], 1), 0.0, 1.0))
    return c * (1.0 - loss * share * share * (3.0 - 2.0 * share))


def solve(problem: Problem, c: Floats, spread: float) -> Floats:
    """Coefficients of the fastest z, started from c with a first gap of `spread`. Raises Stalled.

    A start from which the core does not come to its end is followed by slower ones.
    """
    best: Floats | None = None
    least, place = np.inf, 0.0
    for loss, first_gap in ((0.0, spread), (0.6, 1.0), (0.9, 1.0)):
        begin = slower(problem, c, loss)
        found, status, _, gap, gradient = speed.maximise_speed(
            problem.basis, problem.node, problem.weight, problem.cap, problem.rows, begin.copy(),
            reliefs(problem, begin), problem.end, problem.ratio, first_gap, TOLERANCE, MOST_STEPS,
        )  # fmt: skip
        if status == speed.OPTIMAL:
            optimum: Floats = found
            return optimum
        used = usage(problem, found).max(axis=1)
        place = float(problem.nodes[problem.node[int(np.argmax(used))]])
        if used.max() <= 1.0 + BROKEN_BY and max(gap, STEEP * gradient) < least:
            best, least = found, max(gap, STEEP * gradient)
        if least < GOOD_ENOUGH:
            break
    if best is None or least > ACCEPTABLE:
        raise Stalled(place)
    return best


def solve_long(problem: Problem, c: Floats, spread: float) -> Floats:
    """As `solve`, but a long run window by window, on all cores.

    What happens at one place of a run is of no matter further away than the machine needs to stop and start again.
    So the windows are solved with their borders left as they start, slow; then a wide stretch over each border is
    solved, between nodes that are at their best already.
    """
    last = len(problem.nodes) - 1
    if last <= 1.5 * WINDOW:
        return solve(problem, c, spread)
    border = [int(b) for b in np.linspace(0, last, int(np.ceil(last / WINDOW)) + 1)]
    seams = [Stretch(*problem.around(b, b, SEAM_RAMPS), b, b) for b in border[1:-1]]
    if any(left.high >= right.low for left, right in itertools.pairwise(seams)):
        return solve(problem, c, spread)
    inner, _ = mend(problem, c, [Stretch(a, b, a, b) for a, b in itertools.pairwise(border)], 0.0, spread, least=0.0)
    return mend(problem, inner, seams, SEAM_LOSS, SEAM_LOSS, least=0.0)[0]


def usage(problem: Problem, c: Floats) -> Floats:
    """(points, 3) largest value over limit of cap, acceleration and jerk rows; c (n,) with z > 0 at the points."""
    u = np.einsum("pij,pj->pi", problem.basis, c[problem.node[:, None] + np.arange(3)])
    if not (u[:, 0] > 0.0).all():
        return np.full((len(u), 3), np.inf)
    half = problem.rows.shape[1] // 2
    value = np.abs(np.einsum("pri,pi->pr", problem.rows, u))
    jerk = value[:, half:].max(axis=1) * np.sqrt(u[:, 0])
    return np.stack([u[:, 0] / problem.cap, value[:, :half].max(axis=1), jerk], axis=1)


def reliefs(problem: Problem, c: Floats) -> Floats:
    """(points, 3) by how much cap, acceleration and jerk rows must be relaxed for c to lie inside them."""
    z = np.einsum("pj,pj->p", problem.basis[:, 0], c[problem.node[:, None] + np.arange(3)])
    natural = np.stack([problem.cap, np.ones_like(z), 1.0 / np.sqrt(z)], axis=1)
    excess = usage(problem, c) - (1.0 - MARGIN)
    relief: Floats = np.where(excess > 0.0, 1.5 * excess + MARGIN, 0.0) * natural
    return relief


class Stretch(NamedTuple):
    """Nodes `low` to `high` that may move for the sake of the nodes `first` to `last` among them."""

    low: int
    high: int
    first: int
    last: int


def stretches(problem: Problem, cells: Bools, ramps: float = MEND_RAMPS) -> list[Stretch]:
    """The stretches around the marked cells, so much wider on either side as the motion takes `ramps` ramps for."""
    marked = np.flatnonzero(cells)
    if len(marked) == 0:
        return []
    merged: list[Stretch] = []
    for cell in marked:
        low, high = problem.around(int(cell), int(cell) + 1, ramps)
        if merged and low <= merged[-1].high + 1:
            merged[-1] = merged[-1]._replace(high=max(high, merged[-1].high), last=int(cell) + 1)
        else:
            merged.append(Stretch(low, high, int(cell), int(cell) + 1))
    return merged


def mend(
    problem: Problem, c: Floats, parts: list[Stretch], loss: float, spread: float, least: float = LEAST_LEFT
) -> tuple[Floats, list[Stretch]]:
    """Solve again within the given stretches of nodes only, all other coefficients staying as they are.

    Each stretch starts from c, slowed down by the share `loss` in its middle. The stretches are solved on all cores;
    one that finds no way, or leaves less than the share `least` of a coefficient, is solved once more, wider, when
    the others are done. Returns the coefficients and the
    stretches solved. Raises Stalled.
    """
    out = c.copy()
    stuck: list[Stretch] = []

    def one(part: Stretch) -> None:
        try:
            mend_one(problem, out, part, loss, spread, least)
        except Stalled:
            stuck.append(part)

    with ThreadPoolExecutor(max_workers=os.cpu_count()) as pool:
        list(pool.map(one, parts))
    wider = [Stretch(*problem.around(p.first, p.last, WIDER * MEND_RAMPS), p.first, p.last) for p in sorted(stuck)]
    for part in wider:
        mend_one(problem, out, part, max(loss, SEAM_LOSS), spread, least)
    return out, parts + wider


def mend_one(problem: Problem, c: Floats, part: Stretch, loss: float, spread: float, least: float) -> None:
    """Overwrite the coefficients that lie inside one stretch of nodes. Raises Stalled."""
    piece = problem.stretch(part.low, part.high)
    mine = c[part.low : part.high + 3]
    taper = part.first - part.low, part.high - part.last
    mended = solve(piece, slower(piece, mine, loss, taper) if loss else mine, spread)
    if least > 0.0 and (mended < least * mine).any():
        # the ends cannot be met within the limits: what the nodes show of it is a fall between them
        raise Stalled(float(piece.nodes[int(np.argmin(mended / mine).clip(0, len(piece.nodes) - 1))]))
    first = 0 if piece.end[0] == speed.REST else 2
    last = len(mended) - (0 if piece.end[1] == speed.REST else 2)
    c[part.low + first : part.low + last] = mended[first:last]
