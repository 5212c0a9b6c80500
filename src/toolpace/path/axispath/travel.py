"""A check of joint paths against the travel of the joints."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.path.axispath.axispath import AxisPath
from toolpace.path.axispath.run import AxisRun

PARTS = 4
"""Looks at each piece of a path, and at the way from one hint to the next."""


def check_travel(path: AxisPath, source: str = "", begin: float = -np.inf) -> None:
    """Raise ReachError where a joint of the path's machine leaves its travel, naming the worst one and its line.

    `begin` is the parameter of the first run from which on it is looked at.
    """
    if path.machine is None:
        return
    places = [_places(run) for run in path.runs]
    places[0] = np.append(np.clip(begin, *places[0][[0, -1]]), places[0][places[0] > begin])
    positions = [run.evaluate(s)[0] for run, s in zip(path.runs, places)]
    blocks = [run.block_at(s) for run, s in zip(path.runs, places)]
    path.machine.check_travel(np.concatenate(positions), np.concatenate(blocks), source)


@lru_cache(64)
def joint_ranges(run: AxisRun) -> Floats:
    """(2, m) least and largest positions of the joints along a run."""
    q = run.evaluate(_places(run))[0]
    return np.stack([q.min(axis=0), q.max(axis=0)])


def _places(run: AxisRun) -> Floats:
    """Parameters at which a run is looked at, ascending."""
    knots = np.unique(np.concatenate([[run.s0], run.hints, run.breaks, [run.s1]]))
    between = knots[:-1, None] + np.diff(knots)[:, None] * np.arange(PARTS) / PARTS
    return np.append(between.ravel(), knots[-1])
