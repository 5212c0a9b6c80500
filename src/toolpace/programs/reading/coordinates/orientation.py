"""Rotary positions that bring the tool to a direction on the part."""

from __future__ import annotations

import math

import numpy as np

from toolpace.programs.reading.coordinates.kinematics import Poses

TURN = 2.0 * math.pi
FREE = 1e-6
"""Angle to the pole within which the first rotary joint stays where it is [rad]."""


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
        within, asked = [], []
        for wanted in solutions[0].tolist():
            if bool(pole[0]):
                wanted[0] = present[0]
            if any(map(math.isnan, wanted)):
                continue
            turned = [near(value, here, *ends) for value, here, ends in zip(wanted, present, self.travel)]
            if None not in turned:
                within.append([value for value in turned if value is not None])
                asked.append(not sign or wanted[1] * sign >= -FREE)
        choices = [each for each, wanted in zip(within, asked) if wanted] or (within if else_other else [])
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
