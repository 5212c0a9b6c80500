"""What a program has said about its coordinates, and the placement of its words that comes of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from toolpace.arrays import Floats
from toolpace.reading.coordinates import affine
from toolpace.reading.coordinates.affine import Matrix
from toolpace.reading.coordinates.placement import Datum, Placement


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
    oversize: float = 0.0
    """By how much longer than the table says the program calls the tool [m]."""
    told: tuple[float, float, float] | None = None
    """Offset of the tool that the program itself tells, in place of the table's: along X, Y, and its length [m]."""

    def tool_offset(self, tool: str) -> tuple[float, float, float]:
        """Along X, Y and Z [m], that the control reckons with."""
        if self.told is not None:
            return self.told
        return (0.0, 0.0, self.length(tool) if self.compensated else 0.0)

    def length(self, tool: str) -> float:
        """Of the tool that counts, as the program has it [m]."""
        return self.datum.length(self.length_of or tool) + self.oversize

    def placement(self, tool: str) -> Placement:
        """Of words, with a tool in the spindle."""
        length = self.length(tool) if self.told is None else self.told[2]
        longer = length - self.datum.own_length
        if (self.tip_mode or self.tilted) and self.datum.poses.machine is not None:
            return self._on_part(longer, self.fixed_at)
        return self._of_joints(longer)

    def on_part(self) -> Placement:
        """Of words that would be the tip of the machine's own tool on the part."""
        return self._of_joints(0.0) if self.datum.poses.machine is None else self._on_part(0.0, None)

    def _of_joints(self, longer: float) -> Placement:
        datum = self.datum
        origin = datum.origin(self.offset)
        without = -datum.own_length if datum.setup.offsets else 0.0
        reckoned = datum.lift * (longer if self.compensated else without)
        linear = [a + float(b) for a, b in zip(origin, reckoned)]
        if self.told is not None:
            linear = [linear[0] + self.told[0], linear[1] + self.told[1], linear[2]]
        matrix = affine.product(affine.shift(linear), self.frame) if any(linear) else self.frame
        return Placement(False, matrix, self._shift(origin), longer)

    def _on_part(self, longer: float, fixed_at: list[float] | None) -> Placement:
        """In the coordinates of the work offset on the part, which carries them from where it stood when fixed."""
        poses, origin = self.datum.poses, self.datum.origin(self.offset)
        upright = [0.0] * len(poses.rotary)
        held = poses.carried(fixed_at) if fixed_at is not None and any(fixed_at) else upright
        at, columns, _ = poses.linear_map(held)
        _, zero, _ = poses.linear_map(upright)
        turn = columns @ np.linalg.inv(zero)
        matrix = _clean(np.column_stack([turn, at + columns @ np.array(origin[:3])]))
        framed = matrix if self.frame is affine.IDENTITY else affine.product(matrix, self.frame)
        return Placement(True, framed, self._shift(origin), longer)

    def _shift(self, origin: list[float]) -> tuple[float, ...]:
        shift = tuple(a + b for a, b in zip(origin[3:], self.turn))
        return shift if any(shift) else ()


def _clean(matrix: Floats) -> Matrix:
    """The matrix (3, 4) without the roundings of kinematics, which would tilt straight lines."""
    whole = np.round(matrix)
    near = np.abs(matrix - whole) < np.array([1e-13, 1e-13, 1e-13, 1e-15])
    a, b, c = np.where(near, whole, matrix).tolist()
    cleaned: Matrix = (tuple(a), tuple(b), tuple(c))
    return affine.IDENTITY if cleaned == affine.IDENTITY else cleaned
