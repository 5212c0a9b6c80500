"""A lower bound of the problem on its mesh, by a convex relaxation and weak duality; of a long run from its pieces.

Any nonnegative multipliers give a bound (docs/design/bound.md), so those of overlapping pieces do. Around the border of
two pieces the ones fade into the others: both are near those of the whole there, since what happens at one place of a
run is of no matter further away than the machine needs to stop and start again.
"""

from __future__ import annotations

import threading
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from toolpace.common.arrays import Floats, Ints
from toolpace.common.workers import UNTOLD, Progress, Workers
from toolpace.kernels.motion import cubic_spline
from toolpace.kernels.optimal import dual, relaxation
from toolpace.machine.limits import Limits
from toolpace.motion.laws import SplineLaw
from toolpace.motion.trajectory import OpenPlace
from toolpace.path.axis_run import AxisRun
from toolpace.planning.bound.problem import Knots, start_within
from toolpace.planning.mesh.initial_guess import fleeting, highest_of, ramp_time, steady_speed
from toolpace.planning.optimal.problem import HIGHEST, OnMesh, Problem, discretise, weights
from toolpace.planning.path_at_probes import CachedPath
from toolpace.planning.planned_run import AT_REST, EndState

TOLERANCE = 1e-5
"""What the bound may lose to an end of the iteration ahead of time, relative to the duration."""
MOST_STEPS = 150
"""Of the iteration: 29 at most on the 27 paths of the benchmark."""
STANDS_STILL = 0.01
"""Share of the pace from which the wait at a knot makes it part of a place that keeps the gap open."""
IN_GAP = 0.01
"""Least share of the gap that the waits of such a place sum to."""
PIECE = 4_000
"""Nodes from border to border, unless the overlap would be wider."""
OVERLAP_RAMPS = 40.0
"""How far a piece reaches beyond its border, in times in which an acceleration builds up."""
LEAST_OVERLAP = 100
"""Nodes that a piece reaches beyond its border at least."""
FADE = 0.5
"""Share of the overlap in which the multipliers of one piece fade into those of the next."""
WHOLE = 12_000
"""Nodes up to which a run is bounded in one piece: cheaper so, and exact."""
SAMPLES = 20_000
"""Nodes from which the highest steady speed of the run is taken."""


TOUCHED = 2
"""How often planes are laid above limits that depend on the speed: more gain less than a tenth of a percent."""
LOOSE = 0.01
"""Share of the plan's time by which a bound is below it where further planes are worth a try."""


@dataclass(frozen=True)
class Bound:
    """A lower bound of a run's duration, for the problem on the mesh of its plan."""

    duration: float
    """Of the plan [s]."""
    mesh_duration: float
    """Of the plan, as the problem on the mesh counts it: the sum of weight / speed over the nodes [s]."""
    mesh_bound: float
    """No z that obeys the rows of that mesh has a smaller sum [s]."""
    places: Floats
    """(k, 3) from s, to s, seconds: where the relaxation stands still, which a plan may not. They keep the gap open."""
    steps: int

    @property
    def gap(self) -> float:
        """How far the plan may be from the best one on its mesh: like compared with like."""
        return max(self.mesh_duration / self.mesh_bound - 1.0, 0.0) if self.mesh_bound > 0.0 else np.inf

    @property
    def seconds(self) -> float:
        """The bound in the measure of the plan's duration: duration / (1 + gap), never above the duration [s]."""
        return self.duration / (1.0 + self.gap) if np.isfinite(self.duration) else 0.0


class Relaxation(NamedTuple):
    """What the relaxation of a problem by knots came to."""

    value: float
    """No z that obeys the rows, and lies in the ranges given, has a smaller sum."""
    dual: Floats
    """(points, 2 m, 2) the multipliers that prove it."""
    wait: Floats
    """(n,) how long each knot waits, as a pace."""
    c: Floats
    """(n + 2,) coefficients."""
    steps: int


class JoinedPieces:
    """Multipliers, caps and waits at a run's knots, put together from its pieces."""

    def __init__(self, run: AxisRun, limits: Limits, law: SplineLaw, ends: tuple[EndState, EndState]) -> None:
        n = len(law.nodes)
        self.run, self.limits, self.law, self.ends = run, limits, law, ends
        self.highest = highest_speed(run, limits, law, law.nodes[:: max(n // SAMPLES, 1)])
        self.gathered, self.cap, self.wait = np.zeros((n, dual.GATHERED)), np.empty(n), np.zeros(n)
        self.terms = 4 * limits.half
        self.lock = threading.Lock()

    def problem_ends(self, low: int, high: int) -> tuple[EndState, EndState]:
        """The states in which the piece between two nodes starts and ends."""
        law, n = self.law, len(self.law.nodes)
        start = self.ends[0] if low == 0 else EndState(np.sqrt(law.cells[low, 0]), law.cells[low, 1] / 2.0)
        end = self.ends[1] if high == n - 1 else EndState(np.sqrt(law.cells[high, 0]), law.cells[high, 1] / 2.0)
        return start, end

    def add(self, low: int, high: int, weight: Floats, first: int, last: int) -> int:
        """Add the multipliers of the piece of nodes `low` to `high`, times `weight`; caps and waits from first to last.

        Returns the number of steps it took.
        """
        law = self.law
        start, end = self.problem_ends(low, high)
        before, after = [self.run.s0] if start.at_rest else [], [self.run.s1] if end.at_rest else []
        nodes = law.nodes[low : high + 1]
        around = np.concatenate([before, nodes, after])
        knots = Knots(discretise(self.run, self.limits, around, start, end, self.highest, level=True))
        none = np.zeros(len(nodes))
        found = relaxed(knots, coefficients_of(nodes, law.cells[low:high]), none, knots.cap)
        mine = dual.gather(knots.as_knots(), none, found.dual, self.terms)
        with self.lock:
            self.gathered[low : high + 1] += weight[:, None] * mine
            self.cap[first : last + 1] = knots.cap[first - low : last + 1 - low]
            self.wait[first : last + 1] = found.wait[first - low : last + 1 - low]
        return found.steps

    def bound(self, steps: int) -> Bound:
        """The bound of the whole."""
        law = self.law
        mesh = OnMesh(law.nodes, law.rest, self.ends)
        weight = weights(law.nodes, law.rest)
        pace = 1.0 / np.sqrt(law.z_at_nodes())
        n = len(weight)
        # the rows have been gathered
        knots = dual.KnotRows(
            cubic_spline.basis_at_knots(law.nodes), np.zeros(n + 1, dtype=np.int64), weight, np.zeros(n + 2),
            np.empty((0, 2 * self.limits.half, 3)), mesh.as_ends(),
        )  # fmt: skip
        value, _, _ = dual.value_of(knots, np.zeros(n), self.cap, self.gathered, self.terms)
        return bound_of(law, law.nodes, weight, pace, self.wait, value, steps)


def relaxed(
    knots: Knots, c: Floats, low: Floats, high: Floats, tolerance: float = TOLERANCE, enough: float = np.inf
) -> Relaxation:
    """The relaxation of a problem with z from low (0: unknown) to high (n,), by a plan's c; `enough` ends it early."""
    start, relief = start_within(knots, c, low, high)
    if knots.lines is not None:
        return relaxed_over_lines(knots, c, (start, relief), low, high, tolerance)
    value, multipliers, wait, steps = relaxation.relax(
        knots.as_knots(), low, high, start, relief, tolerance, enough, MOST_STEPS
    )
    if len(knots.one_sided):
        multipliers[:, knots.one_sided, 1] = 0.0
        value = knots.value(multipliers, low, high)
    return Relaxation(value, multipliers, wait, start, steps)


def relaxed_over_lines(
    knots: Knots, c: Floats, begin: tuple[Floats, Floats], low: Floats, high: Floats, tolerance: float
) -> Relaxation:
    """The same with limits that depend on the speed; `begin` are coefficients and reliefs as `start_within` finds them.

    By planes that touch these limits where the plan is, then by further ones where that relaxation is faster. Planes
    that fall with z leave the more the faster a motion is, and their multipliers may tell nothing: then by others.
    """
    found: list[Relaxation] = []
    speeds = [np.sqrt(knots.state(c)[:, 0])]
    planned = float(knots.weight @ (1.0 / speeds[0]))
    for rising in (False,) * TOUCHED + (True,):
        if rising:
            if max(one.value for one in found) > (1.0 - LOOSE) * planned:
                break
            speeds = speeds[:1]
        within, factors = knots.within_planes(c, speeds, rising=rising)
        start = begin[0].copy()
        _, dual, wait, steps = relaxation.relax(
            within.as_knots(), low, high, start, begin[1], tolerance, np.inf, MOST_STEPS
        )
        dual = knots.multipliers(dual, factors)
        found.append(Relaxation(knots.value(dual, low, high), dual, wait, start, steps))
        speeds.append(np.sqrt(np.minimum(knots.state(start)[:, 0], knots.cap)))
    return max(found, key=lambda one: one.value)


def lower_bound(problem: Problem, law: SplineLaw) -> Bound:
    """The bound of a problem, given a plan for it, by its limits before any was lowered."""
    knots = Knots(problem)
    c = coefficients(law)
    found = relaxed(knots, c, np.zeros_like(knots.cap), knots.cap)
    pace = 1.0 / np.sqrt(knots.state(c)[:, 0])
    return bound_of(law, problem.nodes, knots.weight, pace, found.wait, found.value, found.steps)


def bound_of(
    law: SplineLaw, nodes: Floats, weight: Floats, pace: Floats, wait: Floats, value: float, steps: int
) -> Bound:
    """The bound `value` of a plan on its mesh, by weights, paces and waits at its nodes (n,)."""
    mesh_duration = float(weight @ pace)
    places = standstills(nodes, wait > STANDS_STILL * pace, weight * wait)
    kept = places[places[:, 2] > IN_GAP * (mesh_duration - value)]
    return Bound(law.duration, mesh_duration, value, kept, steps)


def standstills(nodes: Floats, marked: npt.NDArray[np.bool_], seconds: Floats) -> Floats:
    """(k, 3) first and last node of each row of marked ones, and the sum of their seconds."""
    edge = np.flatnonzero(np.diff(np.concatenate([[0], marked.astype(np.int8), [0]])))
    first, beyond = edge[::2], edge[1::2]
    total = np.concatenate([[0.0], np.cumsum(seconds)])
    return np.stack([nodes[first], nodes[beyond - 1], total[beyond] - total[first]], axis=1)


def bound_run(
    run: AxisRun,
    limits: Limits,
    law: SplineLaw,
    start: EndState = AT_REST,
    end: EndState = AT_REST,
    cache: CachedPath | None = None,
) -> Bound:
    """The bound of a run's plan where the problem that the plan solves is no longer at hand.

    `cache`: what is known of the path already.
    """
    return lower_bound(problem_of(run, limits, law, start, end, cache), law)


def problem_of(
    run: AxisRun, limits: Limits, law: SplineLaw, start: EndState, end: EndState, cache: CachedPath | None = None
) -> Problem:
    """The problem on the mesh of a law, its limits as they are given."""
    outer = [law.s0] if start.at_rest else [], [law.s1] if end.at_rest else []
    nodes = np.concatenate([outer[0], law.nodes, outer[1]])
    return discretise(run, limits, nodes, start, end, highest_speed(run, limits, law, law.nodes, cache), cache, True)


def highest_speed(
    run: AxisRun, limits: Limits, law: SplineLaw, s: Floats, cache: CachedPath | None = None
) -> float:
    """The highest z that the limits allow anywhere at steady speed, as seen at s (k,), or that is worth anything.

    Where all joints stand limits allow any; a plan's own z is never above.
    """
    length = run.s1 - run.s0
    z = law.z_at_nodes()
    worth = max(float(z.max()) / HIGHEST, fleeting(length, law.duration))
    steady = highest_of(*steady_speed((cache or run).with_cap, limits, s), length)
    return max(min(steady, worth), float(z[0]), float(z[-1]))


def places_in_time(run: AxisRun, law: SplineLaw, bound: Bound) -> tuple[OpenPlace, ...]:
    """Where the relaxation stands still, in time since the start of the run."""
    blocks = run.block_at(bound.places[:, 0])
    times = np.interp(bound.places[:, :2], law.nodes, law.times)
    return tuple(
        OpenPlace(start, end, seconds, block)
        for (start, end), seconds, block in zip(times.tolist(), bound.places[:, 2].tolist(), blocks.tolist())
    )


def coefficients(law: SplineLaw) -> Floats:
    """(n + 2,) coefficients of a law's spline, from its polynomials."""
    return coefficients_of(law.nodes, law.cells)


def coefficients_of(nodes: Floats, cells: Floats) -> Floats:
    """(n + 2,) coefficients of the spline over knots (n,) with these polynomials (n - 1, 4) in its cells.

    Each is the polar form of one of them at three knots.
    """
    n = len(nodes)
    middle = np.clip(np.arange(n + 2) - 1, 0, n - 1)
    cell = np.minimum(middle, n - 2)
    u, v, w = (nodes[np.clip(np.arange(n + 2) + shift, 0, n - 1)] - nodes[cell] for shift in (-2, -1, 0))
    a = cells[cell].T
    c: Floats = a[0] + a[1] * (u + v + w) / 3.0 + a[2] * (u * v + u * w + v * w) / 3.0 + a[3] * u * v * w
    return c


def bound_long_run(
    run: AxisRun,
    limits: Limits,
    law: SplineLaw,
    start: EndState = AT_REST,
    end: EndState = AT_REST,
    workers: Workers | None = None,
    progress: Progress = UNTOLD,
    cache: CachedPath | None = None,
) -> Bound:
    """The bound of a run's plan; that of a long run from pieces of it, on all cores. `cache` is as `bound_run` has it.
    """
    border, over = borders(law, OVERLAP_RAMPS * min(ramp_time(limits), law.duration))
    if len(border) == 2:
        return bound_run(run, limits, law, start, end, cache)
    joined = JoinedPieces(run, limits, law, (start, end))

    def one(k: int) -> int:
        first, last = int(border[k]), int(border[k + 1])
        low, high = first - int(over[k]), last + int(over[k + 1])
        place = np.arange(low, high + 1)
        share = np.ones(len(place))
        for at, reach, sign in ((first, over[k], 1.0), (last, over[k + 1], -1.0)):
            if reach:
                share *= np.clip(0.5 + sign * (place - at) / (2.0 * FADE * reach), 0.0, 1.0)
        return joined.add(low, high, share, first, last)

    steps = (workers or Workers()).each(one, range(len(border) - 1), progress)
    return joined.bound(max(steps))


def borders(law: SplineLaw, overlap: float) -> tuple[Ints, Ints]:
    """Nodes (k,) between which the pieces lie, and how many nodes pieces reach beyond them to cover a time."""
    last = len(law.nodes) - 1
    count = last // PIECE if last > WHOLE else 1
    while count > 1:
        border = np.linspace(0, last, count + 1).astype(np.int64)
        before, after = (np.searchsorted(law.times, law.times[border] + shift) for shift in (-overlap, overlap))
        over = np.maximum(np.maximum(border - before, after - border), LEAST_OVERLAP)
        over[[0, -1]] = 0
        if (border[:-1] + over[:-1] < border[1:] - over[1:]).all():
            return border, over
        count //= 2
    return np.array([0, last]), np.zeros(2, dtype=np.int64)
