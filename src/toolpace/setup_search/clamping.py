"""One clamping of the part, relative to the clamping as given."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from toolpace.common.arrays import Floats, numbers
from toolpace.common.units import FARTHEST_PART, LONGEST_TOOL, METRES, RADIANS, format_length, refuse_other_unit
from toolpace.machine.machine import Machine, check_machine
from toolpace.setup_search.rotary_branch import with_side

WHOLE_TURN = 2.0 * math.pi + 1e-9
STILL = 1e-9
"""Turn [rad] and shift [m] below which the part has not moved."""


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
            given = orientation(chain.workpiece_x, chain.workpiece_z)
            turned = self.rotation @ given
            origin = np.array(chain.workpiece_origin) + given @ middle + np.array(self.shift) - turned @ middle
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
