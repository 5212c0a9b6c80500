"""A run and its limits on a mesh: the rows that the core of the optimal planner takes."""

from __future__ import annotations

from copy import copy

import numpy as np
import numpy.typing as npt

from toolpace.arrays import Floats, Ints
from toolpace.axispath.run import AxisRun
from toolpace.kernels.motion import cubic_spline
from toolpace.kernels.optimal import first_guess, limit_rows, newton
from toolpace.machine.limits import Limits
from toolpace.motion import limit_ratios
from toolpace.planning.endstate import EndState
from toolpace.planning.mesh.guess import highest_of

AT_NODE = 0.02
"""Share of a cell up to which a break belongs to a node: breaks closer together than nodes are one place."""
REST_STATES = 129
"""States of a rest cell that are looked at: on a coarse mesh it is long."""
HIGHEST = 1e3
"""Cap on z where nothing else is one, as a multiple of the highest z at steady speed."""


class OnMesh:
    """A spline's knots along a run, or along a part of it, and its ends.

    There is no knot at an end at rest: ds/dt has a constant third derivative in that outermost cell, which gives
    z' = 4 z / (3 h) at its inner end and so ties two coefficients.
    """

    def __init__(self, nodes: Floats, rest: tuple[float, float], ends: tuple[EndState, EndState]) -> None:
        self.nodes, self.rest = nodes, rest
        self.end = np.array([newton.REST if state.at_rest else newton.MOVING for state in ends])
        first, last = (nodes[1] - nodes[0]) / 3.0, (nodes[-1] - nodes[-2]) / 3.0
        self.ratio = np.array(
            [
                1.0 + 4.0 * first / (3.0 * rest[0]) if rest[0] else 1.0,
                1.0 + 4.0 * last / (3.0 * rest[1]) if rest[1] else 1.0,
            ]
        )
        z0, z1 = ends[0].speed ** 2, ends[1].speed ** 2
        self.fixed = np.array([z0, z0 + 2.0 * ends[0].acceleration * first, z1 - 2.0 * ends[1].acceleration * last, z1])

    def as_ends(self) -> newton.Ends:
        """The ends as the kernels take them."""
        return newton.Ends(self.end, self.ratio, self.fixed)


def node_weights(nodes: Floats, rest: tuple[float, float]) -> Floats:
    """(n,) of the pace 1 / sqrt(z) at the nodes in the time of a run."""
    cell = np.diff(nodes)
    weight: Floats = (np.concatenate([[0.0], cell]) + np.concatenate([cell, [0.0]])) / 2.0
    weight[0] += 3.0 * rest[0]
    weight[-1] += 3.0 * rest[1]
    return weight


class Problem(OnMesh):
    """A run on a mesh, as the core takes it: rows at the nodes, on both sides where the run has a break."""

    def __init__(self, nodes: Floats, rest: tuple[float, float], node: Ints, ends: tuple[EndState, EndState]) -> None:
        super().__init__(nodes, rest, ends)
        self.node = node
        self.basis = cubic_spline.basis_at_knots(nodes)[node]
        self.weight = (node_weights(nodes, rest) / np.bincount(node))[node]
        self.cap = np.empty(0)
        self.rows = np.empty((0, 0, 3))
        self.lowered = np.ones((len(nodes), 3))

    def as_points(self) -> limit_rows.PointRows:
        """The rows as the kernels take them."""
        return limit_rows.PointRows(self.basis, self.node, self.weight, self.cap, self.rows)

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
        part = copy(self)
        mine = slice(*np.searchsorted(self.node, [low, high + 1]))
        part.nodes, part.lowered = self.nodes[low : high + 1], self.lowered[low : high + 1]
        part.node, part.basis, part.weight = self.node[mine] - low, self.basis[mine], self.weight[mine]
        part.cap, part.rows = self.cap[mine], self.rows[mine]
        part.end = np.where([low == 0, high == len(self.nodes) - 1], self.end, newton.MOVING)
        return part


def discretise(
    run: AxisRun, limits: Limits, nodes: Floats, start: EndState, end: EndState, highest: float | None = None
) -> Problem:
    """The rows of a run, or of a part of it, at the nodes (n,) from end to end.

    `highest` is the highest z that the limits allow anywhere at steady speed (default: at these nodes).
    """
    inner = nodes[1 if start.at_rest else 0 : -1 if end.at_rest else len(nodes)]
    rest = (float(inner[0] - nodes[0]), float(nodes[-1] - inner[-1]))
    node, point, left = sides(inner, run.breaks[slice(*np.searchsorted(run.breaks, [nodes[0], nodes[-1]]))])
    point = np.clip(point, run.s0, run.s1)
    q = np.ascontiguousarray(run.evaluate(point))
    problem = Problem(inner, rest, node, (start, end))
    cap, steady, _ = first_guess.pointwise(q, limits.velocity, limits.acceleration, limits.jerk, run.speed_cap(point))
    # Held at nodes only, acceleration could swing from cell to cell for ever: it is held half a cell further on.
    ahead = np.append(np.diff(inner) / 2.0, 0.0)[node]
    ahead[left] = 0.0
    problem.rows = limit_rows.rows_of(q, ahead, limits.acceleration, limits.jerk)
    half = len(limits)
    for k, (state, place) in enumerate(((start, 0), (end, -1))):
        if state.at_rest:
            cap[place] = min(cap[place], rest_cap(run, limits, inner[place], rest[k], forth=k == 0))
        else:
            # what the state fixes has been checked and is no row; acceleration further on is not fixed
            here = node == node[place]
            cap[here] = np.inf
            problem.rows[here & (ahead == 0.0), :half] = 0.0
    if highest is None:
        highest = max(highest_of(steady, run.s1 - run.s0), start.speed**2, end.speed**2)
    problem.cap = np.minimum(cap, HIGHEST * highest)
    return problem


def sides(nodes: Floats, breaks: Floats) -> tuple[Ints, Floats, npt.NDArray[np.bool_]]:
    """The points whose rows a problem holds: the nodes, and both sides of each break that is one place with a node.

    Returns the node of each point, its parameter, and whether others of its node come after it.
    """
    at = np.clip(np.searchsorted(nodes, breaks), 1, len(nodes) - 1)
    at -= breaks - nodes[at - 1] < nodes[at] - breaks
    cell = np.concatenate([[np.inf], np.diff(nodes), [np.inf]])
    near = np.abs(breaks - nodes[at]) <= AT_NODE * np.minimum(cell[at], cell[at + 1])
    at, breaks = at[near], breaks[near]
    single = np.setdiff1d(np.arange(len(nodes)), at)
    node = np.concatenate([single, np.repeat(at, 2)])
    point = np.concatenate([nodes[single], np.stack([np.nextafter(breaks, -np.inf), breaks], axis=1).ravel()])
    order = np.argsort(node, kind="stable")
    node = node[order]
    return node, point[order], np.concatenate([node[1:] == node[:-1], [False]])


def rest_cap(run: AxisRun, limits: Limits, node: float, length: float, forth: bool) -> float:
    """Most z at the inner end of a rest cell, such that nothing inside the cell breaks a limit.

    All states of the cell scale with that z: speeds with its root, accelerations with it, jerks with its power 3/2.
    """
    sign = 1.0 if forth else -1.0
    rest = node - sign * length
    share = np.linspace(0.0, 1.0, REST_STATES)
    # both sides of the breaks in it too
    breaks = run.breaks[(run.breaks > min(rest, node)) & (run.breaks < max(rest, node))]
    inside = np.cbrt((breaks - rest) * sign / length)
    side = np.concatenate([np.where((share == 1.0) == forth, 0.0, 1.0), np.zeros(len(inside)), np.ones(len(inside))])
    share = np.concatenate([share, inside, inside])
    third = 2.0 / (9.0 * length**2)
    t = 3.0 * length * share
    state = np.stack([rest + sign * third * t**3 / 6.0, third * t**2 / 2.0, sign * third * t, np.full(len(t), third)])
    state[0, REST_STATES:] = np.tile(breaks, 2)
    ratios = np.maximum(limit_ratios(run, limits, state, side), 1e-100)
    m = len(limits)
    return float(
        min(
            ratios[:, : 1 + m].max() ** -2.0,
            1.0 / ratios[:, 1 + m : 1 + 2 * m].max(),
            ratios[:, 1 + 2 * m :].max() ** (-2.0 / 3.0),
        )
    )
