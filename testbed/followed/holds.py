"""How soon a follower stands after the operator's hold, from places all along a motion."""

from __future__ import annotations

import numpy as np

from testbed.followed.cases import Case
from testbed.followed.disturbed import Disturbed
from testbed.followed.drive import driven
from toolpace.common.arrays import Floats
from toolpace.deflection.following import Follower
from toolpace.kernels.follow import layout as at

PLACES = 20
LONGEST = 20.0
"""For which a hold is waited [s]."""


def hold_times(case: Case, reserve: float) -> Floats:
    """(PLACES,) time from a feed of 0 to a pace of 0 [s]; inf where it takes longer than `LONGEST`."""
    follower = Follower(case.trajectory, case.machine, reserve=reserve)
    times = np.full(PLACES, np.inf)
    for k, begin in enumerate(np.linspace(0.02, 0.95, PLACES) * follower.duration):
        first = int(begin / follower.period)
        override = np.ones(first + int(LONGEST / follower.period))
        override[first:] = 0.0
        count = len(override)
        nothing = Disturbed(override, np.zeros(count, dtype=np.int64), np.zeros(count), np.zeros((count, 9)))
        stands = np.flatnonzero(driven(follower, nothing, 0.0)[first:, at.OUT_PACE] == 0.0)
        if len(stands):
            times[k] = (stands[0] + 1) * follower.period
    return times
