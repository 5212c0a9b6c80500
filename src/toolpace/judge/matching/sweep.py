"""A sweep along one row of poses: the places of another that can stand for each, in order, as far as it goes."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from toolpace.arrays import Floats, Ints

FANOUT = 8
"""Parts of a row that make up the next larger part of its tree; the same in the kernel."""
FULL = -2
"""What the kernel returns where the room for intervals ends."""
NEVER = 2**62
"""More poses, and more cells, than there are."""


class OutOfWorkError(Exception):
    """More cells were looked at than a motion that belongs to the program can ask for."""


@dataclass(frozen=True)
class Line:
    """A row of poses (m, 6) with balls about its parts, so that what is wholly near is not looked at one by one."""

    poses: Floats
    extra: Floats
    """(m,) radius at each pose beyond that of the pose which is looked for."""
    room: Floats
    """(m - 1, 2) the same of each way from one pose to the next, of tip and axis."""
    balls: Floats = field(init=False)
    """(parts, 8) centre, and radius of tip and axis, of each part of 8, 64, ... ways."""
    levels: Ints = field(init=False)
    """First part of each size, and the number of all."""

    def __post_init__(self) -> None:
        least, most = self.poses, self.poses
        parts, levels = [np.empty((0, 8))], [0]
        ways, size = len(self.poses) - 1, FANOUT
        while ways // size > 0:
            count = ways // size
            starts = np.arange(count) * FANOUT
            # A part ends at the pose with which the next one begins.
            within = slice(0, count * FANOUT + (1 if size == FANOUT else 0))
            low, high = np.minimum.reduceat(least[within], starts), np.maximum.reduceat(most[within], starts)
            if size == FANOUT:
                low, high = np.minimum(low, least[starts + FANOUT]), np.maximum(high, most[starts + FANOUT])
            half = 0.5 * (high - low)
            radii = [np.sqrt((half[:, part] ** 2).sum(axis=1)) for part in (slice(0, 3), slice(3, 6))]
            parts.append(np.column_stack((low + half, *radii)))
            levels.append(levels[-1] + count)
            least, most, size = low, high, size * FANOUT
        object.__setattr__(self, "balls", np.ascontiguousarray(np.concatenate(parts)))
        object.__setattr__(self, "levels", np.array(levels, dtype=np.int64))

    @property
    def last(self) -> int:
        """The last place."""
        return len(self.poses) - 1


@dataclass
class Sweep:
    """The places of a line that each pose of a row can stand at, found from the start on."""

    rows: Floats
    room: Floats
    """(n - 1, 2) how much further from each way between them is near, of tip and axis."""
    line: Line
    radius: Floats
    """(n,) how far from each pose is near; raised where a sweep is told to."""
    work: int = NEVER
    """Cells that may still be looked at."""
    begin: Ints = field(init=False)
    low: Floats = field(init=False)
    high: Floats = field(init=False)

    def __post_init__(self) -> None:
        n = len(self.rows)
        self.begin = np.zeros(n + 1, dtype=np.int64)
        self.low, self.high = np.empty(2 * n + 64), np.empty(2 * n + 64)

    def run(self, known: int, goal: int, seek: int = NEVER, raised: float = 0.0) -> int:
        """Go on from pose `known` (-1: from none) to `goal`; the last pose that was reached, -1 for none.

        From pose `seek` on each is first tried with its radius, then with `raised`; ends at the first that does with
        the radius it had. Raises OutOfWorkError.
        """
        from toolpace.kernels.judge.free_space import Row, reach

        line = self.line
        while True:
            task = np.array([known, goal, seek, self.work, 0], dtype=np.int64)
            found = int(
                reach(
                    Row(self.rows, self.room), Row(line.poses, line.room), self.radius, line.extra, line.balls,
                    line.levels, task, raised,
                    self.begin, self.low, self.high,
                )
            )  # fmt: skip
            if found != FULL:
                break
            self.low, self.high = (np.concatenate((each, np.empty(len(each)))) for each in (self.low, self.high))
        self.work = int(task[3])
        if task[4]:
            raise OutOfWorkError
        return found

    def ends(self) -> bool:
        """Whether the last pose can stand at the end of the line."""
        n = len(self.rows)
        first, last = self.begin[n - 1], self.begin[n]
        return bool(last > first and self.high[last - 1] >= self.line.last)
