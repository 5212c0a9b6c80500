"""A run as planners take and return it: the states at its ends; its law, bound and statistics."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from numbers import Real

import numpy as np

from toolpace.common.errors import InfeasibleError, UsageError
from toolpace.machine.limits import KINDS, Limits
from toolpace.motion import limit_ratios
from toolpace.motion.laws import TimeLaw
from toolpace.motion.trajectory import OpenPlace
from toolpace.path.axis_path import AxisPath
from toolpace.path.axis_run import AxisRun
from toolpace.planning.limit_tolerances import PROMISED

WORTH_NAMING = 0.01
"""Least share of what is open in all runs together from which a place is named: a hundred of them would be no help."""


@dataclass(frozen=True)
class EndState:
    """State of s at an end of a run: ds/dt and d2s/dt2; both zero at rest."""

    speed: float = 0.0
    acceleration: float = 0.0

    def __post_init__(self) -> None:
        for name, value in (("speed", self.speed), ("acceleration", self.acceleration)):
            if not isinstance(value, Real):
                raise UsageError(f"end state: {name} is {value!r}; give ds/dt and d2s/dt2 as numbers")

    @property
    def at_rest(self) -> bool:
        """Whether the run starts or ends without motion."""
        return self.speed == 0.0


AT_REST = EndState()


def check_state(run: AxisRun, limits: Limits, state: EndState, s: float, orders: int = 2) -> None:
    """Raise InfeasibleError where the state itself breaks a limit, whatever comes next.

    `orders` is 2 where its acceleration is held too, 1 where only its speed is.
    """
    if state.at_rest:
        return
    if not (np.isfinite(state.speed) and np.isfinite(state.acceleration) and state.speed > 0.0):
        raise InfeasibleError(
            f"end state: ds/dt = {state.speed:g} and d2s/dt2 = {state.acceleration:g}; ds/dt must be positive"
        )
    side = np.array([1.0 if s == run.s0 else 0.0])
    moment = np.array([[s], [state.speed], [state.acceleration], [0.0]])
    ratios = limit_ratios(run, limits, moment, side)[0][limits.orders < orders]
    if ratios.max() > PROMISED:
        names = ["the feed cap"] + [f"the {kind} limit of {joint}" for kind in KINDS[:2] for joint in limits.joints]
        names += [f"the limit {rows.name}" for rows in limits.rows if rows.order == 1]
        raise InfeasibleError(
            f"end state at {run.place(s)}: takes {ratios.max():.4g} of {names[int(ratios.argmax())]};"
            " start or end slower"
        )


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
