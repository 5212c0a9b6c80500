"""The spline of a run during the fit, its basis, and its deviation from the polyline in both directions.

The basis is that of de Boor, A Practical Guide to Splines, chapter X, in arrays, and to the bit what
scipy.interpolate.BSpline gives; that import takes half as long as a short plan.

Curve and polyline are compared at the same parameter. That pairs every point of one with a point of the other in
order along both, so the largest difference bounds the distance from the curve to the polyline, that from the polyline
to the curve, and the tip and the axis belong to the same moment.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from toolpace.common.arrays import Floats, Ints
from toolpace.machine.machine import Machine
from toolpace.path.fit.polyline import Polyline, axis_columns

PARTS = 4
"""Into how many parts the stretches between samples are cut to look between them."""
CLOSE = 0.9
"""Maxima above this share of the tolerance are looked at more closely."""
CLOSER = 6
"""Into how many parts the stretches on both sides of such a maximum are cut."""


def cells_of(knots: Floats, degree: int, at: Floats) -> Ints:
    """(n,) the cell k of each place, knots[k] <= at < knots[k + 1]; of a place outside the first or last one.

    knots (m,) not falling, at (n,).
    """
    cell = np.searchsorted(knots, at, side="right") - 1
    return np.asarray(np.clip(cell, degree, len(knots) - degree - 2), dtype=np.int64)


def nonzero_basis(knots: Floats, degree: int, cell: Ints, at: Floats, order: int = 0) -> Floats:
    """(n, degree + 1) a derivative of the B-splines cell - degree to cell, at places (n,) in cells (n,).

    The cells are not empty: then no difference of knots is zero.
    """
    basis = np.zeros((degree + 1, len(at)))
    basis[0] = 1.0
    for j in range(1, degree + 1):
        lower = basis[:j].copy()
        basis[0] = 0.0
        for n in range(1, j + 1):
            right, left = knots[cell + n], knots[cell + n - j]
            if j <= degree - order:
                weight = lower[n - 1] / (right - left)
                basis[n - 1] += weight * (right - at)
                basis[n] = weight * (at - left)
            else:
                weight = j * lower[n - 1] / (right - left)
                basis[n - 1] -= weight
                basis[n] = weight
    return np.ascontiguousarray(basis.T)


def spline_values(knots: Floats, coefficients: Floats, degree: int, at: Floats, order: int = 0) -> Floats:
    """(n, ...) a derivative of the spline with coefficients (m - degree - 1, ...) over knots (m,) at places (n,)."""
    cell = cells_of(knots, degree, at)
    basis = nonzero_basis(knots, degree, cell, at, order)
    value = np.zeros((len(at), *coefficients.shape[1:]))
    for k in range(degree + 1):
        weight = basis[:, k].reshape(-1, *[1] * (coefficients.ndim - 1))
        value += coefficients[cell - degree + k] * weight
    return value


@dataclass(frozen=True)
class Spline:
    """Breaks and the coefficients of tip (n, 3) and turn (n, d), which are worked on in place; all in tolerances."""

    breaks: Floats
    tip: Floats
    turn: Floats

    @property
    def is_finite(self) -> bool:
        """Whether all coefficients are numbers."""
        return bool(np.isfinite(self.tip).all() and np.isfinite(self.turn).all())

    def pieces(self) -> Floats:
        """Taylor coefficients (cells, 6, 3 + d) at the left end of each cell."""
        from toolpace.kernels.fit.quintic_spline import pieces

        return pieces(knots_of(self.breaks), np.concatenate([self.tip, self.turn], axis=1))

    def copy(self) -> Spline:
        """One that may be worked on while this one stays."""
        return Spline(self.breaks, self.tip.copy(), self.turn.copy())

    def over(self, breaks: Floats) -> Spline:
        """The same curve over finer breaks."""
        from toolpace.kernels.fit.quintic_spline import recast

        x = recast(self.breaks, self.pieces(), knots_of(breaks))
        for end in (0, -1):
            x[end] = np.concatenate([self.tip[end], self.turn[end]])
        return Spline(breaks, x[:, :3].copy(), x[:, 3:].copy())


def knots_of(breaks: Floats) -> Floats:
    """Knots with both ends six-fold."""
    return np.concatenate([np.repeat(breaks[:1], 5), breaks, np.repeat(breaks[-1:], 5)])


@dataclass(frozen=True)
class Samples:
    """Ascending parameters, what the polyline is there, and what of a spline matters there."""

    s: Floats
    """(m,) ascending parameters: vertices, knots, and the middles of what lies between."""
    first: Ints
    """(m,) first of the six coefficients that matter."""
    rows: Floats
    """(m, 6) their basis values."""
    tip: Floats
    """(m, 3) the polyline, or the middle of the half of the tube beside it [tolerances]."""
    tip_metric: Floats | None
    """(m, 3, 3) what a deviation of the tip is, squared; None: its length."""
    turn: Floats
    """(m, 2 or 3) [tolerances]"""
    metric: Floats
    """(m, d, d) what a deviation of the turn is on the sphere, squared."""
    room: Floats
    """(m, 2) tolerance of tip and turn, in the narrowest."""
    gap: Floats
    """(m,) half the distance between the neighbours."""

    def metrics(self, which: int, part: slice) -> Floats:
        """The metric of the tip (0) or of the turn (1) at some of the samples."""
        if which == 1:
            return self.metric[part]
        if self.tip_metric is not None:
            return self.tip_metric[part]
        return np.broadcast_to(np.eye(3), (len(self.s[part]), 3, 3)).copy()

    def off(self, part: slice, x: Floats, base: int, target: Floats, metric: Floats) -> Floats:
        """Deviation of the spline with coefficients x, from number `base` on, from its target [tolerances]."""
        from toolpace.kernels.fit.polyline import metric_distance
        from toolpace.kernels.fit.smoothing_spline import gather

        here = np.empty_like(target[part])
        gather(self.first[part] - base, self.rows[part], x, here)
        return metric_distance(here, target[part], metric)


def sample(
    line: Polyline,
    breaks: Floats,
    axis_tolerance: float,
    machine: Machine | None,
    at: Floats | None = None,
    previous: Samples | None = None,
) -> Samples:
    """Samples `at` parameters; by default vertices, breaks, and the middles between them where these are not close.

    What `previous` has is not worked out again.
    """
    from toolpace.kernels.fit.polyline import straight
    from toolpace.kernels.fit.quintic_spline import basis_rows

    s = usual(line.s, breaks) if at is None else at
    first, rows = basis_rows(knots_of(breaks), s)
    turn = straight(line.s, line.turn, s)
    metric = np.empty((len(s), turn.shape[1], turn.shape[1]))
    fresh = np.ones(len(s), dtype=bool)
    if previous is not None:
        old = np.minimum(np.searchsorted(previous.s, s), len(previous.s) - 1)
        fresh = previous.s[old] != s
        metric[~fresh] = previous.metric[old[~fresh]]
    metric[fresh] = turn_metric(turn[fresh], axis_tolerance, machine)
    tip, tip_metric = straight(line.s, line.tip, s), None
    if line.half is not None:
        tip, tip_metric = tip + line.half.centre(s), line.half.metric(s)
    return Samples(s, first, rows, tip, tip_metric, turn, metric, line.room_at(s), np.gradient(s))


def usual(vertices: Floats, breaks: Floats) -> Floats:
    """Vertices, breaks, and the middles between them where these are not close."""
    s = np.unique(np.concatenate([vertices, breaks]))
    middle = 0.5 * (s[1:] + s[:-1])
    cell = np.clip(np.searchsorted(breaks, middle) - 1, 0, len(breaks) - 2)
    wide = np.diff(s) > 0.2 * np.diff(breaks)[cell]
    return np.sort(np.concatenate([s, middle[wide]]))


def turn_metric(turn: Floats, axis_tolerance: float, machine: Machine | None) -> Floats:
    """What a deviation of the turn (n, d) is on the sphere, (n, d, d): the square of the axis's derivative.

    Near a pole the angle that does not move the axis is free, but not without bound: a deviation of the tilt by the
    tolerance makes it matter, hence the tolerance added to the length of each column, and more than 0.3 rad are never
    taken.
    """
    if machine is None:
        return np.broadcast_to(np.eye(3), (len(turn), 3, 3)).copy()
    jacobian = axis_columns(turn * axis_tolerance, machine)
    metric = np.asarray(np.einsum("nca,ncb->nab", jacobian, jacobian))
    for joint in range(2):
        length = np.sqrt(metric[:, joint, joint])
        metric[:, joint, joint] += length * axis_tolerance + (axis_tolerance / 0.3) ** 2
    return metric


@dataclass(frozen=True)
class Comparison:
    """What curves are compared with, and how far they are off it."""

    line: Polyline
    axis_tolerance: float
    machine: Machine | None
    in_joints: bool
    """Whether the program itself is straight in the rotary joints; else its axes turn on great circles."""

    def between(self, spline: Spline, samples: Floats) -> tuple[Floats, Floats]:
        """Ascending parameters between the samples, and the larger deviation of the spline there."""
        at, tip, axis = self.closely(spline.pieces(), spline.breaks, samples)
        return at, np.maximum(tip, axis)

    def closely(self, polynomials: Floats, breaks: Floats, samples: Floats) -> tuple[Floats, Floats, Floats]:
        """Ascending parameters, and the deviations of tip and tool axis there, more of them about maxima."""
        at = dense(samples)
        tip, axis = self.deviations(breaks, polynomials, at)
        off = np.maximum(tip, axis)
        peak = np.flatnonzero((off[1:-1] > CLOSE) & (off[1:-1] >= off[:-2]) & (off[1:-1] >= off[2:])) + 1
        if len(peak) == 0:
            return at, tip, axis
        left = np.unique(np.concatenate([peak - 1, peak]))
        share = np.arange(1, CLOSER) / CLOSER
        more = (at[left, None] + (at[left + 1] - at[left])[:, None] * share).ravel()
        tip_more, axis_more = self.deviations(breaks, polynomials, more)
        order = np.argsort(np.concatenate([at, more]), kind="stable")
        return (
            np.concatenate([at, more])[order],
            np.concatenate([tip, tip_more])[order],
            np.concatenate([axis, axis_more])[order],
        )

    def deviations(self, breaks: Floats, polynomials: Floats, at: Floats) -> tuple[Floats, Floats]:
        """Deviation of tip and tool axis (n,) of the curve at the ascending parameters `at` (n,), in the tolerances
        that hold there; where the tip must be on one side, its distance from the middle of that half of the tube."""
        from toolpace.kernels.fit.polyline import circular, distance, straight
        from toolpace.kernels.fit.quintic_spline import values

        line, machine = self.line, self.machine
        curve = values(breaks, polynomials, at)
        turn = np.ascontiguousarray(curve[:, 3:])
        there, wanted = np.ascontiguousarray(curve[:, :3]), straight(line.s, line.tip, at)
        tip_off = distance(there, wanted) if line.half is None else line.half.distance(there - wanted, at)
        if machine is None:
            axis = turn / np.linalg.norm(turn, axis=1)[:, None]
        else:
            axis = machine.axis_at(turn * self.axis_tolerance)
        if machine is not None and self.in_joints:
            program = machine.axis_at(straight(line.s, line.turn, at) * self.axis_tolerance)
        else:
            program = circular(line.s, line.axis, at)
        angle = 2.0 * np.arcsin(np.minimum(1.0, 0.5 * distance(axis, program)))
        room = line.room_at(at)
        return tip_off / room[:, 0], angle / self.axis_tolerance / room[:, 1]

    def strays(self, breaks: Floats, polynomials: Floats, at: Floats, tip: Floats) -> Floats:
        """How far the tip (n,) is from the program, where its deviations `tip` may count from elsewhere."""
        from toolpace.kernels.fit.polyline import distance, straight
        from toolpace.kernels.fit.quintic_spline import values

        if self.line.half is None:
            return tip
        there = np.ascontiguousarray(values(breaks, polynomials, at)[:, :3])
        return distance(there, straight(self.line.s, self.line.tip, at))


def dense(samples: Floats) -> Floats:
    """Parameters that cut each stretch between samples into PARTS."""
    inner = (samples[:-1, None] + np.diff(samples)[:, None] * (np.arange(PARTS) / PARTS)).ravel()
    return np.concatenate([inner, samples[-1:]])
