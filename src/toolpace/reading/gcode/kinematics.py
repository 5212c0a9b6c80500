"""What reading asks of a machine, and positions seen in both ways a program can mean them: tip or joints."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Protocol, SupportsIndex

import numpy as np

from toolpace.arrays import Bools, Floats


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

    def forward(self, q: Floats, /) -> tuple[Floats, Floats]:
        """Tip (n, 3) [m] and tool axis (n, 3) in the workpiece frame, of joints q (n, joints) [m, rad]."""


class Frame:
    """Turns program positions (n, 3 + rotary) [m, rad] into tip and tool axis, by the mode they were written in."""

    def __init__(self, machine: Kinematics | None) -> None:
        self.machine = machine
        self.joints: tuple[str, ...] = () if machine is None else tuple(machine.joints)
        self.rotary: tuple[int, ...] = () if machine is None else tuple(int(i) for i in machine.rotary)
        self.rotary_names = tuple(self.joints[i] for i in self.rotary)
        names = tuple(name.upper() for name in self.joints)
        self.linear: tuple[int, ...] = tuple(names.index(x) for x in "XYZ" if x in names)
        """Indices of joints X, Y, Z; shorter where the machine lacks one."""

    def slots(self) -> dict[str, int]:
        """Column of each axis letter in a program position."""
        letters = {"X": 0, "Y": 1, "Z": 2}
        return letters | {name.upper(): 3 + k for k, name in enumerate(self.rotary_names) if len(name) == 1}

    def place(self, position: Floats, tip_mode: Bools) -> tuple[Floats, Floats]:
        """Tip (n, 3) and tool axis (n, 3); without a machine the axis is +z and both modes mean the same."""
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
        tip = np.where(tip_mode[:, None], position[:, :3], tip)
        return tip, axis / np.linalg.norm(axis, axis=1, keepdims=True)

    def to_tip(self, position: list[float]) -> list[float]:
        """The same place of the machine, with the tip instead of the linear joints."""
        tip, _ = self.place(np.array([position]), np.array([False]))
        return [*tip[0].tolist(), *position[3:]]

    def to_joints(self, position: list[float]) -> list[float]:
        """The same place of the machine, with the linear joints instead of the tip.

        With the rotary joints held the tip is linear in the linear joints: four places give the system.
        """
        if self.machine is None:
            return list(position)
        probe = np.tile(np.array(position), (4, 1))
        probe[:, :3] = np.vstack([np.zeros(3), np.eye(3)])
        tip, _ = self.place(probe, np.zeros(4, dtype=bool))
        joints = np.linalg.solve((tip[1:] - tip[0]).T, np.array(position[:3]) - tip[0])
        return [*joints.tolist(), *position[3:]]
