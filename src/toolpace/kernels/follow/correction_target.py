"""The target of the correction, from a measurement.

What is measured shows the set-point of `delay` before, with the correction that it had: both are remembered. Where tool
or part bends, what was found beyond that set-point is the bending, whatever the correction was; the aim relaxes
towards its opposite,

    aim += gain (-bending - aim),

which contracts where |1 - gain| + gain rho < 1, rho the change of bending for a change of command, since the
correction never leaves the range of its aims. Where the joints were displaced, the correction is what they are off by,
and its aim is none.
"""

from __future__ import annotations

import math

import numpy as np

from toolpace.kernels.arrays import Floats
from toolpace.kernels.follow.correction import stop
from toolpace.kernels.follow.layout import (
    ABSURD,
    AIM,
    AXIS,
    AXIS_TOLERANCE,
    BELIEVABLE,
    CAUSE,
    COMPLIANCE,
    CORRECTION,
    DEADBAND,
    DEFLECTION,
    DELAY,
    DISPLACED,
    FILTER,
    FORCE,
    FRAME,
    FULL,
    GAIN,
    GROUP,
    HISTORY,
    JOINTS,
    JUMPED,
    LAST_AXIS,
    LAST_COUNTED,
    LAST_JUMP,
    LAST_MEASURED,
    LATE,
    LOOK_BACK,
    LOW,
    MEASURED,
    MEASURED_AT,
    MEMORY,
    MOST,
    MOST_TURN,
    NOT_A_NUMBER,
    NOW,
    PERIOD,
    PLACE,
    RHO,
    SCRATCH,
    SHARE,
    SHOWN,
    SMOOTHED,
    STEPS,
    TIP,
    WITH_TOOL,
)
from toolpace.kernels.follow.pace import longer_at, place_on_path
from toolpace.kernels.jit import jit
from toolpace.kernels.kinematics.chain import dot, forward, linear_columns, reciprocal, turn
from toolpace.kernels.kinematics.geometry import A0, C2, U1, U2, Chain

MOST_TILT = 0.5
"""What an axis may be off by to be believed [rad]."""


@jit()
def take(piece: Floats, state: Floats, inputs: Floats) -> int:
    """Take in what was measured (13,), nan where nothing was; returns what is to be said of it."""
    by_tip = math.isfinite(inputs[TIP] + inputs[TIP + 1] + inputs[TIP + 2]) or measures_deflection(inputs)
    by_force = math.isfinite(inputs[FORCE] + inputs[FORCE + 1] + inputs[FORCE + 2]) and bends(piece)
    if not (math.isfinite(inputs[MEASURED_AT]) and (by_tip or by_force)):
        return NOT_A_NUMBER
    seen = (inputs[MEASURED_AT] - piece[DELAY]) / piece[PERIOD]
    if inputs[MEASURED_AT] > state[NOW] + 1.5 * piece[PERIOD]:
        return LATE
    if (state[MEASURED] > 0.0 and inputs[MEASURED_AT] <= state[LAST_MEASURED]) or seen < state[STEPS] - LOOK_BACK + 2.0:
        return LATE
    remembered(piece, state, max(min(seen, state[STEPS]), 0.0))
    wanted = state[SCRATCH + 31 : SCRATCH + 36]
    off = off_by_tip(piece, state, inputs, wanted) if by_tip else off_by_force(piece, state, inputs, wanted)
    if not off <= piece[BELIEVABLE]:
        return ABSURD
    since = inputs[MEASURED_AT] - state[LAST_MEASURED] if state[MEASURED] > 0.0 else piece[PERIOD]
    first = state[MEASURED] == 0.0
    state[MEASURED], state[LAST_MEASURED], state[LAST_COUNTED] = 1.0, inputs[MEASURED_AT], state[NOW]
    if piece[CAUSE] == DISPLACED and by_tip:
        return displace(piece, state, wanted, off)
    by_axis = by_tip and counts_axis(piece, inputs)
    if by_axis:
        state[LAST_AXIS] = state[NOW]
    relax(piece, state, wanted, since, first, by_axis)
    return 0


@jit(inline=True)
def bends(piece: Floats) -> bool:
    """Whether it is known what a force bends."""
    some = False
    for k in range(9):
        some |= piece[COMPLIANCE + k] != 0.0
    return some


@jit(inline=True)
def counts_axis(piece: Floats, inputs: Floats) -> bool:
    """Whether an axis was measured, and the rotary joints are to be corrected by it."""
    return piece[MOST_TURN] > 0.0 and math.isfinite(inputs[AXIS] + inputs[AXIS + 1] + inputs[AXIS + 2])


@jit(inline=True)
def measures_deflection(inputs: Floats) -> bool:
    """Whether what the tip is off by was measured itself."""
    return math.isfinite(inputs[DEFLECTION] + inputs[DEFLECTION + 1] + inputs[DEFLECTION + 2])


@jit()
def remembered(piece: Floats, state: Floats, step: float) -> None:
    """Write the joints (5,) of an earlier set-point, between two of them, to scratch, and the chain with the tool
    that was in the spindle then."""
    before = min(int(step), max(int(state[STEPS]) - 1, 0))
    share = min(max(step - before, 0.0), 1.0)
    one = HISTORY + (before % LOOK_BACK) * MEMORY
    other = HISTORY + ((before + 1) % LOOK_BACK) * MEMORY
    tau = state[one] + share * (state[other] - state[one])
    column = state[SCRATCH + 27 : SCRATCH + 31]
    for j in range(JOINTS):
        place_on_path(piece, tau, j, column)
        off = state[one + 1 + j] + share * (state[other + 1 + j] - state[one + 1 + j])
        state[SCRATCH + j] = column[0] + off
        state[SHOWN + j] = off
    longer = longer_at(piece, tau)
    for k in range(27):
        state[WITH_TOOL + k] = piece[FRAME + k]
    for d in range(3):
        state[WITH_TOOL + 3 * C2 + d] -= longer * piece[FRAME + 3 * A0 + d]


@jit(inline=True)
def chain_of(piece: Floats) -> Chain:
    """The kinematic chain in a piece, with the tool of the machine file."""
    return Chain(
        piece[FRAME : FRAME + 27].reshape((9, 3)),
        piece[GROUP : GROUP + 3].view(np.int64),
        piece[PLACE : PLACE + 5].view(np.int64),
    )


@jit(inline=True)
def chain_with_tool(piece: Floats, state: Floats) -> Chain:
    """The same with the tool of the set-point that `remembered` found."""
    return Chain(
        state[WITH_TOOL : WITH_TOOL + 27].reshape((9, 3)),
        piece[GROUP : GROUP + 3].view(np.int64),
        piece[PLACE : PLACE + 5].view(np.int64),
    )


@jit()
def off_by_tip(piece: Floats, state: Floats, inputs: Floats, wanted: Floats) -> float:
    """How far the joints (5,) must go to undo what tip and axis are off by; returns what the tip is off by [m]."""
    chain = chain_with_tool(piece, state)
    tip, axis = state[SCRATCH + 5 : SCRATCH + 8], state[SCRATCH + 8 : SCRATCH + 11]
    q = state[SCRATCH : SCRATCH + 5]
    forward(chain, q.reshape((1, 5)), tip.reshape((1, 3)), axis.reshape((1, 3)))
    direct = measures_deflection(inputs)
    for d in range(3):
        tip[d] = inputs[DEFLECTION + d] if direct else inputs[TIP + d] - tip[d]
    off = math.sqrt(dot(tip, tip))
    first, second = 0.0, 0.0
    if counts_axis(piece, inputs):
        first, second = turns_for(piece, state, inputs, axis)
        if math.isnan(first):
            return math.inf
    wanted[chain.place[0]], wanted[chain.place[1]] = first, second
    if first != 0.0 or second != 0.0:
        # the tip moves as the joints turn: where it is then is what the linear joints make up for
        q[chain.place[0]] += first
        q[chain.place[1]] += second
        turned = state[SCRATCH + 11 : SCRATCH + 14]
        before = state[SCRATCH + 14 : SCRATCH + 17]
        forward(chain, q.reshape((1, 5)), turned.reshape((1, 3)), axis.reshape((1, 3)))
        q[chain.place[0]] -= first
        q[chain.place[1]] -= second
        forward(chain, q.reshape((1, 5)), before.reshape((1, 3)), axis.reshape((1, 3)))
        for d in range(3):
            tip[d] += turned[d] - before[d]
    by_linear(chain, state, tip, wanted)
    return off


@jit()
def turns_for(piece: Floats, state: Floats, inputs: Floats, axis: Floats) -> tuple[float, float]:
    """Turns of both rotary joints that undo what the axis is off by, in least squares damped by the tolerance of the
    axis: near its pole, where a joint turns far for next to nothing, it stays (Wampler 1986). Nan where that is not to
    be believed."""
    chain = chain_with_tool(piece, state)
    q = state[SCRATCH : SCRATCH + 5]
    s1, k1 = math.sin(q[chain.place[0]]), math.cos(q[chain.place[0]])
    s2, k2 = math.sin(q[chain.place[1]]), math.cos(q[chain.place[1]])
    one, two = state[SCRATCH + 11 : SCRATCH + 14], state[SCRATCH + 14 : SCRATCH + 17]
    u1, u2 = chain.frame[U1], chain.frame[U2]
    one[0] = u1[1] * axis[2] - u1[2] * axis[1]
    one[1] = u1[2] * axis[0] - u1[0] * axis[2]
    one[2] = u1[0] * axis[1] - u1[1] * axis[0]
    turn(u2, s2, k2, chain.frame[A0], two)
    x = u2[1] * two[2] - u2[2] * two[1]
    y = u2[2] * two[0] - u2[0] * two[2]
    two[2] = u2[0] * two[1] - u2[1] * two[0]
    two[0], two[1] = x, y
    turn(u1, s1, k1, two, two)
    off = state[SCRATCH + 17 : SCRATCH + 20]
    for d in range(3):
        off[d] = axis[d] - inputs[AXIS + d]
    least = piece[AXIS_TOLERANCE]
    if dot(off, off) <= least * least:
        return 0.0, 0.0
    if not dot(off, off) <= MOST_TILT * MOST_TILT:
        return math.nan, math.nan
    damping = 1e-2
    a, b, c = dot(one, one) + damping * damping, dot(one, two), dot(two, two) + damping * damping
    x, y = dot(one, off), dot(two, off)
    volume = a * c - b * b
    return (c * x - b * y) / volume, (a * y - b * x) / volume


@jit()
def by_linear(chain: Chain, state: Floats, off: Floats, wanted: Floats) -> None:
    """Write how far the linear joints must go to undo what the tip is off by (3,)."""
    q = state[SCRATCH : SCRATCH + 5]
    columns = state[SCRATCH + 11 : SCRATCH + 20].reshape((3, 3))
    inverse = state[SCRATCH + 20 : SCRATCH + 29].reshape((3, 3))
    first, second = q[chain.place[0]], q[chain.place[1]]
    linear_columns(chain, math.sin(first), math.cos(first), math.sin(second), math.cos(second), columns)
    reciprocal(columns, inverse)
    for j in range(3):
        wanted[chain.place[2 + j]] = -dot(inverse[j], off)


@jit()
def off_by_force(piece: Floats, state: Floats, inputs: Floats, wanted: Floats) -> float:
    """The same for the bending that a force on the tool (3,) [N], in the frame of the workpiece, makes of it."""
    chain = chain_with_tool(piece, state)
    q = state[SCRATCH : SCRATCH + 5]
    first, second = q[chain.place[0]], q[chain.place[1]]
    local, bent = state[SCRATCH + 5 : SCRATCH + 8], state[SCRATCH + 8 : SCRATCH + 11]
    for d in range(3):
        local[d] = inputs[FORCE + d]
    turn(chain.frame[U1], -math.sin(first), math.cos(first), local, local)
    turn(chain.frame[U2], -math.sin(second), math.cos(second), local, local)
    for d in range(3):
        bent[d] = dot(piece[COMPLIANCE + 3 * d : COMPLIANCE + 3 * d + 3], local)
    turn(chain.frame[U2], math.sin(second), math.cos(second), bent, bent)
    turn(chain.frame[U1], math.sin(first), math.cos(first), bent, bent)
    off = math.sqrt(dot(bent, bent))
    wanted[chain.place[0]], wanted[chain.place[1]] = 0.0, 0.0
    by_linear(chain, state, bent, wanted)
    return off


@jit()
def relax(piece: Floats, state: Floats, wanted: Floats, since: float, first: bool, by_axis: bool) -> None:
    """Move the aim (5,) towards where it should be; `since` is the time since the last measurement [s]. That of the
    rotary joints stays where no axis was measured: nothing is known of them then, not that they are right."""
    place = piece[PLACE : PLACE + 5].view(np.int64)
    share = 1.0
    if piece[FILTER] > 0.0 and not first:
        share = 1.0 - math.exp(-since / piece[FILTER])
    steps = max(round(since / piece[PERIOD]), 1.0)
    gain = 1.0 - (1.0 - piece[GAIN]) ** steps if piece[GAIN] < 1.0 else piece[GAIN]
    away, length = 0.0, 0.0
    begin = 0 if by_axis else 2
    for k in range(begin, JOINTS):
        j = place[k]
        # of the bending seen, the correction that it was seen with has its expected part
        settled = (wanted[j] - piece[RHO] * state[SHOWN + j]) / (1.0 - piece[RHO])
        state[SMOOTHED + j] += share * (settled - state[SMOOTHED + j])
        if k >= 2:
            away += (state[SMOOTHED + j] - state[AIM + j]) ** 2
    if math.sqrt(away) < piece[DEADBAND]:
        return
    for k in range(begin, JOINTS):
        j = place[k]
        state[AIM + j] += gain * (state[SMOOTHED + j] - state[AIM + j])
        if k >= 2:
            length += state[AIM + j] ** 2
    keep_within(piece, state, math.sqrt(length))


@jit()
def keep_within(piece: Floats, state: Floats, length: float) -> None:
    """Shorten the aim to the most that a correction may be, and to what travel leaves."""
    place = piece[PLACE : PLACE + 5].view(np.int64)
    state[FULL] = 0.0
    for k in range(JOINTS):
        j = place[k]
        aim = state[AIM + j]
        if k < 2:
            aim = min(max(aim, -piece[MOST_TURN]), piece[MOST_TURN])
        elif length > piece[MOST]:
            aim *= piece[MOST] / length
        aim = min(max(aim, piece[LOW + j]), piece[LOW + JOINTS + j])
        if aim != state[AIM + j]:
            state[FULL] = 1.0
            state[AIM + j] = aim


@jit()
def displace(piece: Floats, state: Floats, wanted: Floats, off: float) -> int:
    """Take the joints for where they were found; they go on as fast as they were commanded."""
    shown = state[LAST_MEASURED] - piece[DELAY]
    if shown <= state[LAST_JUMP]:
        return 0
    state[FULL] = 0.0
    if off <= piece[DEADBAND]:
        return 0
    if not within_reach(piece, state, wanted):
        # too far to go back from: as with a correction at its limit, the tool stops if it lasts
        state[FULL] = 1.0
        return ABSURD
    for j in range(JOINTS):
        state[CORRECTION + 4 * j] -= wanted[j]
        state[AIM + j] = 0.0
    state[LAST_JUMP] = state[NOW]
    return JUMPED


@jit()
def within_reach(piece: Floats, state: Floats, wanted: Floats) -> bool:
    """Whether the correction, and where it can be stopped, are within their range after a jump by -wanted (5,)."""
    place = piece[PLACE : PLACE + 5].view(np.int64)
    limits = state[SCRATCH : SCRATCH + 3]
    length = 0.0
    for k in range(JOINTS):
        j = place[k]
        limits[1], limits[2] = piece[SHARE + JOINTS + j], piece[SHARE + 2 * JOINTS + j]
        at = state[CORRECTION + 4 * j] - wanted[j]
        v, a = state[CORRECTION + 4 * j + 1], state[CORRECTION + 4 * j + 2]
        # braking that has begun may turn round before it ends: without it the way out is no shorter
        ends = at + stop(v, a, limits), at + stop(v, 0.0, limits)
        low, high = min(at, ends[0], ends[1]), max(at, ends[0], ends[1])
        if low < piece[LOW + j] or high > piece[LOW + JOINTS + j]:
            return False
        if k >= 2:
            length += max(low * low, high * high)
    within: bool = length <= piece[MOST] * piece[MOST]
    return within
