"""A check that each derivative column is the derivative of the one before."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from toolpace.common.arrays import Floats, Ints
from toolpace.judge.motion import TOLERANCE, largest_difference, position_noise, unit_of
from toolpace.judge.verification import Check
from toolpace.machine.limits import Limits
from toolpace.motion.setpoints import SetPoints

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
