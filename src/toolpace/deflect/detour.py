"""From a deflected pose in motion back onto a run: quintics of time in every joint, as part of an axis path.

Where the paper joins deflection and projection by a quintic with the same velocity and acceleration at both, here the
joints start as they are moving and arrive with the motion that a known time law has at the point of rejoining: no
joint is asked for a jump of velocity or acceleration at either end.

      deflected o--carry--.__
                             `--quintic--.
    ===== run ============================x======> run goes on, law goes on
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from toolpace.arrays import Floats, Ints
from toolpace.axispath.run import AxisRun
from toolpace.laws.law import TimeLaw
from toolpace.machine.machine import Machine
from toolpace.motion import joint_motion

STEP = 1e-6
"""Time by which joints are moved on to see the speed of the tip [s]."""
SOON = 0.05
"""Time within which the tip must reach the feed for its excess to count [s]."""
STILL = 1e-9
"""Speed of the parameter that counts as rest, relative to its mean."""


def tip_velocity(machine: Machine, q: Floats, qd: Floats) -> Floats:
    """(n, 3) velocity of the tip in the workpiece frame [m/s] at joints and joint velocities (n, m)."""
    velocity: Floats = (machine.forward(q + STEP * qd)[0] - machine.forward(q - STEP * qd)[0]) / (2.0 * STEP)
    return velocity


@dataclass(frozen=True)
class Excess:
    """How much faster the tip is on the deflected pose than on the path, where that passes the feed, and how it fades.

    The joints keep their velocities and accelerations, and the tip, found elsewhere, may thereby be faster than the
    feed, or come to be: no command can change that at once. Allowed is F + (e + 2 g t + 3 e t / T) (1 - t / T)^3 over
    the period T of the way back (before it, while the joints carry on, F + e + 2 g t).
    """

    feed: float
    """F [m/s]; inf where there is none."""
    speed: float
    """e: what the deflection adds to the speed of the tip at the start, or 0 where the feed is far [m/s]."""
    growth: float
    """g: what it adds to the rate of change of that speed, or 0 [m/s^2]."""

    @classmethod
    def at_start(cls, machine: Machine | None, feed: float, motion: Floats, offset: Floats) -> Excess:
        """That of joints in commanded motion (4, 1, m), found at an offset (m,)."""
        if machine is None or not np.isfinite(feed):
            return cls(feed, 0.0, 0.0)
        q, qd, qdd = motion[:3]
        step = 1e-4
        speeds = []
        for where in (q, q + offset):
            moved = [
                tip_velocity(machine, where + h * qd + h * h / 2.0 * qdd, qd + h * qdd) for h in (-step, 0.0, step)
            ]
            speeds.append([float(np.linalg.norm(velocity)) for velocity in moved])
        (_, on_path, _), (_, off_path, _) = speeds
        rates = [(ahead - behind) / (2.0 * step) for behind, _, ahead in speeds]
        speed, growth = max(off_path - on_path, 0.0), max(rates[1] - rates[0], 0.0)
        near = on_path + speed + SOON * (max(rates[0], 0.0) + growth) > feed
        return cls(feed, speed, growth) if near else cls(feed, 0.0, 0.0)

    def allowed(self, t: Floats, carry: float, period: float) -> Floats:
        """(n,) most speed of the tip [m/s] at times since the deflection."""
        later = np.maximum(t - carry, 0.0)
        rise = self.speed + 2.0 * self.growth * t + 3.0 * self.speed / period * later
        most: Floats = self.feed + rise * np.maximum(1.0 - later / period, 0.0) ** 3
        return most


@dataclass(frozen=True)
class Known:
    """A run with a time law that keeps to the limits: what there was before the deflection."""

    run: AxisRun
    law: TimeLaw

    def motion(self, t: Floats) -> Floats:
        """(4, n, m) joints and three time derivatives at sorted times (n,) of the law, held in its range."""
        state = self.law.at(np.clip(t, 0.0, self.law.duration))
        state[0] = np.clip(state[0], self.run.s0, self.run.s1)
        moving = joint_motion(self.run.evaluate(state[0]), state)
        return np.stack([moving.q, moving.qd, moving.qdd, moving.qddd])

    def still(self, speed: Floats) -> npt.NDArray[np.bool_]:
        """(n,) whether these speeds of the parameter are those of rest, but for rounding."""
        resting: npt.NDArray[np.bool_] = np.abs(speed) <= STILL * (self.run.s1 - self.run.s0) / self.law.duration
        return resting


@dataclass(frozen=True, eq=False)
class Detour:
    """Joint motion over `carry + period` from a deflected pose to the state of a known motion at `rejoin`.

    For the time `carry` the joints go on as before, offset by the deflection; then each follows a quintic.
    """

    known: Known
    time: float
    """Of the deflection, on the clock of the known law [s]."""
    offset: Floats
    """(m,) deflected joints minus commanded ones."""
    carry: float
    period: float
    rejoin: float
    """On the clock of the known law [s]."""

    @property
    def duration(self) -> float:
        """[s]"""
        return self.carry + self.period

    def polynomials(self) -> Floats:
        """(1, 6, m) of the quintics."""
        from toolpace.kernels.motion.quintic import coefficients

        q = self.known.motion(np.array([self.time + self.carry]))[:3, 0]
        q[0] += self.offset
        end = self.known.motion(np.array([self.rejoin]))[:3, 0]
        both = np.ascontiguousarray(np.stack([q, end], axis=1))
        out: Floats = coefficients(np.array([0.0, self.period]), *both)
        return out

    def motion(self, t: Floats) -> Floats:
        """(4, n, m) joints and three time derivatives at sorted times (n,) since the deflection."""
        from toolpace.kernels.motion.quintic import evaluate

        out: Floats = evaluate(np.array([0.0, self.period]), self.polynomials(), np.ascontiguousarray(t - self.carry))
        early = t < self.carry
        if early.any():
            before = self.known.motion(self.time + t[early])
            before[0] += self.offset
            out[:, early] = before
        return out


class DetourRun(AxisRun):
    """A detour and then the rest of the run that it rejoins, in one parameter p that goes on as that of the run.

    On the detour p(t) is a cubic of time with the speed v and acceleration a of the run's parameter at the rejoining:
    dp/dt = v (1 + y + y^2 / 2), y = a x / v, at the time x <= 0 before it; that is never less than v / 2. Where the
    joints come to rest as they rejoin (v = 0, an end of the run), p is time and the run ends there.
    """

    def __init__(self, detour: Detour, machine: Machine | None, excess: Excess, kinks: Floats) -> None:
        """`excess` tells the feed of the tip on the detour; `kinks` are times at which the jerk of the carry jumps."""
        known = detour.known
        self.detour, self.machine, self.excess, self.rest_of = detour, machine, excess, known.run
        place, self.v, self.a, _ = map(float, known.law.at(np.array([detour.rejoin]))[:, 0])
        self.ends_here = bool(known.still(np.array([self.v]))[0])
        if self.ends_here:
            self.v, self.a = 1.0, 0.0
        self.join = min(max(place, known.run.s0), known.run.s1)
        self.s0 = float(self.parameter(np.zeros(1))[0, 0])
        self.s1 = self.join if self.ends_here else known.run.s1
        self.dwell = known.run.dwell if place > known.run.s0 else 0.0
        self.kinks = np.unique(np.concatenate([kinks, [detour.carry]]))
        self.kinks = self.kinks[(self.kinks > 0.0) & (self.kinks < detour.duration)]
        own = self.parameter(self.kinks)[0]
        later = known.run.breaks[known.run.breaks > self.join]
        self.breaks = np.concatenate([own, [] if self.ends_here else [self.join], [] if self.ends_here else later])
        even = self.parameter(np.linspace(0.0, detour.duration, 13))[0]
        hints = known.run.hints
        after = np.empty(0) if self.ends_here else hints[hints > self.join]
        self.hints = np.concatenate([even, after]) if len(hints) else even

    def parameter(self, t: Floats) -> Floats:
        """(4, n) p and three time derivatives at times (n,) since the deflection, where the detour runs as made."""
        x = t - self.detour.duration
        y = self.a * x / self.v
        return np.stack(
            [
                self.join + self.v * x * (1.0 + y / 2.0 + y * y / 6.0),
                self.v * (1.0 + y + y * y / 2.0),
                self.a * (1.0 + y),
                np.full_like(x, self.a**2 / self.v),
            ]
        )

    def time_at(self, p: Floats) -> Floats:
        """(n,) the inverse of `parameter`: z = 1 + y solves z^3 + 3 z = 4 + 6 a (p - join) / v^2."""
        way = p - self.join
        x = way / self.v
        if abs(self.a) > 0.0:
            k = self.a * way / self.v**2
            z = 2.0 * np.sinh(np.arcsinh((4.0 + 6.0 * k) / 2.0) / 3.0)
            x = np.where(np.abs(k) > 1e-6, (z - 1.0) * self.v / self.a, x)
        for _ in range(2):
            y = self.a * x / self.v
            x = x - (self.v * x * (1.0 + y / 2.0 + y * y / 6.0) - way) / (self.v * (1.0 + y + y * y / 2.0))
        return np.clip(x + self.detour.duration, 0.0, self.detour.duration)

    def evaluate(self, s: Floats) -> Floats:
        s = np.asarray(s, dtype=float)
        on = (s < self.join) | self.ends_here
        out = np.empty((4, len(s), len(self.detour.offset)))
        if not on.all():
            out[:, ~on] = self.rest_of.evaluate(s[~on])
        if on.any():
            t = self.time_at(s[on])
            order = np.argsort(t, kind="stable")
            moving = np.empty((4, len(t), out.shape[2]))
            moving[:, order] = self.detour.motion(t[order])
            _, w, w1, w2 = (value[:, None] for value in self.parameter(t))
            first, second, third = 1.0 / w, -w1 / w**3, -w2 / w**4 + 3.0 * w1**2 / w**5
            q, qd, qdd, qddd = moving
            out[:, on] = [
                q,
                qd * first,
                qdd * first**2 + qd * second,
                qddd * first**3 + 3.0 * qdd * first * second + qd * third,
            ]
        return out

    def speed_cap(self, s: Floats) -> Floats:
        s = np.asarray(s, dtype=float)
        on = (s < self.join) | self.ends_here
        out = np.empty(len(s))
        if not on.all():
            out[~on] = self.rest_of.speed_cap(s[~on])
        if not on.any():
            return out
        if self.machine is None:
            out[on] = np.inf if self.ends_here else self.rest_of.speed_cap(np.array([self.join]))[0]
            return out
        if not np.isfinite(self.excess.feed):
            out[on] = np.inf
            return out
        jets = self.evaluate(s[on])
        speed = np.linalg.norm(tip_velocity(self.machine, jets[0], jets[1]), axis=1)
        with np.errstate(divide="ignore"):
            out[on] = self.excess.allowed(self.time_at(s[on]), self.detour.carry, self.detour.period) / speed
        return out

    def block_at(self, s: Floats) -> Ints:
        return self.rest_of.block_at(np.maximum(s, self.join))
