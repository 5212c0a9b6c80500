"""A decaying offset superposed on a slower motion along the path.

    q(t) = Q(c(t)) + e(t)          Q: the motion that is rejoined, c: its clock, e: by how much the joints are off

    dc/dt  1 --.              .-- 1        e  --.
               `--- pace ---'                   `--.
                                                   `-- 0
           |ramp|   even    |ramp|         the same ramps and the same even part

One and the same ramp slows the clock and moves the joints aside, so that the speed of the tip is highest at the ends of
a ramp. With the pace 0 the tool comes to rest, goes straight to the path, and starts again. Where the limits leave no
room at once, all joints stop before that (`Stop`), or the motion goes on as it is for a while (`Before`).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.deflection.replanning.commanded import CommandedMotion
from toolpace.deflection.replanning.rejoin.stop import Stop, dying
from toolpace.deflection.replanning.rejoin_motion import RejoinMotion

MARKS = 8
"""Steps of each ramp, and of the even part, in which the motion is looked at."""


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
        return np.linspace(0.0, self.duration, 4 * MARKS + 1)

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
        own = np.concatenate([np.linspace(a, b, MARKS + 1)[:-1] for a, b in pairwise(marks)])
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
