"""The model `heidenhain`: iTNC 530, TNC 640, by the Technical Manual MANUALplus 620 (2012, chapters 6.16 and 6.20).

* Profile along the path with limited jerk: axPathJerk of each axis by its share (pages 834, 835), and maxPathJerk
  (829); for rapids the figures with `Hi`. Up to 5000 blocks are read ahead (825).
* A filter smooths the nominal positions (811). Here it is the triangle filter, over 2 h: a corner at which the velocity
  changes by D is left by D h / 6, a curve of the curvature c at the speed v by v^2 c h^2 / 12. Feeds in corners and
  curves are so low that this stays within the tolerance of cycle 32 (502, 1124).
* Behind the filter no axis exceeds its acceleration nor jerk (834): D_j <= a_j h and D_j <= j_j h^2; where the
  curvature jumps, v^2 c_j <= j_j h.
* Feeds are not lower than minCornerFeed and minPathFeed, unless the program's F is (502).
* The filter ends its motion 2 h after what it filters: each rest takes that longer.

The HSC filters overshoot a little and are faster in circles (811); how, no manual tells: HSC-MODE changes nothing here.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from toolpace.common.arrays import Bools, Floats
from toolpace.controls.timing.axis_motion import AxisWays, Transitions, axis_ways, least_ratio, linear_columns
from toolpace.controls.timing.blocks import (
    FEED,
    MotionProfile,
    cruise_speeds,
    profile_along,
    profile_along_chains,
    rest_ends,
    rests,
    room_of,
)
from toolpace.controls.timing.figures import ControlFigures, limits_of, off_the_path
from toolpace.programs.commanded import Commanded

if TYPE_CHECKING:
    from toolpace.machine.limits import Limits
    from toolpace.machine.machine import Machine

READ_AHEAD = 5000


def heidenhain_profile(moves: Commanded, machine: Machine, figures: ControlFigures) -> MotionProfile:
    """Times of moves and speeds at their ends."""
    own, limits, stop = figures.heidenhain, limits_of(machine, figures), rests(moves)
    room, off = room_of(moves, figures), off_the_path(moves, machine, figures)
    half = half_filters(machine, limits, room, figures)
    path_jerk = np.where(moves.rapid, own.path_jerk_rapid, own.path_jerk)
    axis_jerk = np.where(moves.rapid, own.axis_jerk_rapid, 1.0)
    # the least feeds are those of the tip: turns in place have none
    free, tip_feed = np.full_like(limits.acceleration, np.inf), np.where(moves.length > 0.0, FEED, 0.0)
    depth = READ_AHEAD if figures.look_ahead is None else figures.look_ahead

    def driven(ways: AxisWays, line: Floats) -> MotionProfile:
        steady = cruise_speeds(moves, ways, limits.velocity, free, figures.block_time)
        # an arc has the same curvature everywhere; of others the largest of each axis is known
        arc, other = (np.linalg.norm(bend * off, axis=1) for bend in (ways.bend_first, ways.bend))
        across = np.where(arc > 0.0, arc, other)
        with np.errstate(divide="ignore"):
            filtered = np.sqrt(12.0 * room / across) / half
        curved = np.minimum(np.sqrt(least_ratio(limits.acceleration, ways.bend)), filtered)
        feed = np.minimum(steady, np.maximum(curved, own.least_path_feed * tip_feed))
        corner = np.maximum(
            corner_speeds(ways, line, stop, room, off, limits, half), own.least_corner_feed * tip_feed
        )
        jerk = np.minimum(axis_jerk * ways.along(limits.jerk), np.where(moves.length > 0.0, path_jerk, np.inf))
        found = profile_along(
            feed, ways.length, np.where(stop, 0.0, corner), ways.along(limits.acceleration), jerk, depth
        )
        return found._replace(times=found.times + 2.0 * half * rest_ends(stop, ways.length))

    ways = axis_ways(moves, machine, joints=figures.limits == "joints")
    return profile_along_chains(moves, ways, stop, figures, off, driven)


def half_filters(machine: Machine, limits: Limits, room: Floats, figures: ControlFigures) -> Floats:
    """(n,) half the length of the triangle filter in each move [s]."""
    if figures.heidenhain.filter_time:
        return np.full(len(room), 0.5 * figures.heidenhain.filter_time)
    return np.asarray(np.cbrt(6.0 * room / limits.jerk[linear_columns(machine)].min()))


def corner_speeds(
    ways: AxisWays, line: Floats, stop: Bools, room: Floats, off: Floats, limits: Limits, half: Floats
) -> Floats:
    """Most speed (n,) at the end of each move, by the filter's error and the limits behind it."""
    changes = Transitions.of(ways, stop, line)
    turn = np.linalg.norm(changes.kink * off, axis=1)
    with np.errstate(divide="ignore"):
        by_corner = 6.0 * room / (turn * half)
        # corners nearer to each other than the filter is long make a curve
        by_curve = np.sqrt(12.0 * room / (turn / changes.mean)) / half
    acceleration, jerk = limits.acceleration * half[:, None], limits.jerk * half[:, None]
    behind = least_ratio(np.minimum(acceleration, jerk * half[:, None]), changes.kink)
    jump = np.sqrt(least_ratio(jerk, changes.bend))
    speeds: Floats = np.minimum(np.minimum(by_corner, by_curve), np.minimum(behind, jump))
    return speeds

