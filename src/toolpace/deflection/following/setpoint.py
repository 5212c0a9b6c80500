"""The output of a follower at each step."""

from __future__ import annotations

from enum import IntFlag
from typing import NamedTuple

from toolpace.common.arrays import Floats
from toolpace.kernels.follow import layout


class Status(IntFlag):
    """What there is to say of a set-point; 0: all is well."""

    ENDED = layout.ENDED
    """The path has been gone through."""
    HELD = layout.HELD
    """The tool stands on its path: a feed of 0, or a stop; from the first step on where that is asked for then."""
    STALE = layout.STALE
    """Nothing that counts was measured of late (or no axis, where the rotary joints are corrected): the correction is
    held."""
    FADING = layout.FADED
    """Nothing was measured for so long that the correction is taken back."""
    AT_LIMIT = layout.AT_LIMIT
    """The correction would have to be larger than it may be."""
    STOPPING = layout.STOPPING
    """It was so for longer than patience: the tool is brought to a stop on its path, until `resume`."""
    NOT_A_NUMBER = layout.NOT_A_NUMBER
    """What was measured is not a number, or a force whose bending is not known: not counted."""
    LATE = layout.LATE
    """What was measured came out of order, too late, or from the future: not counted."""
    ABSURD = layout.ABSURD
    """What was measured is too far off to be believed: not counted."""
    JUMPED = layout.JUMPED
    """The joints were found displaced: the motion goes on from where they are."""
    SLOWED = layout.SLOWED
    """The pace is lowered, for a correction that adds to the feed or lags behind."""
    OVERRIDE_CUT = layout.OVERRIDE_CUT
    """The override is above 1.2 or below 0, and 1.2 or 0 is taken; or it is nan or infinite, and the tool holds."""


class SetPoint(NamedTuple):
    """Where the joints shall be one period later, and how they move there."""

    t: float
    """On the follower's clock [s]."""
    q: Floats
    """(m,) joints, path and correction together [m or rad]."""
    qd: Floats
    qdd: Floats
    qddd: Floats
    """(m,) their derivatives by time."""
    s: float
    """Parameter of the path."""
    path_time: float
    """Time of the plan that the path is at [s]."""
    pace: float
    """How fast it goes by, as a share of the pace that is the plan's own, less where the plan leaves no reserve."""
    correction: Floats
    """(4, m) what of q and its derivatives is correction."""
    status: Status
