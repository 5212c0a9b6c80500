"""A clamping of the part relative to the present one, and the branch of the inverse kinematics."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import msgspec
import numpy as np
import numpy.typing as npt

from toolpace.common.arrays import Floats, numbers
from toolpace.common.errors import ReachError
from toolpace.common.units import FARTHEST_PART, LONGEST_TOOL, METRES, RADIANS, format_length, refuse_other_unit
from toolpace.kernels.kinematics.geometry import A0, U1, U2
from toolpace.machine.geometry import Geometry
from toolpace.machine.machine import Machine, check_machine

WHOLE_TURN = 2.0 * math.pi + 1e-9
"""A turn, and what rounding may add [rad]."""
STILL = 1e-9
"""Turn [rad] and shift [m] below which the part has not moved."""
ROOM = math.radians(1.0)
"""Beyond the half circle, so that a smooth path may swing through the pole [rad]."""
NARROWEST = math.radians(2.5)
"""Travel that is worth a side of its own [rad]: less holds but what both sides share."""


@dataclass(frozen=True)
class Clamping:
    """The part turned about its own vertical, tilted by a fixture, the fixture turned on the table; then moved.

    From the way the part is clamped in the machine file, in the bed's frame with every joint at zero: about the centre
    of the program's points it is turned by `turn` about Z, then by `tilt` about X, then by `swing` about Z, and moved.
    """

    turn: float = 0.0
    """Of the part on the fixture [rad]."""
    tilt: float = 0.0
    """Of the fixture [rad]."""
    swing: float = 0.0
    """Of the fixture on the table [rad]."""
    shift: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """How far the centre of the program is moved [m]."""
    tool_length: float | None = None
    """From the spindle nose to the tip [m]; None: as in the machine file."""
    side: int = 0
    """1 or -1: one of both solutions of the inverse kinematics alone (see `with_side`); 0: whichever turns least."""

    def __post_init__(self) -> None:
        for name, angle in self.angles():
            refuse_other_unit(angle, WHOLE_TURN, f"clamping: {name}", RADIANS)
        for each in self.shift:
            refuse_other_unit(each, FARTHEST_PART, "clamping: shift", METRES)
        if self.tool_length is not None:
            refuse_other_unit(self.tool_length, LONGEST_TOOL, "clamping: tool_length", METRES)

    def on(self, machine: Machine, centre: npt.ArrayLike) -> Machine:
        """The machine with the part clamped so; `centre` (3,) is that of the program, in the part's frame [m].

        Raises ToolpaceError where the machine cannot be as it is asked for.
        """
        check_machine(machine, "clamping")
        middle = numbers(centre, "clamping: centre", (3,), unit="m")
        chain = machine.file.chain
        if not self.leaves_part:
            present = orientation(chain.workpiece_x, chain.workpiece_z)
            turned = self.rotation @ present
            origin = np.array(chain.workpiece_origin) + present @ middle + np.array(self.shift) - turned @ middle
            machine = machine.mounted(_vector(origin), _vector(turned[:, 0]), _vector(turned[:, 2]))
        if self.tool_length is not None and self.tool_length != chain.tool_length:
            machine = machine.with_tool(self.tool_length)
        return with_side(machine, self.side)

    @property
    def rotation(self) -> Floats:
        """(3, 3) by which the part is turned, in the bed's frame."""
        return _about_z(self.swing) @ _about_x(self.tilt) @ _about_z(self.turn)

    @property
    def leaves_part(self) -> bool:
        """Whether the part stays where it is."""
        turned = np.abs(self.rotation - np.eye(3)).max()
        return bool(turned < STILL and max(map(abs, self.shift)) < STILL)

    @property
    def effort(self) -> tuple[int, float]:
        """What it asks for beyond what is there: how many things differ, and how far it is moved [m]."""
        turns = sum(abs(angle) > STILL for _, angle in self.angles())
        return turns + (self.side != 0) + (self.tool_length is not None), math.hypot(*self.shift)

    def words(self, machine: Machine) -> str:
        """In words, for people."""
        parts = [f"{name} {_degrees(angle)}" for name, angle in self.angles() if abs(angle) > STILL]
        if max(map(abs, self.shift)) > STILL:
            parts.append("moved by " + ", ".join(f"{each * 1e3:.4g}" for each in self.shift) + " mm")
        if self.tool_length is not None and self.tool_length != machine.tool_length:
            parts.append(f"tool {format_length(self.tool_length)}")
        if self.side:
            parts.append(f"{machine.geometry.rotary_joints[1]} on side {self.side:+d}")
        return ", ".join(parts) or "as given"

    def angles(self) -> tuple[tuple[str, float], ...]:
        """Names and angles of the three turns [rad]."""
        return ("turn", self.turn), ("tilt", self.tilt), ("swing", self.swing)


AS_GIVEN = Clamping()


def orientation(x: tuple[float, float, float], z: tuple[float, float, float]) -> Floats:
    """(3, 3) columns x, y, z of the part's frame in the bed's, of its two directions."""
    first, third = np.array(x) / np.linalg.norm(x), np.array(z) / np.linalg.norm(z)
    first = first - (first @ third) * third
    first /= np.linalg.norm(first)
    return np.column_stack([first, np.cross(third, first), third])


def _about_z(angle: float) -> Floats:
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def _about_x(angle: float) -> Floats:
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])


def _vector(values: Floats) -> tuple[float, float, float]:
    """Rounded to 1e-12 [m]: a set-up sheet shows zeros as zeros."""
    x, y, z = (round(float(each), 12) + 0.0 for each in values)
    return x, y, z


def _degrees(angle: float) -> str:
    return f"{math.degrees(angle):.4g} deg"


def with_side(machine: Machine, side: int) -> Machine:
    """The machine with the travel of its second rotary joint narrowed to one side, 1 or -1; 0: as it is.

    Raises ReachError where its travel has nothing of that side.
    """
    if side == 0:
        return machine
    name = machine.geometry.rotary_joints[1]
    joint = machine.file.joints[name]
    low, high = half_circle(machine.geometry, side)
    if joint.travel is not None:
        low, high = max(low, joint.travel[0]), min(high, joint.travel[1])
    if high - low < NARROWEST:
        raise ReachError(f"machine {machine.name}: joint {name} has no travel on side {side:+d}; take the other side")
    narrowed = msgspec.structs.replace(joint, travel=(low, high), wrap=False)
    joints = {**machine.file.joints, name: narrowed}
    return replace(machine, file=msgspec.structs.replace(machine.file, joints=joints))


def half_circle(geometry: Geometry, side: int) -> tuple[float, float]:
    """Positions [rad] of the second rotary joint above (1) or below (-1) the zero next to the middle of its travel."""
    frame = geometry.frame
    across = np.cross(frame[U1], frame[U2])
    # (R2 a0) . across = a cos + b sin
    a, b = float(frame[A0] @ across), float(np.cross(frame[U2], frame[A0]) @ across)
    zero = math.atan2(-a, b)
    low, high = geometry.travel[geometry.rotary[1]]
    middle = 0.5 * (low + high) if math.isfinite(low) and math.isfinite(high) else 0.0
    zero += math.pi * round((middle - zero) / math.pi)
    return (zero - ROOM, zero + math.pi + ROOM) if side > 0 else (zero - math.pi - ROOM, zero + ROOM)
