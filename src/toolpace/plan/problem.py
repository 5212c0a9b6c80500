"""A run and its limits on a mesh: the rows that the core of the optimal planner takes."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from toolpace.axispath import AxisRun
from toolpace.kernels import cubic, envelope, speed
from toolpace.limits import Limits
from toolpace.plan.endstate import EndState
from toolpace.trajectory import limit_ratios

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

ALLOWED = 1.0 + 5e-5
"""Usage between nodes that is left alone; the guarantee is 1 + 1e-4."""
LEAST_REACH = 40
"""Fewest nodes on either side of a place that is mended."""


class Problem:
    """A run on a mesh, as the core takes it: rows at the nodes, on both sides where the run has a break.

    The core's spline has no node at an end at rest: ds/dt has a constant third derivative in that outermost cell,
    which gives z' = 4 z / (3 h) at its inner end and so ties two coefficients.
    """

    def __init__(self, nodes: Floats, rest: tuple[float, float], node: Ints, ends: tuple[EndState, EndState]) -> None:
        self.nodes, self.rest, self.node = nodes, rest, node
        self.basis = cubic.basis_at_knots(nodes)[node]
        self.end = np.array([speed.REST if state.at_rest else speed.MOVING for state in ends])
        first, last = (nodes[1] - nodes[0]) / 3.0, (nodes[-1] - nodes[-2]) / 3.0
        self.ratio = np.array(
            [
                1.0 + 4.0 * first / (3.0 * rest[0]) if rest[0] else 1.0,
                1.0 + 4.0 * last / (3.0 * rest[1]) if rest[1] else 1.0,
            ]
        )
        z0, z1 = ends[0].speed ** 2, ends[1].speed ** 2
        self.fixed = np.array([z0, z0 + 2.0 * ends[0].acceleration * first, z1 - 2.0 * ends[1].acceleration * last, z1])
        cell = np.diff(nodes)
        weight = (np.concatenate([[0.0], cell]) + np.concatenate([cell, [0.0]])) / 2.0
        weight[0] += 3.0 * rest[0]
        weight[-1] += 3.0 * rest[1]
        self.weight = (weight / np.bincount(node))[node]
        self.cap = np.empty(0)
        self.rows = np.empty((0, 0, 3))
        self.lowered = np.ones((len(nodes), 3))
        self.clock = np.arange(len(nodes), dtype=np.float64)
        """(n,) about when the nodes are passed [s]."""
        self.ramp = 8.0
        """Time in which an acceleration builds up [s]."""

    def around(self, first: int, last: int, ramps: float) -> tuple[int, int]:
        """Nodes from so many ramp times before the node `first` to as many after the node `last`."""
        low = int(np.searchsorted(self.clock, self.clock[first] - ramps * self.ramp))
        high = int(np.searchsorted(self.clock, self.clock[last] + ramps * self.ramp))
        return max(min(low, first - LEAST_REACH), 0), min(max(high, last + LEAST_REACH), len(self.nodes) - 1)

    def tighten(self, peak: Floats, overshoot: float, reach: int) -> None:
        """Lower the limits around the cells whose peaks (cells, 3) by kind pass what is allowed.

        They are lowered `overshoot` times as far as they were passed, since the solution moves on, and as far as
        `reach` nodes to either side: a limit that is lowered at single nodes only is passed between them.
        """
        excess = np.ones((len(self.nodes), 3))
        over = np.where(peak > ALLOWED, 1.0 + overshoot * (peak - 1.0), 1.0)
        for shift in range(1 - reach, reach + 1):
            low, high = max(shift, 0), min(len(over) + shift, len(excess))
            excess[low:high] = np.maximum(excess[low:high], over[low - shift : high - shift])
        self.lower(excess)

    def lower(self, by: Floats) -> None:
        """Divide the limits at the nodes by the factors (nodes, 3) of speed, acceleration and jerk."""
        self.lowered = self.lowered * by
        half = self.rows.shape[1] // 2
        at_point = by[self.node]
        self.cap /= at_point[:, 0] ** 2
        self.rows[:, :half] *= at_point[:, 1, None, None]
        self.rows[:, half:] *= at_point[:, 2, None, None]

    def stretch(self, low: int, high: int) -> Problem:
        """The part between two nodes, in motion at its ends where they are not those of the run.

        There the two outermost coefficients are given, so that everything outside stays as it is.
        """
        part = object.__new__(Problem)
        part.lowered, part.clock, part.ramp = self.lowered[low : high + 1], self.clock[low : high + 1], self.ramp
        mine = slice(*np.searchsorted(self.node, [low, high + 1]))
        part.nodes, part.rest = self.nodes[low : high + 1], self.rest
        part.node, part.basis, part.weight = self.node[mine] - low, self.basis[mine], self.weight[mine]
        part.cap, part.rows, part.ratio, part.fixed = self.cap[mine], self.rows[mine], self.ratio, self.fixed
        part.end = np.where([low == 0, high == len(self.nodes) - 1], self.end, speed.MOVING)
        return part


def discretise(run: AxisRun, limits: Limits, nodes: Floats, start: EndState, end: EndState) -> Problem:
    """The rows of a run at the nodes (n,) from s0 to s1."""
    inner = nodes[1 if start.at_rest else 0 : -1 if end.at_rest else len(nodes)]
    rest = (float(inner[0] - nodes[0]), float(nodes[-1] - inner[-1]))
    both = np.isin(inner, run.breaks)
    node = np.repeat(np.arange(len(inner)), 1 + both)
    point = inner[node]
    left = np.concatenate([node[1:] == node[:-1], [False]])
    point[left] = np.nextafter(point[left], -np.inf)
    point[-1] = min(point[-1], run.s1)
    q = run.evaluate(point)
    problem = Problem(inner, rest, node, (start, end))
    cap, steady, _ = envelope.pointwise(q, limits.velocity, limits.acceleration, limits.jerk, run.speed_cap(point))
    jerk = np.stack([q[3], 1.5 * q[2], q[1] / 2.0], axis=-1)
    acceleration = np.stack([q[2], q[1] / 2.0, np.zeros_like(q[1])], axis=-1)
    # Held at nodes only, acceleration could swing from cell to cell for ever: it is held half a cell further on.
    ahead = np.append(np.diff(inner) / 2.0, 0.0)[node]
    ahead[left] = 0.0
    acceleration += ahead[:, None, None] * jerk
    problem.rows = np.concatenate([acceleration / limits.acceleration[:, None], jerk / limits.jerk[:, None]], axis=1)
    half = len(limits)
    for k, (state, place) in enumerate(((start, 0), (end, -1))):
        if state.at_rest:
            cap[place] = min(cap[place], rest_cap(run, limits, inner[place], rest[k], forth=k == 0))
        else:
            # what the state fixes has been checked and is no row
            cap[place] = np.inf
            problem.rows[place, :half] = 0.0
    finite = np.isfinite(steady)
    highest = steady[finite].max() if finite.any() else ((run.s1 - run.s0) / 1e-6) ** 2
    problem.cap = np.minimum(cap, 1e3 * max(highest, start.speed**2, end.speed**2))
    return problem


def rest_cap(run: AxisRun, limits: Limits, node: float, length: float, forth: bool) -> float:
    """Most z at the inner end of a rest cell, such that nothing inside the cell breaks a limit.

    All states of the cell scale with that z: speeds with its root, accelerations with it, jerks with its power 3/2.
    """
    share = np.linspace(0.0, 1.0, 13)
    third = 2.0 / (9.0 * length**2)
    t = 3.0 * length * share
    sign = 1.0 if forth else -1.0
    rest = node - sign * length
    state = np.stack([rest + sign * third * t**3 / 6.0, third * t**2 / 2.0, sign * third * t, np.full(len(t), third)])
    side = np.where((share == 1.0) == forth, 0.0, 1.0)
    ratios = np.maximum(limit_ratios(run, limits, state, side), 1e-100)
    m = len(limits)
    return float(
        min(
            ratios[:, : 1 + m].max() ** -2.0,
            1.0 / ratios[:, 1 + m : 1 + 2 * m].max(),
            ratios[:, 1 + 2 * m :].max() ** (-2.0 / 3.0),
        )
    )
