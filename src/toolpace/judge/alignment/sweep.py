"""One sweep of the alignment along a row of poses."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from toolpace.common.arrays import Floats, Ints

FANOUT = 8
"""Parts of a row that make up the next larger part of its tree; the same in the kernel."""
FULL = -2
"""What the kernel returns where the room for intervals ends."""
NO_PLACE = 2.0
"""What it takes for a share that there is not."""
NEVER = 2**62
"""More poses, and more cells, than there are."""
LARGE = 64
"""Ways of the least part about which a disc is laid: a turn of a joint has as many."""
NEAR = 2.0
"""Half the side of the largest box about a part that may be wholly near, and is worth a disc [tolerances]."""
POINT = 0.01
"""Radius of a ball that no disc makes much smaller [tolerances]."""
HALVES = (slice(0, 3), slice(3, 6))
"""Tip and axis of a pose."""
AT_ONCE = 1_000_000
"""Poses about which discs are laid at a time."""


class OutOfWorkError(Exception):
    """More cells were looked at than a motion that belongs to the program can ask for."""


@dataclass(frozen=True)
class Line:
    """A row of poses (m, 6) with discs about its parts, so that what is wholly near is not looked at one by one."""

    poses: Floats
    extra: Floats
    """(m,) radius at each pose beyond that of the pose which is looked for."""
    room: Floats
    """(m - 1, 2) the same of each way from one pose to the next, of tip and axis."""
    discs: Floats = field(init=False)
    """(parts, 16) of tip and axis of each part of 8, 64, ... ways: centre, upright, radius and half the thickness; a
    ball where the upright is 0."""
    levels: Ints = field(init=False)
    """First part of each size, and the number of all."""

    def __post_init__(self) -> None:
        least, most = self.poses, self.poses
        parts, levels = [np.empty((0, 16))], [0]
        ways, size = len(self.poses) - 1, FANOUT
        while ways // size > 0:
            count = ways // size
            starts = np.arange(count) * FANOUT
            low, high = _of_parts(np.minimum, least, count), _of_parts(np.maximum, most, count)
            if size == FANOUT:
                # A part ends at the pose with which the next one begins.
                low, high = np.minimum(low, least[starts + FANOUT]), np.maximum(high, most[starts + FANOUT])
            large = (high - low).max(axis=1) <= 2.0 * NEAR if size >= LARGE else np.zeros(count, dtype=bool)
            parts.append(np.hstack([_discs(self.poses, half, low, high, size, large) for half in HALVES]))
            levels.append(levels[-1] + count)
            least, most, size = low, high, size * FANOUT
        object.__setattr__(self, "discs", np.ascontiguousarray(np.concatenate(parts)))
        object.__setattr__(self, "levels", np.array(levels, dtype=np.int64))

    @property
    def last(self) -> int:
        """The last place."""
        return len(self.poses) - 1


def _of_parts(least: np.ufunc, rows: Floats, count: int) -> Floats:
    """(count, 6) the least or the largest of each FANOUT rows: halves with halves, which is quicker than one by one."""
    parts = rows[: count * FANOUT].reshape(count, FANOUT, -1)
    while parts.shape[1] > 1:
        half = parts.shape[1] // 2
        parts = least(parts[:, :half], parts[:, half:])
    found: Floats = parts[:, 0]
    return found


def _discs(poses: Floats, half: slice, low: Floats, high: Floats, size: int, large: npt.NDArray[np.bool_]) -> Floats:
    """Discs (parts, 8) about one half of parts of `size` ways each of a row (m, 6), whose boxes are `low` and `high`
    (parts, 6); balls about their boxes where parts are not `large` (parts,), or next to points.

    Turns of a joint are circles, which have room in a disc and little in the ball about their box: a pose beside the
    plane of a circle can be near all of it and far from parts of the ball.
    """
    side = 0.5 * (high[:, half] - low[:, half])
    found = np.zeros((len(low), 8))
    found[:, :3], found[:, 6] = low[:, half] + side, np.sqrt((side**2).sum(axis=1))
    wanted = np.flatnonzero(large & (found[:, 6] > POINT))
    step = max(AT_ONCE // size, 1)
    for part in (wanted[k : k + step] for k in range(0, len(wanted), step)):
        away = poses[part[:, None] * size + np.arange(size + 1), half] - found[part, None, :3]
        upright = np.linalg.eigh(np.swapaxes(away, 1, 2) @ away)[1][:, :, 0]
        above = np.einsum("psa,pa->ps", away, upright)
        beside = away - above[:, :, None] * upright[:, None]
        found[part, 3:6] = upright
        found[part, 6] = np.sqrt((beside**2).sum(axis=2).max(axis=1))
        found[part, 7] = np.abs(above).max(axis=1)
    return found


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

    def run(self, reached: int, goal: int, seek: int = NEVER, raised: float = 0.0) -> int:
        """Go on from pose `reached` (-1: from none) to `goal`; the last pose that was reached, -1 for none.

        From pose `seek` on each is first tried with its radius, then with `raised`; ends at the first that does with
        the radius it had. Raises OutOfWorkError.
        """
        from toolpace.kernels.judge.free_space import Row, reach

        line = self.line
        while True:
            task = np.array([reached, goal, seek, self.work, 0], dtype=np.int64)
            found = int(
                reach(
                    Row(self.rows, self.room), Row(line.poses, line.room), self.radius, line.extra, line.discs,
                    line.levels, task, raised,
                    self.begin, self.low, self.high,
                )
            )  # fmt: skip
            if found != FULL:
                break
            self._grow()
        self.work = int(task[3])
        if task[4]:
            raise OutOfWorkError
        return found

    def start_at(self, low: Floats, high: Floats) -> None:
        """Take the places low, high (k,) of the first pose, where they are known, in place of the line's start."""
        while len(low) > len(self.low):
            self._grow()
        self.begin[1] = len(low)
        self.low[: len(low)], self.high[: len(low)] = low, high

    def run_from_side(self, low: Floats, high: Floats) -> None:
        """Find the places of all poses from where the line is entered at its start: at places low, high (k,) of the
        row."""
        from toolpace.kernels.judge.free_space import Row, reach_from_side

        line, entry = self.line, _entries(low, high, self.room)
        row, line_row = Row(self.rows, self.room), Row(line.poses, line.room)
        while True:
            found = reach_from_side(
                row, line_row, self.radius, line.extra, line.discs, line.levels, entry,
                self.begin, self.low, self.high,
            )  # fmt: skip
            if found != FULL:
                break
            self._grow()

    def _grow(self) -> None:
        """Make room for twice as many intervals."""
        self.low, self.high = (np.concatenate((each, np.empty(len(each)))) for each in (self.low, self.high))

    def places(self, pose: int) -> tuple[Floats, Floats]:
        """Begins and ends (k,) of the places of a pose."""
        part = slice(self.begin[pose], self.begin[pose + 1])
        return self.low[part].copy(), self.high[part].copy()

    def ends(self) -> bool:
        """Whether the last pose can stand at the end of the line."""
        n = len(self.rows)
        first, last = self.begin[n - 1], self.begin[n]
        return bool(last > first and self.high[last - 1] >= self.line.last)


def _entries(low: Floats, high: Floats, room: Floats) -> Floats:
    """(n,) the least share of the way to each pose of a row that lies in one of the places low, high (k,), NO_PLACE for
    none; of the first pose, to which no way leads, 0 where it does itself. `room` (n - 1, 2) is that of the ways."""
    count = len(room) + 1
    entry = np.full(count, NO_PLACE)
    for first, last in zip(low.tolist(), high.tolist()):
        # what ends at a pose belongs to the way before it
        end = int(np.ceil(last)) if last > first else int(last) + 1
        ways = np.arange(int(first), min(end, count - 1))
        entry[1 + ways] = np.minimum(entry[1 + ways], np.maximum(first - ways, 0.0))
        pose = int(first)
        if pose == 0 and first == 0.0:
            entry[0] = 0.0
        elif pose == first and (pose == count - 1 or (room[pose - 1] >= room[pose]).all()):
            # What begins at a pose is the end of the way to it. Of a narrower way it need not be.
            entry[pose] = min(entry[pose], 1.0)
    return entry
