"""The model `lookahead`: axis limits, rounded corners, a bounded number of blocks ahead."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from toolpace.common.arrays import Bools, Floats
from toolpace.common.units import MILLIMETRE
from toolpace.controls.timing.axis_limits import limits_of, off_the_path
from toolpace.controls.timing.axis_motion import AxisWays, axis_ways
from toolpace.controls.timing.compressor import Chains
from toolpace.controls.timing.figures import ControlFigures
from toolpace.programs.commanded import BLENDED, Commanded

if TYPE_CHECKING:
    from toolpace.machine.limits import Limits
    from toolpace.machine.machine import Machine


def lookahead_times(moves: Commanded, machine: Machine, figures: ControlFigures) -> Floats:
    """Time of each move (n,) [s], dwells left out.

    Short blocks that stay near one line go along it where that is faster, as `compressed` says.
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

    Corners as `kernels.controls.lookahead.corner_speeds` says; constant acceleration between them, which no jerk
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
