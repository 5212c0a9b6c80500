"""The speed of the bent tip, and a feed that holds for it.

The bent tip is at P(s) + D(s), P the commanded tip and D the bending that is compensated. It goes |P' + D'| / |P'|
times as fast as the commanded one. Where that is more than 1, the way gets blocks of its own with a feed that is so
much less. D is told at the places of the program, and straight between them.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from toolpace.common.arrays import Floats, Ints
from toolpace.cutting.bending.inserted_points import Places
from toolpace.cutting.bending.prediction import parameters
from toolpace.motion.trajectory import Trajectory
from toolpace.path.path import Path
from toolpace.path.run import PathRun

GRACE = 1e-4
"""Share of the feed that the bent tip may pass it by, as the limits of plans may be passed between set-points."""
STEP = 0.25 * GRACE
"""Feeds of blocks are less by a whole number of these shares, so that few blocks tell them."""


def keeping_feed(fitted: Path, places: Places, kept: Ints, bending: Floats) -> Path:
    """A path that was fitted to the places `kept` (k,), as one of the program's points, one block for each way of it;
    of more blocks where the tip, bent by (n, 3) [m], would pass the feed."""
    return replace(fitted, runs=tuple(_keeping_feed(run, places, kept, bending) for run in fitted.runs))


def excess_of_feed(fitted: Path, places: Places, kept: Ints, bending: Floats, trajectory: Trajectory) -> float:
    """The most by which the tip, bent by (n, 3) [m], passes the feeds of the program, as a share of them."""
    worst = 0.0
    for run, law in zip(fitted.runs, trajectory.laws):
        at, s = _cells(places, kept, run)
        feed = places.toolpath.feed[at[1:]]
        pace, slope, drift = law.states_at(s)[1], run.tip_slope(s), _drift(at, s, bending)
        for end in (slice(None, -1), slice(1, None)):
            speed = pace[end] * np.linalg.norm(slope[end] + drift, axis=1)
            worst = max(worst, float(np.max(speed / feed, initial=0.0)) - 1.0)
    return worst


def _keeping_feed(run: PathRun, places: Places, kept: Ints, bending: Floats) -> PathRun:
    at, s = _cells(places, kept, run)
    path, leads = places.toolpath, places.origin[at[1:]]
    point = at[1:]
    fed = np.isfinite(path.feed[point]) & (path.least_time[point] == 0.0)
    less = np.where(fed, 1.0 - 1.0 / _faster(run, at, s, bending), 0.0)
    steps = np.ceil(np.maximum(less - STEP, 0.0) / STEP)
    head = np.flatnonzero(np.concatenate([[True], (np.diff(leads) != 0) | (np.diff(steps) != 0)]))
    return replace(
        run,
        block_start=np.append(s[:-1][head], s[-1]),
        block=path.block[point][head],
        feed=path.feed[point][head] * (1.0 - STEP * steps[head]),
        least_time=np.add.reduceat(path.least_time[point], head),
        entry=leads[head],
    )


def _cells(places: Places, kept: Ints, run: PathRun) -> tuple[Ints, Floats]:
    """The places (k,) that a run goes along, without those that stand where another does, and its parameters there."""
    at, s = parameters(places, kept, run)
    # of places that stand together the last has the way that leads on, and the first the one that leads there
    moves = np.concatenate([[True], np.diff(s) > 0.0])
    return at[moves], s[moves]


def _drift(at: Ints, s: Floats, bending: Floats) -> Floats:
    """(k - 1, 3) D' in each cell between places `at` (k,)."""
    drift: Floats = np.diff(bending[at], axis=0) / np.diff(s)[:, None]
    return drift


def _faster(run: PathRun, at: Ints, s: Floats, bending: Floats) -> Floats:
    """(k - 1,) how many times as fast the bent tip is in each cell, at the most; at least 1."""
    drift = _drift(at, s, bending)
    slope = run.tip_slope(s)
    own = np.linalg.norm(slope, axis=1)
    own = np.where(own > 0.0, own, np.inf)
    most = np.ones(len(drift))
    padded = np.concatenate([drift[:1], drift, drift[-1:]])
    for beside in (padded[:-2], drift, padded[2:]):
        for k in (slice(None, -1), slice(1, None)):
            most = np.maximum(most, np.linalg.norm(slope[k] + beside, axis=1) / own[k])
    return most
