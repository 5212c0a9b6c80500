"""The search for the rejoin motion of least duration, and of least loss of time.

search: a state in motion, the motion that shall be rejoined, the limits
  the shortest time in which the joints alone can do it, by steps and bisection
  a little more than that, then more and more, until a way also keeps to the feed:
      in time with the program, where that passes
      else with the least time lost, about a point of rejoining that is found by and by
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.deflection.feed import feed_at, sampled_feed_use, tip_velocity
from toolpace.deflection.rejoin.guaranteed import FeedFallback, Standby, fed_time, guaranteed_rejoin, price
from toolpace.deflection.rejoin.joint_splines import (
    ENOUGH,
    FINER,
    Problem,
    Spline,
    allowed_speed,
    detour_of,
    knots_of,
    rows_of,
    solved,
    with_feed,
)  # fmt: skip
from toolpace.deflection.rejoin.limit_check import FINAL, rows_used
from toolpace.deflection.rejoin_motion import Detour, RejoinMotion
from toolpace.machine.limits import KINDS
from toolpace.planning.limit_tolerances import DETOUR

LONG = 3.0
"""Time of a detour over the first guess from which finer steps are tried too."""
FED = 0.8
"""Time that the feed asks for, over that of the joints alone, from which no spline is tried: it would hug the feed."""
ABOVE_FED = 4.0
"""The same where the tip is above the feed at the start: splines brake it nearly as fast as the joints can."""
COARSE_TRIES, FINE_TRIES = 6, 3
"""Splines that are tried, of few and of many steps: each costs some 20 to 300 ms of computing."""
SHORTEST, LONGEST = 1e-5, 60.0
"""Times of a detour that are looked at [s]."""
TRIES, CLOSE = 20, 1.09
"""Times tried until the shortest is known to the factor."""
LEAP = 0.6
"""Factor by which a time is shortened that leaves room, until one is found that does not."""
FIRST_STRETCH, STRETCHES, MOST_STRETCH = 1.01, 9, 2.5
"""The first multiple of it that is tried, how many more, and the largest step from one to the next."""
SOON = 4.0
"""Multiple of it up to which all ways of braking are tried before longer ones are."""
SLOW = 5.0
"""By how much more time, as an exponent, goes with how much less use of the limits where the feed binds."""
LOSS = 0.3
"""Part of a detour's time that may be lost beyond what the deflection asks for at once."""
BRAKING = (0.9, 0.6, 0.3)
"""Shares of the jerk with which the tip is braked at least while it is above the feed; the later where none passes."""
MOST_ITERATIONS = 4
"""Of a point of rejoining that moves with the time lost."""
CONVERGED = 0.05
"""Change of that point from which on it has converged, as a share of the time taken."""
MOST_SOLUTIONS = 2
"""Of a way to a fixed place, of which the later mend what the feed along the one before it leaves."""
MARGINS = (0.0, 0.003, 0.012, 0.05)
"""Time that is lost beyond the least, as a share of that taken: it leaves room within the limits."""


def least_period(problem: Problem, rejoin: float | None, wish: float, behind: float) -> Spline | None:
    """The shortest way that limits and travel of the joints allow, nearly; None where there is none."""
    low, high, best = 0.0, np.inf, None
    period = max(SHORTEST, problem.guess)
    for tried in range(TRIES):
        found = joints_alone(problem, period, rejoin, wish, behind)
        if found.used <= DETOUR:
            high, best = period, found
        else:
            low = period
        if high <= CLOSE * low or period > LONGEST:
            break
        # by steps that follow from jerk alone, or closer ones where an acceleration or a velocity binds
        step = float(np.clip(found.used**0.4, LEAP, 3.0))
        if low > 0.0 and np.isfinite(high):
            period = float(np.sqrt(low * high))
        else:
            period *= min(step * 0.97, 0.85) if found.used <= DETOUR else max(step * 1.02, 1.1 + 0.05 * tried)
    return best


def joints_alone(problem: Problem, period: float, rejoin: float | None, wish: float, behind: float) -> Spline:
    """The way of least use of limits and travel in a time."""
    rest = problem.commanded.law.duration - problem.left
    lead, range_ = behind, (wish - LOSS * period, behind + LOSS * period)
    if rejoin is not None or period - wish >= rest:
        lead = period - rest if rejoin is None else problem.left + period - rejoin
        range_ = lead, lead
    rows, y = rows_of(problem, period, lead, range_, nearly=True)
    return solved(rows, Spline.begun(problem, period, lead, y), with_tip=False, gap=0.02)


def rejoin_of(problem: Problem, standby: Standby, rejoin: float | None = None, lag: float = 0.0) -> RejoinMotion | None:
    """The way back to a given time of the commanded law, or wherever it is best; None where none keeps to limits and
    travel. Where the feed cannot be kept, it is the way that passes it least.

    `lag` is the time lost before [s], which is made up for where the deflection itself leads onwards. Where the feed
    binds, and not the joints, or where the place to rejoin is given, the way beside the path may lose less.
    """
    found: list[RejoinMotion | None] = []
    fed = fed_time(problem)
    by_joints = fed <= FED * problem.guess or (fed <= ABOVE_FED * problem.guess and begins_above_feed(problem))
    if by_joints:
        found.append(with_pieces(problem, rejoin, lag, COARSE_TRIES))
        if rejoin is None and found[0] is not None and found[0].duration <= LONG * problem.guess:
            return found[0]
    spare = FeedFallback()
    found.append(guaranteed_rejoin(problem, standby, rejoin, min(map(price, found), default=np.inf), spare))
    if by_joints and min(map(price, found)) > LONG * problem.guess:
        found.append(with_pieces(replace(problem, pieces=FINER), rejoin, lag, FINE_TRIES))
    best = min(found, key=price)
    return spare.nearest(problem) if best is None else best


def begins_above_feed(problem: Problem) -> bool:
    """Whether the tip is above the feed where it was found, with the joints going on as they were."""
    if problem.machine is None:
        return False
    feed = feed_at(problem.commanded.run, problem.commanded.place(np.array([problem.left])))[0]
    velocity = tip_velocity(problem.machine, problem.start[:1], problem.start[1:2])
    return bool(np.linalg.norm(velocity) > DETOUR * feed)


def with_pieces(problem: Problem, rejoin: float | None, lag: float, tries: int) -> Detour | None:
    """By a spline of so many steps of constant jerk, in so many tries."""
    ahead = lead_of(problem)
    wish = -min(lag, max(ahead, 0.0))
    soonest = least_period(problem, rejoin, wish, max(-ahead, 0.0))
    if soonest is None:
        return None
    fed = np.isfinite(feed_at(problem.commanded.run, problem.commanded.place(np.array([problem.left])))[0])
    reached = dict.fromkeys(BRAKING, (FIRST_STRETCH * soonest.period, 0))
    for most in (SOON * soonest.period, np.inf):
        for share, (period, tried) in reached.items():
            while tried < STRETCHES and period <= most and tries:
                tries -= 1
                found, used = find_rejoin(problem, soonest, period, rejoin, wish, share, alone=not (fed and tried))
                if found is not None:
                    return found
                period *= float(np.clip(np.exp(SLOW * min(used - 1.0, 1.0)), 1.06 + 0.04 * tried, MOST_STRETCH))
                tried += 1
            reached[share] = period, tried
    return None


def lead_of(problem: Problem) -> float:
    """How far the state is ahead of the commanded motion along it [s]; below zero behind it."""
    motion = problem.commanded.motion(np.array([problem.left]))[:, 0]
    off, rate = problem.start[0] - motion[0], motion[1]
    if problem.machine is not None:
        moved = problem.machine.forward(np.stack([problem.start[0], motion[0]]))[0]
        off, rate = moved[0] - moved[1], tip_velocity(problem.machine, motion[:1], motion[1:2])[0]
    square = float(rate @ rate)
    most = problem.guess
    return float(np.clip(off @ rate / square, -most, most)) if square > 0.0 else 0.0


def find_rejoin(
    problem: Problem, near: Spline, period: float, rejoin: float | None, wish: float, share: float, *, alone: bool
) -> tuple[Detour | None, float]:
    """A detour in a given time, or None where none is found to pass, and the least use of the limits that was found.

    `alone` is whether a way of least use by the joints alone is tried first, which costs least.
    """
    rest = problem.commanded.law.duration - problem.left
    free = rejoin is None and period - wish < rest
    lead = wish if free else problem.left + period - rejoin if rejoin is not None else period - rest
    rows, y = rows_of(problem, period, lead, (lead, lead))
    spline = Spline.begun(problem, period, lead, y)
    if alone or problem.machine is None:
        spline = solved(rows, spline, with_tip=False)
        found = passing(spline, share)
        if found is not None:
            return found, spline.used
    if not free:
        return at_place(spline, share)
    return with_loss(spline, near.lead + near.late, wish, share)


def with_loss(spline: Spline, guess: float, wish: float, share: float) -> tuple[Detour | None, float]:
    """The detour that loses or wins least time beside what is wished, as `find_rejoin` returns it."""
    period, lead, way = spline.period, guess, 0
    rest = spline.problem.commanded.law.duration - spline.problem.left
    for _ in range(MOST_ITERATIONS):
        if period - lead >= rest:
            return at_place(spline, share, period - rest)
        reach = abs(lead - wish) + LOSS * period
        range_ = (wish - reach * (way <= 0), wish + reach * (way >= 0))
        spline = with_rows(spline, lead, range_, share, least_late=way, enough=ENOUGH)
        if spline.used > DETOUR:
            return None, spline.used
        lead = spline.lead + spline.late
        if way and abs(spline.late) <= CONVERGED * period:
            break
        way = way or (1 if lead >= wish else -1)
    if abs(lead - wish) < MARGINS[1] * period:
        lead = wish
    for margin in MARGINS:
        found, used = at_place(spline, share, lead + way * margin * period)
        if found is not None:
            break
    return found, used


def at_place(spline: Spline, share: float, lead: float | None = None) -> tuple[Detour | None, float]:
    """The way of least use of the limits, the feed among them, to a fixed place: as it is found, or after a look."""
    lead = spline.lead if lead is None else lead
    tight = np.ones(spline.problem.pieces)
    for _ in range(MOST_SOLUTIONS):
        spline = with_rows(spline, lead, (lead, lead), share, tight)
        found = passing(spline, share) if spline.used <= DETOUR else None
        if found is not None or spline.used > DETOUR or spline.problem.machine is None:
            break
        tight *= slower(spline, share)
    return found, spline.used


def with_rows(
    spline: Spline, lead: float, late: tuple[float, float], share: float, tight: Floats | None = None,
    *, least_late: int = 0, enough: float = 0.0,
) -> Spline:  # fmt: skip
    """Solved anew about another time lost, with the feed as it is along the motion that was found last."""
    problem, period = spline.problem, spline.period
    rows, y = rows_of(problem, period, lead, late)
    start = Spline.begun(problem, period, lead, y, spline)
    with_tip = False
    if problem.machine is not None:
        allowed, _, rates = allowed_speed(problem, detour_of(start), share)
        with_tip = bool(np.isfinite(allowed).any())
        if with_tip:
            rows = with_feed(problem, rows, period, rates, allowed if tight is None else allowed * tight)
    return solved(
        rows, start, with_tip=with_tip, least_late=least_late, gap=1e-3 if least_late else 1e-2, enough=enough
    )


def passing(spline: Spline, share: float) -> Detour | None:
    """The motion of a spline, if it keeps to the limits, to travel and to the feed of where it is."""
    detour, limits = meeting(detour_of(spline)), spline.problem.limits
    if joints_used(spline.problem, detour) > DETOUR:
        return None
    if limits.rows:
        t = np.unique(np.linspace(detour.times[:-1], detour.times[1:], FINAL))
        if rows_used(limits, detour.motion(t)) > DETOUR:
            return None
    return detour if spline.problem.machine is None or (too_fast(spline, detour, share) <= DETOUR).all() else None


def meeting(detour: Detour) -> Detour:
    """The same with the motion that it rejoins met to rounding, by the least change of jerks."""
    h, left = np.diff(detour.times), detour.duration - detour.times[:-1]
    weights = np.stack([h * (left**2 / 2.0 - left * h / 2.0 + h * h / 6.0), h * (left - h / 2.0), h])
    scale = np.linalg.norm(weights, axis=1)[:, None]
    end = detour.commanded.motion(np.array([detour.rejoin]))[:3, 0]
    if detour.rejoin >= detour.commanded.law.duration:
        end[1:] = 0.0
    jerks, knots = detour.jerks, detour.knots
    weights /= scale
    inverse = weights.T @ np.linalg.inv(weights @ weights.T)
    for _ in range(2):
        jerks = jerks + inverse @ ((end - knots[:, -1]) / scale)
        knots = knots_of(detour.knots[:, 0], jerks, detour.times)
    return replace(detour, jerks=jerks, knots=knots)


def joints_used(problem: Problem, detour: Detour) -> float:
    """Largest share of limits and travel that a detour uses, of what it is free to choose."""
    q, v, a = detour.knots
    limits = [getattr(problem.limits, kind) for kind in KINDS]
    low, high = problem.travel.T
    if (q < low - 1e-9).any() or (q > high + 1e-9).any():
        return np.inf
    # a velocity turns where the acceleration passes zero
    with np.errstate(divide="ignore", invalid="ignore"):
        x = -a[:-1] / detour.jerks
        turning = np.abs(v[:-1] + a[:-1] * x / 2.0)
    inside = (x > 0.0) & (x < np.diff(detour.times)[:, None])
    top = np.maximum(np.abs(v).max(axis=0), np.where(inside, turning, 0.0).max(axis=0))
    peaks = top, np.abs(a).max(axis=0), np.abs(detour.jerks).max(axis=0)
    return max(float((peak / limit).max()) for peak, limit in zip(peaks, limits))


def too_fast(spline: Spline, detour: Detour, share: float) -> Floats:
    """(n,) speed of the tip over what is allowed at the looks along a detour."""
    machine = spline.problem.machine
    assert machine is not None
    t, ratio = sampled_feed_use(detour, machine)
    if ratio.max() <= DETOUR:
        return ratio
    _, until, _ = allowed_speed(spline.problem, detour, share)
    return np.where(t <= until, np.minimum(ratio, 1.0), ratio)


def slower(spline: Spline, share: float) -> Floats:
    """(N,) by what the allowed speed of each control point is to be lessened."""
    detour = meeting(detour_of(spline))
    ratio = too_fast(spline, detour, share)
    pieces = spline.problem.pieces
    per = (len(ratio) - 1) // pieces
    worst = np.maximum(ratio[:-1].reshape(pieces, per).max(axis=1), ratio[1:].reshape(pieces, per).max(axis=1))
    worst = np.maximum(worst, np.maximum(np.append(worst[1:], 1.0), np.append(1.0, worst[:-1])))
    less: Floats = 1.0 / (1.0 + 1.2 * np.maximum(worst - 1.0, 0.0))
    return less
