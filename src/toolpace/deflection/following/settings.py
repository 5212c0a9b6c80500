"""The settings of a follower, checked."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, fields

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.common.errors import UsageError, did_you_mean
from toolpace.common.units import refuse_other_unit
from toolpace.cutting.compliance import SOFTEST
from toolpace.kernels.follow.layout import LOOK_BACK

CAUSES = ("bending", "displaced")
FINEST, COARSEST = 1e-5, 0.1
"""Shortest and longest period that a follower is for [s]."""
MOST_BELIEVABLE, MOST_WAIT = 0.2, 5e-3
"""Deflection that may be believed, and lag of a correction [m]."""
MOST_RESERVE = 0.5
"""Share of each limit that may be kept for the correction: no more than is left to the path."""


@dataclass(frozen=True, eq=False)
class Figures:
    """What a follower is told beside trajectory and machine."""

    reserve: float = 0.1
    """Share of every limit, and of the feed, that is kept for correction and changes of pace."""
    cause: str = "bending"
    """"bending": tool or part bends, the joints are where they were commanded, and the command must compensate;
    "displaced": the joints are not where they were commanded, and go back."""
    period: float = 1e-3
    """Time between two set-points [s]."""
    delay: float = 0.0
    """Time from a set-point to when the machine is there: lag of the drives, and of what waits before them [s].

    A measurement of the time t shows the set-point of t - `delay`. The dead time of the sensor is no part of it.
    """
    dead_time: float = 0.0
    """Time from when something is measured to the step that it is given to, for measurements without a time of their
    own [s]: they count as made `dead_time` before. Where it is given, a measurement with a time is refused."""
    gain: float = 0.08
    """Share by which the aim moves towards what a measurement asks for, each period; the default is half of what nine
    set-points late and not told allow."""
    rho: float = 0.0
    """Expected change of the bending for a change of the command: the nearer to what it is, the sooner all is well."""
    max_correction: float = 0.3e-3
    """Most correction of the linear joints together [m]."""
    max_turn: float = 0.0
    """Most correction of a rotary joint [rad]; 0: measured axes are not corrected."""
    axis_tolerance: float = 1e-4
    """Difference between axes that is none [rad]."""
    deadband: float = 0.0
    """Difference between correction and measurement that is none [m]."""
    filter: float = 0.0
    """Time constant of a filter on what is measured [s]."""
    hold: float = 0.05
    """Time without measurements for which the correction is held [s]."""
    fade: float = 0.5
    """Time constant with which it is taken back then [s]."""
    patience: float = 0.5
    """Time at the limit of the correction after which the tool is stopped [s]."""
    believable: float = math.inf
    """Deflection beyond which a measurement is not believed [m]; ten times the most correction, if not given."""
    wait: float = math.inf
    """Lag of the correction behind its aim from which the pace is lowered [m]; at three times as much it stands."""
    compliance: Floats = field(default_factory=lambda: np.zeros((3, 3)))
    """(3, 3) bending of the tip for a force, in the frame of the tool at joints zero [m/N]; forces count where it is
    given."""

    def __post_init__(self) -> None:
        if self.cause not in CAUSES:
            raise UsageError(f"follower: unknown cause '{self.cause}'; {did_you_mean(str(self.cause), CAUSES)}")
        for each in fields(self):
            if each.name not in ("cause", "compliance"):
                self._check(each.name, *RANGES.get(each.name, (0.0, math.inf, "0 or more")))
        for name, most in (("believable", MOST_BELIEVABLE), ("wait", MOST_WAIT)):
            refuse_other_unit(getattr(self, name), most, f"follower: {name}", "give metres: 0.3 mm is 0.3e-3")
        late = self.delay + self.dead_time
        if late > (LOOK_BACK - 10) * self.period:
            what = "a delay" if self.dead_time == 0.0 else "delay and dead_time together"
            raise UsageError(
                f"follower: {what} of {late:g} s is more than the {LOOK_BACK - 10} set-points that are"
                f" remembered; give a period of {late / (LOOK_BACK - 10):.3g} s or more"
            )
        compliance = numbers(self.compliance)
        if compliance is None or compliance.shape != (3, 3) or not np.isfinite(compliance).all():
            what = type(self.compliance).__name__ if compliance is None else f"shape {compliance.shape}"
            raise UsageError(
                f"follower: compliance of {what}; give (3, 3) finite figures [m/N], such as Bending(...).compliance"
            )
        softest = float(np.abs(compliance).max())
        refuse_other_unit(softest, SOFTEST, "follower: compliance", "give m/N: 0.1 um/N is 1e-7")
        object.__setattr__(self, "compliance", compliance)
        if math.isinf(self.believable):
            object.__setattr__(self, "believable", 10.0 * self.max_correction)

    def _check(self, name: str, least: float, most: float, words: str) -> None:
        raw = getattr(self, name)
        value = number(raw)
        if value is None or not least <= value <= most:
            raise UsageError(f"follower: {name} is {raw!r:.60}; give {words}")
        object.__setattr__(self, name, value)


RANGES = {
    "reserve": (1e-3, MOST_RESERVE, f"a share from 0.001 to {MOST_RESERVE:g}"),
    "period": (FINEST, COARSEST, f"a time from {FINEST:g} to {COARSEST:g} s"),
    "delay": (0.0, 0.2, "a time from 0 to 0.2 s"),
    "dead_time": (0.0, 0.2, "a time from 0 to 0.2 s"),
    "gain": (1e-6, 2.0, "a share above 0, at most 2"),
    "rho": (0.0, 0.9, "a share from 0 to 0.9"),
    "max_correction": (1e-9, 0.02, "a length above 0, at most 0.02 m: 0.3 mm is 0.3e-3"),
    "max_turn": (0.0, 0.5, "an angle from 0 to 0.5 rad"),
    "fade": (1e-6, math.inf, "a time above 0"),
    "deadband": (0.0, 5e-4, "a length from 0 to 0.5e-3 m: 2 um is 2e-6"),
    "believable": (1e-9, math.inf, "a length above 0"),
    "axis_tolerance": (0.0, 0.02, "an angle from 0 to 0.02 rad: 0.05 deg is 0.9e-3"),
    "filter": (0.0, 2.0, "a time from 0 to 2 s"),
    "wait": (1e-9, math.inf, "a length above 0"),
}


def numbers(value: object) -> Floats | None:
    """What was given as an array of real numbers, or None where it is none: text, truth values and None are none."""
    try:
        found = np.asarray(value)
    except (TypeError, ValueError, OverflowError):
        return None
    return found.astype(float) if found.dtype.kind in "iuf" else None


def number(value: object) -> float | None:
    """What was given as one real number, or None where it is none."""
    found = numbers(value)
    return None if found is None or found.shape != () else float(found)
