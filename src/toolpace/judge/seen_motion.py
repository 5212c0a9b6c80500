"""What the judge keeps of a motion that it sees block by block: peaks, places, and some numbers of each set-point.

A block stays in the cache of a core, and all cores work.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import NamedTuple, TypeVar

import numpy as np

from toolpace.common.arrays import Bools, Floats, Ints
from toolpace.machine.limits import Limits
from toolpace.motion.setpoints import Block, SetPoints, SetPointSource

R = TypeVar("R")

ROWS = 1 << 13
"""Rows of a block: ten columns of them take less than a megabyte."""
WINDOW = 256
"""Steps over which the column of jerks is compared with the accelerations; a block holds whole windows."""
AROUND = 2
"""Steps before and behind a window whose change of the mean jerk may belong to it."""
SAG = 12.0
"""By how much a jerk that swings within a step may stray from its mean at the ends, for each unit by which the mean
acceleration is off that of both ends, a step: 6 for a triangle of the length of a step, 2 pi for a sine."""
SPREADS = 4.0
"""Standard deviations by which more swings may be met by set-points than are expected."""
ROUNDING = 1e-9
"""More than the positions of any machine are rounded by [m or rad]."""
ORDERS = (1, 2, 3)
"""Of differences: velocity, acceleration and jerk."""
EPS = float(np.finfo(np.float64).eps)
"""Relative distance from 1 to the next number: rounding is at most half of it."""


def each_block(work: Callable[[int, int], R], count: int) -> list[R]:
    """What `work(begin, end)` makes of each block of `count` rows, in order; one empty block where there are none.

    Blocks are worked on at the same time, so `work` may write only to rows of its own.
    """
    begins = range(0, max(count, 1), ROWS)
    if len(begins) == 1:
        return [work(0, count)]
    with ThreadPoolExecutor(min(os.cpu_count() or 1, len(begins))) as threads:
        futures = [threads.submit(work, begin, min(begin + ROWS, count)) for begin in begins]
        try:
            return [future.result() for future in futures]
        finally:
            threads.shutdown(cancel_futures=True)


class Largest(NamedTuple):
    """The largest value in each column, and the first row that has it."""

    value: Floats
    """(m,)"""
    row: Ints
    """(m,)"""

    @classmethod
    def of(cls, columns: Floats, begin: int) -> Largest:
        """That of columns (m, k) of the rows from `begin` on; 0 where there are none."""
        if not columns.shape[1]:
            return cls(np.zeros(len(columns)), np.full(len(columns), begin))
        row = columns.argmax(axis=1)
        return cls(columns[np.arange(len(columns)), row], begin + row)

    @classmethod
    def of_all(cls, parts: Sequence[Largest]) -> Largest:
        """That of all blocks, from that of each."""
        values = np.stack([part.value for part in parts])
        block, column = values.argmax(axis=0), np.arange(values.shape[1])
        return cls(values[block, column], np.stack([part.row for part in parts])[block, column])


class BlockPeaks(NamedTuple):
    """The largest values of each joint in one block, without sign."""

    time: float
    """[s]"""
    position: Floats
    """(m,)"""
    columns: list[Largest]
    differences: list[Largest]
    mean_jerk: Floats
    """(m,)"""

    @classmethod
    def of(cls, block: Block, begin: int, end: int, even: int) -> BlockPeaks:
        """Those of some rows of a motion whose first `even` set-points come at equal steps."""
        n = block.of_all
        q = block.columns("q", begin, min(end + ORDERS[-1], n))
        columns = [Largest.of(np.abs(block.columns(name, begin, end)), begin) for name in ("qd", "qdd", "qddd")]
        differences, difference = [], q[:, : max(even - begin, 0)]
        for order in ORDERS:
            difference = np.diff(difference, axis=1)
            of_rows = difference[:, : max(min(end, even - order) - begin, 0)]
            differences.append(Largest.of(np.abs(of_rows), begin))
        change = np.diff(block.columns("qdd", begin, min(end + 1, n)), axis=1)
        mean = np.abs(change / np.diff(block.times(begin, min(end + 1, n)))).max(axis=1, initial=0.0)
        time = float(np.abs(block.times(begin, end)).max())
        return cls(time, np.abs(q).max(axis=1), columns, differences, mean)


@dataclass(frozen=True)
class Peaks:
    """The largest values of each joint, without sign."""

    dt: float
    """Time step [s]."""
    time: float
    """[s]"""
    position: Floats
    """(m,)"""
    columns: tuple[Largest, ...]
    """Of the velocities, accelerations and jerks that the set-points tell."""
    differences: tuple[Largest, ...]
    """First to third difference of positions over dt ** order, and the set-point in its middle."""
    mean_jerk: Floats
    """(m,) change of the accelerations over a step, by its time."""

    @classmethod
    def of_all(cls, parts: Sequence[BlockPeaks], count: int, even: int, ending: SetPoints, dt: float) -> Peaks:
        """Those of all blocks of a motion of so many set-points every `dt` [s]; all but the `even` first, or none, come
        sooner. `ending` is its last ones."""
        times, position, columns, differences, mean = zip(*parts)
        largest_position = np.max(position, axis=0)
        found = []
        for order, of_blocks in zip(ORDERS, zip(*differences)):
            value, row = Largest.of_all(of_blocks)
            value, row = value / dt**order, row + order // 2 if even > order else np.zeros_like(row)
            # a shorter last step by divided differences
            last = np.array([
                last_difference(q, ending.t, order, dt, float(most)) for q, most in zip(ending.q.T, largest_position)
            ])  # fmt: skip
            found.append(Largest(np.maximum(value, last), np.where(last > value, count - 1, row)))
        return cls(
            dt, max(times), largest_position, tuple(Largest.of_all(each) for each in zip(*columns)),
            tuple(found), np.max(mean, axis=0),
        )  # fmt: skip

    def difference(self, order: int, joint: int) -> tuple[float, int]:
        """Largest |difference| / dt^order of a joint, and the set-point in its middle."""
        found = self.differences[order - 1]
        return float(found.value[joint]), int(found.row[joint])


def even_rows(source: SetPointSource, dt: float) -> int:
    """How many set-points come at equal steps: all but the last one where it comes sooner."""
    return len(source) - ends_sooner(source.times(np.arange(max(len(source) - 2, 0), len(source))), dt)


def ends_sooner(t: Floats, dt: float) -> bool:
    """Whether the last of times (n,) comes sooner than a step."""
    return bool(len(t) > 1 and t[-1] - t[-2] < 0.999 * dt)


def last_difference(q: Floats, t: Floats, order: int, dt: float, largest: float) -> float:
    """|Difference| / dt^order of positions (n,) over a last step that is shorter, by divided differences; 0 where it is
    not. `largest` is that of the positions without sign."""
    n = len(q)
    if n <= order or not ends_sooner(t, dt):
        return 0.0
    # The span, not the short step, is what a divided difference of order k is divided by last.
    times, table = t[n - 1 - order :], q[n - 1 - order :]
    for k in range(1, order + 1):
        table = np.diff(table) / (times[k:] - times[:-k])
    shortest = max(float(t[-1] - t[-2]) / dt, 1e-9)
    rounding = 2.0**order * 8.0 * EPS * max(largest, 1.0) / (dt**order * shortest)
    return abs(float(table[0])) * math.factorial(order) - rounding


def difference_beyond_rounding(
    q: Floats, t: Floats, order: int, dt: float, rounding: Floats
) -> tuple[float, int]:
    """Largest |difference| / dt^order of positions (n,), less what a `rounding` (n,) of these may make of it, and the
    set-point in its middle."""
    value, at = 0.0, 0
    even = np.abs(np.diff(q[: len(q) - ends_sooner(t, dt)], n=order))
    if len(even):
        most = rounding[: len(even)]
        for k in range(1, order + 1):
            most = np.maximum(most, rounding[k : k + len(even)])
        even = np.maximum(even - 2.0**order * most, 0.0)
        k = int(np.argmax(even))
        value, at = float(even[k]) / dt**order, k + order // 2
    last = last_difference(q, t, order, dt, float(np.abs(q).max()))
    return (last, len(q) - 1) if last > value else (value, at)


def largest_misfits(block: Block, begin: int, end: int, jumpy: Bools) -> tuple[Largest, Largest]:
    """By how much a step of positions is off the mean of the velocities at its ends, of velocities off that of the
    accelerations, at most in the steps from `begin` to `end`; of `jumpy` joints (m,) less what a jump of the velocity
    may make of it."""
    last = block.of_all - 1
    steps = np.diff(block.times(begin, end + 1))
    q, qd, qdd = (block.columns(name, begin, end + 1) for name in ("q", "qd", "qdd"))
    of_q, of_qd = (
        np.abs(np.diff(below, axis=1) - 0.5 * steps * (above[:, 1:] + above[:, :-1]))
        for below, above in ((q, qd), (qd, qdd))
    )
    if jumpy.any():
        before, behind = max(begin - 1, 0), min(end + 1, last)
        around = block.columns("q", before, behind + 1)[jumpy]
        mean = np.diff(around, axis=1) / np.diff(block.times(before, behind + 1))
        # the joint rests before and behind the motion
        mean = np.pad(mean, ((0, 0), (int(begin == 0), int(end == last))))
        change = np.abs(np.diff(mean, axis=1))
        of_q[jumpy] -= steps * (change[:, :-1] + change[:, 1:])
    return Largest.of(of_q, begin), Largest.of(of_qd, begin)


class JerkWindows(NamedTuple):
    """Of windows of WINDOW steps, how far the column of jerks is off the change of the accelerations, and what explains
    it; of the joints (k,) whose accelerations do not jump."""

    off: Floats
    """(k, windows) sum over the steps."""
    around: Floats
    """(k, windows) change of the mean jerk in the window and about it."""
    peak: Floats
    """(k, windows) largest jerk of the column."""
    hidden: Floats
    """(k, windows) what swings within the steps make of it."""
    rate: Floats
    """(windows,) sum of 1 / step [1/s]."""
    steps: Ints
    """(windows,)"""

    @classmethod
    def of(cls, block: Block, begin: int, end: int, judged: Ints) -> JerkWindows:
        """Those of the steps from `begin`, a multiple of WINDOW, to `end`."""
        last = block.of_all - 1
        # What changes just before and behind a window may belong to a step in it.
        before, behind = max(begin - AROUND - 1, 0), min(end + AROUND, last)
        steps = np.diff(block.times(before, behind + 1))
        mean = np.diff(block.columns("qdd", before, behind + 1)[judged], axis=1) / steps
        total = np.cumsum(np.abs(np.diff(mean, axis=1, prepend=mean[:, :1])), axis=1)
        total = np.concatenate((np.zeros((len(judged), 1)), total), axis=1)
        steps, mean = steps[begin - before : end - before], mean[:, begin - before : end - before]
        qd, qdd, qddd = (block.columns(name, begin, end + 1)[judged] for name in ("qd", "qdd", "qddd"))
        off = np.abs(mean - 0.5 * (qddd[:, 1:] + qddd[:, :-1]))
        between = np.diff(qd, axis=1) / steps - 0.5 * (qdd[:, 1:] + qdd[:, :-1])
        sag = np.abs(between) / steps
        starts = np.arange(0, end - begin, WINDOW)
        first = np.maximum(starts + begin - AROUND, 0) - before
        around = total[:, np.minimum(starts + begin + WINDOW + AROUND, last) - before] - total[:, first]
        peak = np.maximum.reduceat(np.maximum(np.abs(qddd[:, 1:]), np.abs(qddd[:, :-1])), starts, axis=1)
        swing, more = _hidden(sag, peak, starts)
        hidden = more + np.add.reduceat(np.maximum(SAG * sag, swing), starts, axis=1)
        off = np.add.reduceat(off, starts, axis=1)
        return cls(
            off, around, peak, hidden, np.add.reduceat(1.0 / steps, starts), np.diff(np.append(starts, end - begin))
        )

    @classmethod
    def of_all(cls, parts: Sequence[JerkWindows]) -> JerkWindows:
        """Those of all blocks."""
        return cls(*(np.concatenate(each, axis=-1) for each in zip(*parts)))


def _hidden(sag: Floats, peak: Floats, starts: Ints) -> tuple[Floats, Floats]:
    """By how much (m, steps) swings of the jerk that are over within a step let it stray from its mean, as expected,
    and (m, windows) how much more a window may happen to have.

    A jerk of J one way for a time T, and the other way for as long, is a change in velocity of J T^2 that no
    acceleration shows: the mean acceleration of the step is off by J T^2 / dt, its `sag` by dt. So the swing lasts
    2 T = 2 dt (sag / J)^(1/2), a set-point meets it in as large a share of the cases, and the column then is off by J:
    2 (J sag)^(1/2) as expected. How many of n are met has a variance of n at most. J is the `peak` of the window.
    """
    steps = np.diff(np.append(starts, sag.shape[1]))
    swing = 2.0 * np.sqrt(np.repeat(peak, steps, axis=1) * sag)
    return swing, SPREADS * np.sqrt(peak * np.add.reduceat(swing, starts, axis=1))


class BlockTool(NamedTuple):
    """What forward kinematics make of one block."""

    highest: Largest
    """Position of each joint."""
    lowest: Largest
    """The same with the other sign."""
    off: Largest
    """How far the columns of tip and axis are off; of no columns where there are none."""
    length_off: Largest
    """How far lengths of tools are off those of the program; of no columns where none are named."""
    farthest: float
    """Largest coordinate of the tip without sign [m]."""

    @classmethod
    def of(
        cls, block: Block, begin: int, end: int, tip: Floats, axis: Floats, first: int, tool_lengths: Floats
    ) -> BlockTool:
        """That of some rows, with tips and axes (k, 3) by the joints from row `first` on, and the lengths of the
        program's tools (l,)."""
        rows, mine = slice(begin - block.first, end - block.first), slice(begin - first, end - first)
        near, q = block.near, block.columns("q", begin, end)
        pairs = ((near.tip, tip), (near.axis, axis)) if near.has_tool else ()
        off = [np.sqrt(((told[rows] - true[mine]) ** 2).sum(axis=1)) for told, true in pairs]
        named = near.tool_length[rows]
        length_off = [np.abs(named[:, None] - tool_lengths).min(axis=1)] if len(named) and len(tool_lengths) else []
        return cls(
            Largest.of(q, begin), Largest.of(-q, begin), Largest.of(np.reshape(off, (len(off), q.shape[1])), begin),
            Largest.of(np.reshape(length_off, (len(length_off), q.shape[1])), begin),
            max(float(tip[mine].max()), -float(tip[mine].min())),
        )  # fmt: skip

    @classmethod
    def of_all(cls, parts: Sequence[BlockTool]) -> BlockTool:
        """That of a whole motion, from those of its blocks."""
        highest, lowest, off, length_off, farthest = zip(*parts)
        return cls(
            Largest.of_all(highest), Largest.of_all(lowest), Largest.of_all(off), Largest.of_all(length_off),
            max(farthest),
        )  # fmt: skip


def ways(tool_length: Floats, tip: Floats, axis: Floats, begin: int, end: int) -> Floats:
    """(k, 3) how the tip at (n, 3) goes in the steps from `begin` to `end`, with the tool in the spindle at
    their begin: where another one, of another of the lengths (n,), takes its place the tip is elsewhere, and did not go
    there."""
    step = np.diff(tip[begin : end + 1], axis=0)
    if len(tool_length):
        step += np.diff(tool_length[begin : end + 1])[:, None] * axis[begin + 1 : end + 1]
    return step


class StillSteps(NamedTuple):
    """Steps of a motion that may be of standing still."""

    step: Ints
    """(k,)"""
    moved: Floats
    """(k, m) by how much each joint moves [m or rad]."""

    @classmethod
    def of(cls, block: Block, begin: int, end: int, limits: Limits, dt: float) -> StillSteps:
        """Those from step `begin` to `end`: more than one out of rest, and more than rounding, is none of them."""
        moved = np.abs(np.diff(block.near.q[begin - block.first : end + 1 - block.first], axis=0))
        few = np.flatnonzero((moved <= 2.0 * still_step(limits, dt) + ROUNDING).all(axis=1))
        return cls(begin + few, moved[few])


def still_step(limits: Limits, dt: float) -> Floats:
    """(joints,) the most that each joint can move from rest in one step."""
    by_jerk, by_acceleration = limits.jerk * dt**3 / 6.0, limits.acceleration * dt**2 / 2.0
    least: Floats = np.minimum(np.minimum(by_jerk, by_acceleration), limits.velocity * dt)
    return least


@dataclass(frozen=True)
class SeenMotion:
    """What the judge keeps of a motion: peaks, places, and some numbers of each set-point."""

    source: SetPointSource
    """Where it is from: for the times and blocks of some places."""
    start: SetPoints
    """The first two set-points."""
    end: SetPoints
    """The last four, or as many as there are."""
    peaks: Peaks
    misfits: tuple[Largest, Largest]
    jerks: JerkWindows
    still: StillSteps
    tool: BlockTool | None
    """None without kinematics."""

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of the joints."""
        return self.source.joints

    def __len__(self) -> int:
        return len(self.source)

    def time(self, row: int) -> float:
        """When a set-point comes [s]."""
        return float(self.source.times(np.array([row]))[0])

    def place(self, row: int) -> tuple[float, int]:
        """When a set-point comes [s], and its block."""
        there = self.source.rows(row, row + 1)
        return float(there.t[0]), int(there.block[0])
