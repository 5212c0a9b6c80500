"""CYCLE800: a swivelled plane from angles or positions of the rotary axes, and the turn of the axes to it."""

from __future__ import annotations

import math

import numpy as np

from toolpace.common.units import DEGREE
from toolpace.programs.reading.arcs import ROUNDING
from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.control.machine_moves import plane_axis, reference, retract, turn_joints, turn_to_plane
from toolpace.programs.reading.coordinates import affine
from toolpace.programs.reading.coordinates.affine import IDENTITY, Matrix
from toolpace.programs.reading.expressions import BlockError
from toolpace.programs.reading.sinumerik.frames import Frames
from toolpace.programs.reading.sinumerik.orientation import along
from toolpace.programs.reading.sinumerik.state import State
from toolpace.programs.reading.sinumerik.syntax.values import Unread, Value, solid
from toolpace.programs.reading.sinumerik.word_values import Arguments

_ORDER = "the first rotary axis is the one that carries the other; with a head and a table, that of the head"
SOLID, PROJECTION, DIRECT = 1, 2, 3
"""Kinds of swivelling in bits 7 and 6 of _MODE; 0: axis by axis."""
PLANES_BEYOND_XY = (2, 3)
"""Of the ones of _DMODE: G18 and G19."""
_CURE = "let the CAM system write the plane axis by axis (_MODE 57)"


def in_order(control: Control) -> list[int]:
    """Columns among the rotary joints, the first axis first: the second stands upon it, and on machines with a head
    and a table the first is that of the head (Commissioning Manual, "CYCLE800 checklist"). Raises Unread.

    Rotary joints are stored from the part to the tool: in a table the one that carries the other comes last.
    """
    poses = control.poses
    if poses.machine is None or len(poses.rotary) != 2:
        raise Unread("rotary axes by their number", "give the machine (--machine NAME), one with two rotary axes")
    return [1, 0] if poses.carried([1.0, 0.0])[0] else [0, 1]


def initial_rotary(control: Control, arguments: Arguments) -> list[float]:
    """Rotary words [rad] of ORIRESET: positions of the machine in the order of its axes, zero where none is told."""
    wanted = [control.datum.zero[3 + k] for k in range(len(control.poses.rotary))]
    if any(arguments.number(place) for place in range(3)):
        order = in_order(control)
        carried = control.poses.carried([1.0, 1.0])
        if arguments.number(2) or carried[0] != carried[1]:
            raise Unread("ORIRESET with positions", "which axis is the first is not told: write A=, B= or C= with G0")
        control.findings.assumed(_ORDER)
        for place, column in enumerate(order):
            wanted[column] += arguments.number(place) * DEGREE
    shift = control.placement.shift or (0.0,) * len(wanted)
    return [a - b for a, b in zip(wanted, shift)]


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
        raise BlockError(f"CYCLE800 with _DIR {arguments.code(13)}: it is -1, 0 or 1")
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
            raise BlockError("CYCLE800: _FR_I, the way of its retract, is below zero: correct it")
        retract(control, None if way == 4 else distance, rapid=True)
    elif way:
        raise Unread(f"CYCLE800 with _FR {way}", "it is 0, 1, 2, 4 or 5: correct it")


def positions(arguments: Arguments, control: Control) -> list[float]:
    """Rotary words [rad] of _A and _B, the positions of the first and the second rotary axis. Raises Unread."""
    if control.placement.shift:
        raise Unread("CYCLE800 with rotary axes given directly, which an offset shifts", _CURE)
    if arguments.number(9):
        raise Unread("CYCLE800 with a third rotary axis given directly (_C)", _CURE)
    wanted = [0.0, 0.0]
    for place, column in enumerate(in_order(control)):
        wanted[column] = arguments.number(7 + place) * DEGREE
    return wanted


def turned_with_axes(rotary: list[float], control: Control) -> Matrix:
    """The turn of coordinates whose Z is the tool at rotary positions [rad], and whose X and Y are the machine's.

    "The tool axis is aligned in the Z direction. You can derive the resulting direction of the X and Y axis by
    traversing the axes" (Operating Manual Milling, "Swiveling plane"). A head keeps X and Y where it turns about an
    axis across the tool, as TOROT has them; else they are not told. Raises Unread.
    """
    poses = control.poses
    carried = poses.carried(rotary)
    table = poses.turn_of_part(carried)
    of_head = [k for k, (a, b) in enumerate(zip(rotary, carried)) if a != b]
    if not of_head:
        turn = table
    else:
        if len(of_head) > 1 or not _across_tool(control, of_head[0]):
            raise Unread("CYCLE800 with axes of a head given directly", f"X and Y there are not told: {_CURE}")
        direction = table.T @ np.array(poses.axis(rotary))
        turn = table @ np.array([row[:3] for row in along(direction.tolist())])
    control.findings.assumed(
        "CYCLE800 with rotary axes given directly (_MODE 192): X and Y of the plane are those of the machine there"
    )
    return IDENTITY if np.allclose(turn, np.eye(3), atol=1e-15) else affine.linear(turn.tolist())


def _across_tool(control: Control, joint: int) -> bool:
    """Whether a rotary joint of the head turns about an axis square to the tool: it carries the tool in a plane."""
    found = []
    for angle in (0.0, 0.7, 1.4):
        alone = [0.0] * len(control.poses.rotary)
        alone[joint] = angle
        found.append(control.poses.axis(alone))
    return abs(float(np.linalg.det(found))) < ROUNDING and math.dist(found[0], found[1]) > ROUNDING
