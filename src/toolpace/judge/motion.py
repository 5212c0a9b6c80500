"""Checks of joint limits, of rest at both ends and of derivative columns, from finite differences of positions."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from toolpace.common.arrays import Bools, Floats, Ints
from toolpace.judge.seen_motion import EPS, WINDOW, SeenMotion, ends_sooner, still_step
from toolpace.judge.verification import Check
from toolpace.machine.limit_curves import CurvedLimit
from toolpace.machine.limits import Limits
from toolpace.machine.rows import Rows
from toolpace.motion.setpoints import ROWS, SetPoints, SetPointSource

TOLERANCE = 1e-4
"""Share of a limit by which it may be exceeded."""

EVENNESS = 1e-9
"""Share of the time step by which one step may differ from another: rounding of times that were added up."""
_KINDS = ("velocity", "acceleration", "jerk")
"""First, second and third derivative."""
_PER = ("s", "s2", "s3")
"""What their units are divided by."""
COLUMN_ROUNDING = 1e-9
"""Relative error of the set-points' own derivatives, which are worked out, not differenced.

As a share of the mean jerk no test holds it: JUMPS grants a window far more of that.
"""
JUMPS = 2.0
"""Jumps of a jerk by its largest value that may hide between set-points in one window."""
CHANGE = 2.0
"""Share of the change of the mean jerk from step to step by which the jerk may stray from its mean."""


def unit_of(base: str, order: int) -> str:
    """The unit of the order-th derivative of a joint measured in `base` ("m", "rad" or, unknown, "")."""
    return base if order == 0 else f"{base or '1'}/{_PER[order - 1]}"


def step_check(points: SetPointSource) -> tuple[float, list[Check]]:
    """The time step [s], and whether it is the same all through (the last one may be shorter)."""
    if len(points) < 2:
        return math.nan, [Check("set-points", float(len(points)), 2.0, "", False, at_least=True, note="too few")]
    count, last = len(points), points.times(np.arange(len(points) - 2, len(points)))
    spans = [(begin, min(begin + ROWS, count - 1)) for begin in range(0, count - 1, ROWS)]
    # of blocks, so that not all times are needed at once
    step = float(np.median([np.median(np.diff(points.times(np.arange(begin, end + 1)))) for begin, end in spans]))
    sooner = bool(0.0 < last[1] - last[0] < step)
    off, worst, latest = -1.0, 0, 0.0
    for begin, end in spans:
        t = points.times(np.arange(begin, end + 1))
        latest = max(latest, float(np.abs(t).max()))
        here = np.abs(np.diff(t[:-1] if sooner and end == count - 1 else t) - step)
        if here.max(initial=-1.0) > off:
            off, worst = float(here.max()), begin + int(np.argmax(here))
    noise = 4.0 * EPS * latest
    there = points.rows(worst, worst + 1)
    time, block = float(there.t[0]), int(there.block[0])
    if step <= 0.0:
        return step, [Check("time step", math.nan, 0.0, "s", False, time, block, note="time does not run forward")]
    off = max(off, 0.0)
    ok = off <= EVENNESS * step + noise
    return step, [Check("unevenness of the time step", off, EVENNESS * step, "s", ok, time, block, noise=noise)]


def position_noise(position: float, time: float, speed: float) -> float:
    """How far a position may be off by rounding: a few units in the last place of it and of its time.

    All three are the largest there are, without sign.
    """
    return EPS * (4.0 * max(position, 1.0) + speed * time)


def motion_checks(
    seen: SeenMotion,
    limits: Limits,
    units: Sequence[str],
    beyond: Callable[[int, int], tuple[float, int]] | None = None,
) -> list[Check]:
    """Velocity, acceleration and jerk of every joint.

    The k-th difference over dt^k is a mean of the k-th derivative with a positive weight (a B-spline, Peano),
    so a motion within its limits never shows more. Rounding of positions adds 2^k noise / dt^k. A jump in
    position, velocity or acceleration shows as too much velocity, acceleration or jerk: continuity needs no
    check of its own. Where a limit seems to be passed, `beyond` tells the largest difference of an order and a joint
    less what positions may be off by beside that.
    """
    checks, peaks, dt = [], seen.peaks, seen.peaks.dt
    for order, kind in enumerate(_KINDS, start=1):
        column = peaks.columns[order - 1]
        for j, joint in enumerate(seen.joints):
            limit = float(getattr(limits, kind)[j])
            speed = float(peaks.columns[0].value[j])
            noise = 2.0**order * position_noise(float(peaks.position[j]), peaks.time, speed) / dt**order
            value, at = peaks.difference(order, j)
            if value > limit * (1.0 + TOLERANCE) + noise and beyond is not None:
                value, at = beyond(order, j)
            note = ""
            if column.value[j] > max(value, limit * (1.0 + TOLERANCE)):
                value, at, note = float(column.value[j]), int(column.row[j]), "by the set-point's own derivative"
            ok = value <= limit * (1.0 + TOLERANCE) + noise
            time, block = seen.place(at)
            unit = unit_of(units[j], order)
            checks.append(Check(kind, value, limit, unit, ok, time, block, joint, note, noise=noise))
    return checks


def curve_checks(
    source: SetPointSource, limits: Limits, units: Sequence[str], dt: float, even: int
) -> list[Check]:
    """Limits that fall with the speed of their joint, over the `even` first set-points, which come at equal steps.

    A second or third difference is a mean of the acceleration or jerk, and so is within the mean of the limits there.
    That is the limit at the mean speed where the curve is straight, less where it is concave, and where it is convex at
    most the mean of those at the ends. Nothing is asked of the planner's own speeds.
    """
    checks = []
    for curve in limits.curves:
        j, order = limits.joints.index(curve.joint), 2 + (curve.kind == "jerk")
        name, unit, used = f"{curve.kind} over speed", unit_of(units[j], order), 0.0
        worst = Check(name, 0.0, curve.largest, unit, True, joint=curve.joint)
        for begin in range(0, max(even - order, 0), ROWS):
            part = source.rows(begin, min(begin + ROWS + order, even))
            q = part.q[:, j]
            value, step = np.diff(q, order) / dt**order, np.diff(q) / dt
            first, last = step[: len(value)], step[order - 1 :]
            mean = (q[order:] - q[: len(value)]) / (order * dt)
            limit = np.maximum(
                limit_over_speed(curve, mean, value),
                (limit_over_speed(curve, first, value) + limit_over_speed(curve, last, value)) / 2.0,
            )
            turns = first * last <= 0.0
            # about a turn, where braking ends and speeding up begins
            at_rest = [curve.largest] if curve.sides == "speeding up" else limit_over_speed(curve, 0.0 * value, value)
            limit = np.where(turns, at_rest, limit)
            speed = float(np.abs(step).max(initial=0.0))
            rounding = position_noise(float(np.abs(q).max()), float(np.abs(part.t).max()), speed)
            noise = 2.0**order * rounding / dt**order
            share = (np.abs(value) - noise) / limit
            k = int(share.argmax())
            if share[k] > used:
                used, at = float(share[k]), k + order // 2
                ok = used <= 1.0 + TOLERANCE
                worst = Check(
                    name, abs(float(value[k])), float(limit[k]), unit, ok, float(part.t[at]),
                    int(part.block[at]), curve.joint, f"at {abs(float(mean[k])):.4g} {unit_of(units[j], 1)}",
                    noise=noise,
                )  # fmt: skip
        checks.append(worst)
    return checks


def limit_over_speed(curve: CurvedLimit, speed: Floats, pushed: Floats) -> Floats:
    """(n,) the limit at speeds (n,) for accelerations or jerks with these signs (n,): straight between corners."""
    limits = [np.interp(np.abs(speed), each.speed, each.limit) for each in curve.curves]
    forth = pushed * speed >= 0.0 if curve.sides == "speeding up" else pushed >= 0.0
    limit: Floats = np.where(forth, limits[0], limits[-1])
    return limit


def row_checks(points: SetPoints, rows: Sequence[Rows], dt: float) -> list[Check]:
    """Rows of one's own, by the time alone.

    Of a quantity its second or third difference is a mean of its acceleration or jerk, as `motion_checks` has it. Rows
    without one get the joints' derivatives by time in place of those by the path: with the time as the parameter z is
    1 and does not change, so that a row is its last coefficient.
    """
    checks = []
    for each in rows:
        order = each.order + 1
        if each.quantity is not None and each.lines is None:
            p = np.asarray(each.quantity(points.q), dtype=float).reshape(len(points), -1)
            uneven = ends_sooner(points.t, dt)
            shown = np.abs(np.diff(p[: len(p) - uneven], order, axis=0)) / dt**order
            speed = float(np.abs(np.diff(p, axis=0)).max(initial=0.0)) / dt
            rounding = position_noise(float(np.abs(p).max()), float(np.abs(points.t).max()), speed)
            noise = 2.0**order * rounding / dt**order
        else:
            moment = np.stack([points.q, points.qd, points.qdd, points.qddd])
            noise = 0.0
            if each.lines is None:
                shown = np.abs(each.shares(moment)[:, :, 0]) * each.limit
            else:
                state = np.stack([points.t, np.ones(len(points)), np.zeros(len(points)), np.zeros(len(points))])
                shown = each.ratio(moment, state)[:, None] * each.limit
        at = int(shown.max(axis=1).argmax()) if len(shown) else 0
        value = float(shown.max(initial=0.0))
        ok = value <= each.limit * (1.0 + TOLERANCE) + noise
        time, block = float(points.t[at]), int(points.block[at])
        checks.append(Check(each.name, value, each.limit, each.unit, ok, time, block, noise=noise))
    return checks


def rest_checks(seen: SeenMotion, limits: Limits, units: Sequence[str]) -> list[Check]:
    """Rest at start and end: from rest, the first step is at most J dt^3 / 6 (or a dt^2 / 2, or v dt)."""
    dt = seen.peaks.dt
    most = still_step(limits, dt)
    noise = 4.0 * EPS * np.maximum(seen.peaks.position, 1.0)
    checks = []
    for name, points, first, second in (("start", seen.start, 0, 1), ("end", seen.end, -1, -2)):
        moved = np.abs(points.q[first] - points.q[second])
        own = np.abs(points.qd[first]) * dt
        off = np.maximum(moved, own)
        j = int(np.argmax(off / (most + noise)))
        ok = bool(off[j] <= most[j] * (1.0 + TOLERANCE) + 2.0 * noise[j])
        time, block = float(points.t[first]), int(points.block[first])
        unit = unit_of(units[j], 1)
        value, limit = float(off[j]) / dt, float(most[j]) / dt
        note = "speed in the first or last step; from rest the jerk limit allows no more"
        checks.append(Check(f"rest at the {name}", value, limit, unit, ok, time, block, seen.joints[j], note))
    return checks


def jumpy_joints(limits: Limits) -> Bools:
    """(m,) joints whose velocity may jump: nothing limits their acceleration nor jerk."""
    return ~np.isfinite(limits.acceleration) & ~np.isfinite(limits.jerk)


def column_checks(seen: SeenMotion, limits: Limits, units: Sequence[str]) -> list[Check]:
    """Whether positions, velocities and accelerations are one another's derivatives, by the trapezoidal rule.

    Its error over a step is at most J dt^3 / 12 for a velocity with |jerk| <= J, and J dt^2 / 4 for an
    acceleration whose slope is at most J. Where the jerk is too high (which is said already), accelerations may jump:
    a jump by D shows as a third difference of at least D / (2 dt), and is off by at most D dt^2 / 8 and D dt / 2. Where
    nothing limits the jerk, twice that is granted: several jumps may lie side by side, and hide one another in part.

    Where nothing limits acceleration nor jerk, velocities may jump: by V, by which the mean velocity changes from the
    step before to that behind (it is zero before and behind the motion), and a velocity is off by at most V dt / 2. The
    acceleration at a set-point says nothing there, and is not judged.
    """
    checks, peaks, jumpy = [], seen.peaks, jumpy_joints(limits)
    of_velocity, of_acceleration = seen.misfits
    scales = (peaks.position, *(column.value for column in peaks.columns))
    for order, name, misfit, share, of_shown in (
        (1, "velocity", of_velocity, 12.0, 4.0),
        (2, "acceleration", of_acceleration, 4.0, 1.0),
    ):
        period = peaks.dt ** (4 - order)
        for j, joint in enumerate(seen.joints):
            jerk, shown = float(limits.jerk[j]), peaks.difference(3, j)[0]
            allowed = jerk * (1.0 + TOLERANCE) * period / share
            if not math.isfinite(jerk):
                allowed = 2.0 * shown * period / of_shown
            elif shown > jerk * (1.0 + TOLERANCE):
                allowed = max(allowed, shown * period / of_shown)
            if jumpy[j] and name == "acceleration":
                continue
            scale, slope = float(scales[order - 1][j]), float(scales[order][j])
            noise = 2.0 * position_noise(scale, peaks.time, slope) + COLUMN_ROUNDING * peaks.dt * scale
            off, at = float(misfit.value[j]), int(misfit.row[j])
            if not off <= allowed + noise:
                time, block = seen.place(at)
                unit = unit_of(units[j], order - 1)
                note = f"the {name} column is not the derivative of its neighbour"
                checks.append(Check(f"{name} column", off, allowed, unit, False, time, block, joint, note))
    note = "not judged: nothing limits acceleration nor jerk"
    free = [seen.joints[j] for j in np.flatnonzero(jumpy)]
    checks += [Check("acceleration column", math.nan, 0.0, "", True, joint=joint, note=note) for joint in free]
    return checks + jerk_columns(seen, np.flatnonzero(~jumpy), units)


def jerk_columns(seen: SeenMotion, judged: Ints, units: Sequence[str]) -> list[Check]:
    """Whether the accelerations change as the jerks say.

    A jerk may jump between two set-points, and then the mean of both is not that of the step. By how much, the means
    of the steps tell: summed over a window, what is off is at most half of what they change, unless the jerk jumps
    there and back within a step. Then accelerations sag between set-points, and velocities tell by how much: also
    where the jerk swings once a step, and its column shows one side of the swing for long, as the phase creeps on.
    Where a motion is so slow, or the steps are so long, that all of a swing is over before it shows in the
    accelerations, a column holds the whole jerk wherever a set-point meets one (`_hidden`).
    A column of another motion, of no motion, or turned round, is off by all of the jerk.
    """
    windows, peaks = seen.jerks, seen.peaks
    if len(seen) < 3 or not len(judged):
        return []
    mean_jerk = peaks.mean_jerk[judged, None]
    noise = COLUMN_ROUNDING * (peaks.columns[1].value[judged, None] * windows.rate + mean_jerk * windows.steps)
    allowed = CHANGE * windows.around + JUMPS * np.maximum(mean_jerk, windows.peak) + windows.hidden + noise
    found, checks = windows.off, []
    for row, j in enumerate(judged):
        worst = int(np.argmax(found[row] - allowed[row]))
        if found[row, worst] > allowed[row, worst]:
            time, block = seen.place(worst * WINDOW)
            count = int(windows.steps[worst])
            value, limit = float(found[row, worst]) / count, float(allowed[row, worst]) / count
            note = "the jerk column is not the derivative of the accelerations, in the mean of a window"
            unit, joint = unit_of(units[j], 3), seen.joints[j]
            checks.append(Check("jerk column", value, limit, unit, False, time, block, joint, note))
    return checks
