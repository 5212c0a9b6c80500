"""Limits that fall with the speed in the bound: planes above them, and what the dual function comes to by themselves.

With x = sqrt(z) such a limit is a function a(x), of jerk (h - f x) / x. It is not concave in what the relaxation is
convex in, the pace p >= 1 / x and z. A plane over both,

    a(v) <= constant + by_pace / v + by_z v^2        for all v

holds for every motion; that it also touches the limit at a plan's x costs nothing where the plan is: there the
relaxation has the limit itself. The pace is the price: only what waits, or is faster, may have more.
"""

from __future__ import annotations

import itertools
from typing import NamedTuple

import numpy as np

from toolpace.common.arrays import Floats, Ints
from toolpace.planning.optimal.own_rows import LineRows

SAMPLES = np.concatenate([np.geomspace(0.02, 0.97, 24), np.geomspace(1.03, 50.0, 26)])
"""Speeds at which a plane is above a limit, as multiples of that at which it touches."""
HALVINGS = 60
"""Of an interval in which a least value is looked for."""
NEAREST = 0.02
"""Share of the speed from where it touches within which a plane may pass below: next to where two lines meet it would
have to be steep."""
ROUNDING = 1e-10
"""Share of a limit by which planes that are exact are above it."""
MEETS = 1e-9
"""Share of a limit up to which two lines that meet are the largest there."""


class Planes(NamedTuple):
    """Planes constant + by_pace p + by_z z above limits that depend on the speed, each (points, k)."""

    constant: Floats
    by_pace: Floats
    by_z: Floats

    def at(self, x: Floats) -> Floats:
        """(points, k) their values at ds/dt x (points, k)."""
        return self.constant + self.by_pace / x + self.by_z * x * x


def limits_at(lines: LineRows, x: Floats) -> Floats:
    """(points, k) the limits at ds/dt x (points, k): of jerk what is left for r . u."""
    largest = (lines.height - lines.fall * x[:, :, None]).max(axis=2)
    limit: Floats = np.where(lines.is_jerk, largest / x, largest)
    return limit


def planes_above(
    lines: LineRows, x: Floats, high: Floats, least: Floats | float = 0.0, *, rising: bool = False
) -> Planes:
    """Planes that touch the limits at ds/dt x (points, k) and lie above them up to `high` (points, k), as far as
    samples tell: multipliers of any planes give a bound.

    Of all with the value a and the slope a' of the limit at x, that with the least multiple of the pace, and at least
    `least` (points, k), or, if they are to be `rising`, that by which none falls with z:

        max over v of (a(v) - a - a' (v^2 - x^2) / (2 x)) / (1 / v - 1 / x + (v^2 - x^2) / (2 x^3))
    """
    height, fall = lines.chosen(x)
    value = np.where(lines.is_jerk, height / x - fall, height - fall * x)
    slope = np.where(lines.is_jerk, -height / (x * x), -fall)
    # in the limit of v = x
    by_pace = np.maximum(np.where(lines.is_jerk, lines.height.max(axis=2), fall * x * x / 3.0), least)
    if rising:
        by_pace = np.maximum(by_pace, -slope * x * x)
    for share in SAMPLES:
        v = np.minimum(share * x, high) if share > 1.0 else share * x
        other = (v * v - x * x) / (2.0 * x)
        bend = 1.0 / v - 1.0 / x + other / (x * x)
        with np.errstate(divide="ignore", invalid="ignore"):
            needed = (limits_at(lines, v) - value - slope * other) / bend
        by_pace = np.where(np.abs(v / x - 1.0) > NEAREST, np.maximum(by_pace, needed), by_pace)
    by_z = (slope + by_pace / (x * x)) / (2.0 * x)
    return Planes(value - by_pace / x - by_z * x * x, by_pace, by_z)


def lifted(lines: LineRows, planes: Planes, top: Floats) -> Planes:
    """The planes with constants by which none is below its limit at any ds/dt up to `top` (points,)."""
    every, one = np.arange(len(top) + 1), np.ones((len(top), 1))
    constant = planes.constant.copy()
    for k, is_jerk in enumerate(lines.is_jerk):
        mine = slice(k, k + 1)
        of_row = lines._replace(
            column=lines.column[mine], is_jerk=np.array([is_jerk]), height=lines.height[:, mine],
            fall=lines.fall[:, mine],
        )  # fmt: skip
        constant[:, k] = -least_over_choices(of_row, one, planes.by_pace[:, k], planes.by_z[:, k], top, every)
    return planes._replace(constant=constant + ROUNDING * (1.0 + np.abs(constant)))


def least_over_choices(
    lines: LineRows, price: Floats, kappa: Floats, theta: Floats, top: Floats, first: Ints
) -> Floats:
    """(n,) the least over 0 < x <= top (n,) of kappa / x + theta x^2 - sum of price times limit, at knots of which the
    points `first` (n + 1,) begin; `price` (points, k) is zero or more.

    Interval by interval, between the places where another line is the largest. Of jerk a price of h / x - f is one of
    the pace as well.
    """
    knot = np.repeat(np.arange(len(kappa)), np.diff(first))
    edges = _edges(lines, price, top, knot, first)
    best = np.full(len(kappa), np.inf)
    for low, high in itertools.pairwise(edges.T):
        height, fall = lines.chosen((0.5 * (low + high))[knot][:, None] + np.zeros(len(lines.column)))
        worth = price * height, price * fall
        of_jerk = [np.add.reduceat(part[:, lines.is_jerk].sum(axis=1), first[:-1]) for part in worth]
        constant, root = (np.add.reduceat(part[:, ~lines.is_jerk].sum(axis=1), first[:-1]) for part in worth)
        constant, left = constant - of_jerk[1], kappa - of_jerk[0]
        for x in (low, high, first_zero(left, theta, root, low, high)):
            with np.errstate(divide="ignore", invalid="ignore"):
                value = np.where(x > 0.0, left / x, np.where(left > 0.0, np.inf, 0.0))
            value = value + (theta * x + root) * x - constant
            best = np.minimum(best, np.where(high > low, value, np.inf))
    return best


def _edges(lines: LineRows, price: Floats, top: Floats, knot: Ints, first: Ints) -> Floats:
    """(n, edges) ascending from 0 to top: where another line of a row with a price becomes the largest."""
    n, choices = len(top), lines.height.shape[2]
    meets = []
    for i, j in itertools.combinations(range(choices), 2):
        with np.errstate(divide="ignore", invalid="ignore"):
            x = (lines.height[:, :, i] - lines.height[:, :, j]) / (lines.fall[:, :, i] - lines.fall[:, :, j])
        inside = (x > 0.0) & (x < top[knot][:, None]) & (price > 0.0)
        x = np.where(inside, x, 0.0)
        there = lines.height - lines.fall * x[:, :, None]
        largest = there.max(axis=2)
        inside &= there[:, :, i] >= largest - MEETS * np.abs(largest)
        meets.append(np.where(inside, x, np.inf))
    of_points = np.sort(np.concatenate(meets, axis=1), axis=1) if meets else np.empty((len(knot), 0))
    of_points = of_points[:, np.isfinite(of_points).any(axis=0)]
    width, sides = of_points.shape[1], int(np.diff(first).max())
    edges = np.full((n, sides * width), np.inf)
    side = np.arange(len(knot)) - first[knot]
    for each in range(sides):
        mine = side == each
        edges[knot[mine], each * width : (each + 1) * width] = of_points[mine]
    edges = np.sort(np.minimum(edges, top[:, None]), axis=1)
    return np.concatenate([np.zeros((n, 1)), edges, top[:, None]], axis=1)


def first_zero(kappa: Floats, theta: Floats, root: Floats, low: Floats, high: Floats) -> Floats:
    """(n,) where 2 theta x^3 + root x^2 - kappa rises above zero between low and high (n,); high where it does not.

    It has one summit or one valley at x > 0, at -root / (3 theta): it rises up to the one, or from the other on.
    """

    def g(x: Floats) -> Floats:
        return (2.0 * theta * x + root) * x * x - kappa

    with np.errstate(divide="ignore", invalid="ignore"):
        turn = np.where(theta != 0.0, -root / (3.0 * theta), np.inf)
    within = (turn > low) & (turn < high)
    near, far = np.where(within & (theta > 0.0), turn, low), np.where(within & (theta < 0.0), turn, high)
    crosses = (g(near) < 0.0) & (g(far) > 0.0)
    far = np.where(crosses, far, high)
    if crosses.any():
        for _ in range(HALVINGS):
            middle = 0.5 * (near + far)
            above = g(middle) > 0.0
            far, near = np.where(crosses & above, middle, far), np.where(crosses & ~above, middle, near)
    return far
