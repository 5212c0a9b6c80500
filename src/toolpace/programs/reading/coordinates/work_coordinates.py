"""Placements of words in the machine or on the part, from machine zero, work offset, active frame and tool length."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.common.errors import UsageError
from toolpace.programs.reading.coordinates import affine
from toolpace.programs.reading.coordinates.affine import Matrix
from toolpace.programs.reading.coordinates.kinematics import Kinematics, Poses
from toolpace.programs.reading.coordinates.setup import Position, SetUp, offset_name

INSIDE = 1e-3
"""How far inside travel the stand-ins of machine coordinates end [m]: a smooth path swings about its points."""


@dataclass(frozen=True)
class Placement:
    """From the words of a program to a place: joints, or in tip mode the tip on the part."""

    tip_mode: bool = False
    matrix: Matrix = affine.IDENTITY
    """Of X, Y, Z, to linear joints, or to the tip [m]."""
    shift: tuple[float, ...] = ()
    """Added to the rotary words [rad]."""
    tool_length: float = 0.0
    """Of the tool whose tip is meant [m]: in tip mode the one that the control reckons with."""

    def place(self, words: list[float]) -> list[float]:
        """Words (3 + rotary) [m, rad] to the place that they mean."""
        turned = words[3:] if not self.shift else [a + b for a, b in zip(words[3:], self.shift)]
        if self.matrix is affine.IDENTITY:
            return [*words[:3], *turned]
        return [*affine.apply(self.matrix, words), *turned]

    def words(self, place: list[float]) -> list[float]:
        """The words of a place."""
        turned = place[3:] if not self.shift else [a - b for a, b in zip(place[3:], self.shift)]
        if self.matrix is affine.IDENTITY:
            return [*place[:3], *turned]
        return [*affine.apply(affine.inverse(self.matrix), place), *turned]


class Datum:
    """Machine coordinates, work offsets and tool lengths of a set-up sheet, or their stand-ins, in joints.

    Without a sheet the origin of the part is the origin of every work offset, the machine's zero and its reference
    point are next to the upper ends of travel, and every tool is as long as the machine's.
    """

    def __init__(self, poses: Poses, setup: SetUp) -> None:
        self.poses, self.setup = poses, setup
        machine = poses.machine
        self.own_length = 0.0 if machine is None else float(machine.tool_length)
        self.lift = np.array([0.0, 0.0, 1.0])
        """(3,) motion of the linear joints that moves the tip by 1 along the tool at zero rotary joints."""
        self.home = [0.0, 0.0, 0.0]
        """Linear joints at which the tip of the machine's own tool is in the origin of the part."""
        self.zero = [0.0] * (3 + len(poses.rotary))
        """Joint positions at which machine coordinates are zero."""
        if machine is not None and len(poses.linear) == 3:
            origin, columns, axis = poses.linear_map([0.0] * len(poses.rotary))
            self.lift = np.linalg.solve(columns, axis)
            self.home = np.linalg.solve(columns, -origin).tolist()
            ends = np.asarray(machine.travel)[list(poses.linear), 1]
            self.zero[:3] = np.where(np.isfinite(ends), ends - INSIDE, 0.0).tolist()
        self._set(self.zero, setup.machine_zero)

    def _set(self, values: list[float], position: Position) -> None:
        slots = self.poses.slots()
        for letter, value in position.items():
            if letter in slots:
                values[slots[letter]] = value

    def joints_of(self, coordinates: Position, present: list[float]) -> list[float]:
        """Joint positions of machine coordinates; of axes that are not given, the present ones."""
        wanted = list(present)
        slots = self.poses.slots()
        for letter, value in coordinates.items():
            wanted[slots[letter]] = self.zero[slots[letter]] + value
        return wanted

    def reference(self, number: int) -> dict[str, float]:
        """Machine coordinates of a reference point; of its stand-in where the sheet does not have it."""
        found: dict[str, float] = dict.fromkeys(self.poses.slots(), 0.0)
        # what is not on the sheet is the end of travel, wherever the machine's zero is
        ends = Datum(self.poses, SetUp()).zero if self.setup.machine_zero else self.zero
        for letter, slot in self.poses.slots().items():
            found[letter] = ends[slot] - self.zero[slot]
        return found | dict(self.setup.references.get(number, {}))

    def length(self, tool: str) -> float:
        """Length of a tool of the table [m]; of the machine's own where it has none.

        Where the program has named none, the only one of the table is in the spindle.
        """
        tools = self.setup.tools
        only = not tool and len(tools) == 1 and self.poses.machine is not None
        found = next(iter(tools.values())) if only else self.setup.tool(tool)
        return self.own_length if found is None or found.length is None else found.length

    def origin(self, offset: str) -> list[float]:
        """Joint positions (3 + rotary) at the origin of a work offset, with the machine's own tool."""
        position = self.setup.offsets.get(offset)
        values = [*self.home, *[0.0] * len(self.poses.rotary)]
        if position is not None:
            lift = self.own_length * self.lift
            for letter, slot in self.poses.slots().items():
                values[slot] = self.zero[slot] + position.get(letter, 0.0) + (lift[slot] if slot < 3 else 0.0)
        return values


def placement_of_offset(machine: Kinematics | None, setup: SetUp, name: str) -> Floats:
    """(4, 4) from the coordinates of a work offset to the frame of the part [m]: as a block of X, Y and Z means them
    while the rotary joints stand where the offset has them. Raises UsageError where the sheet lists others only."""
    name = offset_name(name)
    if setup.offsets and name not in setup.offsets:
        raise UsageError(
            f"{setup.source or 'set-up sheet'}: the work offset {name} is not among {', '.join(setup.offsets)}; list "
            f"[offsets.{name}]"
        )
    poses = Poses(machine)
    position = Datum(poses, setup).origin(name)
    at, columns, _ = poses.linear_map(position[3:])
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = columns, at + columns @ np.array(position[:3])
    return matrix


@dataclass
class Coordinates:
    """Offset, frame, mode and tool length in force."""

    datum: Datum
    turn: tuple[float, ...]
    """By what the program shifted its rotary words [rad]."""
    offset: str = ""
    """Name of the work offset; "" is its stand-in."""
    frame: Matrix = affine.IDENTITY
    """What the program itself shifted or turned, in the coordinates of the work offset."""
    tilted: bool = False
    """Whether the frame is a plane that the tool is turned to, fixed to the part."""
    tip_mode: bool = False
    fixed_at: list[float] | None = None
    """Rotary positions at which tip mode fixed the frame to the workpiece [rad]; None for zero."""
    length_of: str = ""
    """Tool whose length counts; "" is the one in the spindle."""
    compensated: bool = False
    """Whether the control reckons with that length."""
    off: bool = False
    """Whether the program ended the reckoning with a length (G49, D0), which tip mode may outlast."""
    oversize: float = 0.0
    """By how much longer than the table says the program calls the tool [m]."""
    programmed: tuple[float, float, float] | None = None
    """Offset of the tool that the program itself tells, in place of the table's: along X, Y, and its length [m]."""
    named_for: str | None = None
    """Tool that was in the spindle when the length was named; None where none was."""

    def tool_offset(self, tool: str) -> tuple[float, float, float]:
        """Along X, Y and Z [m], that the control reckons with."""
        if self.programmed is not None:
            return self.programmed
        return (0.0, 0.0, self.length(tool) if self.compensated else 0.0)

    def length(self, tool: str) -> float:
        """Of the tool that counts, as the program has it [m]."""
        if self.off and self.tip_mode:
            # as of words that are joints: the nose, or the machine's own tool where no sheet tells of offsets
            return 0.0 if self.datum.setup.offsets else self.datum.own_length
        return self.datum.length(self.length_of or tool) + self.oversize

    @property
    def reckons(self) -> bool:
        """Whether where the tip is depends on the length of a tool that is in no word of the program."""
        return (self.compensated or self.tip_mode or self.tilted) and self.programmed is None

    def placement(self, tool: str) -> Placement:
        """Of words, with a tool in the spindle."""
        length = self.length(tool) if self.programmed is None else self.programmed[2]
        if (self.tip_mode or self.tilted) and self.datum.poses.machine is not None:
            # a plane lies on the part already: tip mode that begins in it does not turn it again
            return self._on_part(length, None if self.tilted else self.fixed_at)
        # a length that was named for the tool before stays in force, but tells nothing of where the tip is
        another = (self.programmed is not None or self.length_of) and self.named_for != tool
        return self._of_joints(length, self.datum.length(tool) if another else length)

    def on_part(self) -> Placement:
        """Of words that would be the tip of the machine's own tool on the part."""
        own = self.datum.own_length
        return self._of_joints(own, own) if self.datum.poses.machine is None else self._on_part(own, None)

    def _of_joints(self, length: float, tool_length: float) -> Placement:
        """Of words that are joints, where the control reckons with a length; `tool_length` is that of the tool."""
        datum = self.datum
        origin = datum.origin(self.offset)
        without = -datum.own_length if datum.setup.offsets else 0.0
        reckoned = datum.lift * (length - datum.own_length if self.compensated else without)
        linear = [a + float(b) for a, b in zip(origin, reckoned)]
        if self.programmed is not None:
            linear = [linear[0] + self.programmed[0], linear[1] + self.programmed[1], linear[2]]
        matrix = affine.product(affine.shift(linear), self.frame) if any(linear) else self.frame
        return Placement(False, matrix, self._shift(origin), tool_length)

    def _on_part(self, length: float, fixed_at: list[float] | None) -> Placement:
        """In the coordinates of the work offset on the part, which carries them from where it stood when fixed."""
        poses, origin = self.datum.poses, self.datum.origin(self.offset)
        upright = [0.0] * len(poses.rotary)
        held = poses.carried(fixed_at) if fixed_at is not None and any(fixed_at) else upright
        at, columns, _ = poses.linear_map(held)
        _, zero, _ = poses.linear_map(upright)
        turn = columns @ np.linalg.inv(zero)
        matrix = affine.of_array(np.column_stack([turn, at + columns @ np.array(origin[:3])]))
        framed = matrix if self.frame is affine.IDENTITY else affine.product(matrix, self.frame)
        return Placement(True, framed, self._shift(origin), length)

    def _shift(self, origin: list[float]) -> tuple[float, ...]:
        shift = tuple(a + b for a, b in zip(origin[3:], self.turn))
        return shift if any(shift) else ()
