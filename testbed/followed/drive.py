"""Steps of a follower in a compiled loop: a second of a run in some milliseconds."""

from __future__ import annotations

import numba
import numpy as np

from testbed.followed.disturbed import AXIS, BEND_WITH_COMMAND, DEFLECTION, FORCE, TIP, Disturbed
from toolpace.common.arrays import Floats, Ints
from toolpace.deflection.following import Follower
from toolpace.kernels.follow import layout as at
from toolpace.kernels.follow.correction_target import chain_of
from toolpace.kernels.follow.pace import place_on_path
from toolpace.kernels.follow.step import step
from toolpace.kernels.kinematics.chain import forward

Q, TAU, NOW, OVERRIDE, STATUS, INPUTS, OUT_CORRECTION = (
    at.Q, at.TAU, at.NOW, at.OVERRIDE, at.STATUS, at.INPUTS, at.OUT_CORRECTION,
)  # fmt: skip
STOPPED, FULL_FOR, ENDED = at.STOPPED, at.FULL_FOR, at.ENDED
AFTERWARDS = 0.3
"""How long a run goes on after its path has ended [s]."""


def driven(follower: Follower, happens: Disturbed, calm: float) -> Floats:
    """(n, OUTPUTS) set-points of a run: all that happens, then `calm` [s] without measurements at full feed, or less
    where the path has ended."""
    follower.reset()
    count = len(happens.override) + int(calm / follower.period)
    out = np.full((count, at.OUTPUTS), np.nan)
    after = int(AFTERWARDS / follower.period)
    n = _drive(follower.piece, follower.state, happens.override, happens.what, happens.lag, happens.off, after, out)
    return out[:n]


@numba.njit(error_model="numpy")
def _drive(
    piece: Floats, state: Floats, override: Floats, what: Ints, lag: Floats, off: Floats, after: int, out: Floats
) -> int:
    chain, q, given = chain_of(piece), np.empty(5), np.empty(INPUTS)
    tip, axis, column, left = np.empty(3), np.empty(3), np.empty(4), after
    for i in range(len(out)):
        given[:] = np.nan
        given[OVERRIDE] = 1.0
        if i < len(override):
            given[OVERRIDE] = override[i]
        elif i == len(override):
            state[STOPPED] = state[FULL_FOR] = 0.0
        if i < len(override) and what[i] != 0:
            for j in range(5):
                place_on_path(piece, state[TAU], j, column)
                q[j] = column[0] if i == 0 or not what[i] & BEND_WITH_COMMAND else out[i - 1, Q + j]
            forward(chain, q.reshape((1, 5)), tip.reshape((1, 3)), axis.reshape((1, 3)))
            given[0] = state[NOW] - lag[i]
            for d in range(3):
                if what[i] & TIP:
                    given[1 + d] = tip[d] + off[i, d]
                if what[i] & AXIS:
                    given[4 + d] = axis[d] + off[i, 3 + d]
                if what[i] & FORCE:
                    given[7 + d] = off[i, 6 + d]
                if what[i] & DEFLECTION:
                    given[10 + d] = off[i, d]
        step(piece, state, given, out[i])
        if int(out[i, STATUS]) & ENDED:
            left -= 1
            if left <= 0 and (i >= len(override) or all_at_rest(out[i])):
                return i + 1
    return len(out)


@numba.njit(error_model="numpy")
def all_at_rest(out: Floats) -> bool:
    """Whether the correction stands."""
    fastest: float = np.abs(out[OUT_CORRECTION + 5 : OUT_CORRECTION + 10]).max()
    return fastest < 1e-12
