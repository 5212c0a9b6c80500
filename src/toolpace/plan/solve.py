"""Solving a problem, or a stretch of it, with the interior-point core."""

from __future__ import annotations

import itertools
import os
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import numpy.typing as npt

from toolpace.kernels import cubic, speed
from toolpace.plan.problem import Problem

Floats = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]

TOLERANCE = 1e-6
"""Gap and gradient at which a solve ends, relative to the duration."""
ACCEPTABLE = 1e-2
"""Gap up to which a solve that stalled inside the limits is taken all the same."""
BROKEN_BY = 1e-6
"""Usage beyond 1 of such a solve; what is more is seen between the nodes and mended there."""
MOST_STEPS = 250
MARGIN = 0.01
"""A start closer than this share to a limit has that limit relaxed at first."""
MARGIN_NODES = 60
"""Nodes on either side of a mended place that may move with it."""
LONGEST = 12_000
"""Nodes up to which a run is solved in one piece."""
WINDOW = 8_000
SEAM = 600
"""Nodes of a window, and on either side of a seam between two."""
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
    c: Floats = share * np.interp(cubic.control_points(problem.nodes), s, z**0.75) ** (4.0 / 3.0)
    for k, (one, two) in enumerate(((0, 1), (-1, -2))):
        if problem.end[k] == speed.REST:
            c[two] = c[one] * problem.ratio[k]
        else:
            c[one], c[two] = problem.fixed[0 if k == 0 else 3], problem.fixed[1 if k == 0 else 2]
    return c


def solve(problem: Problem, c: Floats, spread: float) -> Floats:
    """Coefficients of the fastest z, started from c with a first gap of `spread`. Raises Stalled."""
    c, status, _, gap, _ = speed.maximise_speed(
        problem.basis, problem.node, problem.weight, problem.cap, problem.rows, c.copy(), reliefs(problem, c),
        problem.end, problem.ratio, spread, TOLERANCE, MOST_STEPS,
    )  # fmt: skip
    if status != speed.OPTIMAL:
        used = usage(problem, c).max(axis=1)
        if not (used.max() <= 1.0 + BROKEN_BY and gap < ACCEPTABLE):
            raise Stalled(float(problem.nodes[problem.node[int(np.argmax(used))]]))
    return c


def solve_long(problem: Problem, c: Floats, spread: float) -> Floats:
    """As `solve`, but a long run window by window, on all cores.

    What happens at one place of a run is of no matter further away than the machine needs to stop and start again.
    So the windows are solved with their borders left as they start, slow; then a wide stretch over each border is
    solved, between nodes that are at their best already.
    """
    last = len(problem.nodes) - 1
    if last <= LONGEST:
        return solve(problem, c, spread)
    border = [int(b) for b in np.linspace(0, last, int(np.ceil(last / WINDOW)) + 1)]
    inner = mend(problem, c, list(itertools.pairwise(border)), 0.0, spread)
    seams = [(b - SEAM, b + SEAM) for b in border[1:-1]]
    return mend(problem, inner, seams, SEAM_LOSS, SEAM_LOSS)


def usage(problem: Problem, c: Floats) -> Floats:
    """(points, 3) largest value over limit of cap, acceleration and jerk rows; c (n,) with z > 0 at the points."""
    u = np.einsum("pij,pj->pi", problem.basis, c[problem.node[:, None] + np.arange(3)])
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


def stretches(cells: Bools) -> list[tuple[int, int]]:
    """First and last node of the stretches around the marked cells, MARGIN_NODES wider on either side, merged."""
    marked = np.flatnonzero(cells)
    if len(marked) == 0:
        return []
    low, high = marked - MARGIN_NODES, marked + 1 + MARGIN_NODES
    gap = np.flatnonzero(low[1:] > high[:-1] + 1)
    first = np.concatenate([[0], gap + 1])
    last = np.concatenate([gap, [len(marked) - 1]])
    return [(max(int(low[i]), 0), min(int(high[j]), len(cells))) for i, j in zip(first, last)]


def mend(problem: Problem, c: Floats, parts: list[tuple[int, int]], loss: float, spread: float) -> Floats:
    """Solve again within the given stretches of nodes only, all other coefficients staying as they are.

    Each stretch starts from c, slowed down by the share `loss` in its middle. Raises Stalled.
    """
    out = c.copy()

    def one(part: tuple[int, int]) -> None:
        low, high = part
        piece = problem.stretch(low, high)
        far = np.arange(high + 3 - low, dtype=np.float64)
        from_low = far if piece.end[0] == speed.MOVING else np.full(len(far), np.inf)
        from_high = far[::-1] if piece.end[1] == speed.MOVING else np.full(len(far), np.inf)
        inside = np.clip((np.minimum(from_low, from_high) - 1.0) / (0.5 * MARGIN_NODES), 0.0, 1.0)
        smooth = inside * inside * (3.0 - 2.0 * inside)
        mended = solve(piece, c[low : high + 3] * (1.0 - loss * smooth), spread)
        out[low + 2 : high + 1] = mended[2:-2]
        if piece.end[0] == speed.REST:
            out[low : low + 2] = mended[:2]
        if piece.end[1] == speed.REST:
            out[high + 1 : high + 3] = mended[-2:]

    with ThreadPoolExecutor(max_workers=os.cpu_count()) as pool:
        list(pool.map(one, parts))
    return out
