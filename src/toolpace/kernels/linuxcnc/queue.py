"""A block comes into the queue: it meets the one before, corners are rounded, speeds are planned backwards."""

from __future__ import annotations

import math

from toolpace.kernels.arrays import Floats
from toolpace.kernels.jit import jit
from toolpace.kernels.linuxcnc.blocks import (
    ACCELERATION,
    ARC,
    ASKED,
    BEGIN,
    BLOCK,
    COLUMNS,
    DONE,
    END,
    ENDING,
    EXACT,
    FINAL,
    FIXED,
    KIND,
    KINK,
    KINK_AFTER,
    KINK_BEFORE,
    LENGTH,
    LINE,
    NOMINAL,
    OF_ACCELERATION,
    OF_ASKED,
    OF_ENDING,
    OF_KIND,
    OF_LENGTH,
    OF_RADIUS,
    OF_RAPID,
    OF_SWEEP,
    OF_TOLERANCE,
    OF_TOP,
    OF_TURNS,
    OVERLAPPED,
    OVERLAPPING,
    OVERLAPS,
    PEAK,
    PERIOD,
    RADIUS,
    RAPID,
    REST,
    RISE,
    ROUNDING,
    SIDEWAYS,
    SPLIT,
    SWEEP,
    TANGENT,
    TANGENT_SHARE,
    TANGENTIAL,
    TOLERANCE,
    TOP,
    TURNS,
    Blocks,
    Control,
    acceleration_of,
    end_with,
    most_speed,
)
from toolpace.kernels.linuxcnc.overlap import overlap_speeds
from toolpace.kernels.linuxcnc.rounding import Rounding, no_rounding, round_corner
from toolpace.kernels.linuxcnc.vectors import along, dot, from_to, of_block

SHARP = (math.pi * 2.0 / 180.0) ** 2
"""Corners that turn back within two degrees: squared sum of unit vectors."""
SHORTEST = 1.02
"""Cycles of the shortest segment."""
PEAKS = 4
"""Peaks of the plan behind which looking back ends."""
BEGUN = 0.25
"""Share of a segment that is done from which on its end is not planned anew."""


@jit()
def put(b: Blocks, j: int, q: Floats, head: int, tail: int, control: Control) -> int:
    """Append block j to segments head to tail; the new tail."""
    begin(b, j, q, tail, control)
    if tail == head:
        return tail + 1
    k, new = tail - 1, tail
    if q[k, RAPID] != b.figures[j, OF_RAPID]:
        end_with(q, k, new, REST)
    rounded, taken, rounding = meet(b, q, k, new, control)
    if rounded:
        at = k if taken else new
        if not taken:
            new = tail + 1
            copy(q, tail, new)
            fix(q, k, control)
        block, rapid, rest = q[k, BLOCK], q[k, RAPID], rounding.first
        clear(q, at)
        q[at, BLOCK], q[at, RAPID], q[at, KIND], q[at, ENDING] = block, rapid, ROUNDING, TANGENT
        q[at, LENGTH] = rounding.radius * rounding.angle + (rest if taken else 0.0)
        q[at, NOMINAL], q[at, TOP], q[at, ASKED] = q[at, LENGTH], rounding.speed, rounding.asked
        q[at, ACCELERATION], q[at, TANGENT_SHARE] = rounding.acceleration, TANGENTIAL
        q[at, KINK], q[at, PERIOD] = -1.0, control.cycle
        fix(q, at, control)
    else:
        fix(q, k, control)
    look_back(q, head, new + 1, control)
    return new + 1


@jit(inline=True)
def begin(b: Blocks, j: int, q: Floats, new: int, control: Control) -> None:
    """A segment of block j as the interpreter gives it."""
    clear(q, new)
    q[new, BLOCK], q[new, KIND], q[new, ENDING] = j, b.figures[j, OF_KIND], b.figures[j, OF_ENDING]
    q[new, RAPID] = b.figures[j, OF_RAPID]
    q[new, TURNS] = b.figures[j, OF_TURNS]
    q[new, LENGTH] = q[new, NOMINAL] = b.figures[j, OF_LENGTH]
    q[new, ASKED], q[new, TOP] = b.figures[j, OF_ASKED], b.figures[j, OF_TOP]
    q[new, ACCELERATION] = b.figures[j, OF_ACCELERATION]
    q[new, TANGENT_SHARE], q[new, TOLERANCE], q[new, KINK] = TANGENTIAL, b.figures[j, OF_TOLERANCE], -1.0
    q[new, PERIOD] = control.cycle
    q[new, SWEEP] = b.figures[j, OF_SWEEP]
    q[new, TOP] = min(q[new, TOP], q[new, LENGTH] / control.cycle)
    if q[new, KIND] == ARC:
        # a helix counts as wider, by all of its rise
        radius, rise = b.figures[j, OF_RADIUS], of_block(b, j, RISE)
        q[new, RADIUS] = radius + dot(rise, rise) / radius
        q[new, TOP] = min(q[new, TOP], math.sqrt(SIDEWAYS * q[new, ACCELERATION] * q[new, RADIUS]))


@jit()
def clear(q: Floats, k: int) -> None:
    for column in range(COLUMNS):
        q[k, column] = 0.0


@jit()
def copy(q: Floats, k: int, to: int) -> None:
    for column in range(COLUMNS):
        q[to, column] = q[k, column]


@jit()
def bend(q: Floats, k: int) -> None:
    """Limit an arc's speed by its normal acceleration; what that leaves is for changes of speed."""
    if q[k, KIND] != ARC:
        return
    most = q[k, ACCELERATION] * (1.0 - max(q[k, KINK_AFTER], q[k, KINK_BEFORE]))
    if q[k, OVERLAPS] or q[k, ENDING] == OVERLAPPED:
        most *= 0.5
    needed = q[k, TOP] ** 2 / q[k, RADIUS]
    q[k, TANGENT_SHARE] = TANGENTIAL
    if needed > SIDEWAYS * most:
        q[k, TOP] = math.sqrt(SIDEWAYS * most * q[k, RADIUS])
    else:
        q[k, TANGENT_SHARE] = math.sqrt(1.0 - (needed / most) ** 2)


@jit()
def fix(q: Floats, k: int, control: Control) -> None:
    """The length of a segment is final, now that it has met the next."""
    if q[k, FIXED]:
        return
    q[k, TOP] = min(q[k, TOP], q[k, LENGTH] / control.cycle)
    bend(q, k)
    q[k, FIXED] = 1.0


@jit(inline=True)
def meet(b: Blocks, q: Floats, k: int, new: int, control: Control) -> tuple[bool, bool, Rounding]:
    """Choose how segment k meets the new one: whether by a rounding, whether k is part of it then, and which."""
    none = no_rounding()
    if q[k, DONE] > 0.5 * q[k, LENGTH] or q[k, TURNS] or q[new, TURNS] or q[k, ENDING] == REST:
        return False, False, none
    j, j_new = int(q[k, BLOCK]), int(q[new, BLOCK])
    if pass_straight(b, q, k, new, j, j_new, control):
        return False, False, none
    if q[k, ENDING] == OVERLAPPED and not q[k, FIXED]:
        found, rounding = round_corner(b, q, k, new, j, j_new, control)
        if found:
            left = rounding.first if q[k, KIND] == LINE else 1.0
            taken = q[k, KIND] == LINE and not q[k, OVERLAPS] and left < control.gap * control.cycle * rounding.speed
            length = rounding.radius * rounding.angle + (left if taken else 0.0)
            if choose(b, q, k, new, min(rounding.speed, length / control.cycle), control):
                shorten(q, k, rounding.first)
                shorten(q, new, rounding.second)
                end_with(q, k, new, TANGENT)
                return True, taken, rounding
    choose(b, q, k, new, 0.0, control)
    return False, False, none


@jit(inline=True)
def shorten(q: Floats, k: int, rest: float) -> None:
    """Cut a segment where its rounding begins, to a length or, of an arc, to a sweep."""
    if q[k, KIND] == ARC:
        q[k, LENGTH] *= rest / q[k, SWEEP]
        q[k, SWEEP] = rest
    else:
        q[k, LENGTH] = rest


@jit(inline=True)
def pass_straight(b: Blocks, q: Floats, k: int, new: int, j: int, j_new: int, control: Control) -> bool:
    """Whether the corner needs nothing: it is sharp and is met at rest, or so flat that it is passed at speed.

    Else the speed is noted at which it could be passed, and what that takes of the acceleration.
    """
    before, behind = of_block(b, j, END), of_block(b, j_new, BEGIN)
    turn, back = from_to(before, behind), along(before, 1.0, behind)
    if dot(back, back) < SHARP:
        end_with(q, k, new, REST)
        return True
    speed = min(most_speed(q, k, control, control.override), most_speed(q, new, control, control.override))
    jump = speed / control.cycle + q[new, ACCELERATION]
    share = 0.0
    for i in range(3):
        share = max(share, abs(turn[i]) * jump / control.acceleration[i])
    if q[k, KIND] == ARC or q[new, KIND] == ARC:
        share /= TANGENTIAL
    flat = share < control.kink
    if flat:
        end_with(q, k, new, TANGENT)
    q[k, KINK] = speed if flat else speed * control.kink / share
    taken = min(share, control.kink)
    q[k, KINK_AFTER], q[new, KINK_BEFORE] = max(taken, q[k, KINK_AFTER]), max(taken, q[new, KINK_BEFORE])
    return flat


@jit()
def choose(b: Blocks, q: Floats, k: int, new: int, rounding: float, control: Control) -> bool:
    """Whether a rounding at its speed is the fastest; else the faster of an overlap and a kink is set."""
    if q[k, ENDING] == EXACT or q[k, ENDING] == REST:
        return False
    goal = most_speed(q, k, control, control.override)
    goal_new = most_speed(q, new, control, control.override)
    # an overlap slows its neighbours down as well: half its speed is what it is worth
    overlap = 0.5 * overlap_speeds(b, q, k, new, goal, goal_new)[2]
    kink = q[k, KINK]
    if rounding > overlap and rounding > kink:
        straighten(q, k, new)
        return True
    if kink > overlap:
        end_with(q, k, new, TANGENT)
    else:
        straighten(q, k, new)
        end_with(q, k, new, OVERLAPPED)
    return False


@jit()
def straighten(q: Floats, k: int, new: int) -> None:
    """No kink is left between two segments."""
    q[k, KINK], q[k, KINK_AFTER], q[new, KINK_BEFORE] = -1.0, 0.0, 0.0


@jit()
def look_back(q: Floats, head: int, tail: int, control: Control) -> None:
    """Plan final speeds from the end of the queue backwards, as deep as the control looks ahead."""
    peaks = 0
    past = False
    for x in range(1, control.depth + 2):
        s = tail - x
        k = s - 1
        if k < head:
            return
        if q[k, ENDING] != TANGENT:
            if past:
                return
            past = True
            continue
        if q[k, DONE] >= BEGUN * q[k, LENGTH] or q[k, SPLIT] or q[k, OVERLAPPING]:
            return
        if q[s, FIXED]:
            plan_end(q, k, s, control)
        else:
            # up to half of the last segment may still be cut: stop in the middle of it
            half = math.sqrt(acceleration_of(q, s) * q[s, LENGTH])
            q[k, FINAL] = min(q[k, TOP], min(half, most_speed(q, s, control, control.override)))
            q[s, FINAL] = 0.0
        if q[s, PEAK]:
            peaks += 1
        if peaks > PEAKS:
            return


@jit(inline=True)
def plan_end(q: Floats, k: int, s: int, control: Control) -> None:
    """Most final speed of segment k from which the next, s, gets down to its own."""
    speed = math.sqrt(q[s, FINAL] ** 2 + 2.0 * acceleration_of(q, s) * q[s, LENGTH])
    most = min(q[s, TOP], q[k, TOP])
    if q[k, KINK] >= 0.0:
        most = min(most, q[k, KINK])
    if speed >= most:
        speed = most
        q[k, PEAK] = 1.0
    q[k, FINAL] = speed
    q[s, TOP] = min(q[s, TOP], q[s, LENGTH] / (SHORTEST * control.cycle))
