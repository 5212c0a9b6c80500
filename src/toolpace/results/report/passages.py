"""When which line of the program is passed, in which operation and how: at feed, at rapid, or waiting."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from toolpace.common.arrays import Floats, Ints
from toolpace.motion.setpoints import SetPointSource
from toolpace.motion.trajectory import Trajectory
from toolpace.programs.toolpath import ToolPath

FEED, RAPID, WAITING = 0, 1, 2
"""How a stretch is passed."""
SAMPLES = 40_000
"""Set-points that are looked at where the motion follows no tool path."""


@dataclass(frozen=True)
class Passages:
    """k stretches of time, in order: of one line, one operation and one kind each."""

    t: Floats
    """(k,) when each begins [s]."""
    line: Ints
    """(k,) of the program; 0 where there is none."""
    operation: Ints
    """(k,)"""
    kind: Ints
    """(k,) FEED, RAPID or WAITING."""


def passages(trajectory: Trajectory, setpoints: SetPointSource, toolpath: ToolPath | None) -> Passages:
    """Those of a motion along a tool path; of another one the lines that its set-points tell."""
    if toolpath is None or not _follows(trajectory, toolpath):
        at = np.linspace(0, len(setpoints) - 1, min(len(setpoints), SAMPLES)).astype(np.int64)
        points = setpoints.at(at)
        none = np.zeros(len(at), dtype=np.int64)
        return _joined(Passages(points.t, points.block, none, none))
    parts: list[tuple[Floats, Ints, Ints]] = []
    if trajectory.axis_path.first_dwell > 0.0:
        parts.append((np.zeros(1), np.zeros(1, dtype=np.int64), np.array([WAITING])))
    for begin, run, law in zip(trajectory.starts, trajectory.axis_path.runs, trajectory.laws):
        start, entry = run.entries()
        kind = np.where(toolpath.rapid[entry], RAPID, FEED)
        changes = _changes(toolpath.block[entry], toolpath.operation[entry], kind)
        times = np.concatenate([[0.0], law.times_at(start[changes[1:]])])
        parts.append((begin + times, entry[changes], kind[changes]))
        if run.dwell > 0.0:
            parts.append((np.array([begin + law.duration]), entry[-1:], np.array([WAITING])))
    t, entry, kind = (np.concatenate(each) for each in zip(*parts))
    return _joined(Passages(t, toolpath.block[entry], toolpath.operation[entry], kind))


def _follows(trajectory: Trajectory, toolpath: ToolPath) -> bool:
    entries = [run.entries()[1] for run in trajectory.axis_path.runs]
    return all(len(each) and each.max() < len(toolpath) for each in entries)


def _changes(*columns: Ints) -> Ints:
    """Where any of the columns (n,) has another value than before, the first place too."""
    other = np.any([np.diff(column) != 0 for column in columns], axis=0)
    return np.concatenate([[0], np.flatnonzero(other) + 1])


def _joined(found: Passages) -> Passages:
    """The same with neighbours that are alike as one."""
    at = _changes(found.line, found.operation, found.kind)
    return Passages(found.t[at], found.line[at], found.operation[at], found.kind[at])
