"""Where the spline of a run has knots, where it is compared with the polyline, and a first spline inside the tube.

Knots start at the vertices, at least SPACING tolerances apart, and graded. A smoothing spline that hardly smooths
then shows where more are needed: at corners cells are halved until it runs well inside the tube.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from toolpace.errors import PathError
from toolpace.fit.polyline import Machine, Polyline, axis_columns
from toolpace.pathrun import Bools, Floats, Ints

SPACING = 20.0
"""Least distance of the first knots [tolerances]: curves that differ by less than a tolerance need no closer ones."""
RATIO = 2.5
"""Most ratio of the lengths of neighbouring cells."""
INSIDE = 0.6
"""Share of the tolerance within which the first spline must run."""
SMOOTHING = 0.01
"""Weight of the roughness in the first spline: it smooths what is shorter than a few tolerances."""
ROUNDS = 60
LEAST = 1e-4
"""Shortest cell [tolerances]."""
PARTS = 4
"""Into how many parts the stretches between samples are cut to look between them."""


@dataclass(frozen=True)
class Samples:
    """Where a spline is compared with its polyline, and how."""

    s: Floats
    """(m,) ascending parameters: vertices, knots, and the middles of what lies between."""
    first: Ints
    """(m,) first of the six coefficients that matter."""
    rows: Floats
    """(m, 6) their basis values."""
    tip: Floats
    """(m, 3) the polyline [tolerances]."""
    turn: Floats
    """(m, 2 or 3) [tolerances]"""
    metric: Floats
    """(m, d, d) what a deviation of the turn is on the sphere, squared."""


def first_breaks(s: Floats) -> Floats:
    """Breaks at vertices, SPACING apart or more, and graded; two cells at least."""
    from toolpace.kernels.spline import thin

    breaks = thin(s, SPACING)
    if len(breaks) < 3:
        breaks = np.array([s[0], 0.5 * (s[0] + s[-1]), s[-1]])
    return graded(breaks)


def graded(breaks: Floats) -> Floats:
    """The breaks with cells halved until none is more than RATIO times as long as a neighbour."""
    while True:
        h = np.diff(breaks)
        least = h.copy()
        least[1:] = np.minimum(least[1:], h[:-1])
        least[:-1] = np.minimum(least[:-1], h[1:])
        long = h > RATIO * least
        if not np.any(long):
            return breaks
        middle = 0.5 * (breaks[:-1] + breaks[1:])[long]
        breaks = np.sort(np.concatenate([breaks, middle]))


def knots_of(breaks: Floats) -> Floats:
    """Knots with both ends six-fold."""
    return np.concatenate([np.repeat(breaks[:1], 5), breaks, np.repeat(breaks[-1:], 5)])


def interpolate(s: Floats, values: Floats, at: Floats) -> Floats:
    """The polyline at parameters `at`."""
    return np.stack([np.interp(at, s, column) for column in values.T], axis=1)


def sample(
    line: Polyline, breaks: Floats, axis_tolerance: float, machine: Machine | None, at: Floats | None = None
) -> Samples:
    """Samples `at` parameters; by default vertices, breaks, and the middles between them where these are not close."""
    from toolpace.kernels.spline import basis_rows

    if at is None:
        s = np.unique(np.concatenate([line.s, breaks]))
        middle = 0.5 * (s[1:] + s[:-1])
        cell = np.clip(np.searchsorted(breaks, middle) - 1, 0, len(breaks) - 2)
        wide = np.diff(s) > 0.2 * np.diff(breaks)[cell]
        s = np.sort(np.concatenate([s, middle[wide]]))
    else:
        s = at
    first, rows = basis_rows(knots_of(breaks), s)
    turn = interpolate(line.s, line.turn, s)
    return Samples(s, first, rows, interpolate(line.s, line.tip, s), turn, turn_metric(turn, axis_tolerance, machine))


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


def inside_spline(
    line: Polyline, breaks: Floats, weight: Floats, axis_tolerance: float, machine: Machine | None
) -> tuple[Floats, Samples, Floats, Floats]:
    """Breaks, samples and the coefficients of tip (n, 3) and turn (n, d) of a spline well inside the tube."""
    from toolpace.kernels.spline import third_rows
    from toolpace.kernels.tube import least_squares

    for _ in range(ROUNDS):
        data = sample(line, breaks, axis_tolerance, machine)
        third = third_rows(knots_of(breaks))
        tips = np.broadcast_to(np.eye(3), (len(data.s), 3, 3)).copy()
        n = len(breaks) + 4
        tip, turn = np.zeros((n, 3)), np.zeros((n, data.turn.shape[1]))
        tip[0], tip[-1], turn[0], turn[-1] = line.tip[0], line.tip[-1], line.turn[0], line.turn[-1]
        done = least_squares(third, np.full(3, SMOOTHING), data.first, data.rows, data.tip, tips, tip)
        done &= least_squares(third, SMOOTHING * weight, data.first, data.rows, data.turn, data.metric, turn)
        if not done:
            break
        bad = data.s[outside(data, tip, turn)]
        if len(bad) == 0:
            # a spline with as many coefficients as samples obeys at the samples and swings between them
            between = sample(line, breaks, axis_tolerance, machine, dense(data.s))
            bad = between.s[outside(between, tip, turn)]
        if len(bad) == 0:
            return breaks, data, tip, turn
        breaks = refined_at(line.s, breaks, bad)
    raise PathError("the program asks for a corner that no curve within the tolerance can follow")


def outside(data: Samples, tip: Floats, turn: Floats) -> Bools:
    """Which samples see the splines leave the inner part of the tube."""
    tips = np.broadcast_to(np.eye(3), (len(data.s), 3, 3)).copy()
    return np.asarray(
        np.maximum(deviation(data, tip, data.tip, tips), deviation(data, turn, data.turn, data.metric)) > INSIDE
    )


def dense(samples: Floats) -> Floats:
    """Parameters that cut each stretch between samples into PARTS."""
    inner = (samples[:-1, None] + np.diff(samples)[:, None] * (np.arange(PARTS) / PARTS)).ravel()
    return np.concatenate([inner, samples[-1:]])


def refined_at(vertices: Floats, breaks: Floats, bad: Floats) -> Floats:
    """The breaks with the cells that hold or touch a bad parameter cut in two."""
    split = np.zeros(len(breaks) - 1, dtype=bool)
    for side in (-1e-9, 1e-9):
        at = np.searchsorted(breaks, bad + side * (1.0 + bad), side="right") - 1
        split[np.clip(at, 0, len(split) - 1)] = True
    if np.any(np.diff(breaks)[split] < LEAST):
        raise PathError("the program asks for a corner that no curve within the tolerance can follow")
    return graded(np.sort(np.concatenate([breaks, middles(vertices, breaks, split)])))


def middles(vertices: Floats, breaks: Floats, split: Bools) -> Floats:
    """Where to cut the cells: at the vertex nearest the middle if there is one in the middle half."""
    low, high = breaks[:-1][split], breaks[1:][split]
    middle = 0.5 * (low + high)
    above = np.clip(np.searchsorted(vertices, middle), 1, len(vertices) - 1)
    near = np.where(vertices[above] - middle < middle - vertices[above - 1], vertices[above], vertices[above - 1])
    return np.asarray(np.where(np.abs(near - middle) < 0.25 * (high - low), near, middle))


def deviation(data: Samples, x: Floats, target: Floats, metric: Floats) -> Floats:
    """Deviation (m,) of the spline with coefficients x from its target, in tolerances."""
    from toolpace.kernels.assemble import gather

    r = np.empty_like(target)
    gather(data.first, data.rows, x, r)
    r -= target
    return np.asarray(np.sqrt(np.maximum(0.0, np.einsum("mc,mcd,md->m", r, metric, r))))
