"""A stop of all joints from a state in motion: each comes to rest as fast as its acceleration and jerk allow.

    jerk          acceleration        With v the velocity and a the acceleration at first, J and A the limits:
     --.   .--      --.               the peak is  min(A, sqrt(J v + a^2 / 2)),  on the side that brakes what
       |   |           \\       /      is left of v when a has gone to zero; what the ramps leave of v is
       '---'            '-----'       braked at A.

Source: the third-order stop of textbooks (L. Biagiotti, C. Melchiorri, Trajectory Planning for Automatic Machines and
Robots, 2008, section 3.4), joint by joint: joints that stop by themselves stand earlier than those that wait.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import copysign, sqrt

import numpy as np

from toolpace.arrays import Floats
from toolpace.machine.limits import Limits

STILL = 1e-12
"""Velocity over its limit, and acceleration over its, from which a joint stands."""


@dataclass(frozen=True, eq=False)
class Stop:
    """From a state (3, m) of positions, velocities and accelerations to rest."""

    start: Floats
    limits: Limits
    left: float
    """When the path was left, on the clock of the motion that is rejoined [s]: it stands meanwhile."""

    @cached_property
    def steps(self) -> list[tuple[tuple[float, float], ...]]:
        """Of each joint: lengths [s] and jerks of its steps."""
        limits = zip(self.limits.velocity, self.limits.acceleration, self.limits.jerk)
        return [stop_of_joint(v, a, *map(float, limit)) for v, a, limit in zip(*self.start[1:], limits)]

    @cached_property
    def times(self) -> Floats:
        """(k + 1,) from 0 to the end of the last joint's stop: at all of them a jerk may jump [s]."""
        ends = [np.cumsum([length for length, _ in steps]) for steps in self.steps]
        found: Floats = np.unique(np.concatenate([[0.0], *ends]))
        return found

    @property
    def duration(self) -> float:
        """[s]"""
        return float(self.times[-1])

    @property
    def clocks(self) -> tuple[float, float]:
        """Of the motion that is rejoined, at the start and at the end [s]."""
        return self.left, self.left

    def motion(self, t: Floats) -> Floats:
        """(4, n, m) at sorted times (n,)."""
        out = np.zeros((4, len(t), self.start.shape[1]))
        for joint, steps in enumerate(self.steps):
            q, v, a = map(float, self.start[:, joint])
            begin = 0.0
            for length, jerk in steps:
                on = (t >= begin) & (t < begin + length)
                x = t[on] - begin
                out[:, on, joint] = [
                    q + x * (v + x * (a / 2.0 + x * jerk / 6.0)), v + x * (a + x * jerk / 2.0), a + x * jerk,
                    np.full(len(x), jerk),
                ]  # fmt: skip
                q += length * (v + length * (a / 2.0 + length * jerk / 6.0))
                v += length * (a + length * jerk / 2.0)
                a += length * jerk
                begin += length
            out[0, t >= begin, joint] = q
        return out

    def state(self) -> Floats:
        """(3, m) at its end: at rest."""
        found: Floats = self.motion(np.array([self.duration]))[:3, 0]
        found[1:] = 0.0
        return found


def stop_of_joint(v: float, a: float, most_v: float, most_a: float, jerk: float) -> tuple[tuple[float, float], ...]:
    """Lengths [s] and jerks of the steps in which one joint comes to rest."""
    if not (abs(v) > STILL * most_v or abs(a) > STILL * most_a):
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
