"""CYCLE800: a swivelled plane, and the turn of the rotary axes."""

from __future__ import annotations

import math

from toolpace.common.units import DEGREE
from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.control.joint_moves import reference, turn_joints
from toolpace.programs.reading.control.retract import retract
from toolpace.programs.reading.control.tool_axis import plane_axis, turn_to_plane
from toolpace.programs.reading.coordinates import affine
from toolpace.programs.reading.coordinates.affine import IDENTITY, Matrix
from toolpace.programs.reading.sinumerik.cycles.direct_swivel import positions, turned_with_axes
from toolpace.programs.reading.sinumerik.frames import Frames
from toolpace.programs.reading.sinumerik.state import State
from toolpace.programs.reading.sinumerik.syntax.values import Unread, Value, ValueFault, solid
from toolpace.programs.reading.sinumerik.word_values import Arguments

SOLID, PROJECTION, DIRECT = 1, 2, 3
"""Kinds of swivelling in bits 7 and 6 of _MODE; 0: axis by axis."""
PLANES_BEYOND_XY = (2, 3)
"""Of the ones of _DMODE: G18 and G19."""


def swivel(values: list[Value | None], control: Control, frames: Frames, state: State) -> None:
    """CYCLE800(_FR,_TC,_ST,_MODE,_X0,_Y0,_Z0,_A,_B,_C,_X1,_Y1,_Z1,_DIR,_FR_I,_DMODE); without arguments: none."""
    arguments = Arguments("CYCLE800", values, 24)
    if not values or arguments.text(1) == "0":
        _put(frames, IDENTITY, tilted=False)
        return
    direct = arguments.code(3) >> 6 & 3 == DIRECT
    _check(arguments, state, direct=direct)
    wanted = positions(arguments, control) if direct else []
    made = affine.product(
        affine.product(
            affine.shift(_point(arguments, 4, state.unit)),
            turned_with_axes(wanted, control) if direct else _turned(arguments, control),
        ),
        affine.shift(_point(arguments, 10, state.unit)),
    )
    status = arguments.code(2)
    direction = arguments.code(13)
    if direction:
        _retract(arguments, control, state)
    if status % 10 == 1:
        made = affine.product(affine.product(affine.product(frames.plane, frames.tool), frames.programmed()), made)
    frames.clear()
    _put(frames, made, tilted=True)
    frames.plane_axis = plane_axis(control)
    if not direction:
        return
    follow = status // 10 % 10 == 1
    if direct and follow:
        control.straight([*control.words[:3], *wanted], 0, rapid=True)
    elif direct:
        turn_joints(control, wanted, rapid=True)
    else:
        control.findings.assumed(
            "CYCLE800: _DIR chooses the solution by the sign of the axis that tilts the tool or the table"
        )
        # "if one of the two positions cannot be reached for mechanical reasons, the alternative position is
        # automatically selected irrespective of the direction" (Operating Manual Milling 08/2018, "Swiveling plane")
        turn_to_plane(control, follow=follow, rapid=True, sign=int(math.copysign(1, direction)), else_other=True)
    frames.turned_to = control.placement.place(control.words)[3:]
    control.stop()


def _check(arguments: Arguments, state: State, *, direct: bool) -> None:
    """Unread where the cycle asks for more than a plane square to Z."""
    if arguments.code(15) % 10 in PLANES_BEYOND_XY or (state.plane and arguments.code(15) % 10 != 1):
        raise Unread("CYCLE800 under G18 or G19", "the tool stands along Y or X there: write G17")
    if arguments.code(13) not in (-1, 0, 1):
        raise ValueFault(f"CYCLE800 with _DIR {arguments.code(13)}: it is -1, 0 or 1")
    if arguments.code(2) // 100 % 10:
        raise Unread(f"CYCLE800 with _ST {arguments.code(2)}", "its hundreds align a tool: write 0 there")
    if direct and arguments.code(2) % 10 == 1:
        raise Unread("CYCLE800 with rotary axes given directly, upon another plane (_ST 1)", "write _ST 0")


def _put(frames: Frames, plane: Matrix, *, tilted: bool) -> None:
    frames.plane, frames.tilted = plane, tilted
    frames.tool, frames.tool_bound, frames.turned_to = IDENTITY, False, None
    frames.put()


def _point(arguments: Arguments, first: int, unit: float) -> list[float]:
    return [arguments.number(first + k) * unit for k in range(3)]


def _turned(arguments: Arguments, control: Control) -> Matrix:
    """The turns by _A, _B, _C: of the 1st, 2nd and 3rd, about the axes that _MODE names in its bits."""
    mode = arguments.code(3)
    kind = mode >> 6 & 3
    angles = [arguments.number(7 + k) * DEGREE for k in range(3)]
    if kind == SOLID:
        if angles[2]:
            raise Unread("CYCLE800 with a solid angle and a third one (_C)", "turn within the plane with AROT Z")
        return affine.turns((2, angles[0]), (1, angles[1]))
    named = [(mode >> shift & 3) - 1 for shift in (0, 2, 4)]
    if kind == PROJECTION:
        return _projected(named, angles, control)
    lost = [angle for axis, angle in zip(named, angles) if axis < 0 and angle]
    if lost:
        raise Unread(f"CYCLE800 with _MODE {mode}", "an angle has no axis there: write 57 for X, Y, Z")
    return affine.turns(*((axis, angle) for axis, angle in zip(named, angles) if axis >= 0))


def _projected(named: list[int], angles: list[float], control: Control) -> Matrix:
    """The plane by its angles in two planes of the coordinates, as ROTS has them, then turned about the third axis."""
    if sorted(named) != [0, 1, 2]:
        raise Unread(
            "CYCLE800 with projection angles whose axes _MODE does not name",
            "name all three in its bits, as 185 for X, Y, then Z, or write the plane axis by axis (_MODE 57)",
        )
    control.findings.assumed("CYCLE800 with projection angles turns as ROTS does, then about the third axis")
    pair = {"XYZ"[axis]: angle / DEGREE for axis, angle in zip(named[:2], angles)}
    return affine.product(solid(pair), affine.rotation(named[2], angles[2]))


def _retract(arguments: Arguments, control: Control, state: State) -> None:
    """_FR: 1 machine Z, 2 Z, then X and Y, 4 along the tool to the end of travel, 5 along the tool by _FR_I."""
    way = arguments.code(0)
    if way in (1, 2):
        control.findings.assumed("CYCLE800 retracts to the reference point: where it does is data of the machine")
        reference(control, 1, ["Z"])
        if way == 2:
            reference(control, 1, ["X", "Y"])
    elif way in (4, 5):
        distance = arguments.number(14) * state.unit
        if way == 5 and distance < 0.0:
            raise ValueFault("CYCLE800: _FR_I, the way of its retract, is below zero: correct it")
        retract(control, None if way == 4 else distance, rapid=True)
    elif way:
        raise Unread(f"CYCLE800 with _FR {way}", "it is 0, 1, 2, 4 or 5: correct it")
