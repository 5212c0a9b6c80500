"""The rejoin motion that always exists: superposed on a slower motion along the path, at worst from rest.

sure: an instant of a motion, the motion that shall be rejoined, the limits
  now; where that is long, also from a stop of all joints, and from the next instants at which the limits leave room:
      for paces from nearly the commanded one to none:
          ramps and an even part as long as feed and joints need by closed forms; longer while a look finds them passed
      where none passes, to rest on the path, and from there on by a clock that always passes
      the way that takes least time, and loses least of the program's
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from math import sqrt

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.deflection.feed import above_feed, feed_at, tip_velocity
from toolpace.deflection.rejoin.joint_splines import Problem
from toolpace.deflection.rejoin.limit_check import FINAL, SAMPLES, LimitCheck, check_limits, row_use
from toolpace.deflection.rejoin.stop import Stop, StopAlone, StopTogether
from toolpace.deflection.rejoin.superposed import (
    Before,
    PaceRise,
    RestartFromRest,
    Shape,
    SuperposedRejoin,
    steepest,
)
from toolpace.deflection.rejoin_motion import CommandedMotion, RejoinMotion
from toolpace.machine.limits import KINDS
from toolpace.planning.limit_tolerances import DETOUR

PACES = (0.5, 0.8, 0.2, 0.95, 0.0, 1.0)
"""Of the commanded motion while the joints move aside: the first is that of least time in all where the feed binds."""
TRIES = 14
"""Lengths of one pace's ramps that are looked at."""
LEAST = 2e-3
"""Shortest ramp [s]."""
SHARE = 0.7
"""Of acceleration and jerk that the first guess gives to the way aside, and to the change of pace."""
GROWTH = (1.06, 2.5)
"""Least and most by which a ramp or the even part is stretched after a look."""
ENOUGH, SOON, EASIER = 4.0, 0.05, 1.4
"""Times the shortest that a way back may take and lose before others are tried, a time [s] up to which none are, and
the growth of both with each that is tried."""
WAITS = 14
"""Instants from which the way aside is begun, where it cannot begin at once."""
IN_VAIN = 5
"""Starts that bring nothing better, one after the other, after which what was found is taken."""
STEEPER = (8.0, 4.0, 2.0, 1.0)
"""Times the sure steepness with which a pace is tried to rise again."""
FLATTER = (0.5, 0.2, 0.05)
"""The same where rows or torques are held, of which the proof knows nothing."""
NOT_BEGUN = 1e-6
"""Time of a run up to which it has not been begun [s]."""
SPARES, ALIKE = 10, 0.01
"""Ways above the feed that are looked at closely, where no other is left; and the share of the feed that is as good."""


Placed = tuple[Shape, float, tuple[float, float, float]]
"""A shape, the clock of the commanded law at its start [s], and the paces of that clock."""


@dataclass(frozen=True, eq=False)
class Standby:
    """The motion that the joints are in, which may go on for a while."""

    current: CommandedMotion
    local: float
    """The time on the clock of its law [s]."""
    offset: Floats
    """(m,) by which the joints were found off it."""
    clock: Callable[[float], float]
    """That of the motion that is rejoined, after a time that it goes on [s]."""


@dataclass(eq=False)
class FeedFallback:
    """Ways that keep to joints and travel, and not to the feed: where the tool, found aside on a table that turns, is
    carried faster than the feed whatever the joints do."""

    ways: list[tuple[float, SuperposedRejoin]] = field(default_factory=list)
    """With the share of the feed that each was seen to use."""

    def keep(self, way: SuperposedRejoin, seen: LimitCheck) -> None:
        """Keep a way that was looked at, if it may be needed."""
        if seen.inside and seen.joints <= DETOUR:
            self.ways.append((seen.feed, way))

    def nearest(self, problem: Problem) -> SuperposedRejoin | None:
        """That of least feed, and of those that are nearly alike in it of least time; None where there is none."""
        held: list[tuple[float, float, SuperposedRejoin]] = []
        for _, way in sorted(self.ways, key=lambda each: each[0])[:SPARES]:
            seen = check_limits(problem, way, FINAL)
            if seen.inside and seen.joints <= DETOUR:
                held.append((above_feed(way, problem.machine)[0], price(way), way))
        least = min((share for share, _, _ in held), default=0.0)
        return min(held, key=lambda each: (max(each[0], least + ALIKE), each[1]), default=(0.0, 0.0, None))[2]


def guaranteed_rejoin(
    problem: Problem, standby: Standby, target: float | None, most: float, spare: FeedFallback
) -> SuperposedRejoin | RestartFromRest | None:
    """The way back of least time and least time lost; None where none is found in less than `most` of both [s].

    Ways above the feed go to `spare`.
    """
    best: SuperposedRejoin | RestartFromRest | None = None
    enough, in_vain = max(ENOUGH * shortest(problem), SOON), 0
    for before in befores(problem, standby):
        if before is not None and (most <= enough or (best is not None and in_vain >= IN_VAIN)):
            break
        enough *= EASIER
        if before is not None and before.duration >= most:
            continue
        found: SuperposedRejoin | RestartFromRest | None = best_aside(problem, before, target, most, spare)
        if found is None and best is None and not isinstance(before, Before):
            found = restarted(problem, before, problem.left if target is None else target, most, spare)
        in_vain += 1
        if found is not None:
            best, most, in_vain = found, price(found), 0
    return best


def price(rejoin: RejoinMotion | None) -> float:
    """Time of a way back and what it loses [s]."""
    return np.inf if rejoin is None else rejoin.duration + rejoin.lost


def shortest(problem: Problem) -> float:
    """A time [s] in which there may be a way back: that of the joints alone, and of the feed alone."""
    return problem.guess + fed_time(problem)


def fed_time(problem: Problem) -> float:
    """The least time in which the feed lets the tip go aside [s]; 0 where none holds."""
    if problem.machine is None:
        return 0.0
    feed = feed_at(problem.commanded.run, problem.commanded.place(np.array([problem.left])))[0]
    tips = problem.machine.forward(np.stack([problem.start[0], problem.end(0.0, 0.0)[0]]))[0]
    return float(np.linalg.norm(tips[0] - tips[1]) / feed) if np.isfinite(feed) else 0.0


def befores(problem: Problem, standby: Standby) -> Iterator[Before | Stop | None]:
    """What the joints may do before the way aside: nothing, stop, or go on as they were for a while."""
    yield None
    for kind in (StopAlone, StopTogether):
        stop = kind(problem.start, problem.limits, problem.left)
        if stop.duration > 0.0:
            yield stop
    for wait in waits(problem, standby):
        clocks = (problem.left, standby.clock(wait))
        yield Before(standby.current, standby.local, standby.offset, wait, clocks)


def waits(problem: Problem, standby: Standby) -> Iterator[float]:
    """Times [s] after which a way aside is tried: where the limits leave room, at last at rest."""
    rest = standby.current.law.duration - standby.local
    if rest <= 0.0:
        return
    t = np.unique(np.concatenate([np.geomspace(min(1e-3, rest), rest, 200), np.linspace(0.0, rest, 200)[1:]]))
    motion = standby.current.motion(standby.local + t)
    limits = [getattr(problem.limits, kind) for kind in KINDS]
    used = np.max([(np.abs(rate) / limit).max(axis=1) for rate, limit in zip(motion[1:], limits)], axis=0)
    if problem.limits.rows:
        used = np.maximum(used, row_use(problem.limits.rows, motion))
    ahead = np.minimum(np.searchsorted(t, t + shortest(problem), side="right"), len(t) - 1)
    used = np.array([used[k : last + 1].max() for k, last in enumerate(ahead)])
    for room in (0.5, 0.9):
        # the first instants of some stretches that leave room for as long as a way may take
        free = np.flatnonzero((used < room) & np.append(True, used[:-1] >= room))
        yield from t[free[np.unique(np.geomspace(1, len(free), WAITS // 2).astype(int) - 1)]] if len(free) else ()
    yield rest


def best_aside(
    problem: Problem, before: Before | Stop | None, target: float | None, most: float, spare: FeedFallback
) -> SuperposedRejoin | None:
    """The best way aside after what is before it, in less time and time lost than `most` [s]."""
    best, state, left = None, problem.start, problem.left
    if before is not None:
        state, left = before.state(), before.clocks[1]
    for pace in (0.0,) if isinstance(before, Stop) else PACES:
        found, cost = with_pace(problem, state, left, pace, target, before, most, spare)
        if found is not None and cost < most:
            best, most = found, cost
    return best


def restarted(
    problem: Problem, before: Stop | None, place: float, most: float, spare: FeedFallback
) -> RestartFromRest | None:
    """To rest at a place of the path, on the clock of its law, and on from there, in less than `most` [s].

    None where already the way to the path passes feed or travel.
    """
    state, paces = problem.start if before is None else before.state(), (0.0, 0.0, 0.0)
    shape = guessed(problem, state, place, paces)
    to_rest, _ = lengthened(problem, state, shape, lambda shape: (shape, place, paces), before, most, spare)
    if to_rest is None:
        return None
    sure = steepest(problem.commanded, place, problem.limits)
    for steeper in STEEPER + FLATTER * bool(problem.limits.rows):
        way = RestartFromRest(to_rest, PaceRise(steeper * sure))
        if check_limits(problem, way, FINAL).passes:
            return way if price(way) < most else None
    return None


def first_pace(problem: Problem, state: Floats, clock: float) -> float:
    """The pace of the commanded motion that comes nearest to a state (3, m)."""
    rate = problem.end(clock - problem.left, 0.0)[1] / problem.limits.velocity
    square = float(rate @ rate)
    if not square > 0.0:
        return 1.0
    return float(np.clip((state[1] / problem.limits.velocity) @ rate / square, 0.0, 1.5))


def with_pace(
    problem: Problem,
    state: Floats,
    clock: float,
    pace: float,
    target: float | None,
    before: Before | Stop | None,
    most: float,
    spare: FeedFallback,
) -> tuple[SuperposedRejoin | None, float]:
    """The way aside at a pace, as short as is found, and its time with what it loses; None where none passes."""
    paces = (first_pace(problem, state, clock), pace, 1.0)

    def placed(shape: Shape) -> Placed | None:
        return (shape, clock, paces) if target is None else to_place(shape, clock, paces, target)

    return lengthened(problem, state, guessed(problem, state, clock, paces), placed, before, most, spare)


def lengthened(
    problem: Problem,
    state: Floats,
    shape: Shape | None,
    placed: Callable[[Shape], Placed | None],
    before: Before | Stop | None,
    most: float,
    spare: FeedFallback,
) -> tuple[SuperposedRejoin | None, float]:
    """The first way that passes, of a shape that is stretched by and by, and its time with what it loses."""
    for _ in range(TRIES):
        there = placed(shape) if shape is not None else None
        if there is None:
            break
        shape, begin, paces = there
        way = SuperposedRejoin(problem.commanded, problem.left, state, begin, paces, shape, before)
        cost = way.duration + way.lost
        if cost >= most:
            break
        seen = check_limits(problem, way, SAMPLES)
        if seen.passes:
            seen = check_limits(problem, way, FINAL)
        if seen.passes:
            return way, cost + seen.above
        spare.keep(way, seen)
        shape = stretched(shape, seen)
    return None, np.inf


def to_place(shape: Shape, clock: float, paces: tuple[float, float, float], target: float) -> Placed | None:
    """The shape, the clock at its start and the paces with which it ends at a time of the commanded law.

    None where it never comes there. With a lower pace where the time to there is too short or too long for the shape,
    and from rest where it has passed.
    """
    if target <= NOT_BEGUN:
        return shape, target, (0.0, 0.0, 0.0)
    left, ramps = target - clock, shape.ramp * (paces[0] + paces[2]) / 2.0
    pace = (left - ramps) / (shape.ramp + shape.even)
    if pace < 0.0:
        return shape, target - shape.ramp / 2.0, (0.0, 0.0, 1.0)
    if pace <= paces[1]:
        return shape, clock, (paces[0], pace, paces[2])
    return (Shape(shape.ramp, (left - ramps) / paces[1] - shape.ramp), clock, paces) if paces[1] > 0.0 else None


def stretched(shape: Shape, seen: LimitCheck) -> Shape:
    """A longer one, by what is passed."""
    low, high = GROWTH
    ramps, even = shape.ramp, shape.ramp + shape.even
    if seen.joints > DETOUR or not seen.inside:
        ramps *= float(np.clip(sqrt(seen.joints), low, high))
    if seen.feed > DETOUR:
        even *= float(np.clip(seen.feed, low, high))
        if seen.feed < 1.05:
            ramps *= low
    return Shape(ramps, max(even - ramps, 0.0))


def guessed(problem: Problem, state: Floats, clock: float, paces: tuple[float, float, float]) -> Shape | None:
    """Ramps and even part by closed forms; None where the feed leaves nothing for a way aside at the pace."""
    first, pace, last = paces
    q, v, _, _ = problem.end(clock - problem.left, 0.0)
    velocity, acceleration, jerk = (getattr(problem.limits, kind) for kind in KINDS)
    off = np.abs(state[0] - q)
    slower = np.abs((first - pace) * v) + np.abs((last - pace) * v)
    with np.errstate(divide="ignore", invalid="ignore"):
        ramps = max(
            LEAST, float((1.5 * slower / (SHARE * acceleration)).max()), sqrt((6.0 * slower / (SHARE * jerk)).max())
        )
        room = np.maximum(velocity - pace * np.abs(v), 0.05 * velocity)
        even = float((off / room).max())
    if problem.machine is not None:
        fed = even_by_feed(problem, state[0], q, v, clock, pace)
        if fed is None:
            return None
        even = max(even, fed)
    alone = float(np.cbrt(6.0 * off / (SHARE * jerk)).max())
    if alone >= even:
        even = ramps = max(ramps, alone)
    else:
        ramps = max(ramps, sqrt((6.0 * off / (SHARE * jerk * even)).max()))
        ramps = max(ramps, float((1.5 * off / (SHARE * acceleration * even)).max()))
    return Shape(ramps, max(even - ramps, 0.0))


def even_by_feed(problem: Problem, found: Floats, q: Floats, v: Floats, clock: float, pace: float) -> float | None:
    """The least time [s] in which the tip gets aside beside a pace; None where the feed leaves none.

    |pace u - off w| = feed, u the velocity of the tip on the path, w one over the time.
    """
    assert problem.machine is not None
    run = problem.commanded.run
    feed = float(feed_at(run, problem.commanded.place(np.array([clock])))[0])
    tips = problem.machine.forward(np.stack([found, q]))[0]
    off = tips[0] - tips[1]
    far = float(off @ off)
    if not np.isfinite(feed) or far == 0.0:
        return 0.0
    going = pace * tip_velocity(problem.machine, q[None], v[None])[0]
    along, left = float(going @ off), feed * feed - float(going @ going)
    if left < 0.0:
        left = 0.0
    most = (along + sqrt(along * along + far * left)) / far
    return 1.0 / most if most * 1e4 > 1.0 else None
