"""The models `lookahead` and `fir` of a control: the time of each move, from the limits of the axes.

`lookahead`: short blocks joined within a tolerance, as a control's compressor does; rounded corners; a bounded number
of blocks ahead.

`fir`: pulses of velocity smoothed by two moving averages, after Ward, Sencer, Jones and Ozturk, "Accurate prediction of
machining feedrate and cycle times considering interpolator dynamics", Int. J. Adv. Manuf. Technol. 116 (2021), arXiv
2102.02062: filters in place of ramps, corners blended by overlap, the feed at a corner as high as the tolerance and the
axes allow. Corners close to each other are taken together here, as far as the filters see.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from toolpace.common.arrays import Bools, Floats, Ints
from toolpace.common.units import MILLIMETRE
from toolpace.controls.timing.axis_motion import AxisWays, axis_ways, linear_columns
from toolpace.controls.timing.figures import ControlFigures, limits_of, off_the_path
from toolpace.programs.commanded import BLENDED, Commanded

if TYPE_CHECKING:
    from toolpace.machine.limits import Limits
    from toolpace.machine.machine import Machine

SHORTEST = 1e-6
"""Of a moving average [s]."""


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
        from toolpace.kernels.controls import chains_of

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


def lookahead_times(moves: Commanded, machine: Machine, figures: ControlFigures) -> Floats:
    """Time of each move (n,) [s], dwells left out.

    Short blocks that stay near one line go along it where that is faster, as `Chains` says.
    """
    limits, stop = limits_of(machine, figures), rests(moves)
    ways = axis_ways(moves, machine, joints=figures.limits == "joints")
    room, off = room_of(moves, figures), off_the_path(machine, figures)

    def driven(ways: AxisWays, line: Floats) -> Floats:
        cruise = cruise_speeds(moves, ways, limits.velocity, limits.acceleration, figures.block_time)
        return _driven(cruise, ways, line, stop, room, limits, off, figures.look_ahead)

    apart = driven(ways, ways.length)
    chains = Chains.of_moves(ways, moves, stop, merging_of(moves, figures), off)
    if not chains.joined.any():
        return apart
    chains = chains.faster(apart, driven(*chains.straight()))
    return driven(*chains.straight())


def _driven(
    cruise: Floats, ways: AxisWays, line: Floats, stop: Bools, room: Floats, limits: Limits, off: Floats, depth: int
) -> Floats:
    """Time of each move (n,) [s].

    Corners as `kernels.controls.corner_speeds` says; constant acceleration between them, which no jerk
    limits but at stops: each takes longer by what jerk adds to its ramps. line: (n,) length of the straight way that a
    move is part of.
    """
    from toolpace.kernels import controls

    begin, end = controls.corner_speeds(
        cruise, line, ways.first, ways.last, stop, room, limits.acceleration, limits.jerk, off
    )
    along = np.minimum(ways.along(limits.acceleration), 1e12)
    controls.ramps(cruise, ways.length, along, begin, end, depth)
    times = controls.times_of(cruise, ways.length, along, begin, end)
    top = np.minimum(cruise, np.sqrt(0.5 * (begin**2 + end**2) + along * ways.length))
    at_rest = np.flatnonzero(stop)
    starts, ends = at_rest[:-1] + 1, at_rest[1:]
    # what is reached between two rests, by however many moves it is
    top = np.maximum.reduceat(top, starts)
    jerk = ways.along(limits.jerk)
    # half where the motion begins, half where it ends
    times[starts] += 0.5 * built_up(top, along[starts], jerk[starts])
    times[ends] += 0.5 * built_up(top, along[ends], jerk[ends])
    return times


def built_up(speed: Floats, acceleration: Floats, jerk: Floats) -> Floats:
    """Time (n,) by which jerk lengthens a ramp between rest and a speed [s]: a / j, or less where a is not reached."""
    with np.errstate(invalid="ignore"):
        short = 2.0 * np.sqrt(speed / jerk) - speed / acceleration
        return np.asarray(np.where(speed * jerk >= acceleration**2, acceleration / jerk, short))


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


def rests(moves: Commanded) -> Bools:
    """(n,) whether the control rests at the end of each move."""
    stop = moves.stop | (moves.joining != BLENDED) | (moves.dwell > 0.0)
    # a rapid is positioned before what follows it
    stop[:-1] |= moves.rapid[:-1] != moves.rapid[1:]
    stop[[0, -1]] = True
    return np.asarray(stop)


def merging_of(moves: Commanded, figures: ControlFigures) -> Floats:
    """(n,) tolerance within which moves are taken as one [m]: the program's, the control's, or that of corners."""
    if figures.compress is None:
        merging = room_of(moves, figures)
    else:
        merging = np.full(len(moves), figures.compress * MILLIMETRE)
    return np.where(np.isnan(moves.cam_tolerance), merging, moves.cam_tolerance)


def room_of(moves: Commanded, figures: ControlFigures) -> Floats:
    """(n,) tolerance of the corner at the end of each move [m]."""
    return np.where(np.isfinite(moves.tolerance) & (moves.tolerance > 0.0), moves.tolerance, figures.room)


def filtered_times(moves: Commanded, machine: Machine, figures: ControlFigures) -> Floats:
    """Time of each move (n,) [s], dwells left out. Rapids ramp by their axes' limits, as of the model `lookahead`."""
    from toolpace.kernels import controls

    limits = limits_of(machine, figures)
    ways = axis_ways(moves, machine, joints=figures.limits == "joints")
    cruise = cruise_speeds(moves, ways, limits.velocity, limits.acceleration, figures.block_time)
    ramp, smoothing = filter_lengths(moves, machine, limits, figures)
    stop = rests(moves)
    speeds = controls.blended_speeds(
        cruise, ways.length, ways.first, ways.last, stop, room_of(moves, figures), limits.acceleration, limits.jerk,
        off_the_path(machine, figures), ramp, smoothing,
    )  # fmt: skip
    times = controls.pulse_times(cruise, ways.length, speeds, ramp + smoothing)
    return np.where(moves.rapid, lookahead_times(moves, machine, figures), times)


def filter_lengths(moves: Commanded, machine: Machine, limits: Limits, figures: ControlFigures) -> tuple[float, float]:
    """Lengths of the two moving averages [s], the longer first.

    What is not told follows from the slowest linear axis: the first average lets it reach the program's highest feed
    at its most acceleration, the second lets that build up at its most jerk.
    """
    linear = linear_columns(machine)
    with np.errstate(divide="ignore", invalid="ignore"):
        speed = np.where(moves.time > 0.0, moves.length / moves.time, moves.speed)
    cutting = speed[np.isfinite(speed) & ~moves.rapid & (moves.length > 0.0)]
    feed = min(float(cutting.max(initial=0.0)), float(limits.velocity[linear].max()))
    slowest = float(limits.acceleration[linear].min())
    ramp = figures.ramp_time or (feed / slowest if np.isfinite(feed) else 0.0)
    smoothing = figures.smoothing_time or (slowest / float(limits.jerk[linear].min()) if np.isfinite(slowest) else 0.0)
    return max(ramp, smoothing, SHORTEST), max(min(ramp, smoothing), SHORTEST)
