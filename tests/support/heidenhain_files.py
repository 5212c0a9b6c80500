"""Machine parameters, kinematics tables and configuration objects of machines, as a Heidenhain control keeps them.

Written from the definitions of its manuals: a walk from the tool's reference point to the workpiece, in which a
positive command moves what was before an axis against what comes after it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from toolpace.common.units import DEGREE, MILLIMETRE
from toolpace.machine.machine import Machine

UNIT = dict(zip("XYZABC", np.vstack([np.eye(3), np.eye(3)])))


def _turned(letter: str, angle: float, vector: np.ndarray) -> np.ndarray:
    """A vector turned about X, Y or Z by an angle [deg] (Rodrigues' formula)."""
    axis, radians = UNIT[letter], math.radians(angle)
    along = (axis @ vector) * axis
    return along + math.cos(radians) * (vector - along) + math.sin(radians) * np.cross(axis, vector)


def _turn_to(letter: str, direction: np.ndarray) -> tuple[str, float] | None:
    """The turn about A, B or C that brings an axis from its letter to a direction; None where it is there."""
    unit = direction / np.linalg.norm(direction)
    if np.abs(unit - UNIT[letter]).max() < 1e-12:
        return None
    for about in "ABC":
        for angle in (45.0, -45.0, 90.0, -90.0, 180.0, 135.0, -135.0):
            if np.abs(_turned(about, angle, UNIT[letter]) - unit).max() < 1e-12:
                return about, angle
    raise AssertionError(f"{letter} along {unit}")


def walk(machine: Machine) -> Iterator[tuple[str, str, float | None]]:
    """Rows of the kinematics: key, axis, coordinate [mm or deg]."""
    joints, chain = machine.file.joints, machine.file.chain
    yield "ToolAxis", "XYZ"[int(np.argmax(chain.tool_axis))], None
    here = np.array(chain.spindle_nose) / MILLIMETRE
    sides = [(name, 1.0) for name in reversed(chain.tool)] + [("", 0.0)] + [(name, -1.0) for name in chain.workpiece]
    for name, side in sides:
        if not name:
            yield "MachBase", "", None
            continue
        joint = joints[name]
        if joint.kind == "rotary":
            there = np.array(joint.point) / MILLIMETRE
            yield from (("Trans", axis, step) for axis, step in zip("XYZ", there - here) if step)
            here = there
        turn = _turn_to(name, side * np.array(joint.direction))
        if turn is not None:
            yield "Trans", *turn
        yield "MachAxis", name, None
        if turn is not None:
            yield "Trans", turn[0], -turn[1]


def table_text(machine: Machine) -> str:
    """A kinematics table of the iTNC."""
    lines = ["BEGIN KINEMATIC.TAB MM", "NR   KEY        AXIS COORD          MPFILE"]
    for number, (key, axis, coordinate) in enumerate(walk(machine)):
        cell = "" if coordinate is None else repr(float(coordinate))
        lines.append(f"{number:<4} {key:<10} {axis:<4} {cell}".rstrip())
    return "\n".join([*lines, "[END]"]) + "\n"


def _limits(machine: Machine) -> Iterator[tuple[str, dict[str, float], bool]]:
    """By axis: rapid traverse, acceleration, jerk and limits in the control's units, and whether it has an end."""
    for name, joint in machine.file.joints.items():
        unit, large = (DEGREE, 1000.0 * DEGREE) if joint.kind == "rotary" else (MILLIMETRE, 1.0)
        low, high = joint.travel or (0.0, 0.0)
        yield name, {
            "rapidFeed": joint.velocity / unit * 60.0,
            "maxAcceleration": joint.acceleration / large,
            "axPathJerk": joint.jerk / large,
            "swLimitSwitchPos": high / unit,
            "swLimitSwitchNeg": low / unit,
        }, joint.travel is not None


def parameters_text(machine: Machine, changes: dict[str, str | None] | None = None) -> str:
    """Machine parameters of the iTNC; changes: values by name, None leaves one out."""
    numbers = {"rapidFeed": 1010, "maxAcceleration": 1060, "axPathJerk": 1085, "swLimitSwitchPos": 910,
               "swLimitSwitchNeg": 920}  # fmt: skip
    values = {"MP10": "%11111", "MP100": "".join(reversed(list(machine.file.joints)))}
    for index, (_, figures, _) in enumerate(_limits(machine)):
        values |= {f"MP{numbers[key]}.{index}": repr(figure) for key, figure in figures.items()}
    values |= {"MP1090.0": "60", "MP1090.1": "90", "MP1092": "20000"}
    values |= changes or {}
    return "".join(f"{name} : {text} ; comment\n" for name, text in values.items() if text is not None)


def axis_objects(machine: Machine) -> list[str]:
    """Configuration objects of the axes and the path."""
    lines = ["-- configuration (* not a comment in one line *)", "(* axes,", "   CfgFeedLimits( key:=\"X\" *)"]
    for name, figures, ends in _limits(machine):
        limits = {key: figure for key, figure in figures.items() if key.startswith("sw")}
        others = {key: figure for key, figure in figures.items() if key not in limits}
        text = ",\n   ".join(f"{key}:={figure!r}" for key, figure in others.items())
        lines.append(f'CfgFeedLimits (\n   key:="P{name}1",\n   {text})')
        text = ", ".join(f"{key}:={figure!r}" for key, figure in limits.items())
        modulo = f'CfgAxis( key:="{name}", isModulo:=TRUE )'
        lines.append(f'CfgPositionLimits( key:="P{name}1", {text} )' if ends else modulo)
    lines.append('CfgLaPath( key:="", minPathFeed:=60.0, minCornerFeed:=25.0, maxPathJerk:=70, maxPathJerkHi:=100 )')
    return lines


def objects_text(machine: Machine) -> str:
    """Configuration objects of the TNC 640, with a kinematic model of two subkinematics."""
    lines = axis_objects(machine)
    parts: dict[str, list[str]] = {"K_TOOL": [], "K_TABLE": []}
    part = "K_TOOL"
    for number, (key, axis, coordinate) in enumerate(walk(machine)):
        if key == "ToolAxis":
            continue
        part = "K_TABLE" if key == "MachBase" else part
        name = f"{key}_{axis}_{number}" if key != "MachBase" else "Mach_BASE"
        parts[part].append(name)
        if key == "MachBase":
            lines.append(f'CfgKinAnchor( key:="{name}" )')
        elif key == "MachAxis":
            lines.append(f'CfgKinSimpleAxis( key:="{name}", axisRef:="{axis}", dir:={axis} )')
        else:
            lines.append(f'CfgKinSimpleTrans( key:="{name}", dir:={axis}, val:={float(coordinate or 0.0)!r} )')
    for name, objects in parts.items():
        listed = ", ".join(f'"{each}"' for each in objects)
        lines.append(f'CfgKinList( key:="{name}", kinObjects:=[{listed}] )')
    lines.append('CfgKinComposModel( key:="M1", subKinList:=["K_TOOL",\n  "K_TABLE"], tiltingAllowed:=TRUE )')
    return "\n".join(lines) + "\n"


def vectors_text(machine: Machine) -> str:
    """Configuration objects with a kinematic model of coordinate systems, each in the one before (CfgKinModel).

    Z of a system is the way in which the tool goes, or against that of the workpiece; X is any direction across.
    """
    joints, chain = machine.file.joints, machine.file.chain
    chance = np.random.default_rng(3)
    lines, lists = axis_objects(machine), {}
    ends = {
        "Tool": (chain.tool, 1.0, "toolCoordSys", chain.spindle_nose, chain.tool_axis),
        "Wp": (chain.workpiece, -1.0, "machineTableSys", (0.0, 0.0, 0.0), chain.workpiece_z),
    }
    for side, (names, sense, end, place, direction) in ends.items():
        frame, origin, keys = np.eye(3), np.zeros(3), []
        systems = [(name, sense * np.array(joints[name].direction), joints[name].point) for name in names]
        for name, along, point in [*systems, (end, np.array(direction), place)]:
            z = along / np.linalg.norm(along)
            x = np.cross(z, chance.normal(size=3) if name != end else np.cross(chain.workpiece_x, z))
            x = x / np.linalg.norm(x)
            there = np.array(point) / MILLIMETRE if point is not None else origin
            parts = {"location": frame.T @ (there - origin), "zDir": 2.0 * frame.T @ z, "xDir": frame.T @ x}
            cells = ", ".join(f"{key}:=[{', '.join(map(repr, part.tolist()))}]" for key, part in parts.items())
            keys.append(f"T_{side}_{name}")
            lines.append(f'CfgTrafoByDir( key:="{keys[-1]}", {cells} )')
            frame, origin = np.column_stack([x, np.cross(z, x), z]), there
        axes = ", ".join(f'"P{name}1"' for name in names)
        lists |= {f"axes{side}Side": f"[{axes}]", f"trafo{side}Side": str(keys[:-1]).replace("'", '"')}
        lists[end] = f'"{keys[-1]}"'
    attributes = ", ".join(f"{key}:={text}" for key, text in lists.items())
    return "\n".join([*lines, f'CfgKinModel( key:="K1", {attributes} )']) + "\n"
