"""The machine as a reader sees it: positions as tip or as joints, and rotary positions for a tool axis."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Protocol, SupportsIndex

import numpy as np

from toolpace.common.arrays import Bools, Floats

TURN = 2.0 * math.pi
"""Of a rotary joint [rad]."""
FREE = 1e-6
"""Angle to the pole within which the first rotary joint stays where it is [rad]."""


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

    def turn_of_part(self, rotary: list[float]) -> Floats:
        """Rotation (3, 3) of the part at rotary positions [rad], from where it stands with all of them at zero."""
        _, columns, _ = self.linear_map(rotary)
        _, zero, _ = self.linear_map([0.0] * len(rotary))
        turned: Floats = columns @ np.linalg.inv(zero)
        return turned

    def carried(self, rotary: list[float]) -> list[float]:
        """The rotary positions of the joints that carry the workpiece; those of the joints of the head are zero."""
        _, zero, _ = self.linear_map([0.0] * len(rotary))
        kept = []
        for k, angle in enumerate(rotary):
            alone = [0.5 if i == k else 0.0 for i in range(len(rotary))]
            kept.append(0.0 if np.allclose(self.linear_map(alone)[1], zero, atol=1e-12) else angle)
        return kept


class Orientation:
    """Tool axes to rotary positions, the nearest to where the joints are."""

    def __init__(self, poses: Poses) -> None:
        self.poses = poses
        machine = poses.machine
        self.travel: list[list[float]] = (
            [] if machine is None else np.asarray(machine.travel, dtype=float)[list(poses.rotary)].tolist()
        )
        """Lowest and highest position of each rotary joint [rad]."""
        self.alike: list[float] = []
        """The other rotary positions of the last search [rad], where the rule of a control decides for neither."""

    def rotary(
        self,
        axis: list[float],
        present: list[float],
        sign: int = 0,
        first: tuple[int, int] | None = None,
        *,
        else_other: bool = False,
    ) -> tuple[list[float], str]:
        """Rotary positions [rad] for a tool axis (3,) on the part, and what is wrong, or "".

        Of both solutions, and all turns within travel, the one with the least sum of turns. `sign`: only those with
        the second rotary joint below (-1) or above (1) zero, `else_other`: where none of these is within travel, the
        other one. `first`: the joints in the order in which each turns as little as it can, and where that decides
        nothing comes near to zero.
        """
        machine = self.poses.machine
        if machine is None:
            return [], "a tool vector needs the machine: give --machine NAME (machine= in Python)"
        length = math.hypot(*axis)
        if not 1e-6 < length < 1e6:
            return [], "the tool vector is zero: give the direction from the tip to the spindle"
        unit = [value / length for value in axis]
        solutions, pole = machine.rotary_solutions(np.array([unit]))
        within, preferred = [], []
        for wanted in solutions[0].tolist():
            if bool(pole[0]):
                wanted[0] = present[0]
            if any(map(math.isnan, wanted)):
                continue
            turned = [near(value, here, *ends) for value, here, ends in zip(wanted, present, self.travel)]
            if None not in turned:
                within.append([value for value in turned if value is not None])
                preferred.append(not sign or wanted[1] * sign >= -FREE)
        choices = [each for each, wanted in zip(within, preferred) if wanted] or (within if else_other else [])
        if not choices:
            shown = ", ".join(f"{value:.4g}" for value in unit)
            if within:
                return [], self._other_only(within, sign, shown)
            return [], (
                f"machine '{machine.name}' cannot bring its tool to the direction {shown} within the travel of "
                f"{' and '.join(self.poses.rotary_names)}: choose a machine that can, or clamp the part otherwise"
            )
        if first is not None:
            ranked = sorted(choices, key=lambda choice: _in_turn(choice, present, first))
            tied = len(ranked) > 1 and _in_turn(ranked[0], present, first) == _in_turn(ranked[1], present, first)
            self.alike = ranked[1] if tied and math.dist(*ranked[:2]) > FREE else []
            return ranked[0], ""
        return min(choices, key=lambda choice: math.dist(choice, present)), ""


    def _other_only(self, within: list[list[float]], sign: int, shown: str) -> str:
        """What is wrong where only the solutions within travel (k, 2) are on the other side of zero than asked for."""
        names = self.poses.rotary_names
        which, other = ("below", "SEQ+") if sign < 0 else ("above", "SEQ-")
        there = " or ".join(" ".join(f"{n} {math.degrees(v):.3f}" for n, v in zip(names, each)) for each in within)
        return (
            f"the program asks (SEQ, SYM, _DIR) for the solution with {names[1]} {which} zero, and for the tool "
            f"direction {shown} that is out of travel: {there} deg is within; ask for that one ({other}), or for none"
        )


def _in_turn(choice: list[float], present: list[float], first: tuple[int, int]) -> list[float]:
    """What decides between rotary positions [rad] one after the other: turns, then distances from whole turns."""
    turns = [abs(choice[k] - present[k]) for k in first]
    away = [abs(math.remainder(choice[k], TURN)) for k in first]
    return [round(value, 9) for value in (*turns, *away)]


def near(angle: float, present: float, low: float, high: float) -> float | None:
    """The angle plus whole turns nearest to where the joint is, within travel; None where there is none."""
    best = angle + TURN * round((present - angle) / TURN)
    if low - 1e-9 <= best <= high + 1e-9:
        return best
    fitting = [angle + TURN * k for k in range(-200, 201) if low - 1e-9 <= angle + TURN * k <= high + 1e-9]
    return min(fitting, key=lambda value: abs(value - present), default=None)
