"""The log of a control that goes along single axes from rest to rest with limited jerk, in closed form."""

from __future__ import annotations

import math

import numpy as np

from toolpace.controls.fitting.motion_log import MotionLog, trimmed


def duration(length: float, speed: float, acceleration: float, jerk: float) -> tuple[float, float]:
    """Peak speed and time from rest to rest [m/s], [s]: half of the way of both ramps is the mean of their speeds."""

    def ramp(peak: float) -> float:
        if peak * jerk >= acceleration**2:
            return peak / acceleration + acceleration / jerk
        return 2.0 * math.sqrt(peak / jerk)

    low, high = 0.0, speed
    if speed * ramp(speed) > length:
        for _ in range(100):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if middle * ramp(middle) < length else (low, middle)
    peak = high
    return peak, 2.0 * ramp(peak) + (length - peak * ramp(peak)) / peak


def s_curve(length: float, speed: float, acceleration: float, jerk: float, t: np.ndarray) -> np.ndarray:
    """Positions (n,) at times within the motion."""
    peak, total = duration(length, speed, acceleration, jerk)
    build = min(acceleration / jerk, math.sqrt(peak / jerk))
    top = peak / (jerk * build) - build
    s, v, a, began, place = 0.0, 0.0, 0.0, 0.0, np.zeros(len(t))
    cruise = total - 2.0 * (2.0 * build + top)
    for span, j in zip((build, top, build, cruise, build, top, build), (jerk, 0.0, -jerk, 0.0, -jerk, 0.0, jerk)):
        u = np.clip(t - began, 0.0, span)
        rows = (t >= began) if began else np.ones(len(t), dtype=bool)
        place[rows] = (s + v * u + a * u**2 / 2.0 + j * u**3 / 6.0)[rows]
        s += v * span + a * span**2 / 2.0 + j * span**3 / 6.0
        v, a, began = v + a * span + j * span**2 / 2.0, a + j * span, began + span
    return place


def log_of_lines(
    ways: list[tuple[int, float]], speed: float, acceleration: list[float], jerk: list[float], dt: float,
    noise: float = 0.0, seed: int = 0,
) -> MotionLog:  # fmt: skip
    """Joint positions (n, axes) with rest before and after; ways are axis and length, each from rest to rest."""
    times = [duration(abs(way), speed, acceleration[axis], jerk[axis])[1] for axis, way in ways]
    ends = np.cumsum(times)
    t = np.arange(-50.0 * dt, ends[-1] + 50.0 * dt, dt)
    q = np.zeros((len(t), len(acceleration)))
    for (axis, way), end, spent in zip(ways, ends, times):
        local = np.clip(t - (end - spent), 0.0, spent)
        q[:, axis] += np.sign(way) * s_curve(abs(way), speed, acceleration[axis], jerk[axis], local)
    moved = np.ptp(q, axis=0) > 0.0
    measured = q + noise * np.random.default_rng(seed).normal(size=q.shape) * moved
    return trimmed(dt, measured)
