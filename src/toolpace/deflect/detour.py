"""From a deflected pose in motion back onto a run: quintics of time in every joint, as part of an axis path.

Where the paper joins deflection and projection by a quintic with the same velocity and acceleration at both, here the
joints start as they are moving and arrive with the motion that the commanded time law has at the point of rejoining: no
joint is asked for a jump of velocity or acceleration at either end.

      deflected o--carry--.__
                             `--quintic--.
    ===== run ============================x======> run goes on, law goes on
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from toolpace.arrays import Floats, Ints
from toolpace.axispath.run import AxisRun
from toolpace.deflect.commanded import CommandedMotion
from toolpace.deflect.feed import FeedExcess, tip_velocity
from toolpace.laws.chain import ChainLaw
from toolpace.laws.quintic import QuinticLaw
from toolpace.machine.machine import Machine

HINTS = 13
"""Places along a detour between which it is simple."""
STRAIGHT = 1e-6
"""Share of v^2 / a up to which the parameter is taken as linear in time before Newton's steps, which do the rest."""
NEWTON_STEPS = 2
"""From the closed form, or from the line; each squares the error, so that two leave rounding."""


@dataclass(frozen=True, eq=False)
class Detour:
    """Joint motion over `carry + period` from a deflected pose to the state of the commanded motion at `rejoin`.

    For the time `carry` the joints go on as before, offset by the deflection; then each follows a quintic.
    """

    commanded: CommandedMotion
    time: float
    """Of the deflection, on the clock of the commanded law [s]."""
    offset: Floats
    """(m,) deflected joints minus commanded ones."""
    carry: float
    period: float
    rejoin: float
    """On the clock of the commanded law [s]."""

    @property
    def duration(self) -> float:
        """[s]"""
        return self.carry + self.period

    def kinks(self) -> Floats:
        """(k,) times since the deflection at which the jerk of the carry may jump."""
        if self.carry == 0.0:
            return np.empty(0)
        law, run = self.commanded.law, self.commanded.run
        own = law.times if isinstance(law, QuinticLaw | ChainLaw) else np.empty(0)
        ends = law.at(np.array([self.time, self.time + self.carry]))[0]
        passed = run.breaks[(run.breaks > ends[0]) & (run.breaks < ends[1])]
        times = np.concatenate([own, [law.passing_time(float(s)) for s in passed]]) - self.time
        return np.unique(times[(times > 0.0) & (times < self.carry)])

    def polynomials(self) -> Floats:
        """(1, 6, m) of the quintics."""
        from toolpace.kernels.motion.quintic import coefficients

        q = self.commanded.motion(np.array([self.time + self.carry]))[:3, 0]
        q[0] += self.offset
        end = self.commanded.motion(np.array([self.rejoin]))[:3, 0]
        both = np.ascontiguousarray(np.stack([q, end], axis=1))
        out: Floats = coefficients(np.array([0.0, self.period]), *both)
        return out

    def motion(self, t: Floats) -> Floats:
        """(4, n, m) joints and three time derivatives at sorted times (n,) since the deflection."""
        from toolpace.kernels.motion.quintic import evaluate

        out: Floats = evaluate(np.array([0.0, self.period]), self.polynomials(), np.ascontiguousarray(t - self.carry))
        early = t < self.carry
        if early.any():
            before = self.commanded.motion(self.time + t[early])
            before[0] += self.offset
            out[:, early] = before
        return out


class DetourRun(AxisRun):
    """A detour and then the rest of the run that it rejoins, in one parameter p that goes on as that of the run.

    On the detour p(t) is a cubic of time with the speed v and acceleration a of the run's parameter at the rejoining:
    dp/dt = v (1 + y + y^2 / 2), y = a x / v, at the time x <= 0 before it; that is never less than v / 2. Where the
    joints come to rest as they rejoin (v = 0, an end of the run), p is time and the run ends there.
    """

    def __init__(self, detour: Detour, machine: Machine | None, excess: FeedExcess) -> None:
        """`excess` tells the feed of the tip on the detour."""
        commanded = detour.commanded
        self.detour, self.machine, self.excess, self.rest_of = detour, machine, excess, commanded.run
        place, self.v, self.a, _ = map(float, commanded.law.at(np.array([detour.rejoin]))[:, 0])
        self.ends_here = bool(commanded.still(np.array([self.v]))[0])
        if self.ends_here:
            self.v, self.a = 1.0, 0.0
        self.join = min(max(place, commanded.run.s0), commanded.run.s1)
        self.s0 = float(self.parameter(np.zeros(1))[0, 0])
        self.s1 = self.join if self.ends_here else commanded.run.s1
        self.dwell = commanded.run.dwell if place > commanded.run.s0 else 0.0
        kinks = np.unique(np.concatenate([detour.kinks(), [detour.carry]]))
        self.kinks = kinks[(kinks > 0.0) & (kinks < detour.duration)]
        """(k,) times since the deflection at which the jerk may jump [s]."""
        own = self.parameter(self.kinks)[0]
        later = commanded.run.breaks[commanded.run.breaks > self.join]
        self.breaks = np.concatenate([own, [] if self.ends_here else [self.join], [] if self.ends_here else later])
        even = self.parameter(np.linspace(0.0, detour.duration, HINTS))[0]
        hints = commanded.run.hints
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
            x = np.where(np.abs(k) > STRAIGHT, (z - 1.0) * self.v / self.a, x)
        for _ in range(NEWTON_STEPS):
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
