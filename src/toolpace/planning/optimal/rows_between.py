"""Where limits have rows between the nodes of a mesh, and by how much they are lowered there."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from toolpace.arrays import Bools, Floats, Ints
from toolpace.planning.guarantee import ALLOWED
from toolpace.planning.peaks import Peaks

SHARE, MOST_LOWERED = 0.3, 4e-4
"""How far a limit is lowered where it gets a row, as a share of what it was passed by, and at most: on either side of
the row about a fourth is left."""
OVERSHOOT = 1.2
"""The same where there is a row already: what is passed beside it stays, if it alone is held to the limit."""
SAME_PLACE = 0.12
"""Share of a cell up to which two places are one: the row there is lowered, and no other put beside it."""
BESIDE_NODE = 0.02
"""Share of a cell that a place between two nodes keeps from them."""
QUARTERS, LOWERED = np.array([0.25, 0.5, 0.75]), 3e-4
"""Where a cell that passes a limit by more than a little gets its first rows, and how far their limits are lowered."""
A_LITTLE, FAR_PASSED, NEIGHBOURS = 1.0003, 1.001, 3
"""Usage from which that is so; and from which as many cells on either side get a row too: what such a place loses they
would gain."""


def no_places() -> Floats:
    """None."""
    return np.empty(0)


def no_factors() -> Floats:
    """None."""
    return np.empty((0, 3))


@dataclass(frozen=True)
class RowsBetween:
    """Places between nodes whose limits are held by rows of their own."""

    place: Floats = field(default_factory=no_places)
    """(k,) s, ascending."""
    lowered: Floats = field(default_factory=no_factors)
    """(k, 3) by what the limits of speed, acceleration and jerk are divided."""

    def among(self, nodes: Floats) -> RowsBetween:
        """Those that are not at nodes (n,)."""
        return self._of(~np.isin(self.place, nodes))

    def inside(self, low: float, high: float) -> RowsBetween:
        """Those between two places."""
        return self._of(slice(*np.searchsorted(self.place, [low, high])))

    def _of(self, which: Bools | slice) -> RowsBetween:
        return RowsBetween(self.place[which], self.lowered[which])

    def held(self, nodes: Floats, peaks: Peaks, wrong: Bools, fresh: Bools, urge: float) -> RowsBetween:
        """With rows where the cells marked `wrong` pass a limit most, for each kind, and lower where there is one.

        A cell marked `fresh` has just been cut from one that passed by far: it gets a row whatever. `urge` is how much
        more than usual limits are lowered.
        """
        bare = fresh | wrong & (peaks.used.max(axis=1) > A_LITTLE)
        bare[np.searchsorted(nodes, self.place, side="right") - 1] = False
        cell, kind = np.nonzero((peaks.used > ALLOWED) & (wrong & ~bare)[:, None])
        excess, length = peaks.used[cell, kind] - 1.0, np.diff(nodes)[cell]
        place = nodes[cell] + np.clip(peaks.place[cell, kind], BESIDE_NODE, 1.0 - BESIDE_NODE) * length
        there = np.abs(nearest(self.place, place)[1]) < SAME_PLACE * length
        by = 1.0 + np.where(there, urge * OVERSHOOT * excess, np.minimum(urge * SHARE * excess, MOST_LOWERED))
        new = merged(place[~there], SAME_PLACE * length[~there])
        quarters = (nodes[:-1, None] + np.diff(nodes)[:, None] * QUARTERS)[bare].ravel()
        far = np.flatnonzero(fresh | wrong & (peaks.used.max(axis=1) > FAR_PASSED))
        beside = self._beside(nodes, far, np.concatenate([cell, np.flatnonzero(bare)]))
        places = np.unique(np.concatenate([self.place, new, quarters, beside]))
        lowered = np.ones((len(places), 3))
        lowered[np.searchsorted(places, quarters)] = 1.0 + LOWERED
        lowered[np.searchsorted(places, self.place)] = self.lowered
        factor = np.ones_like(lowered)
        np.maximum.at(factor, (nearest(places, place)[0], kind), by)
        return RowsBetween(places, lowered * factor)

    def _beside(self, nodes: Floats, cells: Ints, but: Ints) -> Floats:
        """The middles of the cells up to NEIGHBOURS from these, where there is no row yet; but not of some."""
        near = (cells[:, None] + np.arange(-NEIGHBOURS, NEIGHBOURS + 1)).ravel()
        taken = np.concatenate([but, np.searchsorted(nodes, self.place, side="right") - 1])
        near = np.setdiff1d(near[(near >= 0) & (near < len(nodes) - 1)], taken)
        middle: Floats = nodes[near] + np.diff(nodes)[near] / 2.0
        return middle


def nearest(places: Floats, wanted: Floats) -> tuple[Ints, Floats]:
    """(k,) the nearest of places, ascending, to each wanted one (k,), and how far off it is; inf without any."""
    if not len(places):
        return np.zeros(len(wanted), dtype=np.int64), np.full(len(wanted), np.inf)
    after = np.clip(np.searchsorted(places, wanted), 1, max(len(places) - 1, 1))
    at = np.minimum(after, len(places) - 1)
    at = np.where(np.abs(places[after - 1] - wanted) <= np.abs(places[at] - wanted), after - 1, at)
    return at, places[at] - wanted


def merged(places: Floats, apart: Floats) -> Floats:
    """Places in order, those left out that lie within `apart` behind one that stays."""
    order = np.argsort(places, kind="stable")
    places, apart = places[order], apart[order]
    while True:
        near = np.diff(places, prepend=-np.inf) < apart
        drop = near & ~np.concatenate([[False], near[:-1]])
        if not drop.any():
            return places
        places, apart = places[~drop], apart[~drop]
