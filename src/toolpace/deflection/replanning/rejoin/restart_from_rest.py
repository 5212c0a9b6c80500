"""A stop on the path and a restart with a clock rate that no limit prevents: the last resort.

    stop, straight to the path, rest       dc/dt:  k^2 t^2 / 2,  then 1 - e with e' = -k e,  at last 1

A motion Q(c) that keeps to velocities V, accelerations A and jerks J keeps to them on a clock c of the rate r = 1 - e,
too, where  k V <= A  and  k^2 V + 3 k A <= J  for each joint:

    acceleration    r^2 Q'' + r' Q'                     <= (1 - e)^2 A + k e V                    <= A
    jerk            r^3 Q''' + 3 r r' Q'' + r'' Q'      <= (1 - e)^3 J + 3 k e A + k^2 e V        <= J

for (1 - e)^2 and (1 - e)^3 are at most 1 - e. The tip is no faster than on the path. An exponential never comes to its
end: the last 1e-5 of the rate are a parabola, by which limits are passed by no more than 1e-5 of themselves.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from math import log, sqrt

import numpy as np
from scipy.optimize import brentq

from toolpace.common.arrays import Floats
from toolpace.deflection.replanning.commanded import CommandedMotion
from toolpace.deflection.replanning.rejoin.stop import Stop
from toolpace.deflection.replanning.rejoin.superposed import Before, SuperposedRejoin
from toolpace.deflection.replanning.rejoin_motion import RejoinMotion
from toolpace.machine.limits import KINDS, Limits
from toolpace.planning.limit_tolerances import ALLOWED, DETOUR

ROOM = 0.95
"""Of the jerk that the rise is reckoned with: it begins with a parabola, which the proof above leaves out."""
MEETS = sqrt(3.0) - 1.0
"""k t at which the parabola k^2 t^2 / 2 meets the exponential."""
LEFT = DETOUR - ALLOWED
"""Of the pace, from which a parabola leads to the end: by that much a detour may pass what the motion itself may."""
PARTS = 8
"""Steps of the rise in which the motion is looked at."""
STEEPEST = 1e4
"""The largest k, where no limit tells one [1/s]."""
PROBES = 400
"""Instants at which rates without a limit are looked at."""


@dataclass(frozen=True)
class PaceRise:
    """A pace from 0 to 1, by k [1/s]."""

    k: float

    @property
    def ends(self) -> Floats:
        """(3,) of the first parabola, of the exponential, and of the last parabola [s]."""
        found: Floats = np.cumsum([MEETS, log(MEETS / LEFT), 2.0]) / self.k
        return found

    @property
    def duration(self) -> float:
        """[s]"""
        return float(self.ends[-1])

    def clock(self, t: Floats) -> Floats:
        """(4, n) how far it has come [s], its pace and two derivatives, at times (n,) from 0 on."""
        k, none = self.k, np.zeros_like(t)
        x, y, z = (np.clip(t - start, 0.0, None) * k for start in (0.0, *self.ends[:2]))
        e, w = MEETS * np.exp(-y), 1.0 - z / 2.0
        parts = [
            np.stack([x**3 / (6.0 * k), x * x / 2.0, k * x, none + k * k]),
            np.stack([(y - MEETS + e) / k, 1.0 - e, k * e, -k * k * e]),
            np.stack(
                [(z - LEFT * (1.0 - w**3) * 2.0 / 3.0) / k, 1.0 - LEFT * w * w, k * LEFT * w, none - k * k * LEFT / 2.0]
            ),
            np.stack([t - self.ends[2], none + 1.0, none, none]),
        ]
        come = np.cumsum([0.0, MEETS**3 / 6.0, log(MEETS / LEFT) - MEETS + LEFT, 2.0 - LEFT * 2.0 / 3.0]) / k
        for part, before in zip(parts, come):
            part[0] += before
        out: Floats = np.choose(np.searchsorted(self.ends, t, side="right"), parts)
        return out

    def when(self, come: float) -> float:
        """The time [s] after which it has come so far [s]."""
        return float(brentq(lambda t: self.clock(np.array([t]))[0, 0] - come, 0.0, self.duration + come))


def steepest(commanded: CommandedMotion, begin: float, limits: Limits) -> float:
    """The largest k [1/s] of the proof, for a motion from a time on its clock.

    Where a joint has no limit of a kind, twice what the motion is seen to use takes its place.
    """
    v, a, j = (getattr(limits, kind) for kind in KINDS)
    rates = np.abs(commanded.motion(np.linspace(begin, commanded.law.duration, PROBES))).max(axis=1)[1:]
    v, a = (np.where(np.isfinite(limit), limit, 2.0 * rate) for limit, rate in zip((v, a), rates))
    with np.errstate(divide="ignore", invalid="ignore"):
        by_acceleration = np.where(np.isfinite(limits.acceleration), a / v, np.inf)
        # the root of k^2 v + 3 k a = j
        by_jerk = 2.0 * ROOM * j / (3.0 * a + np.sqrt(9.0 * a * a + 4.0 * ROOM * v * j))
    return float(np.nanmin([*np.minimum(by_acceleration, np.where(np.isfinite(j), by_jerk, np.inf)), STEEPEST]))


@dataclass(frozen=True, eq=False)
class RestartFromRest(RejoinMotion):
    """A way to rest on the path, and the rise of the pace from there.

    The tool is on the path from the end of `to_rest` on; `rejoin` is where the pace is that of the commanded law.
    """

    to_rest: SuperposedRejoin
    rise: PaceRise
    commanded: CommandedMotion = field(init=False)
    left: float = field(init=False)
    rejoin: float = field(init=False)
    times: Floats = field(init=False)

    def __post_init__(self) -> None:
        aside, rise = self.to_rest, self.rise
        end, rejoin = rise.duration, aside.rejoin + float(rise.clock(np.array([rise.duration]))[0, 0])
        if rejoin > aside.commanded.law.duration:
            rejoin = aside.commanded.law.duration
            end = rise.when(rejoin - aside.rejoin)
        own = np.append(np.linspace(0.0, end, PARTS + 1), rise.ends)
        own = np.unique(own[(own > 0.0) & (own <= end)])
        object.__setattr__(self, "commanded", aside.commanded)
        object.__setattr__(self, "left", aside.left)
        object.__setattr__(self, "times", np.append(aside.times, aside.duration + own))
        object.__setattr__(self, "rejoin", rejoin)

    @property
    def before(self) -> Before | Stop | None:
        """What the joints do before they go to the path."""
        return self.to_rest.before

    @property
    def wait(self) -> float:
        """Time of that [s]."""
        return self.to_rest.wait

    def clock(self, t: Floats) -> Floats:
        out = np.where(t < self.to_rest.duration, self.to_rest.clock(t), self._rising(t)[0])
        on: Floats = np.clip(out, 0.0, self.rejoin)
        return on

    def motion(self, t: Floats) -> Floats:
        order = np.argsort(t, kind="stable")
        on = np.clip(t[order], 0.0, self.duration)
        cut = int(np.searchsorted(on, self.to_rest.duration))
        parts = [self.to_rest.motion(on[:cut]), self.commanded.paced(self._rising(on[cut:]))]
        out = np.empty((4, len(t), self.to_rest.start.shape[1]))
        out[:, order] = np.concatenate(parts, axis=1)
        return out

    def _rising(self, t: Floats) -> Floats:
        """(4, n) the clock of the commanded motion and its rates at times since the start."""
        out = self.rise.clock(np.clip(t - self.to_rest.duration, 0.0, None))
        out[0] += self.to_rest.rejoin
        return out
