"""What all models make of the moves of a program: rests, tolerances, speeds, and times by their profile; the chains of
short blocks that a control takes as one line, as its compressor does; and the model `lookahead`, which needs no more.

`lookahead` is a control of which a few figures are known. Corners are rounded within a tolerance, as
`kernels.controls.rounding` says; short blocks are joined; between the corners the speed has the profile of all models,
with limited jerk.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from toolpace.common.arrays import Bools, Floats, Ints
from toolpace.common.units import MILLIMETRE
from toolpace.controls.timing.axis_motion import AxisWays, axis_ways
from toolpace.controls.timing.figures import ControlFigures, limits_of, off_the_path
from toolpace.programs.commanded import BLENDED, Commanded

if TYPE_CHECKING:
    from toolpace.machine.machine import Machine

MOST_SPEED, MOST_ACCELERATION, MOST_JERK = 1e6, 1e9, 1e15
"""Of what no axis limits [m/s], [m/s^2], [m/s^3]."""
ROUNDING = 1e-9
"""Share of a length that is rounding."""
FEED = MILLIMETRE / 60.0
"""A feed of 1 mm/min [m/s]."""


class MotionProfile(NamedTuple):
    """What a model makes of moves."""

    times: Floats
    """(n,) time of each move [s], dwells left out."""
    corner: Floats
    """(n,) speed at the end of each move, of the tip [m/s] or in place [rad/s]; nan where the model does not tell."""
    acceleration: Floats
    """(n,) along each move, where its speed changes."""
    jerk: Floats
    """(n,) the same; inf where none is kept."""
    ways: AxisWays | None = None
    """Of moves that go along one line with their neighbours; None where each goes its own way."""


def rests(moves: Commanded) -> Bools:
    """(n,) whether the control rests at the end of each move."""
    stop = moves.stop | (moves.joining != BLENDED) | (moves.dwell > 0.0)
    # a rapid is positioned before what follows it
    stop[:-1] |= moves.rapid[:-1] != moves.rapid[1:]
    stop[[0, -1]] = True
    return np.asarray(stop)


def rest_ends(stop: Bools, length: Floats) -> Floats:
    """(n,) 1 for each move that ends at rest, 0 for the others; rests that no move leads to are none."""
    found = np.zeros(len(stop))
    rows = np.flatnonzero(length > 0.0)
    if len(rows):
        found[rows] = np.logical_or.reduceat(stop, rows)
        found[rows[-1]] = 1.0
    return found


def room_of(moves: Commanded, figures: ControlFigures) -> Floats:
    """(n,) tolerance of the corner at the end of each move [m]."""
    return np.where(np.isfinite(moves.tolerance) & (moves.tolerance > 0.0), moves.tolerance, figures.room)


def cruise_speeds(
    moves: Commanded, ways: AxisWays, velocity: Floats, acceleration: Floats, block_time: float
) -> Floats:
    """Most speed (n,) of each move by its feed, the limits of the axes and the time that a block takes to read."""
    turns = moves.length <= 0.0
    speed = np.where(turns, moves.turn, moves.speed)
    least = np.maximum(moves.time, np.where(moves.rapid, 0.0, block_time))
    with np.errstate(divide="ignore", invalid="ignore"):
        timed = np.where(least > 0.0, ways.length / least, np.inf)
    return np.minimum(np.minimum(speed, timed), np.minimum(ways.caps(velocity, acceleration), 1e6))


def profile_along(
    feed: Floats, length: Floats, corner: Floats, acceleration: Floats, jerk: Floats, look_ahead: int = 0
) -> MotionProfile:
    """Times of moves and speeds at their ends, from the speeds that are allowed on the way and at the ends.

    feed: (n,) most speed of each move. length: (n,); moves of length zero take no time, and their corners count for
    the move before. corner: (n,) most speed at the end of each. acceleration, jerk: (n,) along each. look_ahead: a
    control that reads so many moves ahead can stop at the end of the last; 0: it reads all.
    """
    from toolpace.kernels.controls.path_profile import profile_of_chain, stoppable_speeds

    times, speeds = np.zeros(len(length)), np.zeros(len(length))
    rows = np.flatnonzero(length > 0.0)
    if not len(rows):
        return MotionProfile(times, speeds, acceleration, jerk)
    ends = np.minimum.reduceat(np.minimum(corner, MOST_SPEED), rows)
    ends[-1] = 0.0
    ways, most = length[rows], np.minimum(acceleration[rows], MOST_ACCELERATION)
    sharpest = np.minimum(jerk[rows], MOST_JERK)
    if look_ahead and not _can_always_stop(np.minimum(ends, feed[rows]), ways, most, sharpest, look_ahead):
        ends = np.minimum(ends, stoppable_speeds(ways, most, sharpest, look_ahead))
    times[rows], speeds[rows] = profile_of_chain(ways, np.minimum(feed[rows], MOST_SPEED), ends, most, sharpest)
    return MotionProfile(times, speeds, acceleration, jerk)


def _can_always_stop(speed: Floats, length: Floats, acceleration: Floats, jerk: Floats, look_ahead: int) -> bool:
    """Whether a ramp to rest from each speed (n,) fits into the next blocks, with the least limits of all of them.

    That is sooner said than the speed that just fits, which takes n times `look_ahead` steps.
    """
    covered = np.cumsum(length)
    ahead = covered[look_ahead:] - covered[:-look_ahead]
    slowest, softest, fast = acceleration.min(), jerk.min(), speed[: len(ahead)]
    spent = np.where(
        fast * softest >= slowest**2, fast / slowest + slowest / softest, 2.0 * np.sqrt(fast / softest)
    )
    return bool(np.all(0.5 * fast * spent < ahead * (1.0 - ROUNDING)))


Driven = Callable[[AxisWays, Floats], MotionProfile]
"""The profile of moves, from their ways and the length (n,) of the straight way that each is part of."""


@dataclass(frozen=True)
class Chains:
    """Moves, and which of them go along one line together.

    A move that is one of several keeps its share of the line, and its own feed and time.
    """

    ways: AxisWays
    of: Ints
    """(n,) the chain that each move belongs to, from 0 on, in order."""
    step: Floats
    """(n, axes) change of the axes over each move."""
    line: Floats
    """(chains,) from end to end [m], or [rad] of turns in place."""
    joined: Bools
    """(chains,) whether the moves go along the line; else each goes its own way."""

    @classmethod
    def of_moves(cls, ways: AxisWays, moves: Commanded, stop: Bools, tolerance: Floats, way: Floats) -> Chains:
        """Chains of straight moves at feed without rest between them that stay within a tolerance of their line.

        stop: (n,) rest at the end. tolerance: (n,) [m]. way: (axes,) what a unit of an axis leaves of the path [m].
        """
        from toolpace.kernels.controls.chains import chains_of

        step = 0.5 * (ways.first + ways.last) * ways.length[:, None]
        turns = moves.length <= 0.0
        alone = moves.rapid | (moves.sweep > 0.0) | (ways.length <= 0.0)
        cut = stop.copy()
        cut[:-1] |= (turns[1:] != turns[:-1]) | (moves.tip_mode[1:] != moves.tip_mode[:-1])
        of = chains_of(np.cumsum(step * way, axis=0), tolerance, alone, cut)
        begin = np.flatnonzero(np.diff(of, prepend=-1))
        words = np.add.reduceat(moves.way, begin)
        line = np.where(turns[begin], np.linalg.norm(words[:, 3:], axis=1), np.linalg.norm(words[:, :3], axis=1))
        return cls(ways, of, step, line, (np.diff(begin, append=len(of)) > 1) & (line > 0.0))

    @cached_property
    def begin(self) -> Ints:
        """(chains,) the first move of each."""
        return np.asarray(np.flatnonzero(np.diff(self.of, prepend=-1)))

    @cached_property
    def share(self) -> Floats:
        """(chains,) length of the line over that of its moves."""
        path = np.add.reduceat(self.ways.length, self.begin)
        return np.asarray(np.where(self.joined, self.line / np.where(path > 0.0, path, 1.0), 1.0))

    def straight(self) -> tuple[AxisWays, Floats]:
        """The ways of the moves, and the length (n,) of the straight way that each is part of."""
        ways, of = self.ways, self.joined[self.of]
        rates = np.add.reduceat(self.step, self.begin) / np.where(self.joined, self.line, np.inf)[:, None]
        first, last = (np.where(of[:, None], rates[self.of], each) for each in (ways.first, ways.last))
        most = np.where(of[:, None], np.abs(rates)[self.of], ways.most)
        length = ways.length * self.share[self.of]
        found = replace(ways, length=length, first=first, last=last, most=most)
        return found, np.where(of, self.line[self.of], length)

    def faster(self, apart: Floats, together: Floats) -> Chains:
        """Those chains alone that take less time along their lines: a curve in short blocks stays one.

        apart, together: (n,) time of each move, where each goes its own way, and where all go along their lines.
        """
        before, now = (np.add.reduceat(times, self.begin) for times in (apart, together))
        return replace(self, joined=self.joined & (now < before))


def profile_along_chains(
    moves: Commanded, ways: AxisWays, stop: Bools, figures: ControlFigures, way: Floats, driven: Driven
) -> MotionProfile:
    """The profile of moves, each along one line with its neighbours where that is faster, as `Chains` says."""
    apart = driven(ways, ways.length)
    chains = Chains.of_moves(ways, moves, stop, merging_of(moves, figures), way)
    if not chains.joined.any():
        return apart
    straight = chains.faster(apart.times, driven(*chains.straight()).times).straight()
    return driven(*straight)._replace(ways=straight[0])


def merging_of(moves: Commanded, figures: ControlFigures) -> Floats:
    """(n,) tolerance within which moves are taken as one [m]: the program's, the control's, or that of corners."""
    if figures.compress is None:
        merging = room_of(moves, figures)
    else:
        merging = np.full(len(moves), figures.compress * MILLIMETRE)
    return np.where(np.isnan(moves.cam_tolerance), merging, moves.cam_tolerance)


def lookahead_profile(moves: Commanded, machine: Machine, figures: ControlFigures) -> MotionProfile:
    """Times of moves and speeds at their ends."""
    from toolpace.kernels.controls.rounding import rounded_speeds

    limits, stop = limits_of(machine, figures), rests(moves)
    room, off = room_of(moves, figures), off_the_path(moves, machine, figures)

    def driven(ways: AxisWays, line: Floats) -> MotionProfile:
        feed = cruise_speeds(moves, ways, limits.velocity, limits.acceleration, figures.block_time)
        corner = rounded_speeds(feed, line, ways.first, ways.last, stop, room, limits.acceleration, limits.jerk, off)
        along = ways.along(limits.acceleration), ways.along(limits.jerk)
        return profile_along(feed, ways.length, corner, *along, figures.look_ahead or 0)

    ways = axis_ways(moves, machine, joints=figures.limits == "joints")
    return profile_along_chains(moves, ways, stop, figures, off, driven)
