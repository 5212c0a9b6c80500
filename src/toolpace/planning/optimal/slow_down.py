"""Local slow-down that removes the violations which inter-sample rows leave."""

from __future__ import annotations

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.common.workers import Workers
from toolpace.motion.laws import SplineLaw
from toolpace.planning.limit_tolerances import GUARANTEE
from toolpace.planning.optimal.meshed_run import MeshedRun
from toolpace.planning.optimal.solve import LIMITS, Stalled
from toolpace.planning.optimal.undershoot import without_undershoot
from toolpace.planning.peaks import LimitCheck, largest

MOST_EASED = 40
"""Places that may pass the guarantee for easing to be worth a thought."""
EASE_BY = 1.05
"""How far the motion is slowed down about a place, as a multiple of what the place needs."""
EASE_RAMPS, EASE_SLOPE = 20.0, 5e-6
"""How far that reaches in ramp times, at least, and most of z that is lost in one: no other limit shall feel it."""
TOO_SLOW = 0.9
"""Share of z at the limits from which a motion that uses none of them is sped up as a whole."""
CLOSER_CELLS, CLOSER = 20, 1000
"""Cells that are looked at again, and how closely: what all is slowed down for shall not hide between probes."""


def within_guarantee(meshed: MeshedRun, law: SplineLaw, peak: Floats, workers: Workers) -> SplineLaw:
    """The law, with its peaks (cells, 3), within the guarantee: slowed down about the places that pass it.

    That is done so gently that nothing else passes. Where that does not do, or is no better, it is slowed down as a
    whole; with an end in motion it cannot be: Stalled. One that could not be solved, and so uses no limit anywhere, is
    sped up.
    """
    look = meshed.look
    if law.dips().any():
        law = without_undershoot(law)
        look = LimitCheck(meshed.run, meshed.limits, law.nodes)
        peak = look.peaks(law, workers).used
    # the best of many rounds may not have been looked at closely
    peak = np.maximum(peak, look.confirmed(law, look.peaks(law, workers), workers).used)
    rests = law.rest[0] > 0.0 and law.rest[1] > 0.0
    if peak.max() <= GUARANTEE:
        unused = rests and 0.0 < slowing_factor(peak) < TOO_SLOW
        return law.slowed(closer(look, law, peak, workers)) if unused else law
    finite = bool(np.isfinite(peak).all())
    slowed = law.slowed(max(1.0, closer(look, law, peak, workers))) if finite and rests else None
    gently = slowed_down(look, law, peak, meshed.ramp, workers) if finite else None
    if gently is not None and (slowed is None or gently.duration < slowed.duration):
        return gently
    if slowed is None:
        cell, kind = divmod(int(np.nan_to_num(peak, nan=np.inf).argmax()), peak.shape[1])
        raise Stalled(float(law.nodes[cell]), LIMITS[kind])
    return slowed


def slowed_down(look: LimitCheck, law: SplineLaw, peak: Floats, ramp: float, workers: Workers) -> SplineLaw | None:
    """The law slowed down about its peaks (cells, 3) above the guarantee; None where that is not enough."""
    if peak.max() <= GUARANTEE:
        return law
    gently = SplineLaw(law.nodes, law.c * easing(law, peak, ramp), law.rest)
    if gently.dips().any():
        return None
    found = look.confirmed(gently, look.peaks(gently, workers), workers)
    return gently if found.used.max() <= GUARANTEE else None


def closer(look: LimitCheck, law: SplineLaw, peak: Floats, workers: Workers) -> float:
    """By how much z must be divided as the cells with the highest peaks (cells, 3) show that are looked at closely."""
    used = np.stack([peak[:, 0] ** 2, peak[:, 1], peak[:, 2] ** (2.0 / 3.0)], axis=1).max(axis=1)
    highest = np.argsort(-used)[:CLOSER_CELLS]
    fine = SplineLaw(law.nodes, law.c, law.rest)
    fine.inside = np.linspace(0.0, 1.0, CLOSER)
    return max(slowing_factor(peak), slowing_factor(look.peaks_in(fine, highest, workers).used))


def slowing_factor(peak: Floats) -> float:
    """By how much z must be divided for the peaks (cells, 3) of speed, acceleration and jerk to come to 1."""
    speed, acceleration, jerk = (kind.max() for kind in peak.T)
    return float(max(speed**2, acceleration, jerk ** (2.0 / 3.0)))


def slowing(peak: Floats) -> float:
    """The same, where anything must be slowed down; else 1."""
    return max(1.0, slowing_factor(peak))


def worth(law: SplineLaw, peak: Floats, ramp: float) -> float:
    """About how long the motion takes once it is slowed down for the guarantee [s]."""
    whole = law.duration * float(np.sqrt(slowing(peak)))
    if not np.isfinite(whole) or np.count_nonzero(largest(peak) > GUARANTEE) > MOST_EASED:
        return whole
    left = easing(law, peak, ramp)[1:-1]
    return min(whole, law.duration + float(np.diff(law.times) @ (1.0 / np.sqrt(left[1:]) - 1.0)))


def easing(law: SplineLaw, peak: Floats, ramp: float) -> Floats:
    """Shares of the coefficients that are left about the places above the guarantee; all of them at moving ends."""
    clock = np.concatenate([law.times[:1], law.times, law.times[-1:]])
    left = np.ones(len(clock))
    groups: list[tuple[float, float, float]] = []
    for cell in np.flatnonzero(largest(peak) > GUARANTEE):
        begin, end = law.times[cell], law.times[cell + 1]
        loss = 1.0 - 1.0 / (1.0 + EASE_BY * (slowing(peak[cell : cell + 1]) - 1.0))
        # one that reaches into the one before is slowed down together with it
        while groups and begin - ramp * ease_ramps(loss) < groups[-1][1] + ramp * ease_ramps(groups[-1][2]):
            begin, loss = min(begin, groups[-1][0]), max(loss, groups[-1][2])
            groups.pop()
        groups.append((begin, end, loss))
    for begin, end, loss in groups:
        width = ramp * ease_ramps(loss)
        low, high = np.searchsorted(clock, [begin - width, end + width])
        far = np.maximum(begin - clock[low:high], clock[low:high] - end)
        near = np.clip((width - far) / (width - ramp), 0.0, 1.0)
        left[low:high] = 1.0 - loss * near * near * (3.0 - 2.0 * near)
    left[:2] = 1.0 if law.rest[0] == 0.0 else left[:2].min()
    left[-2:] = 1.0 if law.rest[1] == 0.0 else left[-2:].min()
    return left


def ease_ramps(loss: float) -> float:
    """Ramp times in which so much of z is lost and won."""
    return max(EASE_RAMPS, loss / EASE_SLOPE)
