"""Places of a path that need a finer mesh: cusps, poles, and features narrower than the grid.

A bend, a kink or a jump between two places changes position, slope or curvature by more than the derivatives at both
explain, however short it is (kernels/motion/between_nodes.py). The gap is halved, the half kept from which that is
still missing, until it is as short as what happens in it.
"""

from __future__ import annotations

import itertools
from typing import NamedTuple

import numpy as np

from toolpace.common.arrays import Bools, Floats, Ints
from toolpace.common.errors import PathError
from toolpace.kernels.motion import between_nodes
from toolpace.kernels.optimal import first_guess
from toolpace.machine.limits import Limits
from toolpace.motion import gained_in_a_ramp, least_changes
from toolpace.path.axis_run import AxisRun

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
MOST_CHASED = 2_000
"""Gaps after which no more are chased: a path that is noise everywhere is not chased for ever."""


class LimitsAlong(NamedTuple):
    """What the limits allow at places along a run, at the worse side of a break."""

    s: Floats
    steady: Floats
    """(n,) z = (ds/dt)^2 at steady speed."""
    third: Floats
    """(n,) d3s/dt3 at rest."""


class Gaps(NamedTuple):
    """Pairs of places next to each other, and the path there."""

    low: Floats
    high: Floats
    of_low: Floats
    """(4, n, joints)"""
    of_high: Floats
    slow: Floats
    """(n,) z that limits allow at both at steady speed."""

    def take(self, which: Ints | Bools) -> Gaps:
        """Some of them."""
        return Gaps(
            self.low[which], self.high[which], np.ascontiguousarray(self.of_low[:, which]),
            np.ascontiguousarray(self.of_high[:, which]), self.slow[which],
        )  # fmt: skip

    def missing(self, limits: Limits) -> Floats:
        """(n, 3, joints) changes of position, slope and curvature that both ends do not tell."""
        length, speed = self.high - self.low, np.sqrt(self.slow)
        return between_nodes.increment_errors(self.of_low, self.of_high, self.low, length, speed, least_changes(limits))


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
    for rows in limits.rows:
        of_rows, third_of_rows = rows.steady(whole)
        steady, third = np.minimum(steady, of_rows), np.minimum(third, third_of_rows)
    return steady, third


def search_narrow_features(run: AxisRun, limits: Limits, gaps: Gaps, shortest: float) -> tuple[Gaps, Floats]:
    """What hides in the gaps of a grid: gaps as short as it is, and (k,) the places that led there.

    `shortest`: length of a gap that numbers do not resolve [of s].
    """
    missed = gaps.missing(limits)
    which = np.flatnonzero(between_nodes.outliers(missed, gaps.high - gaps.low))[:MOST_CHASED]
    now, missed = gaps.take(which), missed[which]
    found: list[Gaps] = []
    way: list[tuple[Ints, Floats]] = []
    chain, caught = np.arange(len(which)), np.zeros(len(which), dtype=np.bool_)
    number = 0
    while len(now.low):
        number += 1
        middle = (now.low + now.high) / 2.0
        of_middle = run.evaluate(middle)
        left = Gaps(now.low, middle, now.of_low, np.ascontiguousarray(of_middle), now.slow)
        right = Gaps(middle, now.high, left.of_high, now.of_high, now.slow)
        missed_left, missed_right = left.missing(limits), right.missing(limits)
        stays, is_right = between_nodes.worse_half(missed, missed_left, missed_right)
        way.append((chain, middle))
        pick = is_right[:, None, None]
        half = Gaps(
            np.where(is_right, middle, now.low), np.where(is_right, now.high, middle),
            np.where(is_right[:, None], right.of_low, left.of_low),
            np.where(is_right[:, None], now.of_high, left.of_high),
            now.slow,
        )  # fmt: skip
        missed = np.where(pick, missed_right, missed_left)
        length = half.high - half.low
        speed = np.sqrt(half.slow)
        of_joints = (limits.velocity, limits.acceleration, limits.jerk)
        utilised = between_nodes.error_utilisation(missed, length, speed, *of_joints)
        seen = stays & (utilised > UNSEEN) & (number > SETTLED)
        if seen.any():
            caught[chain[seen]] = True
            found.append(half.take(seen))
        go = stays & ~seen & (length > 2.0 * shortest)
        now, missed, chain = half.take(go), missed[go], chain[go]
    if not found:
        return gaps.take(np.empty(0, dtype=np.int64)), np.empty(0)
    places = np.concatenate([middle[caught[of]] for of, middle in way])
    return Gaps(*(np.concatenate(part, axis=1 if part[0].ndim == 3 else 0) for part in zip(*found))), places
