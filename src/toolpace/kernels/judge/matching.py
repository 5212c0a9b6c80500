"""The possible places of each pose in both directions, their distances, and values there."""

from __future__ import annotations

import math

import numpy as np

from toolpace.kernels.arrays import Bools, Floats, Ints
from toolpace.kernels.jit import jit

LOOK = 64
"""Most ways between poses of the line on which the nearest place to one pose is looked for."""
BEHIND = 16
"""How many of them lie before the place of the pose before it."""


@jit()
def both_ways(
    begin: Ints,
    low: Floats,
    high: Floats,
    from_end: Ints,
    end_low: Floats,
    end_high: Floats,
    last: float,
    into: Ints,
    into_low: Floats,
    into_high: Floats,
) -> int:
    """Places reached from the start (begin, low, high) from which the end is reached too.

    `from_end`, `end_low`, `end_high` are those reached on both rows turned round, whose last place is `last`. Written
    to `into`, `into_low`, `into_high`. Where an interval of one only touches one of the other, at a pose between two
    ways of different radius, they share no place unless there is no other. Returns how many intervals there are;
    where that is more than there is room for, only as many as fit are written.
    """
    n, count, room = len(begin) - 1, 0, len(into_low)
    into[0] = 0
    for k in range(n):
        i, stop = begin[k], begin[k + 1]
        j, least = from_end[n - k] - 1, from_end[n - 1 - k]
        touch = -1.0
        while i < stop and j >= least:
            a, b = last - end_high[j], last - end_low[j]
            start, finish = max(low[i], a), min(high[i], b)
            if start == finish and low[i] < high[i] and a < b:
                touch = start
            elif start <= finish:
                if count < room:
                    into_low[count], into_high[count] = start, finish
                count += 1
            if high[i] < b:
                i += 1
            else:
                j -= 1
        if count == into[k] and touch >= 0.0:
            if count < room:
                into_low[count], into_high[count] = touch, touch
            count += 1
        into[k + 1] = count
    return count


@jit()
def parabola(poses: Floats, k: int, line: Floats, j: int, half: int) -> tuple[float, float, float]:
    """a, b, c of the square of the distance, a u^2 + b u + c, at the share u of the way from pose j of the line on."""
    a, b, c = 0.0, 0.0, 0.0
    for i in range(3 * half, 3 * half + 3):
        d = line[j + 1, i] - line[j, i]
        w = line[j, i] - poses[k, i]
        a += d * d
        b += 2.0 * d * w
        c += w * w
    return a, b, c


@jit()
def off(poses: Floats, k: int, line: Floats, j: int, u: float, half: int) -> float:
    """The distance itself, from the difference of the poses."""
    square = 0.0
    for i in range(3 * half, 3 * half + 3):
        w = line[j, i] + u * (line[j + 1, i] - line[j, i]) - poses[k, i]
        square += w * w
    return math.sqrt(square)


@jit()
def nearest_on(
    poses: Floats, k: int, line: Floats, j: int, low: float, high: float, tip_room: float, axis_room: float
) -> tuple[float, float, float]:
    """The share in [low, high] where the larger of both distances, over their room and 1, is least; both there.

    The larger of two parabolas is least at the foot of one of them or where they are equal.
    """
    wide, broad = 1.0 + tip_room, 1.0 + axis_room
    a, b, c = parabola(poses, k, line, j, 0)
    d, e, f = parabola(poses, k, line, j, 1)
    a, b, c = a / wide**2, b / wide**2, c / wide**2
    d, e, f = d / broad**2, e / broad**2, f / broad**2
    best, best_u, best_tip, best_axis = np.inf, low, np.inf, np.inf
    square, slope, rest = a - d, b - e, c - f
    root = math.sqrt(max(slope * slope - 4.0 * square * rest, 0.0))
    for candidate in range(6):
        u = low
        if candidate == 1:
            u = high
        elif candidate == 2 and a > 0.0:
            u = -b / (2.0 * a)
        elif candidate == 3 and d > 0.0:
            u = -e / (2.0 * d)
        elif candidate == 4:
            q = -0.5 * (slope + math.copysign(root, slope))
            u = q / square if square != 0.0 else low
        elif candidate == 5:
            q = -0.5 * (slope + math.copysign(root, slope))
            u = rest / q if q != 0.0 else low
        u = min(max(u, low), high)
        tip, axis = off(poses, k, line, j, u, 0), off(poses, k, line, j, u, 1)
        if max(tip / wide, axis / broad) < best:
            best, best_u, best_tip, best_axis = max(tip / wide, axis / broad), u, tip, axis
    return best_u, best_tip, best_axis


@jit()
def nearest(
    poses: Floats,
    pose_room: Floats,
    line: Floats,
    line_room: Floats,
    begin: Ints,
    low: Floats,
    high: Floats,
    place: Floats,
    tip: Floats,
    axis: Floats,
) -> None:
    """For each pose, of the places low, high[begin[k]:begin[k + 1]] one that is nearest, and both distances there.

    Near is what is near beside the room (n, 2) of poses and ways, and 1.

    Where they lie on more than LOOK ways, only these about the place of the pose before are looked at: what is found
    is then a place that can stand for the pose, if not the very nearest.
    """
    segments, before = len(line) - 1, 0.0
    for k in range(len(begin) - 1):
        first, last = begin[k], begin[k + 1]
        ways = 0
        for i in range(first, last):
            ways += int(high[i]) - int(low[i]) + 1
            if ways > LOOK:
                break
        start = before - BEHIND if ways > LOOK else -1.0
        best, looked = np.inf, 0
        i = first
        while i < last - 1 and high[i] < start:
            i += 1
        while i < last and looked < LOOK:
            bottom = max(low[i], min(start, high[i]))
            j = min(int(bottom), segments - 1)
            while j <= high[i] and j < segments and looked < LOOK:
                tip_room, axis_room = pose_room[k, 0] + line_room[j, 0], pose_room[k, 1] + line_room[j, 1]
                u, off_tip, off_axis = nearest_on(
                    poses, k, line, j, max(bottom - j, 0.0), min(high[i] - j, 1.0), tip_room, axis_room
                )
                looked += 1
                off_both = max(off_tip / (1.0 + tip_room), off_axis / (1.0 + axis_room))
                if off_both < best:
                    best = off_both
                    place[k], tip[k], axis[k] = j + u, off_tip, off_axis
                j += 1
            i += 1
        if first < last:
            before = place[k]


@jit()
def stretch_before(start: Floats, place: float, r: int) -> int:
    """The last of the stretches from start[r] to start[r + 1] that begins before the place; 0 for none.

    Looked for from r on in steps that grow: what is near is found at once, and what is far in a few steps.
    """
    count = len(start) - 1
    low, high, step = r, r, 1
    while low > 0 and start[low] >= place:
        high, low, step = low, max(low - step, 0), 2 * step
    if high == low:
        high = low + 1
        while high < count and start[high] < place:
            low, high, step = high, min(high + step, count), 2 * step
    while high - low > 1:
        middle = (low + high) // 2
        if start[middle] < place:
            low = middle
        else:
            high = middle
    return low


@jit()
def largest_between(begin: Ints, low: Floats, high: Floats, start: Floats, value: Floats, out: Floats) -> None:
    """The largest value that may hold on the way from each pose to the next, (n - 1,).

    value[r] holds from place start[r] to start[r + 1]. The way leads to places of the next pose from the last places
    of this one that lie before them.
    """
    r, count = 0, len(value)
    # The larger of each two, of each two of these, ...: those from any to any other are the largest of a few.
    larger = np.empty(2 * count)
    larger[count:] = value
    for b in range(count - 1, 0, -1):
        larger[b] = max(larger[2 * b], larger[2 * b + 1])
    for k in range(len(begin) - 2):
        i, stop = begin[k], begin[k + 1]
        most = 0.0
        for j in range(begin[k + 1], begin[k + 2]):
            while i + 1 < stop and low[i + 1] <= high[j]:
                i += 1
            lowest = low[j]
            if i < stop:
                lowest = min(low[i], lowest)
            r = stretch_before(start, lowest, r)
            last = stretch_before(start, np.nextafter(high[j], np.inf), r)
            first, last = r + count, last + count + 1
            while first < last:
                if first % 2:
                    most = max(most, larger[first])
                    first += 1
                if last % 2:
                    last -= 1
                    most = max(most, larger[last])
                first, last = first // 2, last // 2
        out[k] = most


@jit()
def named(begin: Ints, low: Floats, high: Floats, start: Floats, value: Ints, asked: Ints, found: Bools) -> None:
    """Whether the value asked for each pose is one of those that hold at its places; value[r] holds from start[r] to
    start[r + 1]."""
    r, count = 0, len(value)
    # stretches of one value after those of another, each in their order
    order, first = np.argsort(value), 0
    for at in range(1, count + 1):
        if at == count or value[order[at]] != value[order[first]]:
            order[first:at] = np.sort(order[first:at])
            first = at
    for k in range(len(begin) - 1):
        found[k] = False
        for j in range(begin[k], begin[k + 1]):
            r = stretch_before(start, low[j], r)
            last = stretch_before(start, np.nextafter(high[j], np.inf), r)
            if value[r] == asked[k]:
                found[k] = True
                break
            # the first with this value that is not before r
            below, above = 0, count
            while below < above and last > r:
                middle = (below + above) // 2
                there = order[middle]
                if value[there] < asked[k] or (value[there] == asked[k] and there < r):
                    below = middle + 1
                else:
                    above = middle
            if last > r and below < count and value[order[below]] == asked[k] and order[below] <= last:
                found[k] = True
                break
