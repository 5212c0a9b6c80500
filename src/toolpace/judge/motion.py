"""Checks of the time step, of joint limits and of rest at both ends, from finite differences of positions."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.judge.peaks import EPS, Peaks, difference_beyond_rounding
from toolpace.judge.verification import Check
from toolpace.machine.limits import Limits
from toolpace.motion.setpoints import SetPoints

TOLERANCE = 1e-4
"""Share of a limit by which it may be exceeded."""

EVENNESS = 1e-9
"""Share of the time step by which one step may differ from another: rounding of times that were added up."""
_KINDS = ("velocity", "acceleration", "jerk")
"""First, second and third derivative."""
_PER = ("s", "s2", "s3")
"""What their units are divided by."""


def unit_of(base: str, order: int) -> str:
    """The unit of the order-th derivative of a joint measured in `base` ("m", "rad" or, unknown, "")."""
    return base if order == 0 else f"{base or '1'}/{_PER[order - 1]}"


def step_check(points: SetPoints) -> tuple[float, list[Check]]:
    """The time step [s], and whether it is the same all through (the last one may be shorter)."""
    if len(points) < 2:
        return math.nan, [Check("set-points", float(len(points)), 2.0, "", False, at_least=True, note="too few")]
    steps = np.diff(points.t)
    step = float(np.median(steps))
    even = steps[:-1] if 0.0 < steps[-1] < step else steps
    off = np.abs(even - step) if len(even) else np.zeros(1)
    worst = int(np.argmax(off))
    noise = 4.0 * EPS * float(np.abs(points.t).max())
    ok = bool(step > 0.0 and off[worst] <= EVENNESS * abs(step) + noise)
    time, block = float(points.t[worst]), int(points.block[worst])
    if step <= 0.0:
        return step, [Check("time step", math.nan, 0.0, "s", False, time, block, note="time does not run forward")]
    return step, [
        Check("unevenness of the time step", float(off[worst]), EVENNESS * step, "s", ok, time, block, noise=noise)
    ]


def position_noise(position: float, time: float, speed: float) -> float:
    """How far a position may be off by rounding: a few units in the last place of it and of its time.

    All three are the largest there are, without sign.
    """
    return EPS * (4.0 * max(position, 1.0) + speed * time)


def motion_checks(
    points: SetPoints, limits: Limits, units: Sequence[str], peaks: Peaks, rounding: Callable[[], Floats] | None = None
) -> list[Check]:
    """Velocity, acceleration and jerk of every joint.

    The k-th difference over dt^k is a mean of the k-th derivative with a positive weight (a B-spline, Peano),
    so a motion within its limits never shows more. Rounding of positions adds 2^k noise / dt^k. A jump in
    position, velocity or acceleration shows as too much velocity, acceleration or jerk: continuity needs no
    check of its own. `rounding` tells what positions (n, m) may be off by beside that; it is asked where a limit seems
    to be passed.
    """
    checks, dt = [], peaks.dt
    for order, kind in enumerate(_KINDS, start=1):
        column = peaks.columns[order - 1]
        for j, joint in enumerate(points.joints):
            limit = float(getattr(limits, kind)[j])
            speed = float(peaks.columns[0].value[j])
            noise = 2.0**order * position_noise(float(peaks.position[j]), peaks.time, speed) / dt**order
            value, at = peaks.difference(points, order, j)
            if value > limit * (1.0 + TOLERANCE) + noise and rounding is not None:
                value, at = difference_beyond_rounding(points.q[:, j], points.t, order, dt, rounding()[:, j])
            note = ""
            if column.value[j] > max(value, limit * (1.0 + TOLERANCE)):
                value, at, note = float(column.value[j]), int(column.row[j]), "by the set-point's own derivative"
            ok = value <= limit * (1.0 + TOLERANCE) + noise
            time, block = float(points.t[at]), int(points.block[at])
            unit = unit_of(units[j], order)
            checks.append(Check(kind, value, limit, unit, ok, time, block, joint, note, noise=noise))
    return checks


def rest_checks(points: SetPoints, limits: Limits, units: Sequence[str], peaks: Peaks) -> list[Check]:
    """Rest at start and end: from rest, the first step is at most J dt^3 / 6 (or a dt^2 / 2, or v dt)."""
    dt = peaks.dt
    most = still_step(limits, dt)
    noise = 4.0 * EPS * np.maximum(peaks.position, 1.0)
    checks = []
    for name, first, second in (("start", 0, 1), ("end", len(points) - 1, len(points) - 2)):
        moved = np.abs(points.q[first] - points.q[second])
        own = np.abs(points.qd[first]) * dt
        off = np.maximum(moved, own)
        j = int(np.argmax(off / (most + noise)))
        ok = bool(off[j] <= most[j] * (1.0 + TOLERANCE) + 2.0 * noise[j])
        time, block = float(points.t[first]), int(points.block[first])
        unit = unit_of(units[j], 1)
        value, limit = float(off[j]) / dt, float(most[j]) / dt
        note = "speed in the first or last step; from rest the jerk limit allows no more"
        checks.append(Check(f"rest at the {name}", value, limit, unit, ok, time, block, points.joints[j], note))
    return checks


def still_step(limits: Limits, dt: float) -> Floats:
    """(joints,) the most that each joint can move from rest in one step."""
    by_jerk, by_acceleration = limits.jerk * dt**3 / 6.0, limits.acceleration * dt**2 / 2.0
    least: Floats = np.minimum(np.minimum(by_jerk, by_acceleration), limits.velocity * dt)
    return least
