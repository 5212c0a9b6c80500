"""The layout of the flat arrays of a follower: piece, state, input and output.

All are float64 and little-endian, so that control code in any language can hold them. The piece is made once and never
changes: a head, tables, the path, the cells and the tools. The state is what a step reads and writes; a fresh one is
zeros.
"""

from __future__ import annotations

MAGIC, VERSION = 1953525106.0, 4.0
"""First two figures of every piece."""
JOINTS = 5

# head of the piece
(
    IS_PIECE, HAS_VERSION, SAMPLES, STEP, CELLS, CELL, DURATION, PERIOD, DELAY, GAIN, MOST, MOST_TURN, DEADBAND, FILTER,
    HOLD, FADE, PATIENCE, BELIEVABLE, CAUSE, FEED_SHARE, TIP_PER_LINEAR, LEVER, NOMINAL, WAIT, AXIS_TOLERANCE,
    RHO, CHECKSUM, TOOLS, DEAD_TIME, USED,
) = range(30)  # fmt: skip
"""Counts and times [s] of samples and cells, then the figures of a follower in SI units; FEED_SHARE: of the feed,
 for each joint's correction; TIP_PER_LINEAR, LEVER: most motion of the tip for one of a linear and a rotary joint;
NOMINAL: pace of the plan at which it was sampled; MOST_TURN: 0 where measured axes do not count; CHECKSUM: of a file,
CRC-32 of all its bytes with zeros for this figure, and 0 elsewhere; TOOLS: rows of the table of tools; DEAD_TIME: of a
sensor whose measurements bear no time, for who gives them one; USED: joints that there are, the others of the five
stand and have no limits."""
HEAD = 32
BENDING, DISPLACED = 0.0, 1.0
"""What CAUSE can be."""

# tables of the piece, by their first places
FRAME = HEAD
"""(9, 3) of kinematics.chain, with the tool of the machine file."""
GROUP = FRAME + 27
PLACE = GROUP + 3
COMPLIANCE = PLACE + 5
"""(3, 3) [m/N] in the frame of the tool."""
SHARE = COMPLIANCE + 9
"""(3, 5) most velocity, acceleration and jerk of the correction, a row a kind."""
ROOM = SHARE + 3 * JOINTS
"""(3, 5) most of each for path and pace together."""
LOW = ROOM + 3 * JOINTS
"""(2, 5) least and most correction."""
PATH = LOW + 2 * JOINTS
"""(SAMPLES + 3, 6) control points of a uniform cubic B-spline: joints, and the parameter of the path."""
COLUMNS = JOINTS + 1
FEED, FEED_SOON, TURNING_SOON = 3 * JOINTS, 3 * JOINTS + 1, 3 * JOINTS + 2
CELL_COLUMNS = 3 * JOINTS + 3
"""A cell: peaks of |velocity|, |acceleration| and |jerk| of each joint (3, 5); least feed [m/s],
and least from here until a correction has been slowed down; most that the workpiece turns over the feed, as far ahead
[1/m]."""
FROM, LONGER = 0, 1
TOOL_COLUMNS = 2
"""Behind the cells, a row for each stretch of the path with one tool: time of the path from which on it is in the
spindle [s], ascending, and by how much it is longer than that of the machine file [m]."""

# what goes in, nan where there is none
MEASURED_AT, TIP, AXIS, FORCE, DEFLECTION, OVERRIDE = 0, 1, 4, 7, 10, 13
INPUTS = 14

# state
(
    NOW, STEPS, TAU, PACE, CHANGE, BEND, GOAL, FINAL, WAY, MEASURED, LAST_MEASURED, LAST_JUMP, FULL, FULL_FOR,
    STOPPED, NEEDED, TAKEN_OFF, LAST_AXIS, LAST_COUNTED,
) = range(19)  # fmt: skip
"""Time [s] and number of the set-point that was given last; time of the path, pace and its two derivatives; the pace
committed to and the one that it ends with; which way of changing it is tried; whether anything was
measured and when; when the joints were last found displaced; whether the correction is at its limit and for how long
[s]; whether that has stopped the tool; share of the pace that a correction needed of late, and what is taken off it;
when an axis, and anything, was last given that counts."""
SEGMENTS = 7
COMMITTED = 19
"""(7, 2) duration [s] and second derivative of the pace [1/s^2] of what is committed to."""
CANDIDATE = COMMITTED + 2 * SEGMENTS
"""The same of what is looked at."""
CORRECTION = CANDIDATE + 2 * SEGMENTS
"""(5, 4) correction and its three derivatives, a row a joint."""
AIM = CORRECTION + 4 * JOINTS
"""(5,) where the correction shall go."""
SMOOTHED = AIM + JOINTS
"""(5,) where it should be by the last measurement, after the filter."""
SHOWN = SMOOTHED + JOINTS
"""(5,) correction of the set-point that the last measurement showed."""
SCRATCH = SHOWN + JOINTS
"""Joints (5,), tip and axis (3,), columns and inverse (3, 3) of the pose that was measured, and (4,) of a column."""
WITH_TOOL = SCRATCH + 36
"""(9, 3) of kinematics.chain with the tool that was measured."""
HISTORY = WITH_TOOL + 27
LOOK_BACK = 512
"""Set-points that are remembered."""
MEMORY = 1 + JOINTS
"""Of each: time of the path, correction."""
STATE = HISTORY + LOOK_BACK * MEMORY

# what comes out
STATUS, AT, PATH_TIME, PARAMETER, OUT_PACE = range(5)
Q = 5
"""(4, 5) joints and three derivatives; then (4, 5) what the correction has of each."""
OUT_CORRECTION = Q + 4 * JOINTS
OUTPUTS = OUT_CORRECTION + 4 * JOINTS

# status: sum of these
(
    ENDED, HELD, STALE, FADED, AT_LIMIT, STOPPING, NOT_A_NUMBER, LATE, ABSURD, JUMPED, SLOWED, OVERRIDE_CUT,
) = (1 << k for k in range(12))  # fmt: skip
