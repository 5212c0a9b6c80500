"""Ramps of speed with limited jerk, in closed form: the acceleration is zero at both ends.

A ramp between the speeds u < w has up to three phases: jerk J up to the acceleration A, that acceleration, jerk down.
It takes T = (w - u) / A + A / J, or 2 ((w - u) / J)^(1/2) where A is not reached. It is symmetric, so that it goes
(u + w) T / 2.
"""

from __future__ import annotations

import math

from toolpace.kernels.jit import jit

POLISHING = 8
"""Steps of Newton's method; the start is close, and each doubles the figures that are right."""


@jit()
def ramp_time(change: float, acceleration: float, jerk: float) -> float:
    """Time of a ramp [s] over a change of speed, above or below zero."""
    change = abs(change)
    if change * jerk >= acceleration * acceleration:
        return change / acceleration + acceleration / jerk
    return 2.0 * math.sqrt(change / jerk)


@jit()
def ramp_distance(start: float, end: float, acceleration: float, jerk: float) -> float:
    """Distance of a ramp between two speeds [m]."""
    return 0.5 * (start + end) * ramp_time(end - start, acceleration, jerk)


@jit()
def reachable_speed(start: float, distance: float, acceleration: float, jerk: float) -> float:
    """Highest speed that a ramp from a speed reaches within a distance."""
    # where the acceleration is not reached, the root y of the change: y^3 + 2 start y = distance jerk^(1/2)
    root = cubic_root(2.0 * start, distance * math.sqrt(jerk))
    if root * root * jerk <= acceleration * acceleration:
        return start + root * root
    linear = 2.0 * start / acceleration + acceleration / jerk
    constant = 2.0 * start * acceleration / jerk - 2.0 * distance
    change = -2.0 * constant / (linear + math.sqrt(max(linear * linear - 4.0 * constant / acceleration, 0.0)))
    return start + max(change, 0.0)


@jit()
def cubic_root(linear: float, value: float) -> float:
    """The root y >= 0 of y^3 + linear y = value, neither below zero."""
    if value <= 0.0:
        return 0.0
    if linear <= 0.0:
        return float(value ** (1.0 / 3.0))
    scale = math.sqrt(linear / 3.0)
    ratio = value / (2.0 * scale * scale * scale)
    if ratio > 1e8:
        root = value ** (1.0 / 3.0)
    else:
        root = 2.0 * scale * math.sinh(math.asinh(ratio) / 3.0)
    for _ in range(2):
        root -= (root * root * root + linear * root - value) / (3.0 * root * root + linear)
    return float(root)


@jit()
def time_on_ramp(slow: float, fast: float, distance: float, acceleration: float, jerk: float) -> float:
    """Time [s] from the slow end of a ramp to a distance from there."""
    change = fast - slow
    if change <= 0.0:
        return distance / fast if fast > 0.0 else 0.0
    phase = min(acceleration / jerk, math.sqrt(change / jerk))
    whole = ramp_time(change, acceleration, jerk)
    first = slow * phase + jerk * phase**3 / 6.0
    if distance <= first:
        return cubic_root(6.0 * slow / jerk, 6.0 * distance / jerk)
    left = 0.5 * (slow + fast) * whole - distance
    if left <= fast * phase - jerk * phase**3 / 6.0:
        # fast t - jerk t^3 / 6 = left: concave, so that Newton's method rises to the root
        back = max(left, 0.0) / fast
        for _ in range(POLISHING):
            back -= (fast * back - jerk * back**3 / 6.0 - left) / (fast - 0.5 * jerk * back * back)
        return whole - min(back, phase)
    reached, steady = slow + 0.5 * jerk * phase * phase, jerk * phase
    further = distance - first
    return phase + 2.0 * further / (reached + math.sqrt(reached * reached + 2.0 * steady * further))


@jit()
def speed_on_ramp(slow: float, fast: float, distance: float, acceleration: float, jerk: float) -> float:
    """Speed at a distance from the slow end of a ramp."""
    change = fast - slow
    if change <= 0.0:
        return fast
    phase = min(acceleration / jerk, math.sqrt(change / jerk))
    time = time_on_ramp(slow, fast, distance, acceleration, jerk)
    whole = ramp_time(change, acceleration, jerk)
    if time <= phase:
        return slow + 0.5 * jerk * time * time
    if time >= whole - phase:
        return fast - 0.5 * jerk * (whole - time) ** 2
    return slow + jerk * phase * (time - 0.5 * phase)


@jit()
def peak_speed(
    start: float,
    end: float,
    distance: float,
    top: float,
    up_acceleration: float,
    up_jerk: float,
    down_acceleration: float,
    down_jerk: float,
) -> float:
    """Highest speed, at most `top`, from which both a ramp from `start` and one to `end` fit into a distance."""
    low, high = max(start, end), top
    if high <= low:
        return low
    for halving in range(60):
        middle = high if halving == 0 else 0.5 * (low + high)
        used = ramp_distance(start, middle, up_acceleration, up_jerk)
        used += ramp_distance(middle, end, down_acceleration, down_jerk)
        if used <= distance:
            low = middle
            if halving == 0:
                break
        else:
            high = middle
        if high - low <= 1e-15 * high:
            break
    return low
