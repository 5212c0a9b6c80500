"""The figures that describe a control, from the table `[time]` of its file, and the limits that it keeps by them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Literal

import msgspec
import numpy as np

from toolpace.common.arrays import Floats
from toolpace.common.errors import UsageError, in_short
from toolpace.common.units import DEGREE, MILLIMETRE
from toolpace.controls.timing.makers import FanucFigures, HeidenhainFigures, LinuxCNCFigures, SinumerikFigures
from toolpace.machine.limits import Limits

if TYPE_CHECKING:
    from toolpace.machine.machine import Machine
    from toolpace.programs.commanded import Commanded

MODELS = ("linuxcnc", "sinumerik", "heidenhain", "fanuc", "lookahead", "ideal")
FORMER_MODELS = {"fir": "heidenhain or fanuc, which filter as their makers say, or lookahead"}
"""Models of former versions, and what to take in their place."""
USUAL_TOLERANCE = 0.01
"""[mm]"""
Positive = Annotated[float, msgspec.Meta(ge=1e-4, le=1e9)]
Time = Annotated[float, msgspec.Meta(ge=0.0, le=3600.0)]


class ControlFigures(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What a model of a control needs to know beside the machine; what is not given is the machine's, or usual."""

    model: Literal["linuxcnc", "sinumerik", "heidenhain", "fanuc", "lookahead", "ideal"] = "lookahead"
    tolerance: Positive | None = None
    """How far corners are rounded where the program does not say [mm]; 0.01, or as LinuxCNC does without G64 P."""
    axis_tolerance: Positive = 0.05
    """The same of turns, where the program does not say [deg]."""
    compress: Annotated[float, msgspec.Meta(ge=0.0, le=10.0)] | None = None
    """Within which short blocks are taken as one line, where the program does not say [mm]; 0: none are, not given:
    the tolerance of corners. `fanuc` and `linuxcnc` take none by it."""
    limits: Literal["joints", "words"] = "joints"
    """Whose limits are kept in tool-centre-point mode: the joints', or those of X, Y, Z of the tip."""
    acceleration: Positive | dict[str, Positive] = 1.0
    """Share of the machine's limits that is used; or by axis [mm/s^2, deg/s^2]."""
    jerk: Positive | dict[str, Positive] = 1.0
    """The same [mm/s^3, deg/s^3]."""
    look_ahead: Annotated[int, msgspec.Meta(ge=0, le=1_000_000)] | None = None
    """Blocks that are read ahead; 0: all. Not given: 40 of `fanuc` (A-63512EN, page 3), 5000 of `heidenhain` (Technical
    Manual MANUALplus 620, page 825), else all."""
    block_time: Time = 0.0
    """Least time of a block [s]: how fast blocks are read."""
    sinumerik: SinumerikFigures = SinumerikFigures()
    heidenhain: HeidenhainFigures = HeidenhainFigures()
    fanuc: FanucFigures = FanucFigures()
    linuxcnc: LinuxCNCFigures = LinuxCNCFigures()

    @property
    def room(self) -> float:
        """Tolerance of corners [m]."""
        return (USUAL_TOLERANCE if self.tolerance is None else self.tolerance) * MILLIMETRE


def figures_of(table: Mapping[str, object], source: str, model: str | None = None) -> ControlFigures:
    """The figures of a table; `model` takes the place of what it names. Raises UsageError."""
    figures = dict(table)
    if model is not None:
        figures["model"] = model
    if (former := str(figures.get("model"))) in FORMER_MODELS:
        raise UsageError(
            f"controller {source}, [time]: there is no model {former} any more; take {FORMER_MODELS[former]}"
        )
    try:
        return msgspec.convert(figures, ControlFigures)
    except msgspec.ValidationError as error:
        raise UsageError(f"controller {source}, [time]: {in_short(error)}") from None


def limits_of(machine: Machine, figures: ControlFigures) -> Limits:
    """The machine's limits, with the shares or the figures of the control in their place. Raises UsageError."""
    own = machine.limits
    acceleration = _scaled(machine, own.acceleration, figures.acceleration, "acceleration")
    jerk = _scaled(machine, own.jerk, figures.jerk, "jerk")
    return Limits(own.velocity, acceleration, jerk, machine.joints)


def _scaled(machine: Machine, own: Floats, share_or_figures: float | dict[str, float], kind: str) -> Floats:
    if isinstance(share_or_figures, int | float):
        return own * share_or_figures
    limits = own.copy()
    for axis, figure in share_or_figures.items():
        if axis not in machine.joints:
            raise UsageError(
                f"[time] {kind}: machine '{machine.name}' has no axis {axis}, it has {', '.join(machine.joints)}"
            )
        column = machine.joints.index(axis)
        limits[column] = figure * (DEGREE if machine.is_rotary[column] else MILLIMETRE)
    return limits


def off_the_path(moves: Commanded, machine: Machine, figures: ControlFigures) -> Floats:
    """(axes,) what a unit of each axis counts for beside the tolerance of the tip [m].

    A turn by its tolerance counts as much as that of the tip; of several in a program the least hold.
    """
    axis = moves.axis_tolerance[np.isfinite(moves.axis_tolerance)].min(initial=np.inf)
    turn = axis if np.isfinite(axis) else figures.axis_tolerance * DEGREE
    tip = moves.tolerance[np.isfinite(moves.tolerance) & (moves.tolerance > 0.0)].min(initial=np.inf)
    return np.where(machine.is_rotary, (tip if np.isfinite(tip) else figures.room) / turn, 1.0)
