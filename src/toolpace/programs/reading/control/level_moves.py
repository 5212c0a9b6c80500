"""Moves between levels along one line of the program's coordinates."""

from __future__ import annotations

from collections.abc import Iterable
from functools import lru_cache

import numpy as np

from toolpace.programs.reading.control.control import ALL, Control
from toolpace.programs.reading.control.moves import FEED, RAPID, Rate
from toolpace.programs.reading.control.strokes import Stroke, StrokeTable

FREE = Rate()
MOST = 4_000_000
"""Motions of all holes of a program: more is a slip of a peck, and would fill memory."""


def along(
    control: Control, words: list[float], axis: int, strokes: Iterable[Stroke], number: float | None = None
) -> None:
    """Move to level after level on the line through words (3 + rotary) along X, Y or Z (0, 1, 2).

    number: F of the block, where feed is by inverse time.
    """
    placement, strokes = control.placement, tuple(strokes)
    if not placement.tip_mode:
        control.need_linear_joints()
    if control.stage is not None:
        control.stage.other_motion("a cycle of holes")
    control.check_dwell(max(stroke.dwell for stroke in strokes))
    by_feed = any(not stroke.rapid and not stroke.speed for stroke in strokes)
    rate = control.feed.rate(number, control.line) if by_feed else FREE
    control.words, control.named = list(words), ALL
    control.words[axis] = 0.0
    moves, at_zero = control.moves, placement.place(control.words)
    way = tuple(row[axis] for row in placement.matrix)
    moves.in_strokes += len(strokes)
    if moves.in_strokes > MOST:
        control.source.fail(f"holes make more than {MOST} motions up to here: check their pecks", control.line)
    moves.strokes[len(moves)] = _table(strokes, rate, way)
    moves.add(at_zero, FREE, control.line, RAPID, placement.tip_mode, ALL, placement.tool_length)
    control.words[axis] = strokes[-1].level


@lru_cache(maxsize=16)
def _table(strokes: tuple[Stroke, ...], rate: Rate, way: tuple[float, ...]) -> StrokeTable:
    """Strokes along a way (3,), those at the feed in force at this rate."""
    rates = [FREE if each.rapid else Rate(each.speed) if each.speed else rate for each in strokes]
    return StrokeTable(
        np.outer([each.level for each in strokes], way),
        np.array(rates),
        np.array([RAPID if each.rapid else FEED for each in strokes]),
        np.array([each.stop or each.dwell > 0.0 for each in strokes]),
        np.array([each.dwell for each in strokes]),
    )
