"""Where joints with dry friction turn back, as breaks of a run: what friction leaves of a torque jumps there."""

from __future__ import annotations

from copy import copy

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.machine.limits import Limits
from toolpace.motion.laws import TimeLaw
from toolpace.path.axis_run import AxisRun
from toolpace.planning.limit_tolerances import PROMISED

LOOKS = 2000
"""Even places of a run, beside its hints, between which a turn is looked for."""
STANDS = 1e-9
"""Share of its largest velocity along the path up to which a joint stands, but for rounding; [m or rad] on the run."""
BESIDE = 1e-7
"""How far from a turn its sides are looked at, as a share of the run: at the turn itself a joint counts as one that
stands, which dry friction holds."""


def with_breaks(run: AxisRun, places: Floats) -> AxisRun:
    """The run with further breaks (k,)."""
    more = copy(run)
    more.breaks = np.union1d(run.breaks, places)
    return more


def exceeded_turns(run: AxisRun, limits: Limits, law: TimeLaw) -> Floats:
    """(k,) turns that are no breaks yet, and on one side of which a law exceeds a limit."""
    places = np.setdiff1d(turns(run, limits), run.breaks)
    if not len(places):
        return places
    beside = BESIDE * (run.s1 - run.s0)
    both = np.clip(np.concatenate([places - beside, places + beside]), run.s0, run.s1)
    path, state = run.evaluate(both), law.states_at(both)
    used = np.max([rows.ratio(path, state) for rows in limits.rows if rows.jumps_at_turns_of], axis=0)
    exceeded: Floats = places[(used.reshape(2, -1) > PROMISED).any(axis=0)]
    return exceeded


def turns(run: AxisRun, limits: Limits) -> Floats:
    """(k,) places where the velocity along the path of a joint changes its sign, and with it a limit jumps; each the
    first of its sign."""
    joints = np.unique(np.array([k for rows in limits.rows for k in rows.jumps_at_turns_of], dtype=np.int64))
    if not len(joints):
        return np.empty(0)
    s = np.unique(np.concatenate([np.linspace(run.s0, run.s1, LOOKS), run.hints, run.breaks]))
    velocity = run.evaluate(s)[1][:, joints]
    largest = np.abs(velocity).max(axis=0)
    moves = (np.abs(velocity) > STANDS * largest) & (largest * (run.s1 - run.s0) > STANDS)
    at, which = np.nonzero((np.sign(velocity[1:]) != np.sign(velocity[:-1])) & (moves[1:] | moves[:-1]))
    left, right, sign = s[at], s[at + 1], np.sign(velocity[at, which])
    while True:
        middle = 0.5 * (left + right)
        inside = (left < middle) & (middle < right)
        if not inside.any():
            break
        same = np.sign(run.evaluate(middle)[1][np.arange(len(at)), joints[which]]) == sign
        left, right = np.where(inside & same, middle, left), np.where(inside & ~same, middle, right)
    margin = STANDS * (run.s1 - run.s0)
    return np.unique(right[(right > run.s0 + margin) & (right < run.s1 - margin)])
