"""The tolerance that rounding to encoder increments leaves of a plan."""

from __future__ import annotations

import numpy as np

from toolpace.common.errors import UsageError
from toolpace.common.units import format_angle, format_length
from toolpace.controls.export.column_units import Scale
from toolpace.controls.export.motion import PlannedMotion
from toolpace.motion.setpoints import SetPoints

CHUNK = 20_000
"""Rows that are compared at once, to keep memory low."""


def refuse_coarse(motion: PlannedMotion, points: SetPoints, scale: Scale) -> None:
    """Raise UsageError where rounding to increments moves tip or tool axis by more than the plan may stray."""
    if not any(scale.counted):
        return
    tip, axis = _moved(motion, points, scale)
    most_tip, most_axis = motion.tolerances
    if tip <= most_tip and axis <= most_axis:
        return
    share = max(tip / most_tip, axis / most_axis)
    raise UsageError(
        f"--counts: rounding to whole increments moves the tip by up to {format_length(tip)} and the tool axis by "
        f"{format_angle(axis)}, more than the plan may stray ({format_length(most_tip)}, {format_angle(most_axis)}); "
        f"give increments at least {np.ceil(share):.0f} times finer, or leave --counts out"
    )


def _moved(motion: PlannedMotion, points: SetPoints, scale: Scale) -> tuple[float, float]:
    """How far rounding moves the tip [m], and turns the tool axis [rad], at most."""
    tip = axis = 0.0
    for start in range(0, len(points), CHUNK):
        q = points.q[start : start + CHUNK]
        rounded = np.where(scale.counted, np.rint(q * scale.factors) / scale.factors, q)
        lengths = points.tool_length[start : start + CHUNK]
        (here, along), (there, turned) = (motion.machine.forward(each, lengths) for each in (q, rounded))
        tip = max(tip, float(np.linalg.norm(there - here, axis=1).max()))
        chord = float(np.linalg.norm(turned - along, axis=1).max())
        axis = max(axis, 2.0 * float(np.arcsin(min(0.5 * chord, 1.0))))
    return tip, axis
