"""The result of planning one run: law, bound, statistics."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from toolpace.motion.laws import TimeLaw
from toolpace.motion.trajectory import OpenPlace
from toolpace.path.axis_path import AxisPath

WORTH_NAMING = 0.01
"""Least share of what is open in all runs together from which a place is named: a hundred of them would be no help."""


@dataclass(frozen=True)
class PlannedRun:
    """A run's law of motion, and how good it is known to be."""

    law: TimeLaw
    mesh_points: int
    lower_bound: float | None = None
    """No motion on the mesh is faster than this [s]; None where that was not asked, or is not known."""
    open_places: tuple[OpenPlace, ...] = ()
    """Where the motion may be faster, or the bound too low; in time since the start of the run."""
    notes: tuple[str, ...] = ()
    """Why its bound was far from it at first, and what came of another try."""


def total_bound(axis_path: AxisPath, planned: Sequence[PlannedRun]) -> tuple[float, tuple[OpenPlace, ...]]:
    """The bound of all runs with their dwells [s], 0 where one has none, and where what is open of it lies."""
    bounds = [run.lower_bound for run in planned if run.lower_bound is not None]
    if len(bounds) < len(planned):
        return 0.0, ()
    total = begins = axis_path.first_dwell
    open_ = sum(run.law.duration - bound for run, bound in zip(planned, bounds, strict=True))
    places = []
    for run, of_run, bound in zip(axis_path.runs, planned, bounds, strict=True):
        for place in of_run.open_places:
            if place.seconds > WORTH_NAMING * open_:
                places.append(replace(place, start=begins + place.start, end=begins + place.end))
        total += bound + run.dwell
        begins += of_run.law.duration + run.dwell
    return total, tuple(places)
