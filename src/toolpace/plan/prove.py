"""Closing the gap: ranges of speed, proved knot by knot, leave the relaxation less and less room to stand still."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from toolpace.axispath import AxisRun
from toolpace.errors import UsageError
from toolpace.kernels import bound
from toolpace.limits import Limits
from toolpace.plan.bound import STANDS_STILL, Bound, Relaxed, bound_run, coefficients, problem_of, relaxed, summed
from toolpace.plan.crew import Crew, Tally, Tell, part_of, untold
from toolpace.plan.endstate import AT_REST, EndState
from toolpace.plan.knots import PADDING, Knots
from toolpace.plan.mesh import ramp_time
from toolpace.plan.problem import Problem
from toolpace.plan.solve import Stalled, slower, solve
from toolpace.timelaw import SplineLaw
from toolpace.trajectory import Trajectory

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

PLACE_RAMPS = 7.0
"""How far around an open place the multipliers may change, in times in which an acceleration builds up."""
KNOT_RAMPS = 2.0
"""The same around a knot whose range is asked for."""
LEAST_REACH = 40
"""Both in knots, at least."""
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
PATIENCE, LEAST_GAIN = 2, 5e-3
"""After how many rounds that raise the bound by less than this share of what the plan loses a place is left."""
GAP = 1e-4
"""What is to be proved, unless something else is asked for: duration / bound - 1."""
IN_GAP = 0.005
"""Least share of the gap for a place to be tried."""


class Place(NamedTuple):
    """Knots `first` to `last`, between which the relaxation stands still, and the part `low` to `high` around them."""

    low: int
    high: int
    first: int
    last: int
    open: float
    """What the plan may lose there [s]."""


@dataclass(frozen=True)
class Part:
    """A part of a run around a place, on its own."""

    knots: Knots
    clock: Floats
    """(n,) when the plan passes the knots [s]."""
    found: Relaxed
    """Multipliers and motion of the relaxation of the whole run, and what those multipliers prove of the part."""


@dataclass(frozen=True)
class Piece:
    """Everything with z in these ranges takes at least `value`."""

    value: float
    low: Floats
    high: Floats
    found: Relaxed
    """The relaxation within the ranges."""


def prove(
    trajectory: Trajectory,
    *,
    gap: float = GAP,
    within: float = 60.0,
    progress: Callable[[float], None] | None = None,
) -> Trajectory:
    """The same motion with its lower bound raised, until it is no more than `gap` from the best or `within` [s] is up.

    For plans of the optimal planner. What is proved before the time is up counts. `progress` is called with the share
    of the gap that is closed. Raises UsageError for the motion of another planner.
    """
    if not all(isinstance(law, SplineLaw) for law in trajectory.laws):
        raise UsageError(f"prove: a plan of the planner '{trajectory.planner}' has no mesh to prove anything on")
    until = time.monotonic() + within
    runs, limits = trajectory.axis_path.runs, trajectory.limits
    laws = [law for law in trajectory.laws if isinstance(law, SplineLaw)]
    tally = Tally(progress, [1.0])
    crew = Crew(tally)
    bounds = crew.each(lambda k: bound_run(runs[k], limits, laws[k], *end_states(laws[k])), range(len(runs)))
    open_ = np.array([bound.duration - bound.seconds for bound in bounds])
    total = max(float(open_.sum()), 1e-300)
    done = 0.0
    for k in np.argsort(-open_).tolist():
        if bounds[k].gap > gap and time.monotonic() < until:
            share = open_[k] / total
            tell = part_of(tally.of(0), done, done + share)
            bounds[k] = prove_run(runs[k], limits, laws[k], gap, until, *end_states(laws[k]), crew=crew, tell=tell)
        done += open_[k] / total
    tally.of(0)(1.0)
    lower_bound, open_places = summed(trajectory.axis_path, laws, bounds)
    return replace(trajectory, lower_bound=max(lower_bound, trajectory.lower_bound), open_places=open_places)


def end_states(law: SplineLaw) -> tuple[EndState, EndState]:
    """How a law starts and ends."""
    t = np.array([0.0, law.duration])
    _, speed, acceleration, _ = law.at(t)
    start, end = (
        EndState(float(speed[k]), float(acceleration[k])) if law.rest[k] == 0.0 else AT_REST for k in range(2)
    )
    return start, end


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
    value, losses = losses_by_knot(knots, c, dual)
    first, wanted = value, planned / (1.0 + target)
    places = []
    ramp = min(ramp_time(limits), law.duration)
    for place in open_places(found.wait > STANDS_STILL * pace, losses, law.times, ramp):
        gained = 0.0
        if value < wanted and time.monotonic() < until:

            def told(gain: float, before: float = value) -> None:
                tell(min((before + gain - first) / (wanted - first), 1.0))

            part = part_around(knots, place, found, dual, law.times)
            lost = place.open - to_gain(problem, c, place)
            gained = close(part, lost, wanted - value, until, ramp, crew, told)
        value += gained
        places.append((law.nodes[place.first], law.nodes[place.last], place.open - gained))
    kept = np.array(places).reshape(-1, 3)
    return Bound(law.duration, planned, max(value, found.value), kept, found.steps)


def to_gain(problem: Problem, c: Floats, place: Place) -> float:
    """What a plan loses in a part against the best motion that holds the limits at the nodes only [s]."""
    piece = problem.stretch(place.low, place.high)
    mine = c[place.low : place.high + 3]
    try:
        best = solve(piece, slower(piece, mine, START_LOSS), START_SPREAD)
    except Stalled:
        return 0.0
    basis, place_of = piece.basis[:, 0], piece.node[:, None] + np.arange(3)
    paces = [np.einsum("pj,pj->p", basis, of[place_of]) ** -0.5 for of in (mine, best)]
    return max(float(piece.weight @ (paces[0] - paces[1])), 0.0)


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
    losses: Floats = kappa * pace + theta * u[:, 0] - least + knots.by_knot(slack)
    return value, np.maximum(losses, 0.0)


def open_places(marked: npt.NDArray[np.bool_], losses: Floats, clock: Floats, ramp: float) -> list[Place]:
    """The places where the marked knots are, the most open ones first; those whose parts overlap are one."""
    merged: list[Place] = []
    knots = np.flatnonzero(marked)
    for k, low, high in zip(
        knots.tolist(), *(side.tolist() for side in surroundings(clock, knots, PLACE_RAMPS * ramp))
    ):
        if merged and low <= merged[-1].high:
            merged[-1] = merged[-1]._replace(high=high, last=k)
        else:
            merged.append(Place(low, high, k, k, 0.0))
    places = [place._replace(open=float(losses[place.low : place.high + 1].sum())) for place in merged]
    places.sort(key=lambda place: -place.open)
    return [place for place in places if place.open > IN_GAP * losses.sum()]


def surroundings(clock: Floats, knots: Ints, reach: float) -> tuple[Ints, Ints]:
    """First and last knot of the parts that reach so far [s] around knots."""
    before = np.minimum(np.searchsorted(clock, clock[knots] - reach), knots - LEAST_REACH) - PADDING
    beyond = np.maximum(np.searchsorted(clock, clock[knots] + reach), knots + LEAST_REACH) + PADDING
    return np.maximum(before, 0), np.minimum(beyond, len(clock) - 1)


def part_around(knots: Knots, place: Place, found: Relaxed, dual: Floats, clock: Floats) -> Part:
    """The part around a place."""
    part = knots.part(place.low, place.high, found.c, dual)
    mine = slice(place.low, place.high + 1)
    prices = knots.of_part(part, place.low, dual)
    c = found.c[place.low : place.high + 3]
    return Part(part, clock[mine], Relaxed(part.value(prices), prices, found.wait[mine], c, 0))


def close(part: Part, lost: float, needed: float, until: float, ramp: float, crew: Crew, tell: Tell) -> float:
    """How much more than its multipliers say any motion takes in a part; `lost` is how much more the best known takes.

    Best first branch and bound, until as much as `needed` is proved: the piece with the least value is tightened, and
    split where that is of no use.
    """
    base = part.found.value
    cut = base + NECESSARY * lost
    enough = base + min(NECESSARY * lost, needed)
    low = np.zeros_like(part.knots.cap)
    pieces = [Piece(base, low, part.knots.cap, part.found)]
    patience, best = PATIENCE, base
    while patience and time.monotonic() < until:
        worst = min(pieces, key=lambda piece: piece.value)
        patience = PATIENCE if worst.value > best + LEAST_GAIN * lost else patience - 1
        best = max(best, worst.value)
        tell(min(best, enough) - base)
        if best >= enough:
            break
        tighter = tightened(part, worst, cut, until, ramp, crew)
        pieces.remove(worst)
        if tighter.value >= min(worst.value + LEAST_PROGRESS * (cut - worst.value), enough):
            pieces.append(tighter)
        else:
            pieces += [relaxed_in(part, low, high, tighter) for low, high in halves(tighter, part.knots)]
    return max(min(min(piece.value for piece in pieces), cut) - base, 0.0)


def tightened(part: Part, piece: Piece, wanted: float, until: float, ramp: float, crew: Crew) -> Piece:
    """The piece with the ranges of its open knots narrowed to what may take less than `wanted`.

    What is cut off takes at least that, as multipliers of its own prove. So it need not be looked at again.
    """
    low, high = piece.low.copy(), piece.high.copy()

    def narrow(k: int) -> tuple[int, float, float]:
        if time.monotonic() > until:
            return k, np.nan, np.nan
        near = Near(part, piece, k, ramp)
        return k, near.border(False, wanted), near.border(True, wanted)

    for k, least, most in crew.each(narrow, open_knots(part.knots, piece).tolist()):
        low[k], high[k] = np.fmax(low[k], least), np.fmin(high[k], most)
    return relaxed_in(part, low, high, piece)


def open_knots(knots: Knots, piece: Piece) -> Ints:
    """The knots that wait longest, and their neighbours."""
    seconds = knots.weight * piece.found.wait * knots.has_rows()
    is_open: npt.NDArray[np.bool_] = seconds > OPEN * seconds.max()
    is_open[1:] |= is_open[:-1].copy()
    is_open[:-1] |= is_open[1:].copy()
    return np.flatnonzero(is_open)


class Near:
    """The surroundings of a knot in a piece; beyond them, the multipliers of the piece stand."""

    def __init__(self, part: Part, piece: Piece, k: int, ramp: float) -> None:
        low, high = surroundings(part.clock, np.array([k]), KNOT_RAMPS * ramp)
        mine = slice(int(low[0]), int(high[0]) + 1)
        found = piece.found
        self.knots = part.knots.part(mine.start, mine.stop - 1, found.c, found.dual, piece.low, piece.high)
        self.low, self.high, self.k = piece.low[mine], piece.high[mine], k - mine.start
        self.c = found.c[mine.start : mine.stop + 2]
        self.z = float(self.knots.state(self.c)[self.k, 0])
        # what is to be gained here, for the whole part to take at least what is wanted
        prices = part.knots.of_part(self.knots, mine.start, found.dual)
        self.offset = self.knots.value(prices, self.low, self.high) - found.value

    def border(self, upper: bool, enough: float) -> float:
        """A z such that everything in the piece with z beyond it at the knot takes at least `enough`; nan: none found.

        Asked is what the relaxation beyond some z takes; by the dual function of its multipliers the border may lie
        further in or out. Where no range was known yet, it is asked for once more, nearer to that border.
        """
        low, high, z = self.low[self.k], self.high[self.k], self.z
        if upper:
            return self.beyond(
                z + NEXT_UP * (high - z) if low > 0.0 else min(FIRST_UP * z, 0.5 * (z + high)), True, enough
            )
        if low > 0.0:
            return self.beyond(z - NEXT_DOWN * (z - low), False, enough)
        border = self.beyond(FIRST_DOWN * z, False, enough)
        again = np.sqrt(FIRST_DOWN * z * border) if border > 0.0 else FIRST_DOWN**4 * z
        return float(np.fmax(border, self.beyond(again, False, enough))) if again < FIRST_DOWN * z else border

    def beyond(self, z: float, upper: bool, enough: float) -> float:
        """The border by the multipliers of the relaxation beyond z; nan where they do not show any."""
        low, high, k = self.low.copy(), self.high.copy(), self.k
        (low if upper else high)[k] = z
        if not low[k] < high[k]:
            return np.nan
        found = relaxed(self.knots, self.c, low, high, PROBE_TOLERANCE, enough + self.offset)
        value, kappa, theta = self.knots.dual(found.dual, low, high)
        wanted = enough + self.offset - value + bound.lowest(kappa[k], theta[k], low[k], high[k])
        if upper:
            low[k] = max(self.low[k], NOT_ZERO * self.z)
        else:
            high[k] = self.high[k]
        return float(bound.range_beyond(kappa[k], theta[k], low[k], high[k], wanted, upper))


def relaxed_in(part: Part, low: Floats, high: Floats, whole: Piece) -> Piece:
    """The relaxation within ranges that are part of those of a piece."""
    found = relaxed(part.knots, part.found.c, low, high)
    if not found.value > whole.found.value:
        found = whole.found
    return Piece(max(found.value, whole.value), low, high, found)


def halves(piece: Piece, knots: Knots) -> list[tuple[Floats, Floats]]:
    """The ranges of a piece, that of the knot which waits longest split at its speed."""
    k = int(np.argmax(knots.weight * piece.found.wait * knots.has_rows()))
    z = knots.state(piece.found.c)[k, 0]
    out = []
    for upper in (False, True):
        low, high = piece.low.copy(), piece.high.copy()
        (low if upper else high)[k] = z
        out.append((low, high))
    return out
