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
from typing import TYPE_CHECKING, Any

from toolpace.version import __version__

if TYPE_CHECKING:
    from toolpace import deflect
    from toolpace.axispath.axispath import AxisPath
    from toolpace.axispath.run import AxisRun
    from toolpace.batching import Batch, BatchJob, BatchRow, batch
    from toolpace.bending.aim_off import AimedOff, aim_off
    from toolpace.bending.compliance import Bending
    from toolpace.bending.cutting_forces import CuttingForces
    from toolpace.bending.tool_file import load_tool
    from toolpace.clamping.choices import Choice, Choices
    from toolpace.clamping.choices_file import load_choices
    from toolpace.clamping.clamping import Clamping
    from toolpace.clamping.confirmed import PlannedSetUp
    from toolpace.clamping.found import FoundSetUp
    from toolpace.clamping.place_map import PlaceMap
    from toolpace.clamping.search import search_setup
    from toolpace.clamping.zones import Zone
    from toolpace.cuttingtool import Coefficients, Cut, Cutter, CuttingTool, Engagement
    from toolpace.deflect.replanning import replan
    from toolpace.errors import ToolpaceError, UnitWarning
    from toolpace.exporting import Exported, ReadBack, export
    from toolpace.follow import Follower, Measurement, SetPoint, Status
    from toolpace.judge import Check, Sampled, Verification, verify
    from toolpace.laws.law import Probe, TimeLaw
    from toolpace.machine.file import ChainFile, JointFile, MachineFile
    from toolpace.machine.geometry import Geometry
    from toolpace.machine.limits import Limits
    from toolpace.machine.machine import Machine
    from toolpace.motion import Motion, Usage
    from toolpace.path.fit.haste import Haste
    from toolpace.path.path import Path
    from toolpace.path.run import PathJet, PathRun
    from toolpace.planning.bound.prove import prove
    from toolpace.planning.endstate import EndState
    from toolpace.planning.genetic.planner import Genetic
    from toolpace.planning.optimal.planner import Optimal
    from toolpace.planning.pace_rounds import Round
    from toolpace.planning.planned_run import PlannedRun
    from toolpace.planning.planner import Planner, plan
    from toolpace.planning.program_plan import ProgramPlan, plan_program
    from toolpace.planning.second_order.planner import SecondOrder
    from toolpace.reading import Kinematics, apply_feed, read, read_text
    from toolpace.reading.controllers.controller import Controller, Sign
    from toolpace.reading.coordinates.setup import SetUp, Tool
    from toolpace.reporting import report
    from toolpace.setpoints import SetPoints
    from toolpace.timing.program import program_time
    from toolpace.timing.program_time import PartTime, ProgramTime
    from toolpace.tolerances.tolerances import Tolerances
    from toolpace.toolpath import Operation, ToolPath
    from toolpace.trajectory import OpenPlace, Skipped, Trajectory
    from toolpace.workers import Progress, Workers
    from toolpace.write.set_up_folder import write_set_up

__all__ = [
    "AimedOff",
    "AxisPath",
    "AxisRun",
    "Batch",
    "BatchJob",
    "BatchRow",
    "Bending",
    "ChainFile",
    "Check",
    "Choice",
    "Choices",
    "Clamping",
    "Coefficients",
    "Controller",
    "Cut",
    "Cutter",
    "CuttingForces",
    "CuttingTool",
    "EndState",
    "Engagement",
    "Exported",
    "Follower",
    "FoundSetUp",
    "Genetic",
    "Geometry",
    "Haste",
    "JointFile",
    "Kinematics",
    "Limits",
    "Machine",
    "MachineFile",
    "Measurement",
    "Motion",
    "OpenPlace",
    "Operation",
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
    "Sampled",
    "SecondOrder",
    "SetPoint",
    "SetPoints",
    "SetUp",
    "Sign",
    "Skipped",
    "Status",
    "TimeLaw",
    "Tolerances",
    "Tool",
    "ToolPath",
    "ToolpaceError",
    "Trajectory",
    "UnitWarning",
    "Usage",
    "Verification",
    "Workers",
    "Zone",
    "__version__",
    "aim_off",
    "apply_feed",
    "batch",
    "deflect",
    "export",
    "load_choices",
    "load_tool",
    "plan",
    "plan_program",
    "program_time",
    "prove",
    "read",
    "read_text",
    "replan",
    "report",
    "search_setup",
    "verify",
    "write_set_up",
]

_HOME = {
    "AimedOff": "bending.aim_off",
    "AxisPath": "axispath.axispath",
    "AxisRun": "axispath.run",
    "Batch": "batching",
    "BatchJob": "batching",
    "BatchRow": "batching",
    "Bending": "bending.compliance",
    "ChainFile": "machine.file",
    "Check": "judge",
    "Choice": "clamping.choices",
    "Choices": "clamping.choices",
    "Clamping": "clamping.clamping",
    "Coefficients": "cuttingtool",
    "Controller": "reading.controllers.controller",
    "Cut": "cuttingtool",
    "Cutter": "cuttingtool",
    "CuttingForces": "bending.cutting_forces",
    "CuttingTool": "cuttingtool",
    "EndState": "planning.endstate",
    "Engagement": "cuttingtool",
    "Exported": "exporting",
    "Follower": "follow",
    "FoundSetUp": "clamping.found",
    "Genetic": "planning.genetic.planner",
    "Geometry": "machine.geometry",
    "Haste": "path.fit.haste",
    "JointFile": "machine.file",
    "Kinematics": "reading",
    "Limits": "machine.limits",
    "Machine": "machine.machine",
    "MachineFile": "machine.file",
    "Measurement": "follow",
    "Motion": "motion",
    "OpenPlace": "trajectory",
    "Operation": "toolpath",
    "Optimal": "planning.optimal.planner",
    "PartTime": "timing.program_time",
    "Path": "path.path",
    "PathJet": "path.run",
    "PathRun": "path.run",
    "PlaceMap": "clamping.place_map",
    "PlannedRun": "planning.planned_run",
    "PlannedSetUp": "clamping.confirmed",
    "Planner": "planning.planner",
    "Probe": "laws.law",
    "ProgramPlan": "planning.program_plan",
    "ProgramTime": "timing.program_time",
    "Progress": "workers",
    "ReadBack": "exporting",
    "Round": "planning.pace_rounds",
    "Sampled": "judge",
    "SecondOrder": "planning.second_order.planner",
    "SetPoint": "follow",
    "SetPoints": "setpoints",
    "SetUp": "reading.coordinates.setup",
    "Sign": "reading.controllers.controller",
    "Skipped": "trajectory",
    "Status": "follow",
    "TimeLaw": "laws.law",
    "Tool": "reading.coordinates.setup",
    "Tolerances": "tolerances.tolerances",
    "ToolPath": "toolpath",
    "ToolpaceError": "errors",
    "Trajectory": "trajectory",
    "UnitWarning": "errors",
    "Usage": "motion",
    "Verification": "judge",
    "Workers": "workers",
    "Zone": "clamping.zones",
    "aim_off": "bending.aim_off",
    "apply_feed": "reading",
    "batch": "batching",
    "export": "exporting",
    "load_choices": "clamping.choices_file",
    "load_tool": "bending.tool_file",
    "plan": "planning.planner",
    "plan_program": "planning.program_plan",
    "program_time": "timing.program",
    "prove": "planning.bound.prove",
    "read": "reading",
    "read_text": "reading",
    "replan": "deflect.replanning",
    "report": "reporting",
    "search_setup": "clamping.search",
    "verify": "judge",
    "write_set_up": "write.set_up_folder",
}
"""Public name to the module that defines it. No public function is named like a module: see docs/design/house.md."""
_MODULES = ("deflect",)
"""Public modules that are reached as attributes."""


def __getattr__(name: str) -> Any:
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
