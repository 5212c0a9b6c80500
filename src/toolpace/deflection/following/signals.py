"""The input and the output of a follower at each step: a measurement of the tool, and a set-point."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import IntFlag
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from toolpace.common.arrays import Floats
from toolpace.common.errors import UsageError
from toolpace.deflection.following.figures import number, numbers
from toolpace.kernels.follow import layout
from toolpace.kernels.follow.layout import AXIS, DEFLECTION, FORCE, MEASURED_AT, TIP


@dataclass(frozen=True, eq=False)
class Measurement:
    """Position of the tip or its deflection, direction of the tool, or force on it, at a time; what is not given was
    not measured.

    Any figures are taken, nan and absurd ones too: a follower says what it made of them, and goes on. The place of the
    tip counts before a force; an axis counts along with it.
    """

    t: float | None
    """When it was measured, on the follower's clock, which `SetPoint.t` tells [s]; None where the sensor does not say,
    and the follower's `dead_time` does."""
    tip: npt.ArrayLike | None = None
    """(3,) tool tip in the workpiece frame [m]."""
    axis: npt.ArrayLike | None = None
    """(3,) unit vector from the tip to the spindle, in the workpiece frame."""
    force: npt.ArrayLike | None = None
    """(3,) force on the tool, in the workpiece frame [N]; counts where the follower has a compliance."""
    deflection: npt.ArrayLike | None = None
    """(3,) how far the tip was from where it was commanded `delay` before, correction and all, in the workpiece frame
    [m]: what `tip` less that place would be, and taken in place of it."""

    def write(self, into: Floats, now: float, dead_time: float) -> None:
        """Write to an array (13,) as kernels/follow/layout.py has it, at a time `now` of the follower's clock [s].

        Raises UsageError for what is no number, or of a wrong shape, and for a time beside a dead time [s].
        """
        into[MEASURED_AT] = self._time(now, dead_time)
        for at, name, value in (
            (TIP, "tip", self.tip),
            (AXIS, "axis", self.axis),
            (FORCE, "force", self.force),
            (DEFLECTION, "deflection", self.deflection),
        ):
            if value is None:
                into[at : at + 3] = np.nan
                continue
            vector = numbers(value)
            if vector is None or vector.shape != (3,):
                what = f"is {value!r:.60}" if vector is None else f"has shape {vector.shape}"
                raise UsageError(f"measurement: {name} {what}; give three figures (x, y, z)")
            into[at : at + 3] = vector

    def _time(self, now: float, dead_time: float) -> float:
        """When it was measured [s]."""
        if self.t is None:
            return now - dead_time
        t = number(self.t)
        if t is None:
            raise UsageError(f"measurement: t is {self.t!r:.60}; give a time in seconds")
        if dead_time > 0.0 and not math.isnan(t):
            raise UsageError(
                f"measurement: t is {t:g} s, and the follower has a dead_time of {dead_time:g} s: the sensor would be"
                " late twice; give t = None, or a follower without dead_time"
            )
        return t


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
