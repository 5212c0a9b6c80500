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
from toolpace.motion.setpoints import Block

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


class BlockPeaks(NamedTuple):
    """The largest values of each joint in one block, without sign."""

    position: Floats
    """(m,)"""
    columns: list[Largest]
    differences: list[Largest]
    mean_jerk: Floats
    """(m,)"""

    @classmethod
    def of(cls, block: Block, begin: int, end: int, even: int) -> BlockPeaks:
        """Those of some rows of a motion whose first `even` set-points come at equal steps."""
        n = block.of_all
        q = block.columns("q", begin, min(end + ORDERS[-1], n))
        columns = [Largest.of(np.abs(block.columns(name, begin, end)), begin) for name in ("qd", "qdd", "qddd")]
        differences, difference = [], q[:, : max(even - begin, 0)]
        for order in ORDERS:
            difference = np.diff(difference, axis=1)
            of_rows = difference[:, : max(min(end, even - order) - begin, 0)]
            differences.append(Largest.of(np.abs(of_rows), begin))
        change = np.diff(block.columns("qdd", begin, min(end + 1, n)), axis=1)
        mean = np.abs(change / np.diff(block.times(begin, min(end + 1, n)))).max(axis=1, initial=0.0)
        return cls(np.abs(q).max(axis=1), columns, differences, mean)


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
    """First to third difference of positions over dt ** order, and the set-point in its middle."""
    mean_jerk: Floats
    """(m,) change of the accelerations over a step, by its time."""

    @classmethod
    def of_all(cls, parts: Sequence[BlockPeaks], t: Floats, ending: Floats, dt: float) -> Peaks:
        """Those of all blocks of a motion at times t (n,) every `dt` [s], the last of which may come sooner; `ending`
        (k, m) are its last positions."""
        n, even = len(t), even_rows(t, dt)
        position, columns, differences, mean = zip(*parts)
        largest_position = np.max(position, axis=0)
        found = []
        for order, of_blocks in zip(ORDERS, zip(*differences)):
            value, row = Largest.of_all(of_blocks)
            value, row = value / dt**order, row + order // 2 if even > order else np.zeros_like(row)
            # a shorter last step by divided differences
            last = np.array([
                last_difference(q, t[-len(q) :], order, dt, float(most)) for q, most in zip(ending.T, largest_position)
            ])  # fmt: skip
            found.append(Largest(np.maximum(value, last), np.where(last > value, n - 1, row)))
        return cls(
            dt, float(np.abs(t).max()), largest_position, tuple(Largest.of_all(each) for each in zip(*columns)),
            tuple(found), np.max(mean, axis=0),
        )  # fmt: skip

    def difference(self, order: int, joint: int) -> tuple[float, int]:
        """Largest |difference| / dt^order of a joint, and the set-point in its middle."""
        found = self.differences[order - 1]
        return float(found.value[joint]), int(found.row[joint])


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
    """Largest |difference| / dt^order of positions (n,), less what a `rounding` (n,) of these may make of it, and the
    set-point in its middle."""
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
