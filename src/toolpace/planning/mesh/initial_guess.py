"""An initial guess of the speed: pointwise limits joined by ramps."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.kernels.optimal import first_guess
from toolpace.machine.limits import Limits
from toolpace.path.axis_run import AxisRun
from toolpace.planning.mesh.path_detail import allowed, closer_look

ROUGH, ROUGH_BY = 0.05, 1.5
"""Share of the intervals between such places, beyond which more are needed, and the factor that makes one rough."""
SAMPLES = 4000
MOST_PLACES = 4_000_000
"""Intervals that are looked at, and most places."""
FLEETING = 3e-3
"""Share of the time in which the whole run would be passed at the highest ds/dt of a guess: more would gain nothing."""
UNLIMITED = 1e12
"""z [length of the run squared a second squared] that stands for the highest where no limit gives a scale."""
CHUNK = 20_000
"""Points of a path that are worked out at a time, to keep memory low."""


PathWithCap = Callable[[Floats], tuple[Floats, Floats]]
"""Path (4, n, joints) and cap (n,) on ds/dt at s (n,), as AxisRun.with_cap tells them."""


@dataclass(frozen=True)
class Guess:
    """A first idea of the motion along a run, on a fine grid."""

    s: Floats
    z: Floats
    """(n,) (ds/dt)^2, well within the limits but for its kinks."""
    t: Floats
    """(n,) time [s]."""
    highest: float
    """The highest z that the limits allow anywhere at steady speed."""
    detail: Floats
    """(k,) those s that only a closer look has found to be needed."""


def guess(run: AxisRun, limits: Limits, ends: tuple[float, float], resolution: int) -> Guess:
    """The speed that pointwise limits and jerk-limited ramps allow; `ends` are the given z, 0 at rest."""
    length = run.s1 - run.s0
    graded = run.s0 + length * from_graded(np.linspace(0.0, 1.0, resolution + 1), ends)
    s = np.unique(np.concatenate([graded, run.hints, run.breaks]))
    s = s[(s >= run.s0) & (s <= run.s1)]
    keep = np.concatenate([[True], np.diff(s) > 1e-12 * length])
    keep |= np.isin(s, run.breaks)
    s = s[keep]
    s[-1] = run.s1
    looks = [closer_look(run, limits, s[i : i + CHUNK + 1]) for i in range(0, len(s) - 1, CHUNK)]
    closer = np.concatenate([between.s for _, between in looks])
    # the last point of a chunk is the first of the next, where its left side is not seen any more
    s, first = np.unique(np.concatenate([part.s for look in looks for part in look]), return_index=True)
    steady = np.concatenate([part.steady for look in looks for part in look])[first]
    third = np.concatenate([part.third for look in looks for part in look])[first]
    highest = highest_of(steady, third, length)
    third[~np.isfinite(third)] = 1e6 * least_third(third, length)
    steady[~np.isfinite(steady)] = 1e6 * highest
    z = first_guess.ramped(s, steady, third, ends[0], ends[1])
    # where nothing moves, or nearly so, ds/dt would be without bounds
    fastest = fleeting(length, first_guess.times(s, z)[-1])
    z = np.minimum(z, fastest)
    return Guess(s, z, first_guess.times(s, z), min(highest, fastest), closer)


def fleeting(length: float, duration: float) -> float:
    """The highest z that is worth anything on a run of some length that takes so long [s]."""
    return (length / (FLEETING * duration)) ** 2


def steady_speed(with_cap: PathWithCap, limits: Limits, s: Floats) -> tuple[Floats, Floats]:
    """(n,) z that all limits allow at steady speed, and (n,) the most d3s/dt3 they allow at rest."""
    steady, third = np.empty(len(s)), np.empty(len(s))
    for i in range(0, len(s), CHUNK):
        part = s[i : i + CHUNK]
        steady[i : i + CHUNK], third[i : i + CHUNK] = allowed(limits, *with_cap(part))
    return steady, third


def highest_of(steady: Floats, third: Floats, length: float) -> float:
    """The highest of the z (n,) that limits allow at steady speed, or, without such limits, what jerks allow in all."""
    finite = np.isfinite(steady)
    return float(steady[finite].max() if finite.any() else (least_third(third, length) * length**2) ** (2.0 / 3.0))


def least_third(third: Floats, length: float) -> float:
    """The least of the d3s/dt3 (n,) that limits allow; a large value where there are no limits."""
    finite = np.isfinite(third)
    return float(third[finite].min()) if finite.any() else UNLIMITED**1.5 * length


def places(run: AxisRun, limits: Limits, fewest: int) -> int:
    """How many even places along a run tell the speed between them: `fewest`, or more where it turns often."""
    count = fewest
    while count < MOST_PLACES:
        interval = np.unique(np.linspace(0, count - 1, min(SAMPLES, count)).astype(np.int64))
        # anywhere in the interval, lest a regular path is met in step
        inside = interval * 0.6180339887498949 % 1.0
        left, right, there = (
            np.sqrt(steady_speed(run.with_cap, limits, run.s0 + (run.s1 - run.s0) * (interval + x) / count)[0])
            for x in (0.0, 1.0, inside)
        )
        low, high = np.minimum(left, right) / ROUGH_BY, np.maximum(left, right) * ROUGH_BY
        if np.mean((there < low) | (there > high)) <= ROUGH:
            break
        count *= 4
    return count


def ramp_time(limits: Limits) -> float:
    """Time in which an acceleration builds up [s]: of the quickest joint; inf where none is limited."""
    with np.errstate(divide="ignore", invalid="ignore"):
        ramps = limits.acceleration / limits.jerk
    usable = ramps[np.isfinite(ramps) & (ramps > 0.0)]
    return float(usable.min()) if len(usable) else np.inf


def quickest_ramp(limits: Limits) -> float:
    """Time in which the acceleration of some joint builds up at best [s]: 0 where one has a limit and its jerk has
    none."""
    with np.errstate(invalid="ignore"):
        ramps = np.where(np.isinf(limits.acceleration), np.inf, limits.acceleration / limits.jerk)
    return float(ramps.min(initial=np.inf))


def from_graded(x: Floats, ends: tuple[float, float]) -> Floats:
    """Place in [0, 1] of evenly spaced x in [0, 1]: next to an end at rest it goes like the cube of the distance."""
    if ends[0] == 0.0 and ends[1] == 0.0:
        return x**3 / (x**3 + (1.0 - x) ** 3)
    if ends[0] == 0.0:
        return x**3
    return 1.0 - (1.0 - x) ** 3 if ends[1] == 0.0 else x


def to_graded(place: Floats, ends: tuple[float, float]) -> Floats:
    """The inverse of `from_graded`."""
    left: Floats = np.cbrt(place)
    right: Floats = np.cbrt(1.0 - place)
    if ends[0] == 0.0 and ends[1] == 0.0:
        return left / (left + right)
    if ends[0] == 0.0:
        return left
    return 1.0 - right if ends[1] == 0.0 else place
