"""The straight line, whose fastest motion is known in closed form."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from toolpace.path.axis_path import AxisPath


def polynomials(*coefficients: list[float]) -> Callable[[np.ndarray, int], np.ndarray]:
    """A path whose joints are polynomials of s, given from the constant up."""
    joints = [np.polynomial.Polynomial(c) for c in coefficients]
    return lambda s, order: np.stack([(p.deriv(order) if order else p)(s) + 0.0 * s for p in joints], axis=1)


def line(length: float = 1.0, **options: Any) -> AxisPath:
    """One joint that goes a length while s goes from 0 to 1."""
    return AxisPath.from_callable(polynomials([0.0, length]), **options)


def s_curve(length: float, v: float, a: float, j: float) -> float:
    """Shortest time from rest to rest over a length: up to seven phases of constant jerk."""
    reached = v if v * j >= a * a else None
    if reached is not None:
        ramp = v / a + a / j
    else:
        ramp = 2.0 * np.sqrt(v / j)
    if ramp * v <= length:
        return 2.0 * ramp + (length - ramp * v) / v
    # the speed limit is not reached
    if 2.0 * a**3 / j**2 >= length:
        return 4.0 * np.cbrt(length / (2.0 * j))
    peak = (-a * a / j + np.sqrt(a**4 / j**2 + 4.0 * a * length)) / 2.0
    return 2.0 * (peak / a + a / j)
