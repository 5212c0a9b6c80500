"""The chain of a machine from the walk along a Heidenhain's kinematics.

A positive command moves or turns what is before an axis, with the tool, by the right-hand rule as what is behind it
sees it; an axis that carries the workpiece goes against its letter.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.machine.from_control.control_file import ControlFileError
from toolpace.machine.from_control.heidenhain.walk import LINEAR, TURNING, Step
from toolpace.machine.from_control.record import Figure, MachineRecord, Origin
from toolpace.machine.from_control.unplaced_axes import with_held_axes

ROUNDING = 15
"""Decimals that are kept of directions and points [mm]: turns by right angles leave crumbs."""


def place_by_steps(steps: Sequence[Step], record: MachineRecord) -> None:
    """Fill in [chain], and direction and point of all joints. Raises ControlFileError.

    An axis that is there twice, or that the machine does not have, is refused with its lines.
    """
    used = _used(steps, record)
    turns, base = _walk(steps)
    frame = turns[base][0]
    tool, workpiece = _sides(used, base)
    for step, index in used:
        orientation, point, origins = turns[index]
        side = -1.0 if step in workpiece else 1.0
        direction = side * step.sense * frame.T @ orientation[:, _column(step.axis)]
        record.joints[step.axis]["direction"] = Figure(_rounded(direction), (step.origin,))
        if step.axis in TURNING:
            record.joints[step.axis]["point"] = Figure(_rounded(frame.T @ point), (*origins, step.origin))
    turning = "".join(sorted(step.axis for step, _ in used if step.axis in TURNING))
    names = ["".join(step.axis for step in side) for side in (workpiece, reversed(tool))]
    names[0], names[1] = with_held_axes(record, turning, *names)
    origins = tuple(step.origin for step, _ in used)
    record.chain["workpiece"] = Figure(tuple(names[0]), origins)
    record.chain["tool"] = Figure(tuple(names[1]), origins)
    record.chain["spindle_nose"] = Figure((0.0, 0.0, 0.0), (Origin("the tool's reference point is at X, Y, Z"),))
    record.chain["tool_length"] = Figure(0.0, (Origin("tools have their lengths in the set-up sheet"),))
    _orient(steps, turns, base, record)


def _orient(
    steps: Sequence[Step], turns: Sequence[tuple[Floats, Floats, tuple[Origin, ...]]], base: int, record: MachineRecord
) -> None:
    """Directions of tool and workpiece, where the walk turns their coordinate systems against that of the base."""
    frame = turns[base][0]
    axis = next((step for step in steps if step.kind == "toolaxis"), None)
    if axis is not None and axis.axis not in LINEAR:
        raise axis.origin.error(f"has the axis '{axis.axis[:20]}'; X, Y or Z can be read")
    column = 2 if axis is None else _column(axis.axis)
    origin = Origin("the tool points along Z (assumption)") if axis is None else axis.origin
    record.chain["tool_axis"] = Figure(_rounded(frame.T @ np.eye(3)[:, column]), (origin,))
    end, _, origins = turns[-1]
    if np.abs(frame.T @ end - np.eye(3)).max() > 1e-12:
        record.chain["workpiece_x"] = Figure(_rounded(frame.T @ end[:, 0]), origins)
        record.chain["workpiece_z"] = Figure(_rounded(frame.T @ end[:, 2]), origins)


def _used(steps: Sequence[Step], record: MachineRecord) -> list[tuple[Step, int]]:
    """The axes of the walk that are joints, with their place in it."""
    used: list[tuple[Step, int]] = []
    for index, step in enumerate(steps):
        if step.kind != "machaxis":
            continue
        other = next((each for each, _ in used if each.axis == step.axis), None)
        if other is not None:
            raise step.origin.error(f"is there twice, as {other.origin}; remove one of both lines")
        if step.axis not in LINEAR + TURNING or not step.axis:
            record.remarks.append(f"The axis {step.axis or 'without a letter'} ({step.origin}) rests at zero.")
            continue
        if step.axis not in record.joints:
            names = ", ".join(record.joints)
            raise step.origin.error(f"moves {step.axis}, which is none of the axes {names}; correct it")
        used.append((step, index))
    letters = [step.axis for step, _ in used]
    place = steps[-1].origin if steps else None
    for letter in LINEAR:
        if letter not in letters:
            message = f"the kinematics have no axis {letter}; a machine here has X, Y and Z"
            raise ControlFileError(message, file=place.file if place else record.files[0])
    turning = [step for step, _ in used if step.axis in TURNING]
    if len(turning) > 2:
        raise turning[2].origin.error(
            f"is the third turning axis beside {turning[0].origin} and {turning[1].origin}; a machine here has two"
        )
    return used


def _sides(used: Sequence[tuple[Step, int]], base: int) -> tuple[list[Step], list[Step]]:
    """Axes from the tool to the base, and from the base to the workpiece."""
    return [step for step, index in used if index < base], [step for step, index in used if index >= base]


def _walk(steps: Sequence[Step]) -> tuple[list[tuple[Floats, Floats, tuple[Origin, ...]]], int]:
    """Coordinate system at each step and at the end, columns in that of the tool; and the step at which the base is.

    Each is an orientation (3, 3), an origin (3,) [mm] and the lines that moved it. Without MachBase the base is behind
    the last linear axis, which makes no difference to the motion.
    """
    orientation, point = np.eye(3), np.zeros(3)
    origins: tuple[Origin, ...] = ()
    found, turns = -1, []
    for index, step in enumerate(steps):
        turns.append((orientation, point, origins))
        if step.kind == "machbase":
            found = index
        elif step.kind == "trans":
            assert step.value is not None
            if step.axis in LINEAR and step.axis:
                point = point + step.value.number * orientation[:, _column(step.axis)]
            elif step.axis in TURNING and step.axis:
                orientation = orientation @ _turn(_column(step.axis), math.radians(step.value.number))
            else:
                raise step.origin.error(f"has the axis '{step.axis[:20]}'; X, Y, Z, A, B or C can be read")
            origins = (*origins, step.origin)
    turns.append((orientation, point, origins))
    if found < 0:
        linear = [index for index, step in enumerate(steps) if step.kind == "machaxis" and step.axis in LINEAR]
        found = linear[-1] + 1 if linear else 0
    return turns, found


def _column(axis: str) -> int:
    """0, 1 or 2: the axis of the coordinate system along or about which an axis goes."""
    return (LINEAR + TURNING).index(axis) % 3


def _turn(column: int, angle: float) -> Floats:
    """(3, 3) right-handed turn about an axis of the coordinate system."""
    first, second = (column + 1) % 3, (column + 2) % 3
    turn = np.eye(3)
    turn[first, first] = turn[second, second] = math.cos(angle)
    turn[second, first], turn[first, second] = math.sin(angle), -math.sin(angle)
    return turn


def _rounded(vector: Floats) -> tuple[float, ...]:
    return tuple(round(float(part), ROUNDING) + 0.0 for part in vector)
