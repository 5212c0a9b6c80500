"""Grids of powers of two that set-points are rounded to, so that they take little room on disk.

A set-point's last digits are noise of the arithmetic, and noise cannot be compressed. Grids are told by that of the
jerk, u, and the time step, h = 2^k <= dt:

    jerk u    acceleration u h    velocity u h^2    position u h^3 / 4

A third difference of positions is then off by at most 8 (u h^3 / 8) / dt^3 <= u, where u is `SHARE` of the joint's jerk
limit; and no position is off by more than 2^-43 m or rad, 1.2e-13: far below any tolerance.
"""

from __future__ import annotations

import math

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.machine.limits import Limits

SHARE = 1e-5
"""Of a jerk limit by which rounding may show: a tenth of what the judge grants."""
COARSEST = 2.0**-42
"""Grid of positions that is never exceeded [m or rad]."""


def grids(limits: Limits, dt: float) -> Floats:
    """(4, m) grids of positions, velocities, accelerations and jerks of each joint, powers of two.

    Where nothing limits the jerk, the acceleration's limit over a step is taken, and so on.
    """
    h = _power_of_two(dt)
    position = []
    for velocity, acceleration, jerk in zip(limits.velocity, limits.acceleration, limits.jerk):
        by_limits = SHARE * min(float(jerk) * h**3, float(acceleration) * h**2, float(velocity) * h) / 4.0
        position.append(_power_of_two(min(by_limits, COARSEST)))
    q = np.array(position)
    found: Floats = np.stack([q, 4.0 * q / h, 4.0 * q / h**2, 4.0 * q / h**3])
    return found


def round_to(grid: Floats, values: Floats) -> None:
    """Round values (n, m) to grids (m,) of powers of two, in place. What is coarser than its grid stays as it is."""
    values /= grid
    np.rint(values, out=values)
    values *= grid
    values += 0.0  # zero has no sign


def _power_of_two(value: float) -> float:
    """The largest power of two that is at most a value above zero."""
    return math.ldexp(0.5, math.frexp(value)[1])
