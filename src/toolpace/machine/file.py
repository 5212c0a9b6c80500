"""Checked figures in SI units from a machine file (TOML); machine/file_writer.py writes it.

Every figure is checked where it is read, so that an error can name file, joint and key.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Literal, TypeVar, get_args, get_origin

import msgspec

from toolpace.common.errors import MachineError, UsageError, did_you_mean
from toolpace.common.files.toml import TableFile
from toolpace.common.units import JOINT_LIMITS, parse_joint_limit
from toolpace.machine.curves_file import check_speeds, curved_limits, motor_curve
from toolpace.machine.limit_curves import CurvedLimit, LimitCurve
from toolpace.machine.limits import KINDS
from toolpace.machine.plausibility import (
    LONGEST_NOTE,
    ask_about,
    check_body,
    check_chain,
    check_joint,
    check_mass,
    check_name,
    check_place,
    check_rating,
    check_text,
    check_viscous_friction,
)

Vector = tuple[float, float, float]
Table = TypeVar("Table", bound=msgspec.Struct)

FILE = TableFile("machine file", longest=100_000, error=MachineError)
"""One has about 1500 characters."""
LENGTHS = {"m": 1.0, "mm": 1e-3, "in": 0.0254}
GRAVITY = (0.0, 0.0, -9.80665)
"""Of a machine whose z points upwards [m/s^2]."""
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
    gravity: Vector = GRAVITY
    """[m/s^2] whatever the units of the file."""


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
    force: float | None = None
    """Most of a linear joint's motor [N], at any speed; None where it is not held."""
    torque: float | None = None
    """Most of a rotary joint's motor, at the joint [N m]."""
    force_continuous: float | None = None
    """Most of its root mean square over the thermal window [N]."""
    torque_continuous: float | None = None
    """The same of a rotary joint's motor [N m]."""
    thermal_window: float = math.inf
    """Time over which the mean square is taken [s]; inf: the whole motion."""
    mass: float = 0.0
    """Of what the joint moves, without what is moved by joints on it [kg]."""
    centre: Vector = (0.0, 0.0, 0.0)
    """Of that mass."""
    inertia: tuple[float, ...] = (0.0, 0.0, 0.0)
    """About that centre [kg m^2]: xx, yy, zz, and xy, xz, yz where they are not zero."""
    rotor_inertia: float = 0.0
    """Of the motor, as the joint feels it [kg m^2; of a linear joint kg]."""
    viscous_friction: float = 0.0
    """[N m s/rad, N s/m]"""
    dry_friction: float = 0.0
    """[N m, N]"""
    balance: float = 0.0
    """Torque or force of a counterweight, forwards [N m, N]."""

    curves: tuple[Any, ...] = ()
    """The limits that fall with its speed, as CurvedLimit [m or rad, s]: of those keys that are more than a number, in
    place of which the least value stands."""

    motor_curve: Any = None
    """The motor's limit over the speed of the joint, as LimitCurve [m/s and N, rad/s and N m], where it is more than a
    number: its least value stands in `force` or `torque`."""

    @property
    def motor(self) -> LimitCurve | None:
        """The limit of the motor's torque or force over the speed of the joint; None where there is none."""
        limit = self.force if self.kind == "linear" else self.torque
        if limit is None or math.isinf(limit):
            return None
        curve: LimitCurve = self.motor_curve or LimitCurve([[0.0, limit]])
        return curve

    @property
    def continuous(self) -> float | None:
        """The motor's continuous rating [N m, N]; None where there is none."""
        return self.force_continuous if self.kind == "linear" else self.torque_continuous


class WorkpieceFile(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """The part with its fixture, which the last joint of the workpiece's chain carries; as in `JointFile`."""

    mass: float
    centre: Vector = (0.0, 0.0, 0.0)
    inertia: tuple[float, ...] = (0.0, 0.0, 0.0)


class MachineFile(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """All of a file, in SI units."""

    name: str
    chain: ChainFile
    joints: dict[str, JointFile]
    note: str = ""
    setup: dict[str, Any] = {}
    """The set-up sheet in the file, as it stands there but for its units, which are named: for reading alone."""
    workpiece: WorkpieceFile | None = None
    """Its mass; None where it has none."""

    def __hash__(self) -> int:
        return hash((self.name, self.chain, tuple(self.joints.items()), self.note))


def read_machine(text: str, source: str) -> MachineFile:
    """Parse and check a machine file; `source` is its name for messages. Raises MachineError."""
    raw = FILE.table(text, source, parse_float=_finite)
    keys = ("name", "note", "columns", "units", "chain", "joints", "workpiece", "setup")
    _check_keys(raw, keys, ("name", "chain", "joints"), "", source)
    units = _convert(raw.get("units", {}), Units, "[units]", source)
    chain = _convert(raw["chain"], ChainFile, "[chain]", source)
    if not isinstance(raw["joints"], dict):
        raise MachineError(f"{source}: joints must be tables such as [joints.X]")
    for name in raw["joints"]:
        check_name(name, "the name of a joint", source)
    length, angle = LENGTHS[units.length], ANGLES[units.angle]
    written = {name: _with_units(value, f"{source}: joint {name}") for name, value in raw["joints"].items()}
    curves, motors, joints = {}, {}, {}
    for name, value in raw["joints"].items():
        value, curves[name] = curved_limits(value, name, (length, angle), f"{source}: joint {name}")
        value, motors[name] = motor_curve(value, (length, angle), f"{source}: joint {name}")
        plain = _in_file_units(value, written[name], length, angle)
        joints[name] = _convert(plain, JointFile, f"[joints.{name}]", source)
    for key in ("name", "note"):
        if not isinstance(raw.get(key, ""), str):
            raise MachineError(f"{source}: {key} must be text in quotes")
    check_name(raw["name"], "name", source)
    check_text(raw.get("note", ""), "note", source, LONGEST_NOTE)
    chain = msgspec.structs.replace(
        chain,
        spindle_nose=_scaled(chain.spindle_nose, length),
        workpiece_origin=_scaled(chain.workpiece_origin, length),
        tool_length=chain.tool_length * length,
    )
    check_chain(chain, source)
    for name, joint in joints.items():
        scale = length if joint.kind == "linear" else angle
        place = f"{source}: joint {name}"
        unit = units.length if joint.kind == "linear" else units.angle
        for figures in (joint, _with_largest(joint, curves[name], scale))[: 1 + bool(curves[name])]:
            check_joint(figures, place, unit, scale)
            ask_about(figures, place, unit, scale)
        velocity = written[name].get("velocity", joint.velocity * scale)
        check_speeds(curves[name], velocity, place, (unit, scale))
        check_place(_scaled(joint.point, length), "point", place)
        if joint.kind == "rotary" and "point" not in raw["joints"][name]:
            raise MachineError(
                f"{place}: point is missing; a rotary joint needs a point on its axis, in the frame of the bed with "
                "every joint at zero, like point = [0, 0, 0]"
            )
        check_body(joint, place)
        motor = motors[name] or joint.motor
        check_rating(joint, motor, place)
        check_viscous_friction(joint.viscous_friction, motor, velocity, place)
        joints[name] = msgspec.structs.replace(
            joint,
            point=_scaled(joint.point, length),
            centre=_scaled(joint.centre, length),
            **{key: written[name].get(key, getattr(joint, key) * scale) for key in KINDS},
            travel=None if joint.travel is None else (joint.travel[0] * scale, joint.travel[1] * scale),
            curves=tuple(curves[name]),
            motor_curve=motors[name],
        )
    workpiece = _workpiece(raw.get("workpiece"), length, source)
    in_order = _in_columns(raw.get("columns"), joints, source)
    setup = _setup(raw.get("setup", {}), units, source)
    return MachineFile(raw["name"], chain, in_order, raw.get("note", ""), setup, workpiece)


def _workpiece(table: object, length: float, source: str) -> WorkpieceFile | None:
    """The mass of the part."""
    if table is None:
        return None
    part = _convert(table, WorkpieceFile, "[workpiece]", source)
    check_mass(part, f"{source}: [workpiece]")
    return msgspec.structs.replace(part, centre=_scaled(part.centre, length))


def _with_largest(joint: JointFile, curves: Sequence[CurvedLimit], scale: float) -> JointFile:
    """The joint with the largest values of its curves, in the unit of the file."""
    return msgspec.structs.replace(joint, **{curve.kind: curve.largest / scale for curve in curves})


def _with_units(raw: object, place: str) -> dict[str, float]:
    """The limits of a joint that are written with their unit, "42 m/min" [m or rad, s]."""
    if not isinstance(raw, dict) or raw.get("kind") not in JOINT_LIMITS:
        return {}
    found = {}
    for key in KINDS:
        if isinstance(raw.get(key), str):
            try:
                found[key] = parse_joint_limit(raw[key], raw["kind"], key)
            except UsageError as error:
                raise MachineError(f"{place}: {key}: {error}") from None
    return found


def _in_file_units(raw: object, written: dict[str, float], length: float, angle: float) -> object:
    """A joint's table with all limits as numbers in the units of the file."""
    if not written or not isinstance(raw, dict):
        return raw
    scale = length if raw["kind"] == "linear" else angle
    return raw | {key: value / scale for key, value in written.items()}


def _setup(table: object, units: Units, source: str) -> dict[str, Any]:
    """The set-up sheet in a machine file, in the units of the file unless it names its own."""
    if not isinstance(table, dict):
        raise MachineError(f"{source}: setup must be a table; write it under headings like [setup.offsets.G54]")
    own = table.get("units", {})
    named = {**msgspec.structs.asdict(units), **own} if isinstance(own, dict) else own
    return {**table, "units": named} if table else {}


def _in_columns(columns: object, joints: dict[str, JointFile], source: str) -> dict[str, JointFile]:
    """The joints in the order in which positions are listed; without `columns` that of their tables."""
    if columns is None:
        return joints
    if not isinstance(columns, list) or sorted(map(str, columns)) != sorted(joints):
        names = ", ".join(f'"{name}"' for name in joints)
        raise MachineError(f"{source}: columns must name each joint once, in the order to list them: [{names}]")
    return {str(name): joints[str(name)] for name in columns}


def _finite(text: str) -> float:
    """A number of the file; `inf` says that nothing limits, but a number that is too large to be one does not."""
    value = float(text)
    if math.isinf(value) and "inf" not in text:
        raise ValueError(f"number {text[:20]} is too large; correct it, or write inf")
    return value


def _check_keys(
    raw: dict[str, object], keys: tuple[str, ...], required: tuple[str, ...], place: str, source: str
) -> None:
    where = f"{place} " if place else ""
    for key in raw:
        if key not in keys:
            raise MachineError(f"{source}: {where}unknown key '{key[:40]}'; {did_you_mean(key, keys)}")
    for key in required:
        if key not in raw:
            raise MachineError(f"{source}: {where}'{key}' is missing; add it")


def _convert(raw: object, kind: type[Table], place: str, source: str) -> Table:
    if not isinstance(raw, dict):
        raise MachineError(f"{source}: {place} must be a table")
    fields = [field for field in msgspec.structs.fields(kind) if field.name not in ("curves", "motor_curve")]
    _check_keys(
        raw,
        tuple(field.name for field in fields),
        tuple(field.name for field in fields if field.required),
        place,
        source,
    )
    try:
        return msgspec.convert(raw, kind)
    except OverflowError:
        raise MachineError(f"{source}: {place} has a number that no machine has; check its digits") from None
    except msgspec.ValidationError as error:
        if "Invalid enum value" in str(error):
            raise MachineError(f"{source}: {place} {_not_among(raw, kind)}") from None
        message = str(error).replace(" - at `$.", ": key `").replace(" - at `$`", "")
        raise MachineError(f"{source}: {place} {message}") from None


def _scaled(vector: Vector, factor: float) -> Vector:
    return (vector[0] * factor, vector[1] * factor, vector[2] * factor)


def _not_among(raw: dict[str, object], kind: type[msgspec.Struct]) -> str:
    """Which value is none of those that there are, and what these are."""
    for field in msgspec.structs.fields(kind):
        values, value = get_args(field.type), raw.get(field.name)
        if get_origin(field.type) is Literal and field.name in raw and value not in values:
            hint = ""
            if field.name == "angle" and str(value).lower() in ("rpm", "rev", "turn", "turns"):
                hint = '; a velocity may have a unit of its own: velocity = "10 rpm"'
            return f"{field.name} = '{str(value)[:40]}' is not known; {did_you_mean(str(value), values)}{hint}"
    return "has a value that is not known"
