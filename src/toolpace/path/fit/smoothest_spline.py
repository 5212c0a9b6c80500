"""The smoothest spline inside its tube, window by window, from a first one with knots where the tube needs them.

What happens at one place does not reach far along the path: windows with fixed ends, and then windows over their
seams, come as close to the answer for the whole as one wants, in linear time. Ranges of one stage are GAP apart: no
sample touches two of them, so each can be solved while the others change, and the result is the same on any number
of cores.

A smoothing spline that hardly smooths shows where knots are needed: where it leaves the inner part of the tube cells
are halved, and the spline is worked out again about these places, until it runs well inside everywhere.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from toolpace.common.arrays import Bools, Floats
from toolpace.common.errors import PathError
from toolpace.common.workers import UNTOLD, Progress, Workers
from toolpace.machine.machine import Machine
from toolpace.path.fit.polyline import Polyline
from toolpace.path.fit.spline import Samples, Spline, knots_of, sample

USED = 0.95
"""Share of the tolerance that the samples may use; what lies between takes some of the rest."""
ACCURACY = 0.002
"""Duality gap over roughness, in each stretch of 32 cells: slow stretches are those that take the time, and at ten
times as much a program of 25 operations took 0.3 percent longer."""
STEPS = 80
"""Newton steps of a range, at most; what is not done by then is taken where it lies inside its tube."""
WAVE = 500.0
"""Waves longer than so many cells are gently pulled towards the polyline, which keeps the Newton matrix regular."""
WINDOW = 2000
"""Coefficients of a window."""
SEAM = 250
"""Coefficients on either side of a seam that are worked on again."""
GAP = 5
"""Coefficients between the ranges of a stage."""
REACH = 25
"""Cells on either side of a place that are worked on with it."""

Range = tuple[int, int]
INSIDE = 0.6
"""Share of the tolerance within which the first spline must run."""
SMOOTHING = 0.01
"""Weight of the roughness in the first spline: it smooths what is shorter than a few tolerances."""
MOST_HALVINGS = 60
"""Rounds of halving after which there is no spline: each halves cells, so no cell can still be too long."""
PATIENCE = 8
"""Rounds after which cells beside those that are bad are halved with them: on a polygon each is nearly bad, and one
that is halved makes the next one bad, so that halving creeps along the path by one cell a round."""
NEARLY = 0.9
"""What is nearly bad, as a share of what is bad: a factor for each round from then on."""
SPACING = 20.0
"""Least distance of the first knots [tolerances]: curves that differ by less than a tolerance need no closer ones."""
RATIO = 2.5
"""Most ratio of the lengths of neighbouring cells."""
SHORTEST = 1e-4
"""Shortest cell [tolerances]."""


def tighten(
    spline: Spline,
    data: Samples,
    weight: Floats,
    least_third: float,
    radius: Floats,
    where: Floats | None,
    workers: Workers,
    progress: Progress,
    rows: tuple[Floats, Floats] | None = None,
) -> None:
    """Minimise the roughness of a spline inside the tube, in place.

    `rows` (cells, 3, 6) make the roughness of each cell, and it weighs (cells,): see `SpeedWeights.rows`. None: that of
    the third derivative, all cells alike.
    `least_third` is a third derivative [tolerances, at unit weight] that no axis would feel; `radius` (m,) the share
    of the tolerance that may be used at each sample. `where` names parameters about which alone to work; None is
    everywhere.
    """
    from toolpace.kernels.fit import smoothing_spline as kernel
    from toolpace.kernels.fit.quintic_spline import third_rows
    from toolpace.kernels.fit.smoothest import smoothest

    h = np.diff(spline.breaks)
    third, cells = rows or (third_rows(knots_of(spline.breaks)), np.ones(len(h)))
    floor = 0.5 * least_third**2 * h * cells
    groups = ((spline.tip, np.ones(3), data.tip), (spline.turn, weight, data.turn))

    def solve(which: int, part: Range) -> None:
        x, share, target = groups[which]
        low, high = part
        base, end = max(0, low - 5), min(len(x), high + 5)
        j = slice(*np.searchsorted(data.first, [low - 5, high]))
        metric = data.metrics(which, j)
        pull = (2.0 * np.pi / (WAVE * h[data.first[j]])) ** 6 * data.gap[j] * cells[data.first[j]]
        moved = x[base:end].copy()
        samples = kernel.Samples(data.first[j] - base, data.rows[j], target[j], metric)
        allowed = USED * radius[j] * data.room[j, which]
        steps, _, _ = smoothest(
            kernel.Roughness(third[base : end - 5], share), samples, kernel.Tube(allowed, pull), moved,
            kernel.Free(low - base, high - base), floor[base : end - 5], ACCURACY, STEPS,
        )  # fmt: skip
        if 0 <= steps < STEPS or np.all(data.off(j, moved, base, target, metric) <= 1.02 * allowed):
            x[low:high] = moved[low - base : high - base]

    solve_ranges(ranges(spline.breaks, where), solve, workers, progress)


def ranges(breaks: Floats, where: Floats | None) -> list[list[Range]]:
    """Ranges of coefficients, stage by stage: about the parameters `where`, or everywhere."""
    n = len(breaks) + 4
    return everywhere(n) if where is None else [near(n, np.searchsorted(breaks, where))]


def everywhere(n: int) -> list[list[Range]]:
    """Ranges that cover n coefficients but for the ends and the seams, and then those over the seams."""
    seams = np.linspace(0, n, max(1, round(n / WINDOW)) + 1).astype(int)
    seams[0], seams[-1] = 1, n - 1 + GAP
    whole = [(int(a), int(b) - GAP) for a, b in pairwise(seams)]
    return [whole, [(int(a) - SEAM, int(a) + SEAM) for a in seams[1:-1]]]


def near(n: int, cells: npt.NDArray[np.intp]) -> list[Range]:
    """Disjoint ranges of coefficients within REACH of the cells."""
    out: list[Range] = []
    for cell in np.unique(cells):
        low, high = max(1, int(cell) - REACH), min(n - 1, int(cell) + REACH + 5)
        if out and low < out[-1][1] + GAP:
            out[-1] = (out[-1][0], high)
        else:
            out.append((low, high))
    return out


def solve_ranges(
    stages: list[list[Range]], solve: Callable[[int, Range], None], workers: Workers, progress: Progress = UNTOLD
) -> None:
    """solve(0, range) for the tip and solve(1, range) for the turn, for all ranges, on all cores stage by stage."""
    jobs = [[(which, part) for part in stage for which in range(2)] for stage in stages]
    parts = progress.split([len(stage) for stage in jobs])
    for stage, reported in zip(jobs, parts):
        workers.each(lambda job: solve(*job), stage, reported)


def inside_spline(
    line: Polyline,
    breaks: Floats,
    weight: Floats,
    axis_tolerance: float,
    machine: Machine | None,
    look: Callable[[Spline, Floats], tuple[Floats, Floats]],
    workers: Workers,
) -> tuple[Spline, Samples]:
    """A spline well inside the tube, and its samples. `look` tells parameters and deviations between samples."""
    spline = near_polyline(line, breaks)
    data = sample(line, breaks, axis_tolerance, machine)
    where: Floats | None = None
    for k in range(MOST_HALVINGS):
        smooth_samples(spline, data, weight, where, workers)
        at, off = data.s, deviation(spline, data)
        if np.all(off <= INSIDE):
            # a spline with as many coefficients as samples obeys at the samples and swings between them
            at, off = look(spline, data.s)
        if np.all(off <= INSIDE):
            return spline, data
        bad = at[spreading(spline.breaks, at, off, INSIDE * NEARLY ** max(k - PATIENCE, 0))]
        finer = refined_at(line.s, spline.breaks, bad)
        where = finer[~np.isin(finer, spline.breaks)]
        spline = spline.over(finer)
        data = sample(line, finer, axis_tolerance, machine, previous=data)
    raise PathError("the program asks for a corner that no curve within the tolerance can follow")


def spreading(breaks: Floats, at: Floats, off: Floats, nearly: float) -> Bools:
    """Which places are bad, or in a row of cells, all of them above `nearly`, that holds a bad one."""
    bad = ~(off <= INSIDE)
    cell = np.clip(np.searchsorted(breaks, at, side="right") - 1, 0, len(breaks) - 2)
    quiet = np.ones(len(breaks) - 1, dtype=bool)
    quiet[cell[~(off <= nearly)]] = False
    row = np.cumsum(quiet)
    return bad | (~quiet[cell] & np.isin(row[cell], row[cell[bad]]))


def near_polyline(line: Polyline, breaks: Floats) -> Spline:
    """The polyline smeared over a few knots: each coefficient is its value at the mean of the inner knots."""
    from toolpace.kernels.fit.polyline import straight

    knots = knots_of(breaks)
    mean = np.mean([knots[k : len(knots) - 6 + k] for k in range(1, 6)], axis=0)
    spline = Spline(breaks, straight(line.s, line.tip, mean), straight(line.s, line.turn, mean))
    for end in (0, -1):
        spline.tip[end], spline.turn[end] = line.tip[end], line.turn[end]
    return spline


def smooth_samples(spline: Spline, data: Samples, weight: Floats, where: Floats | None, workers: Workers) -> None:
    """Replace the coefficients about the parameters `where`, or all, by those of the smoothing spline."""
    from toolpace.kernels.fit import smoothing_spline as kernel
    from toolpace.kernels.fit.quintic_spline import third_rows

    third = third_rows(knots_of(spline.breaks))

    def solve(which: int, part: Range) -> None:
        x, share, target = ((spline.tip, np.ones(3), data.tip), (spline.turn, weight, data.turn))[which]
        low, high = part
        base, end = max(0, low - 5), min(len(x), high + 5)
        j = slice(*np.searchsorted(data.first, [low - 5, high]))
        # the coordinates of the tip have nothing to do with each other here
        for c in range(3) if which == 0 else (slice(None),):
            columns = slice(c, c + 1) if isinstance(c, int) else c
            metric = np.ones((len(data.s[j]), 1, 1)) if which == 0 else data.metric[j]
            moved = np.ascontiguousarray(x[base:end, columns])
            there = kernel.Samples(data.first[j] - base, data.rows[j], np.ascontiguousarray(target[j, columns]), metric)
            rough = kernel.Roughness(third[base : end - 5], SMOOTHING * share[columns])
            done = kernel.least_squares(rough, there, moved, kernel.Free(low - base, high - base))
            if not done:
                raise PathError("the program asks for a corner that no curve within the tolerance can follow")
            x[low:high, columns] = moved[low - base : high - base]

    solve_ranges(ranges(spline.breaks, where), solve, workers)


def deviation(spline: Spline, data: Samples) -> Floats:
    """Deviation (m,) of tip or turn, whichever is more, at the samples [their tolerances]."""
    everything = slice(None)
    tip = data.off(everything, spline.tip, 0, data.tip, data.metrics(0, everything))
    turn = data.off(everything, spline.turn, 0, data.turn, data.metric)
    return np.maximum(tip / data.room[:, 0], turn / data.room[:, 1])


def first_breaks(line: Polyline) -> Floats:
    """Breaks at vertices, SPACING of their own tolerances apart or more, and graded; two cells at least."""
    from toolpace.kernels.fit.quintic_spline import thin

    s = line.s
    own = np.concatenate([s[:1], np.cumsum(np.diff(s) / line.room.min(axis=1))])
    breaks = s[np.searchsorted(own, thin(own, SPACING))] if np.any(line.room != 1.0) else thin(s, SPACING)
    if len(breaks) < 3:
        breaks = np.array([s[0], 0.5 * (s[0] + s[-1]), s[-1]])
    return graded(breaks)


def graded(breaks: Floats) -> Floats:
    """The breaks with cells halved until none is more than RATIO times as long as a neighbour."""
    while True:
        h = np.diff(breaks)
        least = h.copy()
        least[1:] = np.minimum(least[1:], h[:-1])
        least[:-1] = np.minimum(least[:-1], h[1:])
        long = h > RATIO * least
        if not np.any(long):
            return breaks
        middle = 0.5 * (breaks[:-1] + breaks[1:])[long]
        breaks = np.sort(np.concatenate([breaks, middle]))


def refined_at(vertices: Floats, breaks: Floats, bad: Floats) -> Floats:
    """The breaks with the cells that hold or touch a bad parameter cut in two."""
    split = np.zeros(len(breaks) - 1, dtype=bool)
    for side in (-1e-9, 1e-9):
        at = np.searchsorted(breaks, bad + side * (1.0 + bad), side="right") - 1
        split[np.clip(at, 0, len(split) - 1)] = True
    if np.any(np.diff(breaks)[split] < SHORTEST):
        raise PathError("the program asks for a corner that no curve within the tolerance can follow")
    return graded(np.sort(np.concatenate([breaks, middles(vertices, breaks, split)])))


def middles(vertices: Floats, breaks: Floats, split: Bools) -> Floats:
    """Where to cut the cells: at the vertex nearest the middle if there is one in the middle half."""
    low, high = breaks[:-1][split], breaks[1:][split]
    middle = 0.5 * (low + high)
    above = np.clip(np.searchsorted(vertices, middle), 1, len(vertices) - 1)
    near = np.where(vertices[above] - middle < middle - vertices[above - 1], vertices[above], vertices[above - 1])
    return np.asarray(np.where(np.abs(near - middle) < 0.25 * (high - low), near, middle))
