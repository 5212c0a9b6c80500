"""Where a path must be looked at more closely than on an even grid: cusps, poles, and other short-lived detail."""

from __future__ import annotations

import itertools

import numpy as np
import numpy.typing as npt

from toolpace.axispath import AxisRun
from toolpace.kernels import envelope
from toolpace.limits import Limits

Floats = npt.NDArray[np.float64]

UNSEEN = 0.02
"""Share of a limit that may hide between two points of the grid at the speed that the limits allow at them."""
SETTLED = 3
"""Times that a step is halved before it counts as detail: where a grid is a little coarse, that is all it takes."""
FINEST = 1e-13
"""Shortest step of the grid, as a share of the run."""
MOST_POINTS = 20_000


def detail(run: AxisRun, limits: Limits, s: Floats) -> Floats:
    """(k,) points between those of the grid s (n,), which holds the breaks, where the path needs a closer look.

    The grid is halved where the path does not go on as its derivatives say: something happens between two points if
    position, slope or curvature changes by another amount than the next derivative at both points tells. A cusp shows
    like this in any grid, however sharp it is.
    """
    q, before = run.evaluate(s), s[1:].copy()
    before[np.isin(before, run.breaks)] = np.nextafter(before[np.isin(before, run.breaks)], -np.inf)
    ends = q[:, 1:].copy()
    at = np.flatnonzero(before != s[1:])
    if len(at):
        ends[:, at] = run.evaluate(before[at])
    z = envelope.pointwise(q, limits.velocity, limits.acceleration, limits.jerk, run.speed_cap(s))[1]
    low, high, of_low, of_high = s[:-1], s[1:], q[:, :-1], ends
    slow = np.minimum(z[:-1], z[1:])
    shortest = max(FINEST * (run.s1 - run.s0), 4.0 * float(np.spacing(max(abs(run.s0), abs(run.s1)))))
    found: list[Floats] = []
    count = 0
    for level in itertools.count(1):
        marked = (hidden(limits, high - low, of_low, of_high, slow) > UNSEEN) & (high - low > 2.0 * shortest)
        count += int(marked.sum())
        if not marked.any() or count > MOST_POINTS:
            break
        low, high, slow = low[marked], high[marked], slow[marked]
        of_low, of_high = of_low[:, marked], of_high[:, marked]
        middle = (low + high) / 2.0
        of_middle = run.evaluate(middle)
        z = envelope.pointwise(of_middle, limits.velocity, limits.acceleration, limits.jerk, run.speed_cap(middle))[1]
        if level > SETTLED:
            found.append(middle)
        low, high = np.concatenate([low, middle]), np.concatenate([middle, high])
        of_low, of_high = np.concatenate([of_low, of_middle], axis=1), np.concatenate([of_middle, of_high], axis=1)
        slow = np.minimum(np.tile(slow, 2), np.tile(z, 2))
    return np.sort(np.concatenate(found)) if found else np.empty(0)


def hidden(limits: Limits, h: Floats, low: Floats, high: Floats, z: Floats) -> Floats:
    """(n,) largest share of a limit that (ds/dt)^2 = z would ask for between two points h apart, unseen at both.

    `low` and `high` (4, n, m) hold position and derivatives there.
    """
    change = np.abs((high[:3] - low[:3]) / h[:, None] - (low[1:] + high[1:]) / 2.0)
    speed = np.sqrt(np.where(np.isfinite(z), z, 0.0))[:, None]
    worst: Floats = np.max(
        [
            (change[0] * speed / limits.velocity).max(axis=1),
            (change[1] * speed**2 / limits.acceleration).max(axis=1),
            (change[2] * speed**3 / limits.jerk).max(axis=1),
        ],
        axis=0,
    )
    return worst
