"""Which rotary solution and which turn of each joint, along a whole path: linear-time dynamic programming.

A state is a solution (two of them) and the whole turns added to each joint whose travel is limited; a joint
without end has one slot, and its turns follow from the way there. Cost is rotary motion in radians. From a
state the path goes on by the nearest angles of either solution, if the joints moving in proportion keep
near the great circle between the two tool axes; anything else is a jump, which costs more than all motion
together.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from toolpace.kernels.jit import jit
from toolpace.kernels.kinematics.chain import turn

TURN = 2.0 * math.pi
SLACK = 1e-9
JUMP = 1e7
"""Cost of a jump while cutting; it always ends in an error."""
JUMP_RAPID = 1e2
"""Cost of a jump on a rapid move, where the joints may be repositioned."""
HOME = 1e-3
"""Weight of the distance from joint zero at the start, to choose among equals."""


@jit()
def wrapped(angle: float) -> float:
    """The angle less whole turns, in [-pi, pi]."""
    rest: float = angle - TURN * np.round(angle / TURN)
    return rest


@jit()
def strays(frame: Any, from_angles: Any, change: Any, axis: Any, next_axis: Any, scratch: Any) -> bool:
    """Whether joints moving by `change` (2,) leave the great circle between two axes by its length."""
    t1 = from_angles[0] + 0.5 * change[0]
    t2 = from_angles[1] + 0.5 * change[1]
    turn(frame[1], math.sin(t2), math.cos(t2), frame[2], scratch)
    turn(frame[0], math.sin(t1), math.cos(t1), scratch, scratch)
    chord = 0.0
    middle = 0.0
    for d in range(3):
        chord += (next_axis[d] - axis[d]) ** 2
        middle += (axis[d] + next_axis[d]) ** 2
    middle = math.sqrt(middle)
    if middle < 1e-6:
        return False
    off = 0.0
    for d in range(3):
        off += (scratch[d] - (axis[d] + next_axis[d]) / middle) ** 2
    return math.sqrt(off) > math.sqrt(chord) + 1e-3


@jit()
def slot_of(value: float, base: float, travel: Any, first_turn: int, slots: int) -> int:
    """Slot of a joint position whose angle is `base`; -1 where travel or the slots end."""
    if value < travel[0] - SLACK or value > travel[1] + SLACK:
        return -1
    slot = int(np.round((value - base) / TURN)) - first_turn
    return slot if 0 <= slot < slots else -1


@jit()
def choose(
    frame: Any,
    axis: Any,
    angles: Any,
    penalty: Any,
    bridged: Any,
    rapid: Any,
    travel: Any,
    endless: Any,
    first_turn: Any,
    slots: Any,
    chosen: Any,
    jumps: Any,
) -> bool:
    """Choose among `angles` (n, 2, 2) with `penalty` (n, 2), inf where a solution is out of the question.

    `bridged` (n,): a pole lies before the point, where the first joint may turn freely; `rapid` (n,): the
    point is reached without cutting; `travel` (2, 2), `endless` (2,), `first_turn` (2,), `slots` (2,) of
    the joints. Writes `chosen` (n, 2) and `jumps` (n,); returns False where no state exists at some point.
    """
    n = len(angles)
    k1, k2 = slots[0], slots[1]
    states = 2 * k1 * k2
    cost = np.full(states, np.inf)
    value = np.zeros((states, 2))
    new_cost = np.empty(states)
    new_value = np.zeros((states, 2))
    came = np.full((n, states), -1, np.int32)
    jumped = np.zeros((n, states), np.bool_)
    change = np.empty((2, 2, 2, 2))
    bad = np.empty((2, 2, 2), np.bool_)
    scratch = np.empty(3)
    for i in range(n):
        new_cost[:] = np.inf
        if i > 0:
            for s in range(2):
                for r in range(2):
                    for way in range(2):
                        change[s, r, way, 0] = wrapped(angles[i, r, 0] - angles[i - 1, s, 0])
                        change[s, r, way, 1] = wrapped(angles[i, r, 1] - angles[i - 1, s, 1])
                    near = change[s, r, 0, 0]
                    # The other way round can be right where the first joint swings far, close to the pole.
                    change[s, r, 1, 0] = near - TURN if near > 0.0 else near + TURN
                    possible = penalty[i, r] < np.inf and penalty[i - 1, s] < np.inf
                    for way in range(2):
                        worth = possible and (way == 0 or (not endless[0] and abs(near) > 0.5 * math.pi))
                        bad[s, r, way] = not worth or (
                            not bridged[i]
                            and strays(frame, angles[i - 1, s], change[s, r, way], axis[i - 1], axis[i], scratch)
                        )
            best = 0
            for state in range(states):
                if cost[state] < cost[best]:
                    best = state
                if not cost[state] < np.inf:
                    continue
                s = state // (k1 * k2)
                for r in range(2):
                    for way in range(2):
                        if bad[s, r, way]:
                            continue
                        v1 = value[state, 0] + change[s, r, way, 0]
                        v2 = value[state, 1] + change[s, r, way, 1]
                        j2 = 0 if endless[1] else slot_of(v2, angles[i, r, 1], travel[1], first_turn[1], k2)
                        if j2 < 0:
                            continue
                        low = 0
                        high = k1
                        free = bridged[i] and not endless[0]
                        if not free and not endless[0]:
                            low = slot_of(v1, angles[i, r, 0], travel[0], first_turn[0], k1)
                            high = low + 1
                            if low < 0:
                                continue
                        for j1 in range(low, high):
                            w1 = angles[i, r, 0] + TURN * (first_turn[0] + j1) if free else v1
                            if free and slot_of(w1, angles[i, r, 0], travel[0], first_turn[0], k1) < 0:
                                continue
                            total = cost[state] + penalty[i, r] + abs(w1 - value[state, 0]) + abs(v2 - value[state, 1])
                            target = (r * k1 + j1) * k2 + j2
                            if total < new_cost[target]:
                                new_cost[target] = total
                                new_value[target, 0] = w1
                                new_value[target, 1] = v2
                                came[i, target] = state
                                jumped[i, target] = False
        for r in range(2):
            if not penalty[i, r] < np.inf:
                continue
            for j1 in range(k1):
                for j2 in range(k2):
                    v1 = angles[i, r, 0] + (0.0 if endless[0] else TURN * (first_turn[0] + j1))
                    v2 = angles[i, r, 1] + (0.0 if endless[1] else TURN * (first_turn[1] + j2))
                    if not endless[0] and slot_of(v1, angles[i, r, 0], travel[0], first_turn[0], k1) < 0:
                        continue
                    if not endless[1] and slot_of(v2, angles[i, r, 1], travel[1], first_turn[1], k2) < 0:
                        continue
                    target = (r * k1 + j1) * k2 + j2
                    if i == 0:
                        total = penalty[i, r] + HOME * (abs(v1) + abs(v2))
                        back = -1
                    else:
                        back = best
                        if endless[0]:
                            v1 = value[best, 0] + wrapped(v1 - value[best, 0])
                        if endless[1]:
                            v2 = value[best, 1] + wrapped(v2 - value[best, 1])
                        total = cost[best] + penalty[i, r] + (JUMP_RAPID if rapid[i] else JUMP)
                        total += abs(v1 - value[best, 0]) + abs(v2 - value[best, 1])
                    if total < new_cost[target]:
                        new_cost[target] = total
                        new_value[target, 0] = v1
                        new_value[target, 1] = v2
                        came[i, target] = back
                        jumped[i, target] = i > 0
        least = np.inf
        for state in range(states):
            cost[state] = new_cost[state]
            value[state, 0] = new_value[state, 0]
            value[state, 1] = new_value[state, 1]
            least = min(least, cost[state])
        if not least < np.inf:
            return False
    state = 0
    for other in range(states):
        if cost[other] < cost[state]:
            state = other
    order = np.empty(n, np.int64)
    for i in range(n - 1, -1, -1):
        order[i] = state
        jumps[i] = jumped[i, state]
        state = came[i, state]
    for i in range(n):
        state = order[i]
        r = state // (k1 * k2)
        for joint in range(2):
            base = angles[i, r, joint]
            slot = (state // k2) % k1 if joint == 0 else state % k2
            if not endless[joint]:
                chosen[i, joint] = base + TURN * (first_turn[joint] + slot)
            elif i == 0:
                chosen[i, joint] = base
            else:
                chosen[i, joint] = chosen[i - 1, joint] + wrapped(base - chosen[i - 1, joint])
    return True
