"""The tracker beside three running means in series, which keep limits too: how long both take for a step."""

from __future__ import annotations

import math

import numpy as np

from benchmarks.tables import Table
from toolpace.common.arrays import Floats
from toolpace.deflection.following.law import TO_CORRECTION
from toolpace.kernels.follow.correction import approach
from toolpace.machine.machine import Machine

MOST, STEP, PERIOD, RESERVE = 0.3e-3, 0.1e-3, 1e-3, 0.1
"""Most correction and the step [m], the period [s], and the share of the limits."""
MACHINES = ("paper-ab", "linuxcnc-xyzac-trt", "xyzbc-head", "xyzac-trunnion")


def windows(limits: Floats, most: float) -> Floats:
    """(3,) lengths [s] of three running means of least sum that keep limits (3,) for any input within `most`.

    An input within c leaves the first with a velocity of at most 2 c / T1, the second with an acceleration of at most
    4 c / (T1 T2), the third with a jerk of at most 8 c / (T1 T2 T3).
    """
    velocity, acceleration, jerk = limits
    first = max(2.0 * most / velocity, (8.0 * most / jerk) ** (1.0 / 3.0))
    second = max(4.0 * most / acceleration / first, math.sqrt(8.0 * most / jerk / first))
    third = 8.0 * most / (jerk * first * second)
    return np.array([first, second, third])


def means(inputs: Floats, lengths: Floats) -> Floats:
    """The inputs (n,) after three running means, each of a whole number of periods."""
    for length in lengths:
        count = max(math.ceil(length / PERIOD - 1e-9), 1)
        total = np.concatenate([np.zeros(count), np.cumsum(inputs)])
        inputs = (total[count:] - total[:-count]) / count
    return inputs


def tracked(targets: Floats, limits: Floats) -> Floats:
    """Where the tracker is after each period."""
    state, out = np.zeros(4), np.empty(len(targets))
    for k, target in enumerate(targets):
        approach(state, float(target), limits, PERIOD)
        out[k] = state[0]
    return out


def used(x: Floats, limits: Floats) -> float:
    """Most of velocity, acceleration and jerk over limits (3,)."""
    x = np.concatenate([np.zeros(3), x])
    return max(float(np.abs(np.diff(x, k)).max()) / PERIOD**k / limits[k - 1] for k in (1, 2, 3))


def beside_the_tracker() -> Table:
    """Time until a step is made, and what is used of the limits when the input jumps from end to end at random."""
    heads = ["machine", "means: a step [ms]", "tracker: a step [ms]", "means: worst use", "tracker: worst use"]
    table = Table(
        f"A step of {STEP * 1e3:g} mm within {RESERVE * TO_CORRECTION:g} of the limits, most {MOST * 1e3:g} mm", heads
    )
    random = np.random.default_rng(0)
    jumps = MOST * np.repeat(random.choice([-1.0, 1.0], 600), random.integers(1, 80, 600))
    steps = np.full(3000, STEP)
    for name in MACHINES:
        machine = Machine.load(name)
        j, share = machine.linear[0], RESERVE * TO_CORRECTION
        limits = share * np.array([machine.limits.velocity[j], machine.limits.acceleration[j], machine.limits.jerk[j]])
        lengths = windows(limits, MOST)
        line = [name]
        for made in (means(steps, lengths), tracked(steps, limits)):
            there = np.flatnonzero(np.abs(made - STEP) < 1e-4 * STEP)[0] + 1
            line.append(f"{there * PERIOD * 1e3:.0f}")
        line += [f"{used(means(jumps, lengths), limits):.4f}", f"{used(tracked(jumps, limits), limits):.4f}"]
        table.lines.append(line)
    return table
