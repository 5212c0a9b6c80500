"""The planner's problem by knots, for the relaxation and the dual function."""

from __future__ import annotations

import itertools
from copy import copy

import numpy as np
import numpy.typing as npt

from toolpace.common.arrays import Floats, Ints
from toolpace.kernels.motion import cubic_spline
from toolpace.kernels.optimal import newton, relaxation_knots, relaxation_work
from toolpace.kernels.optimal.dual import KnotRows, dual_value, lowest_with_root
from toolpace.planning.optimal.own_rows import LineRows
from toolpace.planning.optimal.problem import Problem
from toolpace.planning.optimal.solve import relief_of

START_SHARE = 0.4
"""Share of a plan's z at which the relaxation is started."""
HALVINGS = 60
"""Of an interval in which a least value is looked for."""
ROUNDING = 1e-13
"""Share of the sums that a bound with several lines for a piece is charged for rounding."""
TELLS = 1e-6
"""Share of the price of the pace from which that of sqrt(z) at the highest z makes a difference between such lines."""
LEAST_ROOM = 0.7
"""Share of a limit that depends on the speed by which a row that the relaxation has by the pace must be inside on its
other side, where it is held as well."""
SETTLE_KNOTS = 30
"""Knots over which that share is reached from an end in motion."""
PADDING = 40
"""Knots over which a change of the spline dies away: to a quarter at each, so to less than a rounding."""


class Knots:
    """A problem by knots: that of the limits as they are, which the planner may have lowered for itself.

    The points on either side of a break are one knot with the rows of both.
    """

    def __init__(self, problem: Problem) -> None:
        node, n = problem.node, len(problem.nodes)
        self.first = np.searchsorted(node, np.arange(n + 1))
        self.basis = cubic_spline.basis_at_knots(problem.nodes)
        self.weight = np.asarray(np.bincount(node, problem.weight, n), dtype=np.float64)
        self.price = np.zeros(n + 2)
        """(n + 2,) of the coefficients, where what surrounds a part is priced."""
        self.cap = np.minimum.reduceat(problem.cap, self.first[:-1])
        self.rows, self.shift, self.root, self.lines = problem.rows, np.empty((0, 0)), np.empty((0, 0)), problem.lines
        if self.lines is not None:
            self._take_lines(self.lines)
        self.end, self.ratio, self.fixed = problem.end, problem.ratio, problem.fixed

    def as_knots(self) -> KnotRows:
        """The problem as the kernels take it."""
        ends = newton.Ends(self.end, self.ratio, self.fixed)
        return KnotRows(self.basis, self.first, self.weight, self.price, self.rows, ends, self.shift, self.root)

    def _take_lines(self, lines: LineRows) -> None:
        """Set the rows whose limits depend on the speed as they are, with constants and multiples of sqrt(z)."""
        rows, shift, root = lines.scaled(*lines.over_range(np.sqrt(np.repeat(self.cap, np.diff(self.first)))))
        self.rows = self.rows.copy()
        self.shift, self.root = np.zeros(self.rows.shape[:2]), np.zeros(self.rows.shape[:2])
        self.rows[:, lines.column], self.shift[:, lines.column], self.root[:, lines.column] = rows, shift, root

    def _local(self, x: Floats) -> tuple[Floats, Floats]:
        """(points, k) constants and multiples of sqrt(z) of the rows of acceleration by their largest lines at x
        (points, k); those of jerk as they are."""
        assert self.lines is not None
        shift, root = self.shift[:, self.lines.column], self.root[:, self.lines.column]
        height, fall = self.lines.chosen(x)
        scale = np.abs(self.lines.height.max(axis=2)) + 1.0
        is_jerk = self.lines.is_jerk
        return np.where(is_jerk, shift, 1.0 - height / scale), np.where(is_jerk, root, fall / scale)

    def _gained_by_choices(self, dual: Floats, kappa: Floats, theta: Floats, high: Floats) -> float:
        """What the dual function gains where the largest of several lines counts, over one line above all of them."""
        lines = self.lines
        assert lines is not None
        price = dual[:, lines.column, 0] - dual[:, lines.column, 1]
        price[:, lines.is_jerk] = 0.0
        scale = np.abs(lines.height.max(axis=2)) + 1.0
        root = self.by_knot((price * self.root[:, lines.column]).sum(axis=1))
        some = root * high > TELLS * np.maximum(kappa, 0.0)
        some[[0, -1]] &= self.end == newton.REST
        point = np.repeat(some, np.diff(self.first))
        first = np.concatenate([[0], np.cumsum(np.diff(self.first)[some])])
        if not some.any():
            return 0.0
        of_points = (part[point] for part in (price / scale, lines.height, lines.fall))
        exact = least_over_choices(kappa[some], theta[some], np.sqrt(high[some]), first, *of_points)
        # with the constants of the one line, which the dual function has counted
        counted = self.by_knot((price * (self.shift[:, lines.column] - 1.0)).sum(axis=1))[some]
        before = np.empty(len(exact))
        for k, (a, b, c, d) in enumerate(zip(kappa[some], theta[some], root[some], high[some])):
            before[k] = lowest_with_root(a, b, c, 0.0, d)
        gained = exact - counted - before
        return float(gained.sum() - ROUNDING * (np.abs(exact) + np.abs(before) + np.abs(counted)).sum())

    def linear(self, c: Floats, local: bool = False) -> tuple[KnotRows, Floats]:
        """The same for the relaxation, sqrt(z) made linear at coefficients c (n + 2,), and (points, k) the factors of
        `multipliers`. It gives multipliers; the bound is theirs in the problem itself. `local`: by the largest of
        several lines there, not by the one line above all of them.

        Near its limit a row takes sqrt(z) for the inverse of the pace p, of which the wait is a part. The tangent is
        linear in p, so that the row becomes one of jerk,

            (r . u + shift + 2 root x - 1) / (root x^2) <= p                                    at sqrt(z) = x

        which holds on its other side, too, far from the plan. Elsewhere it is linear in z.
        """
        if self.lines is None:
            return self.as_knots(), np.empty((0, 0))
        u, column, half = self.state(c), self.lines.column, self.rows.shape[1] // 2
        x = np.sqrt(np.repeat(u[:, 0], np.diff(self.first)))[:, None]
        rows, shift, root = self.rows[:, column], self.shift[:, column], self.root[:, column]
        if local:
            shift, root = self._local(x + np.zeros(len(column)))
        limit, by_pace = 1.0 - shift - root * x, root * x * x
        value = np.einsum("pki,pi->pk", rows, np.repeat(u, np.diff(self.first), axis=0))
        near = (value > limit - 2.0 * root * x + LEAST_ROOM * limit) & (by_pace > 0.0) & ~self.lines.is_jerk
        factor = np.where(near, 1.0 / np.where(near, by_pace, 1.0), 0.0)
        by_z = np.where(near[:, :, None], 0.0, rows)
        by_z[:, :, 0] += np.where(near, 0.0, root / (2.0 * x))
        linear, shifts = self.rows.copy(), self.shift.copy()
        linear[:, column], shifts[:, column] = by_z, np.where(near, 0.0, shift + root * x / 2.0)
        none, further = np.zeros_like(rows), factor * (shift + 2.0 * root * x - 1.0)
        whole = np.concatenate([linear[:, :half], none, linear[:, half:], factor[:, :, None] * rows], axis=1)
        constants = np.concatenate([shifts[:, :half], none[:, :, 0], shifts[:, half:], further], axis=1)
        return self.as_knots()._replace(rows=whole, shift=constants, root=np.empty((0, 0))), factor

    def multipliers(self, found: Floats, factor: Floats) -> Floats:
        """(points, rows, 2) those of the rows from those of `linear`."""
        if self.lines is None:
            return found
        half, more = self.rows.shape[1] // 2, factor.shape[1]
        out = np.concatenate([found[:, :half], found[:, half + more : 2 * half + more]], axis=1)
        out[:, self.lines.column, 0] += factor * found[:, 2 * half + more :, 0]
        return out

    def used(self, u: Floats) -> Floats:
        """(points, rows) value of the rows, constants with them, at z, z', z'' (n, 3)."""
        at_point = np.repeat(u, np.diff(self.first), axis=0)
        value: Floats = np.einsum("pri,pi->pr", self.rows, at_point)
        return value + self.shift + self.root * np.sqrt(at_point[:, :1]) if len(self.root) else value

    def state(self, c: Floats) -> Floats:
        """(n, 3) z, z', z'' at the knots."""
        out = np.empty((len(self.weight), 3))
        relaxation_knots.at_knots(self.basis, c, out)
        return out

    def dual(self, dual: Floats, low: Floats | None = None, high: Floats | None = None) -> tuple[float, Floats, Floats]:
        """The bound by multipliers (points, rows, 2) >= 0 of the sum over all z from low to high (n,), kappa, theta."""
        low = np.zeros(len(self.weight)) if low is None else low
        high = self.cap if high is None else high
        value, kappa, theta = dual_value(self.as_knots(), low, high, dual)
        if self.lines is not None and self.lines.height.shape[2] > 1 and not low.any():
            value += self._gained_by_choices(dual, kappa, theta, high)
        return value, kappa, theta

    def value(self, dual: Floats, low: Floats | None = None, high: Floats | None = None) -> float:
        """The bound alone."""
        return self.dual(dual, low, high)[0]

    def by_knot(self, of_point: Floats) -> Floats:
        """(n, ...) sums over the points of each knot."""
        sums = np.zeros((len(self.weight), *of_point.shape[1:]))
        some = self.has_rows()
        if some.any():
            sums[some] = np.add.reduceat(of_point, self.first[:-1][some])
        return sums

    def force(self, dual: Floats) -> Floats:
        """(n, 3) what the rows of a knot, priced by multipliers, ask for its z, z', z''."""
        return self.by_knot(np.einsum("pi,pij->pj", dual[:, :, 0] - dual[:, :, 1], self.rows))

    def jerk_price(self, dual: Floats) -> Floats:
        """(n,) sum of the multipliers of jerk of a knot: what they take from the price of its pace."""
        half = self.rows.shape[1] // 2
        return self.by_knot(dual[:, half:].sum(axis=(1, 2)))

    def has_rows(self) -> npt.NDArray[np.bool_]:
        """(n,) whether a knot has rows of its own, and is not priced."""
        return np.diff(self.first) > 0

    def part(
        self, low: int, high: int, c: Floats, dual: Floats, least: Floats | None = None, most: Floats | None = None
    ) -> Knots:
        """The part between two knots, the rows of the outermost PADDING of them priced by multipliers.

        The outermost coefficients stay as in c, unless the part ends where the run does. `least` and `most` (n,) are
        the ranges of z that the multipliers are for: where they price a knot's pace below nothing, its chord has the
        same least value.
        """
        part = self.between(low, high, c)
        at_start, at_end = low == 0, high == len(self.weight) - 1
        mine = slice(self.first[low], self.first[high + 1])
        n = len(part.weight)
        priced = np.zeros(n, dtype=np.bool_)
        priced[: 0 if at_start else PADDING] = True
        priced[n if at_end else max(n - PADDING, 0) :] = True
        force = part.force(dual[mine])[priced]
        worth = (part.weight - part.jerk_price(dual[mine]))[priced]
        of_z = np.zeros(len(worth))
        if least is not None and most is not None:
            low_, high_ = least[low : high + 1][priced], most[low : high + 1][priced]
            root, top = np.sqrt(np.where(low_ > 0.0, low_, high_)), np.sqrt(high_)
            of_z = np.where(low_ > 0.0, -np.minimum(worth, 0.0) / (root * top * (root + top)), 0.0)
        basis, place = part.basis[priced], np.flatnonzero(priced)
        for j in range(3):
            np.add.at(part.price, place + j, (basis[:, :, j] * force).sum(axis=1) + basis[:, 0, j] * of_z)
        part.weight[priced] = np.maximum(worth, 0.0)
        part.rows = part.rows[~np.repeat(priced, np.diff(part.first))]
        part.first = np.concatenate([[0], np.cumsum(np.where(priced, 0, np.diff(part.first)))])
        return part

    def of_part(self, part: Knots, low: int, dual: Floats) -> Floats:
        """Of multipliers of the whole, those of the rows that are left in a part from the knot `low` on."""
        some = np.flatnonzero(part.has_rows())
        return dual[self.first[low + some[0]] : self.first[low + some[-1] + 1]] if len(some) else dual[:0]

    def between(self, low: int, high: int, c: Floats) -> Knots:
        """The knots from one to another, all their rows with them; the outermost coefficients stay as in c."""
        part = copy(self)
        ends = np.array([low == 0, high == len(self.weight) - 1])
        part.first = self.first[low : high + 2] - self.first[low]
        part.basis, part.weight = self.basis[low : high + 1], self.weight[low : high + 1].copy()
        part.price, part.cap = self.price[low : high + 3].copy(), self.cap[low : high + 1].copy()
        part.rows = self.rows[self.first[low] : self.first[high + 1]]
        part.end = np.where(ends, self.end, newton.MOVING)
        part.fixed = np.where(np.repeat(ends, 2), self.fixed, c[[low, low + 1, high + 1, high + 2]])
        for place in np.array([0, -1])[~ends]:
            part.cap[place] = max(part.cap[place], 1e3 * part.fixed.max())
        return part


def start_within(
    knots: Knots, c: Floats, low: Floats | None = None, high: Floats | None = None, share: float = START_SHARE
) -> tuple[Floats, Floats]:
    """Coefficients well inside, about `share` of c, and the reliefs (n, 4) that they need."""
    place = np.arange(len(c), dtype=np.float64)
    far = np.full(len(c), np.inf)
    if knots.end[0] == newton.MOVING:
        far = np.minimum(far, place - 1.0)
    if knots.end[1] == newton.MOVING:
        far = np.minimum(far, place[::-1] - 1.0)
    inside = np.clip(far / SETTLE_KNOTS, 0.0, 1.0)
    start: Floats = c * (1.0 - (1.0 - share) * inside * inside * (3.0 - 2.0 * inside))
    u = knots.state(start)
    if u[:, 0].min() <= 0.0:
        start, u = c.copy(), knots.state(c)
    low = np.zeros(len(u)) if low is None else low
    high = knots.cap if high is None else high
    half = knots.rows.shape[1] // 2
    of_point = np.abs(knots.used(u)[:, :half]).max(axis=1, initial=0.0)
    used = np.zeros(len(u))
    np.maximum.at(used, np.repeat(np.arange(len(u)), np.diff(knots.first)), of_point)
    relief = np.zeros((len(u), 4))
    relief[:, relaxation_work.RELIEF_CAP] = high * relief_of(u[:, 0] / high)
    relief[:, relaxation_work.RELIEF_ACCELERATION] = relief_of(used)
    floor = low > 0.0
    relief[floor, relaxation_work.RELIEF_FLOOR] = low[floor] * relief_of(2.0 - u[floor, 0] / low[floor])
    return start, relief


def least_over_choices(
    kappa: Floats, theta: Floats, top: Floats, first: Ints, price: Floats, height: Floats, fall: Floats
) -> Floats:
    """(n,) the least over 0 < x <= top (n,) of kappa / x + theta x^2 - sum of price times limit, at knots of which the
    points `first` (n + 1,) begin; the limit of a row is the largest of its lines (points, k, choices) at x.

    Interval by interval, between the places where another line is the largest. In an interval the slope has the sign of
    g(x) = 2 theta x^3 + root x^2 - kappa, see `lowest_with_root`.
    """
    n, choices = len(kappa), height.shape[2]
    knot = np.repeat(np.arange(n), np.diff(first))
    meets = []
    for i in range(choices):
        for j in range(i):
            with np.errstate(divide="ignore", invalid="ignore"):
                x = (height[:, :, i] - height[:, :, j]) / (fall[:, :, i] - fall[:, :, j])
            meets.append(np.where((x > 0.0) & (x < top[knot][:, None]) & (price > 0.0), x, np.inf))
    of_points = np.sort(np.concatenate(meets, axis=1), axis=1)
    sides = int(np.diff(first).max())
    edges = np.full((n, sides * of_points.shape[1]), np.inf)
    side = np.arange(len(knot)) - first[knot]
    for each in range(sides):
        mine = side == each
        edges[knot[mine], each * of_points.shape[1] : (each + 1) * of_points.shape[1]] = of_points[mine]
    edges = np.sort(np.minimum(edges, top[:, None]), axis=1)
    edges = edges[:, np.append(True, (np.diff(edges, axis=1) > 0.0).any(axis=0))]
    edges = np.concatenate([np.zeros((n, 1)), edges, top[:, None]], axis=1)
    best = np.full(n, np.inf)
    for low, high in itertools.pairwise(edges.T):
        middle = 0.5 * (low + high)[knot]
        largest = (height - fall * middle[:, None, None]).argmax(axis=2)[:, :, None]
        of_rows = [np.take_along_axis(part, largest, axis=2)[:, :, 0] for part in (height, fall)]
        constant, root = (np.add.reduceat((price * part).sum(axis=1), first[:-1]) for part in of_rows)
        inside = first_zero(kappa, theta, root, low, high)
        for x in (low, high, inside):
            with np.errstate(divide="ignore", invalid="ignore"):
                value = np.where(x > 0.0, kappa / x, np.where(kappa > 0.0, np.inf, 0.0))
            value = value + (theta * x + root) * x - constant
            best = np.minimum(best, np.where(high > low, value, np.inf))
    return best


def first_zero(kappa: Floats, theta: Floats, root: Floats, low: Floats, high: Floats) -> Floats:
    """(n,) where 2 theta x^3 + root x^2 - kappa rises above zero between low and high (n,); high where it does not."""

    def g(x: Floats) -> Floats:
        return (2.0 * theta * x + root) * x * x - kappa

    with np.errstate(divide="ignore", invalid="ignore"):
        summit = np.where(theta < 0.0, -root / (3.0 * theta), np.inf)
    far = np.where((summit > low) & (summit < high), summit, high)
    crosses = (g(low) < 0.0) & (g(far) > 0.0)
    near, far = low.copy(), np.where(crosses, far, high)
    if crosses.any():
        for _ in range(HALVINGS):
            middle = 0.5 * (near + far)
            above = g(middle) > 0.0
            far, near = np.where(crosses & above, middle, far), np.where(crosses & ~above, middle, near)
    return far
