"""The fastest motion of a program whose cut keeps its limits: caps of the cut within the planner.

plan the program by its feeds, the path fitted once           for the way of the tool
cut the stock along it                                        engagement at each station
most speed at each station, as a profile over the program     air, teachers or limits
fit path and motion with that profile                         rounds of path and pace see it
while the path is another than the one that was cut
    cut the stock along the path of the motion                its own engagement
    plan that same path anew with its own profile

The last profile is always of the path that is moved: what path and pace changed by is in it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from toolpace.common.arrays import Floats, Ints
from toolpace.common.units import format_length
from toolpace.common.value_objects import counted
from toolpace.common.workers import CallersProgress
from toolpace.cutting.engagement.stations import Stations
from toolpace.cutting.feeds.feed_plan import FeedPlan, plan_feeds
from toolpace.cutting.feeds.limits import FEED, SOURCES
from toolpace.cutting.feeds.rules import FeedRules
from toolpace.cutting.feeds.schedule import Steps
from toolpace.cutting.simulation import MEMORY, simulate_cut
from toolpace.cutting.simulation.operation_cut import CutStretch
from toolpace.cutting.simulation.simulate import CutSimulation
from toolpace.machine.machine import Machine
from toolpace.motion.trajectory import Trajectory
from toolpace.path.axis_path import AxisPath
from toolpace.path.path import Path
from toolpace.path.run import PathRun
from toolpace.planning.planner import Planner, plan
from toolpace.planning.program_plan import ProgramPlan, plan_program
from toolpace.programs.speed_profile import SpeedProfile, ways_between
from toolpace.programs.tolerances import Tolerances
from toolpace.programs.toolpath import ToolPath, check_toolpath

if TYPE_CHECKING:
    from toolpace.programs.reading.coordinates.setup import SetUp

DEPARTURE = 1e-3
"""Share by which what a cut allows may be below a straight line between two stations, before the line is lowered: the
profile is as far below it."""
UNLIMITED = 1e3
"""Stands for a speed without a limit [m/s]."""
FINE = 1.0005
"""Between two speeds that are next to each other: few values are of no use here."""
BELOW = 2e-3
"""Share of a speed by which the profile may be below it, so that it has few places."""


@dataclass(frozen=True, eq=False, repr=False)
class CutLimitedPlan:
    """A motion whose speed is that which its cut allows."""

    plan: ProgramPlan
    toolpath: ToolPath
    """The program with its profile of speed, which the motion was planned for."""
    simulation: CutSimulation
    """What this very path cuts."""
    feeds: FeedPlan
    """What its cut allows, station by station."""
    passed: tuple[Floats, ...]
    """(n,) when the motion passes the stations of each stretch at feed [s]."""

    @property
    def extent(self) -> str:
        """In words, for a step that is done."""
        stations = sum(len(each.stations) for each in self.simulation.stretches)
        return f"{counted(stations, 'station')}, cells of {format_length(self.simulation.resolution)}"

    def fed(self, toolpath: ToolPath) -> ToolPath:
        """The program with the speeds that its cut allows in place of its feeds."""
        profile = self.toolpath.speed_profile
        return toolpath if profile is None else toolpath.fed_by(profile)


def plan_within_cut(
    toolpath: ToolPath,
    machine: Machine,
    setup: SetUp,
    rules: FeedRules,
    tip_tolerance: float | Tolerances = 10e-6,
    axis_tolerance: float | Tolerances = 1e-3,
    *,
    effort: str = "normal",
    planner: str | Planner = "optimal",
    margin: float = 0.0,
    resolution: float | None = None,
    memory: float = MEMORY,
    reached: Floats | None = None,
    progress: Callable[[float], None] | None = None,
) -> CutLimitedPlan:
    """The fastest motion of a tool path within the limits of a machine whose cut is as `rules` allow.

    Stock and tools are those of a set-up sheet; resolution and memory as for `simulate_cut`, the rest as for
    `plan_program`. margin: how far before and behind a place what its cut allows holds [m], in place of that of
    `rules`. reached: (points,) speed that the control reaches on the way to each point, by which `learned`
    teaches [m/s]; None: that of the motion of the program's feeds. On a guessed stock no speed is above the program's.
    Raises as these two, and UsageError where `rules` need a figure that nothing tells.
    """
    check_toolpath(toolpath, "plan_within_cut")
    rules = replace(rules, steps=Steps(margin, FINE, 0.0))
    report = CallersProgress(progress)

    def part(begin: float, end: float) -> Callable[[float], None]:
        return lambda share: report(begin + (end - begin) * share)

    tools = [setup.figures_of(each.tool, each.figures) for each in toolpath.operations]
    tolerances = tip_tolerance, axis_tolerance

    def cut(trajectory: Trajectory, tell: Callable[[float], None]) -> tuple[CutSimulation, FeedPlan]:
        simulation = simulate_cut(
            trajectory, toolpath, setup, resolution=resolution, memory=memory, progress=tell
        )
        return simulation, plan_feeds(simulation, toolpath, tools, rules, reached)

    first = plan_program(toolpath, machine, *tolerances, effort="low", progress=part(0.0, 0.15))
    simulation, feeds = cut(first.trajectory, part(0.15, 0.3))
    limited = with_profile(toolpath, first.trajectory, simulation, feeds)
    found = plan_program(limited, machine, *tolerances, effort=effort, planner=planner, progress=part(0.3, 0.7))
    moved = first.trajectory
    if not same_path(found.path, first.path):
        moved = found.trajectory
        simulation, feeds = cut(found.trajectory, part(0.7, 0.85))
        limited = with_profile(toolpath, found.trajectory, simulation, feeds)
        path = carrying(found.path, limited)
        trajectory = plan(AxisPath.follow(path, machine), machine, planner=planner, progress=part(0.85, 1.0))
        found = replace(found, path=path, trajectory=trajectory)
    passed = [passed_at(moved, each.stations, found.trajectory) for each in fed_stretches(simulation)]
    report(1.0)
    return CutLimitedPlan(found, limited, simulation, feeds, tuple(passed))


def fed_stretches(simulation: CutSimulation) -> list[CutStretch]:
    """Those at feed with a way."""
    return [each for each in simulation.stretches if not each.rapid and len(each.stations) > 1]


def same_path(one: Path, other: Path) -> bool:
    """Whether two paths are the same curves."""
    pairs = list(zip(one.runs, other.runs))
    return len(one.runs) == len(other.runs) and all(
        a.breaks.shape == b.breaks.shape
        and np.array_equal(a.breaks, b.breaks)
        and all(
            x is None or y is None or np.array_equal(x, y)
            for x, y in zip(a.evaluate(a.breaks)[:3], b.evaluate(b.breaks)[:3])
        )
        for a, b in pairs
    )


def carrying(path: Path, toolpath: ToolPath) -> Path:
    """A path of a tool path with that one's feeds, least times and profile of speed."""

    def of_run(run: PathRun) -> PathRun:
        profile = toolpath.speed_profile
        along = None if profile is None else profile.along(ways_between(run.entry), run.block_start)
        entry = run.entry
        return replace(run, feed=toolpath.feed[entry], least_time=toolpath.least_time[entry], speed_profile=along)

    return replace(path, runs=tuple(map(of_run, path.runs)))


def with_profile(toolpath: ToolPath, trajectory: Trajectory, simulation: CutSimulation, feeds: FeedPlan) -> ToolPath:
    """A tool path whose ways at feed have, in place of their feeds, the speeds that the cut along a motion allows."""
    pieces = []
    limited = np.zeros(len(toolpath), dtype=np.bool_)
    for stretch, speed, source in zip(fed_stretches(simulation), feeds.feeds, feeds.sources):
        limited[np.unique(stretch.stations.point[1:])] = True
        # where the tip stands, the time of its turn is the program's
        pieces += _pieces(trajectory, stretch.stations, np.where(speed > 0.0, speed, np.inf), source)
    if not pieces:
        return toolpath
    place, most, source = (np.concatenate(each) for each in zip(*_with_gaps(pieces, len(toolpath) - 1)))
    limited &= (toolpath.way_length > 0.0) & ~toolpath.rapid
    highest = float(most[np.isfinite(most)].max(initial=0.0)) or np.inf
    return replace(
        toolpath,
        # one feed above all others: where feeds differ from block to block the cap would jump
        feed=np.where(limited, highest, toolpath.feed),
        least_time=np.where(limited, 0.0, toolpath.least_time),
        speed_profile=SpeedProfile(place, most, source, SOURCES),
    )


Piece = tuple[Floats, Floats, Ints]
"""Places, speeds there, and what sets the speed from each to the next."""


def _pieces(trajectory: Trajectory, stations: Stations, speed: Floats, source: Ints) -> list[Piece]:
    """The profile over neighbouring stations, a piece for each run; `speed` (n,) and `source` (n,) are those of the way
    to each station."""
    found = []
    for k, first, _, s in _parameters(trajectory, stations):
        on = np.concatenate([[0], np.flatnonzero(np.diff(np.maximum.accumulate(s)) > 0.0) + 1])
        if len(on) < 2:
            continue
        on = on[s[on] < s[-1]]
        on = np.append(on, len(s) - 1)
        # of ways that are none the next one's speed holds from where they stand
        s, of_way, sets = s[on], speed[first + on[1:]], source[first + on[1:]]
        most = at_stations(s, of_way)
        kept = few_places(s, most)
        start, entry = trajectory.axis_path.runs[k].entries()
        place = np.interp(s[kept], start, ways_between(entry))
        found.append((place, (1.0 - 0.5 * BELOW) * most[kept], _least(most, sets, kept)))
    return found


def at_stations(place: Floats, speed: Floats) -> Floats:
    """(n + 1,) most speed at stations, from that which the pose at the end of each way between them allows (n,).

    place: (n + 1,) of the stations along the path, ascending. Between two stations the speed may depart from a straight
    line: at an exit it bends, at an entry it jumps, nobody knows where. The slopes before and behind tell how much: a
    kink from one to the other departs by a quarter of what they differ by, and what their mean does not explain is a
    jump. Where that is more than DEPARTURE both stations are lowered by it, or the lower one holds at both, whichever
    costs less.
    """
    own = np.minimum(np.concatenate([speed[:1], speed]), UNLIMITED)
    way = np.diff(place)
    slope = np.diff(own) / way
    before, behind = np.append(slope[1:2], slope[:-1]), np.append(slope[1:], slope[-2:-1])
    if len(slope) == 1:
        before = behind = np.zeros(1)
    departs = 0.25 * np.abs(behind - before) * way + np.abs(slope - 0.5 * (before + behind)) * way
    low, high = np.minimum(own[:-1], own[1:]), np.maximum(own[:-1], own[1:])
    holds = departs > np.minimum(0.5 * (high - low), 0.5 * low)
    off = np.where(departs > DEPARTURE * low, departs, 0.0)
    found = own.copy()
    for ends in (slice(None, -1), slice(1, None)):
        found[ends] = np.minimum(found[ends], np.where(holds & (off > 0.0), low, own[ends] - off))
    return np.where(found < UNLIMITED, found, np.inf)


def _parameters(trajectory: Trajectory, stations: Stations) -> Iterator[tuple[int, int, int, Floats]]:
    """Of each run that neighbouring stations are in: its number, the first and the last station, and the parameters of
    these and all between."""
    run_of = _run_of(trajectory)[stations.point]
    run_of[0] = run_of[1]
    edges = [0, *np.flatnonzero(np.diff(run_of)).tolist(), len(run_of) - 1]
    for first, last in pairwise(edges):
        k = int(run_of[last])
        run, law = trajectory.axis_path.runs[k], trajectory.laws[k]
        s = law.at(np.clip(stations.time[first : last + 1] - trajectory.starts[k], 0.0, law.duration))[0]
        start, entry = run.entries()
        # at rest the law tells places by its times to a micrometre, and the profile must reach the end of a way
        s[0] = start[np.searchsorted(entry, stations.point[first + 1])]
        s[-1] = start[np.searchsorted(entry, stations.point[last]) + 1]
        yield k, first, last, s


def passed_at(cut: Trajectory, stations: Stations, trajectory: Trajectory) -> Floats:
    """(n,) when a motion [s] along the same path as that which was cut passes its stations."""
    found = np.zeros(len(stations))
    for k, first, last, s in _parameters(cut, stations):
        found[first : last + 1] = trajectory.starts[k] + trajectory.laws[k].times_at(np.maximum.accumulate(s))
    return found


def _least(most: Floats, sets: Ints, kept: Ints) -> Ints:
    """(k,) what sets the speed from each place that is kept to the next: that of the slowest way between them."""
    slowest = [low + int(most[low : high + 1].argmin()) for low, high in pairwise(kept.tolist())]
    found = sets[np.minimum(np.array(slowest, dtype=np.int64), len(sets) - 1)]
    return np.append(found, found[-1:])


def few_places(s: Floats, most: Floats) -> Ints:
    """Which places of a line through (s, most) (n,) are enough for one through (1 - BELOW / 2) of it there, that is
    nowhere above it, and nowhere below by more than BELOW.

    From each place on the last one that can be reached straight (Williams 1978, "An efficient algorithm for the
    piecewise linear approximation of planar curves"). Where the line is infinite each place is kept.
    """
    aim, least, n = most * (1.0 - 0.5 * BELOW), most * (1.0 - BELOW), len(s)
    kept = [0]
    while kept[-1] < n - 1:
        k = kept[-1]
        low, high, best = -np.inf, np.inf, k + 1
        for j in range(k + 1, n if np.isfinite(most[k]) else k + 1):
            if np.isinf(most[j]):
                break
            step = s[j] - s[k]
            if low <= (aim[j] - aim[k]) / step <= high:
                best = j
            low, high = max(low, (least[j] - aim[k]) / step), min(high, (most[j] - aim[k]) / step)
            if low > high:
                break
        kept.append(best)
    return np.array(kept, dtype=np.int64)


def _run_of(trajectory: Trajectory) -> Ints:
    """(points,) the run that leads to each point of the tool path."""
    entries = [run.entries()[1] for run in trajectory.axis_path.runs]
    last = np.array([entry[-1] for entry in entries])
    return np.minimum(np.searchsorted(last, np.arange(last[-1] + 1)), len(last) - 1).astype(np.int64)


def _with_gaps(pieces: list[Piece], last: int) -> list[Piece]:
    """The pieces with nothing limited between them, from 0 to the `last` place."""
    found: list[Piece] = []
    feed = SOURCES.index(FEED)
    for place, most, source in pieces:
        ends = np.array([np.inf])
        found.append((place[:1], ends, np.array([feed])))
        found.append((place, most, source))
        found.append((place[-1:], ends, np.array([feed])))
    nothing = np.array([np.inf]), np.array([feed])
    return [(np.array([0.0]), *nothing), *found, (np.array([float(last)]), *nothing)]
