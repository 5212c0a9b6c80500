"""All blocks of a program through LinuxCNC's planner."""

from __future__ import annotations

import math

import numpy as np

from toolpace.kernels.arrays import Floats, Ints
from toolpace.kernels.jit import jit
from toolpace.kernels.linuxcnc.blocks import (
    BLOCK,
    COLUMNS,
    DONE,
    LENGTH,
    OF_WAIT,
    PERIOD,
    SPEED,
    SPLIT,
    Blocks,
    Control,
    acceleration_of,
    most_speed,
)
from toolpace.kernels.linuxcnc.cycle import final_speed, step
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
