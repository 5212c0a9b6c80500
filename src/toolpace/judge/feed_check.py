"""The feed and block of each set-point, from the program places where it can be."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
import numpy.typing as npt

from toolpace.common.arrays import Floats, Ints
from toolpace.common.value_objects import counted
from toolpace.judge.alignment import Alignment
from toolpace.judge.alignment.sections import Section
from toolpace.judge.motion import TOLERANCE
from toolpace.judge.rows import MotionRow
from toolpace.judge.verification import Check
from toolpace.programs.toolpath import ToolPath

Number = TypeVar("Number", np.float64, np.int64)


@dataclass(frozen=True)
class FeedUse:
    """The speed of the tip over the feeds of the blocks that it can be in."""

    ratio: Floats
    """(steps,) mean speed over the largest feed that may hold, at least; none where the figures of a plan are not
    judged by it."""
    least: float
    """The largest of all: the feed is used to this share at least."""
    worst: Check
    """The step where it is so."""
    most: float
    """Highest speed over the least feed that may hold, with what may hide between set-points."""

    @classmethod
    def of(cls, section: Section, toolpath: ToolPath, owner: Ints, farthest: float, figures: bool) -> FeedUse:
        """That of a section, whose poses of the program belong to the points `owner` (m,); `farthest` [m] is the
        largest coordinate of the tip without sign."""
        speed, steps = section.steps.speed, np.diff(section.steps.t)
        noise = 8.0 * float(np.finfo(np.float64).eps) * max(farthest, 1.0) / steps
        cap = _largest(toolpath.feed, section.motion, section.found.there, owner)
        with np.errstate(divide="ignore"):
            slowest = _largest(1.0 / toolpath.feed, section.motion, section.found.there, owner)
        # Within a step the speed changes by no more than half of what it does to the next.
        change = np.abs(np.diff(speed))
        change, speed = np.maximum(change[:-1], change[1:]), speed[1:-1]
        moving = np.isfinite(slowest)
        most = float(((speed + change)[moving] * slowest[moving]).max(initial=0.0))
        ratio = np.where(np.isfinite(cap), (speed - noise) / cap, 0.0)
        k = int(np.argmax(ratio))
        time, block = float(section.steps.t[k]), int(section.steps.block[k + 1])
        ok = bool(ratio[k] <= 1.0 + TOLERANCE)
        worst = Check("feed", float(speed[k]), float(cap[k]), "m/s", ok, time, block, noise=float(noise[k]))
        return cls(ratio if figures else np.empty(0), max(float(ratio[k]), 0.0), worst, most)

    @classmethod
    def of_all(cls, parts: Sequence[FeedUse], untold: int) -> FeedUse:
        """That of all sections, where the lower feeds of so many blocks are not told: see `untold_feeds`."""
        first = max(parts, key=lambda part: part.least)
        note = f"not told of {counted(untold, 'block')} within the tolerance of a faster one" * (untold > 0)
        most = max(part.most for part in parts)
        return cls(np.concatenate([part.ratio for part in parts]), first.least, replace(first.worst, note=note), most)


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


@dataclass(frozen=True)
class WrongBlocks:
    """Set-points that name a block that they cannot be in."""

    count: int
    time: float
    """When the first of them comes [s]."""
    said: int
    right: int
    """Which block it names, and in which it is."""

    @classmethod
    def of(cls, section: Section, toolpath: ToolPath, owner: Ints) -> WrongBlocks:
        """Those of a section, whose poses of the program belong to the points `owner` (m,)."""
        from toolpace.kernels.judge.matching import named

        there, row = section.found.there, section.motion.row
        row = row[: section.own(len(row))]
        said = section.steps.block[: len(row)]
        start, block = _stretches(owner, toolpath.block)
        found = np.zeros(len(row), dtype=bool)
        named(*_of_setpoints(there, row), start, block, said, found)
        k = int(np.argmin(found))
        right = int(toolpath.block[owner[min(int(there.place[row[k]]) + 1, len(owner) - 1)]])
        return cls(len(found) - int(found.sum()), float(section.steps.t[k]), int(said[k]), right)

    @staticmethod
    def check(parts: Sequence[WrongBlocks]) -> Check:
        """Whether the block of each set-point is one of those that it can be in, in all sections."""
        wrong = sum(part.count for part in parts)
        if not wrong:
            return Check("block column", 0.0, 0.0, "", True, note="every set-point is in its block")
        first = next(part for part in parts if part.count)
        note = (
            f"{wrong} set-points name a block that they are not in; "
            f"the first says {first.said}, it is in {first.right}"
        )
        return Check("block column", float(wrong), 0.0, "", False, first.time, first.right, note=note)


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
