"""The nearest point of a path by branch and bound, from chords with bounds of how far the path is off them.

nearest: stretches of a path, a point
  every chord of every stretch, with the sag that the path stays within
  until nothing is left open:
      no point of a cell is nearer than its chord less its sag: what cannot beat the best by the tolerance is closed
      open cells are halved, which quarters the sag; their middles, and Newton's steps from the best, lower the best

Branch and bound (Land and Doig, 1960), cells of a round side by side. The nearest point lies in no closed cell, but for
the tolerance.

            sag = most |P''| (s1 - s0)^2 / 8
        .-''''''-.          the path stays within the sag of its chord, whatever it does between (Taylor's remainder
    P0 '----------' P1      of linear interpolation), and half the stretch has a quarter of the sag

Most |P''| is that of the control points of P'' where a piece is a polynomial (a curve lies in the hull of its control
points, and the norm is convex), 1 / R on an arc. Of a function only samples can be had: there the bound is trusted, not
proven.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import comb
from weakref import WeakKeyDictionary

import numpy as np

from toolpace.common.arrays import Bools, Floats, Ints, numbers
from toolpace.common.errors import PathError, UsageError
from toolpace.common.value_objects import ByValue, one_line
from toolpace.path.path import Path
from toolpace.path.run import PathRun

BORDER = 1e-12
"""How far an interval may reach beyond its run by rounding."""
MOST_HALVINGS = 100
"""Halvings: more than a double has digits."""
MOST_CELLS = 1 << 18
"""Open at once. More would be only where a long path keeps its distance to the tolerance (many turns about the point);
`within` then tells what is left."""
NEWTON_STEPS = 50
"""Most of them from one start; each squares the error."""
ROUNDING = 1.0 + 1e-14
"""Rise of the distance, or of its square, that is rounding: no fall is seen where the last digits of s are won."""
CONVERGED = 1e-14
"""Step at which a descent ends, relative to the length of the stretch in s."""
FIRST_CELLS = 256
"""Into which a function's run is cut before it is looked at."""
GOLDEN = 0.5 * (np.sqrt(5.0) - 1.0)
"""The cuts are multiples of it, less their whole part: about evenly spread, and in step with no wave."""
INSIDE = np.array([0.25, 0.5, 0.75])
"""Where in a cell a function's second derivative is compared with what its ends foretell."""
RESOLVED = 0.1
"""Difference up to which a cell is resolved, relative to the largest second derivative seen in it."""
TRUST = 2.0
"""What is taken for the most, as a multiple of the most that samples and their Hermite interpolant show."""
STRAIGHT = 1e-12
"""Sag that needs no resolving [m]: rounding."""
DEEPEST = 24
"""Halvings of a first cell; a second derivative that is still not resolved then jumps, and both its sides are seen."""
MOST_UNRESOLVED = 1 << 17
"""Cells; where more are not resolved the second derivative is noise, and is taken as it was seen."""


@dataclass(frozen=True)
class Stretch:
    """A run from one parameter to another."""

    index: int
    """Of the run."""
    run: PathRun
    low: float
    high: float

    def tip(self, s: Floats) -> Floats:
        """(4, n, 3) tip and three derivatives at s (n,)."""
        jets: Floats = self.run.evaluate(s).tip
        return jets


def stretches(path: Path, interval: tuple[float, float] | None) -> list[Stretch]:
    """All runs of a path, or the `interval` (from s, to s) of one of them.

    Raises UsageError where there is none, and where several have it.
    """
    if interval is None:
        return [Stretch(index, run, run.s0, run.s1) for index, run in enumerate(path.runs)]
    low, high = numbers(interval, "deflection: interval", (2,)).tolist()
    found = [
        Stretch(index, run, max(low, run.s0), min(high, run.s1))
        for index, run in enumerate(path.runs)
        if run.s0 - BORDER <= low < high <= run.s1 + BORDER
    ]
    if not found:
        raise UsageError(f"deflection: the path has no interval from s = {interval}; give one inside a run")
    if len(found) > 1:
        raise UsageError(
            f"deflection: {len(found)} runs of the path have an interval from s = {interval}; project on the one that"
            " is meant: Path((path.runs[k],))"
        )
    return found


@dataclass(frozen=True, eq=False, repr=False)
class Projection(ByValue):
    """The point of a path that is nearest to a deflection."""

    s: float
    """Parameter on the path."""
    run: int
    """Index of the run."""
    tip: Floats
    """(3,) [m]."""
    distance: float
    """From the deflection [m]."""
    steps: int
    """Rounds of halving, or steps of the descent."""
    within: float
    """No point that was looked for is nearer by more than this [m]; inf by the potential field, which cannot tell."""
    proven: bool
    """Whether bounds of the path itself stand behind `within`; of a path given as a function only samples can."""

    def __repr__(self) -> str:
        return one_line(self, f"s {self.s:.9g} of run {self.run}", f"{self.distance * 1e3:.6g} mm away")


@dataclass(frozen=True)
class Cells:
    """Parts of stretches, in their order, each with its chord and its sag."""

    stretch: Ints
    """(n,) index of the stretch."""
    ends: Floats
    """(2, n) parameters."""
    tips: Floats
    """(2, n, 3) tip there [m]."""
    sag: Floats
    """(n,) bound of the distance between path and chord [m]."""

    @classmethod
    def of(cls, number: int, stretch: Stretch) -> Cells:
        """Those of one stretch; a cell that its ends cut keeps its sag."""
        chords = chords_of(stretch.run)
        if stretch.low <= chords.s[0] and stretch.high >= chords.s[-1]:
            s, tip, sag = chords.s, chords.tip, chords.sag
        else:
            first = int(np.clip(np.searchsorted(chords.s, stretch.low, side="right") - 1, 0, len(chords.sag) - 1))
            last = int(np.clip(np.searchsorted(chords.s, stretch.high), first + 1, len(chords.sag)))
            ends = np.array([stretch.low, stretch.high])
            (low, high), inside = stretch.tip(ends)[0], slice(first + 1, last)
            s = np.concatenate([ends[:1], chords.s[inside], ends[1:]])
            tip, sag = np.concatenate([low[None], chords.tip[inside], high[None]]), chords.sag[first:last]
        return cls(np.full(len(sag), number), np.stack([s[:-1], s[1:]]), np.stack([tip[:-1], tip[1:]]), sag)

    @classmethod
    def joined(cls, parts: list[Cells]) -> Cells:
        """Those of all stretches."""
        return cls(
            np.concatenate([part.stretch for part in parts]),
            np.concatenate([part.ends for part in parts], axis=1),
            np.concatenate([part.tips for part in parts], axis=1),
            np.concatenate([part.sag for part in parts]),
        )

    def least_distance(self, point: Floats) -> Floats:
        """(n,) bound from below of the distance of each cell from a point."""
        start, along = self.tips[0], self.tips[1] - self.tips[0]
        square = np.einsum("nc,nc->n", along, along)
        share = np.einsum("nc,nc->n", point - start, along) / np.where(square > 0.0, square, 1.0)
        foot = start + np.clip(share, 0.0, 1.0)[:, None] * along
        least: Floats = np.maximum(np.linalg.norm(foot - point, axis=1) - self.sag, 0.0)
        return least

    def halved(self, which: Bools, stretches: list[Stretch]) -> Cells:
        """Both halves of each of these cells; the middles are the right ends of every other one."""
        stretch, ends, tips = self.stretch[which], self.ends[:, which], self.tips[:, which]
        middle = 0.5 * (ends[0] + ends[1])
        tip = np.empty((len(middle), 3))
        for k in np.unique(stretch):
            tip[stretch == k] = stretches[k].tip(middle[stretch == k])[0]
        return Cells(
            np.repeat(stretch, 2),
            np.stack([interleaved(ends[0], middle), interleaved(middle, ends[1])]),
            np.stack([interleaved(tips[0], tip), interleaved(tip, tips[1])]),
            np.repeat(0.25 * self.sag[which], 2),
        )


def interleaved(first: Floats, second: Floats) -> Floats:
    """(2 n, ...) of two arrays (n, ...), an element of either in turn."""
    out: Floats = np.stack([first, second], axis=1).reshape(2 * len(first), *first.shape[1:])
    return out


@dataclass(frozen=True)
class Found:
    """A place on a stretch."""

    stretch: int
    s: float
    tip: Floats
    distance: float


def nearest(stretches: list[Stretch], point: Floats, tolerance: float) -> Projection:
    """The point of these stretches that is nearest to a point (3,) [m], but for the tolerance [m]."""
    cells = Cells.joined([Cells.of(number, stretch) for number, stretch in enumerate(stretches)])
    best = better(None, cells, stretches, point)
    closed = np.inf
    """Least distance that a closed cell may have."""
    halvings = 0
    while True:
        least = cells.least_distance(point)
        is_open = least < best.distance - tolerance
        if halvings == MOST_HALVINGS or np.count_nonzero(is_open) > MOST_CELLS:
            is_open[:] = False
        closed = min(closed, float(least[~is_open].min(initial=np.inf)))
        if not is_open.any():
            break
        cells = cells.halved(is_open, stretches)
        best = better(best, cells, stretches, point)
        halvings += 1
    within = max(0.0, best.distance - closed)
    proven = all(chords_of(stretch.run).proven for stretch in stretches)
    return Projection(best.s, stretches[best.stretch].index, best.tip, best.distance, halvings, within, proven)


def better(best: Found | None, cells: Cells, stretches: list[Stretch], point: Floats) -> Found:
    """The floor of the valley of the nearest end of these cells, if that end is nearer than the best."""
    apart = np.linalg.norm(cells.tips - point, axis=2)
    side, k = np.unravel_index(int(np.argmin(apart)), apart.shape)
    if best is not None and apart[side, k] >= best.distance:
        return best
    number = int(cells.stretch[k])
    s, tip = valley_floor(stretches[number], point, float(cells.ends[side, k]))
    return Found(number, s, tip, float(np.linalg.norm(tip - point)))


def valley_floor(stretch: Stretch, point: Floats, s: float) -> tuple[float, Floats]:
    """Newton's steps from s into the lowest point of the valley of the distance there: s and tip (3,).

    Each is halved until the distance falls, or cannot be seen to any more. From a ridge there is no step.
    """
    jet = stretch.tip(np.array([s]))[:, 0]
    for _ in range(NEWTON_STEPS):
        off = jet[0] - point
        steepness = float(jet[1] @ jet[1] + off @ jet[2])
        if not steepness > 0.0:
            break
        move = -float(off @ jet[1]) / steepness
        while True:
            there = min(max(s + move, stretch.low), stretch.high)
            done = abs(there - s) <= CONVERGED * (stretch.high - stretch.low)
            ahead = stretch.tip(np.array([there]))[:, 0]
            lower = np.linalg.norm(ahead[0] - point) <= np.linalg.norm(off) * ROUNDING
            if lower or done:
                break
            move *= 0.5
        if lower:
            s, jet = there, ahead
        if done:
            break
    return s, jet[0]


@dataclass(frozen=True, eq=False)
class Chords:
    """Marks along a run, and a bound of how far the tip's path is from the chord between each two."""

    s: Floats
    """(k + 1,) ascending parameters, the breaks of the run among them."""
    tip: Floats
    """(k + 1, 3) tip there [m]."""
    sag: Floats
    """(k,) bound of the distance between the path and its chord [m]."""
    proven: bool
    """False where the bound rests on samples of a function."""


CHORDS_OF: WeakKeyDictionary[PathRun, Chords] = WeakKeyDictionary()
"""Of the runs that were asked for: found once, as long as there is the run."""


def chords_of(run: PathRun) -> Chords:
    """Those of a run. Raises PathError where it is a function with a derivative that is not finite."""
    if run not in CHORDS_OF:
        most = run.second_derivative_bounds()
        if most is None:
            CHORDS_OF[run] = sampled_chords(lambda s: run.evaluate(s).tip, run.breaks)
        else:
            sag = most * np.diff(run.breaks) ** 2 / 8.0
            CHORDS_OF[run] = Chords(run.breaks, run.evaluate(run.breaks).tip[0], sag, proven=True)
    return CHORDS_OF[run]


def sampled_chords(tip_jets: Callable[[Floats], Floats], breaks: Floats) -> Chords:
    """Those of a function, s (n,) -> (4, n, 3), finer where its second derivative is not what its neighbours foretell.

    Raises PathError where a derivative is not finite.
    """
    cuts = breaks[0] + (breaks[-1] - breaks[0]) * ((GOLDEN * np.arange(1, FIRST_CELLS)) % 1.0)
    marks = np.union1d(breaks, cuts)
    left, right = marks[:-1], marks[1:]
    done: list[tuple[Floats, Floats]] = []
    for depth in range(DEEPEST + 1):
        width = right - left
        # a break belongs to both its cells, so the right end is looked at from the left
        places = np.stack([left, *(left + share * width for share in INSIDE), np.nextafter(right, left)])
        jets = tip_jets(places.ravel()).reshape(4, len(places), len(left), 3)
        if not np.isfinite(jets).all():
            where = places.ravel()[np.flatnonzero(~np.isfinite(jets).all(axis=(0, 3)).ravel())[0]]
            raise PathError(f"path: the tip or a derivative of it is not finite at s = {where:.9g}; give a smooth path")
        most, off = second_derivative_seen(jets, width)
        fine = (off <= RESOLVED * most) | (TRUST * most * width**2 / 8.0 <= STRAIGHT)
        if depth == DEEPEST or len(left) > MOST_UNRESOLVED:
            fine[:] = True
        done.append((left[fine], TRUST * most[fine] * width[fine] ** 2 / 8.0))
        middle = 0.5 * (left + right)[~fine]
        left, right = np.concatenate([left[~fine], middle]), np.concatenate([middle, right[~fine]])
        if len(left) == 0:
            break
    starts, sag = (np.concatenate(part) for part in zip(*done))
    order = np.argsort(starts)
    s = np.append(starts[order], breaks[-1])
    return Chords(s, tip_jets(s)[0], sag[order], proven=False)


def second_derivative_seen(jets: Floats, width: Floats) -> tuple[Floats, Floats]:
    """(n,) most |P''| of cells, and how far P'' inside is from the cubic that its ends foretell.

    jets (4, 5, n, 3) at the left end, INSIDE, and the right end.
    """
    second, third = jets[2], jets[3] * width[:, None]
    ends = [second[0], second[0] + third[0] / 3.0, second[-1] - third[-1] / 3.0, second[-1]]
    most = np.linalg.norm(np.concatenate([ends, second[1:-1]]), axis=2).max(axis=0)
    off = np.zeros(len(width))
    for share, seen in zip(INSIDE, second[1:-1]):
        foretold = sum(comb(3, k) * share**k * (1.0 - share) ** (3 - k) * point for k, point in enumerate(ends))
        off = np.maximum(off, np.linalg.norm(seen - foretold, axis=1))
    return most, off
