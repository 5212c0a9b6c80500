"""Work on long rows, block by block: what there is of a block stays in the cache of a core, and all cores work."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple, TypeVar

import numpy as np

from toolpace.common.arrays import Floats, Ints

R = TypeVar("R")

ROWS = 1 << 13
"""Rows of a block: ten columns of them take less than a megabyte."""


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
