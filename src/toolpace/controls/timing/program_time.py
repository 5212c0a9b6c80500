"""The time of a program on a control: total, and by operation."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Protocol

import numpy as np

from toolpace.common.arrays import Bools, Floats
from toolpace.controls.timing.axis_limits import limits_of
from toolpace.controls.timing.figures import ControlFigures
from toolpace.controls.timing.filtered import filtered_times
from toolpace.controls.timing.linuxcnc import linuxcnc_times
from toolpace.controls.timing.lookahead import lookahead_times, rests, room_of
from toolpace.programs.commanded import Commanded

if TYPE_CHECKING:
    from toolpace.machine.machine import Machine
    from toolpace.programs.toolpath import Operation


class OperationTime(Protocol):
    """What the parts of a planned motion tell [s]."""

    @property
    def name(self) -> str: ...
    @property
    def tool(self) -> str: ...
    @property
    def cutting(self) -> float: ...
    @property
    def rapid(self) -> float: ...
    @property
    def dwell(self) -> float: ...
    @property
    def stops(self) -> int: ...


Model = Callable[[Commanded, "Machine", ControlFigures], Floats]
"""Time of each move (n,) [s], dwells left out."""


def _linuxcnc_times(moves: Commanded, machine: Machine, figures: ControlFigures) -> Floats:
    """LinuxCNC with the limits and the tolerance of the figures, where they have any."""
    told = moves if figures.tolerance is None else replace(moves, tolerance=room_of(moves, figures))
    return linuxcnc_times(told, machine.with_limits(limits_of(machine, figures)))


MODELS: dict[str, Model] = {"linuxcnc": _linuxcnc_times, "lookahead": lookahead_times, "fir": filtered_times}


@dataclass(frozen=True)
class PartTime:
    """The time of a part of a program."""

    name: str
    tool: str
    cutting: float
    """[s]"""
    rapid: float
    dwell: float
    tool_change: float
    rests: int
    """How often the control comes to rest: at the stops that a program asks for, and wherever else it does."""

    @property
    def time(self) -> float:
        """All of it [s]."""
        return self.cutting + self.rapid + self.dwell + self.tool_change


@dataclass(frozen=True)
class ProgramTime:
    """How long a program takes on a control."""

    parts: tuple[PartTime, ...]
    """By operation, in the order of the program."""
    times: Floats
    """(n,) of each move, with its dwell [s]; empty where moves are not told apart."""

    @property
    def total(self) -> float:
        """[s]"""
        return sum(part.time for part in self.parts)

    def sum(self, kind: str) -> float:
        """Sum of a kind over the parts [s]: cutting, rapid, dwell, tool_change."""
        return float(sum(getattr(part, kind) for part in self.parts))


def time_of_moves(moves: Commanded, machine: Machine, figures: ControlFigures, tool_change: float = 0.0) -> ProgramTime:
    """The time of moves on a control that changes a tool in `tool_change` [s]; figures of a model that is not ideal.

    A program that only waits takes what it waits.
    """
    times = MODELS[figures.model](moves, machine, figures) if len(moves) > 1 else np.zeros(len(moves))
    return ProgramTime(tuple(parts_of(moves, times, tool_change)), times + moves.dwell)


def of_operations(best: Sequence[OperationTime], moves: Commanded, tool_change: float) -> ProgramTime:
    """The time of a motion whose operations are known, as that of a control."""
    changed = {(each.name, each.tool): count for each, count in zip(moves.operations, changes(moves.operations))}
    parts = [
        PartTime(
            each.name, each.tool, each.cutting, each.rapid, each.dwell,
            tool_change * changed.get((each.name, each.tool), 0), each.stops,
        )
        for each in best
    ]  # fmt: skip
    return ProgramTime(tuple(parts), np.zeros(0))


def parts_of(moves: Commanded, times: Floats, tool_change: float) -> list[PartTime]:
    """The parts of a program, from the time of each move (n,) [s], dwells left out."""
    count = len(moves.operations)
    of, stop = moves.operation, rests(moves)

    def total(figures: Floats, rows: Bools) -> list[float]:
        return [float(each) for each in np.bincount(of[rows], figures[rows], count)]

    everywhere = np.ones(len(moves), dtype=bool)
    cutting, rapid = total(times, ~moves.rapid), total(times, moves.rapid)
    dwell, rested = total(moves.dwell, everywhere), np.bincount(of[1:-1], stop[1:-1], count)
    used = np.bincount(of[1:], minlength=count)
    changed = changes(moves.operations)
    return [
        PartTime(
            each.name, each.tool, cutting[k], rapid[k], dwell[k], tool_change * changed[k], round(float(rested[k]))
        )
        for k, each in enumerate(moves.operations)
        if used[k] or dwell[k] > 0.0
    ]


def changes(operations: Sequence[Operation]) -> list[int]:
    """How many tool changes begin each operation: one where its tool is another than that of the one before."""
    found, before = [], ""
    for each in operations:
        found.append(int(each.tool not in ("", before)))
        before = each.tool or before
    return found
