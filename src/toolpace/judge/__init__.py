"""The judge: verification of a motion against limits and tolerances, from set-points, machine and program alone.

Nothing here knows how the motion was planned; speeds, accelerations and jerks are finite differences of
positions, the tool comes from the machine's forward kinematics, and the way along the program is found anew.
"""

from __future__ import annotations

import math
import threading
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any, NamedTuple, Protocol

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.common.errors import UsageError
from toolpace.judge import seen_motion
from toolpace.judge.alignment.sections import Sections, Steps
from toolpace.judge.figures import Figures
from toolpace.judge.motion import (
    column_checks,
    curve_checks,
    jumpy_joints,
    motion_checks,
    rest_checks,
    row_checks,
    step_check,
)
from toolpace.judge.program import JudgedProgram, ProgramJudgement
from toolpace.judge.rows import Stretch
from toolpace.judge.seen_motion import (
    ORDERS,
    BlockPeaks,
    BlockTool,
    JerkWindows,
    Largest,
    Peaks,
    SeenMotion,
    StillSteps,
    difference_beyond_rounding,
    each_block,
    even_rows,
    largest_misfits,
)
from toolpace.judge.tool import length_checks, pole_rounding, tool_checks, tool_lengths, tool_table
from toolpace.judge.torque import JointTorques, rating_checks, torque_checks
from toolpace.judge.verification import Check, Verification
from toolpace.machine.cutting_tool import CuttingTool
from toolpace.machine.limits import Limits
from toolpace.machine.machine import Machine, check_machine
from toolpace.machine.rows import Rows
from toolpace.motion.setpoints import REACH, ROWS, Block, SetPoints, SetPointSource
from toolpace.programs.tolerances import Tolerances
from toolpace.programs.toolpath import ToolPath, check_toolpath

__all__ = ["Check", "MotionJudge", "Verification", "motion_judge", "verify", "verify_plan"]


COLUMNS = ("t", "q", "qd", "qdd", "qddd", "tip", "axis", "tool_length")
"""Of numbers, each of which must be one."""


class Sampled(Protocol):
    """Anything that can be sampled at equal time steps, as a Trajectory can."""

    def sample(self, dt: float) -> SetPoints: ...


def verify(
    trajectory: SetPoints | Sampled,
    machine: Machine | Limits,
    toolpath: ToolPath | None = None,
    tip_tolerance: float | Tolerances = 10e-6,
    axis_tolerance: float | Tolerances = 1e-3,
    dt: float = 1e-3,
    tool: CuttingTool | None = None,
    sheet: str = "",
    rows: Sequence[Rows] = (),
) -> Verification:
    """Judge set-points, or a trajectory sampled every `dt` [s], against the machine and, if given, the
    program.

    Checked: equal time steps, no nan; per joint the velocity, acceleration and jerk as first, second and
    third differences over at most three steps (each is a weighted mean of the true value: what it shows above
    the limit is above the limit), within 1e-4 of the limit and a stated rounding noise; the set-points' own
    derivatives; rest at both ends; travel; the tip and axis columns against forward kinematics. With a
    program: the distance to it and from it (tip within `tip_tolerance` [m], axis within `axis_tolerance`
    [rad], in order; where these are `Tolerances`, each block by its own), the feed of each block, its least
    time, stops and dwells. With bare limits in place of a machine, what needs kinematics is left out. With a
    `tool` (a CuttingTool) the tip that is held against the program is the bent one: how far the force of this
    motion bends it is worked out here anew. The tip is that of the tool in the spindle, as long as set-points and
    program say; `sheet`, the text of the set-up sheet, tells whether they say the truth. `rows` of one's own are judged
    by the differences of their quantity, or where they have none by the set-points' derivatives.

    Time is linear in set-points and program points. Raises UsageError where the set-points do not fit the
    machine.
    """
    if toolpath is not None:
        check_toolpath(toolpath, "verify")
        if isinstance(machine, Limits):
            raise UsageError("verify: a program is judged on a Machine; give it in place of Limits, or no tool path")
    if tool is not None and not isinstance(tool, CuttingTool):
        raise UsageError(f"verify: tool is {type(tool).__name__}; give a CuttingTool, as load_tool makes it")
    points = trajectory if isinstance(trajectory, SetPoints) else trajectory.sample(dt)
    found = _judged(points, machine, toolpath, tip_tolerance, axis_tolerance, tool, sheet)[0]
    own = [*(machine.constants.rows if isinstance(machine, Limits) else ()), *rows]
    if own and not math.isnan(found.dt):
        found = replace(found, checks=found.checks + tuple(row_checks(points, own, found.dt)))
    # without a number there is no step: it is that which was asked for
    return replace(found, dt=dt) if math.isnan(found.dt) else found


def verify_plan(
    points: SetPoints,
    machine: Machine,
    toolpath: ToolPath | None,
    figures: Mapping[str, Any],
    tip_tolerance: float | Tolerances,
    axis_tolerance: float | Tolerances,
    tool: CuttingTool | None = None,
    sheet: str = "",
) -> Verification:
    """Judge set-points as `verify` does, and the figures of their plan.json by them.

    Each figure is recomputed, or held against the others where only the planner can know it (judge/figures.py says
    which). Raises UsageError as `verify` does.
    """
    found, judged = _judged(points, machine, toolpath, tip_tolerance, axis_tolerance, tool, sheet, figures=True)
    if judged is None:
        return found
    checks = Figures(figures, points, machine, toolpath, found, judged.feed_use, judged.passages).checks()
    return replace(found, checks=found.checks + tuple(checks))


def _judged(
    points: SetPoints,
    machine: Machine | Limits,
    toolpath: ToolPath | None,
    tip_tolerance: float | Tolerances,
    axis_tolerance: float | Tolerances,
    tool: CuttingTool | None,
    sheet: str,
    figures: bool = False,
) -> tuple[Verification, ProgramJudgement | None]:
    """The verdict, and what the program has to say; None where the set-points are too bad to go on."""
    judge = motion_judge(points, machine, toolpath, tip_tolerance, axis_tolerance, tool, sheet)
    if len(points):
        each_block(lambda begin, end: judge.take(Block.of(points, begin, end)), len(points))
    return judge.judged(figures)


def motion_judge(
    source: SetPointSource,
    machine: Machine | Limits,
    toolpath: ToolPath | None,
    tip_tolerance: float | Tolerances,
    axis_tolerance: float | Tolerances,
    tool: CuttingTool | None = None,
    sheet: str = "",
) -> MotionJudge:
    """A judge who takes the motion block by block; the rest as for `verify`, and UsageError as there.

    Where a tool bends, all set-points are taken again at once.
    """
    if not isinstance(machine, Limits):
        check_machine(machine, "verify", "a Machine, or Limits")
    limits = machine if isinstance(machine, Limits) else machine.limits
    if len(source.joints) != len(limits.velocity):
        raise UsageError(
            f"set-points of {len(source.joints)} joints ({', '.join(source.joints)}), "
            f"limits of {len(limits.velocity)} ({', '.join(limits.joints)})"
        )
    tip, axis = Tolerances.of(tip_tolerance, "tip_tolerance"), Tolerances.of(axis_tolerance, "axis_tolerance")
    program = None
    if toolpath is not None and isinstance(machine, Machine):
        program = JudgedProgram(toolpath, machine, tip, axis, tool)
    return MotionJudge(source, machine, program, sheet)


class _Notes(NamedTuple):
    """What is kept of a block."""

    peaks: BlockPeaks
    misfits: tuple[Largest, Largest]
    jerks: JerkWindows
    tool: BlockTool | None
    still: StillSteps
    torque: tuple[Largest, Floats] | None


class MotionJudge:
    """Takes a motion block by block, in any order and in any thread, and judges it once it has taken all."""

    def __init__(
        self, source: SetPointSource, machine: Machine | Limits, program: JudgedProgram | None = None, sheet: str = ""
    ) -> None:
        """Take where the set-points are from, the machine, the program, and the text of the set-up sheet."""
        self.source, self.program, self.sheet = source, program, sheet
        self.machine = machine if isinstance(machine, Machine) else None
        limits = machine if isinstance(machine, Limits) else machine.limits
        self.limits, self.over_speed = limits.largest, limits.constants
        torques = None if self.machine is None else JointTorques(self.machine.file)
        self._torques = torques if torques is not None and torques.held.any() else None
        self._notes: dict[int, _Notes] = {}
        self._bad: dict[str, tuple[int, int]] = {}
        self._lock = threading.Lock()
        self._taken = 0
        count = len(source)
        begins = range(0, count, ROWS)
        finite = count > 0 and all(_finite(source.times(np.arange(k, min(k + ROWS, count)))) for k in begins)
        self.step, self._steps = step_check(source) if finite else (math.nan, [])
        self._goes_on = finite and self._steps[0].ok
        self._even = even_rows(source, self.step) if self._goes_on else 0
        self._sections: Sections | None = None
        if self._goes_on and program is not None and program.bent is None:
            self._sections = program.sections(count - 1)

    @cached_property
    def _tool_lengths(self) -> Floats:
        if self.program is None or self.machine is None:
            return np.zeros(0)
        return np.unique(tool_lengths(self.machine, self.program.toolpath)[1:])

    def take(self, block: Block) -> None:
        """Look at a block, in parts that stay in the nearest cache."""
        with self._lock:
            self._taken += block.end - block.begin
        near = block.near
        if not all(_finite(getattr(near, name)) for name in COLUMNS):
            self._note_bad(block)
            return
        if not self._goes_on:
            return
        for begin in range(block.begin, block.end, seen_motion.ROWS):
            self._look(block, begin, min(begin + seen_motion.ROWS, block.end))

    def _look(self, block: Block, begin: int, end: int) -> None:
        """Note what is to be said of the rows from `begin` to `end` of a block."""
        behind, jumpy, limits = min(end, block.of_all - 1), jumpy_joints(self.limits), self.limits
        tool = None
        if self.machine is not None:
            first = max(begin - REACH, block.first)
            rows = slice(first - block.first, end + REACH - block.first)
            q, lengths = block.near.q[rows], block.near.tool_length[rows]
            tip, axis = self.machine.forward(q, lengths if len(lengths) else None)
            tool = BlockTool.of(block, begin, end, tip, axis, first, self._tool_lengths)
            if self._sections is not None and self.program is not None and behind > begin:
                poses = self.program.poses(tip, axis)
                stretch = Stretch.of(block, poses, first, limits, self.step, begin, behind)
                self._sections.take(Steps.of(block, stretch, tip, axis, first, behind))
        self._notes[begin] = _Notes(
            BlockPeaks.of(block, begin, end, self._even),
            largest_misfits(block, begin, behind, jumpy),
            JerkWindows.of(block, begin, behind, np.flatnonzero(~jumpy)),
            tool,
            StillSteps.of(block, begin, behind, limits, self.step),
            None if self._torques is None else self._torques.largest(block, begin, end),
        )

    def _note_bad(self, block: Block) -> None:
        """Keep the first number of each column that is none."""
        for name in COLUMNS:
            bad = np.argwhere(~np.isfinite(getattr(block.points, name)))
            if len(bad):
                row, *column = (int(each) for each in bad[0])
                place = block.begin + row, column[0] if column else 0
                with self._lock:
                    self._bad[name] = min(place, self._bad.get(name, place))

    def judged(self, figures: bool = False) -> tuple[Verification, ProgramJudgement | None]:
        """The verdict, and what the program has to say; None where the set-points are too bad to go on. `figures`: with
        what those of a plan are judged by.

        Raises ValueError where it has not taken each set-point once: what was not seen would count as good.
        """
        count = len(self.source)
        if self._taken != count:
            raise ValueError(f"the judge has taken {self._taken} of {count} set-points")
        first = self._not_finite()
        if first is not None:
            return Verification((first,), math.nan, count), None
        if not self._goes_on:
            return Verification(tuple(self._steps), self.step, count), None
        torques = [self._notes[begin].torque for begin in sorted(self._notes)]
        seen, machine, program = self._seen(), self.machine, self.program
        units = [""] * len(seen.joints)
        if machine is not None:
            units = ["rad" if rotary else "m" for rotary in machine.is_rotary]
        checks = self._steps + motion_checks(seen, self.limits, units, self._beyond if machine is not None else None)
        checks += curve_checks(self.source, self.over_speed, units, self.step, self._even)
        checks += column_checks(seen, self.limits, units) + rest_checks(seen, self.limits, units)
        if self._torques is not None:
            largest, values = zip(*(each for each in torques if each is not None))
            checks += torque_checks(seen, Largest.of_all(largest), self._torques, units)
            if self._torques.rated:
                times = self.source.times(np.arange(count))
                checks += rating_checks(self._torques, times, np.concatenate(values), units)
        judged = ProgramJudgement([], math.nan, math.nan)
        if machine is not None:
            checks += self._names(machine) + tool_checks(seen, machine)
            if program is not None:
                checks += length_checks(seen, machine, program.toolpath, tool_table(self.sheet))
                judged = program.judge(seen, self._sections, self.source, figures)
                checks += judged.checks
        deviations = judged.tip_deviation, judged.axis_deviation
        return Verification(tuple(checks), self.step, count, *deviations, judged.bending), judged

    def _seen(self) -> SeenMotion:
        """All notes as one."""
        notes, count, source = [self._notes.pop(begin) for begin in sorted(self._notes)], len(self.source), self.source
        of_q, of_qd = zip(*(each.misfits for each in notes))
        ending = source.rows(max(count - 1 - ORDERS[-1], 0), count)
        tools = [each.tool for each in notes if each.tool is not None]
        tool = None
        if tools:
            tool = BlockTool.of_all(tools)
        return SeenMotion(
            source, source.rows(0, 2), ending,
            Peaks.of_all([each.peaks for each in notes], count, self._even, ending, self.step),
            (Largest.of_all(of_q), Largest.of_all(of_qd)), JerkWindows.of_all([each.jerks for each in notes]),
            StillSteps(*(np.concatenate(each) for each in zip(*(each.still for each in notes)))), tool,
        )  # fmt: skip

    def _beyond(self, order: int, joint: int) -> tuple[float, int]:
        """Largest difference of an order and a joint beyond rounding near poles, and where."""
        q, rounding = self._rounded
        t = self.source.times(np.arange(len(q)))
        return difference_beyond_rounding(q[:, joint], t, order, self.step, rounding[:, joint])

    @cached_property
    def _rounded(self) -> tuple[Floats, Floats]:
        """(n, m) all positions, and what they may be off by near poles."""
        assert self.machine is not None
        count = len(self.source)
        blocks = [self.source.rows(k, min(k + seen_motion.ROWS, count)).q for k in range(0, count, seen_motion.ROWS)]
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
                place = self.source.rows(row, row + 1)
                time, block = float(place.t[0]), int(place.block[0])
                note = f"set-point {row}: {name} is not a number"
                return Check("set-points", math.nan, 0.0, "", False, time, block, joint, note)
        return None


def _finite(values: Floats) -> bool:
    """Whether all are finite: their sum tells, but for that of numbers near the largest there are."""
    with np.errstate(all="ignore"):
        return math.isfinite(float(values.sum())) or bool(np.isfinite(values).all())
