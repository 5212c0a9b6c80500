"""The figures of a cutting tool's shape: cutting part, shank and holder, as a set-up sheet or a program tells them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, get_args

ToolKind = Literal["flat", "bull", "ball", "taper", "barrel", "drill", "chamfer", "face"]
KINDS: tuple[ToolKind, ...] = get_args(ToolKind)


@dataclass(frozen=True)
class Frustum:
    """A piece of a shank or a holder: a cone, or a cylinder where both diameters are the same."""

    length: float
    """Along the axis [m]."""
    lower_diameter: float
    """At the end towards the tip [m]."""
    upper_diameter: float
    """[m]"""


@dataclass(frozen=True)
class ToolFigures:
    """A solid of revolution about the tool axis, from the tip upwards; what is not known is None."""

    kind: ToolKind
    diameter: float
    """Of the cutting part where it is widest; of `taper` and `chamfer` at the lower end of the cone where `taper` is
    above zero [m]."""
    corner_radius: float = 0.0
    """Of `bull`; half of the diameter of `ball`; of the tip of `barrel` and `taper` [m]."""
    taper: float = 0.0
    """Angle between the cone's side and the axis [rad], of `taper`, `chamfer` and tapered balls."""
    point_angle: float = 0.0
    """Full angle of the point of `drill` and `chamfer` [rad]; 0: none, the tip is flat."""
    barrel_radius: float = math.inf
    """Of the arc of the side of `barrel` (also of a lens at its end) [m]."""
    flute_length: float | None = None
    """How far from the tip the edge reaches [m]; None: to the end of what sticks out."""
    teeth: int | None = None
    pitch: tuple[float, ...] = ()
    """Angles between the teeth [rad], their sum a full turn; empty where they are even."""
    helix: float = 0.0
    """[rad]; above zero where the tool is right-handed."""
    runout: float = 0.0
    """How far the tool's axis is from the spindle's [m]: half of what a dial gauge shows."""
    stick_out: float | None = None
    """From the holder to the tip [m]; None: no holder is known."""
    shank_diameter: float | None = None
    """Above the flutes [m]; None: as the cutting part's."""
    shank: tuple[Frustum, ...] = ()
    """From the end of the flutes upwards, where one diameter does not tell it."""
    holder: tuple[Frustum, ...] = ()
    """From the end of the stick-out upwards."""
    material: str = ""
    """Of the tool (carbide, HSS)."""
    spindle_speed: float | None = None
    """Turns per second [1/s], where the sheet tells it in place of the program."""
    clockwise: bool = True
    """Seen from the spindle, as M3 turns it."""
    source: str = ""
    """Where the figures are from: the sheet and its table, or the line of the program."""
    assumed: tuple[str, ...] = ()
    """Figures that stand in for what nobody told, a sentence each."""
