"""Largest values of long rows, found block by block: a block stays in the cache of a core, and all cores work."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import NamedTuple, TypeVar

import numpy as np

from toolpace.common.arrays import Floats, Ints
from toolpace.motion.setpoints import SetPoints

R = TypeVar("R")

ROWS = 1 << 13
"""Rows of a block: ten columns of them take less than a megabyte."""
ORDERS = (1, 2, 3)
"""Of differences: velocity, acceleration and jerk."""
EPS = float(np.finfo(np.float64).eps)
"""Relative distance from 1 to the next number: rounding is at most half of it."""


def each_block(work: Callable[[int, int], R], count: int) -> list[R]:
    """What `work(begin, end)` makes of each block of `count` rows, in order; one empty block where there are none.

    Blocks are worked on at the same time, so `work` may write only to rows of its own.
    """
    begins = range(0, max(count, 1), ROWS)
    if len(begins) == 1:
        return [work(0, count)]
    with ThreadPoolExecutor(min(os.cpu_count() or 1, len(begins))) as threads:
        futures = [threads.submit(work, begin, min(begin + ROWS, count)) for begin in begins]
        try:
            return [future.result() for future in futures]
        finally:
            threads.shutdown(cancel_futures=True)


class Largest(NamedTuple):
    """The largest value in each column, and the first row that has it."""

    value: Floats
    """(m,)"""
    row: Ints
    """(m,)"""

    @classmethod
    def of(cls, columns: Floats, begin: int) -> Largest:
        """That of columns (m, k) of the rows from `begin` on; 0 where there are none."""
        if not columns.shape[1]:
            return cls(np.zeros(len(columns)), np.full(len(columns), begin))
        row = columns.argmax(axis=1)
        return cls(columns[np.arange(len(columns)), row], begin + row)

    @classmethod
    def of_all(cls, parts: Sequence[Largest]) -> Largest:
        """That of all blocks, from that of each."""
        values = np.stack([part.value for part in parts])
        block, column = values.argmax(axis=0), np.arange(values.shape[1])
        return cls(values[block, column], np.stack([part.row for part in parts])[block, column])


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
