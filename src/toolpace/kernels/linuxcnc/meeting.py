"""The join of two segments in LinuxCNC's planner: kink, rounding or overlap, whichever is fastest.

Of two segments that overlap, each has half its acceleration.
"""

from __future__ import annotations

import math

from toolpace.kernels.arrays import Floats
from toolpace.kernels.jit import jit
from toolpace.kernels.linuxcnc.blocks import (
    ACCELERATION,
    ARC,
    BEGIN,
    BLOCK,
    CENTRE,
    CORNER,
    DONE,
    END,
    ENDING,
    EXACT,
    FIXED,
    JERK,
    KIND,
    KINK,
    KINK_AFTER,
    KINK_BEFORE,
    LENGTH,
    LINE,
    OF_RADIUS,
    ORIGIN,
    OVERLAPPED,
    OVERLAPS,
    REQUESTED,
    REST,
    SWEEP,
    TANGENT,
    TANGENTIAL,
    TOLERANCE,
    TURNS,
    Blocks,
    Control,
    Vector,
    acceleration_of,
    along,
    dot,
    end_with,
    from_to,
    most_speed,
    of_block,
    unit,
)
from toolpace.kernels.linuxcnc.limited_jerk import (
    arc_speed,
    speed_after,
    speed_from_rest,
    speed_near,
    time_to_rest,
)
from toolpace.kernels.linuxcnc.rounding import Rounding, no_rounding, round_corner

SHARP = (math.pi * 2.0 / 180.0) ** 2
"""Corners that turn back within two degrees: squared sum of unit vectors."""
LEAST_ANGLE = 1e-3
"""Between the ways of two segments, for a tolerance to count."""


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
            speed = min(rounding.speed, length / control.cycle)
            if control.jerk > 0.0:
                speed = min(speed, arc_speed(rounding.acceleration, rounding.radius, rounding.angle, control))
            if choose(b, q, k, new, speed, control):
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
    overlap = 0.5 * overlap_speeds(b, q, k, new, goal, goal_new, control)[2]
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
def overlap_speeds(
    b: Blocks, q: Floats, k: int, new: int, goal: float, goal_new: float, control: Control
) -> tuple[float, float, float]:
    """Speeds at which both overlap at most, and the speed through the corner."""
    a, a_new = acceleration_of(q, k), acceleration_of(q, new)
    v, v_new = min(peak_speed(q, k, a, control), goal), min(peak_speed(q, new, a_new, control), goal_new)
    longest = min(q[k, LENGTH] / v, q[new, LENGTH] / v_new)
    time = min(longest, max(time_to_rest(v, a, control), time_to_rest(v_new, a_new, control)))
    v = min(v, speed_after(time, a, q[k, JERK], control))
    v_new = min(v_new, speed_after(time, a_new, q[k, JERK], control))
    j, j_new = int(q[k, BLOCK]), int(q[new, BLOCK])
    turn = dot(of_block(b, j, END), start_of(b, q, new, j_new))
    theta = 0.5 * math.acos(max(-1.0, min(1.0, -turn)))
    if q[k, TOLERANCE] > 0.0 and math.cos(theta) > math.sin(LEAST_ANGLE):
        near = speed_near(2.0 * q[k, TOLERANCE] / math.cos(theta), a, q[k, JERK], control)
        v, v_new = min(v, near), min(v_new, near)
    return v, v_new, math.sin(theta) * 0.5 * (v + v_new)


@jit(inline=True)
def peak_speed(q: Floats, k: int, acceleration: float, control: Control) -> float:
    """Of a segment from rest to rest; half of it may still be cut where its length is not final."""
    left = q[k, LENGTH] * (1.0 if q[k, FIXED] else 0.5)
    return speed_from_rest(acceleration, control.jerk, left, control)


@jit(inline=True)
def start_of(b: Blocks, q: Floats, k: int, j: int) -> Vector:
    """Direction in which a segment accelerates at its start: an arc inwards, too."""
    if q[k, KIND] != ARC:
        return of_block(b, j, BEGIN)
    share = 1.0 - max(q[k, KINK_AFTER], q[k, KINK_BEFORE])
    if q[k, OVERLAPS] or q[k, ENDING] == OVERLAPPED:
        share *= 0.5
    inwards = unit(from_to(of_block(b, j, CORNER), of_block(b, j, CENTRE)))
    curved = (0.5 * q[k, REQUESTED]) ** 2 / b.figures[j, OF_RADIUS]
    return unit(along(along(ORIGIN, q[k, ACCELERATION] * share, of_block(b, j, BEGIN)), curved, inwards))
