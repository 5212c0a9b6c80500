"""The duration over x and y about the best set-up."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.common.cluster import Pool
from toolpace.common.workers import Progress
from toolpace.setup_search.choices import Choices
from toolpace.setup_search.trial import Task, tried_there
from toolpace.setup_search.verified_set_up import PlannedSetUp


@dataclass(frozen=True, eq=False)
class PlaceMap:
    """Cheap plans on a grid of places."""

    x: Floats
    """(k,) shifts along X [m]."""
    y: Floats
    """(l,) shifts along Y [m]."""
    seconds: Floats
    """(l, k) about the duration there [s]; nan beyond travel and in forbidden zones."""
    best: tuple[float, float]
    """Where the best set-up is [m]."""

    @property
    def fits(self) -> bool:
        """Whether the program fits anywhere on it."""
        return bool(np.isfinite(self.seconds).any())


def map_places(
    task: Task, choices: Choices, pool: Pool, best: PlannedSetUp, count: int, progress: Progress
) -> PlaceMap | None:
    """The map with so many places along each of x and y; None where one of them is not to be chosen."""
    if not {"x", "y"} <= set(choices.position):
        return None
    (x0, x1), (y0, y1), _ = choices.box()
    x, y = np.linspace(x0, x1, count), np.linspace(y0, y1, count)
    z = best.clamping.shift[2]
    asked = [replace(best.clamping, shift=(float(a), float(b), z)) for b in y for a in x]
    seconds = np.full(len(asked), np.nan)
    for done, outcome in enumerate(pool.each(tried_there, task, asked), start=1):
        if outcome.value is not None and outcome.value.fits:
            seconds[outcome.number] = outcome.value.cost
        progress(done / len(asked))
    return PlaceMap(x, y, seconds.reshape(count, count), best.clamping.shift[:2])
