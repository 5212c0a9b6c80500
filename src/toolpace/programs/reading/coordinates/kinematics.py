"""The machine as a reader sees it: positions as tip or as joints."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Protocol, SupportsIndex

import numpy as np

from toolpace.common.arrays import Bools, Floats


class Kinematics(Protocol):
    """The part of a machine that reading needs."""

    @property
    def name(self) -> str:
        """For messages."""

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of the joints, in the order of the columns of q."""

    @property
    def rotary(self) -> Iterable[SupportsIndex]:
        """Indices of the rotary joints, in the order of the columns of ToolPath.rotary."""

    @property
    def travel(self) -> Floats:
        """(m, 2) lowest and highest position of the joints [m, rad]; infinite where one turns without end."""

    @property
    def tool_length(self) -> float:
        """From the spindle nose to the tip that `forward` speaks of [m]."""

    def forward(self, q: Floats, /) -> tuple[Floats, Floats]:
        """Tip (n, 3) [m] and tool axis (n, 3) in the workpiece frame, of joints q (n, joints) [m, rad]."""

    def rotary_solutions(self, axis: Floats, /) -> tuple[Floats, Bools]:
        """Both rotary positions (n, 2, 2) [rad] of tool axes (n, 3), nan without; and where the first one is free."""


class Poses:
    """Turns positions (n, 3 + rotary) [m, rad] into tip and tool axis, by the mode they are meant in.

    Positions are joints, or, in tip mode, the tip and the rotary joints.
    """

    def __init__(self, machine: Kinematics | None) -> None:
        self.machine = machine
        self.joints: tuple[str, ...] = () if machine is None else tuple(machine.joints)
        self.rotary: tuple[int, ...] = () if machine is None else tuple(int(i) for i in machine.rotary)
        self.rotary_names = tuple(self.joints[i] for i in self.rotary)
        names = tuple(name.upper() for name in self.joints)
        self.linear: tuple[int, ...] = tuple(names.index(x) for x in "XYZ" if x in names)
        """Indices of joints X, Y, Z; shorter where the machine lacks one."""

    def slots(self) -> dict[str, int]:
        """Column of each axis letter in a position."""
        letters = {"X": 0, "Y": 1, "Z": 2}
        return letters | {name.upper(): 3 + k for k, name in enumerate(self.rotary_names) if len(name) == 1}

    def place(self, position: Floats, tip_mode: Bools, tool_length: Floats | None = None) -> tuple[Floats, Floats]:
        """Tip (n, 3) and tool axis (n, 3) of tools of lengths (n,) [m]; of the machine's own where none are given.

        Without a machine the axis is +z, both modes mean the same, and the spindle nose stands for the tip.
        """
        if self.machine is None:
            axis = np.zeros((len(position), 3))
            axis[:, 2] = 1.0
            return position[:, :3].copy(), axis
        q = np.zeros((len(position), len(self.joints)))
        for column, joint in enumerate(self.rotary):
            q[:, joint] = position[:, 3 + column]
        if not tip_mode.all():
            # In tip mode the linear joints stay zero: the tool axis does not depend on them.
            for column, joint in enumerate(self.linear):
                q[:, joint] = np.where(tip_mode, 0.0, position[:, column])
        tip, axis = self.machine.forward(q)
        axis = axis / np.linalg.norm(axis, axis=1, keepdims=True)
        if tool_length is not None:
            tip = tip - (tool_length - float(self.machine.tool_length))[:, None] * axis
        return np.where(tip_mode[:, None], position[:, :3], tip), axis

    def axis(self, rotary: list[float]) -> list[float]:
        """The tool axis (3,) at rotary positions [rad]."""
        _, axis = self.place(np.array([[0.0, 0.0, 0.0, *rotary]]), np.array([True]))
        return list(map(float, axis[0]))

    def to_tip(self, position: list[float], tool_length: float) -> list[float]:
        """The same place of the machine, with the tip of a tool of this length [m] for the linear joints."""
        tip, _ = self.place(np.array([position]), np.array([False]), np.array([tool_length]))
        return [*tip[0].tolist(), *position[3:]]

    def to_joints(self, position: list[float], tool_length: float) -> list[float]:
        """The same place of the machine, with the linear joints for the tip of such a tool."""
        if self.machine is None:
            return list(position)
        origin, columns, axis = self.linear_map(position[3:])
        tip = np.array(position[:3]) + (tool_length - float(self.machine.tool_length)) * axis
        return [*np.linalg.solve(columns, tip - origin).tolist(), *position[3:]]

    def linear_map(self, rotary: list[float]) -> tuple[Floats, Floats, Floats]:
        """Tip = origin (3,) + columns (3, 3) @ linear joints at held rotary joints; and the tool axis (3,) there.

        With the rotary joints held the tip is linear in the linear joints: four places give the system.
        """
        probe = np.zeros((4, 3 + len(rotary)))
        probe[1:, :3] = np.eye(3)
        probe[:, 3:] = rotary
        tip, axis = self.place(probe, np.zeros(4, dtype=bool))
        return tip[0], (tip[1:] - tip[0]).T, axis[0]

    def carried(self, rotary: list[float]) -> list[float]:
        """The rotary positions of the joints that carry the workpiece; those of the joints of the head are zero."""
        _, zero, _ = self.linear_map([0.0] * len(rotary))
        kept = []
        for k, angle in enumerate(rotary):
            alone = [0.5 if i == k else 0.0 for i in range(len(rotary))]
            kept.append(0.0 if np.allclose(self.linear_map(alone)[1], zero, atol=1e-12) else angle)
        return kept
