"""Runs that are given exactly: by a callable, a circular arc, a pair of B-splines."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, TypedDict

import numpy as np

from toolpace.arrays import Floats, Ints
from toolpace.errors import PathError
from toolpace.path.run import PathJet, PathRun, unit_jets
from toolpace.workers import Lock

if TYPE_CHECKING:
    from scipy.interpolate import BSpline

Curve = Callable[[Floats, int], tuple[Floats, Floats]]
"""(s (n,), order 0 to 3) to the derivative of tip (n, 3) [m] and of the unit tool axis (n, 3)."""


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class CurveRun(PathRun):
    """A run whose derivatives a function knows."""

    curve: Curve
    most_second: float | None = None
    """Most |P''| of the tip [1/m], where it is known."""
    lock: Lock = field(default_factory=Lock)

    def evaluate(self, s: Floats) -> PathJet:
        """Position and derivatives at s (n,), as the function gives them."""
        s = np.asarray(s, dtype=np.float64)
        with self.lock:
            parts = [self.curve(s, order) for order in range(4)]
        tip = np.stack([np.broadcast_to(np.asarray(part[0], dtype=np.float64), (len(s), 3)) for part in parts])
        axis = np.stack([np.broadcast_to(np.asarray(part[1], dtype=np.float64), (len(s), 3)) for part in parts])
        return PathJet(tip, axis, None)

    def tip_slope(self, s: Floats) -> Floats:
        """(n, 3) the first derivative of the tip at s (n,): the function is asked once, not for all orders."""
        s = np.asarray(s, dtype=np.float64)
        with self.lock:
            slope, _ = self.curve(s, 1)
        return np.broadcast_to(np.asarray(slope, dtype=np.float64), (len(s), 3))

    def second_derivative_bounds(self) -> Floats | None:
        """(k - 1,) most |P''| of the tip between breaks, where it is known."""
        return None if self.most_second is None else np.full(len(self.breaks) - 1, self.most_second)


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class TwoCurveRun(PathRun):
    """A run given by two B-splines over one parameter: the tip, and a second point on the tool axis."""

    curves: Callable[[Floats, int], Floats]
    """(s (n,), order 0 to 3) to the derivative of both (n, 6) [m]: of the tip, and of the second point."""
    most_second: Floats
    """(k - 1,) most |P''| of the tip between each two breaks [1/m]."""

    def evaluate(self, s: Floats) -> PathJet:
        """Position and derivatives at s (n,); the axis points from the tip to the second point."""
        s = np.asarray(s, dtype=np.float64)
        both = np.stack([self.curves(s, order) for order in range(4)])
        tip = both[:, :, :3]
        return PathJet(tip, unit_jets(both[:, :, 3:] - tip), None)

    def tip_slope(self, s: Floats) -> Floats:
        """(n, 3) the first derivative of the tip at s (n,): no other order is asked."""
        return self.curves(np.asarray(s, dtype=np.float64), 1)[:, :3]

    def second_derivative_bounds(self) -> Floats:
        """(k - 1,) most |P''| of the tip between breaks, by its control points."""
        return self.most_second


def callable_run(curve: Curve, s0: float, s1: float, feed: float, most_second: float | None = None) -> CurveRun:
    """One run of one block over [s0, s1]; `most_second` bounds |P''| of the tip [1/m]."""
    if not (np.isfinite(s0) and np.isfinite(s1) and s1 > s0):
        raise PathError(f"a path from s0 = {s0:g} to s1 = {s1:g} has no length; give s0 < s1")
    ends = np.array([s0, s1], dtype=np.float64)
    return CurveRun(breaks=ends, curve=curve, most_second=most_second, **one_block(ends, feed))


class BlockTable(TypedDict):
    """The block arrays of a run."""

    block_start: Floats
    block: Ints
    feed: Floats
    least_time: Floats


def one_block(ends: Floats, feed: float) -> BlockTable:
    """The block table of a run of one block."""
    if not feed > 0.0:
        raise PathError(f"the feed is {feed:g} m/s; give a positive feed, or inf for none")
    return {
        "block_start": ends.copy(),
        "block": np.ones(1, dtype=np.int64),
        "feed": np.array([float(feed)]),
        "least_time": np.zeros(1),
    }


def arc_run(centre: Floats, start: Floats, normal: Floats, sweep: float, lean: float, feed: float) -> CurveRun:
    """A circular arc over its length, the tool axis in its plane at a constant angle to the outward normal.

    n (normal, towards you)     P(s) = centre + R (e cos th + f sin th),  th = s / R
    f |  /axis                  axis = e cos(th + lean) + f sin(th + lean)
      | / ) lean
      |/____ e = (start - centre) / R,  f = n x e
    """
    centre, start = np.asarray(centre, dtype=np.float64), np.asarray(start, dtype=np.float64)
    radius = float(np.linalg.norm(start - centre))
    if radius == 0.0 or sweep <= 0.0:
        raise PathError(
            f"an arc of radius {radius:g} m and sweep {sweep:g} rad has no length; turn the normal to go back"
        )
    e = (start - centre) / radius
    n = np.asarray(normal, dtype=np.float64) / np.linalg.norm(normal)
    if abs(n @ e) > 1e-9:
        raise PathError("the normal of an arc must be at right angles to its radius")
    f = np.cross(n, e)

    def turned(angle: Floats, order: int) -> Floats:
        shifted = (angle + 0.5 * np.pi * order)[:, None]
        return np.asarray((np.cos(shifted) * e + np.sin(shifted) * f) / radius**order)

    def curve(s: Floats, order: int) -> tuple[Floats, Floats]:
        tip = radius * turned(s / radius, order)
        return (tip + centre if order == 0 else tip), turned(s / radius + lean, order)

    return callable_run(curve, 0.0, radius * sweep, feed, most_second=1.0 / radius)


def bspline_run(knots: Floats, tip: Floats, axis_point: Floats, degree: int, feed: float) -> TwoCurveRun:
    """Tip and a second point of the tool axis as B-splines over one knot vector (n + degree + 1,)."""
    from scipy.interpolate import BSpline

    knots = np.asarray(knots, dtype=np.float64)
    tip, axis_point = np.asarray(tip, dtype=np.float64), np.asarray(axis_point, dtype=np.float64)
    if tip.shape != axis_point.shape or len(knots) != len(tip) + degree + 1:
        raise PathError(
            f"B-spline of degree {degree} with {len(knots)} knots, {len(tip)} and {len(axis_point)} control points;"
            " it takes as many of both, and degree + 1 knots more"
        )
    breaks = np.unique(knots[degree : len(knots) - degree])
    spline = BSpline(knots, np.concatenate([tip, axis_point], axis=1), degree)
    curves = [spline] + [spline.derivative(order) for order in range(1, 4)]
    return TwoCurveRun(
        breaks=breaks,
        curves=lambda s, order: np.asarray(curves[order](s)),
        most_second=largest_control_points(BSpline(knots, tip, degree).derivative(2), breaks),
        **one_block(breaks[[0, -1]], feed),
    )


def largest_control_points(spline: BSpline, breaks: Floats) -> Floats:
    """(k - 1,) largest control point that has its say between each two breaks (k,): a bound of the spline there."""
    size = np.linalg.norm(spline.c, axis=1)
    last = np.searchsorted(spline.t, breaks[:-1], side="right") - 1
    return np.array([size[j - spline.k : j + 1].max() for j in last])
