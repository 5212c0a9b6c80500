"""The judge's notes on a motion that it sees block by block, and its verdict once it has seen all."""

from __future__ import annotations

import math
import threading
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from toolpace.common.arrays import Floats, Ints
from toolpace.judge import largest
from toolpace.judge.largest import BlockPeaks, Largest, Peaks, difference_beyond_rounding, even_rows
from toolpace.judge.motion import (
    JerkWindows,
    column_checks,
    jumpy_joints,
    largest_misfits,
    motion_checks,
    rest_checks,
    step_check,
)
from toolpace.judge.passing import StillSteps
from toolpace.judge.program import JudgedProgram, ProgramJudgement
from toolpace.judge.rows import Stretch
from toolpace.judge.tool import BlockTool, length_checks, pole_rounding, tool_checks, tool_lengths, tool_table
from toolpace.judge.verification import Check, Verification
from toolpace.machine.limits import Limits
from toolpace.machine.machine import Machine
from toolpace.motion.setpoints import REACH, Block, SetPoints, SetPointSource

COLUMNS = ("t", "q", "qd", "qdd", "qddd", "tip", "axis", "tool_length")
"""Of numbers, each of which must be one."""


class _Notes(NamedTuple):
    """What is kept of a block."""

    peaks: BlockPeaks
    misfits: tuple[Largest, Largest]
    jerks: JerkWindows
    tool: BlockTool | None
    still: StillSteps
    stretch: Stretch | None


@dataclass(frozen=True)
class SeenMotion:
    """What the judge keeps of a motion: peaks, places, and some numbers of each set-point."""

    joints: tuple[str, ...]
    t: Floats
    """(n,) [s]"""
    block: Ints
    """(n,) line numbers of the program."""
    start: SetPoints
    """The first two set-points."""
    end: SetPoints
    """The last four, or as many as there are."""
    peaks: Peaks
    misfits: tuple[Largest, Largest]
    jerks: JerkWindows
    still: StillSteps
    tool: BlockTool | None
    """None without kinematics."""

    def place(self, row: int) -> tuple[float, int]:
        """When a set-point comes [s], and its block."""
        return float(self.t[row]), int(self.block[row])


class MotionJudge:
    """Takes a motion block by block, in any order and in any thread, and judges it once it has taken all."""

    def __init__(
        self, source: SetPointSource, machine: Machine | Limits, program: JudgedProgram | None = None, sheet: str = ""
    ) -> None:
        """Take where the set-points are from, the machine, the program, and the text of the set-up sheet."""
        self.source, self.program, self.sheet = source, program, sheet
        self.machine = machine if isinstance(machine, Machine) else None
        self.limits = machine if isinstance(machine, Limits) else machine.limits
        self.block = np.empty(len(source), dtype=np.int64)
        self._notes: dict[int, _Notes] = {}
        self._bad: dict[str, tuple[int, int]] = {}
        self._lock = threading.Lock()
        finite = len(source) > 0 and bool(np.isfinite(source.t).all())
        self.step, self._steps = step_check(source) if finite else (math.nan, [])
        self._goes_on = finite and self._steps[0].ok

    @cached_property
    def _even(self) -> int:
        return even_rows(self.source.t, self.step)

    @cached_property
    def _tool_lengths(self) -> Floats:
        if self.program is None or self.machine is None:
            return np.zeros(0)
        return np.unique(tool_lengths(self.machine, self.program.toolpath)[1:])

    def take(self, block: Block) -> None:
        """Look at a block, in parts that stay in the nearest cache."""
        near = block.near
        if not all(_finite(getattr(near, name)) for name in COLUMNS):
            self._note_bad(block)
            return
        self.block[block.begin : block.end] = block.points.block
        if not self._goes_on:
            return
        for begin in range(block.begin, block.end, largest.ROWS):
            self._look(block, begin, min(begin + largest.ROWS, block.end))

    def _look(self, block: Block, begin: int, end: int) -> None:
        """Note what is to be said of the rows from `begin` to `end` of a block."""
        behind, jumpy, limits = min(end, block.of_all - 1), jumpy_joints(self.limits), self.limits
        tool = stretch = None
        if self.machine is not None:
            first = max(begin - REACH, block.first)
            rows = slice(first - block.first, end + REACH - block.first)
            q, lengths = block.near.q[rows], block.near.tool_length[rows]
            tip, axis = self.machine.forward(q, lengths if len(lengths) else None)
            tool = BlockTool.of(block, begin, end, tip, axis, first, self._tool_lengths)
            if self.program is not None and self.program.bent is None and behind > begin:
                poses = self.program.poses(tip, axis)
                stretch = Stretch.of(block, poses, first, limits, self.step, begin, behind)
        self._notes[begin] = _Notes(
            BlockPeaks.of(block, begin, end, self._even),
            largest_misfits(block, begin, behind, jumpy),
            JerkWindows.of(block, begin, behind, np.flatnonzero(~jumpy)),
            tool,
            StillSteps.of(block, begin, behind, limits, self.step),
            stretch,
        )

    def _note_bad(self, block: Block) -> None:
        """Keep the first number of each column that is none."""
        self.block[block.begin : block.end] = block.points.block
        for name in COLUMNS:
            bad = np.argwhere(~np.isfinite(getattr(block.points, name)))
            if len(bad):
                row, *column = (int(each) for each in bad[0])
                place = block.begin + row, column[0] if column else 0
                with self._lock:
                    self._bad[name] = min(place, self._bad.get(name, place))

    def judged(self) -> tuple[Verification, ProgramJudgement | None]:
        """The verdict, and what the program has to say; None where the set-points are too bad to go on."""
        count = len(self.source)
        first = self._not_finite()
        if first is not None:
            return Verification((first,), math.nan, count), None
        if not self._goes_on:
            return Verification(tuple(self._steps), self.step, count), None
        stretches: list[Stretch] = []
        seen, machine, program = self._seen(stretches), self.machine, self.program
        units = [""] * len(seen.joints)
        if machine is not None:
            units = ["rad" if rotary else "m" for rotary in machine.is_rotary]
        checks = self._steps + motion_checks(seen, self.limits, units, self._beyond if machine is not None else None)
        checks += column_checks(seen, self.limits, units) + rest_checks(seen, self.limits, units)
        judged = ProgramJudgement([], math.nan, math.nan)
        if machine is not None:
            checks += self._names(machine) + tool_checks(seen, machine)
            if program is not None:
                checks += length_checks(seen, machine, program.toolpath, tool_table(self.sheet))
                judged = program.judge(seen, stretches, self.source)
                checks += judged.checks
        deviations = judged.tip_deviation, judged.axis_deviation
        return Verification(tuple(checks), self.step, count, *deviations, judged.bending), judged

    def _seen(self, stretches: list[Stretch]) -> SeenMotion:
        """All notes as one, and the stretches."""
        notes, count, source = [self._notes.pop(begin) for begin in sorted(self._notes)], len(self.source), self.source
        stretches += [each.stretch for each in notes if each.stretch is not None]
        of_q, of_qd = zip(*(each.misfits for each in notes))
        ending = source.rows(max(count - 1 - largest.ORDERS[-1], 0), count)
        tools = [each.tool for each in notes if each.tool is not None]
        tool = None
        if tools:
            tool = BlockTool.of_all(tools)
        return SeenMotion(
            source.joints, source.t, self.block, source.rows(0, 2), ending,
            Peaks.of_all([each.peaks for each in notes], source.t, ending.q, self.step),
            (Largest.of_all(of_q), Largest.of_all(of_qd)), JerkWindows.of_all([each.jerks for each in notes]),
            StillSteps(*(np.concatenate(each) for each in zip(*(each.still for each in notes)))), tool,
        )  # fmt: skip

    def _beyond(self, order: int, joint: int) -> tuple[float, int]:
        """Largest difference of an order and a joint beyond rounding near poles, and where."""
        q, rounding = self._rounded
        return difference_beyond_rounding(q[:, joint], self.source.t, order, self.step, rounding[:, joint])

    @cached_property
    def _rounded(self) -> tuple[Floats, Floats]:
        """(n, m) all positions, and what they may be off by near poles."""
        assert self.machine is not None
        count = len(self.source)
        blocks = [self.source.rows(k, min(k + largest.ROWS, count)).q for k in range(0, count, largest.ROWS)]
        return np.concatenate(blocks), np.concatenate([pole_rounding(q, self.machine) for q in blocks])

    def _names(self, machine: Machine) -> list[Check]:
        """A failed check if the columns are not named after the machine's joints, in their order."""
        joints = self.source.joints
        if joints == machine.joints:
            return []
        note = f"columns are named {', '.join(joints)}, the machine's joints are {', '.join(machine.joints)}"
        return [Check("joints", 0.0, 0.0, "", False, note=note)]

    def _not_finite(self) -> Check | None:
        """A failed check if there is no set-point, or one that is no number."""
        if not len(self.source):
            return Check("set-points", 0.0, 1.0, "", False, note="there is none")
        for name in COLUMNS:
            if name in self._bad:
                row, column = self._bad[name]
                joint = self.source.joints[column] if name in ("q", "qd", "qdd", "qddd") else ""
                time, block = float(self.source.t[row]), int(self.block[row])
                note = f"set-point {row}: {name} is not a number"
                return Check("set-points", math.nan, 0.0, "", False, time, block, joint, note)
        return None


def _finite(values: Floats) -> bool:
    """Whether all are finite: their sum tells, but for that of numbers near the largest there are."""
    with np.errstate(all="ignore"):
        return math.isfinite(float(values.sum())) or bool(np.isfinite(values).all())
