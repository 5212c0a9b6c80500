"""Gap localisation: the cells in which most of the gap between a plan and its bound lies."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from toolpace.common.arrays import Bools
from toolpace.machine.limits import Limits
from toolpace.motion.laws.spline import SplineLaw
from toolpace.path.axispath.run import AxisRun
from toolpace.planning.bound.gap_localisation import losses_by_knot, open_places, settled
from toolpace.planning.bound.problem import Knots
from toolpace.planning.bound.relaxation import STANDS_STILL, coefficients, problem_of, relaxed
from toolpace.planning.endstate import EndState
from toolpace.planning.mesh.initial_guess import ramp_time

MOSTLY = 0.9
"""Share of the gap that lies about the cells which are cut."""


class GapInterval(NamedTuple):
    """Where the gap of a plan lies."""

    cells: Bools
    """(cells,) those about which most of it lies."""
    low: float
    high: float
    """From which s to which s these are."""
    stands: float
    """Share of the gap that lies at places where the relaxation stands still."""


def gap_interval_of(run: AxisRun, limits: Limits, law: SplineLaw, start: EndState, end: EndState) -> GapInterval:
    """Where the gap of a plan lies."""
    knots, c = Knots(problem_of(run, limits, law, start, end)), coefficients(law)
    found = relaxed(knots, c, np.zeros_like(knots.cap), knots.cap)
    _, losses = losses_by_knot(knots, c, settled(knots, found.dual))
    waits = found.wait > STANDS_STILL * knots.state(c)[:, 0] ** -0.5
    places = open_places(waits, losses, law.times, min(ramp_time(limits), law.duration))
    total = max(float(losses.sum()), 1e-300)
    order = np.argsort(-losses)
    many = int(np.searchsorted(np.cumsum(losses[order]), MOSTLY * total)) + 1
    is_open = np.zeros(len(losses) + 1, dtype=np.bool_)
    is_open[order[:many]] = True
    cells: Bools = is_open[:-1] | is_open[1:]
    cells = cells[: len(losses) - 1]
    where = np.flatnonzero(cells)
    stands = sum(place.open for place in places) / total
    return GapInterval(cells, float(law.nodes[where[0]]), float(law.nodes[where[-1] + 1]), stands)
