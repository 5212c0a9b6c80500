"""The stretches of a run that the gap between plan and bound comes from."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from toolpace.common.arrays import Bools, Floats, Ints
from toolpace.kernels.optimal.dual import least_terms
from toolpace.machine.limits import Limits
from toolpace.motion.laws import SplineLaw
from toolpace.path.axis_run import AxisRun
from toolpace.planning.bound.problem import PADDING, Knots
from toolpace.planning.bound.relaxation import STANDS_STILL, coefficients, problem_of, relaxed
from toolpace.planning.mesh.initial_guess import ramp_time
from toolpace.planning.planned_run import EndState

PLACE_RAMPS = 7.0
"""How far around an open place the multipliers may change, in times in which an acceleration builds up."""
LEAST_REACH = 40
"""How far the surroundings of a knot reach at least, in knots."""
IN_GAP = 0.005
"""Least share of the gap for a place to be tried."""
MOSTLY = 0.9
"""Share of the gap that lies about the cells which are cut."""


class Place(NamedTuple):
    """Knots `first` to `last`, between which the relaxation stands still, and the part `low` to `high` around them."""

    low: int
    high: int
    first: int
    last: int
    open: float
    """What the plan may lose there [s]."""


def settled(knots: Knots, dual: Floats, low: Floats | None = None) -> Floats:
    """Multipliers whose jerk rows are at no knot worth more than its time, unless z has a range there (low > 0)."""
    price = knots.jerk_price(dual)
    too_much = price > knots.weight
    if low is not None:
        too_much &= low == 0.0
    share = np.where(too_much, knots.weight * (1.0 - 1e-12) / np.maximum(price, 1e-300), 1.0)
    half = knots.rows.shape[1] // 2
    out = dual.copy()
    out[:, half:] *= np.repeat(share, np.diff(knots.first))[:, None, None]
    return out


def losses_by_knot(knots: Knots, c: Floats, dual: Floats) -> tuple[float, Floats]:
    """The bound by multipliers, and (n,) by how much a plan misses it at each knot; all >= 0, they sum to the gap.

    Of the time of a plan, what the multipliers cannot say to be necessary: how far kappa / sqrt(z) + theta z is from
    its least value, and the slack of the rows at their price.
    """
    value, kappa, theta = knots.dual(dual)
    u = knots.state(c)
    least = np.empty_like(kappa)
    least_terms(kappa, theta, np.zeros_like(kappa), knots.cap, least)
    pace = 1.0 / np.sqrt(u[:, 0])
    half = knots.rows.shape[1] // 2
    used = knots.used(u)
    limit = np.ones_like(used)
    limit[:, half:] = np.repeat(pace, np.diff(knots.first))[:, None]
    slack = (dual[:, :, 0] * (limit - used) + dual[:, :, 1] * (limit + used)).sum(axis=1)
    losses: Floats = kappa * pace + theta * u[:, 0] - least + knots.by_knot(slack)
    return value, np.maximum(losses, 0.0)


def open_places(marked: npt.NDArray[np.bool_], losses: Floats, clock: Floats, ramp: float) -> list[Place]:
    """The places where the marked knots are, the most open ones first; those whose parts overlap are one."""
    merged: list[Place] = []
    knots = np.flatnonzero(marked)
    low, high = surroundings(clock, knots, PLACE_RAMPS * ramp)
    for k, first, last in zip(knots.tolist(), low.tolist(), high.tolist()):
        if merged and first <= merged[-1].high:
            merged[-1] = merged[-1]._replace(high=last, last=k)
        else:
            merged.append(Place(first, last, k, k, 0.0))
    places = [place._replace(open=float(losses[place.low : place.high + 1].sum())) for place in merged]
    places.sort(key=lambda place: -place.open)
    return [place for place in places if place.open > IN_GAP * losses.sum()]


def surroundings(clock: Floats, knots: Ints, reach: float) -> tuple[Ints, Ints]:
    """First and last knot of the parts that reach so far [s] around knots."""
    before = np.minimum(np.searchsorted(clock, clock[knots] - reach), knots - LEAST_REACH) - PADDING
    beyond = np.maximum(np.searchsorted(clock, clock[knots] + reach), knots + LEAST_REACH) + PADDING
    return np.maximum(before, 0), np.minimum(beyond, len(clock) - 1)


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
