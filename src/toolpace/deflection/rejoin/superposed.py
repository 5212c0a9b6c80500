"""Rejoin motions superposed on a slower motion along the path: a decaying offset, and at the last a restart from rest.

    q(t) = Q(c(t)) + e(t)          Q: the motion that is rejoined, c: its clock, e: by how much the joints are off

    dc/dt  1 --.              .-- 1        e  --.
               `--- pace ---'                   `--.
                                                   `-- 0
           |ramp|   even    |ramp|         the same ramps and the same even part

One and the same ramp slows the clock and moves the joints aside, so that the speed of the tip is highest at the ends of
a ramp. With the pace 0 the tool comes to rest, goes straight to the path, and starts again. Where the limits leave no
room at once, all joints stop before that (`Stop`), or the motion goes on as it is for a while (`Before`).

A restart from rest, with a clock rate that no limit prevents, is the last resort:

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
from itertools import pairwise
from math import log, sqrt

import numpy as np
from scipy.optimize import brentq

from toolpace.common.arrays import Floats
from toolpace.deflection.rejoin.stop import PARTS, Stop, dying
from toolpace.deflection.rejoin_motion import CommandedMotion, RejoinMotion
from toolpace.machine.limits import KINDS, Limits
from toolpace.planning.limit_tolerances import ALLOWED, DETOUR

ROOM = 0.95
"""Of the jerk that the rise is reckoned with: it begins with a parabola, which the proof above leaves out."""
MEETS = sqrt(3.0) - 1.0
"""k t at which the parabola k^2 t^2 / 2 meets the exponential."""
LEFT = DETOUR - ALLOWED
"""Of the pace, from which a parabola leads to the end: by that much a detour may pass what the motion itself may."""
STEEPEST = 1e4
"""The largest k, where no limit tells one [1/s]."""
PROBES = 400
"""Instants at which rates without a limit are looked at."""


def ramp(u: Floats) -> Floats:
    """(4, n) integral, value and two derivatives of the smooth step from 0 to 1 at u (n,) in [0, 1]."""
    return np.stack([u**3 - u**4 / 2.0, u * u * (3.0 - 2.0 * u), 6.0 * u * (1.0 - u), 6.0 - 12.0 * u])


@dataclass(frozen=True)
class Shape:
    """A ramp up, an even part and a ramp down."""

    ramp: float
    """Of each ramp, and of the even part [s]."""
    even: float

    @property
    def duration(self) -> float:
        """[s]"""
        return 2.0 * self.ramp + self.even

    @property
    def marks(self) -> Floats:
        """(k,) where its parts begin and end [s]."""
        ends = np.array([0.0, self.ramp, self.ramp + self.even, self.duration])
        return ends if self.even > 0.0 else ends[[0, 1, 3]]

    def up_and_down(self, t: Floats) -> tuple[Floats, Floats]:
        """(4, n) each at times (n,): integral, value and two derivatives of both ramps, the first and the last."""
        out = []
        for begin, whole in ((0.0, self.even + self.ramp), (self.ramp + self.even, 0.0)):
            u = (t - begin) / self.ramp
            values = ramp(np.clip(u, 0.0, 1.0)) * [[self.ramp], [1.0], [1.0 / self.ramp], [1.0 / self.ramp**2]]
            values[2:, (u < 0.0) | (u > 1.0)] = 0.0
            values[0] += np.clip(t - begin - self.ramp, 0.0, whole)
            out.append(values)
        return out[0], out[1]


@dataclass(frozen=True, eq=False)
class Before:
    """What the joints do before: the motion that they were in, with what was found off."""

    current: CommandedMotion
    local: float
    """The time on the clock of its law [s]."""
    offset: Floats
    """(m,)"""
    duration: float
    """[s]"""
    clocks: tuple[float, float]
    """Of the motion that is rejoined, at the start and at the end [s]."""

    @property
    def times(self) -> Floats:
        """(k + 1,) ends of the steps in which it is looked at [s]."""
        return np.linspace(0.0, self.duration, 4 * PARTS + 1)

    def motion(self, t: Floats) -> Floats:
        """(4, n, m) at sorted times (n,)."""
        out = self.current.motion(self.local + t)
        out[0] += self.offset
        return out

    def state(self) -> Floats:
        """(3, m) at its end: at rest where the motion has come to its own."""
        found: Floats = self.motion(np.array([self.duration]))[:3, 0]
        if self.local + self.duration >= self.current.law.duration:
            found[1:] = 0.0
        return found


@dataclass(frozen=True, eq=False)
class SuperposedRejoin(RejoinMotion):
    """A motion from a state, beside the one that is rejoined and into it."""

    commanded: CommandedMotion
    left: float
    start: Floats
    """(3, m) positions, velocities and accelerations where the way aside begins."""
    begin: float
    """The clock of the commanded law there [s]."""
    paces: tuple[float, float, float]
    """Of that clock at the start, in the even part, and at the end."""
    shape: Shape
    before: Before | Stop | None = None
    wait: float = field(init=False)
    """Time of what is before it [s]."""
    times: Floats = field(init=False)
    rejoin: float = field(init=False)
    off: tuple[Floats, Floats, Floats, Floats] = field(init=False)
    """By how much the joints are off at the start, two time derivatives, and what is left once these have died away."""

    def __post_init__(self) -> None:
        marks = self.shape.marks
        own = np.concatenate([np.linspace(a, b, PARTS + 1)[:-1] for a, b in pairwise(marks)])
        own = np.append(own, self.shape.duration)
        wait = 0.0 if self.before is None else self.before.duration
        times = own if self.before is None else np.concatenate([self.before.times[:-1], wait + own])
        object.__setattr__(self, "times", times)
        object.__setattr__(self, "wait", wait)
        end = float(self._clock(np.array([self.shape.duration]))[0, 0])
        object.__setattr__(self, "rejoin", min(end, self.commanded.law.duration))
        q, v, a = self.commanded.paced(self._clock(np.zeros(1)))[:3, 0]
        off, rate, bend = self.start - [q, v, a]
        # the rates die away in the first ramp, and lead on by this
        far = self.shape.ramp * (rate / 2.0 + bend * self.shape.ramp / 12.0)
        object.__setattr__(self, "off", (off, rate, bend, off + far))

    def _clock(self, t: Floats) -> Floats:
        """(4, n) clock of the commanded motion and its rates at times since the way aside began."""
        up, down = self.shape.up_and_down(t)
        first, even, last = self.paces
        out = (even - first) * up + (last - even) * down
        out[0] += self.begin + first * t
        out[1] += first
        return out

    def _beside(self, t: Floats) -> Floats:
        """(4, n, m) by how much the joints are off."""
        off, rate, bend, whole = self.off
        up, down = self.shape.up_and_down(t)
        share = (up - down)[:, :, None] / (self.shape.ramp + self.shape.even)
        out = np.stack([whole - whole * share[0], *(-whole * each for each in share[1:])])
        out += dying(rate, bend, self.shape.ramp, t)
        out[0] += off - whole
        return out

    def clock(self, t: Floats) -> Floats:
        wait = self.wait
        out = self._clock(np.clip(t - wait, 0.0, self.shape.duration))[0]
        if self.before is not None:
            first, last = self.before.clocks
            out = np.where(t < wait, first + (last - first) * np.clip(t / wait, 0.0, 1.0), out)
        on: Floats = np.clip(out, 0.0, self.rejoin)
        return on

    def motion(self, t: Floats) -> Floats:
        wait = self.wait
        order = np.argsort(t, kind="stable")
        on = np.clip(t[order], 0.0, self.duration)
        m = self.start.shape[1]
        out, cut = np.empty((4, len(t), m)), int(np.searchsorted(on, wait))
        if cut and self.before is not None:
            out[:, order[:cut]] = self.before.motion(on[:cut])
        own = on[cut:] - wait
        out[:, order[cut:]] = self.commanded.paced(self._clock(own)) + self._beside(own)
        return out


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
