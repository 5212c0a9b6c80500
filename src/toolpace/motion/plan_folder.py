"""The path and time law of a plan, from its folder, or from its set-points alone.

The parameter of a joint path from recorded set-points is the time of the plan. Between two set-points each joint is the
polynomial of degree five with position, velocity and acceleration of both.
"""

from __future__ import annotations

import json
import math
import os
import reprlib
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from toolpace.common.arrays import Floats, Ints
from toolpace.common.errors import ToolpaceError, UsageError
from toolpace.common.files import changed, is_folder, reason
from toolpace.machine.limits import CONTINUOUS
from toolpace.machine.machine import Machine
from toolpace.motion.laws import TimeLaw
from toolpace.motion.set_point_files import read_set_points
from toolpace.motion.setpoints import SetPoints
from toolpace.motion.torques_over_time import rated_torques
from toolpace.motion.trajectory_file import TRAJECTORY, read_trajectory
from toolpace.path.axis_path import AxisPath
from toolpace.path.axis_quintic import QuinticAxisRun
from toolpace.programs.toolpath import ToolPath

SHORTEST = 1e-3
"""Share of a time step below which the last one is a part of that before it: a plan ends between two set-points."""
SEEN = 1e-6
"""Joint motion by which the motion of the tip is seen [m or rad]."""
PLAN, MACHINE, CONTROLLER, SETUP = (
    "plan.json", "machine.toml", "controller.toml", "setup.toml",
)  # fmt: skip
"""Names of the files in a plan's folder."""


class RecordedRun(QuinticAxisRun):
    """Set-points with one tool, by the time of the plan."""

    def __init__(self, t: Floats, jets: Floats, block: Ints, feed: Floats, machine: Machine) -> None:
        """Take times (n,) [s], joints with two derivatives (3, n, m), block (n,) and its feed (n,) [m/s] of each, inf
        where it is not known; `machine` has the tool of the run."""
        super().__init__(t, jets, np.inf)
        self.block, self.feed, self.machine = block, feed, machine
        self.tool_length = machine.tool_length
        self.blocks = len(np.unique(block))

    def _index(self, s: Floats) -> Ints:
        """(n,) the set-point at or before times s (n,)."""
        at = np.searchsorted(self.points, s, side="right") - 1
        return np.clip(at, 0, len(self.points) - 1).astype(np.int64)

    def speed_cap(self, s: Floats) -> Floats:
        return self.with_cap(s)[1]

    def with_cap(self, s: Floats) -> tuple[Floats, Floats]:
        jets, feed = self.evaluate(s), self.feed[self._index(s)]
        step = SEEN / np.maximum(np.abs(jets[1]).max(axis=1), 1e-12)[:, None]
        ends = [self.machine.forward(jets[0] + sign * step * jets[1])[0] for sign in (0.5, -0.5)]
        speed = np.linalg.norm(ends[0] - ends[1], axis=1) / step[:, 0]
        return jets, np.divide(feed, speed, where=speed > 0.0, out=np.full(len(s), np.inf))

    def block_at(self, s: Floats) -> Ints:
        line: Ints = self.block[self._index(s)]
        return line


def recorded_path(points: SetPoints, machine: Machine, duration: float, toolpath: ToolPath | None) -> AxisPath:
    """The path of set-points of a plan that takes `duration` [s], a run a tool; feeds are those of the program.

    Raises UsageError where the set-points are not of this machine, or of this duration.
    """
    if points.joints != machine.joints:
        raise UsageError(
            f"set-points of {', '.join(points.joints)}, and machine {machine.name} has {', '.join(machine.joints)}"
        )
    if len(points) < 2 or not points.t[-2] <= duration <= points.t[-1] * (1.0 + 1e-9):
        raise UsageError(f"{len(points)} set-points do not end where the plan of {duration:g} s does")
    t, jets = points.t.copy(), np.stack([points.q, points.qd, points.qdd])
    kept = np.ones(len(t), dtype=bool)
    # the plan has come to rest at its end, wherever the last set-point lies
    kept[-2] = len(t) == 2 or duration - t[-2] > SHORTEST * (t[1] - t[0])
    t[-1], jets[1:, -1] = duration, 0.0
    feed = feeds_of(points.block, toolpath)
    lengths = points.tool_length if len(points.tool_length) else np.full(len(t), machine.tool_length)
    t, jets, block, feed, lengths = t[kept], jets[:, kept], points.block[kept], feed[kept], lengths[kept]
    # the tool is changed at rest: the step to the first set-point with another one is the last of the run before
    borders = [0, *(np.flatnonzero(np.diff(lengths)) + 1), len(t) - 1]
    parts = [slice(a, b + 1) for a, b in pairwise(borders) if b > a]
    machines = machine.with_tools(lengths[part.start] for part in parts)
    runs = (RecordedRun(t[p], jets[:, p], block[p], feed[p], each) for p, each in zip(parts, machines))
    return AxisPath(tuple(runs), machine.joints, machine)


def feeds_of(block: Ints, toolpath: ToolPath | None) -> Floats:
    """(n,) feed of blocks (n,) of a program [m/s]: the lowest of each; inf without a feed, and without a program."""
    if toolpath is None:
        return np.full(len(block), np.inf)
    lines, which = np.unique(toolpath.block, return_inverse=True)
    lowest = np.full(len(lines), np.inf)
    np.minimum.at(lowest, which, np.where(toolpath.rapid, np.inf, toolpath.feed))
    at = np.clip(np.searchsorted(lines, block), 0, len(lines) - 1)
    return np.where(lines[at] == block, lowest[at], np.inf)


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
    motor: dict[str, float]
    """By the name of the limit, "torque A", and of its continuous rating, "continuous torque A"."""
    curves: dict[str, float]
    """The same of limits that fall with the speed, by name."""


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
        of_motors = dict(usage.get("motor", {}))
        motor = {rows.name: float(of_motors[rows.name.partition(" ")[2]]) for rows in machine.limits.rows}
        for rows in rated_torques(machine.limits):
            motor[CONTINUOUS + rows.name] = float(usage["continuous"][rows.name.partition(" ")[2]])
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
            motor,
            dict(usage.get("curves", {})),
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
