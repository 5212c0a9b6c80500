"""The times at which the blocks of a program end, from LinuxCNC's planner with limited jerk (PLANNER_TYPE = 1).

An S-curve for each segment of the queue; where segments overlap, the next begins when this one is slow enough.
"""

from __future__ import annotations

import math

import numpy as np

from toolpace.kernels.arrays import Floats
from toolpace.kernels.jerk_ramp import peak_speed, reachable_speed
from toolpace.kernels.jit import jit
from toolpace.kernels.linuxcnc.blocks import (
    ACCELERATION,
    BLOCK,
    COLUMNS,
    ENDING,
    FINAL,
    JERK,
    KIND,
    KINK_AFTER,
    KINK_BEFORE,
    LENGTH,
    LINE,
    OF_WAIT,
    OVERLAPPED,
    TANGENT,
    TANGENT_SHARE,
    Blocks,
    Control,
    most_speed,
)
from toolpace.kernels.linuxcnc.limited_jerk import last_time, s_curve_time
from toolpace.kernels.linuxcnc.meeting import overlap_speeds
from toolpace.kernels.linuxcnc.queue import put

ROUNDING = 1e-6
"""Share of a cycle by which a motion may seem to end behind it."""


@jit()
def s_curve_ends(b: Blocks, control: Control) -> Floats:
    """(n,) when each block has ended [s]; nan from a block on that never would."""
    n = len(b.figures)
    q = np.zeros((2 * n + 2, COLUMNS))
    ended = np.zeros(n)
    head = tail = 0
    clock = 0.0
    for j in range(n):
        tail = put(b, j, q, head, tail, control)
        wait = b.figures[j, OF_WAIT]
        if wait >= 0.0 or j + 1 == n:
            clock = run(b, q, head, tail, control, clock, ended)
            if not clock < math.inf:
                ended[int(q[head, BLOCK]) :] = math.nan
                break
            if wait >= 0.0:
                clock += math.ceil(wait / control.cycle - 1e-9) * control.cycle
            head = tail
    return ended


@jit()
def run(b: Blocks, q: Floats, head: int, tail: int, control: Control, clock: float, ended: Floats) -> float:
    """Go through segments from rest to rest; when the last has ended [s]."""
    speed = 0.0
    for k in range(head, tail):
        after = k + 1 < tail
        share = 1.0 - max(q[k, KINK_AFTER], q[k, KINK_BEFORE])
        acceleration = q[k, ACCELERATION] * share * (1.0 if q[k, KIND] == LINE else q[k, TANGENT_SHARE])
        jerk, top = min(q[k, JERK], control.jerk), most_speed(q, k, control, 1.0)
        if not (top > 0.0 and acceleration > 0.0 and jerk > 0.0):
            return math.inf
        final = 0.0
        if after and q[k, ENDING] == TANGENT:
            final = min(q[k, FINAL], top, most_speed(q, k + 1, control, 1.0))
            final = min(final, reachable_speed(speed, q[k, LENGTH], acceleration, jerk))
        speed = min(speed, max(top, final))
        peak = peak_speed(speed, final, q[k, LENGTH], top, acceleration, jerk, acceleration, jerk)
        end = clock + s_curve_time(speed, final, peak, q[k, LENGTH], acceleration, jerk)
        speed = final
        if q[k, ENDING] != TANGENT or not after:
            end = math.ceil(end / control.cycle - ROUNDING) * control.cycle
        ended[int(q[k, BLOCK])] = max(end, ended[int(q[k, BLOCK]) - 1] if q[k, BLOCK] > 0 else 0.0)
        clock = end
        if after and q[k, ENDING] == OVERLAPPED:
            goal, goal_after = top, most_speed(q, k + 1, control, 1.0)
            slow = min(overlap_speeds(b, q, k, k + 1, goal, goal_after, control)[0], peak)
            cycles = math.floor(last_time(slow, acceleration, jerk) / control.cycle) + 1
            clock = end - cycles * control.cycle
    return float(max(clock, ended[int(q[tail - 1, BLOCK])]))
