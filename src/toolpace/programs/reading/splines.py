"""Bezier curves and cubic B-splines of programs, from control points, weights and knots."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from toolpace.common.arrays import Floats, Ints
from toolpace.programs.reading.arcs import SAG

MOST_ORDER = 10
"""Most order of a spline, its degree and one: more is a slip, and its points lose their digits."""
MOST_PIECES = 1e6
"""Chords of one curve that are asked for at first; what needs more is refused where points are laid."""
_MEASURED = 64
"""Chords by which a length is measured."""
DEGREE = 3
KNOT_DECIMALS = 10
"""Knots that agree to so many decimals are one knot: programs write seven."""


class CurveError(ValueError):
    """A curve that cannot be; the message says why and what to write."""


class Bezier(NamedTuple):
    """A rational Bezier curve, 0 <= t <= 1."""

    points: tuple[tuple[float, float, float], ...]
    """Control points [m]: their number is the degree and one."""
    weights: tuple[float, ...]

    @staticmethod
    def plain(points: Sequence[Sequence[float]]) -> Bezier:
        """A curve whose weights are all one."""
        return Bezier(tuple((p[0], p[1], p[2]) for p in points), (1.0,) * len(points))

    def length(self) -> float:
        """Length [m], by chords: for times and shares, not for places."""
        t = np.linspace(0.0, 1.0, _MEASURED + 1)
        places = BezierTable([self]).evaluate(np.zeros(len(t), dtype=np.int64), t)
        return float(np.linalg.norm(np.diff(places, axis=0), axis=1).sum())

    def pieces(self) -> int:
        """How many chords keep within SAG where weights are equal; else how many to begin with."""
        points, degree = np.array(self.points), len(self.points) - 1
        bend = float(np.linalg.norm(np.diff(points, 2, axis=0), axis=1).max(initial=0.0))
        return max(degree, math.ceil(min(math.sqrt(degree * (degree - 1) * bend / (8 * SAG)), MOST_PIECES)))


class BezierTable:
    """Many curves as arrays, evaluated at once."""

    def __init__(self, curves: Sequence[Bezier]) -> None:
        degree = max((len(curve.points) - 1 for curve in curves), default=1)
        self.control = np.array([_raised(curve, degree) for curve in curves]).reshape(-1, degree + 1, 4)

    def evaluate(self, curve: Ints, t: Floats) -> Floats:
        """Points (k, 3) [m] of curves `curve` (k,) at fractions t (k,), by de Casteljau's recursion."""
        control, share = self.control[curve], t[:, None, None]
        while control.shape[1] > 1:
            control = (1 - share) * control[:, :-1] + share * control[:, 1:]
        return np.asarray(control[:, 0, :3] / control[:, 0, 3:])


def _raised(curve: Bezier, degree: int) -> Floats:
    """Control points (degree + 1, 4), times their weights and with them, of the same curve in a higher degree."""
    weights = np.array(curve.weights)[:, None]
    control = np.hstack([np.array(curve.points) * weights, weights])
    for n in range(len(control), degree + 1):
        share = np.arange(1, n)[:, None] / n
        control = np.vstack([control[:1], share * control[:-1] + (1 - share) * control[1:], control[-1:]])
    return np.asarray(control)


def curves_of(
    order: int, knots: Sequence[float], points: Sequence[Sequence[float]], weights: Sequence[float]
) -> list[Bezier]:
    """The Bezier curves of a NURBS, one for each span of its knots; CurveError where its numbers do not fit.

    knots: (n + order,), not falling, of which the first and the last `order` are equal. Each control point of a span is
    the polar form of the spline at the ends of the span (Ramshaw 1989, Blossoms are polar forms).
    """
    degree = order - 1
    u = np.array(knots, dtype=float)
    _check(order, u, points, weights)
    w = np.array(weights, dtype=float)[:, None]
    control = np.hstack([np.array(points, dtype=float) * w, w])
    spans = degree + np.flatnonzero(np.diff(u[degree : len(control) + 1]) > 0)
    a, b = u[spans], u[spans + 1]
    made = []
    for number in range(order):
        d = [control[spans - degree + i] for i in range(order)]
        for r in range(1, order):
            at = a if r <= degree - number else b
            for i in range(degree, r - 1, -1):
                left, right = u[spans - degree + i], u[spans + 1 + i - r]
                share = ((at - left) / (right - left))[:, None]
                d[i] = (1 - share) * d[i - 1] + share * d[i]
        made.append(d[degree])
    found = np.stack(made, axis=1)
    return [
        Bezier(tuple(map(tuple, (span[:, :3] / span[:, 3:]).tolist())), tuple(span[:, 3].tolist())) for span in found
    ]


def even_knots(order: int, count: int) -> list[float]:
    """Knots of `count` control points that are evenly spaced between ends where the spline begins and ends."""
    inner = count - order
    return [0.0] * order + [float(k) for k in range(1, inner + 1)] + [inner + 1.0] * order


def _check(order: int, u: Floats, points: Sequence[Sequence[float]], weights: Sequence[float]) -> None:
    if not 2 <= order <= MOST_ORDER:
        raise CurveError(f"a spline of order {order} is not read: from 2 to {MOST_ORDER}")
    if len(points) < order:
        raise CurveError(f"a spline of order {order} takes at least {order} control points, and has {len(points)}")
    if len(u) != len(points) + order:
        raise CurveError(
            f"{len(points)} control points of order {order} take {len(points) + order} knots, and there are {len(u)}: "
            "is the program complete?"
        )
    if (np.diff(u) < 0).any():
        raise CurveError("the knots of the spline fall: correct them")
    if u[order - 1] > u[0] or u[-order] < u[-1] or u[0] == u[-1]:
        raise CurveError(f"a spline of order {order} begins and ends with {order} equal knots: correct them")
    if (u[order:-1] == u[1:-order]).any():
        raise CurveError(f"a knot stands more than {order - 1} times, where the curve breaks: write two curves")
    if not all(1e-6 <= weight <= 1e6 for weight in weights):
        raise CurveError("weights of a spline are from 1e-6 to 1e6, and above zero: correct them")


class Spline(NamedTuple):
    """A cubic B-spline from its first control point to its last."""

    knots: Floats
    """(n + 4,) from 0 to 1, not falling; the first four and the last four are equal."""
    points: Floats
    """(n, 3) control points [m]."""

    @staticmethod
    def clamped(inner: Floats, points: Floats) -> Spline:
        """Spline of control points (n, 3) with knots (n - 4,) between 0 and 1; CurveError where they do not fit."""
        inner = np.round(np.asarray(inner, dtype=float), KNOT_DECIMALS)
        if len(points) != len(inner) + DEGREE + 1:
            raise CurveError(
                f"{len(points)} control points need {len(points) - DEGREE - 1} inner knots, and there are "
                f"{len(inner)}: is the program complete?"
            )
        knots = np.concatenate((np.zeros(DEGREE + 1), inner, np.ones(DEGREE + 1)))
        if (np.diff(knots) < 0).any():
            raise CurveError("the knots do not rise from 0 to 1: correct them")
        if len(inner) >= DEGREE + 1 and (inner[DEGREE:] - inner[:-DEGREE] <= 0).any():
            raise CurveError("a knot stands more than three times, where the curve breaks: write two curves")
        if len(inner) and (inner[0] <= 0 or inner[-1] >= 1):
            raise CurveError("an inner knot is 0 or 1, where the curve begins and ends: leave it out")
        return Spline(knots, np.asarray(points, dtype=float))

    def pieces(self) -> int:
        """How many chords keep within SAG."""
        return int(self._chords()[1].sum())

    def parameters(self) -> Floats:
        """Parameters (k,) > 0 up to 1 of the ends of chords that keep within SAG of the curve."""
        spans, count = self._chords()
        length = np.diff(self.knots)[spans]
        span = np.repeat(np.arange(len(spans)), count)
        step = np.arange(1, len(span) + 1) - np.repeat(np.cumsum(count) - count, count)
        t = self.knots[spans][span] + length[span] * (step / count[span])
        t[-1] = 1.0
        return np.asarray(t)

    def evaluate(self, t: Floats) -> Floats:
        """Points (k, 3) [m] at parameters t (k,), by de Boor's recursion."""
        k, p = self.knots, DEGREE
        j = np.clip(np.searchsorted(k, t, side="right") - 1, p, len(k) - p - 2)
        d = [self.points[j - p + i] for i in range(p + 1)]
        for r in range(1, p + 1):
            for i in range(p, r - 1, -1):
                left, right = k[j - p + i], k[j + 1 + i - r]
                share = ((t - left) / (right - left))[:, None]
                d[i] = (1 - share) * d[i - 1] + share * d[i]
        return np.asarray(d[p])

    def _chords(self) -> tuple[Ints, Ints]:
        """Spans (m,) of some length, and how many chords each takes.

        The second derivative is linear within a span, between two of its control points; a chord over a step h is off
        by at most h^2 / 8 of its greatest value (de Boor 1978, A Practical Guide to Splines).
        """
        spans = np.flatnonzero(np.diff(self.knots) > 0)
        bend = np.linalg.norm(self._second_derivatives(), axis=1)
        most = np.maximum(bend[spans - DEGREE], bend[spans - DEGREE + 1])
        count = np.ceil(np.diff(self.knots)[spans] * np.sqrt(most / (8 * SAG)))
        return spans, np.maximum(1, count).astype(np.int64)

    def _second_derivatives(self) -> Floats:
        """Control points (n - 2, 3) of the second derivative."""
        k, p = self.knots, DEGREE
        n = len(self.points)
        first = p * np.diff(self.points, axis=0) / _width(k[p + 1 : n + p] - k[1:n])
        return np.asarray((p - 1) * np.diff(first, axis=0) / _width(k[p + 1 : n + p - 1] - k[2:n]))


def _width(width: Floats) -> Floats:
    """Widths as a column; what is zero belongs to a span without length, and is never used."""
    return np.asarray(np.where(width > 0, width, 1.0)[:, None])
