"""The figures of four makers' controls that their own parameters hold, with defaults from the makers' manuals.

What no manual tells is marked (assumption). Feeds are in mm/min, times in seconds, lengths in mm, as in the manuals.
"""

from __future__ import annotations

from typing import Annotated, Literal

import msgspec

Share = Annotated[float, msgspec.Meta(ge=0.0, le=0.95)]
Factor = Annotated[float, msgspec.Meta(ge=0.01, le=100.0)]
Time = Annotated[float, msgspec.Meta(ge=0.0, le=10.0)]
Figure = Annotated[float, msgspec.Meta(ge=0.0, le=1e9)]


class SinumerikFigures(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Machine data of a Sinumerik (Function Manual Basic Functions, B1 and B2)."""

    soft_acceleration: Factor = 1.0
    """MD32433 SOFT_ACCEL_FACTOR: share of the acceleration with SOFT."""
    rapid_acceleration: Factor = 1.0
    """MD32434 G00_ACCEL_FACTOR."""
    rapid_jerk: Factor = 1.0
    """MD32435 G00_JERK_FACTOR."""
    overload: Annotated[float, msgspec.Meta(ge=1.0, le=100.0)] = 1.2
    """MD32310 MAX_ACCEL_OVL_FACTOR; 1.2 (Function Manual 802D sl, B1, 3.4)."""
    cycle: Annotated[float, msgspec.Meta(gt=0.0, le=0.1)] = 0.004
    """Cycle of the interpolator [s] (assumption: it differs by control)."""
    curve_share: Share = 0.0
    """MD20602 CURV_EFFECT_ON_PATH_ACCEL: share of the acceleration that is for the direction across the path, the rest
    is for that along it; 0: both have all of it (assumption)."""
    transition_jerk: Factor = 1.0
    """MD32432 PATH_TRANS_JERK_LIM over MD32431 MAX_AX_JERK."""
    jerk_finish: Factor = 1.0
    """Jerk under DYNFINISH over that of the machine's file (MD32431 has a value for each such word; assumption: all are
    alike)."""
    jerk_semifinish: Factor = 1.0
    """Under DYNSEMIFIN."""
    jerk_rough: Factor = 1.0
    """Under DYNROUGH."""
    jerk_precise: Factor = 1.0
    """Under DYNPREC."""
    jerk_position: Factor = 1.0
    """Under DYNPOS."""
    brisk: Annotated[float, msgspec.Meta(ge=0.0, le=1.0)] = 0.0
    """1: the program begins with BRISK; 0: with SOFT (assumption: MD20150 sets it, and CYCLE832 switches SOFT on)."""


class HeidenhainFigures(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Machine parameters of a Heidenhain control (Technical Manual MANUALplus 620, CfgLaPath and CfgLaAxis)."""

    path_jerk: Figure = 40.0
    """maxPathJerk [m/s^3], default 40 (page 829)."""
    path_jerk_rapid: Figure = 40.0
    """maxPathJerkHi [m/s^3], default 40 (page 829)."""
    axis_jerk_rapid: Factor = 5.0
    """axPathJerkHi over axPathJerk: "typically five times" (page 834)."""
    least_corner_feed: Figure = 30.0
    """minCornerFeed [mm/min], default 30 (page 502)."""
    least_path_feed: Figure = 60.0
    """minPathFeed [mm/min], default 60 (page 502)."""
    filter_time: Time = 0.0
    """Length of the triangle filter [s]; 0: 2 (6 E / j)^(1/3), with the tolerance E and the least jerk j of a linear
    axis: the length at which corners are fastest, and slower for neither tolerance nor jerk alone (assumption)."""


class FanucFigures(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Parameters of a Fanuc (specifications A-63512EN of AI contour control, A-78962EN of AI nano contour control)."""

    corner_difference: Figure = 500.0
    """1783, permissible difference of feed of a linear axis at a corner [mm/min]; 500 as in the manual's example
    (A-63512EN, page 5); 0: corners do not slow down."""
    corner_difference_rotary: Figure = 500.0
    """The same of a rotary axis [deg/min] (assumption: as of the linear ones)."""
    arc_acceleration: Factor = 1.0
    """1735 over the axis' acceleration: in circles."""
    curve_acceleration: Factor = 1.0
    """1737 over the axis' acceleration: between lines."""
    arc_least_feed: Figure = 0.0
    """1732, below which arcs do not slow down [mm/min]."""
    acceleration_change: Figure = 0.0
    """1788, permissible change of acceleration [mm/s^2]; 0: there is no jerk control, which is an option."""
    acceleration_change_lines: Figure = 0.0
    """1789, the same between lines; 0: that of 1788."""
    bell_time: Time = 0.0
    """1772, time in which the acceleration builds up [s]; 0: what the axes' jerk limits say (assumption)."""
    after_interpolation: Time = 0.0
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
