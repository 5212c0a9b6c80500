"""The model `sinumerik`: Siemens Sinumerik 840D, 828D, One, by its Function Manual Basic Functions (B1, B2).

* SOFT: jerk along the path is limited by each axis' share of it (B2, acceleration with jerk limitation: seven phases);
  BRISK and DRIVE: it is not. DRIVE's knee is taken to be off, as with MD35220 = 1 (B2, 2.18). Rapids: MD32434,
  MD32435 (B2, 2.15 and 12.2.15).
* Corners with a tolerance (G64x, CYCLE832): the change of velocity is spread over a rounding within the tolerance, as
  `kernels.controls.rounding` says.
* Corners without one: the velocity of an axis may jump by a (overload - 1) cycle (B1, overload factor, MD32310). A
  rounding is made only where the speed would be lower without it (B1, no intermediate rounding blocks).
* Jump of curvature: with jerk limitation the acceleration a_j across the path cannot jump (B2, 12.2.16). Spread over
  the time a_j / J it leaves the path by a_j^3 / (24 J^2): that stays within the tolerance, and J is MD32432
  (assumption: the manual says that it slows down, and gives no formula). Without a tolerance a_j is J times the cycle.
* DYNFINISH, DYNSEMIFIN, DYNROUGH, DYNPREC, DYNPOS, and the modes of CYCLE832, choose among values of the jerk MD32431.
* Curves: MD20602 shares the acceleration between the directions across and along the path.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from toolpace.common.arrays import Bools, Floats
from toolpace.controls.timing.axis_motion import AxisWays, Transitions, axis_ways, least_ratio
from toolpace.controls.timing.blocks import (
    MotionProfile,
    cruise_speeds,
    profile_along,
    profile_along_chains,
    rests,
    room_of,
)
from toolpace.controls.timing.figures import ControlFigures, limits_of, off_the_path
from toolpace.programs.commanded import Commanded

if TYPE_CHECKING:
    from toolpace.machine.limits import Limits
    from toolpace.machine.machine import Machine

FINISH, SEMIFINISH, ROUGH, PRECISE, POSITION = 1.0, 2.0, 3.0, 4.0, 5.0
"""Sets of limits, as `Commanded.dynamics` has them."""
DEVIATION = 24.0
"""Of the deviation a^3 / (24 J^2): a step of acceleration a that is spread over the time a / J."""


def sinumerik_profile(moves: Commanded, machine: Machine, figures: ControlFigures) -> MotionProfile:
    """Times of moves and speeds at their ends."""
    own, limits, stop = figures.sinumerik, limits_of(machine, figures), rests(moves)
    off = off_the_path(moves, machine, figures)
    brisk = brisk_moves(moves, figures)
    acceleration = np.where(brisk, 1.0, own.soft_acceleration) * np.where(moves.rapid, own.rapid_acceleration, 1.0)
    jerk = np.where(brisk, np.inf, np.where(moves.rapid, own.rapid_jerk, 1.0))
    shares = {
        FINISH: own.jerk_finish, SEMIFINISH: own.jerk_semifinish, ROUGH: own.jerk_rough, PRECISE: own.jerk_precise,
        POSITION: own.jerk_position,
    }  # fmt: skip
    for mode, share in shares.items():
        jerk = np.where(moves.dynamics[:, 2] == mode, share * jerk, jerk)
    across = own.curve_share or 1.0

    def driven(ways: AxisWays, line: Floats) -> MotionProfile:
        feed = cruise_speeds(moves, ways, limits.velocity, across * limits.acceleration, figures.block_time)
        corner = corner_speeds(moves, ways, feed, line, stop, limits, figures, off, brisk)
        along = np.where(ways.bend.max(axis=1, initial=0.0) > 0.0, 1.0 - own.curve_share, 1.0)
        along_path = acceleration * along * ways.along(limits.acceleration)
        return profile_along(
            feed, ways.length, corner, along_path, jerk * ways.along(limits.jerk), figures.look_ahead or 0
        )

    ways = axis_ways(moves, machine, joints=figures.limits == "joints")
    return profile_along_chains(moves, ways, stop, figures, off, driven)


def brisk_moves(moves: Commanded, figures: ControlFigures) -> Bools:
    """(n,) whether BRISK is in force: by the program's word, else by the figures."""
    word = moves.dynamics[:, 0]
    return np.where(np.isnan(word), figures.sinumerik.brisk, word) > 0.0


def tolerances(moves: Commanded, figures: ControlFigures) -> Floats:
    """(n,) of roundings [m]; 0 where the program says that there are none (G64)."""
    room: Floats = np.where(moves.dynamics[:, 1] == 0.0, 0.0, room_of(moves, figures))
    return room


def corner_speeds(
    moves: Commanded, ways: AxisWays, feed: Floats, line: Floats, stop: Bools, limits: Limits,
    figures: ControlFigures, off: Floats, brisk: Bools,
) -> Floats:  # fmt: skip
    """Most speed (n,) at the end of each move; 0 at rest."""
    from toolpace.kernels.controls.rounding import rounded_speeds

    own, room = figures.sinumerik, tolerances(moves, figures)
    jump = limits.acceleration * (own.overload - 1.0) * own.cycle
    changes = Transitions.of(ways, stop, line)
    rounded = rounded_speeds(feed, line, ways.first, ways.last, stop, room, limits.acceleration, limits.jerk, off)
    # jumps of a curve in short blocks are its acceleration
    steady = np.sqrt(least_ratio(limits.acceleration, changes.kink / changes.mean[:, None]))
    corner = np.maximum(rounded, np.minimum(least_ratio(jump, changes.kink), steady))
    jerk = own.transition_jerk * limits.jerk
    # an axis' own unit of length: of the tip where it is linear
    spread = np.cbrt(DEVIATION * jerk**2 * room[:, None] / np.where(off > 0.0, off, 1.0))
    curved = np.sqrt(least_ratio(np.maximum(spread, jerk * own.cycle), changes.bend))
    return np.where(stop, 0.0, np.where(brisk, corner, np.minimum(corner, curved)))
