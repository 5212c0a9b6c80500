"""Time laws: the path parameter over time, of each kind that a planner finds, and made of others."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from toolpace.common.arrays import Bools, Floats, Ints, gate_methods, number
from toolpace.common.value_objects import one_line
from toolpace.path.fit.speed_weights import SpeedWeights, weights_of_motion

PROBES = 20_000
"""Probes of a whole law, shared among its cells."""
FEWEST_PROBES, MOST_PROBES = 9, 257
"""Probes of one cell: more where a coarse mesh leaves much room between nodes."""
CELLS_AT_A_TIME = 10_000
"""Cells of a spline that are probed in one piece, to keep memory low."""
HALVINGS = 80
"""Of a duration until no time between two numbers is left: 53 for its digits, and the rest for times next to zero."""
QUINTIC_STATES = 65
"""States that a probe takes in each interval of quintics, both ends included."""
SIDE = 1e-13
"""Time before the end of a piece at which its last state is taken, relative [s]."""


@dataclass(frozen=True, eq=False, repr=False)
class Probe:
    """States of a time law, dense enough to see every peak between them."""

    state: Floats
    """(4, n): s, ds/dt, d2s/dt2, d3s/dt3."""
    right: Floats
    """(n,) of bool-like: 1 where the state belongs to the right side of a break at s, else 0."""
    share: Floats
    """(n,) time that each state stands for [s]; sums to the duration."""

    def __repr__(self) -> str:
        return one_line(self, f"{self.state.shape[1]} states")


class TimeLaw(ABC):
    """s(t) from s0 to s1, three times differentiable but for jumps of the third derivative."""

    s0: float
    s1: float
    duration: float
    """[s]"""

    def __repr__(self) -> str:
        return one_line(self, f"s {self.s0:.6g} to {self.s1:.6g} in {self.duration:.6g} s")

    def __init_subclass__(cls) -> None:
        """Have arrays of times and places that a caller gives go through the gate."""
        gate_methods(cls, ("at",), "t")
        gate_methods(cls, ("states_at", "times_at"), "s")

    @property
    def jumps(self) -> Floats:
        """(2, k) values of s where d2s/dt2 jumps, and by how much; none where the third derivative is bounded."""
        return np.empty((2, 0))

    @abstractmethod
    def at(self, t: Floats) -> Floats:
        """(4, n): s and three time derivatives at sorted times t (n,) in [0, duration]."""

    @abstractmethod
    def probes(self) -> Iterator[Probe]:
        """States between which nothing is hidden, in pieces that do not take much memory."""

    def lost_in_dips(self) -> float:
        """Time [s] that is lost in cells in which the pace falls far below that of both their nodes, to none at times.

        A law whose limits hold at the nodes alone may lose hours so; one whose limits hold everywhere does not.
        """
        return 0.0

    def states_at(self, s: Floats) -> Floats:
        """(4, n) the states in which places s (n,) in order are passed."""
        return self.at(self.times_at(s))

    def times_at(self, s: Floats) -> Floats:
        """(n,) when places s (n,) in order are passed [s], by bisection."""
        low, high = np.zeros(len(s)), np.full(len(s), self.duration)
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            before = self.at(middle)[0] < s
            low, high = np.where(before, middle, low), np.where(before, high, middle)
        return np.asarray(0.5 * (low + high))

    def speed_weights(self, smoothed: float, ramp: float, power: float) -> SpeedWeights:
        """Weights of a fit by the speed of this law, a mean over the time `smoothed` [s].

        ramp: time in which an acceleration builds up [s]; power: of ds/dt, see `SpeedWeights`.
        """
        return weights_of_motion(self.at, self.s0, self.duration, smoothed, ramp, power)

    def passing_time(self, s: float) -> float:
        """When s is passed [s], by bisection; the start or the end where s is at or beyond it.

        Raises UsageError for what is no number.
        """
        s = number(s, f"{type(self).__name__}.passing_time: s", endless=True)
        if s <= self.s0:
            return 0.0
        if s >= self.s1:
            return self.duration
        return float(TimeLaw.times_at(self, np.array([s]))[0])


gate_methods(TimeLaw, ("states_at", "times_at"), "s")


def probes_a_cell(nodes: int) -> int:
    """At how many places each cell of a law with so many nodes is probed."""
    return int(np.clip(PROBES // nodes, FEWEST_PROBES, MOST_PROBES))


class SplineLaw(TimeLaw):
    """(ds/dt)^2 a twice differentiable cubic spline of s; next to rest, ds/dt has a constant third derivative.

    Between nodes time is the integral of ds / sqrt(z), to rounding (kernels/motion/squared_speed_spline.py); s is its
    inverse. So positions are the integral of the velocities on any mesh.
    """

    def __init__(self, nodes: Floats, c: Floats, rest: tuple[float, float]) -> None:
        """Take the spline's knots (n,), its coefficients (n + 2,) and the lengths of the rest cells (0: in motion)."""
        from toolpace.kernels.motion import squared_speed_spline

        self.nodes, self.c, self.rest = nodes, c, rest
        self.inside = (1.0 - np.cos(np.linspace(0.0, np.pi, probes_a_cell(len(nodes))))) / 2.0
        """(k,) shares of a cell at which it is probed: closer together next to the nodes, where peaks hide."""
        self.cells = squared_speed_spline.polynomials(nodes, c)
        """(n - 1, 4) z in each cell as a polynomial of s - nodes[k]."""
        begin = 3.0 * rest[0] / math.sqrt(self.cells[0, 0]) if rest[0] > 0.0 else 0.0
        panels = squared_speed_spline.panels_of(nodes, self.cells, begin)
        self.times = squared_speed_spline.node_times(panels, nodes)
        """(n,) when the nodes are passed [s]."""
        self.s0, self.s1 = nodes[0] - rest[0], nodes[-1] + rest[1]
        end = squared_speed_spline.end_speed(nodes, self.cells)
        self.duration = float(self.times[-1] + (3.0 * rest[1] / end if rest[1] > 0.0 else 0.0))
        ends = float(rest[0]), float(rest[1])
        self._law = squared_speed_spline.Law(nodes, self.cells, self.times, panels, *ends, self.duration)

    def slowed(self, by: float) -> SplineLaw:
        """The same motion with z divided by a factor everywhere; only between two rests."""
        return SplineLaw(self.nodes, self.c / by, self.rest)

    def z_at_nodes(self) -> Floats:
        """(n,) (ds/dt)^2 at the nodes."""
        return np.append(self.cells[:, 0], self.cells[-1] @ np.power(self.nodes[-1] - self.nodes[-2], np.arange(4.0)))

    def dips(self) -> Bools:
        """(n - 1,) cells in which z falls far below its values at both nodes: too long for the motion in them."""
        from toolpace.kernels.motion import squared_speed_spline

        return squared_speed_spline.dips(self.nodes, self.cells, self.inside)

    def lost_in_dips(self) -> float:
        dips = self.dips()
        ends = np.sqrt(self.z_at_nodes())
        level = 2.0 * np.diff(self.nodes) / (ends[:-1] + ends[1:])
        return float((np.diff(self.times)[dips] - level[dips]).sum())

    def at(self, t: Floats) -> Floats:
        from toolpace.kernels.motion import squared_speed_spline

        return squared_speed_spline.states(np.ascontiguousarray(t, dtype=float), self._law)

    def states_at(self, s: Floats) -> Floats:
        from toolpace.kernels.motion import squared_speed_spline

        return squared_speed_spline.states_at(np.ascontiguousarray(s), self._law)

    def probes(self) -> Iterator[Probe]:
        from toolpace.kernels.motion import squared_speed_spline

        last = len(self.nodes) - 1
        for first in range(0, last, CELLS_AT_A_TIME):
            beyond = min(first + CELLS_AT_A_TIME, last)
            yield Probe(*squared_speed_spline.probe(self._law, self.inside, first, beyond))


class QuinticLaw(TimeLaw):
    """s(t) through reference points with given speeds and accelerations, Eq. (7b) in t / T_i over each period T_i.

    Position, speed and acceleration are continuous; the third derivative jumps at the points.
    """

    def __init__(
        self, s: Floats, speed: Floats, acceleration: Floats, periods: Floats, jerk: Floats | None = None
    ) -> None:
        """Take the points (n + 1,), the speeds and accelerations there, and the periods (n,) between [s].

        `jerk` (n,) is given where the law is a cubic in each period: in one of microseconds, the rounding of two points
        is more than what the third derivative moves them by.
        """
        from toolpace.kernels.motion.quintic import coefficients

        self.s, self.speed, self.acceleration, self.periods = s, speed, acceleration, periods
        self.times = np.concatenate([[0.0], np.cumsum(periods)])
        """(n + 1,) when the points are passed [s]."""
        for value in vars(self).values():
            value.flags.writeable = False
        self.polynomials = coefficients(self.times, s[:, None], speed[:, None], acceleration[:, None])
        if jerk is not None:
            self.polynomials[:, 3:, 0] = 0.0
            self.polynomials[:, 3, 0] = jerk * periods**3 / 6.0
        self.s0, self.s1 = float(s[0]), float(s[-1])
        self.duration = float(self.times[-1])

    def at(self, t: Floats) -> Floats:
        from toolpace.kernels.motion.quintic import evaluate

        state: Floats = evaluate(self.times, self.polynomials, np.ascontiguousarray(t, dtype=float))[:, :, 0]
        state[0] = np.clip(state[0], self.s0, self.s1)
        return state

    def probes(self) -> Iterator[Probe]:
        yield self.probe()

    def probe(self) -> Probe:
        """States between which nothing is hidden."""
        from toolpace.kernels.motion.quintic import evaluate

        n = len(self.periods)
        tau = np.linspace(0.0, 1.0, QUINTIC_STATES)
        weight = np.r_[0.5, np.ones(QUINTIC_STATES - 2), 0.5] / (QUINTIC_STATES - 1)
        state = np.empty((4, n, QUINTIC_STATES))
        for k in range(n):
            # each interval on its own, so that its last state is that of its left side
            local = np.array([0.0, self.periods[k]])
            state[:, k] = evaluate(local, self.polynomials[k : k + 1], tau * self.periods[k])[:, :, 0]
            state[0, k, 0], state[0, k, -1] = self.s[k], self.s[k + 1]
        right = np.ones((n, QUINTIC_STATES))
        right[:, -1] = 0.0
        return Probe(state.reshape(4, -1), right.ravel(), (self.periods[:, None] * weight).ravel())


class LinearLaw(TimeLaw):
    """z = (ds/dt)^2 linear in s between nodes: d2s/dt2 is constant in each cell, and s(t) a parabola.

    Acceleration jumps at the nodes, so no number bounds the jerk there.
    """

    def __init__(self, nodes: Floats, z: Floats) -> None:
        """Take the nodes (n,) and z there, above zero but for the ends [1/s^2 times the square of s]."""
        self.nodes, self.z = nodes, z
        self.speed = np.sqrt(z)
        """(n,) ds/dt at the nodes."""
        periods = 2.0 * np.diff(nodes) / (self.speed[1:] + self.speed[:-1])
        self.acceleration = np.diff(self.speed) / periods
        """(n - 1,) d2s/dt2 in the cells."""
        self.times = np.concatenate([[0.0], np.cumsum(periods)])
        """(n,) when the nodes are passed [s]."""
        self.inside = np.linspace(0.0, 1.0, probes_a_cell(len(nodes)))
        """(k,) shares of a cell at which it is probed."""
        for value in vars(self).values():
            value.flags.writeable = False
        self.s0, self.s1 = float(nodes[0]), float(nodes[-1])
        self.duration = float(self.times[-1])

    def slowed(self, by: float) -> LinearLaw:
        """The same motion with z divided by a factor everywhere; only between two rests."""
        return LinearLaw(self.nodes, self.z / by)

    @property
    def jumps(self) -> Floats:
        """(2, n): every node, and by how much d2s/dt2 jumps there; from and to zero at an end at rest."""
        first, last = (self.acceleration[k] if self.z[k] == 0.0 else 0.0 for k in (0, -1))
        return np.stack([self.nodes, np.abs(np.concatenate([[first], np.diff(self.acceleration), [last]]))])

    def at(self, t: Floats) -> Floats:
        k = np.clip(np.searchsorted(self.times, t, side="right") - 1, 0, len(self.acceleration) - 1)
        tau = np.clip(t, 0.0, self.duration) - self.times[k]
        speed, acceleration = self.speed[k], self.acceleration[k]
        s = np.clip(self.nodes[k] + tau * (speed + acceleration * tau / 2.0), self.nodes[k], self.nodes[k + 1])
        return np.stack([s, np.maximum(speed + acceleration * tau, 0.0), acceleration, np.zeros(len(k))])

    def probes(self) -> Iterator[Probe]:
        for first in range(0, len(self.acceleration), CELLS_AT_A_TIME):
            cells = np.arange(first, min(first + CELLS_AT_A_TIME, len(self.acceleration)))
            state, right = self.states_within(cells)
            speed = state[1].reshape(len(cells), -1)
            steps = 2.0 * (self.nodes[cells + 1] - self.nodes[cells])[:, None] * np.diff(self.inside)
            half = steps / (speed[:, 1:] + speed[:, :-1]) / 2.0
            share = np.pad(half, ((0, 0), (0, 1))) + np.pad(half, ((0, 0), (1, 0)))
            yield Probe(state, right, share.ravel())

    def states_within(self, cells: Ints) -> tuple[Floats, Floats]:
        """(4, m k) states at the k places `inside` each of m cells, and 0 for those on the left side of a break."""
        low, high = self.nodes[cells][:, None], self.nodes[cells + 1]
        s = low + (high[:, None] - low) * self.inside
        s[:, -1] = high
        z = self.z[cells][:, None] * (1.0 - self.inside) + self.z[cells + 1][:, None] * self.inside
        right = np.ones_like(s)
        right[:, -1] = 0.0
        acceleration = np.repeat(self.acceleration[cells], len(self.inside))
        return np.stack([s.ravel(), np.sqrt(z.ravel()), acceleration, np.zeros(s.size)]), right.ravel()


class ClockLaw(TimeLaw):
    """s = t + s0: what moves, and how it comes to rest, is all in the path."""

    def __init__(self, nodes: Floats) -> None:
        """Take the times (n,) between which the path is smooth [s]."""
        self.nodes = nodes
        self.nodes.flags.writeable = False
        self.s0, self.s1 = float(nodes[0]), float(nodes[-1])
        self.duration = self.s1 - self.s0

    def at(self, t: Floats) -> Floats:
        return np.stack([np.clip(self.s0 + t, self.s0, self.s1), np.ones(len(t)), *np.zeros((2, len(t)))])

    def probes(self) -> Iterator[Probe]:
        inside = np.linspace(0.0, 1.0, FEWEST_PROBES)
        weight = np.r_[0.5, np.ones(FEWEST_PROBES - 2), 0.5] / (FEWEST_PROBES - 1)
        for first in range(0, len(self.nodes) - 1, CELLS_AT_A_TIME):
            ends = self.nodes[first : first + CELLS_AT_A_TIME + 1]
            length = np.diff(ends)[:, None]
            s = ends[:-1, None] + length * inside
            s[:, -1] = ends[1:]
            right = np.ones_like(s)
            right[:, -1] = 0.0
            none = np.zeros(s.size)
            yield Probe(np.stack([s.ravel(), none + 1.0, none, none]), right.ravel(), (length * weight).ravel())


@dataclass(frozen=True, eq=False)
class LawPiece:
    """A law between two of its times [s]."""

    law: TimeLaw
    begin: float
    end: float


class ChainLaw(TimeLaw):
    """Pieces of laws, each beginning in the state in which the one before ends."""

    def __init__(self, pieces: Sequence[LawPiece]) -> None:
        self.pieces = tuple(pieces)
        self.times = np.concatenate([[0.0], np.cumsum([piece.end - piece.begin for piece in pieces])])
        """(pieces + 1,) when the pieces begin and end [s]."""
        self.duration = float(self.times[-1])
        self.s0 = float(pieces[0].law.at(np.array([pieces[0].begin]))[0, 0])
        self.s1 = float(pieces[-1].law.at(np.array([pieces[-1].end]))[0, 0])

    def at(self, t: Floats) -> Floats:
        t = np.asarray(t, dtype=float)
        which = np.clip(np.searchsorted(self.times, t, side="right") - 1, 0, len(self.pieces) - 1)
        out = np.empty((4, len(t)))
        for k in np.unique(which):
            piece, here = self.pieces[k], which == k
            out[:, here] = piece.law.at(np.clip(piece.begin + (t[here] - self.times[k]), piece.begin, piece.end))
        return out

    def probes(self) -> Iterator[Probe]:
        for piece in self.pieces:
            # the end of a piece belongs to its own side of a jump of the third derivative
            ends = piece.law.at(np.array([piece.begin, piece.end - SIDE * piece.end]))
            total = 0.0
            for probe in piece.law.probes():
                inside = (probe.state[0] > ends[0, 0]) & (probe.state[0] < ends[0, 1])
                if inside.any():
                    total += float(probe.share[inside].sum())
                    yield Probe(probe.state[:, inside], probe.right[inside], probe.share[inside])
            # what the cut leaves of the time is that of the ends
            rest = max(piece.end - piece.begin - total, 0.0) / 2.0
            yield Probe(ends, np.array([1.0, 0.0]), np.full(2, rest))


class SlowedLaw(TimeLaw):
    """A law in which everything takes `pace` times as long."""

    def __init__(self, law: TimeLaw, pace: float) -> None:
        self.law, self.pace = law, pace
        self.s0, self.s1, self.duration = law.s0, law.s1, law.duration * pace
        self._powers = (1.0 / pace) ** np.arange(4.0)[:, None]

    @property
    def jumps(self) -> Floats:
        s, jump = self.law.jumps
        return np.stack([s, jump / self.pace**2])

    def at(self, t: Floats) -> Floats:
        return np.asarray(self.law.at(t / self.pace) * self._powers)

    def times_at(self, s: Floats) -> Floats:
        return self.law.times_at(s) * self.pace

    def states_at(self, s: Floats) -> Floats:
        return np.asarray(self.law.states_at(s) * self._powers)

    def probes(self) -> Iterator[Probe]:
        for probe in self.law.probes():
            yield Probe(probe.state * self._powers, probe.right, probe.share * self.pace)
