"""The search for path features narrower than the grid, from the path's increments.

A bend, a kink or a jump between two places changes position, slope or curvature by more than the derivatives at both
tell, however short it is (kernels/motion/narrow_features.py). The gap is halved, the half kept from which that is
still missing, until it is as short as what happens in it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from toolpace.common.arrays import Bools, Floats, Ints
from toolpace.kernels.motion import narrow_features
from toolpace.machine.limits import Limits
from toolpace.motion import least_changes
from toolpace.path.axis_run import AxisRun

SEEN = 0.02
"""Share of a limit, at the speed that is allowed beside it, at which something is seen for what it is."""
MOST_HALVINGS = 60
FEWEST_HALVINGS = 4
"""Halvings before something counts as hidden: where a grid is a little coarse, fewer do."""
MOST_CHASED = 2_000
"""Gaps after which no more are chased: a path that is noise everywhere is not chased for ever."""


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
        return narrow_features.missing(self.of_low, self.of_high, self.low, length, speed, least_changes(limits))


def search_narrow_features(run: AxisRun, limits: Limits, gaps: Gaps, shortest: float) -> tuple[Gaps, Floats]:
    """What hides in the gaps of a grid: gaps as short as it is, and (k,) the places that led there.

    `shortest`: length of a gap that numbers do not resolve [of s].
    """
    missed = gaps.missing(limits)
    which = np.flatnonzero(narrow_features.odd_ones(missed, gaps.high - gaps.low))[:MOST_CHASED]
    now, missed = gaps.take(which), missed[which]
    found: list[Gaps] = []
    way: list[tuple[Ints, Floats]] = []
    chain, caught = np.arange(len(which)), np.zeros(len(which), dtype=np.bool_)
    for number in range(1, MOST_HALVINGS + 1):
        if len(now.low) == 0:
            break
        middle = (now.low + now.high) / 2.0
        of_middle = run.evaluate(middle)
        left = Gaps(now.low, middle, now.of_low, np.ascontiguousarray(of_middle), now.slow)
        right = Gaps(middle, now.high, left.of_high, now.of_high, now.slow)
        missed_left, missed_right = left.missing(limits), right.missing(limits)
        stays, is_right = narrow_features.worse_half(missed, missed_left, missed_right)
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
        seen = stays & (
            narrow_features.asked(missed, length, speed, limits.velocity, limits.acceleration, limits.jerk) > SEEN
        ) & (number >= FEWEST_HALVINGS)  # fmt: skip
        if seen.any():
            caught[chain[seen]] = True
            found.append(half.take(seen))
        go = stays & ~seen & (length > 2.0 * shortest)
        now, missed, chain = half.take(go), missed[go], chain[go]
    if not found:
        return gaps.take(np.empty(0, dtype=np.int64)), np.empty(0)
    places = np.concatenate([middle[caught[of]] for of, middle in way])
    return Gaps(*(np.concatenate(part, axis=1 if part[0].ndim == 3 else 0) for part in zip(*found))), places
