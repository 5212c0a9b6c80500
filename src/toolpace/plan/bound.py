"""How far a plan may be from the best: a lower bound of the planner's problem on its mesh, by weak duality."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from toolpace.axispath import AxisRun
from toolpace.kernels import bound, speed
from toolpace.limits import Limits
from toolpace.plan.endstate import AT_REST, EndState
from toolpace.plan.problem import Problem, discretise
from toolpace.timelaw import SplineLaw

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

TOLERANCE = 1e-5
"""What the bound may lose to an end of the iteration ahead of time, relative to the duration."""
MOST_STEPS = 150
START_SHARE = 0.4
"""Share of the plan's z at which the relaxation is started."""
SETTLE_KNOTS = 30
"""Knots over which that share is reached from an end in motion."""
MARGIN = 0.01
STANDS_STILL = 0.01
"""Share of the pace from which the wait at a knot makes it part of a place that keeps the gap open."""
IN_GAP = 0.01
"""Least share of the gap that the waits of such a place sum to."""


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
        return self.duration / (1.0 + self.gap)


class Knots:
    """A problem by knots, its limits as they were before any was lowered.

    The points on either side of a break are one knot with the rows of both.
    """

    def __init__(self, problem: Problem) -> None:
        node, n = problem.node, len(problem.nodes)
        self.first = np.searchsorted(node, np.arange(n + 1))
        self.basis = np.ascontiguousarray(problem.basis[self.first[:-1]])
        self.weight = np.bincount(node, problem.weight, n)
        by = problem.lowered[node]
        self.cap = np.minimum.reduceat(problem.cap * by[:, 0] ** 2, self.first[:-1])
        self.rows = problem.rows.copy()
        half = self.rows.shape[1] // 2
        self.rows[:, :half] /= by[:, 1, None, None]
        self.rows[:, half:] /= by[:, 2, None, None]
        self.end, self.ratio, self.fixed = problem.end, problem.ratio, problem.fixed

    def state(self, c: Floats) -> Floats:
        """(n, 3) z, z', z'' at the knots."""
        out = np.empty((len(self.weight), 3))
        bound.at_knots(self.basis, c, out)
        return out

    def value(self, dual: Floats, low: Floats | None = None, high: Floats | None = None) -> float:
        """The bound by multipliers (points, rows, 2) >= 0 of the sum over all z between low and high (n,)."""
        low = np.zeros(len(self.weight)) if low is None else low
        high = self.cap if high is None else high
        return float(bound.dual_value(
            self.basis, self.first, self.weight, low, high, self.rows, dual, self.end, self.ratio, self.fixed
        )[0])  # fmt: skip


def start_within(knots: Knots, c: Floats, share: float = START_SHARE) -> tuple[Floats, Floats]:
    """Coefficients well inside, about `share` of c, and the reliefs (n, 2) of cap and acceleration they need."""
    place = np.arange(len(c), dtype=np.float64)
    far = np.full(len(c), np.inf)
    if knots.end[0] == speed.MOVING:
        far = np.minimum(far, place - 1.0)
    if knots.end[1] == speed.MOVING:
        far = np.minimum(far, place[::-1] - 1.0)
    inside = np.clip(far / SETTLE_KNOTS, 0.0, 1.0)
    start: Floats = c * (1.0 - (1.0 - share) * inside * inside * (3.0 - 2.0 * inside))
    u = knots.state(start)
    if u[:, 0].min() <= 0.0:
        start, u = c.copy(), knots.state(c)
    half = knots.rows.shape[1] // 2
    at_point = np.repeat(u, np.diff(knots.first), axis=0)
    of_point = np.abs(np.einsum("pri,pi->pr", knots.rows[:, :half], at_point)).max(axis=1)
    used = np.stack([u[:, 0] / knots.cap, np.maximum.reduceat(of_point, knots.first[:-1])], axis=1)
    excess = used - (1.0 - MARGIN)
    relief = np.where(excess > 0.0, 1.5 * excess + MARGIN, 0.0)
    relief[:, 0] *= knots.cap
    return start, relief


def lower_bound(problem: Problem, law: SplineLaw) -> Bound:
    """The bound of a problem, given a plan for it, by its limits before any was lowered."""
    knots = Knots(problem)
    c = coefficients(law)
    start, relief = start_within(knots, c)
    value, _, wait, _, _, steps = bound.relax(
        knots.basis, knots.first, knots.weight, knots.cap, knots.rows, start, relief, knots.end, knots.ratio,
        knots.fixed, 1.0, TOLERANCE, MOST_STEPS,
    )  # fmt: skip
    pace = 1.0 / np.sqrt(knots.state(c)[:, 0])
    mesh_duration = float(knots.weight @ pace)
    places = standstills(problem.nodes, wait > STANDS_STILL * pace, knots.weight * wait)
    kept = places[places[:, 2] > IN_GAP * (mesh_duration - value)]
    return Bound(law.duration, mesh_duration, float(value), kept, int(steps))


def standstills(nodes: Floats, marked: npt.NDArray[np.bool_], seconds: Floats) -> Floats:
    """(k, 3) first and last node of each row of marked ones, and the sum of their seconds."""
    edge = np.flatnonzero(np.diff(np.concatenate([[0], marked.astype(np.int8), [0]])))
    first, beyond = edge[::2], edge[1::2]
    total = np.concatenate([[0.0], np.cumsum(seconds)])
    return np.stack([nodes[first], nodes[beyond - 1], total[beyond] - total[first]], axis=1)


def bound_run(
    run: AxisRun, limits: Limits, law: SplineLaw, start: EndState = AT_REST, end: EndState = AT_REST
) -> Bound:
    """The bound of a run's plan where the problem that the plan solves is no longer at hand."""
    outer = [law.s0] if start.at_rest else [], [law.s1] if end.at_rest else []
    nodes = np.concatenate([outer[0], law.nodes, outer[1]])
    return lower_bound(discretise(run, limits, nodes, start, end), law)


def coefficients(law: SplineLaw) -> Floats:
    """(n + 2,) coefficients of a law's spline, from its polynomials: each is the polar form of one at three knots."""
    x, n = law.nodes, len(law.nodes)
    middle = np.clip(np.arange(n + 2) - 1, 0, n - 1)
    cell = np.minimum(middle, n - 2)
    u, v, w = (x[np.clip(np.arange(n + 2) + shift, 0, n - 1)] - x[cell] for shift in (-2, -1, 0))
    a = law.cells[cell].T
    c: Floats = a[0] + a[1] * (u + v + w) / 3.0 + a[2] * (u * v + u * w + v * w) / 3.0 + a[3] * u * v * w
    return c
