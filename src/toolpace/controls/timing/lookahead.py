"""The model `lookahead`: a control of which a few figures are known.

Corners are rounded within a tolerance, as `kernels.controls.rounding` says; short blocks are joined; between the
corners the speed has the profile of all models, with limited jerk.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from toolpace.common.arrays import Floats
from toolpace.controls.timing.axis_motion import AxisWays, axis_ways
from toolpace.controls.timing.blocks import MotionProfile, cruise_speeds, profile_along, rests, room_of
from toolpace.controls.timing.chains import profile_along_chains
from toolpace.controls.timing.figures import ControlFigures, limits_of, off_the_path
from toolpace.programs.commanded import Commanded

if TYPE_CHECKING:
    from toolpace.machine.machine import Machine


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
