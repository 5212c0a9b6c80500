"""A rejoin motion and the rest of its run, as one joint run; and the stretches of the path that it leaves out."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from toolpace.common.arrays import Bools, Floats, Ints
from toolpace.common.units import format_length
from toolpace.deflection.compensation import CompensatedRun
from toolpace.deflection.feed import above_feed, feed_at, tip_velocity
from toolpace.deflection.rejoin_motion import RejoinMotion
from toolpace.machine.machine import Machine
from toolpace.motion.trajectory import Skipped
from toolpace.path.axis_run import AxisRun

STRAIGHT = 1e-6
"""Share of v^2 / a up to which the parameter is taken as linear in time before Newton's steps, which do the rest."""
NEWTON_STEPS = 2
"""From the closed form, or from the line; each squares the error, so that two leave rounding."""
SHARPEST = 6.0
"""Most relative change of the parameter's speed over a detour, as an exponent; see DetourRun."""
LEAST_WAY = 1e-6
"""Least way of the parameter over the detour at its speed of rejoining, over the length of the run."""
LEFT_OUT = 1e-5
"""Distance from the tip's way beyond which a point of the path is left out: the tolerance that a fit and the judge take
where no other is given [m]; without a machine of the joints."""
SPACING = 5e-5
"""Wanted between two points of path and way [m]: a chord of it is within 0.3 um of an arc of 1 mm."""
FEWEST, MOST_POINTS = 64, 1024
"""Points of path and way each: enough for a short one, and what costs 20 ms for a long one."""


class DetourRun(AxisRun):
    """A detour and then the rest of the run that it rejoins, in one parameter p that goes on as that of the run.

    On the detour p(t) is a cubic of time with the speed v and acceleration a of the run's parameter at the rejoining:
    dp/dt = v (1 + y + y^2 / 2), y = a x / v, at the time x <= 0 before it; that is never less than v / 2. Where the
    joints come to rest as they rejoin (v = 0, an end of the run), p is time and the run ends there. Where v is next to
    nothing or changes by much over the detour, p is time on the detour, and the path goes on in another slope.
    """

    def __init__(self, detour: RejoinMotion, machine: Machine | None, lag: float = 0.0) -> None:
        """`lag` is what earlier detours on the same run have lost [s]."""
        commanded = detour.commanded
        self.detour, self.machine, self.rest_of, self.lag = detour, machine, commanded.run, lag
        place, self.v, self.a, _ = map(float, commanded.law.at(np.array([detour.rejoin]))[:, 0])
        self.joints = detour.motion(np.zeros(1)).shape[2]
        length, span = commanded.run.s1 - commanded.run.s0, detour.duration
        self.ends_here = bool(commanded.still(np.array([self.v]))[0])
        self.smooth = (
            not self.ends_here and abs(self.a) * span <= SHARPEST * self.v and self.v * span >= LEAST_WAY * length
        )
        """Whether the path over the parameter is twice continuously differentiable at the rejoining."""
        if not self.smooth:
            self.v, self.a = 1.0, 0.0
        self.leads_to_start = self.ends_here and detour.rejoin <= commanded.law.duration / 2.0
        """Whether the joints come to rest where the run that is rejoined starts: all of that is still to come, as the
        next run. What stands at the start may be a rounding behind it."""
        self.join = commanded.run.s0 if self.leads_to_start else min(max(place, commanded.run.s0), commanded.run.s1)
        self.s0 = float(self.parameter(np.zeros(1))[0, 0])
        self.s1 = self.join if self.ends_here else commanded.run.s1
        self.dwell = 0.0 if self.leads_to_start else commanded.run.dwell
        self.kinks = detour.times[1:-1]
        """(k,) times since the start at which the jerk may jump [s]."""
        own = self.parameter(self.kinks)[0]
        later = commanded.run.breaks[commanded.run.breaks > self.join]
        self.breaks = np.concatenate([own, [] if self.ends_here else [self.join], [] if self.ends_here else later])
        hints = commanded.run.hints
        after = np.empty(0) if self.ends_here else hints[hints > self.join]
        self.hints = np.concatenate([own, after]) if len(hints) else own
        self.blocks = commanded.run.blocks
        self.tool_length = commanded.run.tool_length

    @cached_property
    def above(self) -> tuple[float, float]:
        """By what share of the feed the tip starts above it, at most, and until when [s]; 0, 0 where it does not.

        The joints keep their velocities and accelerations, and the tip, found elsewhere, may thereby be faster than
        the feed, or come to be: no command can change that at once.
        """
        return above_feed(self.detour, self.machine)

    def parameter(self, t: Floats) -> Floats:
        """(4, n) p and three time derivatives at times (n,) since the start, where the detour runs as made."""
        x = t - self.detour.duration
        y = self.a * x / self.v
        return np.stack(
            [
                self.join + self.v * x * (1.0 + y / 2.0 + y * y / 6.0),
                self.v * (1.0 + y + y * y / 2.0),
                self.a * (1.0 + y),
                np.full_like(x, self.a**2 / self.v),
            ]
        )

    def time_at(self, p: Floats) -> Floats:
        """(n,) the inverse of `parameter`: z = 1 + y solves z^3 + 3 z = 4 + 6 a (p - join) / v^2."""
        way = p - self.join
        x = way / self.v
        if abs(self.a) > 0.0:
            k = self.a * way / self.v**2
            z = 2.0 * np.sinh(np.arcsinh((4.0 + 6.0 * k) / 2.0) / 3.0)
            x = np.where(np.abs(k) > STRAIGHT, (z - 1.0) * self.v / self.a, x)
        for _ in range(NEWTON_STEPS):
            y = self.a * x / self.v
            x = x - (self.v * x * (1.0 + y / 2.0 + y * y / 6.0) - way) / (self.v * (1.0 + y + y * y / 2.0))
        return np.clip(x + self.detour.duration, 0.0, self.detour.duration)

    def on_detour(self, s: Floats) -> Bools:
        """(n,) which places lie on the detour."""
        on: Bools = (s < self.join) | self.ends_here
        return on

    def evaluate(self, s: Floats) -> Floats:
        on = self.on_detour(s)
        out = np.empty((4, len(s), self.joints))
        if not on.all():
            out[:, ~on] = self.rest_of.evaluate(s[~on])
        if on.any():
            t = self.time_at(s[on])
            _, w, w1, w2 = (value[:, None] for value in self.parameter(t))
            first, second, third = 1.0 / w, -w1 / w**3, -w2 / w**4 + 3.0 * w1**2 / w**5
            q, qd, qdd, qddd = self.detour.motion(t)
            out[:, on] = [
                q,
                qd * first,
                qdd * first**2 + qd * second,
                qddd * first**3 + 3.0 * qdd * first * second + qd * third,
            ]
        return out

    def speed_cap(self, s: Floats) -> Floats:
        on = self.on_detour(s)
        out = np.full(len(s), np.inf)
        if not on.all():
            out[~on] = self.rest_of.speed_cap(s[~on])
        if self.machine is None or not on.any():
            return out
        t = self.time_at(s[on])
        feed = feed_at(self.rest_of, self.detour.abreast(t))
        q, qd = self.detour.motion(t)[:2]
        with np.errstate(divide="ignore", invalid="ignore"):
            share = np.where(
                np.isfinite(feed), feed / np.linalg.norm(tip_velocity(self.machine, q, qd), axis=1), np.inf
            )
        # what the start is above the feed by is told apart, and may not become more
        share = np.where(t <= self.above[1], np.maximum(share, 1.0), share)
        out[on] = share * self.parameter(t)[1]
        return out

    def block_at(self, s: Floats) -> Ints:
        on = self.on_detour(s)
        return self.rest_of.block_at(np.where(on, self.detour.abreast(self.time_at(s)), s))


def skipped_by(run: DetourRun, place: float) -> tuple[Skipped, ...]:
    """What a detour leaves out from a place of it on, in the order of the path."""
    detour, followed = run.detour, run.rest_of
    if not run.on_detour(np.array([place]))[0]:
        return ()
    begin = float(run.time_at(np.array([place]))[0])
    compensation = followed.compensation if isinstance(followed, CompensatedRun) else None
    path = followed.base if isinstance(followed, CompensatedRun) else followed
    start = float(detour.abreast(np.array([begin]))[0])
    if run.leads_to_start or not start < run.join or not begin < detour.duration:
        return ()

    def tips(count: int) -> tuple[Floats, Floats, Floats]:
        """Parameters (count,), the path there and the way, (count, c) each."""
        s, t = np.linspace(start, run.join, count), np.linspace(begin, detour.duration, count)
        way = tip_of(run.machine, detour.motion(t)[0])
        return s, tip_of(run.machine, path.evaluate(s)[0]), way if compensation is None else way - compensation.offset

    s, on_path, way = tips(FEWEST)
    longest = max(float(np.linalg.norm(np.diff(each, axis=0), axis=1).sum()) for each in (on_path, way))
    if longest > FEWEST * SPACING:
        s, on_path, way = tips(int(min(longest / SPACING, MOST_POINTS)))
    off = distances(on_path, way)
    steps = np.linalg.norm(np.diff(on_path, axis=0), axis=1)
    out = np.concatenate([[False], off > LEFT_OUT, [False]])
    firsts, ends = np.flatnonzero(out[1:] & ~out[:-1]), np.flatnonzero(out[:-1] & ~out[1:])
    found = []
    for first, end in zip(firsts, ends):
        low, high = max(int(first) - 1, 0), min(int(end), len(s) - 1)
        blocks = path.block_at(s[[low, high]])
        length = float(steps[low:high].sum())
        found.append(Skipped(float(s[low]), float(s[high]), length, float(off[first:end].max()), *map(int, blocks)))
    # where the path stands still there is no length to leave out
    return tuple(each for each in found if each.length > 0.0)


def skipped_in_words(skipped: Skipped, machine: Machine | None) -> str:
    """One line for people."""
    first, last = skipped.first_block, skipped.last_block
    blocks = "" if not first else f", block {first}" if first == last else f", blocks {first} to {last}"
    length, off = (
        (format_length(value) if machine is not None else f"{value:.4g} of the joints")
        for value in (skipped.length, skipped.off)
    )
    where = f"from s = {skipped.start:.6g} to {skipped.end:.6g}{blocks}"
    return f"the path is left out {where}: {length}, up to {off} off the way of the tip"


def tip_of(machine: Machine | None, q: Floats) -> Floats:
    """(n, 3) tips of joints (n, m) [m]; without a machine the joints."""
    return q if machine is None else machine.forward(q)[0]


def distances(points: Floats, way: Floats) -> Floats:
    """(n,) distance of points (n, c) from the chords of a way (k, c), beside its nearest corner."""
    square = (points**2).sum(axis=1)[:, None] + (way**2).sum(axis=1) - 2.0 * points @ way.T
    k = np.argmin(square, axis=1)
    sides = [from_chord(points, way[np.maximum(k - 1, 0)], way[k])]
    sides.append(from_chord(points, way[k], way[np.minimum(k + 1, len(way) - 1)]))
    return np.minimum(*sides)


def from_chord(points: Floats, begin: Floats, end: Floats) -> Floats:
    """(n,) distance of points (n, c), each from a chord of its own."""
    along = end - begin
    square = np.einsum("nc,nc->n", along, along)
    share = np.einsum("nc,nc->n", points - begin, along) / np.where(square > 0.0, square, 1.0)
    distance: Floats = np.linalg.norm(begin + np.clip(share, 0.0, 1.0)[:, None] * along - points, axis=1)
    return distance
