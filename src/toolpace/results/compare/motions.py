"""Motions of plans from their folders, and when each of them is at the places of another."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from toolpace.common.arrays import Floats, Ints
from toolpace.motion.set_point_files import read_set_points, set_points_file
from toolpace.motion.setpoints import SetPoints
from toolpace.motion.trajectory import Trajectory
from toolpace.motion.trajectory_file import TRAJECTORY
from toolpace.programs.reading import Source, read_source
from toolpace.programs.toolpath import ToolPath
from toolpace.results.compare.plans import OperationKey, operation_keys
from toolpace.results.report.charts import POINTS
from toolpace.results.report.passages import FEED, Passages, passages
from toolpace.results.write import PlanRecord, read_again

ALIKE = 0.01
"""Share by which ways may differ in length to be one way, of which it can be told who is where when."""
STANDS = 1e-7
"""Way of the tip in a stretch below which its time tells the places in it [m]."""


@dataclass(frozen=True)
class PlannedMotion:
    """The motion of a plan, with its program."""

    trajectory: Trajectory
    setpoints: SetPoints
    toolpath: ToolPath | None
    program: bytes | None
    """What the file of the program holds."""
    passages: Passages
    way: Floats
    """(n,) of the tip from the beginning to each set-point [m], never falling."""

    @classmethod
    def load(cls, folder: Path, record: PlanRecord) -> PlannedMotion | None:
        """That of a folder; None where it was written without set-points, or has no tool.

        Raises UsageError where a file is damaged or was changed.
        """
        if not set_points_file(folder):
            return None
        trajectory = Trajectory.load(folder, exact=(folder / TRAJECTORY).is_file())
        machine = trajectory.axis_path.machine
        assert machine is not None
        setpoints = read_set_points(folder, machine)
        if not setpoints.has_tool or len(setpoints) < 2:
            return None
        toolpath = program = None
        if record.program_file:
            source = Source.load(folder / record.program_file)
            options = read_again(folder, record.reading)
            toolpath = read_source(source, machine, record.dialect, options, feed=record.feed)
            program = source.data
        way = np.concatenate(([0.0], np.cumsum(setpoints.tip_steps)))
        passed = passages(trajectory, setpoints, toolpath)
        return cls(trajectory, setpoints, toolpath, program, passed, way)

    @property
    def duration(self) -> float:
        """[s]"""
        return float(self.trajectory.duration)

    def way_at(self, t: Floats) -> Floats:
        """(n,) how far the tip has come at times t (n,) [m]."""
        found: Floats = np.interp(t, self.setpoints.t, self.way)
        return found

    def feeds(self) -> dict[OperationKey, float]:
        """Mean speed of the tip of each operation while it is passed at feed [m/s]; none where it never is."""
        if self.toolpath is None:
            return {}
        passed, operations = self.passages, self.toolpath.operations
        edges = np.append(passed.t, self.duration)
        at_feed = passed.kind == FEED
        of_each = passed.operation[at_feed]
        way, time = (
            np.bincount(of_each, np.diff(each)[at_feed], len(operations)) for each in (self.way_at(edges), edges)
        )
        # as plan.json lists them
        there = np.bincount(self.toolpath.operation[1:], minlength=len(operations)) > 0
        there |= np.bincount(self.toolpath.operation, self.toolpath.dwell, len(operations)) > 0.0
        listed = np.flatnonzero(there).tolist()
        keys = operation_keys((operations[k].name, operations[k].tool) for k in listed)
        return {key: float(way[k] / time[k]) for key, k in zip(keys, listed) if time[k] > 0.0}


def same_places(first: PlannedMotion, other: PlannedMotion, t: Floats) -> Floats | None:
    """(n,) when another motion is where the first is at ascending times t (n,) [s].

    Where both pass the same lines of their programs, places are matched line by line, within each by the share of its
    way, and where the tip stands by the share of its time; else by the share of the whole way. None where the ways
    differ in length: they are then not of one path.
    """
    length = first.way[-1]
    if not length > 0.0 or abs(other.way[-1] / length - 1.0) > ALIKE:
        return None
    lines = [_lines(each.passages) for each in (first, other)]
    if np.array_equal(lines[0], lines[1]):
        begin, matched = (np.append(each.passages.t, each.duration) for each in (first, other))
    else:
        begin, matched = (np.array([0.0, each.duration]) for each in (first, other))
    at = np.clip(np.searchsorted(begin, t, side="right") - 1, 0, len(begin) - 2)
    share = _shares(first.way_at(t), first.way_at(begin), t, begin, at)
    low, high = matched[at], matched[at + 1]
    way = other.way_at(matched)
    target = way[at] + share * (way[at + 1] - way[at])
    by_way = np.clip(np.interp(target, other.way, other.setpoints.t), low, high)
    found: Floats = np.where(way[at + 1] - way[at] > STANDS, by_way, low + share * (high - low))
    # rounding may let one place come before the one ahead of it
    return np.maximum.accumulate(found)


def _lines(passed: Passages) -> Ints:
    """(3, k) line, operation and kind of what is passed."""
    return np.stack([passed.line, passed.operation, passed.kind])


def _shares(way: Floats, way_at_begin: Floats, t: Floats, begin: Floats, at: Ints) -> Floats:
    """(n,) how much of its stretch has been passed at each time, by way, or by time where there is none."""
    gone, whole = way - way_at_begin[at], way_at_begin[at + 1] - way_at_begin[at]
    since, long = t - begin[at], begin[at + 1] - begin[at]
    by_time = since / np.where(long > 0.0, long, 1.0)
    share: Floats = np.where(whole > STANDS, gone / np.where(whole > STANDS, whole, 1.0), by_time)
    return np.clip(share, 0.0, 1.0)


def place_times(motion: PlannedMotion) -> Floats:
    """(n,) even times of a motion at whose places others are compared with it [s]."""
    return np.linspace(0.0, motion.duration, min(len(motion.setpoints), POINTS))
