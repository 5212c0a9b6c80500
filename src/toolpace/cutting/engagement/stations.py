"""Stations: poses of the tool along a motion, close enough that the stock may be cut at each of them in turn."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, fields
from itertools import pairwise

import numpy as np

from toolpace.common.arrays import Bools, Floats, Ints
from toolpace.common.errors import UsageError
from toolpace.machine.machine import Machine
from toolpace.motion.laws import TimeLaw
from toolpace.motion.trajectory import Trajectory
from toolpace.path.axis_run import AxisRun
from toolpace.programs.toolpath import ToolPath

DENSE = 0.25
"""Share of the spacing: of points of the program that are closer than that, one stands for all."""
QUARTERS = 4
"""Parts in which a way is looked at first where its parameter grows by more than the spacing: both ends of a whole turn
are one place."""
STANDS = 1e-9
"""A way of tip [m] and axis below which the tool waits: at both ends of a dwell the pose is worked out anew."""
SPLITS = 8
"""How often ways are split where the tool moves farther than it should: a smooth curve needs two or three."""
MOST = 20_000_000
"""Stations of a program: more take more memory than the stock, and hours."""


@dataclass(frozen=True)
class Stations:
    """n poses; entry i speaks of pose i and of the way from i - 1 to i, all with one tool."""

    tip: Floats
    """(n, 3) tip, workpiece frame [m]."""
    axis: Floats
    """(n, 3) unit vectors from the tip to the spindle."""
    time: Floats
    """(n,) when the pose is passed [s]."""
    block: Ints
    """(n,) line of the program."""
    operation: Ints
    """(n,) index of the operation."""
    rapid: Bools
    """(n,)"""
    point: Ints = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    """(n,) point of the tool path that the way leads to; 0 where they are of none."""

    def __post_init__(self) -> None:
        if not len(self.point):
            object.__setattr__(self, "point", np.zeros(len(self.tip), dtype=np.int64))

    def __len__(self) -> int:
        return len(self.tip)

    def part(self, first: int, last: int) -> Stations:
        """Stations from `first` up to, not including, `last`."""
        return Stations(*(getattr(self, each.name)[first:last] for each in fields(self)))

    @property
    def moving_time(self) -> Floats:
        """(n,) time of the way to each station [s]; 0 to the first, and where the tool waits."""
        ways = (np.diff(each, axis=0, prepend=each[:1]) for each in (self.tip, self.axis))
        moves = np.any([np.abs(way).max(axis=1) > STANDS for way in ways], axis=0)
        return np.where(moves, np.diff(self.time, prepend=self.time[:1]), 0.0)

    def where(self, kept: Bools) -> Stations:
        """Those stations that are `kept` (n,)."""
        return Stations(*(getattr(self, each.name)[kept] for each in fields(self)))


def motion_stations(
    trajectory: Trajectory, toolpath: ToolPath, spacing: float, reach: Sequence[float]
) -> list[Stations]:
    """The stations of a planned motion, a part for each stretch of one operation, in the order of time.

    Along each way the tip and the point `reach` [m] above it, by operation, move by at most `spacing` [m] from one
    station to the next. The tool path's points are among them. The first station of a part is where the part before
    ends, with the tool that works in it. Raises UsageError where the motion does not follow the tool path, and for
    more stations than memory holds.
    """
    machine = trajectory.axis_path.machine
    if machine is None:
        raise UsageError("cut: the motion has no machine, and so no tool; plan a Path on a Machine")
    parts: list[Stations] = []
    count = 0
    for k, (run, law) in enumerate(zip(trajectory.axis_path.runs, trajectory.laws)):
        entry = run.entries()[1]
        if not len(entry) or entry.max() >= len(toolpath):
            raise UsageError("cut: the motion does not follow the tool path; give the one that it was planned for")
        length = trajectory.axis_path.tool_lengths[k]
        operation = toolpath.operation[entry]
        borders = [0, *(np.flatnonzero(np.diff(operation)) + 1).tolist(), len(entry)]
        for first, last in pairwise(borders):
            points = _Ways(run, law, machine, float(length), slice(first, last))
            part = points.stations(toolpath, spacing, reach[int(operation[first])], float(trajectory.starts[k]))
            count += len(part)
            if count > MOST:
                raise _too_many(spacing)
            parts.append(part)
    return joined(parts)


def program_stations(
    toolpath: ToolPath, times: Floats, spacing: float, reach: Sequence[float]
) -> list[Stations]:
    """The stations of a program as it is written, whose points are passed at `times` (n,) [s], straight and evenly
    from one to the next; for all else see `motion_stations`."""
    start, operation = toolpath.way_start, toolpath.operation
    # a longer tool begins elsewhere
    jumps = (start[1:] != toolpath.tip[:-1]).any(axis=1) | (np.diff(operation) != 0)
    borders = [1, *(np.flatnonzero(jumps[1:]) + 2).tolist(), len(toolpath)] if len(toolpath) > 1 else []
    parts: list[Stations] = []
    for first, last in pairwise(borders):
        tip = np.concatenate([start[first : first + 1], toolpath.tip[first:last]])
        axis, time = toolpath.axis[first - 1 : last], times[first - 1 : last]
        leads = np.maximum(np.arange(first - 1, last), first)
        parts.append(_straight(toolpath, tip, axis, time, leads, spacing, reach[int(operation[first])]))
        if sum(map(len, parts)) > MOST:
            raise _too_many(spacing)
    return joined(parts)


def _straight(
    toolpath: ToolPath, tip: Floats, axis: Floats, time: Floats, leads: Ints, spacing: float, reach: float
) -> Stations:
    """Stations along straight ways between poses (k,) that are passed at times (k,); to point `leads` (k,) of the tool
    path leads the way to each."""
    kept = _apart(_moves(tip, axis, reach), toolpath.rapid[leads[1:]], DENSE * spacing)
    tip, axis, time, leads = tip[kept], axis[kept], time[kept], leads[kept]
    count = np.maximum(np.ceil(_moves(tip, axis, reach) / spacing), 1.0)
    if count.sum() > MOST:
        raise _too_many(spacing)
    share = _split(np.arange(len(tip), dtype=float), count.astype(np.int64))
    tips, axes = (
        np.stack([np.interp(share, np.arange(len(tip)), column) for column in place.T], axis=1)
        for place in (tip, axis)
    )
    point = leads[np.ceil(share).astype(np.int64)]
    return Stations(
        tips,
        axes / np.linalg.norm(axes, axis=1)[:, None],
        np.interp(share, np.arange(len(tip)), time),
        toolpath.block[point],
        toolpath.operation[point],
        toolpath.rapid[point],
        point,
    )


def _apart(moves: Floats, rapid: Bools, least: float) -> Ints:
    """Those of k poses that are `least` [m] apart, by the moves (k - 1,) between them, and those at which rapids
    (k - 1,) begin and end."""
    way = np.concatenate([[0.0], np.cumsum(moves)])
    fixed = np.concatenate([[True], rapid[1:] != rapid[:-1], [True]])
    return np.flatnonzero(fixed | (np.diff(np.floor(way / least), prepend=-1.0) > 0.0))


def joined(parts: Sequence[Stations]) -> list[Stations]:
    """Neighbours of one operation and one place of its tool as one part: from one stop to the next the tool stays."""
    found: list[list[Stations]] = []
    for part in parts:
        last = found[-1][-1] if found else None
        same = last is not None and last.operation[-1] == part.operation[0]
        if last is not None and same and np.allclose(last.tip[-1], part.tip[0]):
            # a dwell is a way of its own, on which nothing moves
            found[-1].append(part if part.time[0] > last.time[-1] else part.part(1, len(part)))
        else:
            found.append([part])
    return [
        Stations(*(np.concatenate([getattr(part, each.name) for part in group]) for each in fields(Stations)))
        for group in found
    ]


class _Ways:
    """Neighbouring ways of one run, of one operation."""

    def __init__(self, run: AxisRun, law: TimeLaw, machine: Machine, length: float, ways: slice) -> None:
        start, entry = run.entries()
        self.run, self.law, self.machine, self.length = run, law, machine, length
        self.start = start[ways.start : ways.stop + 1]
        self.entry = entry[ways]

    def stations(self, toolpath: ToolPath, spacing: float, reach: float, begin: float) -> Stations:
        """The stations of these ways; the run starts at `begin` [s]."""
        s = _split(self.start, np.where(np.diff(self.start) > spacing, QUARTERS, 1))
        tip, axis = self.tool(s)
        kept = self.apart(s, _moves(tip, axis, reach), toolpath, DENSE * spacing)
        s, tip, axis = s[kept], tip[kept], axis[kept]
        for _ in range(SPLITS):
            count = np.ceil(_moves(tip, axis, reach) / spacing)
            if count.sum() > MOST:
                raise _too_many(spacing)
            if not (count > 1.0).any():
                break
            s = _split(s, np.maximum(count, 1.0).astype(np.int64))
            tip, axis = self.tool(s)
        # a place at the border of two ways is the end of the first
        entry = self.entry[np.clip(np.searchsorted(self.start, s, side="left") - 1, 0, len(self.entry) - 1)]
        return Stations(
            tip,
            axis,
            begin + self.times(s),
            toolpath.block[entry],
            toolpath.operation[entry],
            toolpath.rapid[entry],
            entry,
        )

    def apart(self, s: Floats, moves: Floats, toolpath: ToolPath, least: float) -> Ints:
        """Those of the parameters (n,) that are `least` [m] apart, and those at which rapids begin and end."""
        way = np.concatenate([[0.0], np.cumsum(moves)])
        rapid = toolpath.rapid[self.entry]
        fixed = np.isin(s, self.start[1:-1][rapid[1:] != rapid[:-1]])
        fixed[[0, -1]] = True
        return np.flatnonzero(fixed | (np.diff(np.floor(way / least), prepend=-1.0) > 0.0))

    def times(self, s: Floats) -> Floats:
        """(n,) when the run passes s (n,), from its start [s]."""
        # at rest the law tells the time to a microsecond only
        t = np.where(s >= self.run.s1, self.law.duration, np.where(s <= self.run.s0, 0.0, self.law.times_at(s)))
        rising: Floats = np.maximum.accumulate(t)
        return np.minimum(rising, self.law.duration)

    def tool(self, s: Floats) -> tuple[Floats, Floats]:
        """Tip and axis (n, 3) at s (n,)."""
        return self.machine.forward(self.run.evaluate(s)[0], np.full(len(s), self.length))


def _moves(tip: Floats, axis: Floats, reach: float) -> Floats:
    """(n - 1,) how far the tip or the point `reach` above it moves between n poses, whichever is more [m]."""
    upper = tip + reach * axis
    moves: Floats = np.maximum(*(np.linalg.norm(np.diff(point, axis=0), axis=1) for point in (tip, upper)))
    return moves


def _too_many(spacing: float) -> UsageError:
    apart = f"{spacing * 1e3:g} mm apart"
    return UsageError(f"cut: the motion has more than {MOST} places {apart}; give a coarser resolution")


def _split(s: Floats, count: Ints) -> Floats:
    """Parameters (n,) with each of their n - 1 intervals in `count` equal parts."""
    within = np.arange(int(count.sum())) - np.repeat(np.cumsum(count) - count, count)
    begin = np.repeat(s[:-1], count)
    step = np.repeat(np.diff(s) / count, count)
    found: Floats = np.append(begin + within * step, s[-1])
    return np.unique(found)
