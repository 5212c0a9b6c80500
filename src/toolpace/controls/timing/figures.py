"""The figures that describe a control, from the table `[time]` of its file, and the limits that it keeps by them.

Those of four makers' controls are in the controls' own parameters, with defaults from the makers' manuals. What no
manual tells is marked (assumption). Feeds are in mm/min, times in seconds, lengths in mm, as in the manuals.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Literal

import msgspec
import numpy as np

from toolpace.common.arrays import Floats
from toolpace.common.errors import UnitWarning, UsageError, in_short
from toolpace.common.units import DEGREE, MILLIMETRE
from toolpace.machine.limits import Limits

if TYPE_CHECKING:
    from toolpace.machine.machine import Machine
    from toolpace.programs.commanded import Commanded

Share = Annotated[float, msgspec.Meta(ge=0.0, le=0.95)]
Ratio = Annotated[float, msgspec.Meta(ge=0.01, le=100.0)]
TimeConstant = Annotated[float, msgspec.Meta(ge=0.0, le=10.0)]
Figure = Annotated[float, msgspec.Meta(ge=0.0, le=1e9)]
MODELS = ("linuxcnc", "sinumerik", "heidenhain", "fanuc", "lookahead", "ideal")
FORMER_MODELS = {"fir": "heidenhain or fanuc, which filter as their makers say, or lookahead"}
"""Models of former versions, and what to take in their place."""
USUAL_TOLERANCE = 0.01
"""[mm]"""
Positive = Annotated[float, msgspec.Meta(ge=1e-4, le=1e9)]
Time = Annotated[float, msgspec.Meta(ge=0.0, le=3600.0)]
Factor = Annotated[float, msgspec.Meta(ge=1.0, le=1e3)]
Ends = Annotated[list[float], msgspec.Meta(min_length=2, max_length=2)]  # msgspec 0.22 crashes at a tuple in a union
Spread = Factor | Ends
"""How uncertain a figure is: it lies between a part and a multiple of itself by this factor, or between two ends."""


class SinumerikFigures(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Machine data of a Sinumerik (Function Manual Basic Functions, B1 and B2)."""

    soft_acceleration: Ratio = 1.0
    """MD32433 SOFT_ACCEL_FACTOR: share of the acceleration with SOFT."""
    rapid_acceleration: Ratio = 1.0
    """MD32434 G00_ACCEL_FACTOR."""
    rapid_jerk: Ratio = 1.0
    """MD32435 G00_JERK_FACTOR."""
    overload: Annotated[float, msgspec.Meta(ge=1.0, le=100.0)] = 1.2
    """MD32310 MAX_ACCEL_OVL_FACTOR; 1.2 (Function Manual 802D sl, B1, 3.4)."""
    cycle: Annotated[float, msgspec.Meta(gt=0.0, le=0.1)] = 0.004
    """Cycle of the interpolator [s] (assumption: it differs by control)."""
    curve_share: Share = 0.0
    """MD20602 CURV_EFFECT_ON_PATH_ACCEL: share of the acceleration that is for the direction across the path, the rest
    is for that along it; 0: both have all of it (assumption)."""
    transition_jerk: Ratio = 1.0
    """MD32432 PATH_TRANS_JERK_LIM over MD32431 MAX_AX_JERK."""
    jerk_finish: Ratio = 1.0
    """Jerk under DYNFINISH over that of the machine's file (MD32431 has a value for each such word; assumption: all are
    alike)."""
    jerk_semifinish: Ratio = 1.0
    """Under DYNSEMIFIN."""
    jerk_rough: Ratio = 1.0
    """Under DYNROUGH."""
    jerk_precise: Ratio = 1.0
    """Under DYNPREC."""
    jerk_position: Ratio = 1.0
    """Under DYNPOS."""
    brisk: Annotated[float, msgspec.Meta(ge=0.0, le=1.0)] = 0.0
    """1: the program begins with BRISK; 0: with SOFT (assumption: MD20150 sets it, and CYCLE832 switches SOFT on)."""


class HeidenhainFigures(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Machine parameters of a Heidenhain control (Technical Manual MANUALplus 620, CfgLaPath and CfgLaAxis)."""

    path_jerk: Figure = 40.0
    """maxPathJerk [m/s^3], default 40 (page 829)."""
    path_jerk_rapid: Figure = 40.0
    """maxPathJerkHi [m/s^3], default 40 (page 829)."""
    axis_jerk_rapid: Ratio = 5.0
    """axPathJerkHi over axPathJerk: "typically five times" (page 834)."""
    least_corner_feed: Figure = 30.0
    """minCornerFeed [mm/min], default 30 (page 502)."""
    least_path_feed: Figure = 60.0
    """minPathFeed [mm/min], default 60 (page 502)."""
    filter_time: TimeConstant = 0.0
    """Length of the triangle filter [s]; 0: 2 (6 E / j)^(1/3), with the tolerance E and the least jerk j of a linear
    axis: the length at which corners are fastest, and slower for neither tolerance nor jerk alone (assumption)."""


class FanucFigures(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Parameters of a Fanuc (specifications A-63512EN of AI contour control, A-78962EN of AI nano contour control)."""

    corner_difference: Figure = 500.0
    """1783, permissible difference of feed of a linear axis at a corner [mm/min]; 500 as in the manual's example
    (A-63512EN, page 5); 0: corners do not slow down."""
    corner_difference_rotary: Figure = 500.0
    """The same of a rotary axis [deg/min] (assumption: as of the linear ones)."""
    arc_acceleration: Ratio = 1.0
    """1735 over the axis' acceleration: in circles."""
    curve_acceleration: Ratio = 1.0
    """1737 over the axis' acceleration: between lines."""
    arc_least_feed: Figure = 0.0
    """1732, below which arcs do not slow down [mm/min]."""
    acceleration_change: Figure = 0.0
    """1788, permissible change of acceleration [mm/s^2]; 0: there is no jerk control, which is an option."""
    acceleration_change_lines: Figure = 0.0
    """1789, the same between lines; 0: that of 1788."""
    bell_time: TimeConstant = 0.0
    """1772, time in which the acceleration builds up [s]; 0: what the axes' jerk limits say (assumption)."""
    after_interpolation: TimeConstant = 0.0
    """1769, time constant of acceleration after interpolation [s] (assumption: none)."""
    cycle: Annotated[float, msgspec.Meta(gt=0.0, le=0.1)] = 0.001
    """Over which a jump of velocity is spread where nothing is behind the interpolation [s] (assumption)."""


class LinuxCNCFigures(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Settings of LinuxCNC, by the sections TRAJ and EMCMOT of its ini file (its documents, "INI Configuration")."""

    planner: Literal[0, 1] = 0
    """PLANNER_TYPE: 1 keeps jerk (2.10), 0 does not (2.9, and the default of 2.10). R of G64 takes its place."""
    cycle: Annotated[float, msgspec.Meta(gt=0.0, le=0.1)] = 0.001
    """SERVO_PERIOD [s]."""
    path_velocity: Figure = 0.0
    """MAX_LINEAR_VELOCITY [mm/s]; 0: none but the axes'."""
    path_jerk: Figure = 0.0
    """MAX_LINEAR_JERK [mm/s^3], by which arcs and roundings are slowed; 0: the greatest of X, Y and Z (assumption)."""
    peak_scale: Annotated[float, msgspec.Meta(ge=0.1, le=1.0)] = 1.0
    """SCURVE_PEAK_SCALE."""


class ControlFigures(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What a model of a control needs to know beside the machine; what is not given is the machine's, or usual."""

    model: Literal["linuxcnc", "sinumerik", "heidenhain", "fanuc", "lookahead", "ideal"] = "lookahead"
    tolerance: Positive | None = None
    """How far corners are rounded where the program does not say [mm]; 0.01, or as LinuxCNC does without G64 or
    its P."""
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
    uncertainty: dict[str, Spread | dict[str, Spread]] = {}
    """By figure, and of acceleration and jerk by axis, too; `controls/timing/uncertainty.py` has the usual ones."""

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


def within_limits(machine: Machine, limits: Limits) -> Machine:
    """The machine with limits that are computed: nobody is asked whether they are in another unit."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UnitWarning)
        return machine.with_limits(limits)


def off_the_path(moves: Commanded, machine: Machine, figures: ControlFigures) -> Floats:
    """(axes,) what a unit of each axis counts for beside the tolerance of the tip [m].

    A turn by its tolerance counts as much as that of the tip; of several in a program the least hold.
    """
    axis = moves.axis_tolerance[np.isfinite(moves.axis_tolerance)].min(initial=np.inf)
    turn = axis if np.isfinite(axis) else figures.axis_tolerance * DEGREE
    tip = moves.tolerance[np.isfinite(moves.tolerance) & (moves.tolerance > 0.0)].min(initial=np.inf)
    return np.where(machine.is_rotary, (tip if np.isfinite(tip) else figures.room) / turn, 1.0)
