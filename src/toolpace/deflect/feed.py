"""The speed of the tip on the way back, and the feed that holds for it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from toolpace.arrays import Floats
from toolpace.deflect.commanded import CommandedMotion
from toolpace.machine.machine import Machine

STEP = 1e-6
"""Time by which joints are moved on to see the speed of the tip [s]: at speeds of 1 m/s and radii of 1 m the central
difference is off by 1e-12 of it, and by 1e-10 m/s of rounding."""
RATE_STEP = 1e-4
"""The same to see the rate of change of that speed [s]: a difference of differences, so a longer step rounds less."""
SOON = 0.05
"""Time within which the tip must reach the feed for its excess to count [s]."""


def tip_velocity(machine: Machine, q: Floats, qd: Floats) -> Floats:
    """(n, 3) velocity of the tip in the workpiece frame [m/s] at joints and joint velocities (n, m)."""
    velocity: Floats = (machine.forward(q + STEP * qd)[0] - machine.forward(q - STEP * qd)[0]) / (2.0 * STEP)
    return velocity


def feed_at(commanded: CommandedMotion, machine: Machine | None, time: float) -> float:
    """The feed [m/s] that holds for the tip at a time of the commanded law; inf where there is none."""
    if machine is None:
        return np.inf
    s = commanded.law.at(np.array([time]))[0]
    cap = float(commanded.run.speed_cap(s)[0])
    jets = commanded.run.evaluate(s)
    return cap * float(np.linalg.norm(tip_velocity(machine, jets[0], jets[1]))) if np.isfinite(cap) else np.inf


@dataclass(frozen=True)
class FeedExcess:
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
    def at_start(cls, machine: Machine | None, feed: float, motion: Floats, offset: Floats) -> FeedExcess:
        """That of joints in commanded motion (4, 1, m), found at an offset (m,)."""
        if machine is None or not np.isfinite(feed):
            return cls(feed, 0.0, 0.0)
        q, qd, qdd = motion[:3]
        speeds = []
        for where in (q, q + offset):
            moved = [
                tip_velocity(machine, where + h * qd + h * h / 2.0 * qdd, qd + h * qdd)
                for h in (-RATE_STEP, 0.0, RATE_STEP)
            ]
            speeds.append([float(np.linalg.norm(velocity)) for velocity in moved])
        (_, on_path, _), (_, off_path, _) = speeds
        rates = [(ahead - behind) / (2.0 * RATE_STEP) for behind, _, ahead in speeds]
        speed, growth = max(off_path - on_path, 0.0), max(rates[1] - rates[0], 0.0)
        near = on_path + speed + SOON * (max(rates[0], 0.0) + growth) > feed
        return cls(feed, speed, growth) if near else cls(feed, 0.0, 0.0)

    def allowed(self, t: Floats, carry: float, period: float) -> Floats:
        """(n,) most speed of the tip [m/s] at times since the deflection."""
        later = np.maximum(t - carry, 0.0)
        rise = self.speed + 2.0 * self.growth * t + 3.0 * self.speed / period * later
        most: Floats = self.feed + rise * np.maximum(1.0 - later / period, 0.0) ** 3
        return most
