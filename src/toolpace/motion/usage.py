"""Joint motion from a path and states (s, ds/dt, ...) on it, and its utilisation of the limits.

Along a time law it is sampled adaptively, where states at even steps tell too little.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from toolpace.common.arrays import Bools, Floats
from toolpace.common.value_objects import ByValue, one_line
from toolpace.machine.limits import KINDS, Limits
from toolpace.motion.laws import Probe, TimeLaw
from toolpace.path.axis_run import AxisRun

LEAST_JUMP = 1e-6
"""Jump of an acceleration, as a share of its limit, below which it is rounding."""
CHUNK = 100_000
"""Jumps that are worked out at once, to keep memory low."""
IN_A_STRETCH = np.arange(0.5, 8.0) / 8.0
"""Where it is looked at between two hints of a run, as shares of the stretch."""
UNTOLD_SHARE = 1e-3
"""Share of a limit that the path may ask for between two states beyond what both tell."""
LEAST_CHANGES = (1e-12, 1e-9, 1e-6)
"""Changes of position, velocity and acceleration that are let pass between two places, as shares of what a joint gains
while its acceleration builds up at the jerk limit: a^3 / j^2, a^2 / j, a. Numbers hold no path together better."""
SHORTEST = 1e-12
"""Gap that is not halved any more, as a share of the run."""
MOST_PLACES = 20_000
"""Places between the states of a probe after which no more are looked at: noise is not chased for ever."""
HIGHER = 1e-5
"""Height of a top over the highest of three states from which it is looked at, and not only reckoned."""
TOPS = np.linspace(0.0, 1.0, 10)[1:-1]


@dataclass(frozen=True, eq=False, repr=False)
class Motion(ByValue):
    """Joint positions and three time derivatives [m or rad, s]: (joints,) at one time, (n, joints) at n times."""

    q: Floats
    """Positions."""
    qd: Floats
    """Velocities."""
    qdd: Floats
    """Accelerations."""
    qddd: Floats
    """Jerks."""

    def __repr__(self) -> str:
        times = "one time" if self.q.ndim == 1 else f"{len(self.q)} times"
        return one_line(self, f"of {self.q.shape[-1]} joints at {times}")


def joint_motion(path: Floats, state: Floats) -> Motion:
    """The chain rule: path derivatives (4, n, joints) and a state (4, n) of s give the motion of the joints."""
    motion = Motion(*(np.empty(path.shape[1:]) for _ in range(4)))
    put_joint_motion(path, state, motion, slice(None))
    return motion


def put_joint_motion(path: Floats, state: Floats, motion: Motion, rows: slice | Bools) -> None:
    """The same, put into some rows of a motion."""
    q, q1, q2, q3 = path
    v, a, j = (state[i][:, None] for i in (1, 2, 3))
    motion.q[rows] = q
    motion.qd[rows] = q1 * v
    motion.qdd[rows] = q2 * v**2 + q1 * a
    motion.qddd[rows] = q3 * v**3 + 3.0 * q2 * v * a + q1 * j


@dataclass(frozen=True, eq=False, repr=False)
class Usage(ByValue):
    """Peak value over limit, over continuous time: of the feed cap, and by joint of each limit.

    The jerk of a joint whose acceleration jumps is infinite.
    """

    feed: float
    velocity: dict[str, float]
    acceleration: dict[str, float]
    jerk: dict[str, float]
    rows: dict[str, float] = field(default_factory=dict)
    """Of rows of one's own, by name."""

    @property
    def worst(self) -> float:
        """The largest of all."""
        joints = *self.velocity.values(), *self.acceleration.values(), *self.jerk.values()
        return max(self.feed, *joints, *self.rows.values())

    def __repr__(self) -> str:
        peaks = [f"{kind} {max(getattr(self, kind).values(), default=0.0):.6g}" for kind in KINDS]
        return one_line(self, f"of feed {self.feed:.6g}", *peaks)


def limit_ratios(run: AxisRun, limits: Limits, state: Floats, right: Floats) -> Floats:
    """(n, k) value over limit, in the order of `Limits.names`.

    `right` (n,) is 0 where the state belongs to the left side of a break.
    """
    return ratios_along(run, limits, state, right)[0]


def ratios_along(run: AxisRun, limits: Limits, state: Floats, right: Floats) -> tuple[Floats, Floats]:
    """The same, and the path (4, n, m) there."""
    s = np.clip(np.where(right > 0.0, state[0], np.nextafter(state[0], -np.inf)), run.s0, run.s1)
    path, cap = run.with_cap(s)
    path = np.ascontiguousarray(path)
    return ratios_of(path, cap, limits, state), path


def ratios_of(path: Floats, cap: Floats, limits: Limits, state: Floats) -> Floats:
    """The same from the path (4, n, m) and the cap (n,) on ds/dt there."""
    from toolpace.kernels.motion import usage

    ratio: Floats = usage.ratios(path, state, cap, limits.velocity, limits.acceleration, limits.jerk)
    if limits.rows:
        return np.column_stack([ratio, *(rows.ratio(path, state) for rows in limits.rows)])
    return ratio


def jerk_jumps(run: AxisRun, limits: Limits, law: TimeLaw) -> npt.NDArray[np.bool_]:
    """(m,) joints with a jerk limit whose acceleration jumps, so that no number bounds their jerk."""
    s, jump = law.jumps
    noise = np.where(np.isfinite(limits.acceleration), LEAST_JUMP * limits.acceleration, 0.0)
    marks = np.zeros(len(limits), dtype=np.bool_)
    for i in range(0, len(s), CHUNK):
        size = np.abs(run.evaluate(s[i : i + CHUNK])[1]) * jump[i : i + CHUNK, None]
        marks |= (size > noise).any(axis=0)
    return marks & np.isfinite(limits.jerk)


def closer_look(run: AxisRun, limits: Limits, law: TimeLaw, probe: Probe) -> tuple[Floats, Floats, Floats]:
    """Value over limit at the states of a probe (n, k), and at places between (k,) where these tell too little.

    Places are added in stretches between two hints of the run that have too few states; where the path does not go on
    between two states as its derivatives say (kernels/motion/between_nodes.py), until what is there is resolved;
    and beside tops between three states.
    """
    ratio, path = ratios_along(run, limits, probe.state, probe.right)
    s, speed = probe.state[0], probe.state[1]
    extra: list[tuple[Floats, Floats]] = []

    def look(places: Floats) -> tuple[Floats, Floats]:
        state = law.states_at(places)
        state[0] = places
        found, there = ratios_along(run, limits, state, np.ones(len(places)))
        extra.append((places, found))
        return there, state[1]

    between = stretches_unseen(run, s)
    if len(between):
        there, swift = look(between)
        s, speed, path = np.append(s, between), np.append(speed, swift), np.concatenate([path, there], axis=1)
        order = np.argsort(s, kind="stable")
        s, speed, path = s[order], speed[order], np.ascontiguousarray(path[:, order])
    of_low, of_high = (np.ascontiguousarray(part) for part in (path[:, :-1], path[:, 1:]))
    unexplained(run, limits, s[:-1], s[1:], of_low, of_high, np.maximum(speed[:-1], speed[1:]), look)
    beside_tops(probe.state[0], ratio, np.True_, look)
    if not extra:
        return ratio, np.empty(0), np.empty((0, ratio.shape[1]))
    return ratio, np.concatenate([places for places, _ in extra]), np.concatenate([found for _, found in extra])


def beside_tops(
    s: Floats, ratio: Floats, meant: Bools | np.bool_, look: Callable[[Floats], tuple[Floats, Floats]]
) -> None:
    """Look beside tops between three of the places s (n,) with these values over limits, in the stretches (n - 1,) that
    are `meant`."""
    from toolpace.kernels.motion import usage

    beside = usage.summits(s, ratio, HIGHER) & meant
    if beside.any():
        low, high = s[:-1][beside], s[1:][beside]
        look(np.unique(low[:, None] + (high - low)[:, None] * TOPS))


def gained_in_a_ramp(limits: Limits) -> Floats:
    """(3, m) position, velocity and acceleration that a joint gains while its acceleration builds up at the jerk limit.

    Zero where there are no such limits.
    """
    a, j = limits.acceleration, limits.jerk
    with np.errstate(all="ignore"):
        ramps = np.stack([a**3 / j**2, a**2 / j, a])
    gained: Floats = np.where(np.isfinite(ramps), ramps, 0.0)
    return gained


def least_changes(limits: Limits) -> Floats:
    """(3, m) changes of position, velocity and acceleration that nobody would notice: see LEAST_CHANGES."""
    changes: Floats = gained_in_a_ramp(limits) * np.array(LEAST_CHANGES)[:, None]
    return changes


def stretches_unseen(run: AxisRun, s: Floats) -> Floats:
    """(k,) places in the stretches between hints, and between breaks that are none of the places, that have too few of
    the places s (n,) in order; and both sides of such breaks."""
    hints, breaks = (each[(each > s[0]) & (each < s[-1])] for each in (run.hints, run.breaks))
    breaks = breaks[s[np.searchsorted(s, breaks)] != breaks]
    if not len(hints) and not len(breaks):
        return np.empty(0)
    ends = np.concatenate([[s[0]], np.union1d(hints, breaks), [s[-1]]])
    sparse = (np.diff(np.searchsorted(s, ends)) < len(IN_A_STRETCH)) & (np.diff(ends) > 0.0)
    places: Floats = (ends[:-1][sparse, None] + np.diff(ends)[sparse, None] * IN_A_STRETCH).ravel()
    return np.concatenate([places, np.nextafter(breaks, -np.inf), breaks])


def unexplained(
    run: AxisRun,
    limits: Limits,
    low: Floats,
    high: Floats,
    of_low: Floats,
    of_high: Floats,
    swift: Floats,
    look: Callable[[Floats], tuple[Floats, Floats]],
) -> None:
    """Look between places `low` and `high` (n,) where the path does more than it tells at both (4, n, m).

    `swift` (n,) is ds/dt there; `look` takes places, and returns the path and ds/dt at them.
    """
    from toolpace.kernels.motion import between_nodes

    bounds, least = (limits.velocity, limits.acceleration, limits.jerk), least_changes(limits)
    length = high - low
    missed = between_nodes.increment_errors(of_low, of_high, low, length, swift, least)
    asked = between_nodes.error_utilisation(missed, length, swift, *bounds)
    go = between_nodes.outliers(missed, length) | (asked > UNTOLD_SHARE)
    shortest, count = SHORTEST * (run.s1 - run.s0), 0
    while go.any() and count < MOST_PLACES:
        low, high, swift, missed = low[go], high[go], swift[go], missed[go]
        of_low, of_high = (np.ascontiguousarray(part[:, go]) for part in (of_low, of_high))
        middle = np.clip(0.5 * (low + high), low, high)
        order = np.argsort(middle, kind="stable")
        of_middle, fast = (np.empty_like(of_low), np.empty_like(low))
        of_middle[:, order], fast[order] = look(middle[order])
        count += len(middle)
        left = between_nodes.increment_errors(of_low, of_middle, low, middle - low, swift, least)
        right = between_nodes.increment_errors(of_middle, of_high, middle, high - middle, swift, least)
        stays, is_right = between_nodes.worse_half(missed, left, right)
        stays = np.concatenate([stays & ~is_right, stays & is_right])
        low, high = np.concatenate([low, middle]), np.concatenate([middle, high])
        of_low, of_high = np.concatenate([of_low, of_middle], axis=1), np.concatenate([of_middle, of_high], axis=1)
        swift = np.maximum(np.tile(swift, 2), np.tile(fast, 2))
        missed, length = np.concatenate([left, right]), high - low
        asked = between_nodes.error_utilisation(missed, length, swift, *bounds)
        go = (stays | (asked > UNTOLD_SHARE)) & (length > shortest)
