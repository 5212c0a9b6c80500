"""The distance between a fitted curve and its polyline, in both directions, between samples too.

Curve and polyline are compared at the same parameter. That pairs every point of one with a point of the other in
order along both, so the largest difference bounds the distance from the curve to the polyline, that from the polyline
to the curve, and the tip and the axis belong to the same moment.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.machine.machine import Machine
from toolpace.path.fit.polyline import Polyline
from toolpace.path.fit.spline import Spline

PARTS = 4
"""Into how many parts the stretches between samples are cut to look between them."""
CLOSE = 0.9
"""Maxima above this share of the tolerance are looked at more closely."""
CLOSER = 6
"""Into how many parts the stretches on both sides of such a maximum are cut."""


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
