"""The judge: verification of a motion against limits and tolerances, from set-points, machine and program alone.

Nothing here knows how the motion was planned; speeds, accelerations and jerks are finite differences of
positions, the tool comes from the machine's forward kinematics, and the way along the program is found anew.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any, Protocol

from toolpace.common.errors import UsageError
from toolpace.judge.figures import Figures
from toolpace.judge.largest import each_block
from toolpace.judge.program import JudgedProgram, ProgramJudgement
from toolpace.judge.seen_motion import MotionJudge
from toolpace.judge.verification import Check, Verification
from toolpace.machine.cutting_tool import CuttingTool
from toolpace.machine.limits import Limits
from toolpace.machine.machine import Machine, check_machine
from toolpace.motion.setpoints import Block, SetPoints, SetPointSource
from toolpace.programs.tolerances import Tolerances
from toolpace.programs.toolpath import ToolPath, check_toolpath

__all__ = ["Check", "MotionJudge", "Verification", "motion_judge", "verify", "verify_plan"]


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
    program say; `sheet`, the text of the set-up sheet, tells whether they say the truth.

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
    found, judged = _judged(points, machine, toolpath, tip_tolerance, axis_tolerance, tool, sheet)
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
) -> tuple[Verification, ProgramJudgement | None]:
    """The verdict, and what the program has to say; None where the set-points are too bad to go on."""
    judge = motion_judge(points, machine, toolpath, tip_tolerance, axis_tolerance, tool, sheet)
    if len(points):
        each_block(lambda begin, end: judge.take(Block.of(points, begin, end)), len(points))
    return judge.judged()


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
