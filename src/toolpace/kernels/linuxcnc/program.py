"""All blocks of a program, from cycle to cycle."""

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
    FINAL,
    LENGTH,
    PERIOD,
    SPEED,
    SPLIT,
    TANGENT,
    Blocks,
    Control,
    acceleration_of,
    most_speed,
)
from toolpace.kernels.linuxcnc.cycle import step
from toolpace.kernels.linuxcnc.queue import put


@jit()
def cycles_of(b: Blocks, control: Control) -> Ints:
    """(n,) cycle in which each block has ended."""
    n = len(b.length)
    q = np.zeros((2 * n + 2, COLUMNS))
    ended = np.zeros(n, dtype=np.int64)
    head = tail = fed = clock = 0
    waiting = False
    while True:
        if fed < n and not waiting:
            tail = put(b, fed, q, head, tail, control)
            waiting = b.wait[fed] >= 0.0
            fed += 1
        if head == tail:
            if not waiting or fed == n:
                break
            clock += control.latency + math.ceil(b.wait[fed - 1] / control.cycle - 1e-9)
            waiting = False
            continue
        gone = step(b, q, head, tail, control)
        clock += 1
        if gone:
            ended[int(q[head, BLOCK])] = clock
            head += 1
        elif fed == n or waiting:
            clock += cruise(q, head, control)
    return ended


@jit()
def cruise(q: Floats, k: int, control: Control) -> int:
    """Cycles that a segment goes on as it is, at its most speed, far from its end; they are done at once."""
    v = q[k, SPEED]
    if q[k, SPLIT] or v <= 0.0 or v != most_speed(q, k, control, 1.0) or q[k, PERIOD] != control.cycle:
        return 0
    a = acceleration_of(q, k)
    half = 0.5 * a * control.cycle
    final = q[k, FINAL] if q[k, ENDING] == TANGENT else 0.0
    braking = max(((v + half) ** 2 - min(final, v) ** 2 - half**2) / (2.0 * a), 0.0) + v * control.cycle
    count = int((q[k, LENGTH] - q[k, DONE] - braking) / (v * control.cycle)) - 2
    if count <= 0:
        return 0
    q[k, DONE] += count * v * control.cycle
    return count
