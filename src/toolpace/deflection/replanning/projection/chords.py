"""Chords of a tip path with bounds of their deviation, for the nearest-point search.

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

from toolpace.common.arrays import Floats
from toolpace.common.errors import PathError
from toolpace.path.run import PathRun

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


KNOWN: WeakKeyDictionary[PathRun, Chords] = WeakKeyDictionary()
"""Of the runs that were asked for: found once, as long as there is the run."""


def chords_of(run: PathRun) -> Chords:
    """Those of a run. Raises PathError where it is a function with a derivative that is not finite."""
    if run not in KNOWN:
        most = run.second_derivative_bounds()
        if most is None:
            KNOWN[run] = sampled_chords(lambda s: run.evaluate(s).tip, run.breaks)
        else:
            sag = most * np.diff(run.breaks) ** 2 / 8.0
            KNOWN[run] = Chords(run.breaks, run.evaluate(run.breaks).tip[0], sag, proven=True)
    return KNOWN[run]


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
