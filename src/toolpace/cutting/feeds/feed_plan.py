"""The feeds of a program by what it cuts.

of each tool, where a teacher or a limit is asked for
    what it takes at each station that may be cut (the largest stock), at the program's feeds
    what it surely takes (the smallest stock), at the speeds that are reached          teachers
of each stretch at feed
    most speed at each station      in air the feed of air; else the program's, the teachers', that of the limits
    in steps, with a margin         schedule
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from toolpace.common.arrays import Bools, Floats, Ints
from toolpace.common.errors import UsageError
from toolpace.cutting.engagement.stations import Stations
from toolpace.cutting.engagement.table import EngagementTable
from toolpace.cutting.feeds.learned import Taken, best_of, learned_speeds, teachers
from toolpace.cutting.feeds.limits import AIR, FEED, SOURCES, TAUGHT, CutLimits, speeds_within
from toolpace.cutting.feeds.rules import FeedRules
from toolpace.cutting.feeds.schedule import Places, over_window, slowest_within, stepped
from toolpace.cutting.forces.engaged import EngagedForces
from toolpace.cutting.simulation.operation_cut import CutStretch
from toolpace.cutting.simulation.simulate import CutSimulation
from toolpace.cutting.tool_profile import ToolProfile
from toolpace.machine.cutting_tool import Coefficients
from toolpace.programs.tool_figures import ToolFigures
from toolpace.programs.toolpath import ToolPath

WIDE = 3.0
"""Cells that a contact is wide or deep at least, to teach: what is narrower is known too coarsely."""
SHARE = 0.1
"""Of the volume of a tool that is removed at a feed at least, for it to be a feed at which the tool cuts."""
RATE = 5
"""Stations over which a removal rate is a mean."""
ANY = Coefficients(1e9, 1e9)
"""Where no force is asked for."""
STANDS = 1e-12
"""Speed of the tip below which it stands: the axis turns at a time of its own [m/s]."""


@dataclass(frozen=True)
class Teacher:
    """A place of the program whose load is taken as one that the tool bears."""

    line: int
    operation: str
    tool: str
    chip: float
    """[m]"""
    area: float
    """[m2]"""
    edge: float
    """[m]"""


@dataclass(frozen=True)
class Overload:
    """A place at which the program's feed, or any, is above a limit."""

    line: int
    tool: str
    limit: str
    share: float
    """The program's feed in that which the limits allow; of a limit that any feed is above, the load in the limit."""
    always: bool = False
    """Whether any feed is above it, since the edges alone are: the program's feed stays."""


@dataclass(frozen=True)
class OperationFeeds:
    """What becomes of one operation: times are the way over the feed [s]."""

    name: str
    tool: str
    before: float
    after: float


@dataclass(frozen=True)
class LargestLoad:
    """The largest that a tool takes of one kind, where something may be cut, at the feeds before and after."""

    tool: str
    kind: str
    """chip [m], removal_rate [m3/s]; with a material force [N], torque [N m], power [W], deflection [m]."""
    before: float
    after: float


@dataclass(frozen=True)
class FeedPlan:
    """New feeds of a program, stretch by stretch."""

    places: tuple[Places, ...]
    feeds: tuple[Floats, ...]
    """(n,) of each stretch, on the way to each of its stations [m/s]."""
    operations: tuple[OperationFeeds, ...]
    sources: tuple[Ints, ...] = ()
    """(n,) of each stretch likewise, what sets the feed: index in SOURCES."""
    teachers: tuple[Teacher, ...] = ()
    overloads: tuple[Overload, ...] = ()
    """The worst of each tool and limit."""
    largest: tuple[LargestLoad, ...] = ()
    """By tool and kind; of tools whose teeth and spindle speed are known."""
    notes: tuple[str, ...] = ()


def plan_feeds(
    simulation: CutSimulation,
    toolpath: ToolPath,
    tools: Sequence[ToolFigures | None],
    rules: FeedRules,
    reached: Floats | None = None,
) -> FeedPlan:
    """The feeds of a program by what it cuts; as they are where the stock is a guess.

    tools: figures of the tool of each operation. reached: (points,) speed that the control reaches on the way to each
    point of the program [m/s]; None: that of the motion that was cut. Raises UsageError where a figure is missing that
    `rules` need, and where they name a tool or an operation that the program does not have.
    """
    rules.check(toolpath)
    stretches = [each for each in simulation.stretches if not each.rapid and len(each.stations) > 1]
    places = tuple(Places.of(toolpath, each.stations) for each in stretches)
    own = toolpath.most_speed
    before = [np.where(np.isfinite(feed), feed, 0.0) for feed in (own[each.stations.point] for each in stretches)]
    work = _Planning(simulation, toolpath, tools, rules, reached, stretches, places, before)
    after = work.guessed() if simulation.guessed else work.feeds()
    return FeedPlan(
        places, tuple(after), work.operation_times(after), tuple(work.sources), tuple(work.teachers),
        work.overloads(), work.largest(after), tuple(work.notes),
    )  # fmt: skip


class _Planning:
    """The work on one program."""

    def __init__(
        self,
        simulation: CutSimulation,
        toolpath: ToolPath,
        tools: Sequence[ToolFigures | None],
        rules: FeedRules,
        reached: Floats | None,
        stretches: list[CutStretch],
        places: tuple[Places, ...],
        before: list[Floats],
    ) -> None:
        self.simulation, self.toolpath, self.tools, self.rules = simulation, toolpath, tools, rules
        self.reached, self.stretches, self.places, self.before = reached, stretches, places, before
        self.notes: list[str] = []
        self.teachers: list[Teacher] = []
        self.sources = [np.zeros(len(each), dtype=np.int64) for each in before]
        self.worst: dict[tuple[str, bool], Overload] = {}
        self.air_feed = rules.air_feed or max((float(each.max(initial=0.0)) for each in before), default=0.0)
        if rules.air_feed is None:
            feed = f"{self.air_feed * 60e3:g} mm/min"
            self.notes.append(f"in air: {feed}, the highest feed of the program (--air-feed)")

    def guessed(self) -> list[Floats]:
        """The feeds as they are."""
        self.notes.append(
            "the stock is a guess, and on a guess no feed is raised: tell it on the set-up sheet, "
            "like [stock] box = [[-10, -10, -20], [60, 40, 0]]"
        )
        return self.before

    def feeds(self) -> list[Floats]:
        """Those by the rules, of each stretch."""
        taught = self.taught() if self.rules.way == "learned" else {}
        return [self.of_stretch(k, taught) for k in range(len(self.stretches))]

    def of_stretch(self, k: int, taught: Mapping[tuple[str, float], Taken]) -> Floats:
        """(n,) the feeds of stretch k."""
        stretch, before, rules = self.stretches[k], self.before[k], self.rules
        name = self.toolpath.operations[stretch.operation].name
        if name in rules.left_alone:
            return before
        stands = before <= STANDS
        most = np.maximum(self.air_feed, before)
        speed = np.where(stretch.air, most, before)
        # above this the program's own feed is lowered
        bound = np.full(len(before), math.inf)
        source = np.where(stretch.air & (most > before), SOURCES.index(AIR), SOURCES.index(FEED))
        if rules.way != "air":
            loaded = ~stretch.air & ~stands
            cap, holds = self.cap(stretch, self.places[k], before, taught)
            lower = rules.lower or rules.way == "limits"
            bound = np.where(loaded & lower, cap, math.inf)
            cap = np.minimum(cap, most)
            if math.isfinite(rules.raise_at_most):
                cap = np.minimum(cap, rules.raise_at_most * before)
            speed = np.where(loaded, cap if lower else np.maximum(cap, before), speed)
            holds = np.where(speed < most, holds, SOURCES.index(AIR))
            source = np.where(loaded & (speed != before), holds, source)
        if not rules.finishing:
            speed = np.where(self.finishes(stretch, (speed > before) & ~stands), before, speed)
        place, steps = self.places[k], rules.steps
        self.sources[k] = source[slowest_within(place.way, speed, steps.margin)]
        kept = before
        if (bound < before).any():
            lowered = stepped(place, np.minimum(bound, most.max()), steps)
            within = over_window(place.way, bound, steps.margin, np.minimum)
            kept = np.where(within >= before, before, np.minimum(before, lowered))
        # a step of the feed may be below what the program has, and may keep
        return np.where(stands, before, np.maximum(stepped(place, speed, steps), kept))

    def cap(
        self, stretch: CutStretch, place: Places, before: Floats, taught: Mapping[tuple[str, float], Taken]
    ) -> tuple[Floats, Ints]:
        """(n,) most speed at each station by teachers or limits [m/s], the program's where neither tells anything; and
        what sets it: index in SOURCES."""
        tool, found = self.tool(stretch), before.copy()
        holds = np.full(len(before), SOURCES.index(FEED))
        speed, spindle = np.maximum(before, 1e-9), self.spindle(stretch)
        limits = self.rules.limits_of(tool)
        for turns in np.unique(spindle).tolist():
            at = spindle == turns
            if self.rules.way == "learned":
                taken = taught.get((tool, turns))
                if not taken:
                    continue
                forces = self.forces(stretch, stretch.possible, turns)
                allowed, teacher = learned_speeds(forces, taken, speed)
                # no feed makes an edge shorter that is longer than any teacher's
                allowed = np.where(teacher >= 0, allowed, before)
                sets = np.where(teacher >= 0, SOURCES.index(TAUGHT), SOURCES.index(FEED))
            elif limits.names:
                forces = self.forces(stretch, stretch.possible, turns)
                within = speeds_within(forces, place, limits, max(self.air_feed, float(before.max())))
                self.tell_overload(stretch, limits, 1.0 + np.where(at, within.exceeded, 0.0), True)
                allowed = np.where(within.exceeded > 0.0, before, within.speed)
                words = np.array([SOURCES.index(name.replace("_", " ")) for name in limits.names])
                sets = np.where(within.holds >= 0, words[within.holds], SOURCES.index(FEED))
                self.tell_overload(stretch, limits, np.where(at, before / allowed.clip(1e-12), 0.0), False)
            else:
                break
            # what is cut without a chip that is known has no load that is known
            allowed = np.where(forces.loads(speed).chip > 0.0, allowed, np.minimum(allowed, before))
            found, holds = np.where(at, allowed, found), np.where(at, sets, holds)
        return found, holds

    def tell_overload(self, stretch: CutStretch, limits: CutLimits, share: Floats, always: bool) -> None:
        """Keep the worst place of a tool at which the shares (n,) of its limits are above 1."""
        k, tool = int(share.argmax()), self.tool(stretch)
        if share[k] > 1.0 + 1e-6:
            found = Overload(int(stretch.stations.block[k]), tool, ", ".join(limits.names), float(share[k]), always)
            worst = self.worst.setdefault((tool, always), found)
            if worst.share < found.share:
                self.worst[tool, always] = found

    def taught(self) -> dict[tuple[str, float], Taken]:
        """The teachers of each tool at each spindle speed."""
        found: dict[tuple[str, float], list[tuple[CutStretch, Taken]]] = defaultdict(list)
        usual = self.cutting_feeds()
        for stretch, place, before in zip(self.stretches, self.places, self.before):
            tool = self.tool(stretch)
            wide = np.maximum(stretch.certain.width, stretch.certain.depth) > WIDE * stretch.resolution
            may = stretch.cutting & wide & (before <= usual.get(tool, 0.0) * (1.0 + 1e-9))
            speed = np.minimum(self.speed_reached(stretch), np.maximum(before, 1e-9))
            spindle = self.spindle(stretch)
            for turns in np.unique(spindle[may]).tolist():
                forces = self.forces(stretch, stretch.certain, turns)
                taken = teachers(forces, speed, place.way, may & (spindle == turns))
                found[tool, turns].append((stretch, taken))
        return {key: self.named(key[0], each) for key, each in found.items()}

    def named(self, tool: str, found: list[tuple[CutStretch, Taken]]) -> Taken:
        """The best of a tool, each told with its place."""
        lines = np.concatenate([stretch.stations.block[taken.station] for stretch, taken in found])
        which = np.concatenate([np.full(len(taken), stretch.operation) for stretch, taken in found])
        begins = np.cumsum([0, *(len(taken) for _, taken in found)])
        best = best_of(
            [replace(taken, station=begin + np.arange(len(taken))) for begin, (_, taken) in zip(begins, found)]
        )
        for k, at in enumerate(best.station.tolist()):
            operation = self.toolpath.operations[int(which[at])].name
            loads = float(best.chip[k]), float(best.area[k]), float(best.edge[k])
            self.teachers.append(Teacher(int(lines[at]), operation, tool, *loads))
        return best

    def cutting_feeds(self) -> dict[str, float]:
        """Of each tool the highest feed at which it surely cuts SHARE of all that it removes [m/s]."""
        by_tool: dict[str, list[tuple[Floats, Floats]]] = {}
        for stretch, before in zip(self.stretches, self.before):
            by_tool.setdefault(self.tool(stretch), []).append((before, stretch.certain.removed))
        found = {}
        for tool, parts in by_tool.items():
            feed, removed = (np.concatenate([part[k] for part in parts]) for k in range(2))
            order = np.argsort(-feed, kind="stable")
            enough = np.cumsum(removed[order]) >= SHARE * removed.sum()
            found[tool] = float(feed[order][enough.argmax()]) if removed.sum() > 0.0 else 0.0
        return found

    def finishes(self, stretch: CutStretch, asked: Bools) -> Bools:
        """(n,) which of some stations make a surface that is left at the end: a larger, lower tool is in it.

        A pass that finds nothing more to cut is one of them: it takes what bending left.
        """
        figures = self.figures(stretch)
        off = stretch.resolution
        wider = replace(
            figures,
            diameter=figures.diameter + 2.0 * off,
            corner_radius=figures.corner_radius + off if figures.corner_radius > 0.0 else 0.0,
        )
        stations = stretch.stations.where(asked)
        lower: Stations = replace(stations, tip=stations.tip - off * stations.axis)
        depth = self.simulation.left.nominal.depth_in_material((ToolProfile.of(wider).cutting,), lower)
        found = asked.copy()
        found[asked] = depth > 0.5 * off
        return found

    def speed_reached(self, stretch: CutStretch) -> Floats:
        """(n,) on the way to each station [m/s]."""
        stations = stretch.stations
        if self.reached is not None:
            reached: Floats = self.reached[stations.point]
            return reached
        steps = np.linalg.norm(np.diff(stations.tip, axis=0, prepend=stations.tip[:1]), axis=1)
        moved: Floats = np.divide(steps, stretch.seconds, out=np.zeros(len(steps)), where=stretch.seconds > 0.0)
        return moved

    def forces(self, stretch: CutStretch, engagement: EngagementTable, turns: float) -> EngagedForces:
        """Of the tool of a stretch in an engagement, at turns per second [1/s]."""
        coefficients = self.rules.material_of(self.tool(stretch)) or ANY
        return EngagedForces(engagement, self.figures(stretch), coefficients, abs(turns))

    def spindle(self, stretch: CutStretch) -> Floats:
        """(n,) turns per second [1/s], signed by the sense. Raises UsageError where nothing tells them."""
        figures = self.figures(stretch)
        speed = self.toolpath.spindle[stretch.stations.point]
        told = np.isfinite(speed) & (speed != 0.0)
        if not told.all() and figures.spindle_speed is None:
            raise UsageError(
                f"tool {self.tool(stretch)}: the spindle speed is not known; write spindle_speed in its table of the "
                "set-up sheet"
            )
        usual = figures.spindle_speed or 0.0
        return np.where(told, speed, usual if figures.clockwise else -usual)

    def figures(self, stretch: CutStretch) -> ToolFigures:
        """Of the tool of a stretch: a stretch without one is not cut."""
        found = self.tools[stretch.operation]
        assert found is not None
        return found

    def tool(self, stretch: CutStretch) -> str:
        """As the program calls it."""
        return self.toolpath.operations[stretch.operation].tool

    def largest(self, after: Sequence[Floats]) -> tuple[LargestLoad, ...]:
        """The largest loads of each tool; of one whose figures do not tell them, none."""
        found: dict[tuple[str, str], Floats] = {}
        for stretch, place, *feeds in zip(self.stretches, self.places, self.before, after):
            tool, figures = self.tool(stretch), self.figures(stretch)
            try:
                loads = [self.loads_at(stretch, place, feed) for feed in feeds]
            except UsageError:
                continue
            told = {"chip", "removal_rate"}
            if self.rules.material_of(tool) is not None:
                told |= {"force", "torque", "power"} | ({"deflection"} if figures.stick_out is not None else set())
            for kind in told & set(loads[0]):
                most = found.setdefault((tool, kind), np.zeros(2))
                np.maximum(most, [each[kind] for each in loads], out=most)
        return tuple(LargestLoad(*key, float(a), float(b)) for key, (a, b) in sorted(found.items()))

    def loads_at(self, stretch: CutStretch, place: Places, feed: Floats) -> dict[str, float]:
        """The largest of each kind along a stretch at feeds (n,)."""
        way, spindle = np.diff(place.way, prepend=place.way[:1]), self.spindle(stretch)
        rate = np.divide(stretch.possible.removed, way, out=np.zeros(len(way)), where=way > 0.0) * feed
        # between two stations the volume is counted in cells: over RATE of them it is known
        rate = np.convolve(rate, np.full(RATE, 1.0 / RATE), mode="same") if len(way) > RATE else rate
        largest: dict[str, float] = defaultdict(float, removal_rate=float(rate.max(initial=0.0)))
        for turns in np.unique(spindle).tolist():
            loads = self.forces(stretch, stretch.possible, turns).loads(feed)
            kinds = {
                "chip": loads.chip, "force": loads.resultant, "torque": np.abs(loads.torque),
                "power": np.abs(loads.power), "deflection": np.nan_to_num(loads.deflection),
            }  # fmt: skip
            for kind, values in kinds.items():
                largest[kind] = max(largest[kind], float(values[spindle == turns].max(initial=0.0)))
        return dict(largest)

    def overloads(self) -> tuple[Overload, ...]:
        """The worst first."""
        return tuple(sorted(self.worst.values(), key=lambda each: -each.share))

    def operation_times(self, after: Sequence[Floats]) -> tuple[OperationFeeds, ...]:
        """By operation, in the order of the program."""
        times = np.zeros((len(self.toolpath.operations), 2))
        for stretch, place, *feeds in zip(self.stretches, self.places, self.before, after):
            way = np.diff(place.way, prepend=place.way[:1])
            for k, feed in enumerate(feeds):
                times[stretch.operation, k] += np.divide(way, feed, out=np.zeros(len(way)), where=feed > 0.0).sum()
        return tuple(
            OperationFeeds(each.name, each.tool, float(old), float(new))
            for each, (old, new) in zip(self.toolpath.operations, times)
            if old > 0.0
        )
