"""Joint runs from piecewise polynomials of a caller, or from waypoints: natural quintic splines, lines between stops.

Between its knots a spline is analytic. At a knot its derivatives may jump, and what that does to the motion decides
what is taken:

    jump of q, q'    the velocity would jump: no motion follows it without a stop; refused
    jump of q''      the acceleration would jump, and no number bounds the jerk there; refused
    jump of q'''     the jerk jumps within its limit: a break, which the planner takes a node to

Of all curves through the waypoints the natural quintic spline has the least integral of its squared third derivative
over the parameter, which is what jerk is made of. It is four times continuously differentiable, and its third and
fourth derivatives vanish at both ends. Two waypoints make a straight line, three a parabola.

Source: I. J. Schoenberg, Spline interpolation and best quadrature formulae (1964), for the property of least integral.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from math import factorial
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from toolpace.common.arrays import Floats, numbers
from toolpace.common.errors import PathError, UnitWarning, UsageError
from toolpace.path.axis_run import AxisRun, SpeedCap

if TYPE_CHECKING:
    from scipy.interpolate import BSpline, PPoly

ORDERS = 4
"""Position and three derivatives."""
JUMP = 1e-9
"""Jump of a derivative, times the power of the piece's length that makes it a position, as a share of the motion on
both pieces, above which it is one: what solving for an interpolating spline leaves is below 1e-12."""
ROUNDING = 1e-13
"""The same for rounding of the positions, as a share of their size: joints may be far from zero."""
DEGREE = 5
ROWS = "one row a waypoint, q[:, None] for one joint"
SPOILED = 1e-6
"""Distance from a waypoint at first, as a share of the joint's range and size, from which rounding spoils a spline.

Measured on a sine: with steps of 1e-4 beside 1 it is 8e-9, and the third derivative right to eleven digits; with steps
of 1e-6 it is 1e-4, and the third derivative 4500 times too large.
"""
MISSED = 1e-10
"""The same in the end."""
FAR = 4.0 * np.pi
"""Position that no slide has [m], and next to no waypoint of a turning joint: two turns [rad]."""
LARGEST = 1e12
"""Most of a parameter: its fifth power, and more of it, must stay a number."""
ROUND = 1e-9
"""Share of a position up to which it counts as one of a decimal."""


class SplineAxisRun(AxisRun):
    """A run of piecewise polynomials of any degree, in powers of the distance from the left end of each piece."""

    def __init__(self, knots: Floats, coefficients: Floats, speed_cap: SpeedCap) -> None:
        """Take the knots (k + 1,), ascending, and Taylor coefficients (degree + 1, k, m), of the highest power first.

        PathError where a derivative jumps that must not.
        """
        from scipy.interpolate import PPoly

        self.knots, self.coefficients, self.cap = knots, coefficients, speed_cap
        for value in (knots, coefficients):
            value.flags.writeable = False
        self.s0, self.s1, self.hints = float(knots[0]), float(knots[-1]), knots
        first = PPoly(coefficients, knots, extrapolate=True)
        self._orders = [first] + [first.derivative(order) for order in range(1, ORDERS)]
        self.breaks = knots[1:-1][third_jumps(knots, coefficients)]

    def evaluate(self, s: Floats) -> Floats:
        return np.stack([polynomial(s) for polynomial in self._orders])

    def speed_cap(self, s: Floats) -> Floats:
        return self.cap.at(s)


def third_jumps(knots: Floats, coefficients: Floats) -> npt.NDArray[np.bool_]:
    """(k - 1,) inner knots at which q''' jumps. PathError where position, slope or curvature does.

    A jump of the derivative of order d moves the joint by about jump h^d / d! over a piece of length h; what counts is
    how that compares with the motion on both pieces.
    """
    h = np.diff(knots)
    degree = len(coefficients) - 1
    powers = np.arange(degree, -1, -1)
    # (degree + 1, k, m): how far each term moves the joint on its piece; the last one is where it begins
    terms = np.abs(coefficients) * h[None, :, None] ** powers[:, None, None]
    motion, size = terms[:-1].sum(axis=0), terms[-1]
    allowed = JUMP * (motion[1:] + motion[:-1]) + ROUNDING * (size[1:] + size[:-1] + motion[1:] + motion[:-1])
    shorter = np.minimum(h[1:], h[:-1])[:, None]
    jumps = np.zeros((len(h) - 1, coefficients.shape[2]), dtype=np.bool_)
    for order, what in enumerate(("position", "slope", "curvature", "third derivative")):
        left, right = _sides(coefficients, h, order)
        jumps = np.abs(right - left) * shorter**order > allowed
        if order < ORDERS - 1 and jumps.any():
            knot, joint = (int(i) for i in np.argwhere(jumps)[0])
            raise PathError(
                f"path: the {what} of joint {joint + 1} jumps from {left[knot, joint]:.6g} to "
                f"{right[knot, joint]:.6g} at s = {knots[knot + 1]:.9g}; a motion needs the path twice continuously "
                "differentiable: use AxisPath.from_waypoints, or split it there"
            )
    return np.asarray(jumps.any(axis=1), dtype=np.bool_)


def _sides(coefficients: Floats, h: Floats, order: int) -> tuple[Floats, Floats]:
    """(k - 1, m) the derivative of an order at the inner knots: from the left, and from the right."""
    degree = len(coefficients) - 1
    left, right = np.zeros(coefficients.shape[1:]), np.zeros(coefficients.shape[1:])
    for power in range(order, degree + 1):
        factor = factorial(power) // factorial(power - order)
        term = factor * coefficients[degree - power]
        left += term * h[:, None] ** (power - order)
        if power == order:
            right = term
    return left[:-1], right[1:]


def spline_run(spline: BSpline | PPoly, speed_cap: float | Callable[[Floats], npt.ArrayLike]) -> SplineAxisRun:
    """A run along the whole of a spline (m,)-valued or, of one joint, scalar. UsageError for what is no such spline."""
    knots, coefficients = _pieces(spline)
    if len(knots) < 2 or not (np.diff(knots) > 0.0).all():
        raise UsageError("path: the spline's knots must ascend from one end to the other; turn it round")
    if not np.isfinite(coefficients).all() or not np.isfinite(knots).all():
        raise UsageError("path: the spline has knots or coefficients that are not finite; give finite numbers")
    return SplineAxisRun(knots, coefficients, SpeedCap(speed_cap))


def _pieces(spline: Any) -> tuple[Floats, Floats]:
    """Knots (k + 1,) and Taylor coefficients (degree + 1, k, m) of a spline of scipy, without those past its ends."""
    from scipy.interpolate import BSpline, PPoly

    if not isinstance(spline, BSpline | PPoly):
        raise UsageError(
            f"path: {type(spline).__name__} is no spline that is taken; give a BSpline, CubicSpline or other PPoly of "
            "scipy.interpolate, or any function to AxisPath.from_callable"
        )
    array = np.asarray(spline.c)
    if array.dtype.kind not in "iuf":
        raise UsageError(f"path: the spline's coefficients are {array.dtype}; give real numbers")
    shape = array.shape[1:] if isinstance(spline, BSpline) else array.shape[2:]
    if len(shape) > 1 or 0 in shape:
        raise UsageError(f"path: the spline's values have shape {shape}; give (joints,), one column a joint")
    if isinstance(spline, PPoly):
        # a copy of the pieces alone: a periodic spline takes its last parameter for the first
        return np.array(spline.x, dtype=float), np.array(array, dtype=float).reshape(*array.shape[:2], -1)
    degree = int(spline.k)
    knots = np.unique(np.asarray(spline.t, dtype=float)[degree : len(spline.t) - degree])
    # without `axis` the values are (n, joints), however the caller wants his own
    plain = BSpline(spline.t, array.reshape(len(array), -1), degree)
    taylor = [plain(knots[:-1], nu=power) / factorial(power) for power in range(degree, -1, -1)]
    return knots, np.ascontiguousarray(taylor)


def line_run(s: tuple[float, float], q: Floats, speed_cap: SpeedCap) -> SplineAxisRun:
    """The straight line between two points q (2, m)."""
    slope = (q[1] - q[0]) / (s[1] - s[0])
    return SplineAxisRun(np.array(s), np.ascontiguousarray([slope, q[0]])[:, None, :].copy(), speed_cap)


def waypoint_runs(
    q: npt.ArrayLike,
    s: npt.ArrayLike | None,
    speed_cap: float | Callable[[Floats], npt.ArrayLike],
    stop: bool,
) -> tuple[SplineAxisRun, ...]:
    """One run through waypoints q (n, m) at s (n,), or with `stop` one from each to the next; see AxisPath."""
    points = _checked(q)
    parameter = chord_lengths(points) if s is None else _parameter(s, len(points))
    if stop or len(points) == 2:
        cap = SpeedCap(speed_cap)
        ends = parameter.tolist()
        return tuple(line_run((ends[k], ends[k + 1]), points[k : k + 2], cap) for k in range(len(points) - 1))
    return (_natural_run(parameter, points, speed_cap),)


def _natural_run(s: Floats, points: Floats, speed_cap: float | Callable[[Floats], npt.ArrayLike]) -> SplineAxisRun:
    from scipy.interpolate import make_interp_spline

    still = np.zeros(points.shape[1])
    natural: Any = [(3, still), (4, still)]
    size = np.ptp(points, axis=0) + np.abs(points).max(axis=0)
    spline = make_interp_spline(s, points, k=DEGREE, bc_type=(natural, natural))
    missed = points - spline(s)
    spoiled = not (np.abs(missed) <= SPOILED * size).all()
    # where steps differ by much, the equations lose digits: what is missed is interpolated, and added
    spline.c += make_interp_spline(s, missed, k=DEGREE, bc_type=(natural, natural)).c
    try:
        run = spline_run(spline, speed_cap)
        off = np.abs(run.evaluate(s)[0] - points).max(axis=0)
    except PathError:
        off = np.full(points.shape[1], np.inf)
    if spoiled or (off > MISSED * size).any():
        h = np.diff(s)
        k = int(np.argmin(h / np.maximum(np.append(h[1:], 0.0), np.append(0.0, h[:-1]))))
        raise UsageError(
            f"waypoints: q[{k + 1}] lies too close to q[{k}] for a spline through both ({h[k]:.3g} apart in s, "
            "far less than their neighbours); leave one of them out"
        )
    return run


def chord_lengths(points: Floats) -> Floats:
    """(n,) how far each waypoint (n, m) is along the polygon through them, each joint in shares of its whole range.

    The shares make metres and radians alike, and slides and arms.
    """
    span = np.ptp(points, axis=0)
    moves = span > 0.0
    steps = np.diff(points[:, moves] / span[moves], axis=0)
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(steps, axis=1))])


def _checked(q: npt.ArrayLike) -> Floats:
    points = numbers(q, "waypoints: q", ("n", "joints"), unit="m or rad", cure=ROWS).copy()
    if points.shape[1] == 0:
        raise UsageError(f"waypoints: q has no joints; {ROWS}")
    if len(points) < 2:
        raise UsageError(f"waypoints: {len(points)} of them make no path; give at least two")
    _ask_about_unit(points)
    same = np.flatnonzero((points[1:] == points[:-1]).all(axis=1))
    if len(same):
        k = int(same[0])
        raise UsageError(
            f"waypoints: q[{k + 1}] repeats q[{k}]; leave it out; to wait there, plan the ways to it and from it apart"
        )
    return points


def _ask_about_unit(points: Floats) -> None:
    """Warn of positions far beyond those of joints in m and rad that are round as those in mm and degrees are."""
    far = np.abs(points) > FAR
    if far.any() and not (np.abs(10.0 * points - np.rint(10.0 * points)) > ROUND * np.abs(points)).any():
        i, j = (int(each) for each in np.argwhere(far)[0])
        warnings.warn(
            f"waypoints: q[{i}, {j}] is {points[i, j]:g}, and all are round; positions are in m or rad: are these mm "
            "or degrees? Then give 1e-3 * q, or np.radians(q)",
            UnitWarning,
            stacklevel=5,
        )


def _parameter(s: npt.ArrayLike, count: int) -> Floats:
    parameter = numbers(s, "waypoints: s", (count,), cure=f"one for each of {count} waypoints").copy()
    falls = np.flatnonzero(np.diff(parameter) <= 0.0)
    if len(falls):
        k = int(falls[0])
        raise UsageError(
            f"waypoints: s[{k + 1}] = {parameter[k + 1]:g} does not lie above s[{k}] = {parameter[k]:g}; s must grow"
        )
    if np.abs(parameter).max() > LARGEST:
        raise UsageError(f"waypoints: s goes to {np.abs(parameter).max():g}; give values of {LARGEST:g} at most")
    return parameter
