"""Joint paths through waypoints: natural splines of degree five, or straight lines between stops.

Of all curves through the waypoints the natural quintic spline has the least integral of its squared third derivative
over the parameter, which is what jerk is made of. It is four times continuously differentiable, and its third and
fourth derivatives vanish at both ends. Two waypoints make a straight line, three a parabola.

Source: I. J. Schoenberg, Spline interpolation and best quadrature formulae (1964), for the property of least integral.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from toolpace.common.arrays import Floats, numbers
from toolpace.common.errors import PathError, UnitWarning, UsageError
from toolpace.path.axispath.cap import SpeedCap
from toolpace.path.axispath.spline import SplineAxisRun, line_run, spline_run

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
