"""The rotary solution and turn of each point of a path, by dynamic programming in linear time.

A state is a solution (two of them) and the whole turns added to each joint whose travel is limited, counted in slots; a
joint without end has one slot, and its turns follow from the way there. Its number is
(solution * slots of R1 + slot of R1) * slots of R2 + slot of R2. Cost is rotary motion in radians. From a state the
path goes on by the nearest angles of either solution, if the joints moving in proportion keep near the great circle
between the two tool axes; anything else is a jump, which costs more than all motion together.

    point by point: which states there are             lay_out
      at the first: what each costs                    start
      at others:    the ways from the point before     ways_between
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

Links = npt.NDArray[np.int32]

TURN = 2.0 * math.pi
SLACK = 1e-9
"""How far beyond its travel a joint may be [rad]."""

JUMP = 1e7
"""Cost of a jump while cutting; it always ends in an error."""
JUMP_RAPID = 1e2
"""Cost of a jump on a rapid move, where the joints may be repositioned."""
HOME = 1e-3
"""Weight of the distance from joint zero at the start, to choose among equals."""


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
    """The states at one point."""

    cost: Floats
    """(states,) least cost up to there; inf where the path does not get there."""
    value: Floats
    """(states, 2) joint positions there, with all turns of endless joints."""
    base: Floats
    """(states, 2) joint positions in their slots; of endless joints the angles."""
    possible: Bools
    """(states,) whether solution and slots are within travel."""


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
def slot_of(value: float, angle: float, travel: Floats, first: int, slots: int) -> int:
    """Slot of a joint position that is `angle` but for whole turns; -1 where travel (2,) or the slots end."""
    if value < travel[0] - SLACK or value > travel[1] + SLACK:
        return -1
    slot = int(np.round((value - angle) / TURN)) - first
    return slot if 0 <= slot < slots else -1


@jit()
def lay_out(points: Points, turns: Turns, i: int, states: States) -> None:
    """Joint positions of the states at point i, of endless joints the angles, at infinite cost."""
    endless, travel, first, slots = turns.endless, turns.travel, turns.first, turns.slots
    cost, _, base, possible = states
    angles, penalty = points.angles, points.penalty
    state = 0
    for side in range(2):
        for j1 in range(slots[0]):
            for j2 in range(slots[1]):
                a1, a2 = angles[i, side, 0], angles[i, side, 1]
                v1 = a1 if endless[0] else a1 + TURN * (first[0] + j1)
                v2 = a2 if endless[1] else a2 + TURN * (first[1] + j2)
                possible[state] = (
                    penalty[i, side] < np.inf
                    and (endless[0] or slot_of(v1, a1, travel[0], first[0], slots[0]) >= 0)
                    and (endless[1] or slot_of(v2, a2, travel[1], first[1], slots[1]) >= 0)
                )
                cost[state] = np.inf
                base[state, 0] = v1
                base[state, 1] = v2
                state += 1


@jit()
def new_states(count: int) -> States:
    """Room for the states of a point."""
    return States(np.empty(count), np.zeros((count, 2)), np.empty((count, 2)), np.empty(count, np.bool_))


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
def cheapest(cost: Floats) -> int:
    """The first of the states of least cost."""
    best = 0
    for state in range(len(cost)):
        if cost[state] < cost[best]:
            best = state
    return best


@jit()
def start(penalty: Floats, states: States) -> None:
    """The states at the first point: the nearer the joints are to zero, the better; penalty (2,) of the solutions."""
    count = len(states.cost)
    for state in range(count):
        if states.possible[state]:
            v1, v2 = states.base[state, 0], states.base[state, 1]
            states.value[state, 0] = v1
            states.value[state, 1] = v2
            states.cost[state] = penalty[2 * state // count] + HOME * (abs(v1) + abs(v2))


@jit()
def ways_between(frame: Floats, points: Points, turns: Turns, i: int, ways: Ways, scratch: Floats) -> None:
    """The ways from point i - 1 to point i."""
    angles, penalty = points.angles, points.penalty
    for s in range(2):
        for r in range(2):
            near = wrapped(angles[i, r, 0] - angles[i - 1, s, 0])
            second = wrapped(angles[i, r, 1] - angles[i - 1, s, 1])
            possible = penalty[i, r] < np.inf and penalty[i - 1, s] < np.inf
            for way in range(2):
                ways.change[s, r, way, 0] = near
                ways.change[s, r, way, 1] = second
                fine = possible
                if way == 1:
                    # The other way round can be right where the first joint swings far, close to the pole.
                    ways.change[s, r, way, 0] = near - TURN if near > 0.0 else near + TURN
                    fine = possible and not turns.endless[0] and abs(near) > 0.5 * math.pi
                if fine and not points.bridged[i]:
                    change = ways.change[s, r, way]
                    fine = not strays(frame, angles[i - 1, s], change, points.axis[i - 1], points.axis[i], scratch)
                ways.fine[s, r, way] = fine


@jit()
def go_on(points: Points, turns: Turns, i: int, ways: Ways, now: States, after: States, trace: Trace) -> None:
    """Reach the states at point i from those before, by the ways between; after a pole, any turn of the first joint."""
    endless, travel, first, slots = turns.endless, turns.travel, turns.first, turns.slots
    angles, penalty = points.angles, points.penalty
    change, fine = ways
    now_cost, now_value, cost, value, link = now.cost, now.value, after.cost, after.value, trace.before
    k1, k2 = slots[0], slots[1]
    free = points.bridged[i] and not endless[0]
    for state in range(len(now_cost)):
        if not now_cost[state] < np.inf:
            continue
        before = state // (k1 * k2)
        for way in range(4):
            side = way // 2
            if not fine[before, side, way % 2]:
                continue
            a1, a2 = angles[i, side, 0], angles[i, side, 1]
            v1 = now_value[state, 0] + change[before, side, way % 2, 0]
            v2 = now_value[state, 1] + change[before, side, way % 2, 1]
            j2 = 0 if endless[1] else slot_of(v2, a2, travel[1], first[1], k2)
            low = 0 if free or endless[0] else slot_of(v1, a1, travel[0], first[0], k1)
            if low < 0 or j2 < 0:
                continue
            for j1 in range(low, k1 if free else low + 1):
                if free:
                    v1 = a1 + TURN * (first[0] + j1)
                    if slot_of(v1, a1, travel[0], first[0], k1) < 0:
                        continue
                total = now_cost[state] + penalty[i, side]
                total = total + abs(v1 - now_value[state, 0]) + abs(v2 - now_value[state, 1])
                target = (side * k1 + j1) * k2 + j2
                if total < cost[target]:
                    cost[target] = total
                    value[target, 0] = v1
                    value[target, 1] = v2
                    link[i, target] = state


@jit()
def jump(penalty: Floats, rapid: bool, turns: Turns, i: int, now: States, after: States, trace: Trace) -> None:
    """Reach the states at point i from the cheapest one before, whatever lies between; penalty (2,) of solutions."""
    endless = turns.endless
    cost, value, base, possible = after
    before, jumped = trace
    best = cheapest(now.cost)
    at1, at2 = now.value[best, 0], now.value[best, 1]
    least = now.cost[best]
    count = len(cost)
    for state in range(count):
        if not possible[state]:
            continue
        v1, v2 = base[state, 0], base[state, 1]
        if endless[0]:
            v1 = at1 + wrapped(v1 - at1)
        if endless[1]:
            v2 = at2 + wrapped(v2 - at2)
        total = least + penalty[2 * state // count] + (JUMP_RAPID if rapid else JUMP)
        total += abs(v1 - at1) + abs(v2 - at2)
        if total < cost[state]:
            cost[state] = total
            value[state, 0] = v1
            value[state, 1] = v2
            before[i, state] = best
            jumped[i, state] = True


@jit()
def trace_back(points: Points, turns: Turns, state: int, trace: Trace, chosen: Floats, jumps: Bools) -> None:
    """The joint positions `chosen` (n, 2) on the way to a state at the last point, and where it jumps."""
    n = len(points.angles)
    k1, k2 = turns.slots[0], turns.slots[1]
    order = np.empty(n, np.int64)
    for i in range(n - 1, -1, -1):
        order[i] = state
        jumps[i] = trace.jumped[i, state]
        state = trace.before[i, state]
    for i in range(n):
        side = order[i] // (k1 * k2)
        for joint in range(2):
            slot = (order[i] // k2) % k1 if joint == 0 else order[i] % k2
            angle = points.angles[i, side, joint]
            if not turns.endless[joint]:
                chosen[i, joint] = angle + TURN * (turns.first[joint] + slot)
            elif i == 0:
                chosen[i, joint] = angle
            else:
                chosen[i, joint] = chosen[i - 1, joint] + wrapped(angle - chosen[i - 1, joint])


@jit()
def choose(frame: Floats, points: Points, turns: Turns, chosen: Floats, jumps: Bools) -> bool:
    """Joint positions `chosen` (n, 2) along the path, and where (n,) it jumps; False where some point has no state."""
    n = len(points.angles)
    count = 2 * turns.slots[0] * turns.slots[1]
    now, after = new_states(count), new_states(count)
    ways = Ways(np.empty((2, 2, 2, 2)), np.empty((2, 2, 2), np.bool_))
    trace = Trace(np.full((n, count), -1, np.int32), np.zeros((n, count), np.bool_))
    scratch = np.empty(3)
    for i in range(n):
        lay_out(points, turns, i, after)
        if i == 0:
            start(points.penalty[0], after)
        else:
            ways_between(frame, points, turns, i, ways, scratch)
            go_on(points, turns, i, ways, now, after, trace)
            jump(points.penalty[i], points.rapid[i], turns, i, now, after, trace)
        now, after = after, now
        if not now.cost[cheapest(now.cost)] < np.inf:
            return False
    trace_back(points, turns, cheapest(now.cost), trace, chosen, jumps)
    return True
