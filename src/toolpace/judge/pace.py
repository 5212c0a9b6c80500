"""The feed and the block of each set-point, by the places of the program at which it can be."""

from __future__ import annotations

import numpy as np

from toolpace.arrays import Floats, Ints
from toolpace.judge.alignment import Alignment
from toolpace.judge.motion import TOLERANCE
from toolpace.judge.rows import MotionRow
from toolpace.judge.verification import Check
from toolpace.setpoints import SetPoints
from toolpace.toolpath import ToolPath


def feed_check(
    points: SetPoints, toolpath: ToolPath, motion: MotionRow, there: Alignment, owner: Ints, tip: Floats
) -> list[Check]:
    """The speed of the tip against the largest feed of the blocks that it can be in, in order."""
    ratio = feed_ratio(points, toolpath, motion, there, owner, tip)
    if ratio is None:
        return []
    speed, cap, noise = ratio
    over = np.where(np.isfinite(cap), (speed - noise) / cap, 0.0)
    k = int(np.argmax(over))
    ok = bool(over[k] <= 1.0 + TOLERANCE)
    time, block = float(points.t[k]), int(points.block[k + 1])
    return [Check("feed", float(speed[k]), float(cap[k]), "m/s", ok, time, block, noise=float(noise[k]))]


def feed_ratio(
    points: SetPoints, toolpath: ToolPath, motion: MotionRow, there: Alignment, owner: Ints, tip: Floats
) -> tuple[Floats, Floats, Floats] | None:
    """Speed, largest feed and rounding noise of each step (n - 1,) [m/s]; None where the program has no feed."""
    from toolpace.kernels.judge.matching import largest_between

    if not np.isfinite(toolpath.feed[1:]).any():
        return None
    start, feed = _stretches(owner, toolpath.feed)
    of_row = np.empty(len(motion.poses) - 1)
    largest_between(there.begin, there.low, there.high, start, feed, of_row)
    moved = np.sqrt(((tip[1:] - tip[:-1]) ** 2).sum(axis=1))
    steps = np.diff(points.t)
    # A step of set-points is one or more of the row, or none where they stand still.
    first, last = motion.row[:-1], motion.row[1:]
    cap = np.full(len(steps), np.inf)
    going = np.flatnonzero(last > first)
    if len(going):
        cap[going] = np.maximum.reduceat(of_row, first[going])
    noise = 8.0 * float(np.finfo(np.float64).eps) * max(float(np.abs(tip).max()), 1.0) / steps
    return moved / steps, cap, noise


def block_check(
    points: SetPoints, toolpath: ToolPath, motion: MotionRow, there: Alignment, owner: Ints
) -> list[Check]:
    """Whether the block of each set-point is one of those that it can be in."""
    from toolpace.kernels.judge.matching import named

    start, block = _stretches(owner, toolpath.block)
    found = np.zeros(len(points), dtype=bool)
    row = motion.row
    begin, low, high = _of_setpoints(there, row)
    named(begin, low, high, start, block, points.block.copy(), found)
    wrong = int(len(found) - found.sum())
    if not wrong:
        return [Check("block column", 0.0, 0.0, "", True, note="every set-point is in its block")]
    k = int(np.argmin(found))
    place = int(there.place[row[k]])
    right = int(toolpath.block[owner[min(place + 1, len(owner) - 1)]])
    note = f"{wrong} set-points name a block that they are not in; the first one says {points.block[k]}, it is in {right}"
    return [Check("block column", float(wrong), 0.0, "", False, float(points.t[k]), right, note=note)]


def _of_setpoints(there: Alignment, row: Ints) -> tuple[Ints, Floats, Floats]:
    """The places of each set-point: those of the row that are set-points, one after the other."""
    count = there.begin[row + 1] - there.begin[row]
    begin = np.concatenate(([0], np.cumsum(count)))
    at = np.arange(begin[-1]) - np.repeat(begin[:-1], count) + np.repeat(there.begin[row], count)
    return begin, there.low[at], there.high[at]


def _stretches(owner: Ints, value: Floats | Ints) -> tuple[Floats, Floats | Ints]:
    """Places where stretches of the line with one value begin (r + 1,), and the values (r,).

    value[i] holds on the way to program point i.
    """
    of_way = value[owner[1:]]
    first = np.flatnonzero(np.concatenate(([True], of_way[1:] != of_way[:-1])))
    return np.concatenate((first, [len(of_way)])).astype(np.float64), of_way[first]
