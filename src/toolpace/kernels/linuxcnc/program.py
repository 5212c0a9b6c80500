"""The servo cycles in which the blocks of a program end, from LinuxCNC's planner cycle by cycle.

In a cycle the segment at the head of the queue moves on, and the next as well where they overlap.
"""

from __future__ import annotations

import math

import numpy as np

from toolpace.kernels.arrays import Floats, Ints
from toolpace.kernels.jit import jit
from toolpace.kernels.linuxcnc.blocks import (
    BLOCK,
    COLUMNS,
    DONE,
    ENDING,
    EXACT,
    FINAL,
    GONE,
    LEAVING,
    LENGTH,
    OF_WAIT,
    OVERLAPPED,
    OVERLAPPING,
    PERIOD,
    RAMPED,
    RAPID,
    REST,
    SLOWING,
    SMALL_SPEED,
    SMALL_TIME,
    SMALL_WAY,
    SPEED,
    SPLIT,
    STARTED,
    TANGENT,
    Blocks,
    Control,
    acceleration_of,
    most_speed,
)
from toolpace.kernels.linuxcnc.meeting import overlap_speeds
from toolpace.kernels.linuxcnc.queue import put


@jit()
def cycles_of(b: Blocks, control: Control) -> Ints:
    """(n,) cycle in which each block has ended; -1 from a block on that never would."""
    n = len(b.figures)
    q = np.zeros((2 * n + 2, COLUMNS))
    ended = np.zeros(n, dtype=np.int64)
    head = tail = fed = clock = since = 0
    waiting = False
    while True:
        if fed < n and not waiting:
            tail = put(b, fed, q, head, tail, control)
            waiting = b.figures[fed, OF_WAIT] >= 0.0
            fed += 1
        if head == tail:
            if not waiting or fed == n:
                break
            clock += math.ceil(b.figures[fed - 1, OF_WAIT] / control.cycle - 1e-9)
            waiting = False
            continue
        gone = step(b, q, head, tail, control)
        clock += 1
        if gone:
            ended[int(q[head, BLOCK])] = clock
            head += 1
            since = clock
        elif fed == n or waiting:
            clock += cruise(q, head, head + 1 if head + 1 < tail else -1, control)
        if clock - since > patience(q, min(head, tail - 1), control):
            ended[int(q[head, BLOCK]) :] = -1
            break
    return ended


@jit(inline=True)
def patience(q: Floats, k: int, control: Control) -> float:
    """Cycles that a segment can take at most, many times over."""
    speed = most_speed(q, k, control, 1.0)
    if not speed > 0.0:
        return 0.0
    found: float = 1e5 + 100.0 * (q[k, LENGTH] / speed + speed / acceleration_of(q, k)) / control.cycle
    return found


@jit(inline=True)
def cruise(q: Floats, k: int, after: int, control: Control) -> int:
    """Cycles that a segment goes on as it is, at its most speed, far from its end; they are done at once."""
    v = q[k, SPEED]
    if q[k, SPLIT] or v <= 0.0 or v != most_speed(q, k, control, 1.0) or q[k, PERIOD] != control.cycle:
        return 0
    a = acceleration_of(q, k)
    half = 0.5 * a * control.cycle
    final = final_speed(q, k, after, control)
    braking = max(((v + half) ** 2 - min(final, v) ** 2 - half**2) / (2.0 * a), 0.0) + v * control.cycle
    count = int((q[k, LENGTH] - q[k, DONE] - braking) / (v * control.cycle)) - 2
    if count <= 0:
        return 0
    q[k, DONE] += count * v * control.cycle
    return count


@jit()
def step(b: Blocks, q: Floats, head: int, tail: int, control: Control) -> bool:
    """Go on for one cycle; whether the segment at the head has ended."""
    k = head
    after = k + 1 if k + 1 < tail else -1
    if not q[k, STARTED]:
        start(q, k, control)
    if q[k, SPLIT]:
        split(q, k, after, tail, control)
        return True
    q[k, PERIOD] = control.cycle
    go(q, k, after, control)
    if after >= 0 and overlapping(b, q, k, after, control):
        go(q, after, -1, control)
    return bool(q[k, GONE] != 0.0)


@jit(inline=True)
def start(q: Floats, k: int, control: Control) -> None:
    """A segment is begun: short ones at speed are ramped."""
    q[k, STARTED] = 1.0
    q[k, OVERLAPPING] = q[k, SLOWING] = 0.0
    left = q[k, LENGTH] - q[k, DONE]
    speeds = q[k, SPEED] + min(q[k, FINAL], most_speed(q, k, control, 1.0))
    quick = 2.0 * left < speeds / control.ramp_frequency
    q[k, RAMPED] = 1.0 if quick and not q[k, RAPID] and q[k, ENDING] == TANGENT and left != 0.0 else 0.0


@jit(inline=True)
def split(q: Floats, k: int, after: int, tail: int, control: Control) -> None:
    """A segment ends within the cycle; the next has what is left of it."""
    q[k, DONE] = q[k, LENGTH]
    q[k, GONE] = 1.0
    if after < 0:
        return
    if q[k, ENDING] == TANGENT:
        q[after, PERIOD] = control.cycle - q[k, PERIOD]
        q[after, SPEED] = q[k, LEAVING]
    go(q, after, after + 1 if after + 1 < tail else -1, control)


@jit(inline=True)
def overlapping(b: Blocks, q: Floats, k: int, after: int, control: Control) -> bool:
    """Whether the next segment runs beside this one: from when it slows down to its end, below the overlap's speed."""
    if q[k, ENDING] != OVERLAPPED:
        return False
    if not q[k, OVERLAPPING] and q[k, SLOWING]:
        goal, goal_after = most_speed(q, k, control, 1.0), most_speed(q, after, control, 1.0)
        if q[k, SPEED] < overlap_speeds(b, q, k, after, goal, goal_after, control)[0]:
            q[k, OVERLAPPING] = 1.0
    return bool(q[k, OVERLAPPING] != 0.0)


@jit()
def final_speed(q: Floats, k: int, after: int, control: Control) -> float:
    """At the end of a segment."""
    if q[k, ENDING] != TANGENT or after < 0:
        return 0.0
    most = min(most_speed(q, k, control, 1.0), most_speed(q, after, control, 1.0))
    found: float = min(q[k, FINAL], most)
    return found


@jit()
def go(q: Floats, k: int, after: int, control: Control) -> None:
    """Move a segment on for its period, and see whether it ends within the next."""
    final = final_speed(q, k, after, control)
    most = acceleration_of(q, k)
    period = max(q[k, PERIOD], SMALL_TIME)
    left, v = q[k, LENGTH] - q[k, DONE], q[k, SPEED]
    if q[k, RAMPED] and q[k, ENDING] == TANGENT and final >= SMALL_SPEED:
        mean = 0.5 * (v + final)
        time = max(left / mean, 1e-16) if mean > SMALL_SPEED else 1e-16
        a, aim = (final - v) / time, final
    else:
        half = 0.5 * most * q[k, PERIOD]
        rest = final * final + most * (2.0 * left - v * q[k, PERIOD])
        # so that the end is met at the final speed by whole cycles
        aim = -half + (math.sqrt(rest + half * half) if rest > 0.0 else 0.0)
        goal = most_speed(q, k, control, 1.0)
        a = (max(-goal, min(goal, aim)) - v) / period
    a = max(-most, min(most, a))
    faster = v + a * q[k, PERIOD]
    if faster < 0.0:
        faster = 0.0
        if left < v * q[k, PERIOD]:
            q[k, DONE] = q[k, LENGTH]
    else:
        q[k, DONE] = min(q[k, DONE] + 0.5 * (v + faster) * q[k, PERIOD], q[k, LENGTH])
    q[k, SPEED] = faster
    q[k, SLOWING] = 1.0 if abs(aim - faster) < SMALL_SPEED and a < 0.0 else 0.0
    look_for_end(q, k, final, most, control)


@jit(inline=True)
def look_for_end(q: Floats, k: int, final: float, most: float, control: Control) -> None:
    """Note whether the segment ends within the next cycle, when, and at what speed."""
    q[k, PERIOD] = control.cycle
    left, v = q[k, LENGTH] - q[k, DONE], q[k, SPEED]
    stops = q[k, ENDING] == REST or q[k, ENDING] == EXACT
    if left <= SMALL_WAY:
        q[k, DONE] = q[k, LENGTH]
        finish(q, k, 0.0, v)
        if stops:
            q[k, GONE] = 1.0
        return
    if stops:
        return
    mean = 0.5 * (v + final)
    if mean <= SMALL_SPEED:
        return
    time = max(0.5 * SMALL_TIME, left / mean)
    a = (final - v) / time
    if abs(a) > most:
        a = math.copysign(most, a)
        rest = (v / a) ** 2 + 2.0 * left / a
        if rest < 0.0:
            return
        time = -v / a + math.copysign(math.sqrt(rest), a)
        final = v + time * a
    if time < SMALL_TIME:
        q[k, DONE] = q[k, LENGTH]
        finish(q, k, 0.0, final)
    elif time < control.cycle:
        finish(q, k, time, final)


@jit()
def finish(q: Floats, k: int, time: float, speed: float) -> None:
    """The next cycle ends a segment, after some time of it, at a speed."""
    q[k, SPLIT], q[k, PERIOD], q[k, LEAVING] = 1.0, time, speed
