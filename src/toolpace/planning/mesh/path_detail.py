"""Places of a path that need a finer mesh: cusps, poles, short features."""

from __future__ import annotations

import itertools
from typing import NamedTuple

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.common.errors import PathError
from toolpace.kernels.optimal import first_guess
from toolpace.machine.limits import Limits
from toolpace.motion import gained_in_a_ramp
from toolpace.path.axis_run import AxisRun
from toolpace.planning.mesh.narrow_feature_search import Gaps, search_narrow_features

UNSEEN = 0.02
"""Share of a limit that may hide between two points of the grid at the speed that the limits allow at them."""
SETTLED = 3
"""Times that a step is halved before it counts as detail: where a grid is a little coarse, that is all it takes."""
FINEST = 1e-13
"""Shortest step of the grid, as a share of the run."""
JUMP = 1e-5
"""Jump of position, velocity or acceleration that is refused, as a share of what a joint gains while its acceleration
builds up: a^3 / j^2, a^2 / j, a. Nothing can follow it, and smaller ones are what numbers make of a path."""
MOST_POINTS = 20_000
"""Points after which no closer look is taken: a path that is detail everywhere is not looked at for ever."""


class LimitsAlong(NamedTuple):
    """What the limits allow at places along a run, at the worse side of a break."""

    s: Floats
    steady: Floats
    """(n,) z = (ds/dt)^2 at steady speed."""
    third: Floats
    """(n,) d3s/dt3 at rest."""


def detail(run: AxisRun, limits: Limits, s: Floats) -> Floats:
    """(k,) points between those of the grid s (n,), which holds the breaks, where the path needs a closer look."""
    return closer_look(run, limits, s)[1].s


def closer_look(run: AxisRun, limits: Limits, s: Floats) -> tuple[LimitsAlong, LimitsAlong]:
    """What there is at the grid s (n,), which holds the breaks, and at points between where that does not tell enough.

    The grid is halved where the path does not go on as its derivatives say: something happens between two points if
    position, slope or curvature changes by another amount than the next derivative at both points tells. A cusp shows
    like this in any grid, however sharp it is.
    """
    q, cap = run.with_cap(s)
    steady, third = allowed(limits, q, cap)
    low, high, of_low, of_high, slow = s[:-1], s[1:], q[:, :-1], q[:, 1:], np.minimum(steady[:-1], steady[1:])
    at = np.flatnonzero(np.isin(s[1:], run.breaks)) if len(run.breaks) else np.empty(0, dtype=np.int64)
    if len(at):
        before = np.nextafter(s[1 + at], -np.inf)
        of_high = of_high.copy()
        of_high[:, at], cap_before = run.with_cap(before)
        steady_before, third_before = allowed(limits, of_high[:, at], cap_before)
        steady[1 + at] = np.minimum(steady[1 + at], steady_before)
        third[1 + at] = np.minimum(third[1 + at], third_before)
    grid = LimitsAlong(s, steady, third)
    shortest = max(FINEST * (run.s1 - run.s0), 4.0 * float(np.spacing(max(abs(run.s0), abs(run.s1)))))
    # what is shorter than the steps of the grid by far shows in its increments only
    narrow, way = search_narrow_features(
        run, limits, Gaps(low, high, np.ascontiguousarray(of_low), np.ascontiguousarray(of_high), slow), shortest
    )
    found = [(way, *allowed(limits, *run.with_cap(way)))] if len(way) else []
    count = 0
    for level in itertools.count(1):
        ends = (np.ascontiguousarray(of_low), np.ascontiguousarray(of_high))
        unseen = first_guess.unseen(*ends, high - low, slow, limits.velocity, limits.acceleration, limits.jerk)
        shows = unseen > UNSEEN
        marked = shows & (high - low > 2.0 * shortest)
        stuck = shows & ~marked & (level > SETTLED)
        if stuck.any():
            refuse_jumps(limits, low[stuck], of_low[:, stuck], of_high[:, stuck], np.sqrt(slow[stuck]))
        if level == SETTLED + 1 and len(narrow.low):
            # so short, they are looked at like what is left of the others now
            low, high, slow = (
                np.concatenate(pair) for pair in zip((low, high, slow), (narrow.low, narrow.high, narrow.slow))
            )
            of_low = np.concatenate([of_low, narrow.of_low], axis=1)
            of_high = np.concatenate([of_high, narrow.of_high], axis=1)
            marked = np.concatenate([marked, narrow.high - narrow.low > 2.0 * shortest])
        count += int(marked.sum())
        if (not marked.any() and (level > SETTLED or not len(narrow.low))) or count > MOST_POINTS:
            break
        low, high, slow = low[marked], high[marked], slow[marked]
        of_low, of_high = of_low[:, marked], of_high[:, marked]
        middle = (low + high) / 2.0
        of_middle, cap = run.with_cap(middle)
        steady, third = allowed(limits, of_middle, cap)
        if level > SETTLED:
            found.append((middle, steady, third))
        low, high = np.concatenate([low, middle]), np.concatenate([middle, high])
        of_low, of_high = np.concatenate([of_low, of_middle], axis=1), np.concatenate([of_middle, of_high], axis=1)
        slow = np.minimum(np.tile(slow, 2), np.tile(steady, 2))
    if not found:
        return grid, LimitsAlong(np.empty(0), np.empty(0), np.empty(0))
    between = np.concatenate(found, axis=1)
    return grid, LimitsAlong(*between[:, np.argsort(between[0])])


def refuse_jumps(limits: Limits, s: Floats, of_low: Floats, of_high: Floats, speed: Floats) -> None:
    """Raise PathError where position, slope or curvature jump at s (n,), by the path (4, n, m) on both sides.

    What counts is the jump of a joint's position, velocity or acceleration at the speeds (n,) that the limits allow.
    """
    powers = speed ** np.arange(3.0)[:, None]
    jump = np.abs(of_high[:3] - of_low[:3]) * powers[:, :, None]
    gained = gained_in_a_ramp(limits)
    share = jump / np.maximum(gained, 1e-300)[:, None, :]
    share[:, :, (gained == 0.0).any(axis=0)] = 0.0
    if share.max() > JUMP:
        kind, at, joint = np.unravel_index(int(share.argmax()), share.shape)
        what = ("position", "slope", "curvature")[int(kind)]
        raise PathError(
            f"path: the {what} of {limits.joints[int(joint)]} jumps at s = {s[int(at)]:.12g}, and no motion of bounded"
            " jerk follows it; make it smooth there, or end a run there"
        )


def allowed(limits: Limits, q: Floats, cap: Floats) -> tuple[Floats, Floats]:
    """(n,) z at steady speed and (n,) d3s/dt3 at rest that the limits allow, from path (4, n, m) and cap (n,) there."""
    whole = np.ascontiguousarray(q)
    _, steady, third = first_guess.pointwise(whole, limits.velocity, limits.acceleration, limits.jerk, cap)
    return steady, third
