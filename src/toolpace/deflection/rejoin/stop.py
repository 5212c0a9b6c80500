"""Stops of all joints from a state in motion.

    jerk          acceleration        With v the velocity and a the acceleration at first, J and A the limits:
     --.   .--      --.               the peak is  min(A, sqrt(J v + a^2 / 2)),  on the side that brakes what
       |   |           \\       /      is left of v when a has gone to zero; what the ramps leave of v is
       '---'            '-----'       braked at A.

Source: the third-order stop of textbooks (L. Biagiotti, C. Melchiorri, Trajectory Planning for Automatic Machines and
Robots, 2008, section 3.4), joint by joint: joints that stop by themselves stand earlier than those that wait.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property
from math import copysign, sqrt

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.machine.limits import Limits

BRAKED = 0.95
"""Share of the jerk with which joints brake in proportion; what is left is for what is beside their direction."""
PARTS = 8
"""Steps in which what dies away is looked at."""
LONGEST = 0.1
"""Time in which an acceleration builds up that counts, where none is limited [s]."""
STILL = 1e-12
"""Velocity over its limit, and acceleration over its, up to which a joint stands; without a limit in SI units."""


@dataclass(frozen=True, eq=False)
class Stop(ABC):
    """From a state (3, m) of positions, velocities and accelerations to rest."""

    start: Floats
    limits: Limits
    left: float
    """When the path was left, on the clock of the motion that is rejoined [s]: it stands meanwhile."""

    @property
    @abstractmethod
    def times(self) -> Floats:
        """(k + 1,) from 0 to the end, between which the motion is smooth: at all of them a jerk may jump [s]."""

    @abstractmethod
    def motion(self, t: Floats) -> Floats:
        """(4, n, m) at sorted times (n,)."""

    @property
    def duration(self) -> float:
        """[s]"""
        return float(self.times[-1])

    @property
    def clocks(self) -> tuple[float, float]:
        """Of the motion that is rejoined, at the start and at the end [s]."""
        return self.left, self.left

    def state(self) -> Floats:
        """(3, m) at its end: at rest."""
        found: Floats = self.motion(np.array([self.duration]))[:3, 0]
        found[1:] = 0.0
        return found


@dataclass(frozen=True, eq=False)
class StopAlone(Stop):
    """Each joint by itself, as fast as it can: the last to stand is the slowest."""

    @cached_property
    def steps(self) -> list[tuple[tuple[float, float], ...]]:
        """Of each joint: lengths [s] and jerks of its steps."""
        limits = zip(self.limits.velocity, self.limits.acceleration, self.limits.jerk)
        return [stop_of_joint(v, a, *map(float, limit)) for v, a, limit in zip(*self.start[1:], limits)]

    @cached_property
    def times(self) -> Floats:
        ends = [np.cumsum([length for length, _ in steps]) for steps in self.steps]
        found: Floats = np.unique(np.concatenate([[0.0], *ends]))
        return found

    def motion(self, t: Floats) -> Floats:
        columns = [motion_of(steps, q, v, a, t) for steps, (q, v, a) in zip(self.steps, self.start.T.tolist())]
        out: Floats = np.stack(columns, axis=2)
        return out


@dataclass(frozen=True, eq=False)
class StopTogether(Stop):
    """All joints in proportion: what their motions cancel at the tip they cancel while they brake, too.

    Velocities and accelerations are along one direction, as in a ramp of a time law, and little beside it: the stop is
    that of the slowest joint along it, and what is beside it dies away.
    """

    @cached_property
    def along(self) -> tuple[Floats, float, float]:
        """Direction (m,) of the motion, and its rates along it."""
        weight = 1.0 / np.where(np.isfinite(self.limits.jerk), self.limits.jerk, 1.0)
        v, a = self.start[1], self.start[2]
        built = (self.limits.acceleration * weight)[np.isfinite(self.limits.acceleration)]
        way = v + a * float(built.min(initial=LONGEST))
        square = float((way * weight) @ (way * weight))
        if square == 0.0:
            return way, 0.0, 0.0
        return way, float((v * weight) @ (way * weight)) / square, float((a * weight) @ (way * weight)) / square

    @cached_property
    def beside(self) -> tuple[Floats, Floats, float]:
        """Velocities and accelerations (m,) beside the direction, and the time in which they die away [s]."""
        way, v, a = self.along
        rates = self.start[1] - v * way, self.start[2] - a * way
        share = (1.0 - BRAKED) / 2.0 * self.limits.jerk
        time = max(float((4.0 * np.abs(rates[1]) / share).max()), sqrt(float((6.0 * np.abs(rates[0]) / share).max())))
        return *rates, time

    @cached_property
    def steps(self) -> tuple[tuple[float, float], ...]:
        """Lengths [s] and jerks along the direction."""
        way, v, a = self.along
        with np.errstate(divide="ignore"):
            most = [float((kind / np.abs(way)).min()) for kind in (self.limits.acceleration, self.limits.jerk)]
        return stop_of_joint(v, a, 1.0, most[0], BRAKED * most[1]) if way.any() else ()

    @cached_property
    def times(self) -> Floats:
        ends = np.cumsum([length for length, _ in self.steps])
        found: Floats = np.unique(np.concatenate([np.linspace(0.0, self.beside[2], PARTS + 1), ends]))
        return found

    def motion(self, t: Floats) -> Floats:
        way, v, a = self.along
        rate, bend, time = self.beside
        out: Floats = motion_of(self.steps, 0.0, v, a, t)[:, :, None] * way
        if time > 0.0:
            out += dying(rate, bend, time, t)
        out[0] += self.start[0]
        return out


def dying(rate: Floats, bend: Floats, time: float, t: Floats) -> Floats:
    """(4, n, m) of a motion from 0 whose velocity and acceleration (m,) die away in a time [s], smoothly."""
    u = np.clip(t / time, 0.0, 1.0)[:, None]
    on = (t < time)[:, None]
    turned = bend * time * u * u * (0.5 - 2.0 / 3.0 * u + u * u / 4.0)
    return np.stack(
        [
            time * (rate * (u - u**3 + u**4 / 2.0) + turned),
            on * (rate * (1.0 - 3.0 * u * u + 2.0 * u**3) + bend * time * (u - 2.0 * u * u + u**3)),
            on * (rate * (6.0 * u * u - 6.0 * u) / time + bend * (1.0 - 4.0 * u + 3.0 * u * u)),
            on * (rate * (12.0 * u - 6.0) / time**2 + bend * (6.0 * u - 4.0) / time),
        ]
    )


def motion_of(steps: tuple[tuple[float, float], ...], q: float, v: float, a: float, t: Floats) -> Floats:
    """(4, n) of one joint through steps of constant jerk, at times (n,); behind them it stands."""
    out, begin = np.zeros((4, len(t))), 0.0
    for length, jerk in steps:
        on = (t >= begin) & (t < begin + length)
        x = t[on] - begin
        out[:, on] = [
            q + x * (v + x * (a / 2.0 + x * jerk / 6.0)), v + x * (a + x * jerk / 2.0), a + x * jerk,
            np.full(len(x), jerk),
        ]  # fmt: skip
        q += length * (v + length * (a / 2.0 + length * jerk / 6.0))
        v += length * (a + length * jerk / 2.0)
        a += length * jerk
        begin += length
    out[0, t >= begin] = q
    return out


def stop_of_joint(v: float, a: float, most_v: float, most_a: float, jerk: float) -> tuple[tuple[float, float], ...]:
    """Lengths [s] and jerks of the steps in which one joint comes to rest."""
    scales = (most if np.isfinite(most) else 1.0 for most in (most_v, most_a))
    if all(abs(rate) <= STILL * scale for rate, scale in zip((v, a), scales)):
        return ()
    if not np.isfinite(jerk):
        jerk = max(most_a if np.isfinite(most_a) else 0.0, abs(a), abs(v)) * 1e3
    left = v + a * abs(a) / (2.0 * jerk)
    side = copysign(1.0, left)
    v, a = side * v, side * a
    peak = min(most_a, sqrt(max(jerk * v + a * a / 2.0, 0.0)))
    # beyond its limit it is brought within by this
    peak = max(peak, -a)
    held = max((v + (a * a - 2.0 * peak * peak) / (2.0 * jerk)) / peak, 0.0) if peak > 0.0 else 0.0
    steps = (((a + peak) / jerk, -side * jerk), (held, 0.0), (peak / jerk, side * jerk))
    return tuple((length, each) for length, each in steps if length > 0.0)
