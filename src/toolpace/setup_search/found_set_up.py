"""The result of a set-up search: set-ups planned in full, the map of the duration about the best, and the gain."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, replace

import msgspec
import numpy as np

from toolpace.common.arrays import Floats
from toolpace.common.cluster import Pool
from toolpace.common.errors import ReachError
from toolpace.common.units import format_time
from toolpace.common.value_objects import one_line
from toolpace.common.workers import Progress
from toolpace.machine.machine import Machine
from toolpace.motion.trajectory import Trajectory
from toolpace.programs.reading.coordinates.setup import SetUp
from toolpace.programs.reading.setup_file import setup_in, setup_text
from toolpace.programs.toolpath import ToolPath
from toolpace.setup_search.choices import Choices
from toolpace.setup_search.clamping import AS_GIVEN, Clamping
from toolpace.setup_search.trial import Task, tried_there, zones_entered

MOST_SAMPLES = 200_000
"""Set-points by which travel is judged at most."""
SHORTEST = 1e-3
"""Between two of them [s]."""


@dataclass(frozen=True, eq=False, repr=False)
class PlannedSetUp:
    """A set-up that was planned in full, within all travels and outside of all forbidden zones."""

    clamping: Clamping
    machine: Machine
    """With the part clamped so, and this tool."""
    duration: float
    """[s]"""
    lower_bound: float
    """Of the duration on its mesh [s]."""
    limited_by: Mapping[str, float]
    """Share of the duration in which each limit binds, largest first."""
    used: Floats
    """(m, 2) lowest and highest position of each joint [m or rad]."""
    tool_lengths: tuple[float, ...]
    """Of its tools, from the spindle nose to the tip, as they follow each other in the program [m]."""

    @property
    def gap(self) -> float:
        """How far the duration may be from the best on its mesh."""
        return self.duration / self.lower_bound - 1.0 if self.lower_bound > 0.0 else np.inf

    def __repr__(self) -> str:
        return one_line(self, f"{self.machine.name}: {self.clamping.words(self.machine)}", format_time(self.duration))


def confirmed(task: Task, clamping: Clamping) -> PlannedSetUp:
    """A clamping planned in full. Raises ToolpaceError where it is beyond travel, or no motion exists."""
    return planned(task, task.toolpath, clamping)


def given_as_written(task: Task, toolpath: ToolPath) -> PlannedSetUp:
    """The program as it is written, rotary joints and all, on the machine as it is. Raises ToolpaceError."""
    return planned(task, toolpath, AS_GIVEN)


def planned(task: Task, toolpath: ToolPath, clamping: Clamping) -> PlannedSetUp:
    """See `confirmed`."""
    from toolpace.path.axis_path import AxisPath, check_travel
    from toolpace.path.path import Path
    from toolpace.planning.planner import plan

    machine = clamping.on(task.machine, task.centre)
    axis_path = AxisPath.follow(Path.fit(toolpath, task.tip_tolerance, task.axis_tolerance, machine), machine)
    check_travel(axis_path, toolpath.source)
    trajectory = plan(axis_path, machine)
    used = positions_used(trajectory, machine, task, toolpath.source)
    lengths = np.where(np.isnan(toolpath.tool_length), machine.tool_length, toolpath.tool_length)
    return PlannedSetUp(
        clamping, machine, trajectory.duration, trajectory.lower_bound, trajectory.limited_by(), used,
        tuple(dict.fromkeys(lengths.tolist())),
    )  # fmt: skip


def positions_used(trajectory: Trajectory, machine: Machine, task: Task, source: str) -> Floats:
    """(m, 2) lowest and highest position of each joint. Raises ReachError beyond travel and in a forbidden zone."""
    points = trajectory.sample(max(SHORTEST, trajectory.duration / MOST_SAMPLES))
    machine.check_travel(points.q, points.block, source)
    if zones_entered(machine, task.forbidden, points.q) > 0.0:
        names = [zone.name for zone in task.forbidden if zone.entered(machine.joints, points.q).any()]
        raise ReachError(
            f"{source or 'tool path'}: the machine would enter the forbidden zone {names[0]}; clamp the part elsewhere"
        )
    return np.stack([points.q.min(axis=0), points.q.max(axis=0)], axis=1)


@dataclass(frozen=True, eq=False)
class PlaceMap:
    """Cheap plans on a grid of places."""

    x: Floats
    """(k,) shifts along X [m]."""
    y: Floats
    """(l,) shifts along Y [m]."""
    seconds: Floats
    """(l, k) about the duration there [s]; nan beyond travel and in forbidden zones."""
    best: tuple[float, float]
    """Where the best set-up is [m]."""

    @property
    def fits(self) -> bool:
        """Whether the program fits anywhere on it."""
        return bool(np.isfinite(self.seconds).any())


def map_places(
    task: Task, choices: Choices, pool: Pool, best: PlannedSetUp, count: int, progress: Progress
) -> PlaceMap | None:
    """The map with so many places along each of x and y; None where one of them is not to be chosen."""
    if not {"x", "y"} <= set(choices.position):
        return None
    (x0, x1), (y0, y1), _ = choices.box()
    x, y = np.linspace(x0, x1, count), np.linspace(y0, y1, count)
    z = best.clamping.shift[2]
    clampings = [replace(best.clamping, shift=(float(a), float(b), z)) for b in y for a in x]
    seconds = np.full(len(clampings), np.nan)
    for done, outcome in enumerate(pool.each(tried_there, task, clampings), start=1):
        if outcome.value is not None and outcome.value.fits:
            seconds[outcome.number] = outcome.value.cost
        progress(done / len(clampings))
    return PlaceMap(x, y, seconds.reshape(count, count), best.clamping.shift[:2])


@dataclass(frozen=True, eq=False, repr=False)
class FoundSetUp:
    """The best set-ups for a program on a machine, each planned in full within all travels."""

    toolpath: ToolPath
    """The program as it was read on the machine as it was given."""
    best: tuple[PlannedSetUp, ...]
    """First the simplest of those as fast as the fastest, to 0.1 percent; then fastest first; the given one last."""
    given: PlannedSetUp | None
    """The set-up as it was given; None where the program cannot be run with it."""
    why: str
    """Why it cannot; empty where it can."""
    places: PlaceMap | None
    """The time over x and y, all else as in the best; None where these are not to be chosen, or it was not wanted."""
    trials: int
    """Clampings that were tried by a cheap plan."""
    seed: int
    seconds: float
    """That the search took."""

    @property
    def gain(self) -> float:
        """Share of the given duration that the best set-up saves; nan where the given one cannot be run."""
        return 1.0 - self.best[0].duration / self.given.duration if self.given is not None else float("nan")

    @property
    def machine(self) -> Machine:
        """The machine with the best set-up, ready to plan on; its set-up sheet says where the part is."""
        return with_sheet(self.best[0].machine)

    def sheet(self, setup: SetUp | None = None) -> SetUp:
        """The set-up sheet of the best set-up; `setup` is that of the given one, by default the machine file's."""
        return sheet_of(self.best[0].machine, setup)

    def changes(self) -> Mapping[str, tuple[float, float]]:
        """What limits before and after: share of the time in which each limit binds, most changed first."""
        before = self.given.limited_by if self.given is not None else {}
        after = self.best[0].limited_by
        names = sorted({*before, *after}, key=lambda name: -max(before.get(name, 0.0), after.get(name, 0.0)))
        return {name: (before.get(name, 0.0), after.get(name, 0.0)) for name in names}

    def __repr__(self) -> str:
        gain = f"gain {100.0 * self.gain:.3g} %" if self.given is not None else "as given it cannot be run"
        return one_line(
            self, f"{self.best[0].clamping.words(self.best[0].machine)}", format_time(self.best[0].duration), gain
        )


def sheet_of(machine: Machine, setup: SetUp | None = None) -> SetUp:
    """The set-up sheet of a machine with its part: that of the machine file, or `setup`, with the part where it is.

    Work offsets are left out, and bodies that they place: they tell where the part was.
    """
    sheet = setup_in(machine) if setup is None else setup
    chain = machine.file.chain
    part = {"origin": chain.workpiece_origin, "x": chain.workpiece_x, "z": chain.workpiece_z}
    return replace(sheet, part=part, offsets={}, workpiece=sheet.workpiece.without_offsets())


def with_sheet(machine: Machine, setup: SetUp | None = None) -> Machine:
    """The machine with the set-up sheet of its part in its file."""
    table = tomllib.loads(setup_text(sheet_of(machine, setup)))
    return replace(machine, file=msgspec.structs.replace(machine.file, setup=table))
