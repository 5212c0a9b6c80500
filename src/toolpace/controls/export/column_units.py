"""The units of a table's columns: mm and degrees, others, or encoder increments; and what rounding to these moves."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.common.errors import UsageError, did_you_mean
from toolpace.common.units import ANGLES, LENGTHS, format_angle, format_length
from toolpace.controls.export.rows import CHUNK
from toolpace.controls.export.target import PlannedMotion
from toolpace.motion.setpoints import SetPoints

MOST_COUNTS = 2.0**53
"""Increments beyond which a double is no whole number any more."""
_LENGTHS = {name: LENGTHS[name] for name in ("um", "mm", "cm", "m", "in")}
_ANGLES = {name: ANGLES[name] for name in ("deg", "rad", "mrad")}


@dataclass(frozen=True)
class Scale:
    """How each joint is written."""

    units: tuple[str, ...]
    """(m,) of positions: "mm", "deg", "counts"."""
    factors: Floats
    """(m,) from m and rad."""
    counted: tuple[bool, ...]
    """(m,) whether positions are whole numbers."""
    length: tuple[str, float]
    """Unit of the tip, and its factor from m."""

    @property
    def resolution(self) -> Floats:
        """(m,) how far rounding may move a position [m, rad]; 0 for joints that are not counted."""
        return np.where(self.counted, 0.5 / np.abs(self.factors), 0.0)


def scale_of(motion: PlannedMotion, units: str, counts: Mapping[str, str]) -> Scale:
    """The scale of `mm,deg` or the like, and of `X` to `10000/mm` for the joints that are counted.

    Raises UsageError with what is wrong and the units there are.
    """
    parts = [part.strip().lower() for part in units.split(",")]
    lengths, angles = [p for p in parts if p in _LENGTHS], [p for p in parts if p in _ANGLES]
    if len(parts) != 2 or len(lengths) != 1 or len(angles) != 1:
        raise UsageError(
            f"--scale {units[:40]}: give a unit of length ({', '.join(_LENGTHS)}) and one of angle "
            f"({', '.join(_ANGLES)}), like mm,deg"
        )
    for joint in counts:
        if joint not in motion.joints:
            raise UsageError(
                f"--counts {joint[:40]}: the machine has no such joint; {did_you_mean(joint, motion.joints)}"
            )
    if counts and (missing := [joint for joint in motion.joints if joint not in counts]):
        raise UsageError(
            f"--counts: nothing is said of joint {', '.join(missing)}; give all, like {missing[0]}=10000/mm"
        )
    names, factors = [], []
    for joint, turns in zip(motion.joints, motion.rotary):
        if joint in counts:
            names.append("counts")
            factors.append(_per_unit(joint, counts[joint], turns))
        else:
            names.append(angles[0] if turns else lengths[0])
            factors.append(1.0 / (_ANGLES[angles[0]] if turns else _LENGTHS[lengths[0]]))
    counted = tuple(joint in counts for joint in motion.joints)
    scale = Scale(tuple(names), np.array(factors), counted, (lengths[0], 1.0 / _LENGTHS[lengths[0]]))
    most = np.abs(motion.setpoints.q).max(axis=0) * np.abs(scale.factors)
    for joint, value, whole in zip(motion.joints, most, counted):
        if whole and value > MOST_COUNTS:
            raise UsageError(
                f"--counts {joint}={counts[joint]}: {value:.3g} increments are more than a whole number can hold "
                f"({MOST_COUNTS:.3g}); correct the figure"
            )
    return scale


def _per_unit(joint: str, text: str, turns: bool) -> float:
    """Increments for each m or rad, of text such as `10000/mm`; below zero where the encoder counts backwards."""
    units = _ANGLES if turns else _LENGTHS
    figure, _, unit = text.partition("/")
    example = "1000/deg" if turns else "10000/mm"
    try:
        value = float(figure)
    except ValueError:
        value = math.nan
    if unit.strip().lower() not in units:
        kind = "turns" if turns else "moves straight"
        raise UsageError(
            f"--counts {joint}={text[:40]}: joint {joint} {kind}; write increments for each of {', '.join(units)}, "
            f"like {joint}={example}"
        )
    if not (math.isfinite(value) and value != 0.0):
        raise UsageError(
            f"--counts {joint}={text[:40]}: '{figure[:20]}' is no number of increments; like {joint}={example}"
        )
    return value / units[unit.strip().lower()]


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
