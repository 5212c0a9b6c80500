"""The model `fanuc`: AI contour control of a Fanuc 16i to 31i, by specifications A-63512EN and A-78962EN.

* Corners: the feed F / R, R the greatest ratio of an axis' difference of feed to 1783 (A-63512EN, 2.4).
* Arcs: v^2 / r within 1735 of each axis, not below 1732 (A-63512EN, 2.6; A-78962EN, 2.8).
* Lines that make a curve: each axis' difference of feed at a corner, over the longer one of the times of both blocks,
  within 1737 (A-78962EN, 2.7).
* Jerk control, an option: where a line meets an arc, or arcs meet, the change of each axis' acceleration is within
  1788; between lines, whose acceleration is that difference over time, within 1789 (A-78962EN, 2.9).
* Bell-shaped acceleration before interpolation, at a constant rate (A-78395E, 2.16): 1772.
* Acceleration after interpolation, of the time constant 1769, rounds what is left; each rest takes that longer.
* 40 blocks are read ahead (A-63512EN, 2.3), more where the figures say so.

There is no tolerance in these rules: how far corners are rounded follows from 1783 and 1769.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from toolpace.common.arrays import Bools, Floats
from toolpace.common.units import DEGREE, MILLIMETRE
from toolpace.controls.timing.axis_motion import Transitions, axis_ways, least_ratio
from toolpace.controls.timing.blocks import FEED, MotionProfile, cruise_speeds, profile_along, rest_ends, rests
from toolpace.controls.timing.figures import ControlFigures, limits_of
from toolpace.programs.commanded import Commanded

if TYPE_CHECKING:
    from toolpace.machine.limits import Limits
    from toolpace.machine.machine import Machine

READ_AHEAD = 40


def fanuc_profile(moves: Commanded, machine: Machine, figures: ControlFigures) -> MotionProfile:
    """Times of moves and speeds at their ends."""
    own, limits, stop = figures.fanuc, limits_of(machine, figures), rests(moves)
    ways = axis_ways(moves, machine, joints=figures.limits == "joints")
    free = cruise_speeds(moves, ways, limits.velocity, np.full_like(limits.acceleration, np.inf), figures.block_time)
    arcs = moves.sweep > 0.0
    curved = np.sqrt(least_ratio(own.arc_acceleration * limits.acceleration, ways.bend))
    feed = np.minimum(free, np.where(arcs, np.maximum(curved, own.arc_least_feed * FEED), curved))
    changes = Transitions.of(ways, stop, ways.length)
    corner = np.where(stop, 0.0, corner_speeds(changes, limits, machine.is_rotary, figures))
    acceleration = ways.along(limits.acceleration)
    jerk = acceleration / own.bell_time if own.bell_time else ways.along(limits.jerk)
    depth = READ_AHEAD if figures.look_ahead is None else figures.look_ahead
    found = profile_along(feed, ways.length, corner, acceleration, jerk, depth)
    return found._replace(times=found.times + own.after_interpolation * rest_ends(stop, ways.length))


def corner_speeds(changes: Transitions, limits: Limits, is_rotary: Bools, figures: ControlFigures) -> Floats:
    """Most speed (n,) at the end of each move, by differences of feed and by accelerations."""
    own = figures.fanuc
    units = np.where(is_rotary, DEGREE, MILLIMETRE)
    difference = np.where(is_rotary, own.corner_difference_rotary, own.corner_difference) * units / 60.0
    by_difference = least_ratio(np.where(difference > 0.0, difference, np.inf), changes.kink)
    # v D over the time L / v
    longer = changes.longer[:, None]
    by_acceleration = np.sqrt(least_ratio(own.curve_acceleration * limits.acceleration, changes.kink / longer))
    speeds = np.minimum(by_difference, by_acceleration)
    if not own.acceleration_change:
        return speeds
    change = own.acceleration_change * units
    between_lines = (own.acceleration_change_lines or own.acceleration_change) * units
    by_bend = np.sqrt(least_ratio(change, changes.bend))
    by_lines = np.sqrt(least_ratio(between_lines, changes.kink / longer))
    return np.minimum(speeds, np.where(changes.straight, by_lines, by_bend))
