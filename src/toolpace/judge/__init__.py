"""The judge: verification of a motion against limits and tolerances, from set-points, machine and program alone.

Nothing here knows how the motion was planned; speeds, accelerations and jerks are finite differences of
positions, the tool comes from the machine's forward kinematics, and the way along the program is found anew.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from typing import Any, Protocol

import numpy as np

from toolpace.common.errors import UsageError
from toolpace.judge.figures import Figures
from toolpace.judge.motion import column_checks, motion_checks, rest_checks, step_check
from toolpace.judge.program import ProgramJudgement, program_checks
from toolpace.judge.tool import length_checks, pole_rounding, tool_checks, tool_table
from toolpace.judge.verification import Check, Verification
from toolpace.machine.cutting_tool import CuttingTool
from toolpace.machine.limits import Limits
from toolpace.machine.machine import Machine, check_machine
from toolpace.motion.setpoints import SetPoints
from toolpace.programs.tolerances import Tolerances
from toolpace.programs.toolpath import ToolPath, check_toolpath

__all__ = ["Check", "Verification", "verify"]


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
    return _judged(points, machine, toolpath, tip_tolerance, axis_tolerance, dt, tool, sheet)[0]


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
    found, judged = _judged(points, machine, toolpath, tip_tolerance, axis_tolerance, math.nan, tool, sheet)
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
    dt: float,
    tool: CuttingTool | None,
    sheet: str,
) -> tuple[Verification, ProgramJudgement | None]:
    """The verdict, and what the program has to say; None where the set-points are too bad to go on."""
    if not isinstance(machine, Limits):
        check_machine(machine, "verify", "a Machine, or Limits")
    limits = machine if isinstance(machine, Limits) else machine.limits
    if points.q.shape[1] != len(limits.velocity):
        raise UsageError(
            f"set-points of {points.q.shape[1]} joints ({', '.join(points.joints)}), "
            f"limits of {len(limits.velocity)} ({', '.join(limits.joints)})"
        )
    tip_tolerance, axis_tolerance = (
        Tolerances.of(tip_tolerance, "tip_tolerance"),
        Tolerances.of(axis_tolerance, "axis_tolerance"),
    )
    first = _finite(points)
    if first is not None:
        return Verification((first,), dt, len(points)), None
    step, checks = step_check(points)
    if not checks[0].ok:
        return Verification(tuple(checks), step, len(points)), None
    units = _units(machine)
    rounding = cache(lambda: pole_rounding(points.q, machine)) if isinstance(machine, Machine) else None
    checks += motion_checks(points, limits, units, step, rounding)
    checks += column_checks(points, limits, units, step)
    checks += rest_checks(points, limits, units, step)
    judged = ProgramJudgement([], math.nan, math.nan)
    if isinstance(machine, Machine):
        checks += _names(points, machine)
        tip, axis = machine.forward(points.q, points.tool_length)
        checks += tool_checks(points, machine, tip, axis)
        if toolpath is not None:
            checks += length_checks(points, machine, toolpath, tool_table(sheet))
            judged = program_checks(points, machine, toolpath, tip, axis, tip_tolerance, axis_tolerance, step, tool)
            checks += judged.checks
    deviations = judged.tip_deviation, judged.axis_deviation
    return Verification(tuple(checks), step, len(points), *deviations, judged.bending), judged


def _names(points: SetPoints, machine: Machine) -> list[Check]:
    """A failed check if the columns are not named after the machine's joints, in their order."""
    if points.joints == machine.joints:
        return []
    note = f"columns are named {', '.join(points.joints)}, the machine's joints are {', '.join(machine.joints)}"
    return [Check("joints", 0.0, 0.0, "", False, note=note)]


def _units(machine: Machine | Limits) -> list[str]:
    """The unit of each joint; bare limits do not tell."""
    if isinstance(machine, Machine):
        return ["rad" if rotary else "m" for rotary in machine.is_rotary]
    return [""] * len(machine.joints)


def _finite(points: SetPoints) -> Check | None:
    """A failed check if there is no set-point, or one that is no number."""
    if len(points) == 0:
        return Check("set-points", 0.0, 1.0, "", False, note="there is none")
    for name in ("t", "q", "qd", "qdd", "qddd", "tip", "axis", "tool_length"):
        bad = ~np.isfinite(getattr(points, name))
        if bad.any():
            row, *column = np.argwhere(bad)[0]
            joint = points.joints[column[0]] if name in ("q", "qd", "qdd", "qddd") else ""
            time, block = float(points.t[row]), int(points.block[row])
            note = f"set-point {row}: {name} is not a number"
            return Check("set-points", math.nan, 0.0, "", False, time, block, joint, note)
    return None
