"""The free space of two rows of poses: which place of one can stand for each pose of the other, in order.

A pose is six numbers: the tip divided by its tolerance, then the tool axis divided by its own. Two poses are near
where both halves are within a radius. A place of a row is a number: the pose before it, plus the share of the way to
the next. All pairs of places that are near make up the free space of Alt and Godau (1995): between two neighbours of
one row and two of the other it is convex, so that on each border of such a cell one interval can be reached, and
nothing is lost by keeping these alone.

The way from each pose of a row to the next may have room beyond the radius, for the tip and for the axis: where the
program's tolerance is wider there. A pose has the least room of both ways that meet at it.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from toolpace.kernels.arrays import Floats, Ints
from toolpace.kernels.jit import jit

FANOUT = 8
"""Parts of the row that make up the next larger part of the tree."""
NO_PLACE = 2.0
"""Stands for a share that there is not."""
FULL = -2
"""No room for more intervals."""


class Row(NamedTuple):
    """A row of poses."""

    poses: Floats
    """(n, 6)"""
    room: Floats
    """(n - 1, 2) of the way from each pose to the next, beyond the radius: of tip and axis."""


@jit()
def at_pose(room: Floats, k: int, half: int) -> float:
    """Room (ways, 2) at pose k, for the tip (0) or the axis (1)."""
    before, behind = room[max(k - 1, 0), half], room[min(k, len(room) - 1), half]
    least: float = min(before, behind)
    return least


@jit()
def near(
    poses: Floats, k: int, line: Floats, j: int, radius: float, tip_room: float, axis_room: float
) -> tuple[float, float]:
    """The shares of the way from pose j of the line to the next that are within the radius of pose k, and the room
    beyond it; (2, -1) for none.

    Found from the foot of the perpendicular, so that long ways lose no digits.
    """
    low, high = 0.0, 1.0
    for half in range(0, 6, 3):
        within = radius + (tip_room if half == 0 else axis_room)
        square, along, still = 0.0, 0.0, 0.0
        for i in range(half, half + 3):
            d = line[j + 1, i] - line[j, i]
            w = poses[k, i] - line[j, i]
            square += d * d
            along += w * d
            still += w * w
        if square < 1e-200:
            if still > within * within:
                return NO_PLACE, -1.0
            continue
        foot = along / square
        off = 0.0
        for i in range(half, half + 3):
            w = poses[k, i] - line[j, i] - foot * (line[j + 1, i] - line[j, i])
            off += w * w
        room = within * within - off
        if room < 0.0:
            return NO_PLACE, -1.0
        reach = math.sqrt(room / square)
        low = max(low, foot - reach)
        high = min(high, foot + reach)
    if low > high:
        return NO_PLACE, -1.0
    return low, high


@jit()
def encloses(poses: Floats, k: int, radius: float, discs: Floats, b: int) -> bool:
    """Whether all of part b of the line, within its discs (16: of tip and axis centre, upright, radius and half the
    thickness), is within the radius of pose k."""
    for half in range(2):
        first, square, above = 8 * half, 0.0, 0.0
        for i in range(3):
            w = poses[k, 3 * half + i] - discs[b, first + i]
            square += w * w
            above += w * discs[b, first + 3 + i]
        beside = math.sqrt(max(square - above * above, 0.0)) + discs[b, first + 6]
        if beside > radius or beside * beside + (abs(above) + discs[b, first + 7]) ** 2 > radius * radius:
            return False
    return True


@jit()
def free_part(rows: Floats, radius: Floats, discs: Floats, levels: Ints, k: int, after: int, j: int) -> int:
    """Length of the longest part of the line that begins at j and is wholly near from pose k to pose `after`; 0 for
    none.

    What is within the radius of both poses is within that of the way between them.
    """
    level, size = -1, 1
    while level + 2 < len(levels) and j % (size * FANOUT) == 0:
        if levels[level + 1] + j // (size * FANOUT) >= levels[level + 2]:
            break
        level, size = level + 1, size * FANOUT
    # A larger part may be seen to be near where a smaller one is not: a turn fills its disc, and an arc does not.
    while level >= 0:
        b = levels[level] + j // size
        if encloses(rows, k, radius[k], discs, b) and encloses(rows, after, radius[after], discs, b):
            return size
        level, size = level - 1, size // FANOUT
    return 0


@jit()
def advance(
    row: Row,
    line_row: Row,
    radius: Floats,
    extra: Floats,
    discs: Floats,
    levels: Ints,
    k: int,
    after: int,
    entry: float,
    span: Ints,
    low: Floats,
    high: Floats,
) -> int:
    """From the places that pose k can stand at to those of the pose `after`: both in intervals, in order.

    `entry` is the least share of the way between both at which the start of the line is reached from elsewhere, and
    NO_PLACE where it is not. The former places are low, high[span[0]:span[1]]; the latter are written from span[1] on,
    and span[2] becomes their end.
    Returns the cells looked at, or FULL.
    """
    (rows, row_room), (line, line_room) = row, line_row
    first, last, end, room = span[0], span[1], span[1], len(low)
    wide = max(radius[k], radius[after])
    i = first
    below = entry  # least share of the way between the poses at which the line's pose j is reached
    j, cells, segments = 0, 0, len(line) - 1
    while True:
        # What ends at a pose of the line belongs to the way before it, what begins there to the way after it.
        while i < last and (high[i] < j or (high[i] == j and low[i] < j)):
            i += 1
        if below > 1.0:
            if i >= last:
                break
            j = max(j, min(int(low[i]), segments - 1))
        if j >= segments:
            break
        cells += 1
        here = i < last and (low[i] < j + 1 or j == segments - 1)
        if below <= 1.0 or (here and low[i] <= j):
            size = free_part(rows, radius, discs, levels, k, after, j)
            if size > 0:
                if i < last and low[i] < j + size:
                    below = 0.0
                if end > last and high[end - 1] >= j:
                    high[end - 1] = j + size
                else:
                    if end >= room:
                        return FULL
                    low[end], high[end] = j, j + size
                    end += 1
                j += size
                continue
        least, most = near(
            rows, after, line, j, radius[after] + max(extra[j], extra[j + 1]),
            at_pose(row_room, after, 0) + line_room[j, 0], at_pose(row_room, after, 1) + line_room[j, 1],
        )  # fmt: skip
        if below > 1.0:
            least = max(least, low[i] - j)
        if least <= most:
            if end > last and high[end - 1] >= j + least:
                high[end - 1] = j + most
            else:
                if end >= room:
                    return FULL
                low[end], high[end] = j + least, j + most
                end += 1
        tip_room, axis_room = at_pose(line_room, j + 1, 0), at_pose(line_room, j + 1, 1)
        if after > k:
            tip_room, axis_room = tip_room + row_room[k, 0], axis_room + row_room[k, 1]
            start, stop = near(line, j + 1, rows, k, wide + extra[j + 1], tip_room, axis_room)
        else:
            tip_room, axis_room = tip_room + at_pose(row_room, k, 0), axis_room + at_pose(row_room, k, 1)
            start, stop = standing(line, j + 1, rows, k, wide + extra[j + 1], tip_room, axis_room)
        if not here:
            start = max(start, below)
        below = start if start <= stop else NO_PLACE
        j += 1
    span[2] = end
    return cells


@jit()
def standing(
    line: Floats, j: int, rows: Floats, k: int, radius: float, tip_room: float, axis_room: float
) -> tuple[float, float]:
    """As `near`, for a pose that stays where it is."""
    for half in range(0, 6, 3):
        within = radius + (tip_room if half == 0 else axis_room)
        square = 0.0
        for i in range(half, half + 3):
            square += (line[j, i] - rows[k, i]) ** 2
        if square > within * within:
            return NO_PLACE, -1.0
    return 0.0, 1.0


@jit()
def first_places(
    row: Row,
    line_row: Row,
    radius: Floats,
    extra: Floats,
    discs: Floats,
    levels: Ints,
    span: Ints,
    low: Floats,
    high: Floats,
) -> int:
    """How many intervals the first pose has that goes on along the line from its start: low, high[:count]; -1 for none,
    where it is not near the start, FULL where the room for intervals ends."""
    (rows, row_room), (line, line_room) = row, line_row
    tip_room = at_pose(line_room, 0, 0) + at_pose(row_room, 0, 0)
    axis_room = at_pose(line_room, 0, 1) + at_pose(row_room, 0, 1)
    start, stop = standing(line, 0, rows, 0, radius[0] + extra[0], tip_room, axis_room)
    if start > stop:
        return -1
    low[0], high[0] = 0.0, 0.0
    span[0], span[1] = 0, 1
    if advance(row, line_row, radius, extra, discs, levels, 0, 0, NO_PLACE, span, low, high) == FULL:
        return FULL
    for i in range(span[1], span[2]):
        low[i - 1], high[i - 1] = low[i], high[i]
    return int(span[2] - 1)


@jit()
def reach_from_side(
    row: Row,
    line_row: Row,
    radius: Floats,
    extra: Floats,
    discs: Floats,
    levels: Ints,
    entry: Floats,
    begin: Ints,
    low: Floats,
    high: Floats,
) -> int:
    """The places of each pose of a row that are reached where the line is entered at its start all along the row.

    entry[k] is the least share of the way from pose k - 1 to pose k at which it can be entered, NO_PLACE where it
    cannot; entry[0] is 0 where it can be at pose 0. Places of pose k are low, high[begin[k]:begin[k + 1]]: a pose may
    have none. Returns how many intervals there are, or FULL.
    """
    span = np.zeros(3, dtype=np.int64)
    begin[0] = begin[1] = 0
    if entry[0] == 0.0:
        found = first_places(row, line_row, radius, extra, discs, levels, span, low, high)
        if found == FULL:
            return FULL
        begin[1] = max(found, 0)
    for k in range(len(begin) - 2):
        span[0], span[1] = begin[k], begin[k + 1]
        begin[k + 2] = begin[k + 1]
        if span[1] > span[0] or entry[k + 1] <= 1.0:
            if advance(row, line_row, radius, extra, discs, levels, k, k + 1, entry[k + 1], span, low, high) == FULL:
                return FULL
            begin[k + 2] = span[2]
    return int(begin[-1])


@jit()
def reach(
    row: Row,
    line_row: Row,
    radius: Floats,
    extra: Floats,
    discs: Floats,
    levels: Ints,
    task: Ints,
    raised: float,
    begin: Ints,
    low: Floats,
    high: Floats,
) -> int:
    """Go on from the pose task[0], whose places are known (from none, where it is 0), to task[1] at most.

    Places of pose k are low, high[begin[k]:begin[k + 1]]. From pose task[2] on, `radius` (n,) is first tried as it is
    and then `raised`, which is written into it: returns at the first pose that is reached with the radius as it was.
    Returns the last pose that has places; -1 for none at all, FULL where the room for intervals ends. task[3] is the
    number of cells that may be looked at, and becomes what is left of it; where it is used up, task[4] becomes 1.
    """
    k, goal, seek = int(task[0]), int(task[1]), int(task[2])
    span = begin[:3].copy()
    task[4] = 0
    if k < 0:
        if seek == 0:
            radius[0] = raised
        count = first_places(row, line_row, radius, extra, discs, levels, span, low, high)
        if count < 0:
            return count
        begin[0], begin[1] = 0, count
        k = 0
    while k < goal:
        span[0], span[1] = begin[k], begin[k + 1]
        cells = advance(row, line_row, radius, extra, discs, levels, k, k + 1, NO_PLACE, span, low, high)
        if cells == FULL:
            return FULL
        found = span[2] > span[1]
        if k + 1 >= seek:
            if found:
                begin[k + 2] = span[2]
                return k + 1
            radius[k + 1] = raised
            cells = advance(row, line_row, radius, extra, discs, levels, k, k + 1, NO_PLACE, span, low, high)
            if cells == FULL:
                return FULL
            found = span[2] > span[1]
        task[3] -= cells
        if not found:
            return k
        begin[k + 2] = span[2]
        k += 1
        if task[3] < 0:
            task[4] = 1
            return k
    return k
