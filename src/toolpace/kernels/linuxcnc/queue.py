"""The queue of LinuxCNC's planner: a block enters with the corner before it, and final speeds are planned backwards."""

from __future__ import annotations

import math

from toolpace.kernels.arrays import Floats
from toolpace.kernels.jit import jit
from toolpace.kernels.linuxcnc.blocks import (
    ACCELERATION,
    ARC,
    BLOCK,
    COLUMNS,
    DONE,
    ENDING,
    FINAL,
    FIXED,
    JERK,
    KIND,
    KINK,
    KINK_AFTER,
    KINK_BEFORE,
    LENGTH,
    NOMINAL,
    OF_ACCELERATION,
    OF_ENDING,
    OF_JERK,
    OF_KIND,
    OF_LENGTH,
    OF_RADIUS,
    OF_RAPID,
    OF_REQUESTED,
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
    REQUESTED,
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
    dot,
    end_with,
    most_speed,
    of_block,
)
from toolpace.kernels.linuxcnc.limited_jerk import arc_speed, speed_at_start, speed_from_rest
from toolpace.kernels.linuxcnc.meeting import meet

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
        block, rapid, rest, jerk = q[k, BLOCK], q[k, RAPID], rounding.first, q[k, JERK]
        clear(q, at)
        q[at, BLOCK], q[at, RAPID], q[at, KIND], q[at, ENDING] = block, rapid, ROUNDING, TANGENT
        q[at, LENGTH] = rounding.radius * rounding.angle + (rest if taken else 0.0)
        q[at, NOMINAL], q[at, TOP], q[at, REQUESTED] = q[at, LENGTH], rounding.speed, rounding.requested
        q[at, ACCELERATION], q[at, TANGENT_SHARE] = rounding.acceleration, TANGENTIAL
        q[at, KINK], q[at, PERIOD] = -1.0, control.cycle
        q[at, RADIUS], q[at, SWEEP] = rounding.radius, rounding.angle
        q[at, JERK] = min(q[k, JERK], q[new, JERK]) if not taken else min(jerk, q[new, JERK])
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
    q[new, REQUESTED], q[new, TOP] = b.figures[j, OF_REQUESTED], b.figures[j, OF_TOP]
    q[new, ACCELERATION] = b.figures[j, OF_ACCELERATION]
    q[new, TANGENT_SHARE], q[new, TOLERANCE], q[new, KINK] = TANGENTIAL, b.figures[j, OF_TOLERANCE], -1.0
    q[new, PERIOD] = control.cycle
    q[new, SWEEP], q[new, JERK] = b.figures[j, OF_SWEEP], b.figures[j, OF_JERK]
    q[new, TOP] = min(q[new, TOP], q[new, LENGTH] / control.cycle)
    if q[new, KIND] == ARC:
        # a helix counts as wider, by all of its rise
        radius, rise = b.figures[j, OF_RADIUS], of_block(b, j, RISE)
        q[new, RADIUS] = radius + dot(rise, rise) / radius
        q[new, TOP] = min(q[new, TOP], math.sqrt(SIDEWAYS * q[new, ACCELERATION] * q[new, RADIUS]))
        if control.jerk > 0.0:
            bend(q, new, control)


@jit()
def clear(q: Floats, k: int) -> None:
    """Set all of a segment to zero."""
    for column in range(COLUMNS):
        q[k, column] = 0.0


@jit()
def copy(q: Floats, k: int, to: int) -> None:
    """Make a segment the same as another."""
    for column in range(COLUMNS):
        q[to, column] = q[k, column]


@jit()
def bend(q: Floats, k: int, control: Control) -> None:
    """Limit an arc's speed by its normal acceleration, and its jerk; what that leaves is for changes of speed."""
    if q[k, KIND] != ARC and not (q[k, KIND] == ROUNDING and control.jerk > 0.0):
        return
    most = q[k, ACCELERATION] * (1.0 - max(q[k, KINK_AFTER], q[k, KINK_BEFORE]))
    if q[k, OVERLAPS] or q[k, ENDING] == OVERLAPPED:
        most *= 0.5
    if control.jerk > 0.0:
        q[k, TOP] = min(q[k, TOP], arc_speed(most, q[k, RADIUS], q[k, SWEEP], control))
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
    bend(q, k, control)
    q[k, FIXED] = 1.0


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
            half = speed_from_rest(acceleration_of(q, s), q[s, JERK], q[s, LENGTH], control)
            q[k, FINAL] = min(q[k, TOP], min(half, most_speed(q, s, control, control.override)))
            if control.jerk > 0.0 and q[k, KINK] >= 0.0:
                q[k, FINAL] = min(q[k, FINAL], q[k, KINK])
            q[s, FINAL] = 0.0
        if q[s, PEAK]:
            peaks += 1
        if peaks > PEAKS:
            return


@jit(inline=True)
def plan_end(q: Floats, k: int, s: int, control: Control) -> None:
    """Most final speed of segment k from which the next, s, gets down to its own."""
    speed = speed_at_start(q[s, FINAL], acceleration_of(q, s), q[s, JERK], q[s, LENGTH], control)
    most = min(q[s, TOP], q[k, TOP])
    if q[k, KINK] >= 0.0:
        most = min(most, q[k, KINK])
    if speed >= most:
        speed = most
        q[k, PEAK] = 1.0
    if control.jerk > 0.0:
        speed = min(speed, speed_from_rest(acceleration_of(q, k), q[k, JERK], q[k, LENGTH], control))
    q[k, FINAL] = speed
    q[s, TOP] = min(q[s, TOP], q[s, LENGTH] / (SHORTEST * control.cycle))
