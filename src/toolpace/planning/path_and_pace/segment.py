"""The linearised limits and tolerances of a segment under small changes of its path and speed, by effort.

Over the time t of the motion at hand, tip and rotary joints x(t) change by d(t), and the pace by z = (dt / dt_new)^2,
which was 1. The joints q then have, with primes for derivatives by t,

    velocity q' z^(1/2)      acceleration q'' z + q' z' / 2      jerk (q''' z + 3/2 q'' z' + 1/2 q' z'') z^(1/2)

in which q' to q''' are those of the motion plus J d and its derivatives: J is the derivative of the joints by tip and
rotary joints along the path, with its own derivatives by t, and exact to the second order of d, which is next to
nothing within tolerances. So all rows are bilinear in d and z.

d is a quintic spline on the knots of the path, z a cubic one. Coefficient k of the one and k - 1 of the other make
slot k: each cell has six neighbouring slots of six unknowns, the last of them that of the pace.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from toolpace.common.arrays import Bools, Floats
from toolpace.kernels import path_and_pace as kernel
from toolpace.machine import kinematics
from toolpace.machine.machine import Machine
from toolpace.motion.laws import TimeLaw
from toolpace.path.fit.polyline import Polyline
from toolpace.path.fit.spline import cells_of, nonzero_basis, turn_metric
from toolpace.path.follow_run import FollowRun
from toolpace.path.run import SplineRun

JERK = 0.98
"""Share of the jerk limits that the change may use: where an acceleration or a velocity at its limit tells the pace,
what is left of the jerks is all the freedom that the plan of the changed path has."""
NUDGE = 1e-4
"""By which coordinates are moved to see what joints do [m or rad]."""
SLOT = kernel.SLOT
"""Unknowns of a slot, and slots of a cell."""
PACE_SLOTS = np.arange(1, 5)
"""Those of a cell that its pace is made of."""
GROUPS = slice(0, 3), slice(3, 5)
"""Columns of tip and turn: a ball each."""


@dataclass(frozen=True)
class FittedRun:
    """A run that is fitted and planned, and what it was fitted to."""

    run: SplineRun
    joints: FollowRun
    law: TimeLaw
    line: Polyline
    machine: Machine
    scale: Floats
    """(5,) tolerances of tip [m] and of rotary joints [rad]: units of the change."""
    breaks: Floats
    """(cells + 1,) parameters of the knots of the change [m], from the start of the path on."""
    times: Floats
    """(cells + 1,) when the motion passes them [s]."""
    begin: float
    """Parameter at which the run starts [m]."""
    still: Bools
    """(slots, 2) whether a rotary joint stays as it is in a slot."""
    care: EffortSettings

    def off(self, s: Floats) -> Floats:
        """(n, 5) deviation of the path from the program at s (n,) [tolerances]."""
        from toolpace.kernels.fit.polyline import straight

        jet = self.run.evaluate(s)
        at = (s - self.begin) / self.scale[0]
        assert jet.rotary is not None
        wanted = np.concatenate([straight(self.line.s, each, at) for each in (self.line.tip, self.line.turn)], axis=1)
        return np.asarray(np.concatenate([jet.tip[0], jet.rotary[0]], axis=1) / self.scale - wanted)


class Tube:
    """Where a stretch is held to the program."""

    def __init__(self, fitted: FittedRun, low: int, high: int, also: Floats) -> None:
        """Of cells low to high; at their ends, thirds and at the parameters `also`."""
        breaks = fitted.breaks[low : high + 1]
        inner = (breaks[:-1, None] + np.diff(breaks)[:, None] * np.array([0.0, 1.0, 2.0]) / 3.0).ravel()[1:]
        s = np.unique(np.concatenate([inner, also[(also > breaks[0]) & (also < breaks[-1])]]))
        cell = np.searchsorted(breaks, s, side="right") - 1
        self.off = fitted.off(s)
        """(n, 5) deviation before any change, from the middle of the tube."""
        self.room = fitted.line.room_at((s - fitted.begin) / fitted.scale[0])
        """(n, 2) tolerance of tip and turn, in the narrowest."""
        rotary = fitted.run.evaluate(s).rotary
        assert rotary is not None
        metric = np.zeros((len(s), 5, 5))
        metric[:, :3, :3] = np.eye(3)
        half, at = fitted.line.half, (s - fitted.begin) / fitted.scale[0]
        if half is not None:
            self.off[:, :3] -= half.centre(at)
            metric[:, :3, :3] = half.metric(at)
        metric[:, 3:, 3:] = turn_metric(rotary[0] / fitted.scale[4], float(fitted.scale[4]), fitted.machine)
        start = np.searchsorted(cell, np.arange(high - low + 1))
        self.balls = kernel.Balls(cell, start, local_basis(fitted.breaks, 5, s, 0), metric)

    def moved(self, move: Floats) -> Floats:
        """(n, 5) the part of the path in a move (slots, 6) of its slots."""
        there = move[self.balls.first[:, None] + np.arange(SLOT)][:, :, :5]
        return np.asarray(np.einsum("nk,nkc->nc", self.balls.basis, there))


class Stretch:
    """The cells low to high of a run, at whose places limits are rows; its slots are counted from `low` on."""

    def __init__(self, fitted: FittedRun, low: int, high: int, also: Floats) -> None:
        breaks, times = fitted.breaks[low : high + 1], fitted.times[low : high + 1]
        self.slots = slice(low, high + SLOT - 1)
        """Those of the run."""
        self.care, each, self.still = fitted.care, fitted.care.places, fitted.still[self.slots]
        t = (times[:-1, None] + np.diff(times)[:, None] * (np.arange(each) + 0.5) / each).ravel()
        self.weight = np.repeat(np.diff(times) / each, each)
        """(n,) time of each place [s]."""
        state = fitted.law.at(t)
        s = np.clip(state[0] - fitted.law.s0 + fitted.begin, breaks[0], breaks[-1])
        jet = fitted.run.evaluate(s)
        assert jet.rotary is not None
        tip, rotary = in_time(jet.tip, state), in_time(jet.rotary, state)
        limits, cap = fitted.machine.limits, fitted.joints.speed_cap(s)
        self.places = kernel.Places(
            first=np.repeat(np.arange(high - low), each),
            basis=by_place(in_time(np.stack([local_basis(fitted.breaks, 5, s, order) for order in range(4)]), state)),
            pace=by_place(np.stack([local_basis(fitted.times, 3, t, order) for order in range(3)])),
            moved=by_place(moves(fitted.machine, tip, rotary) * fitted.scale),
            joints=by_place(fitted.machine.linear_jets(tip, rotary)[1:]),
            feed=np.where(np.isfinite(cap), state[1] / cap, 0.0),
            limits=np.stack([limits.velocity, limits.acceleration, JERK * np.asarray(limits.jerk)]),
        )
        self.tube = Tube(fitted, low, high, also)

    def at(self, x: Floats) -> State:
        """What is felt with coefficients x (slots, 6)."""
        n, _, m = self.places.joints.shape
        felt = kernel.Felt(np.empty((n, 3)), np.empty((n, 3, m)), np.empty((n, 3 * m + 1)))
        kernel.feel(self.places, x, felt)
        off = self.tube.off + self.tube.moved(x)
        return State(felt, off, np.einsum("ncd,nd->nc", self.tube.balls.metric, off))

    def pace_moved(self, move: Floats) -> Floats:
        """(n,) the part of the pace in a move (slots, 6)."""
        there = move[self.places.first[:, None] + PACE_SLOTS, 5]
        return np.asarray(np.einsum("nk,nk->n", self.places.pace[:, 0], there))

    def rows_moved(self, now: State, move: Floats) -> Floats:
        """(n, 3 m + 1) how what is used changes with a move (slots, 6), to the first order."""
        rows = np.empty_like(now.used)
        kernel.move_rows(self.places, now.felt, move, rows)
        return rows


@dataclass(frozen=True)
class State:
    """A stretch with some change."""

    felt: kernel.Felt
    """At the places of its rows."""
    off: Floats
    """(k, 5) deviation from the program where the tube is held [tolerances]."""
    force: Floats
    """(k, 5) metric times deviation."""

    @property
    def z(self) -> Floats:
        """(n,) of the pace."""
        return self.felt.z[:, 0]

    @property
    def used(self) -> Floats:
        """(n, 3 m + 1) acceleration, jerk and velocity over their limits, and ds/dt over its own."""
        return self.felt.used

    def excess(self, radius: Floats) -> Floats:
        """(k, 2) half the squared deviation of tip and turn, less that of the radius (k, 2)."""
        squared = np.stack([np.einsum("nc,nc->n", self.force[:, g], self.off[:, g]) for g in GROUPS], axis=1)
        return np.asarray(0.5 * (squared - radius**2))


def by_place(derivatives: Floats) -> Floats:
    """(n, orders, ...) from (orders, n, ...)."""
    return np.ascontiguousarray(np.moveaxis(derivatives, 0, 1))


def local_basis(breaks: Floats, degree: int, at: Floats, order: int) -> Floats:
    """(n, degree + 1) a derivative of the B-splines that are not zero, at places (n,) inside the cells."""
    padded = np.concatenate([np.repeat(breaks[0], degree), breaks, np.repeat(breaks[-1], degree)])
    return nonzero_basis(padded, degree, cells_of(padded, degree, at), at, order)


def in_time(by_s: Floats, state: Floats) -> Floats:
    """Value and derivatives 1 to 3 by t (4, n, k) from those by s (4, n, k), and the state (4, n) of s."""
    v, a, j = (each[:, None] for each in state[1:])
    x, first, second, third = by_s
    return np.stack([x, first * v, second * v**2 + first * a, third * v**3 + 3.0 * second * v * a + first * j])


def moves(machine: Machine, tip: Floats, rotary: Floats) -> Floats:
    """(4, n, m, 5) the derivative of the joints by tip and rotary joints along a path, and its derivatives 1 to 3 by
    t; tip (4, n, 3) and rotary (4, n, 2) with theirs."""
    columns = []
    for coordinate in range(5):
        sides = []
        for nudge in (NUDGE, -NUDGE):
            moved = [tip.copy(), rotary.copy()]
            moved[coordinate // 3][0, :, coordinate % 3] += nudge
            sides.append(kinematics.linear_jets(machine.geometry, moved[0], moved[1]))
        columns.append((sides[0] - sides[1]) / (2.0 * NUDGE))
    return np.stack(columns, axis=3)


def slots_of(breaks: Floats) -> int:
    """How many slots a run with these breaks has."""
    return len(breaks) + 4


class EffortSettings(NamedTuple):
    """The discretisation of the change, and when its methods are at their end."""

    longest: float
    """Most time from knot to knot, in that in which an acceleration builds up."""
    places: int
    """In each cell, evenly spread, at which limits are held."""
    gap: float
    """At which the interior-point method ends, relative to the time."""
    steps: int
    """After which it ends in any case."""
    seams: bool
    """Whether windows over the seams of the others follow."""
    covered: float
    """Share of the time lost below the caps on the speed that the windows which are changed hold."""


THOROUGH = EffortSettings(0.08, 4, 1e-2, 60, True, 1.0)
"""All that is to be had, nearly."""
QUICK = EffortSettings(0.08, 2, 0.1, 14, False, 0.9)
"""Most of it for a tenth of the time: between its places limits are passed a little, which the plan of the path
mends."""
