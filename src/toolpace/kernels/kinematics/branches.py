"""Which rotary solution and which turn of each joint, along a whole path: linear-time dynamic programming.

A state is a solution (two of them) and the whole turns added to each joint whose travel is limited; a joint
without end has one slot, and its turns follow from the way there. Cost is rotary motion in radians. From a
state the path goes on by the nearest angles of either solution, if the joints moving in proportion keep
near the great circle between the two tool axes; anything else is a jump, which costs more than all motion
together.

    the states at the first point
    point by point: the ways from the point before     ways_between
                    each state on by them              go_on
                    the cheapest state by a jump       jump
    back from the cheapest state at the last point     trace_back
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from toolpace.kernels.arrays import Bools, Floats, Ints
from toolpace.kernels.jit import jit
from toolpace.kernels.kinematics.chain import turn
from toolpace.kernels.kinematics.geometry import A0, U1, U2

TURN = 2.0 * math.pi
SLACK = 1e-9
JUMP = 1e7
"""Cost of a jump while cutting; it always ends in an error."""
JUMP_RAPID = 1e2
"""Cost of a jump on a rapid move, where the joints may be repositioned."""
HOME = 1e-3
"""Weight of the distance from joint zero at the start, to choose among equals."""

Links = npt.NDArray[np.int32]


class Points(NamedTuple):
    """The points of a path, and both rotary solutions at each."""

    axis: Floats
    """(n, 3) unit tool axes."""
    angles: Floats
    """(n, 2, 2) [point, solution, joint] [rad]"""
    penalty: Floats
    """(n, 2) cost of each solution; inf where it is out of the question."""
    bridged: Bools
    """(n,) a pole lies before the point, where the first joint may turn freely."""
    rapid: Bools
    """(n,) the point is reached without cutting."""


class Turns(NamedTuple):
    """The turns of both rotary joints that are looked at."""

    travel: Floats
    """(2, 2) lowest and highest position of each joint [rad]."""
    endless: Bools
    """(2,)"""
    first: Ints
    """(2,) whole turns of the first slot."""
    slots: Ints
    """(2,) number of slots; one for an endless joint."""


class States(NamedTuple):
    """The states at one point: number (solution * slots[0] + slot of R1) * slots[1] + slot of R2."""

    cost: Floats
    """(states,) least cost up to there; inf where the path does not get there."""
    value: Floats
    """(states, 2) joint positions, with all turns of endless joints."""


class Trace(NamedTuple):
    """How each state of each point is reached."""

    before: Links
    """(n, states) from which state at the point before; -1 at the first."""
    jumped: Bools
    """(n, states) whether by a jump."""


class Ways(NamedTuple):
    """The ways between two points, [solution before, solution after, way]: nearest angles, and the other way round."""

    change: Floats
    """(2, 2, 2, 2) of each joint."""
    fine: Bools
    """(2, 2, 2) whether the way may be taken."""


@jit()
def wrapped(angle: float) -> float:
    """The angle less whole turns, in [-pi, pi]."""
    rest: float = angle - TURN * np.round(angle / TURN)
    return rest


@jit()
def strays(
    frame: Floats, from_angles: Floats, change: Floats, axis: Floats, next_axis: Floats, scratch: Floats
) -> bool:
    """Whether joints moving by `change` (2,) leave the great circle between two axes by its length."""
    t1 = from_angles[0] + 0.5 * change[0]
    t2 = from_angles[1] + 0.5 * change[1]
    turn(frame[U2], math.sin(t2), math.cos(t2), frame[A0], scratch)
    turn(frame[U1], math.sin(t1), math.cos(t1), scratch, scratch)
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
def slot_of(turns: Turns, joint: int, value: float, angle: float) -> int:
    """Slot of a joint position that is `angle` but for whole turns; -1 where travel or the slots end."""
    if turns.endless[joint]:
        return 0
    if value < turns.travel[joint, 0] - SLACK or value > turns.travel[joint, 1] + SLACK:
        return -1
    slot = int(np.round((value - angle) / TURN)) - turns.first[joint]
    return slot if 0 <= slot < turns.slots[joint] else -1


@jit()
def slots_of(turns: Turns, state: int) -> tuple[int, int, int]:
    """Solution and slots of both joints of a state."""
    k1, k2 = turns.slots[0], turns.slots[1]
    return state // (k1 * k2), (state // k2) % k1, state % k2


@jit()
def in_slot(turns: Turns, joint: int, slot: int, angle: float) -> float:
    """Joint position that is `angle` but for the whole turns of a slot; of an endless joint the angle itself."""
    return angle if turns.endless[joint] else angle + TURN * (turns.first[joint] + slot)


@jit()
def positions(points: Points, turns: Turns, i: int, state: int) -> tuple[int, float, float]:
    """Solution and joint positions of a state at point i; solution -1 where there is no such state."""
    side, j1, j2 = slots_of(turns, state)
    first, second = points.angles[i, side, 0], points.angles[i, side, 1]
    v1, v2 = in_slot(turns, 0, j1, first), in_slot(turns, 1, j2, second)
    possible = points.penalty[i, side] < np.inf
    if possible and slot_of(turns, 0, v1, first) >= 0 and slot_of(turns, 1, v2, second) >= 0:
        return side, v1, v2
    return -1, v1, v2


@jit()
def cheapest(cost: Floats) -> int:
    """The first of the states of least cost."""
    best = 0
    for state in range(len(cost)):
        if cost[state] < cost[best]:
            best = state
    return best


@jit()
def offer(after: States, trace: Trace, i: int, target: int, total: float, v1: float, v2: float, state: int) -> bool:
    """Reach a state of point i at joint positions (v1, v2) from one before, if that costs less than what is known."""
    if not total < after.cost[target]:
        return False
    after.cost[target] = total
    after.value[target, 0] = v1
    after.value[target, 1] = v2
    trace.before[i, target] = state
    return True


@jit()
def start(points: Points, turns: Turns, after: States, trace: Trace) -> None:
    """The states at the first point: the nearer the joints are to zero, the better."""
    for state in range(len(after.cost)):
        side, v1, v2 = positions(points, turns, 0, state)
        if side >= 0:
            offer(after, trace, 0, state, points.penalty[0, side] + HOME * (abs(v1) + abs(v2)), v1, v2, -1)


@jit()
def ways_between(frame: Floats, points: Points, turns: Turns, i: int, ways: Ways, scratch: Floats) -> None:
    """The ways from point i - 1 to point i."""
    angles, penalty = points.angles, points.penalty
    for s in range(2):
        for r in range(2):
            near = wrapped(angles[i, r, 0] - angles[i - 1, s, 0])
            ways.change[s, r, 0, 0] = near
            # The other way round can be right where the first joint swings far, close to the pole.
            ways.change[s, r, 1, 0] = near - TURN if near > 0.0 else near + TURN
            ways.change[s, r, :, 1] = wrapped(angles[i, r, 1] - angles[i - 1, s, 1])
            possible = penalty[i, r] < np.inf and penalty[i - 1, s] < np.inf
            for way in range(2):
                fine = possible and (way == 0 or (not turns.endless[0] and abs(near) > 0.5 * math.pi))
                if fine and not points.bridged[i]:
                    change = ways.change[s, r, way]
                    fine = not strays(frame, angles[i - 1, s], change, points.axis[i - 1], points.axis[i], scratch)
                ways.fine[s, r, way] = fine


@jit()
def go_on(points: Points, turns: Turns, i: int, ways: Ways, now: States, after: States, trace: Trace) -> None:
    """Reach the states at point i from those before, by the ways between."""
    for state in range(len(now.cost)):
        if not now.cost[state] < np.inf:
            continue
        before, _, _ = slots_of(turns, state)
        for side in range(2):
            for way in range(2):
                if ways.fine[before, side, way]:
                    land(points, turns, i, state, side, ways.change[before, side, way], now, after, trace)


@jit()
def land(
    points: Points, turns: Turns, i: int, state: int, side: int, change: Floats,
    now: States, after: States, trace: Trace,
) -> None:  # fmt: skip
    """Reach a solution at point i from a state before by a change (2,); after a pole, any turn of the first joint."""
    first = points.angles[i, side, 0]
    v1 = now.value[state, 0] + change[0]
    v2 = now.value[state, 1] + change[1]
    j2 = slot_of(turns, 1, v2, points.angles[i, side, 1])
    if j2 < 0:
        return
    free = points.bridged[i] and not turns.endless[0]
    low = 0 if free else slot_of(turns, 0, v1, first)
    high = turns.slots[0] if free else low + 1
    for j1 in range(max(low, 0), high):
        if free:
            v1 = in_slot(turns, 0, j1, first)
            if slot_of(turns, 0, v1, first) < 0:
                continue
        total = now.cost[state] + points.penalty[i, side]
        total = total + abs(v1 - now.value[state, 0]) + abs(v2 - now.value[state, 1])
        offer(after, trace, i, (side * turns.slots[0] + j1) * turns.slots[1] + j2, total, v1, v2, state)


@jit()
def jump(points: Points, turns: Turns, i: int, now: States, after: States, trace: Trace) -> None:
    """Reach the states at point i from the cheapest one before, whatever lies between."""
    best = cheapest(now.cost)
    at1, at2 = now.value[best, 0], now.value[best, 1]
    for state in range(len(after.cost)):
        side, v1, v2 = positions(points, turns, i, state)
        if side < 0:
            continue
        if turns.endless[0]:
            v1 = at1 + wrapped(v1 - at1)
        if turns.endless[1]:
            v2 = at2 + wrapped(v2 - at2)
        total = now.cost[best] + points.penalty[i, side] + (JUMP_RAPID if points.rapid[i] else JUMP)
        total += abs(v1 - at1) + abs(v2 - at2)
        if offer(after, trace, i, state, total, v1, v2, best):
            trace.jumped[i, state] = True


@jit()
def trace_back(points: Points, turns: Turns, state: int, trace: Trace, chosen: Floats, jumps: Bools) -> None:
    """The joint positions `chosen` (n, 2) on the way to a state at the last point, and where it jumps."""
    n = len(points.angles)
    order = np.empty(n, np.int64)
    for i in range(n - 1, -1, -1):
        order[i] = state
        jumps[i] = trace.jumped[i, state]
        state = trace.before[i, state]
    for i in range(n):
        side, j1, j2 = slots_of(turns, order[i])
        chosen[i, 0] = in_slot(turns, 0, j1, points.angles[i, side, 0])
        chosen[i, 1] = in_slot(turns, 1, j2, points.angles[i, side, 1])
        for joint in range(2):
            if turns.endless[joint] and i > 0:
                chosen[i, joint] = chosen[i - 1, joint] + wrapped(chosen[i, joint] - chosen[i - 1, joint])


@jit()
def choose(frame: Floats, points: Points, turns: Turns, chosen: Floats, jumps: Bools) -> bool:
    """Joint positions `chosen` (n, 2) along the path, and where (n,) it jumps; False where some point has no state."""
    n = len(points.angles)
    count = 2 * turns.slots[0] * turns.slots[1]
    now = States(np.empty(count), np.zeros((count, 2)))
    after = States(np.empty(count), np.zeros((count, 2)))
    ways = Ways(np.empty((2, 2, 2, 2)), np.empty((2, 2, 2), np.bool_))
    trace = Trace(np.full((n, count), -1, np.int32), np.zeros((n, count), np.bool_))
    scratch = np.empty(3)
    for i in range(n):
        after.cost[:] = np.inf
        if i == 0:
            start(points, turns, after, trace)
        else:
            ways_between(frame, points, turns, i, ways, scratch)
            go_on(points, turns, i, ways, now, after, trace)
            jump(points, turns, i, now, after, trace)
        now, after = after, now
        if not now.cost[cheapest(now.cost)] < np.inf:
            return False
    trace_back(points, turns, cheapest(now.cost), trace, chosen, jumps)
    return True
