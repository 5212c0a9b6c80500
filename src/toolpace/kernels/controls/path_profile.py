"""The speed along a chain of blocks with limited jerk: seven phases between the places where the speed is limited.

knots <- nodes at rest                                   a node is the end of a block, with its highest speed
repeat
  speeds of knots <- lowered until a ramp reaches each from its neighbours      forwards and backwards
  between two knots: ramp up, steady speed, ramp down                           acceleration zero at the knots
  where that passes a node too fast, the worst node is a knot, too
until no node is passed too fast
knots without which the motion is faster are none

A ramp may go over any number of nodes, by the least limits of the blocks that it covers. It is not quite the fastest
motion: where a limit is reached in a ramp the acceleration is zero, although it might pass that node while it rises.
"""

from __future__ import annotations

import math

import numpy as np

from toolpace.kernels.arrays import Bools, Floats, Ints
from toolpace.kernels.jerk_ramp import (
    peak_speed,
    ramp_distance,
    ramp_time,
    reachable_speed,
    speed_on_ramp,
    time_on_ramp,
)
from toolpace.kernels.jit import jit

ROUNDING = 1e-9
"""Share of a speed by which it may seem too high."""
ONE_BY_ONE = 40
"""Rounds in which one node becomes a knot between two others; after that all that are passed too fast do."""
SWEEPS = 3
"""Times that knots are tried without which the motion may be faster."""
PEAK, UP_A, UP_J, DOWN_A, DOWN_J, TIME, WORST = 0, 1, 2, 3, 4, 5, 6
"""Columns of a passage: its peak speed, limits of its two ramps, time, and the node that is passed too fast (or -1)."""


@jit()
def profile_of_chain(
    length: Floats, feed: Floats, corner: Floats, acceleration: Floats, jerk: Floats
) -> tuple[Floats, Floats]:
    """Time of each block (n,) [s], and the speed at its end (n,).

    length: (n,) [m], above zero. feed: (n,) most speed of each block. corner: (n,) most speed at its end; the first
    block begins at rest. acceleration, jerk: (n,) along each block.
    """
    n = len(length)
    place, cap = np.zeros(n + 1), np.zeros(n + 1)
    for i in range(n):
        place[i + 1] = place[i] + length[i]
        cap[i + 1] = min(corner[i], feed[i], feed[i + 1]) if i + 1 < n else min(corner[i], feed[i])
    knot, speed = cap <= 0.0, cap.copy()
    knot[0], knot[n] = True, True
    passage = np.full((n, 7), -1.0)
    current = np.zeros(n, dtype=np.bool_)
    _settle(place, cap, feed, acceleration, jerk, knot, speed, passage, current)
    for _ in range(SWEEPS):
        if not _spare_knots(place, cap, feed, acceleration, jerk, knot, speed, passage, current):
            break
    _settle(place, cap, feed, acceleration, jerk, knot, speed, passage, current)
    return _times(place, knot, speed, passage)


@jit()
def _settle(
    place: Floats, cap: Floats, feed: Floats, acceleration: Floats, jerk: Floats,
    knot: Bools, speed: Floats, passage: Floats, current: Bools,
) -> None:  # fmt: skip
    """Make knots of the nodes that are passed too fast, until there are none.

    current: (n,) whether the passage from a knot is that to the next knot as it is now.
    """
    n = len(feed)
    rounds = 0
    while True:
        knots = np.flatnonzero(knot)
        _reach(place, acceleration, jerk, knots, speed, current)
        added = False
        for k in range(len(knots) - 1):
            left, right = knots[k], knots[k + 1]
            if current[left]:
                continue
            _pass(place, cap, feed, acceleration, jerk, speed, left, right, math.inf, passage[left])
            current[left] = True
            worst = int(passage[left, WORST])
            if worst < 0:
                continue
            added = True
            for node in range(left + 1, right):
                if node == worst or (rounds > ONE_BY_ONE and _too_fast(place, cap, speed, left, right, node, passage)):
                    knot[node], speed[node], current[node] = True, cap[node], False
            current[left] = False
        rounds += 1
        if not added or rounds > n + ONE_BY_ONE:
            return


@jit()
def _reach(place: Floats, acceleration: Floats, jerk: Floats, knots: Ints, speed: Floats, current: Bools) -> None:
    """Lower the speeds of knots until a ramp reaches each from the knot before and the one behind, in place."""
    count = len(knots)
    for step in (1, -1):
        k = 0 if step == 1 else count - 1
        while 0 <= k + step < count:
            here, there = knots[k], knots[k + step]
            if speed[there] > speed[here]:
                first, last = min(here, there), max(here, there)
                most, sharpest = _least(acceleration, first, last), _least(jerk, first, last)
                distance = place[last] - place[first]
                if ramp_distance(speed[here], speed[there], most, sharpest) > distance * (1.0 + ROUNDING):
                    speed[there] = reachable_speed(speed[here], distance, most, sharpest)
                    current[first] = False
                    if there < len(current):
                        current[there] = False
                    if step == -1 and k + 2 * step >= 0:
                        current[knots[k + 2 * step]] = False
            k += step


@jit()
def _least(limit: Floats, first: int, last: int) -> float:
    """Least limit of the blocks between two nodes."""
    least = limit[first]
    for i in range(first + 1, last):
        least = min(least, limit[i])
    return float(least)


@jit()
def _pass(
    place: Floats, cap: Floats, feed: Floats, acceleration: Floats, jerk: Floats, speed: Floats,
    left: int, right: int, top: float, passage: Floats,
) -> None:  # fmt: skip
    """The fastest passage between two knots, at most `top`, into a row `passage` (7,)."""
    distance, start, end = place[right] - place[left], speed[left], speed[right]
    highest = feed[left]
    for i in range(left + 1, right):
        highest = max(highest, feed[i])
    top = min(top, highest)
    most, sharpest = _least(acceleration, left, right), _least(jerk, left, right)
    while True:
        passage[UP_A], passage[DOWN_A], passage[UP_J], passage[DOWN_J] = most, most, sharpest, sharpest
        passage[PEAK] = peak_speed(start, end, distance, top, most, sharpest, most, sharpest)
        if right - left > 1:
            _limits_of_ramps(place, acceleration, jerk, speed, left, right, top, passage)
        peak = passage[PEAK]
        up = ramp_distance(start, peak, passage[UP_A], passage[UP_J])
        down = ramp_distance(peak, end, passage[DOWN_A], passage[DOWN_J])
        passage[TIME] = ramp_time(peak - start, passage[UP_A], passage[UP_J])
        passage[TIME] += ramp_time(peak - end, passage[DOWN_A], passage[DOWN_J])
        if peak > 0.0:
            passage[TIME] += max(distance - up - down, 0.0) / peak
        passage[WORST] = -1.0
        worst, lower = 1.0 + ROUNDING, top
        for i in range(left, right):
            if i > left and peak > cap[i]:
                ratio = _speed_at(place, speed, left, right, i, passage) / cap[i]
                if ratio > worst:
                    worst, passage[WORST] = ratio, float(i)
            begins, ends = place[i] - place[left], place[i + 1] - place[left]
            if peak > feed[i] * (1.0 + ROUNDING) and begins < distance - down and ends > up:
                lower = min(lower, feed[i])
        # where only the inside of a block is too fast, its feed is the most
        if passage[WORST] >= 0.0 or lower >= top or lower < max(start, end):
            return
        top = lower


@jit()
def _limits_of_ramps(
    place: Floats, acceleration: Floats, jerk: Floats, speed: Floats, left: int, right: int, top: float, passage: Floats
) -> None:
    """Take for each ramp the least limits of those blocks alone that it covers, where it covers no others then."""
    start, end, distance = speed[left], speed[right], place[right] - place[left]
    before = passage.copy()
    for attempt in range(2):
        up = place[left] + ramp_distance(start, passage[PEAK], passage[UP_A], passage[UP_J])
        down = place[right] - ramp_distance(passage[PEAK], end, passage[DOWN_A], passage[DOWN_J])
        up_a = up_j = down_a = down_j = math.inf
        for i in range(left, right):
            if place[i] < up or i == left:
                up_a, up_j = min(up_a, acceleration[i]), min(up_j, jerk[i])
            if place[i + 1] > down or i == right - 1:
                down_a, down_j = min(down_a, acceleration[i]), min(down_j, jerk[i])
        kept = passage[UP_A] <= up_a and passage[UP_J] <= up_j and passage[DOWN_A] <= down_a
        if attempt == 1:
            if not (kept and passage[DOWN_J] <= down_j):
                passage[:] = before
            return
        passage[UP_A], passage[UP_J], passage[DOWN_A], passage[DOWN_J] = up_a, up_j, down_a, down_j
        passage[PEAK] = peak_speed(start, end, distance, top, up_a, up_j, down_a, down_j)


@jit()
def _speed_at(place: Floats, speed: Floats, left: int, right: int, node: int, passage: Floats) -> float:
    """Speed with which a passage between two knots goes over a node."""
    peak, start, end = passage[PEAK], speed[left], speed[right]
    gone, left_over = place[node] - place[left], place[right] - place[node]
    if gone < ramp_distance(start, peak, passage[UP_A], passage[UP_J]):
        return speed_on_ramp(start, peak, gone, passage[UP_A], passage[UP_J])
    if left_over < ramp_distance(peak, end, passage[DOWN_A], passage[DOWN_J]):
        return speed_on_ramp(end, peak, left_over, passage[DOWN_A], passage[DOWN_J])
    return float(peak)


@jit()
def _too_fast(
    place: Floats, cap: Floats, speed: Floats, left: int, right: int, node: int, passage: Floats
) -> bool:
    if passage[left, PEAK] <= cap[node]:
        return False
    return bool(_speed_at(place, speed, left, right, node, passage[left]) > cap[node] * (1.0 + ROUNDING))


@jit()
def _spare_knots(
    place: Floats, cap: Floats, feed: Floats, acceleration: Floats, jerk: Floats,
    knot: Bools, speed: Floats, passage: Floats, current: Bools,
) -> bool:  # fmt: skip
    """Give up knots that are not needed, or without which a steady lower speed is faster; whether there were any."""
    knots = np.flatnonzero(knot)
    tried, spared, left = np.zeros(7), False, 0
    for k in range(1, len(knots) - 1):
        middle, right = knots[k], knots[k + 1]
        if speed[middle] > max(speed[left], speed[right]) or speed[middle] < cap[middle]:
            _pass(place, cap, feed, acceleration, jerk, speed, left, right, math.inf, tried)
            if tried[WORST] >= 0.0:
                top = cap[left + 1]
                for node in range(left + 2, right):
                    top = min(top, cap[node])
                if top >= max(speed[left], speed[right]):
                    _pass(place, cap, feed, acceleration, jerk, speed, left, right, top, tried)
            if tried[WORST] < 0.0 and tried[TIME] < (passage[left, TIME] + passage[middle, TIME]) * (1.0 - ROUNDING):
                knot[middle], spared = False, True
                passage[left] = tried
                continue
        left = middle
    return spared


@jit()
def _times(place: Floats, knot: Bools, speed: Floats, passage: Floats) -> tuple[Floats, Floats]:
    """Time of each block (n,) [s] and speed at its end (n,)."""
    n = len(passage)
    times, ends = np.zeros(n), np.zeros(n)
    knots = np.flatnonzero(knot)
    for k in range(len(knots) - 1):
        left, right = knots[k], knots[k + 1]
        row = passage[left]
        peak, start, end = row[PEAK], speed[left], speed[right]
        up = ramp_distance(start, peak, row[UP_A], row[UP_J])
        down = ramp_distance(peak, end, row[DOWN_A], row[DOWN_J])
        before = 0.0
        for node in range(left + 1, right + 1):
            gone, left_over = place[node] - place[left], place[right] - place[node]
            if node == right:
                now = row[TIME]
            elif gone < up:
                now = time_on_ramp(start, peak, gone, row[UP_A], row[UP_J])
            elif left_over < down:
                now = row[TIME] - time_on_ramp(end, peak, left_over, row[DOWN_A], row[DOWN_J])
            else:
                now = ramp_time(peak - start, row[UP_A], row[UP_J]) + (gone - up) / peak
            ends[node - 1] = end if node == right else _speed_at(place, speed, left, right, node, row)
            times[node - 1] = max(now - before, 0.0)
            before = now
    return times, ends


@jit()
def stoppable_speeds(length: Floats, acceleration: Floats, jerk: Floats, depth: int) -> Floats:
    """Most speed (n,) at the end of each block, from which a ramp to rest fits into the `depth` blocks behind it."""
    n = len(length)
    speeds = np.full(n, math.inf)
    for i in range(n - depth):
        distance, most, sharpest = 0.0, math.inf, math.inf
        for k in range(i + 1, i + 1 + depth):
            distance += length[k]
            most, sharpest = min(most, acceleration[k]), min(sharpest, jerk[k])
        speeds[i] = reachable_speed(0.0, distance, most, sharpest)
    return speeds
