"""The tip speed of a rejoin motion, and the feed that limits it."""

from __future__ import annotations

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.deflection.compensation import CompensatedRun
from toolpace.deflection.rejoin_motion import RejoinMotion
from toolpace.machine.limits import Limits
from toolpace.machine.machine import Machine
from toolpace.path.axis_run import AxisRun
from toolpace.path.follow_run import FollowRun
from toolpace.planning.limit_tolerances import DETOUR

STEP = 1e-6
"""Time by which joints are moved on to see the speed of the tip [s]: at speeds of 1 m/s and radii of 1 m the central
difference is off by 1e-12 of it, and by 1e-10 m/s of rounding."""
SAMPLES = 8
"""Looks at the tip in each step of a detour."""
HALVINGS = 30
"""Of the time between two looks, to find when the feed falls: a nanosecond of a second."""


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
    follow = on_program(run)
    if follow is None:
        return np.full(len(s), np.inf)
    feed: Floats = follow.run.feed[follow.run.block_index(s)]
    return feed


def feed_changes(rejoin: RejoinMotion, t: Floats) -> Floats:
    """(k,) ascending times just before and just behind the places where another feed begins, of a way back from t[0]
    to t[-1].

    Between two looks (n,) at ascending times the tip may be abreast of a block with a lower feed, or still go at the
    feed of the block before.
    """
    run = on_program(rejoin.commanded.run)
    if run is None:
        return np.empty(0)
    feed, begins = run.run.feed, run.run.block_start[1 : len(run.run.feed)]
    abreast = rejoin.abreast(t)
    # a place to rejoin may be one that was passed already
    forward = abreast[-1] >= abreast[0]
    first, last = (abreast[0], abreast[-1]) if forward else (abreast[-1], abreast[0])
    places = begins[(feed[1:] != feed[:-1]) & (begins > first) & (begins <= last)]
    if len(places) == 0:
        return np.empty(0)
    behind = np.clip(np.searchsorted(abreast if forward else -abreast, places if forward else -places), 1, len(t) - 1)
    low, high = t[behind - 1], t[behind]
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        order = np.argsort(middle, kind="stable")
        there = np.empty_like(middle)
        there[order] = rejoin.abreast(middle[order])
        passed = there >= places if forward else there < places
        low, high = np.where(passed, low, middle), np.where(passed, middle, high)
    found: Floats = np.sort(np.concatenate([low, high]))
    return found


def on_program(run: AxisRun) -> FollowRun | None:
    """The run that follows a program, compensated or not; None where there is none."""
    while isinstance(run, CompensatedRun):
        run = run.base
    return run if isinstance(run, FollowRun) else None


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


def sample_times(times: Floats) -> Floats:
    """(n,) times at which the tip is looked at, for the ends of steps (k + 1,)."""
    inside = np.arange(SAMPLES) / SAMPLES
    return np.append((times[:-1, None] + np.diff(times)[:, None] * inside).ravel(), times[-1])


def feed_used(rejoin: RejoinMotion, machine: Machine, t: Floats) -> Floats:
    """(n,) speed of the tip over the feed of where it is, at ascending times (n,) of a way back."""
    q, qd = rejoin.motion(t)[:2]
    feed = feed_at(rejoin.commanded.run, rejoin.abreast(t))
    if not np.isfinite(feed).any():
        return np.zeros(len(t))
    used: Floats = np.linalg.norm(tip_velocity(machine, q, qd), axis=1) / feed
    return used


def sampled_feed_use(rejoin: RejoinMotion, machine: Machine) -> tuple[Floats, Floats]:
    """Times (n,) of the looks at a way back, and the most (n,) of the feed used there and up to the next look."""
    t = sample_times(rejoin.times)
    used, changes = feed_used(rejoin, machine, t), feed_changes(rejoin, t)
    if len(changes):
        np.maximum.at(used, np.searchsorted(t, changes, side="right") - 1, feed_used(rejoin, machine, changes))
    return t, used


def above_feed(rejoin: RejoinMotion, machine: Machine | None) -> tuple[float, float]:
    """Largest share of the feed by which the tip is above it on a way back, and the last time when it is [s]."""
    if machine is None:
        return 0.0, 0.0
    t, ratio = sampled_feed_use(rejoin, machine)
    over = np.flatnonzero(ratio > DETOUR)
    if len(over) == 0:
        return 0.0, 0.0
    return float(ratio.max()) - 1.0, float(t[min(over[-1] + 1, len(t) - 1)])
