"""Checks of joint limits, of rest at both ends and of derivative columns, from finite differences of positions."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from toolpace.common.arrays import Floats, Ints
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
_EPS = float(np.finfo(np.float64).eps)
"""Relative distance from 1 to the next number: rounding is at most half of it."""
COLUMN_ROUNDING = 1e-9
"""Relative error of the set-points' own derivatives, which are worked out, not differenced.

As a share of the mean jerk no test holds it: JUMPS grants a window far more of that.
"""
WINDOW = 256
"""Steps over which the column of jerks is compared with the accelerations."""
JUMPS = 2.0
"""Jumps of a jerk by its largest value that may hide between set-points in one window."""
CHANGE = 2.0
"""Share of the change of the mean jerk from step to step by which the jerk may stray from its mean."""
SAG = 12.0
"""By how much a jerk that swings within a step may stray from its mean at the ends, for each unit by which the mean
acceleration is off that of both ends, a step: 6 for a triangle of the length of a step, 2 pi for a sine."""
SPREADS = 4.0
"""Standard deviations by which more swings may be met by set-points than are expected."""


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
    noise = 4.0 * _EPS * float(np.abs(points.t).max())
    ok = bool(step > 0.0 and off[worst] <= EVENNESS * abs(step) + noise)
    time, block = float(points.t[worst]), int(points.block[worst])
    if step <= 0.0:
        return step, [Check("time step", math.nan, 0.0, "s", False, time, block, note="time does not run forward")]
    return step, [
        Check("unevenness of the time step", float(off[worst]), EVENNESS * step, "s", ok, time, block, noise=noise)
    ]


def position_noise(q: Floats, t: Floats, speed: float) -> float:
    """How far a position may be off by rounding: a few units in the last place of it and of its time."""
    return _EPS * (4.0 * max(float(np.abs(q).max()), 1.0) + speed * float(np.abs(t).max()))


def motion_checks(
    points: SetPoints, limits: Limits, units: Sequence[str], dt: float, rounding: Callable[[], Floats] | None = None
) -> list[Check]:
    """Velocity, acceleration and jerk of every joint.

    The k-th difference over dt^k is a mean of the k-th derivative with a positive weight (a B-spline, Peano),
    so a motion within its limits never shows more. Rounding of positions adds 2^k noise / dt^k. A jump in
    position, velocity or acceleration shows as too much velocity, acceleration or jerk: continuity needs no
    check of its own. `rounding` tells what positions (n, m) may be off by beside that; it is asked where a limit seems
    to be passed.
    """
    checks = []
    for order, kind in enumerate(_KINDS, start=1):
        for j, joint in enumerate(points.joints):
            limit = float(getattr(limits, kind)[j])
            q = points.q[:, j]
            noise = 2.0**order * position_noise(q, points.t, float(np.abs(points.qd[:, j]).max())) / dt**order
            value, at = largest_difference(q, points.t, order, dt)
            if value > limit * (1.0 + TOLERANCE) + noise and rounding is not None:
                value, at = largest_difference(q, points.t, order, dt, rounding()[:, j])
            column = np.abs((points.qd, points.qdd, points.qddd)[order - 1][:, j])
            worst = int(np.argmax(column))
            note = ""
            if column[worst] > max(value, limit * (1.0 + TOLERANCE)):
                value, at, note = float(column[worst]), worst, "by the set-point's own derivative"
            ok = value <= limit * (1.0 + TOLERANCE) + noise
            time, block = float(points.t[at]), int(points.block[at])
            unit = unit_of(units[j], order)
            checks.append(Check(kind, value, limit, unit, ok, time, block, joint, note, noise=noise))
    return checks


def largest_difference(
    q: Floats, t: Floats, order: int, dt: float, rounding: Floats | None = None
) -> tuple[float, int]:
    """Largest |difference| / dt^order and the set-point in its middle; a shorter last step by divided
    differences. What `rounding` (n,) of the positions may make of it is taken off."""
    n = len(q)
    if n <= order:
        return 0.0, 0
    value, at = 0.0, 0
    short = t[-1] - t[-2] < 0.999 * dt
    even = np.abs(np.diff(q[: n - 1] if short else q, n=order))
    if rounding is not None:
        most = rounding[: len(even)]
        for k in range(1, order + 1):
            most = np.maximum(most, rounding[k : k + len(even)])
        even = np.maximum(even - 2.0**order * most, 0.0)
    if len(even):
        k = int(np.argmax(even))
        value, at = float(even[k]) / dt**order, k + order // 2
    if short:
        # The span, not the short step, is what a divided difference of order k is divided by last.
        times, table = t[n - 1 - order :], q[n - 1 - order :]
        for k in range(1, order + 1):
            table = np.diff(table) / (times[k:] - times[:-k])
        tail = abs(float(table[0])) * math.factorial(order)
        shortest = max(float(t[-1] - t[-2]) / dt, 1e-9)
        tail -= 2.0**order * 8.0 * _EPS * max(float(np.abs(q).max()), 1.0) / (dt**order * shortest)
        if tail > value:
            value, at = tail, n - 1
    return value, at


def rest_checks(points: SetPoints, limits: Limits, units: Sequence[str], dt: float) -> list[Check]:
    """Rest at start and end: from rest, the first step is at most J dt^3 / 6 (or a dt^2 / 2, or v dt)."""
    most = still_step(limits, dt)
    checks = []
    for name, first, second in (("start", 0, 1), ("end", len(points) - 1, len(points) - 2)):
        moved = np.abs(points.q[first] - points.q[second])
        own = np.abs(points.qd[first]) * dt
        off = np.maximum(moved, own)
        noise = 4.0 * _EPS * np.maximum(np.abs(points.q).max(axis=0), 1.0)
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


def column_checks(points: SetPoints, limits: Limits, units: Sequence[str], dt: float) -> list[Check]:
    """Whether positions, velocities and accelerations are one another's derivatives, by the trapezoidal rule.

    Its error over a step is at most J dt^3 / 12 for a velocity with |jerk| <= J, and J dt^2 / 4 for an
    acceleration whose slope is at most J. Where the jerk is too high (which is said already), accelerations may jump:
    a jump by D shows as a third difference of at least D / (2 dt), and is off by at most D dt^2 / 8 and D dt / 2. Where
    nothing limits the jerk, twice that is granted: several jumps may lie side by side, and hide one another in part.

    Where nothing limits acceleration nor jerk, velocities may jump: by V, by which the mean velocity changes from the
    step before to that behind (it is zero before and behind the motion), and a velocity is off by at most V dt / 2. The
    acceleration at a set-point says nothing there, and is not judged.
    """
    checks = []
    jumpy = ~np.isfinite(limits.acceleration) & ~np.isfinite(limits.jerk)
    steps = np.diff(points.t)
    shown = [largest_difference(points.q[:, j], points.t, 3, dt)[0] for j in range(len(points.joints))]
    for name, below, above, power, share, of_shown in (
        ("velocity", points.q, points.qd, 3, 12.0, 4.0),
        ("acceleration", points.qd, points.qdd, 2, 4.0, 1.0),
    ):
        for j, joint in enumerate(points.joints):
            jerk = float(limits.jerk[j])
            allowed = jerk * (1.0 + TOLERANCE) * dt**power / share
            if not math.isfinite(jerk):
                allowed = 2.0 * shown[j] * dt**power / of_shown
            elif shown[j] > jerk * (1.0 + TOLERANCE):
                allowed = max(allowed, shown[j] * dt**power / of_shown)
            if not len(steps) or (jumpy[j] and name == "acceleration"):
                continue
            off = np.abs(np.diff(below[:, j]) - 0.5 * steps * (above[1:, j] + above[:-1, j]))
            if jumpy[j]:
                change = np.abs(np.diff(np.diff(below[:, j]) / steps, prepend=0.0, append=0.0))
                off -= steps * (change[:-1] + change[1:])
            worst = int(np.argmax(off))
            scale = float(np.abs(below[:, j]).max())
            noise = 2.0 * position_noise(below[:, j], points.t, float(np.abs(above[:, j]).max()))
            noise += COLUMN_ROUNDING * dt * scale
            ok = bool(off[worst] <= allowed + noise)
            if not ok:
                time, block = float(points.t[worst]), int(points.block[worst])
                unit = unit_of(units[j], 0 if name == "velocity" else 1)
                note = f"the {name} column is not the derivative of its neighbour"
                checks.append(Check(f"{name} column", float(off[worst]), allowed, unit, ok, time, block, joint, note))
    note = "not judged: nothing limits acceleration nor jerk"
    free = [points.joints[j] for j in np.flatnonzero(jumpy)]
    checks += [Check("acceleration column", math.nan, 0.0, "", True, joint=joint, note=note) for joint in free]
    return checks + _jerk_columns(points, np.flatnonzero(~jumpy), units, steps)


def _jerk_columns(points: SetPoints, judged: Ints, units: Sequence[str], steps: Floats) -> list[Check]:
    """Whether the accelerations change as the jerks say.

    A jerk may jump between two set-points, and then the mean of both is not that of the step. By how much, the means
    of the steps tell: summed over a window, what is off is at most half of what they change, unless the jerk jumps
    there and back within a step. Then accelerations sag between set-points, and velocities tell by how much: also
    where the jerk swings once a step, and its column shows one side of the swing for long, as the phase creeps on.
    Where a motion is so slow, or the steps are so long, that all of a swing is over before it shows in the
    accelerations, a column holds the whole jerk wherever a set-point meets one (`_hidden`).
    A column of another motion, of no motion, or turned round, is off by all of the jerk.
    """
    checks: list[Check] = []
    if len(steps) < 2:
        return checks
    for j in judged:
        joint = points.joints[j]
        mean = np.diff(points.qdd[:, j]) / steps
        off = np.abs(mean - 0.5 * (points.qddd[1:, j] + points.qddd[:-1, j]))
        change = np.abs(np.diff(mean, prepend=mean[0]))
        between = np.diff(points.qd[:, j]) / steps - 0.5 * (points.qdd[1:, j] + points.qdd[:-1, j])
        sag = np.abs(between) / steps
        noise = COLUMN_ROUNDING * float(np.abs(points.qdd[:, j]).max()) / steps + COLUMN_ROUNDING * np.abs(mean).max()
        starts = np.arange(0, len(steps), WINDOW)
        found = np.add.reduceat(off, starts)
        # What changes just before and behind a window may belong to a step in it.
        total = np.concatenate(([0.0], np.cumsum(change)))
        around = total[np.minimum(starts + WINDOW + 2, len(steps))] - total[np.maximum(starts - 2, 0)]
        peak = np.maximum.reduceat(np.maximum(np.abs(points.qddd[1:, j]), np.abs(points.qddd[:-1, j])), starts)
        swing, more = _hidden(sag, peak, starts)
        allowed = CHANGE * around + JUMPS * np.maximum(np.abs(mean).max(), peak) + more
        allowed += np.add.reduceat(np.maximum(SAG * sag, swing) + noise, starts)
        worst = int(np.argmax(found - allowed))
        if found[worst] > allowed[worst]:
            k, count = int(starts[worst]), min(WINDOW, len(steps) - int(starts[worst]))
            time, block = float(points.t[k]), int(points.block[k])
            value, limit = float(found[worst]) / count, float(allowed[worst]) / count
            note = "the jerk column is not the derivative of the accelerations, in the mean of a window"
            checks.append(Check("jerk column", value, limit, unit_of(units[j], 3), False, time, block, joint, note))
    return checks


def _hidden(sag: Floats, peak: Floats, starts: Ints) -> tuple[Floats, Floats]:
    """By how much (steps,) swings of the jerk that are over within a step let it stray from its mean, as expected, and
    (windows,) how much more a window may happen to have.

    A jerk of J one way for a time T, and the other way for as long, is a change in velocity of J T^2 that no
    acceleration shows: the mean acceleration of the step is off by J T^2 / dt, its `sag` by dt. So the swing lasts
    2 T = 2 dt (sag / J)^(1/2), a set-point meets it in as large a share of the cases, and the column then is off by J:
    2 (J sag)^(1/2) as expected. How many of n are met has a variance of n at most. J is the `peak` of the window.
    """
    steps = np.diff(np.append(starts, len(sag)))
    swing = 2.0 * np.sqrt(np.repeat(peak, steps) * sag)
    return swing, SPREADS * np.sqrt(peak * np.add.reduceat(swing, starts))
