"""What all models make of the moves of a program: rests, tolerances, speeds, and times by their profile."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from toolpace.common.arrays import Bools, Floats
from toolpace.common.units import MILLIMETRE
from toolpace.controls.timing.axis_motion import AxisWays
from toolpace.controls.timing.figures import ControlFigures
from toolpace.programs.commanded import BLENDED, Commanded

MOST_SPEED, MOST_ACCELERATION, MOST_JERK = 1e6, 1e9, 1e15
"""Of what no axis limits [m/s], [m/s^2], [m/s^3]."""
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
    if look_ahead:
        ends = np.minimum(ends, stoppable_speeds(ways, most, sharpest, look_ahead))
    times[rows], speeds[rows] = profile_of_chain(ways, np.minimum(feed[rows], MOST_SPEED), ends, most, sharpest)
    return MotionProfile(times, speeds, acceleration, jerk)
