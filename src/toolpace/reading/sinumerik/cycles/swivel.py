"""CYCLE800: swivel a plane, which is a frame and, unless _DIR is 0, a turn of the rotary axes."""

from __future__ import annotations

import math

from toolpace.reading.control.control import Control
from toolpace.reading.control.joint_moves import reference
from toolpace.reading.control.retract import retract
from toolpace.reading.control.tool_axis import turn_to_plane
from toolpace.reading.coordinates import affine
from toolpace.reading.coordinates.affine import IDENTITY, Matrix
from toolpace.reading.sinumerik.frames import Frames
from toolpace.reading.sinumerik.given import Arguments
from toolpace.reading.sinumerik.state import State
from toolpace.reading.sinumerik.syntax.values import Unread, Value
from toolpace.units import DEGREE

SOLID, PROJECTION, DIRECT = 1, 2, 3
"""Kinds of swivelling in bits 7 and 6 of _MODE; 0: axis by axis."""
_CURE = "it needs data of the machine: let the CAM system write the plane axis by axis (_MODE 57)"


def swivel(values: list[Value | None], control: Control, frames: Frames, state: State) -> None:
    """CYCLE800(_FR,_TC,_ST,_MODE,_X0,_Y0,_Z0,_A,_B,_C,_X1,_Y1,_Z1,_DIR,_FR_I,_DMODE); without arguments: none."""
    arguments = Arguments("CYCLE800", values, 24)
    if not values or arguments.text(1) == "0":
        _put(frames, IDENTITY, tilted=False)
        return
    made = affine.product(
        affine.product(affine.shift(_point(arguments, 4, state.unit)), _turned(arguments)),
        affine.shift(_point(arguments, 10, state.unit)),
    )
    status = arguments.code(2)
    direction = arguments.code(13)
    if direction:
        _retract(arguments, control, state)
    if status % 10 == 1:
        made = affine.product(affine.product(frames.plane, frames.programmed()), made)
    frames.clear()
    _put(frames, made, tilted=True)
    if direction:
        control.findings.assumed(
            "CYCLE800: _DIR chooses the solution by the sign of the axis that tilts the tool or the table"
        )
        turn_to_plane(control, follow=status // 10 % 10 == 1, rapid=True, sign=int(math.copysign(1, direction)))
        control.stop()


def _put(frames: Frames, plane: Matrix, *, tilted: bool) -> None:
    frames.plane, frames.tilted = plane, tilted
    frames.put()


def _point(arguments: Arguments, first: int, unit: float) -> list[float]:
    return [arguments.number(first + k) * unit for k in range(3)]


def _turned(arguments: Arguments) -> Matrix:
    """The turns by _A, _B, _C: of the 1st, 2nd and 3rd, about the axes that _MODE names in its bits."""
    mode = arguments.code(3)
    kind = mode >> 6 & 3
    angles = [arguments.number(7 + k) * DEGREE for k in range(3)]
    if kind == SOLID:
        return affine.turns((2, angles[0]), (1, angles[1]))
    if kind in (PROJECTION, DIRECT):
        name = "projection angles" if kind == PROJECTION else "rotary axes given directly"
        raise Unread(f"CYCLE800 with {name} (_MODE {mode})", _CURE)
    named = [mode >> shift & 3 for shift in (0, 2, 4)]
    steps = [(axis - 1, angle) for axis, angle in zip(named, angles) if axis]
    lost = [angle for axis, angle in zip(named, angles) if not axis and angle]
    if lost:
        raise Unread(f"CYCLE800 with _MODE {mode}", "an angle has no axis there: write 57 for X, Y, Z")
    return affine.turns(*steps)


def _retract(arguments: Arguments, control: Control, state: State) -> None:
    """_FR: 1 machine Z, 2 Z, then X and Y, 4 along the tool to the end of travel, 5 along the tool by _FR_I."""
    way = arguments.code(0)
    if way in (1, 2):
        control.findings.assumed("CYCLE800 retracts to the reference point: where it does is data of the machine")
        reference(control, 1, ["Z"])
        if way == 2:
            reference(control, 1, ["X", "Y"])
    elif way in (4, 5):
        retract(control, None if way == 4 else abs(arguments.number(14)) * state.unit, rapid=True)
    elif way:
        raise Unread(f"CYCLE800 with _FR {way}", "it is 0, 1, 2, 4 or 5: correct it")
