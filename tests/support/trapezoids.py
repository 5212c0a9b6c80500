"""A program of lines from rest to rest, and the log of a control that runs it by trapezoids, worked out by hand."""

from __future__ import annotations

import math

import numpy as np

from tests.support.timed_programs import machine
from toolpace.controls.fitting.motion_log import MotionLog

MACHINE = machine()


def trapezoids(ways: list[tuple[str, float]], feed: float, acceleration: dict[str, float], dt: float) -> np.ndarray:
    """Joint positions (n, 5) of lines along single axes, each from rest to rest, worked out by hand."""
    place, rows = np.zeros(5), [np.zeros((3, 5))]
    for axis, way in ways:
        a, length = acceleration[axis], abs(way)
        v = min(feed, math.sqrt(a * length))
        ramp, total = v / a, length / v + v / a
        t = np.minimum(np.arange(0.0, total + dt, dt), total)
        slowing = length - 0.5 * a * (total - t) ** 2
        s = np.where(t < ramp, 0.5 * a * t**2, np.where(t < total - ramp, v * (t - 0.5 * ramp), slowing))
        row = np.tile(place, (len(t), 1))
        row[:, MACHINE.joints.index(axis)] += np.sign(way) * s
        rows.append(row)
        place[MACHINE.joints.index(axis)] += way
    return np.vstack([*rows, place[None], place[None]])


WAYS = [("X", 0.05), ("Y", 0.03), ("X", -0.02), ("Z", 0.01), ("Y", -0.01), ("X", 0.004)]
REAL = {"X": 1.3, "Y": 0.8, "Z": 0.5}


def log_of(dt: float = 1e-3, noise: float = 0.0) -> MotionLog:
    q = trapezoids(WAYS, 0.08, REAL, dt)
    return MotionLog(dt, q + noise * np.random.default_rng(1).normal(size=q.shape) * (q.std(axis=0) > 0.0))


def program() -> str:
    place = dict.fromkeys("XYZ", 0.0)
    lines = ["G21 G90 G94 G61.1", "G0 X0 Y0 Z0 A0 C0"]
    for axis, way in WAYS:
        place[axis] += way * 1e3
        lines.append(f"G1 {axis}{place[axis]:.6f} F4800")
    return "\n".join([*lines, "M2", ""])
