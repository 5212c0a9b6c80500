"""Largest differences of positions and largest values of the columns of each joint, found in one pass over the rows."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.judge.blocks import Largest, each_block
from toolpace.motion.setpoints import SetPoints

ORDERS = (1, 2, 3)
"""Of differences: velocity, acceleration and jerk."""
EPS = float(np.finfo(np.float64).eps)
"""Relative distance from 1 to the next number: rounding is at most half of it."""


@dataclass(frozen=True)
class Peaks:
    """The largest values of each joint, without sign."""

    dt: float
    """Time step [s]."""
    time: float
    """[s]"""
    position: Floats
    """(m,)"""
    columns: tuple[Largest, ...]
    """Of the velocities, accelerations and jerks that the set-points tell."""
    differences: tuple[Largest, ...]
    """First to third difference of positions at equal steps, over dt ** order, and the set-point in its middle."""
    mean_jerk: Floats
    """(m,) change of the accelerations over a step, by its time."""

    @classmethod
    def of(cls, points: SetPoints, dt: float) -> Peaks:
        """Those of set-points every `dt` [s], the last of which may come sooner."""
        n, even = len(points), even_rows(points.t, dt)

        def of_block(begin: int, end: int) -> tuple[Floats, list[Largest], list[Largest], Floats]:
            q = columns_of(points.q, begin, min(end + ORDERS[-1], n))
            columns = [
                Largest.of(np.abs(columns_of(each, begin, end)), begin)
                for each in (points.qd, points.qdd, points.qddd)
            ]
            differences, difference = [], q[:, : max(even - begin, 0)]
            for order in ORDERS:
                difference = np.diff(difference, axis=1)
                of_rows = difference[:, : max(min(end, even - order) - begin, 0)]
                differences.append(Largest.of(np.abs(of_rows), begin))
            change = np.diff(columns_of(points.qdd, begin, min(end + 1, n)), axis=1)
            mean = np.abs(change / np.diff(points.t[begin : end + 1])).max(axis=1, initial=0.0)
            return np.abs(q).max(axis=1), columns, differences, mean

        position, columns, differences, mean = zip(*each_block(of_block, n))
        found = []
        for order, parts in zip(ORDERS, zip(*differences)):
            largest = Largest.of_all(parts)
            middle = largest.row + order // 2 if even > order else np.zeros_like(largest.row)
            found.append(Largest(largest.value / dt**order, middle))
        return cls(
            dt, float(np.abs(points.t).max()), np.max(position, axis=0),
            tuple(Largest.of_all(parts) for parts in zip(*columns)), tuple(found), np.max(mean, axis=0),
        )  # fmt: skip

    def difference(self, points: SetPoints, order: int, joint: int) -> tuple[float, int]:
        """Largest |difference| / dt^order of a joint and the set-point in its middle; a shorter last step by divided
        differences."""
        found = self.differences[order - 1]
        value, at = float(found.value[joint]), int(found.row[joint])
        last = last_difference(points.q[:, joint], points.t, order, self.dt, float(self.position[joint]))
        return (last, len(points) - 1) if last > value else (value, at)


def columns_of(values: Floats, begin: int, end: int) -> Floats:
    """(m, k) the columns of rows of values (n, m), each in one piece."""
    return np.ascontiguousarray(values[begin:end].T)


def even_rows(t: Floats, dt: float) -> int:
    """How many set-points come at equal steps: all but the last one where it comes sooner."""
    return len(t) - bool(len(t) > 1 and t[-1] - t[-2] < 0.999 * dt)


def last_difference(q: Floats, t: Floats, order: int, dt: float, largest: float) -> float:
    """|Difference| / dt^order of positions (n,) over a last step that is shorter, by divided differences; 0 where it is
    not. `largest` is that of the positions without sign."""
    n = len(q)
    if n <= order or even_rows(t, dt) == n:
        return 0.0
    # The span, not the short step, is what a divided difference of order k is divided by last.
    times, table = t[n - 1 - order :], q[n - 1 - order :]
    for k in range(1, order + 1):
        table = np.diff(table) / (times[k:] - times[:-k])
    shortest = max(float(t[-1] - t[-2]) / dt, 1e-9)
    rounding = 2.0**order * 8.0 * EPS * max(largest, 1.0) / (dt**order * shortest)
    return abs(float(table[0])) * math.factorial(order) - rounding


def difference_beyond_rounding(
    q: Floats, t: Floats, order: int, dt: float, rounding: Floats
) -> tuple[float, int]:
    """As `Peaks.difference`, of positions (n,), less what a `rounding` (n,) of these may make of it."""
    value, at = 0.0, 0
    even = np.abs(np.diff(q[: even_rows(t, dt)], n=order))
    if len(even):
        most = rounding[: len(even)]
        for k in range(1, order + 1):
            most = np.maximum(most, rounding[k : k + len(even)])
        even = np.maximum(even - 2.0**order * most, 0.0)
        k = int(np.argmax(even))
        value, at = float(even[k]) / dt**order, k + order // 2
    last = last_difference(q, t, order, dt, float(np.abs(q).max()))
    return (last, len(q) - 1) if last > value else (value, at)
