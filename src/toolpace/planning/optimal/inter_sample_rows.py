"""Where limits have rows between the nodes of a mesh, and by how much they are lowered there."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from toolpace.common.arrays import Bools, Floats
from toolpace.kernels.motion import inter_sample_rows
from toolpace.planning.limit_tolerances import ALLOWED
from toolpace.planning.peaks import Peaks


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

    def beside(self, places: Floats) -> Floats:
        """(j,) places of those that are not at some places (n,), ascending."""
        new: Floats = self.place[np.append(places, np.nan)[np.searchsorted(places, self.place)] != self.place]
        return new

    def _of(self, which: Bools | slice) -> RowsBetween:
        return RowsBetween(self.place[which], self.lowered[which])

    def held(self, nodes: Floats, peaks: Peaks, wrong: Bools, fresh: Bools, urge: float) -> RowsBetween:
        """With rows where the cells marked `wrong` pass a limit most, for each kind, and lower where there is one.

        A cell marked `fresh` has just been cut from one that passed by far: it gets a row whatever. `urge` is how much
        more than usual limits are lowered.
        """
        used, place = peaks.used, peaks.place
        return RowsBetween(
            *inter_sample_rows.held(nodes, self.place, self.lowered, used, place, wrong, fresh, urge, ALLOWED)
        )
