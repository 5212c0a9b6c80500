"""The planner's problem by knots, for the relaxation and the dual function."""

from __future__ import annotations

from copy import copy

import numpy as np
import numpy.typing as npt

from toolpace.common.arrays import Floats
from toolpace.kernels.motion import cubic_spline
from toolpace.kernels.optimal import newton, relaxation_knots, relaxation_work
from toolpace.kernels.optimal.dual import KnotRows, dual_value, lowest_with_root
from toolpace.planning.bound.falling_limits import least_over_choices, lifted, limits_at, planes_above
from toolpace.planning.optimal.own_rows import LineRows
from toolpace.planning.optimal.problem import Problem
from toolpace.planning.optimal.solve import relief_of

START_SHARE = 0.4
"""Share of a plan's z at which the relaxation is started."""
ROUNDING = 1e-13
"""Share of the sums that a bound with several lines for a piece is charged for rounding."""
TELLS = 1e-9
"""Share of a knot's time that the prices of such limits must be worth for a difference between such lines."""
LEAST_ROOM = 0.7
"""Share of a limit that depends on the speed by which a row that the relaxation has by the pace must be inside on its
other side, where it is held as well."""
NEAR = 0.5
"""Share of such a limit from which a row is held in the relaxation."""
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
        self.one_sided = np.zeros(0, dtype=np.int64)
        """Columns of rows of which the other side is no limit: it has no multipliers."""

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

    def _gained_by_choices(self, dual: Floats, kappa: Floats, theta: Floats, high: Floats) -> float:
        """What the dual function gains where the largest of several lines counts, over one line above all of them."""
        lines = self.lines
        assert lines is not None
        price = dual[:, lines.column, 0] - dual[:, lines.column, 1]
        shift, root = self.shift[:, lines.column], self.root[:, lines.column]
        points, top = np.diff(self.first), np.sqrt(high)
        worth = np.where(lines.is_jerk, price / np.repeat(top, points)[:, None], price).sum(axis=1)
        some = self.by_knot(worth) * top > TELLS * self.weight
        some[[0, -1]] &= self.end == newton.REST
        point = np.repeat(some, points)
        if not some.any():
            return 0.0
        # with the constants of the one line, which the dual function has counted
        constants = np.where(lines.is_jerk, shift, shift - 1.0)
        counted = self.by_knot((price * constants).sum(axis=1))[some]
        roots = self.by_knot((price * root).sum(axis=1))[some]
        before = np.empty(len(counted))
        for k, (a, b, c, d) in enumerate(zip(kappa[some], theta[some], roots, high[some])):
            before[k] = lowest_with_root(a, b, c, 0.0, d)
        # that line took its whole height at rest off the price of the pace
        price = (price / self._scale())[point]
        paid = np.where(lines.is_jerk, price * lines.height[point].max(axis=2), 0.0).sum(axis=1)
        first = np.concatenate([[0], np.cumsum(points[some])])
        own = kappa[some] + np.add.reduceat(paid, first[:-1])
        exact = least_over_choices(lines.at(point), price, own, theta[some], top[some], first)
        gained = exact - counted - before
        return float(gained.sum() - ROUNDING * (np.abs(exact) + np.abs(before) + np.abs(counted)).sum())

    def _scale(self) -> Floats:
        """(points, k) what the rows whose limits depend on the speed are divided by."""
        assert self.lines is not None
        height = np.abs(self.lines.height.max(axis=2))
        scale: Floats = np.where(self.lines.is_jerk, height, height + 1.0)
        return scale

    def within_planes(
        self, c: Floats, speeds: list[Floats], exact: bool = False, rising: bool = False
    ) -> tuple[Knots, Floats]:
        """The problem with planes for the limits that depend on the speed, and (points, planes, k) the factors of
        `multipliers`. With `exact` they are nowhere below the limits, so that what it takes is a bound by itself;
        else the bound is that of the multipliers in the problem itself.

        Near its limit at coefficients c (n + 2,) a row is one of jerk, by each plane that touches the limit at one of
        `speeds`, ds/dt (n,) at the knots:

            (r . u - by_z z - constant) / by_pace <= p

        It holds on its other side, too: far from the plan, as the pace counts enough. Elsewhere it is left out. What
        `rising` planes are, `planes_above` tells.
        """
        lines = self.lines
        assert lines is not None
        column, half = lines.column, self.rows.shape[1] // 2
        points, none = np.diff(self.first), np.zeros(len(column))
        u = np.repeat(self.state(c), points, axis=0)
        value = np.einsum("pki,pi->pk", lines.rows, u)
        high = np.repeat(np.sqrt(self.cap), points)[:, None] + none
        rows, constants, factors = [], [], []
        for speed in speeds:
            x = np.repeat(speed, points)[:, None] + none
            limit = limits_at(lines, x)
            near = (value > NEAR * limit) & (~lines.is_jerk | (lines.height.shape[2] > 1))
            least = np.where(near, 0.5 * x * ((1.0 + LEAST_ROOM) * limit - value), 0.0)
            planes = planes_above(lines, x, high, least, rising=rising)
            if exact:
                planes = lifted(lines, planes, np.sqrt(self.cap)[np.repeat(np.arange(len(points)), points)])
            factor = np.where(near, 1.0 / np.where(near, planes.by_pace, 1.0), 0.0)
            by_pace = lines.rows.copy()
            by_pace[:, :, 0] -= planes.by_z
            rows.append(factor[:, :, None] * by_pace)
            constants.append(-factor * planes.constant)
            factors.append(factor)
        near = np.any(factors, axis=0)
        linear, shifts = self.rows.copy(), self.shift.copy()
        gone = near | ~lines.is_jerk
        linear[:, column] = np.where(gone[:, :, None], 0.0, linear[:, column])
        shifts[:, column] = np.where(gone, 0.0, shifts[:, column])
        more, further = np.concatenate(rows, axis=1), np.concatenate(constants, axis=1)
        nothing = np.zeros_like(more)
        whole = np.concatenate([linear[:, :half], nothing, linear[:, half:], more], axis=1)
        shifts = np.concatenate([shifts[:, :half], nothing[:, :, 0], shifts[:, half:], further], axis=1)
        part = copy(self)
        part.rows, part.shift, part.root, part.lines = whole, shifts, np.empty((0, 0)), None
        part.one_sided = np.arange(whole.shape[1] - more.shape[1], whole.shape[1])
        return part, np.stack(factors, axis=1) * self._scale()[:, None]

    def multipliers(self, found: Floats, factors: Floats) -> Floats:
        """(points, rows, 2) those of the rows from those of `within_planes`."""
        assert self.lines is not None
        half, more = self.rows.shape[1] // 2, factors.shape[1] * factors.shape[2]
        out = np.concatenate([found[:, :half], found[:, half + more : 2 * half + more]], axis=1)
        by_pace = found[:, 2 * half + more :, 0].reshape(factors.shape)
        out[:, self.lines.column, 0] += (factors * by_pace).sum(axis=1)
        # the other sides of these rows are no limits
        out[:, self.lines.column, 1] = 0.0
        return out

    def used(self, u: Floats) -> Floats:
        """(points, rows) value of the rows, constants with them, at z, z', z'' (n, 3)."""
        at_point = np.repeat(u, np.diff(self.first), axis=0)
        value: Floats = np.einsum("pri,pi->pr", self.rows, at_point)
        value = value + self.shift if len(self.shift) else value
        return value + self.root * np.sqrt(at_point[:, :1]) if len(self.root) else value

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
        kept = ~np.repeat(priced, np.diff(part.first))
        part.rows, part.shift = part.rows[kept], part.shift[kept] if len(part.shift) else part.shift
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
        mine = slice(self.first[low], self.first[high + 1])
        part.rows, part.shift = self.rows[mine], self.shift[mine] if len(self.shift) else self.shift
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
