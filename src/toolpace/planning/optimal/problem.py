"""The optimisation problem of a run on a mesh: rows of limits for the solver, and speed caps of the cells at rest."""

from __future__ import annotations

from copy import copy
from typing import Any

import numpy as np
import numpy.typing as npt

from toolpace.common.arrays import Floats, Ints
from toolpace.kernels.motion import cubic_spline
from toolpace.kernels.optimal import first_guess, limit_rows, newton
from toolpace.machine.limits import Limits
from toolpace.motion.usage import ratios_along, unexplained
from toolpace.path.axis_run import AxisRun
from toolpace.planning.mesh.initial_guess import highest_of
from toolpace.planning.optimal.own_rows import LineRows, with_own_rows
from toolpace.planning.path_at_probes import CachedPath
from toolpace.planning.planned_run import EndState

AT_NODE = 0.02
"""Share of a cell up to which a break belongs to a node: breaks closer together than nodes are one place."""
HIGHEST = 1e3
"""Cap on z where nothing else is one, as a multiple of the highest z at steady speed."""
REST_STATES, CLOSER_AT_REST = 65, 3
"""States of a rest cell that are looked at, and places of which the surroundings are looked at so again: on a coarse
mesh it is long."""

REST_POWERS = np.array([2.0, 1.0, 2.0 / 3.0])
"""By what power of a limit of speed, acceleration or jerk the z at the inner end of a rest cell grows."""


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


def weights(places: Floats, rest: tuple[float, float]) -> Floats:
    """(n,) of the pace 1 / sqrt(z) at places (n,) in the time of a run: by trapezoids between them."""
    cell = np.diff(places)
    weight: Floats = (np.concatenate([[0.0], cell]) + np.concatenate([cell, [0.0]])) / 2.0
    weight[0] += 3.0 * rest[0]
    weight[-1] += 3.0 * rest[1]
    return weight


class Problem(OnMesh):
    """A run on a mesh, as the core takes it: rows at nodes, on both sides of a break, and at places between them."""

    def __init__(self, nodes: Floats, rest: tuple[float, float], node: Ints, ends: tuple[EndState, EndState]) -> None:
        super().__init__(nodes, rest, ends)
        self.node = node
        """(points,) of each point its node, or the one before it; ascending."""
        self.inside = np.zeros(len(node), dtype=np.bool_)
        """(points,) those between two nodes."""
        self.place = nodes[node]
        """(points,) s."""
        self.first, self.basis = as_cells(nodes, node, with_fourth(cubic_spline.basis_at_knots(nodes))[node])
        self.weight = (weights(nodes, rest) / np.bincount(node))[node]
        self.cap = np.empty(0)
        self.most = np.inf
        """What no cap on z is above."""
        self.rows = np.empty((0, 0, 3))
        self.shift = np.empty((0, 0))
        """(points, rows) constants of the rows; empty where all are zero."""
        self.lines: LineRows | None = None
        """Those of the rows whose limits depend on the speed, which `rows` and `shift` have linear in z."""

    def as_points(self) -> limit_rows.PointRows:
        """The rows as the kernels take them."""
        return limit_rows.PointRows(self.basis, self.first, self.weight, self.cap, self.rows, self.shift)

    def take_rows(self, rows: Floats, lines: LineRows | None) -> None:
        """Take the rows (points, 2 h, 3); those whose limits depend on the speed are linear next to rest."""
        self.rows, self.lines = rows, lines
        if lines is not None:
            self.shift = np.zeros(rows.shape[:2])
            self._make_linear(np.zeros((len(rows), len(lines.column))))

    def _make_linear(self, x: Floats) -> None:
        """Set the rows whose limits depend on the speed as they are linear at ds/dt x (points, k)."""
        assert self.lines is not None
        self.rows[:, self.lines.column], self.shift[:, self.lines.column] = self.lines.linear(x)

    def about(self, c: Floats) -> Problem:
        """With limits that depend on the speed made linear at the speeds of coefficients c (n,)."""
        if self.lines is None:
            return self
        part = copy(self)
        part.rows, part.shift = self.rows.copy(), self.shift.copy()
        part._make_linear(self.lines.speeds(self.basis, c[self.first[:, None] + np.arange(4)]))
        return part

    def exceeded_by(self, c: Floats) -> float:
        """By how much coefficients c (n,) exceed limits that depend on the speed, as a share of the largest."""
        return 0.0 if self.lines is None else self.lines.exceeded_by(self.basis, c[self.first[:, None] + np.arange(4)])

    def time(self, c: Floats) -> float:
        """The sum of weight / sqrt(z) over the points, from coefficients c (n,) [s]."""
        z = (self.basis[:, 0] * c[self.first[:, None] + np.arange(4)]).sum(axis=1)
        return float((self.weight / np.sqrt(z)).sum())

    def lowered(self, by: Floats, between: Floats) -> Problem:
        """With limits divided by factors of speed, acceleration and jerk: (nodes, 3) at nodes, (k, 3) at places between
        them."""
        at_point = by[self.node]
        at_point[self.inside] = between
        part = copy(self)
        part.cap, part.rows = limit_rows.lowered(self.cap, self.rows, at_point)
        if self.lines is not None:
            part.lines = self.lines.times(at_point[:, 1:])
        return part

    def raised(self, by: float) -> Problem:
        """With limits that are higher by this share."""
        if by == 0.0:
            return self
        part = copy(self)
        part.cap, part.rows = self.cap * (1.0 + by) ** 2, self.rows / (1.0 + by)
        if self.lines is not None:
            part.lines = self.lines.times(np.full((len(self.cap), 2), 1.0 / (1.0 + by)))
        return part

    def stretch(self, low: int, high: int) -> Problem:
        """The part between two nodes, in motion at its ends where they are not those of the run.

        There the two outermost coefficients are given, so that everything outside stays as it is.
        """
        if low == 0 and high == len(self.nodes) - 1:
            return self
        part = copy(self)
        first, last, beyond = np.searchsorted(self.node, [low, high, high + 1])
        mine = slice(first, last + np.count_nonzero(~self.inside[last:beyond]))
        part.nodes = self.nodes[low : high + 1]
        part.node, part.inside, part.place = self.node[mine] - low, self.inside[mine], self.place[mine]
        part.first, part.basis = as_cells(part.nodes, self.first[mine] - low, self.basis[mine])
        part.cap, part.rows, part.weight = self.cap[mine], self.rows[mine], self.weight[mine]
        if self.lines is not None:
            part.shift, part.lines = self.shift[mine], self.lines.at(mine)
        part.end = np.where([low == 0, high == len(self.nodes) - 1], self.end, newton.MOVING)
        return part


def discretise(
    run: AxisRun, limits: Limits, nodes: Floats, start: EndState, end: EndState, highest: float | None = None,
    cache: CachedPath | None = None, level: bool = False,
) -> Problem:  # fmt: skip
    """The rows of a run, or of a part of it, at the nodes (n,) from end to end.

    `highest` is the highest z that the limits allow anywhere at steady speed (default: at these nodes); `cache`, what
    is known of the path already. With `level`, what has limits that depend on the speed is held at the nodes
    themselves, not ahead of them, as the bound takes it.
    """
    inner = nodes[1 if start.at_rest else 0 : -1 if end.at_rest else len(nodes)]
    rest = (float(inner[0] - nodes[0]), float(nodes[-1] - inner[-1]))
    node, point, left = sides(inner, run.breaks[slice(*np.searchsorted(run.breaks, [nodes[0], nodes[-1]]))])
    point = np.clip(point, run.s0, run.s1)
    problem = Problem(inner, rest, node, (start, end))
    # Held at nodes only, acceleration could swing from cell to cell for ever: it is held half a cell further on.
    ahead = np.append(np.diff(inner) / 2.0, 0.0)[node]
    ahead[left] = 0.0
    cap, scale, rows, lines = rows_at(cache or run, limits, point, ahead, level)
    for k, (state, place) in enumerate(((start, 0), (end, -1))):
        if state.at_rest:
            cap[place] = min(cap[place], cached_rest_cap(run, limits, inner[place], rest[k], k == 0, cache))
        else:
            # what the state fixes has been checked and is no row; acceleration further on is not fixed
            here = node == node[place]
            cap[here] = np.inf
            fixed = here & (ahead == 0.0)
            rows[fixed, : limits.half] = 0.0
            lines = None if lines is None else lines.without_acceleration(fixed)
    problem.take_rows(rows, lines)
    if highest is None:
        highest = max(highest_of(*scale, run.s1 - run.s0), start.speed**2, end.speed**2)
    problem.most = HIGHEST * highest
    problem.cap = np.minimum(cap, problem.most)
    return problem


def rows_at(
    run: AxisRun | CachedPath, limits: Limits, s: Floats, ahead: Floats, level: bool = False
) -> tuple[Floats, tuple[Floats, Floats], Floats, LineRows | None]:
    """Caps on z (n,), z at steady speed and d3s/dt3 at rest (n,), and rows (n, 2 h, 3) at s (n,), h as `Limits.half`,
    and those of them whose limits depend on the speed.

    Acceleration is held `ahead` (n,) of its place; where limits depend on the speed, not with `level`.
    """
    q, cap = run.with_cap(s)
    q = np.ascontiguousarray(q)
    most, *scale = first_guess.pointwise(q, limits.velocity, limits.acceleration, limits.jerk, cap)
    rows, lines = limit_rows.rows_of(q, ahead, limits.acceleration, limits.jerk), None
    if limits.rows:
        ahead = np.zeros_like(ahead) if level and limits.depend_on_speed else ahead
        q_ahead = np.ascontiguousarray(run.with_cap(s + ahead)[0]) if ahead.any() else q
        rows, lines = with_own_rows(rows, limits, q, q_ahead, ahead)
    return most, (scale[0], scale[1]), rows, lines


def with_rows_between(problem: Problem, run: AxisRun, limits: Limits, places: Floats) -> Problem:
    """The problem with the rows of further places (k,) between its nodes, ascending."""
    if not len(places):
        return problem
    cap, _, rows, lines = rows_at(run, limits, places, np.zeros(len(places)))
    cell = np.searchsorted(problem.nodes, places, side="right") - 1
    is_new = limit_rows.order_with(problem.node, problem.inside, problem.place, cell, places) >= len(problem.node)
    at, at_new = np.flatnonzero(~is_new), np.flatnonzero(is_new)

    def merged(old: npt.NDArray[Any], new: npt.NDArray[Any] | bool) -> npt.NDArray[Any]:
        out = np.empty((len(is_new), *old.shape[1:]), dtype=old.dtype)
        out[at], out[at_new] = old, new
        return out

    more = copy(problem)
    more.node, more.first = merged(problem.node, cell), merged(problem.first, cell)
    more.inside, more.place = merged(problem.inside, True), merged(problem.place, places)
    more.basis = merged(problem.basis, cubic_spline.basis_between(problem.nodes, cell, places))
    more.cap = merged(problem.cap, np.minimum(cap, problem.most))
    if problem.lines is None or lines is None:
        more.rows = merged(problem.rows, rows)
    else:
        of_points = [merged(old, new) for old, new in zip(problem.lines[2:], lines[2:])]
        both = LineRows(lines.column, lines.is_jerk, *of_points)
        more.take_rows(merged(problem.rows, rows), both)
    # both sides of a break are one place
    new = np.concatenate([[True], np.diff(more.place) > 0.0])
    own = np.cumsum(new) - 1
    more.weight = (weights(more.place[new], problem.rest) / np.bincount(own))[own]
    return more


def with_fourth(basis: Floats, before: bool = False) -> Floats:
    """(points, 3, 4) the basis (points, 3, 3) at knots with a zero for the coefficient behind, or `before`, them."""
    none = np.zeros((len(basis), 3, 1))
    return np.concatenate([none, basis] if before else [basis, none], axis=2)


def as_cells(nodes: Floats, first: Ints, basis: Floats) -> tuple[Ints, Floats]:
    """First coefficients (points,) and basis (points, 3, 4), points at the last node being the end of the last cell."""
    at_end = np.searchsorted(first, len(nodes) - 1)
    if at_end < len(first):
        basis = np.concatenate([basis[:at_end], with_fourth(basis[at_end:, :, :3], before=True)])
    return np.minimum(first, len(nodes) - 2), np.ascontiguousarray(basis)


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


def cached_rest_cap(
    run: AxisRun, limits: Limits, node: float, length: float, forth: bool, cache: CachedPath | None
) -> float:
    """As `rest_cap`, which is worked out once for each such cell of a run."""
    if cache is None:
        return rest_cap(run, limits, node, length, forth)
    cell = float(node), -length if forth else length
    if cell not in cache.rest_caps:
        cache.rest_caps[cell] = rest_cap(run, limits, node, length, forth)
    return cache.rest_caps[cell]


def rest_cap(run: AxisRun, limits: Limits, node: float, length: float, forth: bool) -> float:
    """Most z at the inner end of a rest cell, such that nothing inside the cell breaks a limit.

    It is looked at where its ends are near, where the path does more between two places than it tells at both, and then
    around the places that allow least.
    """
    share = (1.0 - np.cos(np.linspace(0.0, np.pi, REST_STATES))) / 2.0
    allowed = rest_caps(run, limits, node, length, forth, share)
    at_breaks = allowed[REST_STATES:].min(initial=np.inf)
    hidden, of_hidden = hidden_rest_caps(run, limits, node, length, forth, share, float(allowed.min()))
    share, allowed = np.append(share, hidden), np.append(allowed[:REST_STATES], of_hidden)
    for _ in range(2 if len(hidden) else 1):
        order = np.argsort(share, kind="stable")
        share, allowed = share[order], allowed[order]
        lowest, last = np.argsort(allowed)[:CLOSER_AT_REST], len(share) - 1
        low, high = share[np.maximum(lowest - 1, 0)], share[np.minimum(lowest + 1, last)]
        between = np.unique(np.linspace(low, high, REST_STATES))
        closer = rest_caps(run, limits, node, length, forth, between)[: len(between)]
        share, allowed = np.append(share, between), np.append(allowed, closer)
    return float(min(allowed.min(), at_breaks))


def hidden_rest_caps(
    run: AxisRun, limits: Limits, node: float, length: float, forth: bool, share: Floats, most: float
) -> tuple[Floats, Floats]:
    """Places between these ascending shares (k,) of a rest cell's time where the path does more than it tells there, at
    `most` so much z at the inner end; as such shares (n,), and most z by the limits at them (n,)."""
    sign = 1.0 if forth else -1.0
    rest = node - sign * length
    shares, caps = [np.empty(0)], [np.empty(0)]

    def path_at(places: Floats) -> Floats:
        return np.ascontiguousarray(run.evaluate(np.clip(places, run.s0, run.s1)))

    def look(places: Floats) -> tuple[Floats, Floats]:
        at = np.cbrt((places - rest) * sign / length)
        shares.append(at)
        caps.append(rest_caps(run, limits, node, length, forth, at)[: len(at)])
        return path_at(places), np.sqrt(most) * at * at

    s, speed = rest + sign * length * share**3, np.sqrt(most) * share * share
    s[-1] = node
    if not forth:
        s, speed = s[::-1].copy(), speed[::-1]
    path = path_at(s)
    low, high = (np.ascontiguousarray(part) for part in (path[:, :-1], path[:, 1:]))
    unexplained(run, limits, s[:-1], s[1:], low, high, np.maximum(speed[:-1], speed[1:]), look)
    return np.concatenate(shares), np.concatenate(caps)


def rest_caps(run: AxisRun, limits: Limits, node: float, length: float, forth: bool, share: Floats) -> Floats:
    """Most z at the inner end of a rest cell by the limits at shares (k,) of its time, and at both sides of breaks."""
    least: Floats = rest_caps_by_limit(run, limits, node, length, forth, share).min(axis=1)
    return least


def rest_caps_by_limit(
    run: AxisRun, limits: Limits, node: float, length: float, forth: bool, share: Floats
) -> Floats:
    """The same by each limit, (n, k) in the order of `Limits.names`.

    All states of the cell scale with that z: speeds with its root, accelerations with it, jerks with its power 3/2.
    """
    sign = 1.0 if forth else -1.0
    rest = node - sign * length
    breaks = run.breaks[(run.breaks > min(rest, node)) & (run.breaks < max(rest, node))]
    inside = np.cbrt((breaks - rest) * sign / length)
    side = np.concatenate([np.where((share == 1.0) == forth, 0.0, 1.0), np.zeros(len(inside)), np.ones(len(inside))])
    third = 2.0 / (9.0 * length**2)
    t = 3.0 * length * np.concatenate([share, inside, inside])
    state = np.stack([rest + sign * third * t**3 / 6.0, third * t**2 / 2.0, sign * third * t, np.full(len(t), third)])
    # rounded, the node could lie beyond a break that is there, and the breaks on the other side of themselves
    state[0, : len(share)][share == 1.0], state[0, len(share) :] = node, np.tile(breaks, 2)
    ratios, path = ratios_along(run, limits, state, side)
    ratios = np.maximum(ratios, 1e-100)
    for order, power in enumerate(REST_POWERS):
        ratios[:, limits.orders == order] **= -power
    for column, rows in enumerate(limits.rows, len(limits.names) - len(limits.rows)):
        if rows.lines is not None:
            ratios[:, column] = rows.most_z(path, state[1], rows.values(path, state))
    return ratios
