"""The path and time law of a plan, from its folder."""

from __future__ import annotations

import json
import math
import os
import reprlib
from pathlib import Path
from typing import Any, NamedTuple

from toolpace.common.errors import ToolpaceError, UsageError
from toolpace.common.files import changed, is_folder, reason
from toolpace.machine.machine import Machine
from toolpace.motion.files.set_point_files import read_set_points
from toolpace.motion.files.trajectory_file import TRAJECTORY, read_trajectory
from toolpace.motion.laws import TimeLaw
from toolpace.motion.recorded_path import recorded_path
from toolpace.path.axis_path import AxisPath
from toolpace.programs.toolpath import ToolPath

PLAN, MACHINE, CONTROLLER, SETUP = (
    "plan.json", "machine.toml", "controller.toml", "setup.toml",
)  # fmt: skip
"""Names of the files in it."""


class PlanFolder(NamedTuple):
    """What a folder holds."""

    path: AxisPath
    laws: tuple[TimeLaw, ...]
    """None where the path is one of recorded set-points, over time."""
    planner: str
    lower_bound: float
    continuous_bound: float
    """[s], 0 where it is not known."""
    mesh_points: int
    solve_seconds: float
    feed: float
    velocity: dict[str, float]
    acceleration: dict[str, float]
    jerk: dict[str, float]
    """Peak value over limit, inf where no number bounds it."""


def read_plan_folder(place: str | os.PathLike[str], exact: bool = False) -> PlanFolder:
    """What a folder of `toolpace plan --out` holds: the path of its set-points or, `exact`, the planned one.

    Raises UsageError.
    """
    if not isinstance(place, str | os.PathLike):
        raise UsageError(f"plan: {reprlib.repr(place)[:40]} is no path; give the folder of `toolpace plan --out`")
    folder = Path(place)
    if not is_folder(folder):
        raise UsageError(f"{folder}: no such folder; give the one that `toolpace plan --out` wrote")
    try:
        if words := changed(folder):
            raise UsageError(f"{folder}: {words}; plan again, into a new folder")
        record = json.loads((folder / PLAN).read_bytes())
    except OSError as error:
        raise UsageError(f"{folder}: cannot read: {reason(error)}; give the folder of a plan") from None
    except ValueError:
        raise UsageError(f"{folder}: {PLAN} is not JSON; plan again, into a new folder") from None
    machine = Machine.load(folder / MACHINE)
    laws: tuple[TimeLaw, ...] = ()
    if exact:
        path, laws = read_trajectory(folder / TRAJECTORY, machine)
    else:
        points = read_set_points(folder, machine)
    try:
        usage, duration = record["usage"], float(record["duration_s"])
        jerk = {joint: math.inf if value is None else value for joint, value in usage["jerk"].items()}
        if not exact:
            path = recorded_path(points, machine, duration, program_of(folder, machine, record))
        return PlanFolder(
            path,
            laws,
            str(record["planner"]),
            float(record["lower_bound_s"] or 0.0),
            float(record["continuous_bound_s"] or 0.0),
            int(record["mesh_points"]),
            float(record["solve_s"]),
            float(usage["feed"]),
            dict(usage["velocity"]),
            dict(usage["acceleration"]),
            jerk,
        )
    except (KeyError, TypeError, ValueError, AttributeError):
        raise UsageError(f"{folder}: {PLAN} is not that of a plan; plan again, into a new folder") from None
    except ToolpaceError as error:
        raise UsageError(f"{folder}: {error}; plan again, into a new folder") from None


def program_of(folder: Path, machine: Machine, record: dict[str, Any]) -> ToolPath | None:
    """The program of a plan, read as it was then; None where there was none."""
    from toolpace.programs.reading import Source, read_source
    from toolpace.programs.reading.options import ReadOptions

    name, how = str(record["program_file"]), record["reading"]
    if not name:
        return None
    if Path(name).name != name:
        raise UsageError(f"{PLAN} names a program {name!r} elsewhere")
    options = ReadOptions.of(
        None,
        folder / CONTROLLER if how["controller_file"] else None,
        folder / SETUP if how["setup_file"] else None,
        how["skip_unknown"],
        True,
        how["compensation"],
        how["max_blocks"],
        bool(how.get("lenient", False)),
        how.get("columns", ""),
        how.get("units", ""),
    )
    return read_source(Source.load(folder / name), machine, record["dialect"], options, feed=record["feed"])
