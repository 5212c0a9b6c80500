"""The states of path points in the branch choice, and its records.

A state is a solution and the whole turns added to each joint whose travel is limited, counted in slots; a joint without
end has one slot. Its number is (solution * slots of R1 + slot of R1) * slots of R2 + slot of R2.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from toolpace.kernels.arrays import Bools, Floats, Ints
from toolpace.kernels.jit import jit

TURN = 2.0 * math.pi
SLACK = 1e-9
"""How far beyond its travel a joint may be [rad]."""

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
