"""A lower bound of the problem on its mesh, by a convex relaxation and weak duality."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from toolpace.common.arrays import Floats
from toolpace.kernels.optimal import relaxation
from toolpace.machine.limits import Limits
from toolpace.motion.laws import SplineLaw
from toolpace.motion.trajectory import OpenPlace
from toolpace.path.axis_run import AxisRun
from toolpace.planning.bound.problem import Knots, start_within
from toolpace.planning.endstate import AT_REST, EndState
from toolpace.planning.mesh.initial_guess import fleeting, highest_of, steady_speed
from toolpace.planning.optimal.problem import HIGHEST, Problem, discretise

TOLERANCE = 1e-5
"""What the bound may lose to an end of the iteration ahead of time, relative to the duration."""
MOST_STEPS = 150
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


def relaxed(
    knots: Knots, c: Floats, low: Floats, high: Floats, tolerance: float = TOLERANCE, enough: float = np.inf
) -> Relaxation:
    """The relaxation of a problem with z from low (0: unknown) to high (n,), by a plan's c; `enough` ends it early."""
    start, relief = start_within(knots, c, low, high)
    value, dual, wait, _, _, steps = relaxation.relax(
        knots.as_knots(), low, high, start, relief, tolerance, enough, MOST_STEPS
    )
    return Relaxation(value, dual, wait, start, steps)


def lower_bound(problem: Problem, law: SplineLaw) -> Bound:
    """The bound of a problem, given a plan for it, by its limits before any was lowered."""
    knots = Knots(problem)
    c = coefficients(law)
    found = relaxed(knots, c, np.zeros_like(knots.cap), knots.cap)
    pace = 1.0 / np.sqrt(knots.state(c)[:, 0])
    mesh_duration = float(knots.weight @ pace)
    places = standstills(problem.nodes, found.wait > STANDS_STILL * pace, knots.weight * found.wait)
    kept = places[places[:, 2] > IN_GAP * (mesh_duration - found.value)]
    return Bound(law.duration, mesh_duration, found.value, kept, found.steps)


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
    return lower_bound(problem_of(run, limits, law, start, end), law)


def problem_of(run: AxisRun, limits: Limits, law: SplineLaw, start: EndState, end: EndState) -> Problem:
    """The problem on the mesh of a law, its limits as they are given."""
    outer = [law.s0] if start.at_rest else [], [law.s1] if end.at_rest else []
    nodes = np.concatenate([outer[0], law.nodes, outer[1]])
    return discretise(run, limits, nodes, start, end, highest_speed(run, limits, law, law.nodes))


def highest_speed(run: AxisRun, limits: Limits, law: SplineLaw, s: Floats) -> float:
    """The highest z that the limits allow anywhere at steady speed, as seen at s (k,), or that is worth anything.

    Where all joints stand limits allow any; a plan's own z is never above.
    """
    length = run.s1 - run.s0
    z = law.z_at_nodes()
    worth = max(float(z.max()) / HIGHEST, fleeting(length, law.duration))
    return max(min(highest_of(*steady_speed(run, limits, s), length), worth), float(z[0]), float(z[-1]))


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
