"""All that a follower knows of path, machine and its own figures, as one flat piece: see kernels/follow/layout.py."""

from __future__ import annotations

import numpy as np

from toolpace.arrays import Floats
from toolpace.follow.figures import Figures
from toolpace.follow.samples import Samples
from toolpace.kernels.follow import layout
from toolpace.machine.machine import Machine

CELL_SAMPLES = 16
"""Samples in a cell, of which the peaks are known."""
TO_CORRECTION = 0.75
"""Share of the reserve that is the correction's; the rest lets the pace be changed where the path uses all it may."""
LEAST_FEED = 1e-5
"""Feed below which a correction is not slowed any further [m/s]."""


def law_of(samples: Samples, machine: Machine, figures: Figures, pace: float) -> Floats:
    """The piece of a path; `pace` is that of the plan at which it was sampled."""
    count, m = samples.q.shape
    spline = np.column_stack([samples.q, samples.s])[[0, *range(count), -1, -1]]
    share = TO_CORRECTION * figures.reserve
    limits = np.stack([machine.limits.velocity, machine.limits.acceleration, machine.limits.jerk])
    own = share * limits
    own[0] = np.minimum(own[0], fastest(own[1], machine, figures))
    brakes = braking_time(own[:, machine.linear])
    cells = cells_of(samples, spline[:, :m], brakes, turning_workpiece(machine))
    piece = np.zeros(layout.PATH + spline.size + cells.size)
    head = {
        layout.IS_PIECE: layout.MAGIC,
        layout.HAS_VERSION: layout.VERSION,
        layout.SAMPLES: count,
        layout.STEP: samples.step,
        layout.CELLS: len(cells),
        layout.CELL: CELL_SAMPLES * samples.step,
        layout.DURATION: (count - 1) * samples.step,
        layout.PERIOD: figures.period,
        layout.DELAY: figures.delay,
        layout.GAIN: figures.gain,
        layout.MOST: figures.max_correction,
        layout.MOST_TURN: figures.max_turn,
        layout.DEADBAND: figures.deadband,
        layout.FILTER: figures.filter,
        layout.HOLD: figures.hold,
        layout.FADE: figures.fade,
        layout.PATIENCE: figures.patience,
        layout.BELIEVABLE: figures.believable,
        layout.CAUSE: layout.DISPLACED if figures.cause == "displaced" else layout.BENDING,
        layout.FEED_SHARE: figures.reserve,
        layout.TIP_PER_LINEAR: samples.reach[0],
        layout.LEVER: max(samples.reach[1], 1e-6),
        layout.NOMINAL: pace,
        layout.WAIT: figures.wait,
        layout.AXIS_TOLERANCE: figures.axis_tolerance,
        layout.RHO: figures.rho,
    }
    for at, value in head.items():
        piece[at] = value
    geometry = machine.geometry
    piece[layout.FRAME : layout.GROUP] = geometry.frame.ravel()
    piece[layout.GROUP : layout.COMPLIANCE].view(np.int64)[:] = np.concatenate([geometry.group, geometry.place])
    piece[layout.COMPLIANCE : layout.SHARE] = figures.compliance.ravel()
    piece[layout.SHARE : layout.ROOM] = own.ravel()
    piece[layout.ROOM : layout.LOW] = ((1.0 - share) * limits).ravel()
    piece[layout.LOW : layout.PATH] = corrections_within(samples.q, machine, figures).ravel()
    piece[layout.PATH :] = np.concatenate([spline.ravel(), cells.ravel()])
    return piece


def cells_of(samples: Samples, control: Floats, brakes: float, table: list[int]) -> Floats:
    """(k, CELL_COLUMNS) of the cells, from control points (n + 3, m).

    A correction is slowed down in `brakes` [s]; the joints of `table` turn the workpiece.
    """
    peaks, h = [], samples.step
    for order in (1, 2, 3):
        difference = np.abs(np.diff(control, order, axis=0)) / h**order
        spans = 4 - order
        # a spline on a span is a mean of the differences of the four control points that it touches
        on_span = np.lib.stride_tricks.sliding_window_view(difference, spans, axis=0).max(axis=2)
        peaks.append(_most(on_span[: len(samples.q) - 1]))
    feed = -_most(-np.minimum(samples.feed[:-1], samples.feed[1:])[:, None])
    feed = np.maximum(feed, LEAST_FEED)
    ahead = int(np.ceil(1.2 * brakes / (CELL_SAMPLES * h))) + 2
    turning = peaks[0][:, table].sum(axis=1, keepdims=True) / feed
    return np.concatenate([*peaks, feed, -_most_ahead(-feed, ahead), _most_ahead(turning, ahead)], axis=1)


def _most_ahead(values: Floats, cells: int) -> Floats:
    """(k, 1) largest of values (k, 1) in each cell and the next ones, `cells` in all."""
    most = values.copy()
    for ahead in range(1, cells):
        most[:-ahead] = np.maximum(most[:-ahead], values[ahead:])
    return most


def turning_workpiece(machine: Machine) -> list[int]:
    """The rotary joints that carry the workpiece."""
    return [j for j in machine.rotary if machine.joints[j] in machine.file.chain.workpiece]


def _most(values: Floats) -> Floats:
    """(k, c) largest of values (n, c) in each cell."""
    starts = np.arange(0, len(values), CELL_SAMPLES)
    most: Floats = np.maximum.reduceat(values, starts, axis=0)
    return most


def fastest(acceleration: Floats, machine: Machine, figures: Figures) -> Floats:
    """(m,) what a correction from one end of its range to the other reaches by its acceleration alone."""
    most = np.where(machine.is_rotary, max(figures.max_turn, 1e-6), figures.max_correction)
    speed: Floats = np.sqrt(2.0 * most * acceleration)
    return speed


def braking_time(share: Floats) -> float:
    """Time in which a correction within a share (3, joints) of the limits is slowed down from any velocity [s]."""
    velocity, acceleration, jerk = share
    return float((velocity / acceleration + acceleration / jerk).max())


def corrections_within(q: Floats, machine: Machine, figures: Figures) -> Floats:
    """(2, m) least and most correction that leaves the joints (n, m) within travel."""
    most = np.where(machine.is_rotary, figures.max_turn, figures.max_correction)
    low, high = machine.travel.T
    return np.stack([np.clip(low - q.min(axis=0), -most, 0.0), np.clip(high - q.max(axis=0), 0.0, most)])
