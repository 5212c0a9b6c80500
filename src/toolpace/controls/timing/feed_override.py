"""Moves with other feeds than the program's, as `--feed` asks for."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from toolpace.programs.commanded import Commanded
from toolpace.programs.reading.feeds import FeedChange


def refed(moves: Commanded, change: FeedChange) -> Commanded:
    """The moves with their feeds changed; rapids keep having none.

    As of tool paths: a value rules where X, Y, Z move, turns in place keep their time or speed.
    """
    if change.speed is None:
        factor = change.factor
        return replace(moves, speed=moves.speed * factor, turn=moves.turn * factor, time=moves.time / factor)
    if np.isinf(change.speed):
        free = np.full(len(moves), np.inf)
        return replace(moves, speed=free, turn=free.copy(), time=np.zeros(len(moves)))
    ruled = ~moves.rapid & (moves.length > 0.0)
    return replace(moves, speed=np.where(ruled, change.speed, moves.speed), time=np.where(ruled, 0.0, moves.time))
