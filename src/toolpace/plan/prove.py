"""Closing the gap: ranges of speed, proved knot by knot, leave the relaxation less and less room to stand still."""

from __future__ import annotations

import itertools
import time
from contextlib import suppress
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from toolpace.axispath import AxisRun
from toolpace.kernels import bound
from toolpace.limits import Limits
from toolpace.plan.bound import STANDS_STILL, Bound, Relaxed, coefficients, problem_of, relaxed
from toolpace.plan.course import KEPT
from toolpace.plan.crew import Crew, Tell, untold
from toolpace.plan.endstate import AT_REST, EndState
from toolpace.plan.knots import Knots
from toolpace.plan.mesh import ramp_time
from toolpace.plan.problem import Problem
from toolpace.plan.solve import Stalled, slower, solve
from toolpace.timelaw import SplineLaw

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

RAMPS = 7.0
"""How far around an open place the multipliers may change, in times in which an acceleration builds up."""
LEAST_REACH = 40
"""The same in knots, at least."""
PADDING = 40
"""Knots beyond, over which a change of the spline dies away: to a quarter at each, so to less than a rounding."""
OPEN = 0.02
"""Share of the longest wait from which a knot is asked for its range."""
FIRST_UP, FIRST_DOWN = 1.02, 0.67
"""Speeds, as multiples of the relaxation's, from which it is first asked whether the best could lie beyond."""
NEXT_UP, NEXT_DOWN = 0.3, 0.5
"""How far between the relaxation's speed and the border of its range the next question lies."""
NOT_ZERO = 1e-4
"""Share of the relaxation's z below which no range from a z on is looked for."""
NECESSARY = 0.999
"""Share of what the best motion known loses at a place that is to be proved necessary."""
START_LOSS, START_SPREAD = 0.1, 0.1
"""How the search for that motion starts: the plan, so much slower, with so large a gap."""
PROBE_TOLERANCE = 1e-4
LEAST_PROGRESS = 0.2
"""Share of what is open that a round must close; else the range of a knot is split."""
MOST_PIECES = 32
IN_GAP = 0.005
"""Least share of the gap for a place to be tried."""


class Place(NamedTuple):
    """Knots `first` to `last`, between which the relaxation stands still, and the part `low` to `high` around them."""

    low: int
    high: int
    first: int
    last: int
    open: float
    """What the best motion known may lose there [s]."""


@dataclass(frozen=True)
class Piece:
    """Everything with z in these ranges takes at least `value`."""

    value: float
    low: Floats
    high: Floats
    z: Floats
    wait: Floats
    """(n,) of the relaxation within the ranges: speed, and how long it waits, as a pace."""


def prove_run(
    run: AxisRun,
    limits: Limits,
    law: SplineLaw,
    target: float,
    until: float,
    start: EndState = AT_REST,
    end: EndState = AT_REST,
    crew: Crew | None = None,
    tell: Tell = untold,
) -> Bound:
    """The bound of a run's plan, raised until the gap is at most `target` or the time is `until` (time.monotonic).

    Place by place: the multipliers may change in a part around it; what lies outside is priced by those found. So
    what is gained at places whose parts do not overlap adds up.
    """
    crew = crew or Crew()
    problem = problem_of(run, limits, law, start, end)
    knots, c = Knots(problem), coefficients(law)
    found = relaxed(knots, c, np.zeros_like(knots.cap), knots.cap)
    dual = settled(knots, found.dual)
    pace = knots.state(c)[:, 0] ** -0.5
    planned = float(knots.weight @ pace)
    value, losses = losses_by_knot(knots, best_known(problem, knots, c), dual)
    first, wanted = value, planned / (1.0 + target)
    places = []
    for place in open_places(found.wait > STANDS_STILL * pace, losses, law.times, min(ramp_time(limits), law.duration)):
        gained = 0.0
        if value < wanted and time.monotonic() < until:

            def told(gain: float, before: float = value) -> None:
                tell(min((before + gain - first) / (wanted - first), 1.0))

            gained = close(*part_around(knots, place, found, dual), place.open, wanted - value, until, crew, told)
        value += gained
        places.append((law.nodes[place.first], law.nodes[place.last], place.open - gained))
    kept = np.array(places).reshape(-1, 3)
    return Bound(law.duration, planned, max(value, found.value), kept, found.steps)


def best_known(problem: Problem, knots: Knots, c: Floats) -> Floats:
    """Coefficients of the best motion known on the mesh: a plan, or what is better where limits hold at nodes only."""
    best = c
    if len(c) > KEPT:
        return best
    with suppress(Stalled):
        unguarded = solve(problem, slower(problem, c, START_LOSS), START_SPREAD)
        if knots.weight @ knots.state(unguarded)[:, 0] ** -0.5 < knots.weight @ knots.state(c)[:, 0] ** -0.5:
            best = unguarded
    return best


def settled(knots: Knots, dual: Floats) -> Floats:
    """Multipliers that no knot's jerk rows make worth more than its time."""
    price = knots.jerk_price(dual)
    share = np.where(price > knots.weight, knots.weight * (1.0 - 1e-12) / np.maximum(price, 1e-300), 1.0)
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
    bound.least_terms(kappa, theta, np.zeros_like(kappa), knots.cap, least)
    pace = 1.0 / np.sqrt(u[:, 0])
    half = knots.rows.shape[1] // 2
    used = np.einsum("pri,pi->pr", knots.rows, np.repeat(u, np.diff(knots.first), axis=0))
    limit = np.ones_like(used)
    limit[:, half:] = np.repeat(pace, np.diff(knots.first))[:, None]
    slack = (dual[:, :, 0] * (limit - used) + dual[:, :, 1] * (limit + used)).sum(axis=1)
    losses: Floats = kappa * pace + theta * u[:, 0] - least + np.add.reduceat(slack, knots.first[:-1])
    return value, np.maximum(losses, 0.0)


def open_places(marked: npt.NDArray[np.bool_], losses: Floats, clock: Floats, ramp: float) -> list[Place]:
    """The places where the marked knots are, the most open ones first; those whose parts overlap are one."""
    n = len(clock)
    merged: list[Place] = []
    for k in np.flatnonzero(marked):
        low = min(int(np.searchsorted(clock, clock[k] - RAMPS * ramp)), k - LEAST_REACH) - PADDING
        high = max(int(np.searchsorted(clock, clock[k] + RAMPS * ramp)), k + LEAST_REACH) + PADDING
        low, high = max(low, 0), min(high, n - 1)
        if merged and low <= merged[-1].high:
            merged[-1] = merged[-1]._replace(high=high, last=int(k))
        else:
            merged.append(Place(low, high, int(k), int(k), 0.0))
    places = [place._replace(open=float(losses[place.low : place.high + 1].sum())) for place in merged]
    places.sort(key=lambda place: -place.open)
    return [place for place in places if place.open > IN_GAP * losses.sum()]


def part_around(knots: Knots, place: Place, found: Relaxed, dual: Floats) -> tuple[Knots, Floats, Piece]:
    """The part around a place, its coefficients, and all of it as one piece."""
    last = len(knots.weight) - 1
    inner = place.low + PADDING * (place.low > 0), place.high - PADDING * (place.high < last)
    part = knots.part(place.low, place.high, inner, found.c, dual)
    mine = slice(place.low, place.high + 1)
    c = found.c[place.low : place.high + 3]
    prices = dual[knots.first[place.low] : knots.first[place.high + 1]]
    prices = np.where(part.rows.any(axis=2)[:, :, None], prices, 0.0)
    low = np.zeros_like(part.cap)
    return part, c, Piece(part.value(prices), low, part.cap, part.state(c)[:, 0], found.wait[mine])


def close(
    part: Knots, c: Floats, everything: Piece, lost: float, needed: float, until: float, crew: Crew, tell: Tell,
) -> float:  # fmt: skip
    """How much more than `everything.value` any motion takes in a part; `lost` is how much more the best known takes.

    Best first branch and bound, until as much as `needed` is proved: the piece with the least value is tightened, and
    split where that is of no use.
    """
    cut = everything.value + NECESSARY * lost
    enough = everything.value + min(NECESSARY * lost, needed)
    pieces = [everything]
    while len(pieces) <= MOST_PIECES and time.monotonic() < until:
        worst = min(pieces, key=lambda piece: piece.value)
        tell(min(worst.value, enough) - everything.value)
        if worst.value >= enough:
            break
        tighter = tightened(part, c, worst, cut, until, crew)
        pieces.remove(worst)
        if tighter.value >= min(worst.value + LEAST_PROGRESS * (cut - worst.value), enough):
            pieces.append(tighter)
        else:
            pieces += [relaxed_in(part, c, low, high, tighter) for low, high in halves(tighter, part)]
    return max(min(min(piece.value for piece in pieces), cut) - everything.value, 0.0)


def tightened(part: Knots, c: Floats, piece: Piece, wanted: float, until: float, crew: Crew) -> Piece:
    """The piece with the ranges of its open knots narrowed to what may take less than `wanted`.

    What is cut off takes at least that, as multipliers of its own prove. So it need not be looked at again.
    """
    low, high = piece.low.copy(), piece.high.copy()

    def narrow(question: tuple[int, bool]) -> tuple[int, bool, float]:
        k, upper = question
        return k, upper, border(part, c, piece, k, upper, wanted) if time.monotonic() < until else np.nan

    questions = list(itertools.product(open_knots(part, piece).tolist(), (True, False)))
    for k, upper, z in crew.each(narrow, questions):
        if upper and z < high[k]:
            high[k] = z
        elif not upper and z > low[k]:
            low[k] = z
    return relaxed_in(part, c, low, high, piece)


def open_knots(part: Knots, piece: Piece) -> Ints:
    """The knots that wait longest, and their neighbours."""
    seconds = part.weight * piece.wait
    seconds[~part.rows.reshape(len(part.rows), -1).any(axis=1)[part.first[:-1]]] = 0.0
    is_open = seconds > OPEN * seconds.max()
    is_open[1:] |= is_open[:-1].copy()
    is_open[:-1] |= is_open[1:].copy()
    return np.flatnonzero(is_open)


def border(part: Knots, c: Floats, piece: Piece, k: int, upper: bool, wanted: float) -> float:
    """A z such that everything in the piece with z beyond it at knot k takes at least `wanted`; nan if none is found.

    The multipliers are those of the relaxation beyond some z that is asked; by their dual function the border may lie
    further in or out.
    """
    low, high = piece.low.copy(), piece.high.copy()
    z = piece.z[k]
    if upper:
        low[k] = z + NEXT_UP * (high[k] - z) if piece.low[k] > 0.0 else min(FIRST_UP * z, 0.5 * (z + high[k]))
    else:
        high[k] = z - NEXT_DOWN * (z - low[k]) if piece.low[k] > 0.0 else FIRST_DOWN * z
    if not low[k] < high[k]:
        return np.nan
    beyond = relaxed(part, c, low, high, PROBE_TOLERANCE, enough=wanted)
    value, kappa, theta = part.dual(beyond.dual, low, high)
    others = value - bound.lowest(kappa[k], theta[k], low[k], high[k])
    if upper:
        far = max(piece.low[k], NOT_ZERO * z)
        return float(bound.range_beyond(kappa[k], theta[k], far, high[k], wanted - others, True))
    return float(bound.range_beyond(kappa[k], theta[k], low[k], piece.high[k], wanted - others, False))


def relaxed_in(part: Knots, c: Floats, low: Floats, high: Floats, whole: Piece) -> Piece:
    """The relaxation within ranges that are part of those of a piece."""
    found = relaxed(part, c, low, high)
    return Piece(max(found.value, whole.value), low, high, part.state(found.c)[:, 0], found.wait)


def halves(piece: Piece, part: Knots) -> list[tuple[Floats, Floats]]:
    """The ranges of a piece, that of the knot which waits longest split at its speed."""
    k = int(np.argmax(part.weight * piece.wait))
    out = []
    for upper in (False, True):
        low, high = piece.low.copy(), piece.high.copy()
        (low if upper else high)[k] = piece.z[k]
        out.append((low, high))
    return out
