"""Minimum-time motion along five-axis tool paths, within every axis's velocity, acceleration and jerk limits.

    import toolpace as tp

    machine = tp.Machine.load("xyzac-trunnion")
    toolpath = tp.read("part.ngc", machine)
    path = tp.Path.fit(toolpath, machine=machine)
    trajectory = tp.plan(path, machine)
    tp.verify(trajectory, machine, toolpath).raise_if_failed()
    tp.report(trajectory, "part.html")

Names are imported when they are first used: `import toolpace` alone loads no numerical library.
"""

from __future__ import annotations

import importlib
import warnings
from typing import TYPE_CHECKING, Any

from toolpace.common import __version__

if TYPE_CHECKING:
    from toolpace import deflection
    from toolpace.common.errors import ToolpaceError, UnitWarning
    from toolpace.common.workers import Progress, Workers
    from toolpace.controls.export import Exported, ReadBack, export
    from toolpace.controls.timing.exceeded import ExceededLimit
    from toolpace.controls.timing.program_time import PartTime, ProgramTime, program_time
    from toolpace.controls.timing.uncertainty import FigureEffect, TimeRange
    from toolpace.cutting.compensated_program import BendingCompensation, compensate_bending
    from toolpace.cutting.compliance import Bending
    from toolpace.cutting.engagement.stations import Stations
    from toolpace.cutting.engagement.table import EngagementTable
    from toolpace.cutting.forces.engaged import CutLoads, EngagedForces
    from toolpace.cutting.forces.engaged_deflection import with_engaged_deflection
    from toolpace.cutting.forces.fixed_engagement import CuttingForces
    from toolpace.cutting.forces.material import Material
    from toolpace.cutting.simulation import simulate_cut
    from toolpace.cutting.simulation.findings import Finding
    from toolpace.cutting.simulation.left_above_part import LeftAbovePart, LeftRegion
    from toolpace.cutting.simulation.operation_cut import CutStretch, OperationCut
    from toolpace.cutting.simulation.simulate import CutSimulation
    from toolpace.cutting.simulation.stock_range import Stock, StockRange
    from toolpace.cutting.tool_file import load_tool
    from toolpace.cutting.tool_profile import ToolProfile
    from toolpace.deflection.following import Follower, Measurement, SetPoint, Status
    from toolpace.deflection.new_trajectory import replan
    from toolpace.jobs.batch import Batch, BatchJob, BatchRow, batch
    from toolpace.judge import Check, Sampled, Verification, verify
    from toolpace.machine.cutting_tool import Coefficients, Cut, Cutter, CuttingTool, EngagedDeflection, Engagement
    from toolpace.machine.dynamics import Dynamics, Link, TorqueTerms
    from toolpace.machine.dynamics.torques import torque_rows
    from toolpace.machine.file import ChainFile, JointFile, MachineFile, WorkpieceFile
    from toolpace.machine.geometry import Geometry
    from toolpace.machine.limit_curves import CurvedLimit, LimitCurve
    from toolpace.machine.limits import Limits
    from toolpace.machine.machine import Machine
    from toolpace.machine.rows import Rows
    from toolpace.motion import Motion, Usage
    from toolpace.motion.active_limits import ActiveLimits, ActiveStretch
    from toolpace.motion.laws import Probe, TimeLaw
    from toolpace.motion.set_point_files import read_set_points
    from toolpace.motion.setpoints import SetPoints
    from toolpace.motion.trajectory import OpenPlace, Skipped, Trajectory
    from toolpace.path.axis_path import AxisPath
    from toolpace.path.axis_run import AxisRun
    from toolpace.path.fit.speed_weights import SpeedWeights
    from toolpace.path.path import Path
    from toolpace.path.run import PathJet, PathRun
    from toolpace.planning.bound.prove import prove
    from toolpace.planning.genetic import Genetic
    from toolpace.planning.optimal.planner import Optimal
    from toolpace.planning.path_and_pace.alternating import Round
    from toolpace.planning.planned_run import EndState, PlannedRun
    from toolpace.planning.planner import Planner, plan
    from toolpace.planning.program_plan import ProgramPlan, plan_program
    from toolpace.planning.second_order import SecondOrder
    from toolpace.programs.reading import Kinematics, apply_feed, read, read_text
    from toolpace.programs.reading.controllers.controller import Controller, Sign
    from toolpace.programs.reading.controllers.tool_rules import ToolRule
    from toolpace.programs.reading.coordinates.setup import SetUp, Tool
    from toolpace.programs.speed_profile import SpeedProfile
    from toolpace.programs.spindle_figures import SpeedCurve, SpindleFigures
    from toolpace.programs.stock_figures import Solid, StockFigures, WorkpieceFigures
    from toolpace.programs.tolerances import Tolerances
    from toolpace.programs.tool_figures import Frustum, ToolFigures
    from toolpace.programs.toolpath import Operation, ToolPath
    from toolpace.results.report import report
    from toolpace.results.write.set_up_folder import write_set_up
    from toolpace.setup_search.choices import Choice, Choices, Zone, load_choices
    from toolpace.setup_search.clamping import Clamping
    from toolpace.setup_search.found_set_up import FoundSetUp, PlaceMap, PlannedSetUp
    from toolpace.setup_search.search import search_setup

__all__ = [
    "ActiveLimits",
    "ActiveStretch",
    "AxisPath",
    "AxisRun",
    "Batch",
    "BatchJob",
    "BatchRow",
    "Bending",
    "BendingCompensation",
    "ChainFile",
    "Check",
    "Choice",
    "Choices",
    "Clamping",
    "Coefficients",
    "Controller",
    "CurvedLimit",
    "Cut",
    "CutLoads",
    "CutSimulation",
    "CutStretch",
    "Cutter",
    "CuttingForces",
    "CuttingTool",
    "Dynamics",
    "EndState",
    "EngagedDeflection",
    "EngagedForces",
    "Engagement",
    "EngagementTable",
    "ExceededLimit",
    "Exported",
    "FigureEffect",
    "Finding",
    "Follower",
    "FoundSetUp",
    "Frustum",
    "Genetic",
    "Geometry",
    "JointFile",
    "Kinematics",
    "LeftAbovePart",
    "LeftRegion",
    "LimitCurve",
    "Limits",
    "Link",
    "Machine",
    "MachineFile",
    "Material",
    "Measurement",
    "Motion",
    "OpenPlace",
    "Operation",
    "OperationCut",
    "Optimal",
    "PartTime",
    "Path",
    "PathJet",
    "PathRun",
    "PlaceMap",
    "PlannedRun",
    "PlannedSetUp",
    "Planner",
    "Probe",
    "ProgramPlan",
    "ProgramTime",
    "Progress",
    "ReadBack",
    "Round",
    "Rows",
    "Sampled",
    "SecondOrder",
    "SetPoint",
    "SetPoints",
    "SetUp",
    "Sign",
    "Skipped",
    "Solid",
    "SpeedCurve",
    "SpeedProfile",
    "SpeedWeights",
    "SpindleFigures",
    "Stations",
    "Status",
    "Stock",
    "StockFigures",
    "StockRange",
    "TimeLaw",
    "TimeRange",
    "Tolerances",
    "Tool",
    "ToolFigures",
    "ToolPath",
    "ToolProfile",
    "ToolRule",
    "ToolpaceError",
    "TorqueTerms",
    "Trajectory",
    "UnitWarning",
    "Usage",
    "Verification",
    "Workers",
    "WorkpieceFigures",
    "WorkpieceFile",
    "Zone",
    "__version__",
    "apply_feed",
    "batch",
    "compensate_bending",
    "deflection",
    "export",
    "load_choices",
    "load_tool",
    "plan",
    "plan_program",
    "program_time",
    "prove",
    "read",
    "read_set_points",
    "read_text",
    "replan",
    "report",
    "search_setup",
    "simulate_cut",
    "torque_rows",
    "verify",
    "with_engaged_deflection",
    "write_set_up",
]

_HOME = {
    "ActiveLimits": "motion.active_limits",
    "ActiveStretch": "motion.active_limits",
    "AxisPath": "path.axis_path",
    "AxisRun": "path.axis_run",
    "Batch": "jobs.batch",
    "BatchJob": "jobs.batch",
    "BatchRow": "jobs.batch",
    "Bending": "cutting.compliance",
    "BendingCompensation": "cutting.compensated_program",
    "ChainFile": "machine.file",
    "Check": "judge",
    "Choice": "setup_search.choices",
    "Choices": "setup_search.choices",
    "Clamping": "setup_search.clamping",
    "Coefficients": "machine.cutting_tool",
    "Controller": "programs.reading.controllers.controller",
    "CurvedLimit": "machine.limit_curves",
    "Cut": "machine.cutting_tool",
    "CutLoads": "cutting.forces.engaged",
    "CutSimulation": "cutting.simulation.simulate",
    "CutStretch": "cutting.simulation.operation_cut",
    "Cutter": "machine.cutting_tool",
    "CuttingForces": "cutting.forces.fixed_engagement",
    "CuttingTool": "machine.cutting_tool",
    "Dynamics": "machine.dynamics",
    "EndState": "planning.planned_run",
    "EngagedDeflection": "machine.cutting_tool",
    "EngagedForces": "cutting.forces.engaged",
    "Engagement": "machine.cutting_tool",
    "EngagementTable": "cutting.engagement.table",
    "ExceededLimit": "controls.timing.exceeded",
    "Exported": "controls.export",
    "FigureEffect": "controls.timing.uncertainty",
    "Finding": "cutting.simulation.findings",
    "Follower": "deflection.following",
    "FoundSetUp": "setup_search.found_set_up",
    "Frustum": "programs.tool_figures",
    "Genetic": "planning.genetic",
    "Geometry": "machine.geometry",
    "JointFile": "machine.file",
    "Kinematics": "programs.reading",
    "LeftAbovePart": "cutting.simulation.left_above_part",
    "LeftRegion": "cutting.simulation.left_above_part",
    "LimitCurve": "machine.limit_curves",
    "Limits": "machine.limits",
    "Link": "machine.dynamics",
    "Machine": "machine.machine",
    "MachineFile": "machine.file",
    "Material": "cutting.forces.material",
    "Measurement": "deflection.following",
    "Motion": "motion",
    "OpenPlace": "motion.trajectory",
    "Operation": "programs.toolpath",
    "OperationCut": "cutting.simulation.operation_cut",
    "Optimal": "planning.optimal.planner",
    "PartTime": "controls.timing.program_time",
    "Path": "path.path",
    "PathJet": "path.run",
    "PathRun": "path.run",
    "PlaceMap": "setup_search.found_set_up",
    "PlannedRun": "planning.planned_run",
    "PlannedSetUp": "setup_search.found_set_up",
    "Planner": "planning.planner",
    "Probe": "motion.laws",
    "ProgramPlan": "planning.program_plan",
    "ProgramTime": "controls.timing.program_time",
    "Progress": "common.workers",
    "ReadBack": "controls.export",
    "Rows": "machine.rows",
    "Round": "planning.path_and_pace.alternating",
    "Sampled": "judge",
    "SecondOrder": "planning.second_order",
    "SetPoint": "deflection.following",
    "SetPoints": "motion.setpoints",
    "SetUp": "programs.reading.coordinates.setup",
    "Sign": "programs.reading.controllers.controller",
    "Skipped": "motion.trajectory",
    "Solid": "programs.stock_figures",
    "SpeedCurve": "programs.spindle_figures",
    "SpeedProfile": "programs.speed_profile",
    "SpeedWeights": "path.fit.speed_weights",
    "SpindleFigures": "programs.spindle_figures",
    "Stations": "cutting.engagement.stations",
    "Status": "deflection.following",
    "Stock": "cutting.simulation.stock_range",
    "StockFigures": "programs.stock_figures",
    "StockRange": "cutting.simulation.stock_range",
    "TimeLaw": "motion.laws",
    "TimeRange": "controls.timing.uncertainty",
    "Tolerances": "programs.tolerances",
    "Tool": "programs.reading.coordinates.setup",
    "ToolFigures": "programs.tool_figures",
    "ToolPath": "programs.toolpath",
    "ToolProfile": "cutting.tool_profile",
    "ToolRule": "programs.reading.controllers.tool_rules",
    "ToolpaceError": "common.errors",
    "TorqueTerms": "machine.dynamics",
    "Trajectory": "motion.trajectory",
    "UnitWarning": "common.errors",
    "Usage": "motion",
    "Verification": "judge",
    "Workers": "common.workers",
    "WorkpieceFigures": "programs.stock_figures",
    "WorkpieceFile": "machine.file",
    "Zone": "setup_search.choices",
    "apply_feed": "programs.reading",
    "batch": "jobs.batch",
    "compensate_bending": "cutting.compensated_program",
    "export": "controls.export",
    "load_choices": "setup_search.choices",
    "load_tool": "cutting.tool_file",
    "plan": "planning.planner",
    "plan_program": "planning.program_plan",
    "program_time": "controls.timing.program_time",
    "prove": "planning.bound.prove",
    "read": "programs.reading",
    "read_set_points": "motion.set_point_files",
    "read_text": "programs.reading",
    "replan": "deflection.new_trajectory",
    "report": "results.report",
    "search_setup": "setup_search.search",
    "simulate_cut": "cutting.simulation",
    "torque_rows": "machine.dynamics.torques",
    "verify": "judge",
    "with_engaged_deflection": "cutting.forces.engaged_deflection",
    "write_set_up": "results.write.set_up_folder",
}
"""Public name to the module that defines it. No public function is named like a module (docs/design/decisions.md)."""
_MODULES = ("deflection", "errors")
"""Public modules that are reached as attributes."""
_RENAMED = {
    "AimedOff": "BendingCompensation",
    "Haste": "SpeedWeights",
    "aim_off": "compensate_bending",
    "deflect": "deflection",
}
"""Public names of the release before, and what they are called now."""


def __getattr__(name: str) -> Any:
    if name in _RENAMED:
        warnings.warn(
            f"toolpace.{name} is called toolpace.{_RENAMED[name]} now; the old name goes with the next release",
            DeprecationWarning, stacklevel=2,
        )  # fmt: skip
        name = _RENAMED[name]
    if name in _MODULES:
        return importlib.import_module(f"toolpace.{name}")
    home = _HOME.get(name)
    if home is None:
        raise AttributeError(f"module 'toolpace' has no attribute '{name}'; it has {', '.join(__all__)}")
    value = getattr(importlib.import_module(f"toolpace.{home}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
