"""The alignment of a motion and a program: the possible program places of each pose, in order.

Two rows are within a distance of each other, in order, if two walkers can go along them, none ever back, and stay that
close (Fréchet's distance). All ways for them to do so are kept at once, none is chosen, so that a program that goes
back over its own line, or crosses it, is matched as surely as any other. Where there is none, the motion has left the
program: the distance is raised there until there is one, as little as it takes, and what follows is judged as before.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from toolpace.common.arrays import Floats, Ints
from toolpace.judge.alignment.sweep import NEVER, Line, OutOfWorkError, Sweep

WORK = 200
"""Cells that may be looked at for each pose of both rows, to find a way on from where the motion left the program."""
LEAST_WORK = 10_000_000
"""The least number of them, in all."""
MOST_REPAIRS = 100
"""Places at which the motion leaves the program, until it is taken for another program's."""
AROUND = 4.0
"""Length before and behind a deviation for which it may be matched in another way [deviations]."""
CLOSE = 1e-4
"""Share of a deviation to which it is found."""
ROUNDING = 1e-9
"""By how much a second sweep sees further than the first [tolerances]."""


@dataclass(frozen=True)
class Alignment:
    """Of each pose of a row, the places that can stand for it on the other, and how near one of them is."""

    begin: Ints
    """(n + 1,) the places of pose k are low, high[begin[k]:begin[k + 1]]."""
    low: Floats
    high: Floats
    place: Floats
    """(n,) a nearest of them."""
    tip: Floats
    """(n,) distance of the tip there [tolerances]."""
    axis: Floats
    """(n,) of the tool axis [tolerances]."""

    @property
    def first(self) -> Floats:
        """(n,) the first place of each pose."""
        found: Floats = self.low[self.begin[:-1]]
        return found

    @property
    def last(self) -> Floats:
        """(n,) the last one."""
        found: Floats = self.high[self.begin[1:] - 1]
        return found


@dataclass(frozen=True)
class BothWays:
    """The alignment of a motion with a program, and of the program with the motion."""

    there: Alignment
    """Places on the program of each pose of the motion."""
    back: Alignment
    """Places on the motion of each pose of the program."""
    deviations: tuple[tuple[int, float], ...]
    """Pose of the motion at which it is found off the program, and the least distance at which it goes on."""


@dataclass(frozen=True)
class Lost:
    """The motion has so little to do with the program that no end of the search was in sight."""

    pose: int
    """Where it left the program."""
    distance: float
    """It is further off than this [tolerances]."""


def align(
    motion: Floats, program: Floats, within: float, allowance: Floats, room: Floats | None = None
) -> BothWays | Lost:
    """Match two rows of poses (n, 6) and (m, 6) in tolerances, `within` these.

    `room` (m - 1, 2) is by how much the tolerances of tip and axis are wider on each way of the program, none where it
    is None; where two ways meet, each has its own. `allowance` (n,) is what is granted beyond that at poses of the
    motion that are not set-points. Time is linear in n + m where both belong together, and bounded by a multiple of
    it where they do not.
    """
    room, none = no_room(program) if room is None else room, no_room(motion)
    sweep = Sweep(motion, none, Line(program, np.zeros(len(program)), room), within + allowance)
    try:
        deviations = _follow(sweep, motion, LEAST_WORK + WORK * (len(motion) + len(program)))
    except _LostError as lost:
        return Lost(lost.pose, lost.distance)
    there, raised = _finish(sweep), sweep.radius - within
    # of a long motion its places take as much memory as all that is still to come
    del sweep
    back = Sweep(program, room, Line(motion, raised + 2.0 * ROUNDING, none), np.full(len(program), within))
    if back.run(-1, len(program) - 1) < len(program) - 1:
        raise AssertionError("two rows are near each other, but not the other way round")
    return BothWays(there, _finish(back), tuple(deviations))


class _LostError(Exception):
    def __init__(self, pose: int, distance: float) -> None:
        super().__init__()
        self.pose, self.distance = pose, distance


def _follow(sweep: Sweep, motion: Floats, work: int) -> list[tuple[int, float]]:
    """Sweep along the motion to its end; where it cannot go on, raise the radius. Returns where, and how far."""
    last, length = len(motion) - 1, np.empty(0)
    deviations: list[tuple[int, float]] = []
    reached, widest = -1, 2.0
    while True:
        reached = sweep.run(reached, last)
        if reached == last and sweep.ends():
            return deviations
        stuck = min(reached + 1, last)
        if not len(length):
            length = np.concatenate(([0.0], np.cumsum(np.sqrt((np.diff(motion, axis=0) ** 2).sum(axis=1)))))
        for_good = len(deviations) >= MOST_REPAIRS
        sweep.work = work
        reached, distance = _Repair(sweep, length, stuck, for_good).carry_out(widest if for_good else 2.0)
        work, sweep.work = sweep.work, NEVER
        widest = max(widest, distance)
        deviations.append((stuck, distance))


@dataclass(frozen=True)
class _Repair:
    """A way on from where a sweep is stuck: with a raised radius until the motion is back on the program."""

    sweep: Sweep
    length: Floats
    """(n,) of the motion up to each pose."""
    stuck: int
    """The pose that is not reached; the last one where the end of the program is not."""
    for_good: bool
    """Whether the radius stays raised to the end."""

    def carry_out(self, distance: float) -> tuple[int, float]:
        """The pose from which on all is well again, and the least distance at which it is reached."""
        below = 0.0
        try:
            while True:
                start = self.start(distance)
                before = self.sweep.radius[start + 1 :].copy()
                back = self.through(start, distance)
                if back is not None:
                    break
                self.sweep.radius[start + 1 :] = before
                below, distance = distance, 2.0 * distance
            while distance - below > CLOSE * distance and not self.for_good:
                middle = 0.5 * (below + distance)
                if self.passes(start, back, middle, before):
                    distance = middle
                else:
                    below = middle
            self.passes(start, back, distance, before)
        except OutOfWorkError:
            raise _LostError(self.stuck, below) from None
        return self.checked(back, distance), distance

    def start(self, distance: float) -> int:
        """The pose before the stretch that is matched in another way; -1 for the start of all."""
        far = self.length[self.stuck] - AROUND * distance
        return int(np.searchsorted(self.length[: self.stuck], far, side="right")) - 1

    def checked(self, back: int, distance: float) -> int:
        """The pose to which a way back must hold."""
        far = self.length[back] + AROUND * distance
        return min(int(np.searchsorted(self.length, far)), len(self.length) - 1)

    def raise_radius(self, start: int, end: int, distance: float) -> None:
        """Raise it for the poses between."""
        part = self.sweep.radius[start + 1 : end]
        np.maximum(part, distance, out=part)

    def through(self, start: int, distance: float) -> int | None:
        """The pose at which the motion is back on the program; the last one where it never is; None: too near."""
        last = len(self.length) - 1
        self.raise_radius(start, self.stuck, distance)
        passed, seek = start, self.stuck if not self.for_good else last + 1
        if self.for_good:
            self.raise_radius(start, last + 1, distance)
        while True:
            reached = self.sweep.run(passed, last, seek, distance)
            if reached == last:
                return last if self.sweep.ends() or self.raised_end(distance) else None
            if reached < seek or reached < 0 or self.sweep.radius[reached] >= distance:
                return None
            good = self.checked(reached, distance)
            held = self.sweep.run(reached, good)
            if held == good and (good < last or self.sweep.ends()):
                return reached
            # Near by chance; on from there, no more looking until where that ended.
            seek = min(held + 1, last)
            self.raise_radius(reached - 1, seek, distance)
            passed = reached - 1

    def raised_end(self, distance: float) -> bool:
        """Whether the last pose stands at the end of the program if it may be as far off as the others."""
        last = len(self.length) - 1
        self.raise_radius(last - 1, last + 1, distance)
        self.sweep.run(last - 1, last)
        return self.sweep.ends()

    def passes(self, start: int, back: int, distance: float, before: Floats) -> bool:
        """Whether a smaller distance does, with the same pose for the way back."""
        sweep, last = self.sweep, len(self.length) - 1
        sweep.radius[start + 1 :] = before
        self.raise_radius(start, back if back < last else last + 1, distance)
        good = self.checked(back, distance)
        return sweep.run(start, good) == good and (good < last or sweep.ends())


def _finish(sweep: Sweep) -> Alignment:
    """The places from which the end is reached too, and the nearest of them."""
    n, turned = len(sweep.rows), turned_sweep(sweep)
    if turned.run(-1, n - 1) < n - 1:
        raise AssertionError("a way that leads there leads back")
    return nearest_places(sweep.rows, sweep.room, sweep.line.poses, sweep.line.room, common_places(sweep, turned))


def turned_sweep(sweep: Sweep, line: Line | None = None) -> Sweep:
    """A sweep of the same rows from the end on; `line` is the same line turned round, where that is there already."""
    line = turned_line(sweep.line) if line is None else line
    return Sweep(_turned(sweep.rows), _turned(sweep.room), line, _turned(sweep.radius) + ROUNDING)


def turned_line(line: Line) -> Line:
    """A line from its end on."""
    return Line(*map(_turned, (line.poses, line.extra, line.room)))


def common_places(sweep: Sweep, turned: Sweep) -> tuple[Ints, Floats, Floats]:
    """Begin, low and high, as in `Alignment`, of the places of a sweep that are those of the turned one, too."""
    from toolpace.kernels.judge.matching import both_ways

    begin, room = np.empty(len(sweep.rows) + 1, dtype=np.int64), len(sweep.low)
    while True:
        low, high = np.empty(room), np.empty(room)
        count = both_ways(
            sweep.begin, sweep.low, sweep.high, turned.begin, turned.low, turned.high, float(sweep.line.last),
            begin, low, high,
        )  # fmt: skip
        if count <= room:
            return begin, low[:count], high[:count]
        room = int(count)


def nearest_places(
    rows: Floats, room: Floats, line: Floats, line_room: Floats, places: tuple[Ints, Floats, Floats]
) -> Alignment:
    """Places on a line (m, 6) of a row of poses (n, 6), and the nearest of each pose; what has none is at infinity."""
    from toolpace.kernels.judge.matching import nearest

    place, tip, axis = np.zeros(len(rows)), np.full(len(rows), np.inf), np.full(len(rows), np.inf)
    nearest(rows, room_at_poses(room), line, line_room, *places, place, tip, axis)
    return Alignment(*places, place, tip, axis)


def room_at_poses(room: Floats) -> Floats:
    """(n, 2) the least room of both ways (n - 1, 2) that meet at a pose."""
    if not room.any():
        return np.zeros((len(room) + 1, 2))
    least = np.empty((len(room) + 1, 2))
    least[[0, -1]] = room[[0, -1]]
    np.minimum(room[:-1], room[1:], out=least[1:-1])
    return least


def _turned(values: Floats) -> Floats:
    """Rows in the opposite order."""
    return np.ascontiguousarray(values[::-1]) if values.any() else np.zeros(values.shape)


def no_room(poses: Floats) -> Floats:
    """(n - 1, 2) of a row of poses (n, 6) whose ways have no room of their own."""
    return np.zeros((max(len(poses) - 1, 1), 2))
