"""The speed of the tip on the way back, and the feed that holds for it."""

from __future__ import annotations

import numpy as np

from toolpace.arrays import Floats
from toolpace.axispath.follow import FollowRun
from toolpace.axispath.run import AxisRun
from toolpace.deflect.aim import AimedOffRun
from toolpace.deflect.course import Course
from toolpace.machine.limits import Limits
from toolpace.machine.machine import Machine
from toolpace.planning.guarantee import DETOUR

STEP = 1e-6
"""Time by which joints are moved on to see the speed of the tip [s]: at speeds of 1 m/s and radii of 1 m the central
difference is off by 1e-12 of it, and by 1e-10 m/s of rounding."""
LOOKS = 8
"""Looks at the tip in each step of a detour."""


def tip_velocity(machine: Machine, q: Floats, qd: Floats) -> Floats:
    """(n, 3) velocity of the tip in the workpiece frame [m/s] at joints and joint velocities (n, m)."""
    n = len(q)
    ends = machine.forward(np.concatenate([q + STEP * qd, q - STEP * qd]))[0]
    velocity: Floats = (ends[:n] - ends[n:]) / (2.0 * STEP)
    return velocity


def tip_rates(machine: Machine, q: Floats) -> Floats:
    """(n, 3, m) how the tip moves with each joint, at joints (n, m)."""
    n, m = q.shape
    each = STEP * np.eye(m)
    there = (
        machine.forward((q[:, None] + each).reshape(-1, m))[0] - machine.forward((q[:, None] - each).reshape(-1, m))[0]
    )
    rates: Floats = np.ascontiguousarray(there.reshape(n, m, 3).transpose(0, 2, 1)) / (2.0 * STEP)
    return rates


def feed_at(run: AxisRun, s: Floats) -> Floats:
    """(n,) feed of the blocks at s (n,) [m/s]; inf where there is none. What times a block is no feed of the tip."""
    while isinstance(run, AimedOffRun):
        run = run.base
    if not isinstance(run, FollowRun):
        return np.full(len(s), np.inf)
    feed: Floats = run.run.feed[run.run.block_index(s)]
    return feed


def fastest_braking(rates: Floats, start: Floats, t: Floats, limits: Limits, share: float) -> Floats:
    """(n,) least speed of the tip [m/s] at times (n,): every joint brakes it with a share of its jerk at once.

    `rates` (n, 3, m) are those of the tip by the joints, `start` (3, m) the state. With the share 1 no motion within
    the limits of acceleration and jerk is slower along the direction in which the tip would go on.
    """
    velocity = start[1] + t[:, None] * start[2]
    going = np.einsum("ndm,nm->nd", rates, velocity)
    speed: Floats = np.linalg.norm(going, axis=1)
    along = np.einsum("nd,ndm->nm", going / np.maximum(speed, 1e-300)[:, None], rates)
    jerk, most = share * limits.jerk, limits.acceleration
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        ramp = np.maximum((most + np.sign(along) * start[2]) / jerk, 0.0)
        build = np.minimum(t[:, None], np.where(np.isnan(ramp), np.inf, ramp))
        less = jerk * build * (t[:, None] - build / 2.0)
    less = np.where(np.isnan(less), np.inf, less)
    with np.errstate(invalid="ignore"):
        braked = np.where(along == 0.0, 0.0, np.abs(along) * less)
    left: Floats = np.maximum(speed - braked.sum(axis=1), 0.0)
    return left


def looks_at(times: Floats) -> Floats:
    """(n,) times at which the tip is looked at, for the ends of steps (k + 1,)."""
    inside = np.arange(LOOKS) / LOOKS
    return np.append((times[:-1, None] + np.diff(times)[:, None] * inside).ravel(), times[-1])


def tip_speed(detour: Course, machine: Machine) -> tuple[Floats, Floats, Floats]:
    """Times along a detour, speed of the tip and the feed of where it is, each (n,)."""
    t = looks_at(detour.times)
    q, qd = detour.motion(t)[:2]
    return t, np.linalg.norm(tip_velocity(machine, q, qd), axis=1), feed_at(detour.commanded.run, detour.abreast(t))


def above_feed(detour: Course, machine: Machine | None) -> tuple[float, float]:
    """Largest share of the feed by which the tip is above it on a detour, and the last time when it is [s]."""
    if machine is None:
        return 0.0, 0.0
    t, speed, feed = tip_speed(detour, machine)
    ratio = speed / feed
    over = np.flatnonzero(ratio > DETOUR)
    if len(over) == 0:
        return 0.0, 0.0
    return float(ratio.max()) - 1.0, float(t[min(over[-1] + 1, len(t) - 1)])
