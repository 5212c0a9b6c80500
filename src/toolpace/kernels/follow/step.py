"""One step of a follower: from a measurement to the next set-point; and its C interface.

step: a piece, its state, a measurement
  the measurement is taken in, or why it is not is said
  the pace that is wanted: what the operator asks, less for what the correction adds to the feed or lags behind
  before anything has moved, that is the pace
  a change of pace is committed to, if one fits
  path and pace go on for one period, and so does the correction
  joints: path and correction together
"""

from __future__ import annotations

import math
from typing import Any

import numba
import numpy as np

from toolpace.kernels.arrays import Floats
from toolpace.kernels.follow.correction import correct, feed_of_correction
from toolpace.kernels.follow.correction_target import take
from toolpace.kernels.follow.layout import (
    AIM,
    AT,
    AT_LIMIT,
    BEND,
    CHANGE,
    CORRECTION,
    DELAY,
    DURATION,
    ENDED,
    FADE,
    FADED,
    FULL,
    FULL_FOR,
    HELD,
    HISTORY,
    HOLD,
    INPUTS,
    JOINTS,
    LAST_AXIS,
    LAST_COUNTED,
    LOOK_BACK,
    MEASURED,
    MEMORY,
    NEEDED,
    NOMINAL,
    NOW,
    OUT_CORRECTION,
    OUT_PACE,
    OUTPUTS,
    OVERRIDE,
    OVERRIDE_CUT,
    PACE,
    PARAMETER,
    PATH_TIME,
    PATIENCE,
    PERIOD,
    PLACE,
    SCRATCH,
    SLOWED,
    STALE,
    STATE,
    STATUS,
    STEPS,
    STOPPED,
    STOPPING,
    TAKEN_OFF,
    TAU,
    WAIT,
    Q,
)
from toolpace.kernels.follow.pace import begin, commit, keep_pace, place_on_path
from toolpace.kernels.jit import jit

NOTCHES = 16.0
"""Parts in which the pace is lowered for a correction: it is not changed for every little."""
SETTLES = 0.2
"""Time constant with which it comes back [s]: what noise makes of the correction shall not make the pace tremble."""
LEAST = 0.02
"""Share of the feed up to which nothing is taken off the pace."""
MOST_OVERRIDE = 1.2
"""Highest override that counts; what is above it is cut, and said."""
TYPES: Any = numba.types
POINTER = TYPES.CPointer(TYPES.float64)


@jit()
def step(piece: Floats, state: Floats, inputs: Floats, out: Floats) -> None:
    """Write the next set-point (layout.OUTPUTS,); `inputs` (layout.INPUTS,) has nan for what was not measured."""
    status = 0
    if measured_something(inputs):
        status |= take(piece, state, inputs)
    status |= grow_old(piece, state)
    status |= supervise(piece, state)
    requested = allowed(inputs[OVERRIDE])
    if requested != inputs[OVERRIDE]:
        status |= OVERRIDE_CUT
    wanted, slowed = wanted_pace(piece, state, requested)
    status |= slowed
    begin(state, wanted)
    commit(piece, state, wanted)
    keep_pace(piece, state)
    correct(piece, state)
    state[STEPS] += 1.0
    state[NOW] = state[STEPS] * piece[PERIOD]
    status |= write(piece, state, out)
    out[STATUS] = float(status)


@jit()
def measured_something(inputs: Floats) -> bool:
    """Whether anything but the override is given."""
    something = False
    for k in range(OVERRIDE):
        something |= not math.isnan(inputs[k])
    return something


@jit()
def grow_old(piece: Floats, state: Floats) -> int:
    """Hold the aim for a while without measurements, then let it fade; returns the bits of the status.

    The rotary joints go by when an axis was measured, the linear ones by when anything was, however old it was then.
    """
    if state[MEASURED] == 0.0:
        return 0
    place = piece[PLACE : PLACE + 5].view(np.int64)
    status, kept = 0, math.exp(-piece[PERIOD] / piece[FADE])
    for k in range(JOINTS):
        aim = AIM + place[k]
        late = state[NOW] - state[LAST_AXIS if k < 2 else LAST_COUNTED] - piece[DELAY] - 0.5 * piece[PERIOD]
        if late <= 0.0 or (k < 2 and state[aim] == 0.0):
            continue
        status |= STALE
        if late > piece[HOLD]:
            status |= FADED
            state[aim] *= kept
            if k >= 2:
                state[FULL] = 0.0
    return status


@jit()
def supervise(piece: Floats, state: Floats) -> int:
    """Count how long the correction has been at its limit; beyond patience the tool is brought to a stop."""
    state[FULL_FOR] = state[FULL_FOR] + piece[PERIOD] if state[FULL] > 0.0 else 0.0
    if state[FULL_FOR] > piece[PATIENCE]:
        state[STOPPED] = 1.0
    status = AT_LIMIT if state[FULL] > 0.0 else 0
    return status | STOPPING if state[STOPPED] > 0.0 else status


@jit(inline=True)
def allowed(override: float) -> float:
    """The override within its range; a hold for what is no finite number."""
    return min(max(override, 0.0), MOST_OVERRIDE) if math.isfinite(override) else 0.0


@jit()
def wanted_pace(piece: Floats, state: Floats, requested: float) -> tuple[float, int]:
    """The pace that is wanted, and whether it is less than what was requested."""
    if state[STOPPED] > 0.0:
        return 0.0, 0
    needed = feed_of_correction(piece, state)
    lag = 0.0
    place = piece[PLACE : PLACE + 5].view(np.int64)
    for k in range(2, JOINTS):
        j = place[k]
        lag += (state[AIM + j] - state[CORRECTION + 4 * j]) ** 2
    lag = math.sqrt(lag) / piece[WAIT]
    needed = min(max(needed, 0.5 * (lag - 1.0)), 1.0)
    state[NEEDED] = max(needed, state[NEEDED] * math.exp(-piece[PERIOD] / SETTLES))
    notches = math.ceil(state[NEEDED] * NOTCHES) if state[NEEDED] > LEAST else 0.0
    if notches == 0.0 or not -1.5 < notches - NOTCHES * state[TAKEN_OFF] < 0.5:
        state[TAKEN_OFF] = notches / NOTCHES
    return requested * (1.0 - state[TAKEN_OFF]), SLOWED if state[TAKEN_OFF] > 0.0 else 0


@jit()
def write(piece: Floats, state: Floats, out: Floats) -> int:
    """Write path and correction together, and remember them; returns the bits of the status."""
    tau, pace, change, bend = state[TAU], state[PACE], state[CHANGE], state[BEND]
    memory = HISTORY + (int(state[STEPS]) % LOOK_BACK) * MEMORY
    state[memory] = tau
    on_path = state[SCRATCH : SCRATCH + 4]
    for j in range(JOINTS):
        place_on_path(piece, tau, j, on_path)
        own = CORRECTION + 4 * j
        q1, q2, q3 = on_path[1], on_path[2], on_path[3]
        out[Q + j] = on_path[0] + state[own]
        out[Q + JOINTS + j] = q1 * pace + state[own + 1]
        out[Q + 2 * JOINTS + j] = q2 * pace * pace + q1 * change + state[own + 2]
        out[Q + 3 * JOINTS + j] = (q3 * pace * pace + 3.0 * q2 * change) * pace + q1 * bend + state[own + 3]
        state[memory + 1 + j] = state[own]
        for k in range(4):
            out[OUT_CORRECTION + k * JOINTS + j] = state[own + k]
    place_on_path(piece, tau, JOINTS, on_path)
    out[AT], out[PATH_TIME], out[PARAMETER], out[OUT_PACE] = state[NOW], tau * piece[NOMINAL], on_path[0], pace
    status = ENDED if tau >= piece[DURATION] else 0
    return status | HELD if pace == 0.0 else status


def step_for_c() -> Any:
    """Compile the door; `address` of what is returned is the function's, good as long as that lives."""

    def door(piece: Any, length: Any, state: Any, inputs: Any, out: Any) -> None:
        step(
            numba.carray(piece, (length,)),
            numba.carray(state, (STATE,)),
            numba.carray(inputs, (INPUTS,)),
            numba.carray(out, (OUTPUTS,)),
        )

    return numba.cfunc(TYPES.void(POINTER, TYPES.int64, POINTER, POINTER, POINTER))(door)
