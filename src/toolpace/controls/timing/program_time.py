"""The time of a program on a control, in all and by operation, by the model that the control's file names."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from toolpace.common.arrays import Bools, Floats
from toolpace.common.errors import UsageError
from toolpace.controls.timing.axis_motion import axis_ways
from toolpace.controls.timing.blocks import MotionProfile, lookahead_profile, rests, room_of
from toolpace.controls.timing.exceeded import ExceededLimit, exceeded_limits
from toolpace.controls.timing.fanuc import fanuc_profile
from toolpace.controls.timing.figures import ControlFigures, figures_of, limits_of, within_limits
from toolpace.controls.timing.heidenhain import heidenhain_profile
from toolpace.controls.timing.linuxcnc import FAR, LinuxCNC, linuxcnc_times
from toolpace.controls.timing.sinumerik import sinumerik_profile
from toolpace.controls.timing.uncertainty import TimeRange, time_range
from toolpace.programs.commanded import BLENDED, Commanded
from toolpace.programs.reading import Findings, ReadOptions, Source, read_commanded, read_source
from toolpace.programs.reading.coordinates.setup import SetUp
from toolpace.programs.reading.feeds import FeedChange
from toolpace.programs.reading.languages import with_controller
from toolpace.programs.toolpath import ToolPath

if TYPE_CHECKING:
    from toolpace.machine.machine import Machine
    from toolpace.motion.trajectory import OperationTime
    from toolpace.programs.reading import Controller
    from toolpace.programs.toolpath import Operation

Model = Callable[[Commanded, "Machine", ControlFigures], MotionProfile]
LONG = 20_000
"""Moves of a program from which its range is worked out with fewer trials: each takes a second at 100 000."""
STILL = 1e-12
"""Way of the tip [m] below which it stands."""


def _linuxcnc_profile(moves: Commanded, machine: Machine, figures: ControlFigures) -> MotionProfile:
    """LinuxCNC with the limits and the tolerance of the figures, where they have any.

    The first R of G64 chooses the planner for the whole program: it belongs at its beginning, and waits for rest.
    """
    rounded = moves if figures.tolerance is None else replace(moves, tolerance=room_of(moves, figures))
    own, limits = figures.linuxcnc, limits_of(machine, figures)
    words = moves.dynamics[np.isfinite(moves.dynamics[:, 3]), 3]
    planner, scale = (own.planner, own.peak_scale) if not len(words) else (int(words[0] > 0.0), float(words[0]) or 1.0)
    settings = LinuxCNC(
        own.cycle, own.path_velocity or FAR, planner=planner, path_jerk=own.path_jerk, peak_scale=scale
    )
    times = linuxcnc_times(rounded, within_limits(machine, limits), settings)
    ways = axis_ways(moves, machine, joints=False)
    jerk = ways.along(limits.jerk) if planner else np.full(len(times), np.inf)
    return MotionProfile(times, np.full(len(times), np.nan), ways.along(limits.acceleration), jerk)


MODELS: dict[str, Model] = {
    "linuxcnc": _linuxcnc_profile,
    "sinumerik": sinumerik_profile,
    "heidenhain": heidenhain_profile,
    "fanuc": fanuc_profile,
    "lookahead": lookahead_profile,
}


@dataclass(frozen=True)
class PartTime:
    """The time of a part of a program."""

    name: str
    tool: str
    cutting: float
    """[s]"""
    rapid: float
    dwell: float
    tool_change: float
    rests: int
    """How often the control comes to rest: at the stops that a program asks for, and wherever else it does."""

    @property
    def time(self) -> float:
        """All of it [s]."""
        return self.cutting + self.rapid + self.dwell + self.tool_change


@dataclass(frozen=True)
class ProgramTime:
    """How long a program takes on a control."""

    parts: tuple[PartTime, ...]
    """By operation, in the order of the program."""
    times: Floats
    """(n,) of each move, with its dwell [s]; empty where moves are not told apart."""
    exceeded: tuple[ExceededLimit, ...] = ()
    """Limits of the machine's joints that the control exceeds, by the rules of its maker."""
    range: TimeRange | None = None
    """Between which times the total is, by the uncertainty of the control's figures; None where that is not told."""

    @property
    def total(self) -> float:
        """[s]"""
        return sum(part.time for part in self.parts)

    def sum(self, kind: str) -> float:
        """Sum of a kind over the parts [s]: cutting, rapid, dwell, tool_change."""
        return float(sum(getattr(part, kind) for part in self.parts))


def time_of_moves(moves: Commanded, machine: Machine, figures: ControlFigures, tool_change: float = 0.0) -> ProgramTime:
    """The time of moves on a control that changes a tool in `tool_change` [s]; figures of a model that is not ideal.

    A program that only waits takes what it waits.
    """
    if len(moves) < 2:
        return ProgramTime(tuple(parts_of(moves, np.zeros(len(moves)), tool_change)), moves.dwell.copy())
    profile = MODELS[figures.model](moves, machine, figures)
    exceeded = exceeded_limits(moves, machine, figures, profile)
    return ProgramTime(tuple(parts_of(moves, profile.times, tool_change)), profile.times + moves.dwell, exceeded)


def with_range(time: ProgramTime, moves: Commanded, machine: Machine, figures: ControlFigures) -> ProgramTime:
    """The time with its range: the moves are timed again with each uncertain figure at both ends."""
    waits = time.sum("dwell") + time.sum("tool_change")
    if len(moves) < 2:
        return replace(time, range=TimeRange(waits, waits))

    def total(changed: ControlFigures) -> float:
        return float(MODELS[changed.model](moves, machine, changed).times.sum()) + waits

    return replace(time, range=time_range(total, machine, figures, time.total, thorough=len(moves) < LONG))


def of_operations(best: Sequence[OperationTime], moves: Commanded, tool_change: float) -> ProgramTime:
    """The time of a motion whose operations are known, as that of a control."""
    changed: dict[tuple[str, str], list[int]] = {}
    for each, count in reversed(list(zip(moves.operations, changes(moves.operations)))):
        changed.setdefault((each.name, each.tool), []).append(count)
    parts = [
        PartTime(
            each.name, each.tool, each.cutting, each.rapid, each.dwell,
            tool_change * (left.pop() if (left := changed.get((each.name, each.tool))) else 0), each.stops,
        )
        for each in best
    ]  # fmt: skip
    return ProgramTime(tuple(parts), np.zeros(0))


def parts_of(moves: Commanded, times: Floats, tool_change: float) -> list[PartTime]:
    """The parts of a program, from the time of each move (n,) [s], dwells left out."""
    count = len(moves.operations)
    of, stop = moves.operation, rests(moves)

    def total(figures: Floats, rows: Bools) -> list[float]:
        return [float(each) for each in np.bincount(of[rows], figures[rows], count)]

    everywhere = np.ones(len(moves), dtype=bool)
    cutting, rapid = total(times, ~moves.rapid), total(times, moves.rapid)
    dwell, rested = total(moves.dwell, everywhere), np.bincount(of[1:-1], stop[1:-1], count)
    used = np.bincount(of[1:], minlength=count)
    changed = changes(moves.operations)
    return [
        PartTime(
            each.name, each.tool, cutting[k], rapid[k], dwell[k], tool_change * changed[k], round(float(rested[k]))
        )
        for k, each in enumerate(moves.operations)
        if used[k] or dwell[k] > 0.0
    ]


def changes(operations: Sequence[Operation]) -> list[int]:
    """How many tool changes begin each operation: one where its tool is another than that of the one before."""
    found, before = [], ""
    for each in operations:
        found.append(int(each.tool not in ("", before)))
        before = each.tool or before
    return found


def program_time(
    program: str | Path,
    machine: Machine,
    *,
    controller: str | Path | Controller | None = None,
    model: str | None = None,
    feed: str | None = None,
    setup: str | Path | SetUp | None = None,
    dialect: str | None = None,
) -> ProgramTime:
    """How long a program takes on a control as it is written, without a plan.

    controller: a built-in controller or a file (TOML), whose table [time] describes how it goes through blocks; None
        tells it by the program's content. model: `linuxcnc`, `sinumerik`,
        `heidenhain`, `fanuc` or `lookahead`, in place of what the file says.
    feed, setup, dialect: as of `read`. Cutter-location data are timed as a post would write them, tool-centre-point
        mode on.

    Raises ProgramError, UsageError, ReachError. What the fastest motion takes is `plan(path, machine).duration`.
    """
    source = Source.load(program)
    options, _ = with_controller(source, dialect, ReadOptions.of(machine, controller, setup))
    figures = figures_for(options, model)
    if figures.model == "ideal":
        raise UsageError("the model ideal is the fastest motion: its time is plan(path, machine).duration")
    moves = moves_of(source, machine, options, feed, dialect)
    time = time_of_moves(moves, machine, figures, options.setup.tool_change)
    return with_range(time, moves, machine, figures)


def figures_for(options: ReadOptions, model: str | None) -> ControlFigures:
    """The figures of the controller that a program is read for. Raises UsageError."""
    controller = options.controller
    if controller is None:
        return figures_of({}, "", model)
    return figures_of(controller.time, controller.source or controller.name, model)


def moves_of(
    source: Source,
    machine: Machine,
    options: ReadOptions,
    feed: str | None = None,
    dialect: str | None = None,
    findings: Findings | None = None,
) -> Commanded:
    """The moves of a program; those of points where it is for no control. Raises ToolpaceError."""
    if options.controller is None:
        toolpath = read_source(source, machine, dialect, options, feed=feed, findings=findings)
        return moves_of_points(toolpath, machine)
    change = None if feed is None else FeedChange.parse(feed)
    default = None if change is None else change.speed
    reading = replace(options, default_feed=default)
    moves = read_commanded(source, machine, dialect, reading, findings=findings)
    return moves if change is None else refed(moves, change)


def moves_of_points(toolpath: ToolPath, machine: Machine) -> Commanded:
    """A move to each point. Raises ReachError where the machine cannot follow the tool axes."""
    rotary = machine.choose_rotary(toolpath)
    words = np.hstack([toolpath.tip, rotary])
    way = np.diff(words, axis=0, prepend=words[:1])
    way[:, :3] = toolpath.tip - toolpath.way_start
    length = np.linalg.norm(way[:, :3], axis=1)
    length[length < STILL] = 0.0
    direction = way[:, :3] / np.where(length > 0.0, length, np.inf)[:, None]
    count = len(words)
    return Commanded(
        words=words,
        way=way,
        rotary_joints=tuple(machine.joints[i] for i in machine.rotary),
        tip_mode=np.ones(count, dtype=bool),
        tool_length=toolpath.tool_length,
        rapid=toolpath.rapid,
        speed=toolpath.feed,
        turn=np.full(count, np.inf),
        time=toolpath.least_time,
        length=length,
        begin=direction,
        end=direction.copy(),
        radius=np.full(count, np.inf),
        centre=np.full((count, 3), np.nan),
        normal=np.zeros((count, 3)),
        sweep=np.zeros(count),
        line=toolpath.block,
        stop=toolpath.stop,
        joining=np.full(count, BLENDED),
        tolerance=np.full(count, np.inf),
        axis_tolerance=np.full(count, np.nan),
        cam_tolerance=np.full(count, np.nan),
        dynamics=np.full((count, 4), np.nan),
        dwell=toolpath.dwell,
        operation=toolpath.operation,
        operations=toolpath.operations,
        blocks=toolpath.blocks,
        source=toolpath.source,
    )


def refed(moves: Commanded, change: FeedChange) -> Commanded:
    """The moves with their feeds changed; rapids keep having none.

    As of tool paths: a value rules where X, Y, Z move, turns in place keep their time or speed.
    """
    if change.speed is None:
        factor = change.factor
        return replace(moves, speed=moves.speed * factor, turn=moves.turn * factor, time=moves.time / factor)
    if np.isinf(change.speed):
        free = np.full(len(moves), np.inf)
        return replace(moves, speed=free, turn=free.copy(), time=np.zeros(len(moves)))
    ruled = ~moves.rapid & (moves.length > 0.0)
    return replace(moves, speed=np.where(ruled, change.speed, moves.speed), time=np.where(ruled, 0.0, moves.time))
