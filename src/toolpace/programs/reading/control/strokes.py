"""Strokes: straight moves that end on one line, from which drilling motions are made.

A hole takes ten of them, and a program has thousands of holes that are alike: what they share is kept once.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from toolpace.common.arrays import Bools, Floats, Ints


class Stroke(NamedTuple):
    """A straight way to a level, and what is done there."""

    level: float
    """Coordinate of the program along the line [m]."""
    rapid: bool = True
    speed: float = 0.0
    """Of a way at feed [m/s]; 0: that in force."""
    stop: bool = False
    dwell: float = 0.0
    """[s]"""


class StrokeTable(NamedTuple):
    """Strokes of a hole as arrays: the motions that one row of moves stands for."""

    offset: Floats
    """(k, 3) from the row's position to the end of each [m]."""
    rate: Floats
    """(k, 3): speed [m/s], turn [rad/s], time [s]."""
    kind: Floats
    stop: Bools
    dwell: Floats


class Expansion:
    """Rows of moves, some of which stand for strokes, to the rows of single motions."""

    def __init__(self, rows: int, strokes: dict[int, StrokeTable]) -> None:
        count = np.ones(rows, dtype=np.int64)
        alike: dict[int, tuple[StrokeTable, list[int]]] = {}
        for row, table in strokes.items():
            alike.setdefault(id(table), (table, []))[1].append(row)
        for table, of in alike.values():
            count[of] = len(table.kind)
        self.row: Ints = np.repeat(np.arange(rows), count)
        """Of each motion, the row that it comes from."""
        self.last: Ints = np.cumsum(count) - 1
        """Of each row, its last motion."""
        self.strokes = [
            (table, self.last[of][:, None] + np.arange(1 - len(table.kind), 1)) for table, of in alike.values()
        ]
        """Strokes (k,), and the motions (holes, k) that they are."""
