"""The path in time of a follower, and the clock rate along it, changed only within the limits.

The path is a uniform cubic B-spline with its samples as control points. Each derivative of such a spline is a mean of
the differences of the samples, and these are means of the derivative sampled: so it passes no limit that the motion
keeps, at any time. It leaves the samples by a sixth of their second difference (Schoenberg 1946; de Boor, A Practical
Guide to Splines, chapter IX).

With the pace p = d tau / dt a joint has, of its path's derivatives by tau,

    velocity       q' p
    acceleration   q'' p^2 + q' dp/dt
    jerk           q''' p^3 + 3 q'' p dp/dt + q' d2p/dt2

so that a steady pace of at most 1 keeps what the path keeps. A change of pace is looked through over all of the path
that it passes before it is begun, and it ends at a steady pace of at most 1: what is committed to can always be gone
through with, whatever comes. The path comes out of rest: until it has moved its pace is the one that is wanted.
"""

from __future__ import annotations

import math

from toolpace.kernels.arrays import Floats
from toolpace.kernels.follow.layout import (
    BEND,
    CANDIDATE,
    CELL,
    CELL_COLUMNS,
    CELLS,
    CHANGE,
    COLUMNS,
    COMMITTED,
    DURATION,
    FINAL,
    FROM,
    GOAL,
    JOINTS,
    LONGER,
    PACE,
    PATH,
    PERIOD,
    ROOM,
    SAMPLES,
    SEGMENTS,
    STEP,
    TAU,
    TOOL_COLUMNS,
    TOOLS,
    WAY,
)
from toolpace.kernels.jit import jit

WAYS = 13
"""Ways of changing the pace, from quick to slow."""
ABOVE, BELOW = 3, 4
"""Goals that ways are tried with: above a pace of 1, and on the way up to 1 or less; each half as far as the last."""
QUICKEST, SLOWER = 400.0, 0.44
"""Second derivative of the pace of the first way [1/s^2], and what each next one has of it."""
LOOK, LOOKS = 4e-3, 50.0
"""Least time between two looks at what a change of pace passes [s], and most looks a segment: in between, all that is
largest counts."""
DIP = 0.01
"""How far the pace may fall below where it comes from and goes to."""
SAME = 1e-9
"""Paces that count as one."""

Ramp = tuple[float, float, float, float, float]
"""Sign of the first jerk; times of jerk, of none, and of jerk against it [s]; the way [m]."""


@jit()
def place_on_path(piece: Floats, tau: float, column: int, out: Floats) -> None:
    """Value and three derivatives by the time of the path (4,) of one column at a time [s]."""
    h = piece[STEP]
    last = int(piece[SAMPLES]) - 1
    x = min(max(tau / h, 0.0), float(last))
    i = min(int(x), last - 1)
    u = x - i
    at = PATH + i * COLUMNS + column
    a, b, c, d = piece[at], piece[at + COLUMNS], piece[at + 2 * COLUMNS], piece[at + 3 * COLUMNS]
    first = ((b - a), (c - b), (d - c))
    second = (first[1] - first[0], first[2] - first[1])
    w = 1.0 - u
    # about the control point that is nearest, so that no digits are lost
    out[0] = (
        b
        + (w * w * w * (a - b) + (1.0 + 3.0 * u + 3.0 * u * u - 3.0 * u * u * u) * (c - b) + u * u * u * (d - b)) / 6.0
    )
    out[1] = (0.5 * w * w * first[0] + (0.5 + u - u * u) * first[1] + 0.5 * u * u * first[2]) / h
    out[2] = (w * second[0] + u * second[1]) / (h * h)
    out[3] = (second[1] - second[0]) / (h * h * h)


@jit()
def cell_at(piece: Floats, tau: float) -> int:
    """First place in the piece of the cell that a time of the path lies in."""
    count = int(piece[CELLS])
    k = min(max(int(tau / piece[CELL]), 0), count - 1)
    return PATH + (int(piece[SAMPLES]) + 3) * COLUMNS + k * CELL_COLUMNS


@jit()
def longer_at(piece: Floats, tau: float) -> float:
    """By how much the tool in the spindle at a time of the path is longer than that of the machine file [m]."""
    table = PATH + (int(piece[SAMPLES]) + 3) * COLUMNS + int(piece[CELLS]) * CELL_COLUMNS
    low, high = 0, int(piece[TOOLS])
    while high - low > 1:
        middle = (low + high) // 2
        if piece[table + middle * TOOL_COLUMNS + FROM] <= tau:
            low = middle
        else:
            high = middle
    longer: float = piece[table + low * TOOL_COLUMNS + LONGER]
    return longer


@jit(inline=True)
def ramp(v0: float, a0: float, v1: float, most: float, jerk: float) -> Ramp:
    """The quickest change from velocity v0 and acceleration a0 to v1 and none; `most` is the limit of acceleration."""
    left = v1 - (v0 + 0.5 * a0 * abs(a0) / jerk)
    sign = 1.0 if left > 0.0 or (left == 0.0 and a0 < 0.0) else -1.0
    peak = math.sqrt(max(sign * jerk * (v1 - v0) + 0.5 * a0 * a0, 0.0))
    even = 0.0
    if peak > most:
        even = (sign * (v1 - v0) - (most * most - 0.5 * a0 * a0) / jerk) / most
        peak = most
    first = max((peak - sign * a0) / jerk, 0.0)
    last = peak / jerk
    even = max(even, 0.0)
    x, v, a = moved(0.0, v0, a0, sign * jerk, first)
    x, v, a = moved(x, v, a, 0.0, even)
    x, v, a = moved(x, v, a, -sign * jerk, last)
    return sign, first, even, last, x


@jit(inline=True)
def moved(x: float, v: float, a: float, jerk: float, t: float) -> tuple[float, float, float]:
    """Position, velocity and acceleration after a time t of constant jerk."""
    return x + t * (v + t * (0.5 * a + t * jerk / 6.0)), v + t * (a + 0.5 * t * jerk), a + t * jerk


@jit()
def change_of_pace(begin: float, change: float, end: float, bend: float, out: Floats, at: int) -> None:
    """Write three segments (duration, second derivative) from a pace and its change to another pace and none.

    bend: most second derivative; the change is at most the root of a quarter of it, so that it counts as little.
    """
    steep = max(0.5 * math.sqrt(bend), abs(change))
    sign, first, even, last, _ = ramp(begin, change, end, steep, bend)
    out[at], out[at + 1] = first, sign * bend
    out[at + 2], out[at + 3] = even, 0.0
    out[at + 4], out[at + 5] = last, -sign * bend


@jit()
def fits(piece: Floats, state: Floats, least: float) -> bool:
    """Whether all limits hold along the candidate from here on, with all that lies between two looks at its largest,
    and the pace nowhere falls below the least."""
    cells, length, end = int(piece[CELLS]), piece[CELL], piece[DURATION]
    table = PATH + (int(piece[SAMPLES]) + 3) * COLUMNS
    tau, pace, change = state[TAU], state[PACE], state[CHANGE]
    for k in range(SEGMENTS):
        left, bend = state[CANDIDATE + 2 * k], state[CANDIDATE + 2 * k + 1]
        look = max(LOOK, left / LOOKS)
        while left > 0.0:
            t = min(left, look)
            left -= t
            after = change + t * bend
            later = pace + t * (change + 0.5 * t * bend)
            most, lowest, steep = max(pace, later), min(pace, later), max(abs(change), abs(after))
            if change > 0.0 and after < 0.0:
                most = pace - 0.5 * change * change / bend
            elif change < 0.0 and after > 0.0:
                lowest = pace - 0.5 * change * change / bend
            if lowest < least:
                return False
            to = tau + t * (pace + t * (0.5 * change + t * bend / 6.0))
            if tau < end:
                first, last = int(max(tau, 0.0) / length), min(int(to / length), cells - 1)
                for cell in range(min(first, cells - 1), last + 1):
                    if not cell_allows(piece, table + cell * CELL_COLUMNS, most, steep, abs(bend)):
                        return False
            tau, pace, change = to, later, after
    return True


@jit(inline=True)
def cell_allows(piece: Floats, at: int, pace: float, steep: float, bend: float) -> bool:
    """Whether a cell of the path allows a pace with such derivatives, all at their largest at once."""
    for j in range(JOINTS):
        v, a, jerk = piece[at + j], piece[at + JOINTS + j], piece[at + 2 * JOINTS + j]
        if v * pace > piece[ROOM + j]:
            return False
        if a * pace * pace + v * steep > piece[ROOM + JOINTS + j]:
            return False
        if (jerk * pace * pace + 3.0 * a * steep) * pace + v * bend > piece[ROOM + 2 * JOINTS + j]:
            return False
    return True


@jit()
def lay_out(state: Floats, goal: float, way: int, period: float) -> float:
    """Write the candidate that goes to a goal by one of the ways; returns the time until it is there [s].

    A goal above 1 is kept for two periods, and then left for 1: the next step lays that end further ahead.
    """
    bend = QUICKEST * SLOWER**way
    change_of_pace(state[PACE], state[CHANGE], goal, bend, state, CANDIDATE)
    for k in range(6, 2 * SEGMENTS):
        state[CANDIDATE + k] = 0.0
    if goal > 1.0:
        state[CANDIDATE + 6] = 2.0 * period
        change_of_pace(goal, 0.0, 1.0, bend, state, CANDIDATE + 8)
    time: float = state[CANDIDATE] + state[CANDIDATE + 2] + state[CANDIDATE + 4]
    return time


@jit(inline=True)
def begin(state: Floats, wanted: float) -> None:
    """At the start of the path, where it is at rest, any steady pace that the path itself allows may be begun with."""
    if state[TAU] == 0.0:
        state[PACE] = state[GOAL] = state[FINAL] = min(wanted, 1.0)
        state[CHANGE] = state[BEND] = 0.0
        for k in range(2 * SEGMENTS):
            state[COMMITTED + k] = 0.0


@jit()
def commit(piece: Floats, state: Floats, wanted: float) -> None:
    """Commit to a change towards the pace that is wanted, if the way that is next in turn fits.

    Where no way goes all along to a higher pace, one goes a part of it: a path that is at its limits lets no pace rise
    to what it is planned for, but all the more to a lower one, and so the tool never stands for good.
    """
    done = abs(state[PACE] - wanted) <= SAME and abs(state[CHANGE]) <= SAME
    if done and state[GOAL] == wanted and wanted <= 1.0:
        return
    period = piece[PERIOD]
    # the ways are gone through in turn whatever is wanted meanwhile: noise in it keeps none from being tried
    index = int(state[WAY])
    if index >= goals(state[PACE], wanted) * WAYS:
        index = 0
    goal = goal_in_turn(state[PACE], wanted, index // WAYS)
    time = lay_out(state, goal, index % WAYS, period)
    left = state[COMMITTED] + state[COMMITTED + 2] + state[COMMITTED + 4]
    nearer = abs(goal - wanted) < abs(state[FINAL] - wanted) - SAME
    sooner = goal == wanted and (state[GOAL] != wanted or time < left - 0.5 * period)
    # a change that has to be turned round first is not to dip
    if (goal > 1.0 or nearer or sooner) and fits(piece, state, max(min(goal, state[PACE]) - DIP, 0.0) - SAME):
        for k in range(2 * SEGMENTS):
            state[COMMITTED + k] = state[CANDIDATE + k]
        state[GOAL], state[FINAL] = wanted, min(goal, 1.0)
    else:
        index += 1
    state[WAY] = float(index)


@jit(inline=True)
def goals(pace: float, wanted: float) -> int:
    """How many goals there are between a pace and the one that is wanted."""
    count = ABOVE if wanted > 1.0 else 0
    if pace < min(wanted, 1.0):
        count += BELOW
    return max(count, 1)


@jit(inline=True)
def goal_in_turn(pace: float, wanted: float, turn: int) -> float:
    """One of these goals: the one that is wanted first."""
    if wanted > 1.0:
        if turn < ABOVE:
            return 1.0 + (wanted - 1.0) * 0.5**turn
        turn -= ABOVE
    end = min(wanted, 1.0)
    return end if turn == 0 else pace + (end - pace) * 0.5**turn


@jit()
def keep_pace(piece: Floats, state: Floats) -> None:
    """Go on for one period as committed: time of the path, pace and its derivatives."""
    left = piece[PERIOD]
    state[BEND] = 0.0
    for k in range(SEGMENTS):
        at = COMMITTED + 2 * k
        t = min(state[at], left)
        if t <= 0.0:
            continue
        bend = state[at + 1]
        state[TAU] += t * (state[PACE] + t * (0.5 * state[CHANGE] + t * bend / 6.0))
        state[PACE] += t * (state[CHANGE] + 0.5 * t * bend)
        state[CHANGE] += t * bend
        state[at] -= t
        left -= t
        state[BEND] = bend
        if left <= 0.0:
            return
    # all is gone through: a steady pace, without what rounding has left
    state[PACE], state[CHANGE], state[BEND] = state[FINAL], 0.0, 0.0
    state[TAU] += left * state[PACE]
