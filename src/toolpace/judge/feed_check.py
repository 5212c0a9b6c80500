"""The feed and block of each set-point, from the program places where it can be."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeVar

import numpy as np
import numpy.typing as npt

from toolpace.common.arrays import Floats, Ints
from toolpace.common.value_objects import counted
from toolpace.judge.alignment import Alignment
from toolpace.judge.motion import TOLERANCE
from toolpace.judge.rows import MotionRow
from toolpace.judge.seen_motion import SeenMotion
from toolpace.judge.verification import Check
from toolpace.programs.toolpath import ToolPath

Number = TypeVar("Number", np.float64, np.int64)


@dataclass(frozen=True)
class FeedUse:
    """The speed of the tip over the feeds of the blocks that it can be in."""

    speed: Floats
    """(n - 1,) mean speed of each step [m/s]."""
    cap: Floats
    """(n - 1,) largest feed that may hold [m/s]."""
    noise: Floats
    """(n - 1,) rounding of the speed [m/s]."""
    most: float
    """Highest speed over the least feed that may hold, with what may hide between set-points."""
    untold: int = 0
    """Blocks whose lower feed is not told from those beside them: see `untold_feeds`."""

    @property
    def ratio(self) -> Floats:
        """(n - 1,) speed over the largest feed, at least."""
        found: Floats = np.where(np.isfinite(self.cap), (self.speed - self.noise) / self.cap, 0.0)
        return found

    @property
    def least(self) -> float:
        """The largest of them: the feed is used to this share at least."""
        return float(self.ratio.max(initial=0.0))

    def check(self, seen: SeenMotion) -> Check:
        """The speed of the tip against the largest feed of the blocks that it can be in, in order."""
        over = self.ratio
        k = int(np.argmax(over))
        ok = bool(over[k] <= 1.0 + TOLERANCE)
        time, block = float(seen.t[k]), int(seen.block[k + 1])
        speed, cap = float(self.speed[k]), float(self.cap[k])
        note = f"not told of {counted(self.untold, 'block')} within the tolerance of a faster one" * (self.untold > 0)
        return Check("feed", speed, cap, "m/s", ok, time, block, note=note, noise=float(self.noise[k]))


def feed_use(
    seen: SeenMotion, toolpath: ToolPath, motion: MotionRow, there: Alignment, owner: Ints, tolerances: Floats
) -> FeedUse | None:
    """How fast the tip goes for the feeds of the program; None where it has none. `tolerances` (p, 2) of tip [m] and
    axis [rad] on the way to each of its points."""
    if not np.isfinite(toolpath.feed[1:]).any():
        return None
    assert seen.tool is not None
    steps = np.diff(seen.t)
    speed = seen.tool.lengths / steps
    noise = 8.0 * float(np.finfo(np.float64).eps) * max(seen.tool.farthest, 1.0) / steps
    cap = _largest(toolpath.feed, motion, there, owner)
    with np.errstate(divide="ignore"):
        slowest = _largest(1.0 / toolpath.feed, motion, there, owner)
    # Within a step the speed changes by no more than half of what it does to the next.
    change = np.abs(np.diff(speed, prepend=speed[0]))
    change = np.maximum(change, np.append(change[1:], 0.0))
    moving = np.isfinite(slowest)
    most = float(((speed + change)[moving] * slowest[moving]).max(initial=0.0))
    return FeedUse(speed, cap, noise, most, untold_feeds(toolpath, tolerances))


def untold_feeds(toolpath: ToolPath, tolerances: Floats) -> int:
    """Blocks slower than one beside them that are within twice the tolerances (n, 2) of tip [m] and axis [rad].

    All of such a block is near the end of another: a tip that keeps the tolerance may be in that one. One longer by two
    steps of set-points holds a step that can be nowhere else. Blocks of one feed that follow each other count as one.
    """
    feed = toolpath.feed[1:]
    first = np.flatnonzero(np.concatenate(([True], feed[1:] != feed[:-1])))
    of_stretch = feed[first]
    beside = np.maximum(np.append(of_stretch[1:], 0.0), np.insert(of_stretch[:-1], 0, 0.0))
    short = of_stretch < beside
    for row, tolerance in zip((toolpath.tip, toolpath.axis), tolerances.T):
        ways = np.linalg.norm(np.diff(row, axis=0), axis=1)
        short &= np.add.reduceat(ways, first) <= 2.0 * np.maximum.reduceat(tolerance[1:], first)
    return int(short.sum())


def _largest(value: Floats, motion: MotionRow, there: Alignment, owner: Ints) -> Floats:
    """(n - 1,) largest value of the blocks that each step of set-points can be in; infinite where it stands still."""
    from toolpace.kernels.judge.matching import largest_between

    start, of_stretch = _stretches(owner, value)
    of_row = np.empty(len(motion.poses) - 1)
    largest_between(there.begin, there.low, there.high, start, of_stretch, of_row)
    # A step of set-points is one or more of the row, or none where they stand still.
    first, last = motion.row[:-1], motion.row[1:]
    found = np.full(len(first), np.inf)
    going = np.flatnonzero(last > first)
    if len(going):
        found[going] = np.maximum.reduceat(of_row, first[going])
    return found


def block_check(seen: SeenMotion, toolpath: ToolPath, motion: MotionRow, there: Alignment, owner: Ints) -> list[Check]:
    """Whether the block of each set-point is one of those that it can be in."""
    from toolpace.kernels.judge.matching import named

    start, block = _stretches(owner, toolpath.block)
    found = np.zeros(len(seen.block), dtype=bool)
    row = motion.row
    begin, low, high = _of_setpoints(there, row)
    named(begin, low, high, start, block, seen.block, found)
    wrong = int(len(found) - found.sum())
    if not wrong:
        return [Check("block column", 0.0, 0.0, "", True, note="every set-point is in its block")]
    k = int(np.argmin(found))
    place = int(there.place[row[k]])
    right = int(toolpath.block[owner[min(place + 1, len(owner) - 1)]])
    note = f"{wrong} set-points name a block that they are not in; the first says {seen.block[k]}, it is in {right}"
    return [Check("block column", float(wrong), 0.0, "", False, float(seen.t[k]), right, note=note)]


def _of_setpoints(there: Alignment, row: Ints) -> tuple[Ints, Floats, Floats]:
    """The places of each set-point: those of the row that are set-points, one after the other."""
    count = there.begin[row + 1] - there.begin[row]
    begin = np.concatenate(([0], np.cumsum(count)))
    at = np.arange(begin[-1]) - np.repeat(begin[:-1], count) + np.repeat(there.begin[row], count)
    return begin, there.low[at], there.high[at]


def _stretches(owner: Ints, value: npt.NDArray[Number]) -> tuple[Floats, npt.NDArray[Number]]:
    """Places where stretches of the line with one value begin (r + 1,), and the values (r,).

    value[i] holds on the way to program point i.
    """
    of_way = value[owner[1:]]
    first = np.flatnonzero(np.concatenate(([True], of_way[1:] != of_way[:-1])))
    return np.concatenate((first, [len(of_way)])).astype(np.float64), of_way[first]
