"""Whole numbers that are left of a joint's positions, velocities, accelerations and jerks by a prediction.

Of positions fifth differences are left. Derivatives are predicted by central differences over time steps dt:

    velocity      (45 (q[+1] - q[-1]) - 9 (q[+2] - q[-2]) + (q[+3] - q[-3])) / (60 dt)
    acceleration  2 (q[+1] - 2 q + q[-1]) / dt^2 - (v[+1] - v[-1]) / (2 dt)
    jerk          (8 (a[+1] - a[-1]) - (a[+2] - a[-2])) / (12 dt)

Each takes what is known already, so all rows are predicted at once, in writing and in reading alike. Every operation
rounds as IEEE 754 says, one after the other, so that both predict the same on any computer.
"""

from __future__ import annotations

import numpy as np

from toolpace.common.arrays import Floats, Ints
from toolpace.motion.files.packed_integers import AS_THEY_ARE, values_of, whole_numbers

ORDER = 5
"""Of the differences of positions: of the orders 3 to 7 this one leaves the fewest bits (docs/design/set_points.md)."""
KINDS = 4
"""Columns of a joint: position and three derivatives."""
REACH = (0, 3, 1, 2)
"""Rows before and behind that a prediction takes."""
_LARGEST = 2.0**62
"""A prediction beyond is none."""


def residuals(jets: Floats, dt: float) -> tuple[list[Ints], list[int]]:
    """What is left (n,) of each of a joint's columns (4, n), and the exponents of their grids, for `jets_of`."""
    left, exponents = [], []
    for kind in range(KINDS):
        numbers, exponent = whole_numbers(jets[kind])
        if kind == 0:
            for _ in range(ORDER):
                numbers = np.diff(numbers, prepend=np.int64(0))
        else:
            numbers = numbers - predicted(jets, kind, dt, exponent)
        left.append(numbers)
        exponents.append(exponent)
    return left, exponents


def jets_of(left: list[Ints], exponents: list[int], dt: float, out: Floats) -> None:
    """Put the columns (4, n) that `residuals` took into `out`. Raises DamagedError for exponents of none."""
    for kind in range(KINDS):
        numbers = left[kind]
        if kind == 0:
            for _ in range(ORDER):
                numbers = np.cumsum(numbers)
        else:
            numbers = numbers + predicted(out, kind, dt, exponents[kind])
        out[kind] = values_of(numbers, exponents[kind])


def predicted(jets: Floats, kind: int, dt: float, exponent: int) -> Ints:
    """(n,) the whole numbers of a derivative that the columns before it in jets (4, n) tell; zeros at the ends."""
    count, reach = jets.shape[1], REACH[kind]
    guess = np.zeros(count, dtype=np.int64)
    if exponent == AS_THEY_ARE or count <= 2 * reach:
        return guess

    def across(values: Floats, steps: int) -> Floats:
        """What values (n,) change by from so many steps before to as many behind."""
        return values[reach + steps : count - reach + steps] - values[reach - steps : count - reach - steps]

    q, v, a, _ = jets
    with np.errstate(all="ignore"):
        if kind == 1:
            found = (45.0 * across(q, 1) - 9.0 * across(q, 2) + across(q, 3)) / (60.0 * dt)
        elif kind == 2:
            found = 2.0 * ((q[2:] - q[1:-1]) - (q[1:-1] - q[:-2])) / (dt * dt) - across(v, 1) / (2.0 * dt)
        else:
            found = (8.0 * across(a, 1) - across(a, 2)) / (12.0 * dt)
        found = np.rint(found * 2.0**-exponent)
        guess[reach : count - reach] = np.where(np.abs(found) < _LARGEST, found, 0.0)
    return guess
