"""Checks of joint limits, of rest at both ends and of derivative columns, from finite differences of positions."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from toolpace.common.arrays import Bools, Floats, Ints
from toolpace.judge.largest import EPS, Largest
from toolpace.judge.verification import Check
from toolpace.machine.limits import Limits
from toolpace.motion.setpoints import Block, SetPointSource

if TYPE_CHECKING:
    from toolpace.judge.seen_motion import SeenMotion

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
WINDOW = 256
"""Steps over which the column of jerks is compared with the accelerations; a block holds whole windows."""
AROUND = 2
"""Steps before and behind a window whose change of the mean jerk may belong to it."""
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


def step_check(points: SetPointSource) -> tuple[float, list[Check]]:
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
    time, block = float(points.t[worst]), int(points.rows(worst, worst + 1).block[0])
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


def still_step(limits: Limits, dt: float) -> Floats:
    """(joints,) the most that each joint can move from rest in one step."""
    by_jerk, by_acceleration = limits.jerk * dt**3 / 6.0, limits.acceleration * dt**2 / 2.0
    least: Floats = np.minimum(np.minimum(by_jerk, by_acceleration), limits.velocity * dt)
    return least


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


def largest_misfits(block: Block, begin: int, end: int, jumpy: Bools) -> tuple[Largest, Largest]:
    """By how much a step of positions is off the mean of the velocities at its ends, of velocities off that of the
    accelerations, at most in the steps from `begin` to `end`; of `jumpy` joints (m,) less what a jump of the velocity
    may make of it."""
    last = block.of_all - 1
    steps = np.diff(block.times(begin, end + 1))
    q, qd, qdd = (block.columns(name, begin, end + 1) for name in ("q", "qd", "qdd"))
    of_q, of_qd = (
        np.abs(np.diff(below, axis=1) - 0.5 * steps * (above[:, 1:] + above[:, :-1]))
        for below, above in ((q, qd), (qd, qdd))
    )
    if jumpy.any():
        before, behind = max(begin - 1, 0), min(end + 1, last)
        around = block.columns("q", before, behind + 1)[jumpy]
        mean = np.diff(around, axis=1) / np.diff(block.times(before, behind + 1))
        # the joint rests before and behind the motion
        mean = np.pad(mean, ((0, 0), (int(begin == 0), int(end == last))))
        change = np.abs(np.diff(mean, axis=1))
        of_q[jumpy] -= steps * (change[:, :-1] + change[:, 1:])
    return Largest.of(of_q, begin), Largest.of(of_qd, begin)


class JerkWindows(NamedTuple):
    """Of windows of WINDOW steps, how far the column of jerks is off the change of the accelerations, and what explains
    it; of the joints (k,) whose accelerations do not jump."""

    off: Floats
    """(k, windows) sum over the steps."""
    around: Floats
    """(k, windows) change of the mean jerk in the window and about it."""
    peak: Floats
    """(k, windows) largest jerk of the column."""
    hidden: Floats
    """(k, windows) what swings within the steps make of it."""
    rate: Floats
    """(windows,) sum of 1 / step [1/s]."""
    steps: Ints
    """(windows,)"""

    @classmethod
    def of(cls, block: Block, begin: int, end: int, judged: Ints) -> JerkWindows:
        """Those of the steps from `begin`, a multiple of WINDOW, to `end`."""
        last = block.of_all - 1
        # What changes just before and behind a window may belong to a step in it.
        before, behind = max(begin - AROUND - 1, 0), min(end + AROUND, last)
        steps = np.diff(block.times(before, behind + 1))
        mean = np.diff(block.columns("qdd", before, behind + 1)[judged], axis=1) / steps
        total = np.cumsum(np.abs(np.diff(mean, axis=1, prepend=mean[:, :1])), axis=1)
        total = np.concatenate((np.zeros((len(judged), 1)), total), axis=1)
        steps, mean = steps[begin - before : end - before], mean[:, begin - before : end - before]
        qd, qdd, qddd = (block.columns(name, begin, end + 1)[judged] for name in ("qd", "qdd", "qddd"))
        off = np.abs(mean - 0.5 * (qddd[:, 1:] + qddd[:, :-1]))
        between = np.diff(qd, axis=1) / steps - 0.5 * (qdd[:, 1:] + qdd[:, :-1])
        sag = np.abs(between) / steps
        starts = np.arange(0, end - begin, WINDOW)
        first = np.maximum(starts + begin - AROUND, 0) - before
        around = total[:, np.minimum(starts + begin + WINDOW + AROUND, last) - before] - total[:, first]
        peak = np.maximum.reduceat(np.maximum(np.abs(qddd[:, 1:]), np.abs(qddd[:, :-1])), starts, axis=1)
        swing, more = _hidden(sag, peak, starts)
        hidden = more + np.add.reduceat(np.maximum(SAG * sag, swing), starts, axis=1)
        off = np.add.reduceat(off, starts, axis=1)
        return cls(
            off, around, peak, hidden, np.add.reduceat(1.0 / steps, starts), np.diff(np.append(starts, end - begin))
        )

    @classmethod
    def of_all(cls, parts: Sequence[JerkWindows]) -> JerkWindows:
        """Those of all blocks."""
        return cls(*(np.concatenate(each, axis=-1) for each in zip(*parts)))


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
    if len(seen.t) < 3 or not len(judged):
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


def _hidden(sag: Floats, peak: Floats, starts: Ints) -> tuple[Floats, Floats]:
    """By how much (m, steps) swings of the jerk that are over within a step let it stray from its mean, as expected,
    and (m, windows) how much more a window may happen to have.

    A jerk of J one way for a time T, and the other way for as long, is a change in velocity of J T^2 that no
    acceleration shows: the mean acceleration of the step is off by J T^2 / dt, its `sag` by dt. So the swing lasts
    2 T = 2 dt (sag / J)^(1/2), a set-point meets it in as large a share of the cases, and the column then is off by J:
    2 (J sag)^(1/2) as expected. How many of n are met has a variance of n at most. J is the `peak` of the window.
    """
    steps = np.diff(np.append(starts, sag.shape[1]))
    swing = 2.0 * np.sqrt(np.repeat(peak, steps, axis=1) * sag)
    return swing, SPREADS * np.sqrt(peak * np.add.reduceat(swing, starts, axis=1))
