"""The state of a Klartext program beside the virtual control."""

from __future__ import annotations

from dataclasses import dataclass, field

from toolpace.common.units import MILLIMETRE
from toolpace.programs.reading.arcs import Arc
from toolpace.programs.reading.coordinates.work_coordinates import Placement

PLANES = ("YZ", "ZX", "XY")
"""Planes by the tool axis X, Y, Z: the angle is 0 along their first axis."""
OF_AXIS = ((1, 2), (2, 0), (0, 1))
"""First and second axis of the plane across each axis."""


@dataclass
class State:
    """Modes, as they stand at a block."""

    unit: float = MILLIMETRE
    """Of lengths [m]."""
    feed_unit: float = MILLIMETRE
    """Of F [m]."""
    tool_axis: int = 2
    """X, Y or Z: arcs, drilling and turns are across it."""
    shortest: bool = False
    """Whether rotary axes go the shorter way (M126)."""
    per_revolution: bool = False
    """Whether F is a length a turn (M136)."""
    spatial: bool = False
    """Whether A, B, C are spatial angles (FUNCTION TCPM AXIS SPAT)."""
    spatial_angles: list[float | None] = field(default_factory=lambda: [None] * 3)
    """A, B, C of the last block under AXIS SPAT [rad]; None where none has told it."""
    tip_mode: bool = False
    """Whether M128 or FUNCTION TCPM is on."""
    tool_feed: float | None = None
    """F of TOOL CALL, which FAUTO means."""
    centre: float = 0.0
    """How far above its tip the point of the tool is that X, Y, Z name [m]: REFPNT CENTER-CENTER."""
    oversize: bool = False
    """Whether the tool was called with DL, DR or DR2 that is not zero."""
    path_is_contour: bool = False
    """Whether LN is the surface itself, which the control then leaves by the radii of the tool (FUNCTION PROG PATH)."""
    calls_everywhere: bool = False
    """Whether each positioning block calls the cycle (M89)."""
    side: str = "R0"
    """R0, RL or RR."""
    looks_ahead: int = 0
    """LA of M120: elements within which the control leaves out loops of a compensated way."""
    beside: set[int] = field(default_factory=set)
    """Columns of axes that stand the tool's radius beside the program's coordinate, behind R+ and R-."""
    radius_oversize: float = 0.0
    """DR of TOOL CALL [m]."""
    pole: list[float] = field(default_factory=lambda: [0.0, 0.0, 0.0])
    """CC, in the program's coordinates [m]."""
    pole_across: int | None = None
    """The axis across which the plane of the last CC lies, where its two coordinates tell; None: the tool axis."""
    pole_is_set: bool = False
    pole_in: Placement | None = None
    """The coordinates in which CC told it."""
    polar_end: list[float] = field(default_factory=list)
    """In its plane, where the last polar block ended, and its pole [m]; empty where there was none."""
    pole_in_space: bool = False
    """Whether a CC has named the coordinate along the tool axis too, as NX does for arcs across another axis."""
    came_from: list[float] = field(default_factory=list)
    """Words before the last motion; empty where there was none."""
    came_by: Arc | None = None
    """The arc of the last motion."""
    ended: bool = False
    """Whether M2, M30 or the end of the main program was reached."""
