"""Placements of words in the machine or on the part, with machine zero and work offsets."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from toolpace.programs.reading.coordinates import affine
from toolpace.programs.reading.coordinates.affine import Matrix
from toolpace.programs.reading.coordinates.kinematics import Poses
from toolpace.programs.reading.coordinates.setup import Position, SetUp

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

    def _set(self, values: list[float], given: Position) -> None:
        slots = self.poses.slots()
        for letter, value in given.items():
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
        """Length of a tool of the table [m]; of the machine's own where there is none.

        Where the program has named none, the only one of the table is in the spindle.
        """
        tools = self.setup.tools
        only = not tool and len(tools) == 1 and self.poses.machine is not None
        found = next(iter(tools.values())) if only else self.setup.tool(tool)
        return self.own_length if found is None else found.length

    def origin(self, offset: str) -> list[float]:
        """Joint positions (3 + rotary) at the origin of a work offset, with the machine's own tool."""
        given = self.setup.offsets.get(offset)
        values = [*self.home, *[0.0] * len(self.poses.rotary)]
        if given is not None:
            lift = self.own_length * self.lift
            for letter, slot in self.poses.slots().items():
                values[slot] = self.zero[slot] + given.get(letter, 0.0) + (lift[slot] if slot < 3 else 0.0)
        return values
