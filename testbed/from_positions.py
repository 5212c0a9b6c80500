"""What a motion uses of its limits, from positions alone: differences of `at()` at three steps, each a tenth.

A divided difference of order k is a mean of the k-th derivative with positive weights: it never passes the largest
value of the derivative, so that what it passes a limit by is real, but for rounding, which is taken off.
"""

from __future__ import annotations

import itertools

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.motion import least_changes
from toolpace.motion.trajectory import Trajectory

WEIGHTS = (np.array([-1.0, 1.0]), np.array([1.0, -2.0, 1.0]), np.array([-1.0, 3.0, -3.0, 1.0]))
FIRST_STEP = 1.0 / 4000.0
"""Share of the duration."""
STEPS = 3
STARTS = 12_000
CLOSER = 24
"""Places of each limit that are looked at with the next smaller step."""
AROUND = 80
"""Starts there."""
CAP_PLACES = 17
"""At which a cap on ds/dt is asked in one step: a long step passes more than one top of it."""
ROUNDING = 8.0 * np.finfo(float).eps


def used_by_positions(trajectory: Trajectory) -> Floats:
    """(1 + 3,) largest use of the cap on ds/dt, and of velocity, acceleration and jerk limits, by positions alone."""
    limits, duration = trajectory.limits, trajectory.duration
    bounds = (limits.velocity, limits.acceleration, limits.jerk)
    worst = np.zeros(4)
    step = FIRST_STEP * duration
    starts = np.sort(np.random.default_rng(0).uniform(0.0, duration - 3.0 * step, STARTS))
    groups = [np.concatenate([starts, beside_nodes(trajectory, step)])]
    for _ in range(STEPS):
        nearer = []
        for first in groups:
            first = np.clip(first, 0.0, duration - 3.0 * step)
            q = [trajectory.at(first + k * step).q for k in range(4)]
            # rounding of a position, of the time at which it is taken, and of the parameter there
            swift = fastest(q, step)
            blur = ROUNDING * (
                np.abs(q[0]).max(axis=0) + duration * swift + behind_the_parameter(trajectory, first, q, step)
            )
            blur += grain(trajectory, q)
            blur = np.maximum(blur, noise(trajectory, first[:: max(len(first) // 3000, 1)], step / 1000.0))
            for order, (weights, bound) in enumerate(zip(WEIGHTS, bounds), start=1):
                change = np.abs(sum(w * at for w, at in zip(weights, q)))
                used = np.maximum(change - 2.0**order * blur, 0.0) / step**order / bound
                used[:, ~np.isfinite(bound)] = 0.0
                worst[order] = max(worst[order], float(used.max(initial=0.0)))
                nearer.append(first[np.argsort(used.max(axis=1))[-CLOSER:]])
            worst[0] = max(worst[0], cap_used(trajectory, first, step))
        near = np.unique(np.concatenate(nearer))
        groups = [(near[:, None] + np.linspace(-step, 4.0 * step, AROUND)).ravel()]
        step /= 10.0
    return worst


def behind_the_parameter(trajectory: Trajectory, first: Floats, q: list[Floats], step: float) -> Floats:
    """(m,) by how much a joint moves while s moves by its own size, at most."""
    size = max(max(abs(run.s0), abs(run.s1)) for run in trajectory.axis_path.runs)
    moved = np.abs(trajectory.parameter(first + step) - trajectory.parameter(first))
    with np.errstate(divide="ignore", invalid="ignore"):
        slope = np.abs(q[1] - q[0]) / moved[:, None]
    # where s hardly moves its rounding is all there is
    slope[moved <= 1e3 * np.spacing(size)] = 0.0
    return size * slope.max(axis=0, initial=0.0)


def grain(trajectory: Trajectory, q: list[Floats]) -> Floats:
    """(m,) the least by which a joint's positions differ over a step, where over others they do not: their rounding.

    A position next to zero may be a difference of larger numbers. No more than a change of position that is let pass.
    """
    change = np.abs(q[1] - q[0])
    least = np.where(change > 0.0, change, np.inf).min(axis=0)
    rounded = (change == 0.0).any(axis=0) & np.isfinite(least)
    return np.where(rounded, np.minimum(least, least_changes(trajectory.limits)[0]), 0.0)


def noise(trajectory: Trajectory, first: Floats, step: float) -> Floats:
    """(m,) third differences over a step so small that they are nothing but noise of the path: a pole makes it large.

    A jump of an acceleration by as much as its limit makes less than a millionth of what it makes over the real step.
    """
    q = [trajectory.at(first + k * step).q for k in range(4)]
    return np.abs(sum(w * at for w, at in zip(WEIGHTS[2], q))).max(axis=0)


def fastest(q: list[Floats], step: float) -> Floats:
    """(m,) the largest velocity seen."""
    return np.max([np.abs(b - a).max(axis=0) for a, b in itertools.pairwise(q)], axis=0) / step


def beside_nodes(trajectory: Trajectory, step: float) -> Floats:
    """Times about the shortest cells of the laws: where to look, and nothing else, is taken from them."""
    found = [np.empty(0)]
    for start, law in zip(trajectory.starts, trajectory.laws):
        times = getattr(law, "times", np.empty(0))
        if len(times) > 2:
            short = np.argsort(np.diff(times))[:2000]
            found.append(start + times[short] - 1.5 * step)
    return np.concatenate(found)


def cap_used(trajectory: Trajectory, first: Floats, step: float) -> float:
    """Largest ds/dt over its cap, by differences of s; the cap is the largest there is from one to the other."""
    worst = 0.0
    for start, law, run in zip(trajectory.starts, trajectory.laws, trajectory.axis_path.runs):
        inside = first[(first >= start) & (first + step <= start + law.duration)]
        if len(inside) == 0:
            continue
        s = np.stack([trajectory.parameter(inside + share * step) for share in np.linspace(0.0, 1.0, CAP_PLACES)])
        caps = [run.speed_cap(np.clip(each, run.s0, run.s1)) for each in s]
        caps += [run.speed_cap(np.nextafter(np.clip(each, run.s0, run.s1), -np.inf)) for each in s]
        blur = ROUNDING * (max(abs(run.s0), abs(run.s1)) + trajectory.duration * float(np.max(s[-1] - s[0])) / step)
        worst = max(worst, float((np.maximum(s[-1] - s[0] - 2.0 * blur, 0.0) / step / np.max(caps, axis=0)).max()))
    return worst
