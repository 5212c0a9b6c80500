"""Joint splines of given duration, from the measured state to the motion that is rejoined.

late      by how much the rest of the motion comes later: the time taken, less what the commanded law takes
lead      where the end's motion is known exactly; from there its state goes on in a straight line with `late`

The splines are cubic, in the coefficients c_0 to c_N+2; c_k has its say about the mean of t_k-2, t_k-1 and t_k.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property, lru_cache

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.deflection.feed import fastest_braking, feed_at, tip_rates
from toolpace.deflection.rejoin_motion import CommandedMotion, Detour, with_constant_jerk
from toolpace.kernels.planners.interior_point import least
from toolpace.kernels.planners.joint_spline_barrier import Rows, most_used
from toolpace.machine.limits import KINDS, Limits
from toolpace.machine.machine import Machine

AHEAD, TABLE = 4.0, 160
"""How far a table of the motion goes on, over the first guess of a detour's time, and its length."""
START_WIDER = 1.1
"""How far a start lies within the limits that it is given at first."""
ENOUGH = 0.98
"""Share of the limits from which a way within them is good enough to go on with."""
FIRST = (0.125, 0.125, 0.25, 0.5)
"""Lengths of the first steps, over that of the others."""
PIECES, FINER = 18, 48
"""Steps of constant jerk: more where these find no way, or a long one. A motion at its limits leaves no room but for
one whose jerk changes just when its own does."""


@dataclass(frozen=True, eq=False)
class Problem:
    """A state in motion, the motion that shall be rejoined, and the limits between."""

    commanded: CommandedMotion
    left: float
    """On the clock of the commanded law [s]."""
    start: Floats
    """(3, m) positions, velocities and accelerations found."""
    limits: Limits
    machine: Machine | None
    pieces: int = PIECES
    """Steps of the splines."""
    travel: Floats = field(init=False)
    """(m, 2)"""

    def __post_init__(self) -> None:
        m = self.start.shape[1]
        open_ended = np.tile([-np.inf, np.inf], (m, 1))
        object.__setattr__(self, "travel", open_ended if self.machine is None else self.machine.travel)

    def near_end(self, period: float, late: float) -> Floats:
        """The same from a table, nearly: enough to see how long a way takes."""
        times, motions = self._table
        t = self.left + period - late
        k = int(np.searchsorted(times, t))
        if not 0 < k < len(times):
            return self.end(period, late)
        k -= int(t - times[k - 1] < times[k] - t)
        q, v, a, j = motions[:, k]
        x = t - times[k]
        return with_constant_jerk(q, v, a, j, x)

    @cached_property
    def _table(self) -> tuple[Floats, Floats]:
        """Times about where the motion may be rejoined, and the motion there (4, n, m)."""
        low, high = self.left - self.guess, self.left + AHEAD * self.guess
        times = np.linspace(max(low, 0.0), min(high, self.commanded.law.duration), TABLE)
        return times, self.commanded.motion(times)

    @cached_property
    def guess(self) -> float:
        """Time from rest to rest over the way to the motion at once [s]."""
        off = np.abs(self.end(0.0, 0.0)[0] - self.start[0])
        v, a, j = (getattr(self.limits, kind) for kind in KINDS)
        return float(np.max(off / v + np.sqrt(off / a) + np.cbrt(32.0 * off / j)))

    def end(self, period: float, late: float) -> Floats:
        """(4, m) of the commanded motion that is rejoined after `period`, `late` behind its time [s]."""
        motion: Floats = self.commanded.motion(np.array([self.left + period - late]))[:, 0]
        if self.left + period - late >= self.commanded.law.duration:
            motion[1:] = 0.0
        return motion


@dataclass(frozen=True, eq=False)
class Spline:
    """Joints over the steps of a time: a start within rows, or the answer."""

    problem: Problem
    period: float
    lead: float
    """[s]"""
    y: Floats
    """(N + 3, m) coefficients; see kernels/planners/joint_spline_barrier.py."""
    late: float
    """Beyond `lead` [s]."""
    used: float
    """Share of what is asked of it."""
    plain: Floats
    """(N + 3, m) those of a quintic between the same ends."""

    @classmethod
    def begun(cls, problem: Problem, period: float, lead: float, plain: Floats, near: Spline | None = None) -> Spline:
        """A quintic, or what is as far from it as another spline is from its own."""
        y = plain.copy()
        if near is not None:
            share = scales(near.problem, near.period) / scales(problem, period)
            y[3:-3] += (near.y - near.plain)[3:-3] * share
        return cls(problem, period, lead, y, 0.0, np.inf, plain)


def scales(problem: Problem, period: float) -> Floats:
    """(m,) size of the coefficients of each joint: what its limits let it do within a step."""
    v, a, j = (getattr(problem.limits, kind) for kind in KINDS)
    h = period / problem.pieces
    size: Floats = np.minimum(np.minimum(j * h**3, a * h**2), v * h)
    return np.where(np.isfinite(size), size, 1.0)


def quintic(end: Floats, period: float, t: Floats, spread: Floats) -> Floats:
    """(n, m) coefficients about t (n,), of a variance `spread`, of the quintics from nothing to a state (3, m)."""
    d1, d2, d3 = end[0], end[1] * period, end[2] * period**2 / 2.0
    c = (10.0 * d1 - 4.0 * d2 + d3, -15.0 * d1 + 7.0 * d2 - 2.0 * d3, 6.0 * d1 - 3.0 * d2 + d3)
    x = (t / period)[:, None]
    value = x**3 * (c[0] + x * (c[1] + x * c[2]))
    bend: Floats = x * (6.0 * c[0] + x * (12.0 * c[1] + x * 20.0 * c[2])) / period**2
    found: Floats = value - spread[:, None] / 2.0 * bend
    return found


def rows_of(
    problem: Problem, period: float, lead: float, late: tuple[float, float], *, nearly: bool = False
) -> tuple[Rows, Floats]:
    """What limits and travel ask for, and coefficients (N + 3, m) that join both states, not within them yet.

    `late` is its range [s], from and to; `nearly` takes the end from a table.
    """
    n, m, mesh = problem.pieces, problem.start.shape[1], Mesh.of(period, problem.pieces)
    q, v, a = problem.start
    limits = [getattr(problem.limits, kind) for kind in KINDS]
    unit = scales(problem, period)
    low, high = problem.travel.T
    bounded = np.isfinite(high - low)
    middle, half = (
        np.where(bounded, both, 1.0) for both in ((np.where(bounded, low, 0.0) + high) / 2.0, (high - low) / 2.0)
    )
    base, ratio = np.zeros((4, n, m)), np.zeros((4, m))
    at, square = mesh.places[:n, None], mesh.squares[:n, None]
    base[0] = np.where(bounded, (q + v * at + a / 2.0 * square - middle) / half, 0.0)
    ratio[0] = np.where(bounded, unit / half, 0.0)
    base[1] = (v + a * mesh.paces[:, None]) / limits[0]
    base[2] = a / limits[1]
    ratio[1:] = unit / np.stack(limits)
    end = problem.near_end(period, lead) if nearly else problem.end(period, lead)
    wanted = end[:3] - [q + v * period + a * period**2 / 2.0, v + a * period, a]
    y = np.zeros((n + 3, m))
    y[n:] = mesh.end_coefficients(wanted) / unit
    spread = mesh.places**2 - mesh.squares
    y[3:n] = quintic(wanted, period, mesh.places[3:n], spread[3:n]) / unit
    drift = mesh.end_coefficients(-end[1:]) / unit
    none = np.zeros((n, 3)), np.zeros((n, 3, m))
    return Rows(mesh.stencil, base, ratio, drift, *none, late[0] - lead, late[1] - lead), y


def with_feed(problem: Problem, rows: Rows, period: float, rates: Floats, allowed: Floats) -> Rows:
    """The rows with those of the feed: `allowed` (N,) speeds of the tip where its control points have their say.

    `rates` (N, 3, m) are those of the tip by the joints there.
    """
    mesh = Mesh.of(period, problem.pieces)
    going = problem.start[1] + mesh.paces[:, None] * problem.start[2]
    there = np.isfinite(allowed)
    scale = np.where(there, 1.0 / np.where(there, allowed, 1.0), 0.0)[:, None]
    base = np.einsum("kdm,km->kd", rates, going) * scale
    each = rates * (scale * mesh.stencil[1, :, 1:2])[:, :, None] * scales(problem, period)
    return rows._replace(tip_base=base, tip_map=np.ascontiguousarray(each))


def allowed_speed(problem: Problem, detour: Detour, share: float) -> tuple[Floats, float, Floats]:
    """(N,) most speed of the tip [m/s] where its control points have their say, and until when it is above the feed.

    That of the block that the tool is abreast of, or while the start is above it what is left when every joint brakes
    with a `share` of its jerk. Also the rates (N, 3, m) of the tip by the joints there.
    """
    assert problem.machine is not None
    mesh, run = Mesh.of(detour.duration, problem.pieces), problem.commanded.run
    feeds = feed_at(run, detour.abreast(mesh.times))
    # a control point of velocity has its say from t_k-2 to t_k+1: the least feed of all these steps is its own
    around = np.arange(problem.pieces)[:, None] + np.arange(-2, 2)
    feed = feeds[np.clip(around, 0, problem.pieces)].min(axis=1)
    rates = tip_rates(problem.machine, detour.motion(mesh.paces)[0])
    if not np.isfinite(feed).any():
        return feed, 0.0, rates
    braked = fastest_braking(rates, problem.start, mesh.paces, problem.limits, share)
    within = np.concatenate([[True, True], np.logical_and.accumulate((braked > feed)[2:])])  # the start decides two
    return np.where(within, np.maximum(feed, braked), feed), float(mesh.times[int(np.sum(within))]), rates


def solved(
    rows: Rows, spline: Spline, *, with_tip: bool, least_late: int = 0, gap: float = 1e-2, enough: float = 0.0
) -> Spline:
    """The spline with least use of its rows, or, where it is within them, least (1) or most (-1) `late`, to a gap.

    Use below `enough` is as good as the least.
    """
    y = spline.y.copy()
    at = np.array([spline.late, 1.0])
    if rows.latest > rows.earliest:
        inside = 0.05 * (rows.latest - rows.earliest)
        at[0] = np.clip(spline.late, rows.earliest + inside, rows.latest - inside)
        y[-3:] += (at[0] - spline.late) * rows.drift
    used = most_used(rows, y, with_tip)
    if not (least_late and used < 1.0):
        at[1] = START_WIDER * used
        least(rows, y, at, 0, ENOUGH if least_late else enough, gap, int(with_tip))
    if least_late and rows.latest > rows.earliest and most_used(rows, y, with_tip) < 1.0:
        at[1] = 1.0
        least(rows, y, at, least_late, 0.0, gap * spline.period, int(with_tip))
    used = float(most_used(rows, y, with_tip))
    return Spline(spline.problem, spline.period, spline.lead, y, float(at[0]), used, spline.plain)


def detour_of(spline: Spline) -> Detour:
    """The motion of a spline: knots worked out step by step from the start, so that it has no gap."""
    problem, mesh = spline.problem, Mesh.of(spline.period, spline.problem.pieces)
    jerks = mesh.jerks(spline.y * scales(problem, spline.period))
    rejoin = min(problem.left + spline.period - spline.lead - spline.late, problem.commanded.law.duration)
    knots = knots_of(problem.start, jerks, mesh.times)
    return Detour(problem.commanded, problem.left, rejoin, mesh.times, knots, jerks)


def knots_of(start: Floats, jerks: Floats, times: Floats) -> Floats:
    """(3, n + 1, m) states at the ends of steps (n + 1,), from that at the first (3, m) and jerks (n, m)."""
    h, first = np.diff(times)[:, None], np.zeros((1, start.shape[1]))
    a = start[2] + np.concatenate([first, np.cumsum(h * jerks, axis=0)])
    v = start[1] + np.concatenate([first, np.cumsum(h * (a[:-1] + h * jerks / 2.0), axis=0)])
    moved = h * (v[:-1] + h * (a[:-1] / 2.0 + h * jerks / 6.0))
    q = start[0] + np.concatenate([first, np.cumsum(moved, axis=0)])
    return np.stack([q, v, a])


@dataclass(frozen=True, eq=False)
class Mesh:
    """Steps over a time, and what a spline on them is made of."""

    times: Floats
    """(N + 1,) ends of the steps [s]."""
    places: Floats
    """(N + 3,) where each coefficient has its say: the coefficients of t."""
    squares: Floats
    """(N + 3,) the coefficients of t^2."""
    paces: Floats
    """(N,) where the control points of velocity have theirs, of c_k + 1 and c_k."""
    stencil: Floats
    """(4, N, 4) weights of c_k to c_k + 3 in the control points k of position, velocity, acceleration and jerk."""

    @classmethod
    @lru_cache(4)
    def of(cls, period: float, pieces: int) -> Mesh:
        """Over a time [s]."""
        unit = unit_mesh(pieces)
        orders = period ** -np.arange(4.0)[:, None, None]
        return cls(
            unit.times * period, unit.places * period, unit.squares * period**2, unit.paces * period,
            unit.stencil * orders,
        )  # fmt: skip

    def end_coefficients(self, state: Floats) -> Floats:
        """(3, m) last coefficients of splines with a state (3, m) at the end, where the steps are even."""
        h = self.times[-1] - self.times[-2]
        middle = state[0] - h * h / 6.0 * state[2]
        beside = h * h / 2.0 * state[2]
        return np.stack([middle - h * state[1] + beside, middle, middle + h * state[1] + beside])

    def jerks(self, c: Floats) -> Floats:
        """(N, m) of coefficients (N + 3, m)."""
        weights = self.stencil[3]
        found: Floats = sum(weights[:, d, None] * c[d : len(weights) + d] for d in range(4))
        return found


@lru_cache(2)
def unit_mesh(pieces: int) -> Mesh:
    """Over one second."""
    shares = np.array([*FIRST, *np.ones(pieces - len(FIRST))])
    times = np.concatenate([[0.0], np.cumsum(shares) / shares.sum()])
    first, last = times[1], times[-1] - times[-2]
    t = np.concatenate([[-2.0 * first, -first], times, times[-1] + last * np.arange(1.0, 4.0)])  # t_-2 is the first
    a, b, c = (t[i : i + pieces + 3] for i in range(3))
    k = np.arange(pieces)
    widths = (
        (t[k + 3] - t[k]) / 3.0, (t[k + 3] - t[k + 1]) / 2.0, t[k + 3] - t[k + 2],
        (t[k + 4] - t[k + 1]) / 3.0, (t[k + 4] - t[k + 2]) / 2.0, (t[k + 5] - t[k + 2]) / 3.0,
    )  # fmt: skip
    stencil = np.zeros((4, pieces, 4))
    stencil[0, :, 0] = 1.0
    slopes = [difference(d, w) for d, w in enumerate((widths[0], widths[3], widths[5]))]
    bends = [(slopes[1] - slopes[0]) / widths[1][:, None], (slopes[2] - slopes[1]) / widths[4][:, None]]
    stencil[1], stencil[2] = slopes[0], bends[0]
    stencil[3] = (bends[1] - bends[0]) / widths[2][:, None]
    return Mesh(times, (a + b + c) / 3.0, (a * b + b * c + c * a) / 3.0, ((b + c) / 2.0)[:pieces], stencil)


def difference(d: int, width: Floats) -> Floats:
    """(n, 4) weights of (c_k+d+1 - c_k+d) / width."""
    weights = np.zeros((len(width), 4))
    weights[:, d], weights[:, d + 1] = -1.0 / width, 1.0 / width
    return weights
