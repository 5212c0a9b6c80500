"""The text of a machine file (TOML) to checked figures in SI units, and back.

Every figure is checked where it is read, so that an error can name file, joint and key.
"""

from __future__ import annotations

import math
import tomllib
from typing import Literal, TypeVar

import msgspec

from toolpace.errors import MachineError, did_you_mean

Vector = tuple[float, float, float]
Table = TypeVar("Table", bound=msgspec.Struct)

LENGTHS = {"m": 1.0, "mm": 1e-3, "in": 0.0254}
ANGLES = {"rad": 1.0, "deg": math.pi / 180.0}


class Units(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """What the figures of the file are in; seconds throughout."""

    length: Literal["m", "mm", "in"] = "m"
    angle: Literal["rad", "deg"] = "rad"


class ChainFile(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """The two joint chains; points and directions in the bed frame with every joint at zero."""

    workpiece: tuple[str, ...]
    tool: tuple[str, ...]
    spindle_nose: Vector
    tool_length: float
    workpiece_origin: Vector = (0.0, 0.0, 0.0)
    workpiece_x: Vector = (1.0, 0.0, 0.0)
    workpiece_z: Vector = (0.0, 0.0, 1.0)
    tool_axis: Vector = (0.0, 0.0, 1.0)


class JointFile(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """One joint."""

    kind: Literal["linear", "rotary"]
    direction: Vector
    velocity: float
    acceleration: float
    jerk: float
    point: Vector = (0.0, 0.0, 0.0)
    travel: tuple[float, float] | None = None
    wrap: bool = False


class MachineFile(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """All of a file, in SI units."""

    name: str
    chain: ChainFile
    joints: dict[str, JointFile]
    note: str = ""

    def __hash__(self) -> int:
        return hash((self.name, self.chain, tuple(self.joints.items()), self.note))


def read_machine(text: str, source: str) -> MachineFile:
    """Parse and check a machine file; `source` is its name for messages. Raises MachineError."""
    try:
        raw = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise MachineError(f"{source}: not a TOML file: {error}") from None
    _check_keys(raw, ("name", "note", "units", "chain", "joints"), ("name", "chain", "joints"), "", source)
    units = _convert(raw.get("units", {}), Units, "[units]", source)
    chain = _convert(raw["chain"], ChainFile, "[chain]", source)
    if not isinstance(raw["joints"], dict):
        raise MachineError(f"{source}: joints must be tables such as [joints.X]")
    joints = {name: _convert(value, JointFile, f"[joints.{name}]", source) for name, value in raw["joints"].items()}
    for key in ("name", "note"):
        if not isinstance(raw.get(key, ""), str):
            raise MachineError(f"{source}: {key} must be text in quotes")
    length, angle = LENGTHS[units.length], ANGLES[units.angle]
    chain = msgspec.structs.replace(
        chain,
        spindle_nose=_scaled(chain.spindle_nose, length),
        workpiece_origin=_scaled(chain.workpiece_origin, length),
        tool_length=chain.tool_length * length,
    )
    for key in ("spindle_nose", "workpiece_origin", "workpiece_x", "workpiece_z", "tool_axis"):
        if not all(map(math.isfinite, getattr(chain, key))):
            raise MachineError(f"{source}: [chain] {key} must be three finite numbers")
    if not math.isfinite(chain.tool_length):
        raise MachineError(f"{source}: [chain] tool_length must be a finite number")
    for name, joint in joints.items():
        _check_joint(name, joint, source, units)
        scale = length if joint.kind == "linear" else angle
        joints[name] = msgspec.structs.replace(
            joint,
            point=_scaled(joint.point, length),
            velocity=joint.velocity * scale,
            acceleration=joint.acceleration * scale,
            jerk=joint.jerk * scale,
            travel=None if joint.travel is None else (joint.travel[0] * scale, joint.travel[1] * scale),
        )
    return MachineFile(raw["name"], chain, joints, raw.get("note", ""))


def write_machine(machine: MachineFile) -> str:
    """The text of a machine file, in metres and radians, digits exact."""
    lines = [f"name = {_quoted(machine.name)}"]
    if machine.note:
        lines.append(f"note = {_quoted(machine.note)}")
    lines += ["", "[units]", 'length = "m"', 'angle = "rad"', "", "[chain]"]
    lines += [f"{key} = {_value(value)}" for key, value in msgspec.structs.asdict(machine.chain).items()]
    for name, joint in machine.joints.items():
        lines += ["", f"[joints.{name if name.isidentifier() and name.isascii() else _quoted(name)}]"]
        for key, value in msgspec.structs.asdict(joint).items():
            if value is None or (key == "wrap" and not value):
                continue
            lines.append(f"{key} = {_value(value)}")
    return "\n".join(lines) + "\n"


def _check_keys(
    raw: dict[str, object], known: tuple[str, ...], required: tuple[str, ...], place: str, source: str
) -> None:
    where = f"{place} " if place else ""
    for key in raw:
        if key not in known:
            raise MachineError(f"{source}: {where}unknown key '{key}'; {did_you_mean(key, known)}")
    for key in required:
        if key not in raw:
            raise MachineError(f"{source}: {where}'{key}' is missing; add it")


def _convert(raw: object, kind: type[Table], place: str, source: str) -> Table:
    if not isinstance(raw, dict):
        raise MachineError(f"{source}: {place} must be a table")
    fields = msgspec.structs.fields(kind)
    _check_keys(
        raw,
        tuple(field.name for field in fields),
        tuple(field.name for field in fields if field.required),
        place,
        source,
    )
    try:
        return msgspec.convert(raw, kind)
    except msgspec.ValidationError as error:
        message = str(error).replace(" - at `$.", ": key `").replace(" - at `$`", "")
        raise MachineError(f"{source}: {place} {message}") from None


def _check_joint(name: str, joint: JointFile, source: str, units: Units) -> None:
    place = f"{source}: joint {name}"
    unit = units.length if joint.kind == "linear" else units.angle
    for key, suffix in (("velocity", "/s"), ("acceleration", "/s^2"), ("jerk", "/s^3")):
        figure = getattr(joint, key)
        if not figure > 0.0:
            raise MachineError(f"{place}: {key} = {figure:g} {unit}{suffix}; give a number above zero")
    if not all(map(math.isfinite, joint.direction)) or math.hypot(*joint.direction) < 1e-9:
        raise MachineError(f"{place}: direction = {list(joint.direction)} is no direction; give e.g. [1, 0, 0]")
    if not all(map(math.isfinite, joint.point)):
        raise MachineError(f"{place}: point must be three finite numbers")
    if joint.wrap and joint.kind == "linear":
        raise MachineError(f"{place}: wrap = true is for rotary joints; give travel = [low, high] in {unit}")
    if joint.wrap and joint.travel is not None:
        raise MachineError(f"{place}: has both travel and wrap = true; keep one (wrap is for endless rotary joints)")
    if joint.travel is None and not joint.wrap:
        cure = "" if joint.kind == "linear" else " or, for an endless rotary joint, wrap = true"
        raise MachineError(f"{place}: travel is missing; give travel = [low, high] in {unit}{cure}")
    if joint.travel is not None and not joint.travel[0] < joint.travel[1]:
        raise MachineError(f"{place}: travel = {list(joint.travel)} {unit} is empty; give the lower end first")


def _scaled(vector: Vector, factor: float) -> Vector:
    return (vector[0] * factor, vector[1] * factor, vector[2] * factor)


def _quoted(text: str) -> str:
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n") + '"'


def _value(value: bool | str | float | tuple[str, ...] | tuple[float, ...]) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return _quoted(value)
    if isinstance(value, tuple):
        return "[" + ", ".join(_value(item) for item in value) + "]"
    return repr(float(value))
