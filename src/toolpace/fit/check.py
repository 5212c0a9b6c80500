"""How far a fitted curve is from its polyline, between all samples, in both directions.

Curve and polyline are compared at the same parameter. That pairs every point of one with a point of the other in
order along both, so the largest difference bounds the distance from the curve to the polyline, that from the polyline
to the curve, and the tip and the axis belong to the same moment.
"""

from __future__ import annotations

import numpy as np

from toolpace.fit.mesh import interpolate
from toolpace.fit.polyline import Machine, Polyline, great_circle
from toolpace.pathrun import Floats


def deviations(
    line: Polyline,
    at: Floats,
    tip: Floats,
    turn: Floats,
    axis_tolerance: float,
    machine: Machine | None,
    joints_given: bool,
) -> tuple[Floats, Floats]:
    """Deviation of tip and tool axis (n,) in tolerances, at parameters `at` where the curve is at tip and turn."""
    tip_off = np.linalg.norm(tip - interpolate(line.s, line.tip, at), axis=1)
    if machine is None:
        curve = turn / np.linalg.norm(turn, axis=1)[:, None]
    else:
        curve = machine.axis_at(turn * axis_tolerance)
    if machine is not None and joints_given:
        program = machine.axis_at(interpolate(line.s, line.turn, at) * axis_tolerance)
    else:
        cell = np.clip(np.searchsorted(line.s, at, side="right") - 1, 0, len(line.s) - 2)
        u = (at - line.s[cell]) / (line.s[cell + 1] - line.s[cell])
        program = great_circle(line.axis[cell], line.axis[cell + 1], u[:, None])
    angle = 2.0 * np.arcsin(np.minimum(1.0, 0.5 * np.linalg.norm(curve - program, axis=1)))
    return tip_off, angle / axis_tolerance
