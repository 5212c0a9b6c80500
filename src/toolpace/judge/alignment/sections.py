"""Sections of a motion, each aligned with its part of the program by itself.

A pose between two sections has places that are reached from the start, and from the end. Where these are known at both
ends of a section, what lies between depends on nothing else: it is found with the room of one section, in several at
the same time. From the start, places are carried on as the sections come; from the end, when all are there.
"""

from __future__ import annotations

import os
import threading
from collections import deque
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from typing import NamedTuple, TypeVar

import numpy as np

from toolpace.common.arrays import Floats, Ints
from toolpace.common.files import Spool
from toolpace.judge.alignment import (
    ROUNDING,
    BothWays,
    Lost,
    align,
    common_places,
    nearest_places,
    no_room,
    turned_line,
    turned_sweep,
)
from toolpace.judge.alignment.sweep import Line, Sweep
from toolpace.judge.rows import MotionRow, Stretch, joined
from toolpace.judge.seen_motion import ways
from toolpace.motion.setpoints import Block

R = TypeVar("R")
Places = tuple[Floats, Floats]
"""Begins and ends (k,) of the places of a pose."""


class Steps(NamedTuple):
    """What is kept of some steps, with the set-points at both their ends."""

    stretch: Stretch
    t: Floats
    """(n,) of the set-points [s]."""
    block: Ints
    """(n,) their line numbers."""
    speed: Floats
    """(n + 1,) mean speed of the tip in each step, in the one before and the one behind them; as in the nearest step
    where there is none [m/s]."""

    @classmethod
    def of(cls, block: Block, stretch: Stretch, tip: Floats, axis: Floats, first: int, end: int) -> Steps:
        """That of a stretch up to the set-point `end`, with tips and axes (k, 3) from row `first` on."""
        begin, last = stretch.begin, block.of_all - 1
        before, behind = max(begin - 1, 0), min(end + 1, last)
        lengths = block.near.tool_length[first - block.first :]
        way = np.sqrt((ways(lengths, tip, axis, before - first, behind - first) ** 2).sum(axis=1))
        speed = way / np.diff(block.times(before, behind + 1))
        speed = np.pad(speed, (int(before == begin), int(behind == end)), "edge")
        own = slice(begin - block.first, end + 1 - block.first)
        # kernels are compiled for numbers that may be written to
        return cls(stretch, block.near.t[own], block.near.block[own].copy(), speed)


@dataclass(frozen=True)
class Section:
    """Some steps of a motion, and the part of the program that can stand for them."""

    steps: Steps
    motion: MotionRow
    """Their row; set-points count from its first one on."""
    program: slice
    """Which poses of the program's line the part has."""
    found: BothWays
    """Places count from the first pose of row and part on."""
    is_last: bool
    """Whether the motion ends with it."""

    @property
    def begin(self) -> int:
        """Its first set-point."""
        return self.steps.stretch.begin

    def own(self, count: int) -> int:
        """How many of its poses or set-points are its own: the last is the first of the next section."""
        return count if self.is_last else count - 1


class Sections:
    """The sections of a motion: taken in any order and in any thread, and aligned with a program once all are there."""

    def __init__(self, program: Line, within: float, steps: int) -> None:
        """Take the program, the radius that is near [tolerances], and how many steps the motion has."""
        self.program, self.within, self.steps = program, within, steps
        self._spool = Spool()
        self._reached: dict[int, Places] = {}
        """Of the first set-point of each section but the first."""
        self._next, self._stuck, self._sweeping, self._lock = 0, False, False, threading.Lock()

    @property
    def follows(self) -> bool:
        """Whether the motion, all of which is there, keeps to the program from its start to its end."""
        return self._next == self.steps and not self._stuck

    def take(self, steps: Steps) -> None:
        """Keep a section, and carry places on through all that have come from the start on."""
        self._spool.put(steps.stretch.begin, steps)
        while self._claim():
            self._carry_on(self._spool.get(self._next))

    def _claim(self) -> bool:
        """Whether this thread is the one to carry on, and can."""
        with self._lock:
            if self._sweeping or self._stuck or self._next not in self._spool:
                return False
            self._sweeping = True
            return True

    def _carry_on(self, steps: Steps) -> None:
        """Sweep over the next section."""
        sweep, start = self._sweep(row_of(steps), steps)
        last = len(sweep.rows) - 1
        end = steps.stretch.begin + len(steps.t) - 1
        follows: bool = sweep.run(start, last) == last and (end < self.steps or sweep.ends())
        if follows:
            self._reached[end] = sweep.places(last)
        with self._lock:
            self._next, self._stuck, self._sweeping = end, not follows, False

    def _sweep(self, motion: MotionRow, steps: Steps) -> tuple[Sweep, int]:
        """A sweep of a section from what is reached at its first pose, and the pose to run it from."""
        sweep = Sweep(motion.poses, no_room(motion.poses), self.program, self.within + motion.allowance)
        begin = steps.stretch.begin
        if not begin:
            return sweep, -1
        sweep.start_at(*self._reached[begin])
        return sweep, 0

    def each(self, work: Callable[[Section], R]) -> list[R]:
        """What `work` makes of each section, in their order; of a motion that follows the program."""
        results: deque[R] = deque()
        pending: deque[Future[R]] = deque()
        turned_program, ending = turned_line(self.program), None
        cores = os.cpu_count() or 1
        with ThreadPoolExecutor(cores) as threads:
            for begin in reversed(self._spool.numbers()):
                steps: Steps = self._spool.get(begin)
                motion = row_of(steps)
                sweep, start = self._sweep(motion, steps)
                turned, last = turned_sweep(sweep, turned_program), len(sweep.rows) - 1
                if ending is not None:
                    turned.start_at(*ending)
                if turned.run(-1 if ending is None else 0, last) < last:
                    raise AssertionError("a way that leads there leads back")
                ending = turned.places(last)
                pending.append(threads.submit(self._worked, work, steps, motion, sweep, start, turned))
                if len(pending) > 2 * cores:
                    results.appendleft(pending.popleft().result())
            results.extendleft(each.result() for each in pending)
        return list(results)

    def _worked(
        self, work: Callable[[Section], R], steps: Steps, motion: MotionRow, sweep: Sweep, start: int, turned: Sweep
    ) -> R:
        """What is made of a section, with its sweep from the end on."""
        sweep.run(start, len(sweep.rows) - 1)
        part, found = aligned(sweep, turned, self.within)
        is_last = steps.stretch.begin + len(steps.t) - 1 == self.steps
        return work(Section(steps, motion, part, found, is_last))

    def whole(self) -> tuple[Steps, MotionRow, BothWays | Lost]:
        """All sections as one, aligned with the program at once: of a motion that may leave it."""
        every: list[Steps] = [self._spool.get(begin) for begin in self._spool.numbers()]
        t, block = (np.concatenate([each[k][: None if each is every[-1] else -1] for each in every]) for k in (1, 2))
        speed = np.concatenate([every[0].speed[:1], *(each.speed[1:-1] for each in every), every[-1].speed[-1:]])
        motion = joined([each.stretch for each in every], t, every[-1].stretch.poses[-1])
        found = align(motion.poses, self.program.poses, self.within, motion.allowance, self.program.room)
        return Steps(every[0].stretch, t, block, speed), motion, found


def row_of(steps: Steps) -> MotionRow:
    """The row of a section by itself."""
    return joined([steps.stretch], steps.t, steps.stretch.poses[-1])


def aligned(sweep: Sweep, turned: Sweep, within: float) -> tuple[slice, BothWays]:
    """The part of the program that a section can be at, and the places of both; its sweeps are from the start and from
    the end."""
    begin, low, high = common_places(sweep, turned)
    program, motion = sweep.line, sweep.rows
    # both ends with their neighbours: a pose has the least room of the ways beside it
    first, last = max(int(low.min()) - 1, 0), min(int(np.ceil(high.max())) + 1, program.last)
    low, high = low - first, high - first
    poses, room = np.ascontiguousarray(program.poses[first : last + 1]), np.ascontiguousarray(program.room[first:last])
    there = nearest_places(motion, sweep.room, poses, room, (begin, low, high))
    line = Line(motion, sweep.radius - within + 2.0 * ROUNDING, sweep.room)
    back = Sweep(poses, room, line, np.full(len(poses), within))
    back.run_from_side(low[: begin[1]], high[: begin[1]])
    back_turned = turned_sweep(back)
    back_turned.run_from_side(last - first - high[begin[-2] :][::-1], last - first - low[begin[-2] :][::-1])
    places = common_places(back, back_turned)
    return slice(first, last + 1), BothWays(there, nearest_places(poses, room, motion, sweep.room, places), ())

