"""Exactly given runs: a callable, a circular arc, a pair of B-splines."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, TypedDict

import numpy as np

from toolpace.common.arrays import Floats, Ints, number, numbers
from toolpace.common.errors import PathError, UsageError
from toolpace.common.workers import Lock
from toolpace.machine.kinematics import UNIT
from toolpace.path.callable_run import check_derivatives
from toolpace.path.run import PathJet, PathRun, unit_jets

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
        if not all(isinstance(part, tuple | list) and len(part) == 2 for part in parts):
            raise PathError(
                "path: f(s, order) is not a pair; return the derivatives of tip (n, 3) and tool axis (n, 3)"
            )
        tip = np.stack([_rows(part[0], len(s), f"the tip of f(s, {k})") for k, part in enumerate(parts)])
        axis = np.stack([_rows(part[1], len(s), f"the tool axis of f(s, {k})") for k, part in enumerate(parts)])
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
    s0, s1 = number(s0, "path: s0"), number(s1, "path: s1")
    if not s1 > s0:
        raise PathError(f"a path from s0 = {s0:g} to s1 = {s1:g} has no length; give s0 < s1")
    ends = np.array([s0, s1], dtype=np.float64)
    return CurveRun(breaks=ends, curve=curve, most_second=most_second, **one_block(ends, feed))


class BlockTable(TypedDict):
    """The block arrays of a run."""

    block_start: Floats
    block: Ints
    feed: Floats
    least_time: Floats


def checked_run(curve: Curve, s0: float, s1: float, feed: float) -> CurveRun:
    """The run of a caller's function. Raises PathError where its derivatives are not those of its positions."""
    run = callable_run(curve, s0, s1, feed)

    def columns(s: Floats) -> Floats:
        jet = run.evaluate(s)
        assert jet.axis is not None
        length = np.linalg.norm(jet.axis[0], axis=1)
        if not (np.abs(length - 1.0) <= UNIT).all():
            at = int(np.argmin(np.abs(length - 1.0) <= UNIT))
            raise PathError(
                f"path: the tool axis has the length {length[at]:.9g} at s = {s[at]:.9g}; divide it by its length, and "
                "give the derivatives of that"
            )
        return np.concatenate([jet.tip, jet.axis], axis=2)

    names = [f"{part} {coordinate}" for part in ("tip", "axis") for coordinate in "xyz"]
    check_derivatives(columns, run.s0, run.s1, names)
    return run


def _rows(value: object, count: int, name: str) -> Floats:
    """What a caller's function gave, as real numbers (count, 3). Raises PathError where it gave something else."""
    found = np.asarray(value)
    if found.dtype.kind not in "iuf" or found.shape not in ((count, 3), (1, 3), (3,), (count, 1), (1,), ()):
        raise PathError(
            f"path: {name} has shape {found.shape} of {found.dtype} for {count} values of s; give real numbers (n, 3)"
        )
    return np.broadcast_to(found.astype(np.float64, copy=False), (count, 3))


def one_block(ends: Floats, feed: float) -> BlockTable:
    """The block table of a run of one block."""
    feed = number(feed, "path: feed", least=0.0, above=True, endless=True, unit="m/s")
    return {
        "block_start": ends.copy(),
        "block": np.ones(1, dtype=np.int64),
        "feed": np.array([feed]),
        "least_time": np.zeros(1),
    }


def arc_run(centre: Floats, start: Floats, normal: Floats, sweep: float, lean: float, feed: float) -> CurveRun:
    """A circular arc over its length, the tool axis in its plane at a constant angle to the outward normal.

    n (normal, towards you)     P(s) = centre + R (e cos th + f sin th),  th = s / R
    f |  /axis                  axis = e cos(th + lean) + f sin(th + lean)
      | / ) lean
      |/____ e = (start - centre) / R,  f = n x e
    """
    centre, start = numbers(centre, "arc: centre", (3,), unit="m"), numbers(start, "arc: start", (3,), unit="m")
    normal = numbers(normal, "arc: normal", (3,))
    sweep, lean = number(sweep, "arc: sweep", unit="rad"), number(lean, "arc: lean", unit="rad")
    if not normal.any():
        raise PathError("arc: normal is zero; give the direction about which the arc turns")
    radius = float(np.linalg.norm(start - centre))
    if radius == 0.0 or sweep <= 0.0:
        raise PathError(
            f"an arc of radius {radius:g} m and sweep {sweep:g} rad has no length; turn the normal to go back"
        )
    e = (start - centre) / radius
    n = normal / np.linalg.norm(normal)
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

    knots = numbers(knots, "B-spline: knots", ("k",))
    tip = numbers(tip, "B-spline: tip", ("n", 3), unit="m")
    axis_point = numbers(axis_point, "B-spline: axis_point", ("n", 3), unit="m")
    if not isinstance(degree, int) or degree < 1:
        raise UsageError(f"B-spline: degree is {degree!r:.40}; give a whole number of 1 or more, 3 for a cubic")
    if tip.shape != axis_point.shape or len(knots) != len(tip) + degree + 1:
        raise PathError(
            f"B-spline of degree {degree} with {len(knots)} knots, {len(tip)} and {len(axis_point)} control points;"
            " it takes as many of both, and degree + 1 knots more"
        )
    if (np.diff(knots) < 0.0).any() or not knots[degree] < knots[len(knots) - 1 - degree]:
        raise PathError("B-spline: knots must ascend from one end to the other; sort them")
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
