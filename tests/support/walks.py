"""Random five-axis programs and motions along them, right, or wrong by a known amount; from rest to rest in each block.

What a matching finds hard: programs that go back over their own line, plunge and retract, cross themselves, turn the
tool to and fro, wait, and ask for another feed in another pass.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from tests.support import motions
from toolpace.motion.setpoints import SetPoints
from toolpace.programs.toolpath import ToolPath

TIP, AXIS = 10e-6, 1e-3
"""Tolerances [m], [rad]."""
DT = 1e-3
MACHINE = motions.machine()
KINDS = ("retrace", "peck", "loop", "spiral", "zigzag", "wander", "crossing", "turns")
PEAK = 2.1875
"""Highest speed of a smooth step over its mean."""
USED = 0.97
"""Share of the feed that is used at the peak."""


@dataclass
class Walk:
    """A motion along poses (k, 5) of tip [m] and rotary joints C, A [rad]: from each to the next in so many seconds."""

    poses: np.ndarray
    seconds: np.ndarray
    dwell: np.ndarray
    """(k,) standing at each pose [s]."""
    block: np.ndarray
    """(k,) of the way to each pose."""
    bumps: list = field(default_factory=list)
    """(way, displacement (5,)) that is reached in the middle of a way."""
    flowing: frozenset = frozenset()
    """Poses that are passed at full speed, with the ways before and behind as long as one another."""


def random_walk(seed):
    """A program, and the right motion along it."""
    r = np.random.default_rng(seed)
    kind = KINDS[seed % len(KINDS)]
    poses = random_poses(r, kind)
    n = len(poses)
    feed = r.choice([0.02, 0.05, 0.1], n) if r.random() < 0.7 else np.full(n, 0.05)
    dwell = np.where(r.random(n) < 0.15, r.choice([0.02, 0.05, 0.2], n), 0.0)
    stop = (r.random(n) < 0.3) | (dwell > 0.0)
    stop[[0, -1]] = True
    program = ToolPath(
        tip=np.ascontiguousarray(poses[:, :3]),
        axis=MACHINE.axis_at(np.ascontiguousarray(poses[:, 3:])),
        feed=np.concatenate(([np.inf], feed[1:])),
        least_time=np.zeros(n),
        block=np.arange(n) * 3 + 7,
        stop=stop,
        dwell=dwell,
        rotary=np.ascontiguousarray(poses[:, 3:]),
        rotary_joints=tuple(MACHINE.joints[i] for i in MACHINE.rotary),
    )
    return program, Walk(poses, least_seconds(poses, feed), dwell.copy(), program.block.copy()), r


def random_poses(r, kind):
    """Poses (k, 5) of 4 to 25 blocks, each unlike the one before."""
    n = int(r.integers(4, 25))
    size = 10.0 ** r.uniform(-4.0, -2.7)
    tilt = r.uniform(0.2, 0.8)
    tip, turn = np.zeros((n, 3)), np.zeros((n, 2))
    if kind == "retrace":
        line = np.cumsum(r.normal(0.0, size, (int(r.integers(2, 5)), 3)), axis=0)
        tip = np.concatenate([line if k % 2 == 0 else line[::-1] for k in range(int(r.integers(2, 6)))])
        turn = np.zeros((len(tip), 2))
    elif kind == "peck":
        depth = np.cumsum(r.uniform(0.3, 1.0, n)) * size
        rows = [[0.0, 0.0, 0.0]]
        for d in depth[: n // 2]:
            rows += [[0.0, 0.0, -d], [0.0, 0.0, r.choice([0.0, -d + 3.0 * TIP, size])]]
        tip, turn = np.array(rows), np.zeros((len(rows), 2))
    elif kind == "loop":
        angle = np.linspace(0.0, r.uniform(1.0, 3.0) * 2.0 * np.pi, n)
        tip[:, 0], tip[:, 1] = size * np.cos(angle) + r.uniform(0.0, 0.3) * size * angle, size * np.sin(angle)
    elif kind == "spiral":
        angle = np.linspace(0.0, 4.0 * np.pi, n)
        tip[:, 0], tip[:, 1] = 1.5 * TIP * angle * np.cos(angle), 1.5 * TIP * angle * np.sin(angle)
        tip[:, 2] = size * r.random() * angle / 10.0
    elif kind == "zigzag":
        turn[:, 1] = np.where(np.arange(n) % 2, r.uniform(0.002, 0.03), 0.0)
        tip[:, 0] = size * np.arange(n) * r.choice([0.0, 0.02, 1.0])
    elif kind == "wander":
        tip, turn = np.cumsum(r.normal(0.0, size, (n, 3)), axis=0), np.cumsum(r.normal(0.0, 0.02, (n, 2)), axis=0)
    elif kind == "crossing":
        tip[:, 0] = np.cumsum(r.choice([-1.0, 1.0, 1.0], n)) * size
        tip[:, 1] = np.cumsum(r.choice([-1.0, 0.0, 1.0], n)) * size
    else:
        n = min(n, 8)
        tip, turn = tip[:n], turn[:n]
        turn[:, 0] = np.arange(n) * r.uniform(0.5, 2.0)
        tip[:, 0] = np.arange(n) * r.choice([0.0, 1e-6, size])
        tilt = r.choice([0.3 * AXIS, 2.0 * AXIS, 0.02])
    poses = np.hstack((tip, turn + np.array([0.3, tilt])))
    return poses[np.concatenate(([True], np.abs(np.diff(poses, axis=0)).max(axis=1) > 1e-9))]


def least_seconds(poses, feed):
    """(k,) of the way to each pose: a smooth step whose peak just uses the feed, and turns at most 30 rad/s."""
    step = np.diff(poses, axis=0)
    length, turn = np.linalg.norm(step[:, :3], axis=1), np.abs(step[:, 3:]).max(axis=1)
    seconds = np.maximum(np.maximum(PEAK * length / (USED * feed[1:]), PEAK * turn / 30.0), 0.012)
    return np.concatenate(([0.0], seconds))


def smooth_step(u):
    """From 0 to 1 with three derivatives at rest at both ends."""
    return u**4 * (35.0 - 84.0 * u + 70.0 * u**2 - 20.0 * u**3)


def set_points(walk, wobble=0.0, phase=0.0):
    """The motion, sampled, and the machine just fast enough for it; `wobble` is how far it strays [tolerances]."""
    starts = np.cumsum(walk.seconds + np.concatenate(([0.0], walk.dwell[:-1])))  # arrival at each pose
    starts = starts + 0.0
    end = starts[-1] + walk.dwell[-1]
    t = np.arange(int(np.ceil(end / DT)) + 1) * DT
    leave = starts + walk.dwell
    way = np.clip(np.searchsorted(leave, t, side="right"), 1, len(starts) - 1)
    u = np.clip((t - leave[way - 1]) / walk.seconds[way], 0.0, 1.0)
    share = smooth_step(u)
    for k in walk.flowing:
        # two ways as one: half the step each, run through in the middle
        before, after = way == k, way == k + 1
        share[before] = 2.0 * smooth_step(0.5 * u[before])
        share[after] = 2.0 * smooth_step(0.5 + 0.5 * u[after]) - 1.0
    poses = walk.poses[way - 1] + share[:, None] * (walk.poses[way] - walk.poses[way - 1])
    for at, displacement in walk.bumps:
        here = way == at
        poses[here] += (smooth_step(np.minimum(2.0 * share[here], 2.0 - 2.0 * share[here])))[:, None] * displacement
    place = way - 1 + share
    for column, size in ((0, TIP), (1, TIP), (2, TIP), (3, AXIS)):
        poses[:, column] += wobble * size / np.sqrt(3.0) * np.sin(2.0 * place + phase * (column + 1))
    q = MACHINE.joints_at(np.ascontiguousarray(poses[:, :3]), np.ascontiguousarray(poses[:, 3:]))
    tip, axis = MACHINE.forward(q)
    qd = np.gradient(q, DT, axis=0)
    points = SetPoints(t, q, qd, 0.0 * q, 0.0 * q, tip, axis, walk.block[way], MACHINE.joints)
    peaks = [np.abs(np.diff(q, n=k, axis=0)).max(axis=0) / DT**k * 1.05 + 1e-6 for k in (1, 2, 3)]
    return points, motions.with_limits(MACHINE, velocity=peaks[0], acceleration=peaks[1], jerk=peaks[2])


def without(walk, i, j):
    """The motion goes from pose i - 1 to pose j at once."""
    keep = np.r_[0:i, j : len(walk.poses)]
    kept = {name: getattr(walk, name)[keep] for name in ("poses", "seconds", "dwell", "block")}
    return replace(walk, **kept)
