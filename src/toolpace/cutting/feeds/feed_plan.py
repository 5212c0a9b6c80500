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
from toolpace.common.units import format_time
from toolpace.cutting.engagement.stations import Stations
from toolpace.cutting.feeds.feed_moves import FeedMoves
from toolpace.cutting.feeds.learned import Teacher, learned_speeds
from toolpace.cutting.feeds.limits import AIR, FEED, SOURCES, TAUGHT, CutLimits, speeds_within
from toolpace.cutting.feeds.rules import FeedRules
from toolpace.cutting.feeds.schedule import Places, over_window, slowest_within, stepped
from toolpace.cutting.feeds.teaching import HEAVIEST, Taught, taught
from toolpace.cutting.forces.engaged import CutLoads, turning_of
from toolpace.cutting.simulation.operation_cut import CutStretch
from toolpace.cutting.simulation.simulate import CutSimulation
from toolpace.cutting.stock.solids import guessed_stock
from toolpace.cutting.tool_profile import ToolProfile
from toolpace.programs.tool_figures import ToolFigures
from toolpace.programs.toolpath import ToolPath

STANDS = 1e-12
"""Speed of the tip below which it stands: the axis turns at a time of its own [m/s]."""


HARDLY = 0.02
"""Share by which the time may grow where the heaviest time teaches nothing, before that is told."""
RUBBING = 4e-6
"""Feed per tooth below which an edge may rub [m]: a third of the radius of an edge of carbide (5 to 15 um), about where
chips begin to form (Vogler, DeVor and Kapoor, J. Manuf. Sci. Eng. 126 (2004): 0.2 to 0.3 of the radius in steel)."""
SHOWN = 0.05
"""Time from which it is told [s]."""
REASONS = (
    "something may be cut there",
    "within the margin of a cut, or shorter than feeds are changed for",
    "in air as fast as air allows, or within the margin of a cut",
    "the operation is left as it is (--leave)",
    "a surface is made that stays (--finishing)",
    "no teacher or limit is for that tool and spindle speed",
    "as heavy as a teacher, or beside a place that is",
    "the edge in material is longer than a teacher's",
    "at a limit, or beside a place that is",
    "the edges alone are above a limit",
)
MAY_CUT, NEAR_CUT, IN_AIR, LEFT, FINISHES, NOT_TOLD, AS_TAUGHT, LONG_EDGE, AT_LIMIT, EDGES = range(len(REASONS))
"""Why a feed stays."""


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
class KeptFeed:
    """For how long the program's feed stays, and why."""

    reason: str
    seconds: float
    lines: tuple[tuple[int, int], ...] = ()
    """First and last line of each stretch of neighbouring lines of which some of the way keeps its feed so."""

    def told(self, most: int) -> str:
        """A sentence, with at most so many stretches of lines."""
        where = ", ".join(f"{a}" if a == b else f"{a} to {b}" for a, b in self.lines[:most])
        more = ", ..." if len(self.lines) > most else ""
        return f"as it was for {format_time(self.seconds)}: {self.reason}; lines {where}{more}"


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
    """Each at one angle of the tool, several of a line; `by_line` takes one of each."""
    overloads: tuple[Overload, ...] = ()
    """The worst of each tool and limit."""
    notes: tuple[str, ...] = ()
    kept: tuple[KeptFeed, ...] = ()
    """The longest first."""


def plan_feeds(
    simulation: CutSimulation,
    toolpath: ToolPath,
    tools: Sequence[ToolFigures | None],
    rules: FeedRules,
    reached: Floats | None = None,
    ratio: Sequence[float] = (),
) -> FeedPlan:
    """The feeds of a program by what it cuts; as they are where the stock is a guess.

    tools: figures of the tool of each operation. reached: (points,) speed that the control reaches on the way to each
    point of the program [m/s]; None: that of the motion that was cut. ratio: of the spindle speed of each operation to
    the program's, see `spindle_speeds`; empty: the same. Raises UsageError where a figure is missing that `rules`
    need, and where they name a tool or an operation that the program does not have.
    """
    rules.check(toolpath)
    written = FeedMoves.of(simulation, toolpath, tools, rules, reached)
    moves = FeedMoves.of(simulation, toolpath, tools, rules, reached, ratio) if len(ratio) else written
    work = _Planning(simulation, moves, written)
    after = work.guessed() if simulation.guessed else work.feeds()
    kept = sorted(work.kept.items(), key=lambda each: -each[1].sum())
    return FeedPlan(
        moves.places, tuple(after), work.operation_times(after), tuple(work.sources), tuple(work.teachers),
        work.overloads(), tuple(work.notes),
        tuple(
            KeptFeed(why, float(time.sum()), neighbours(np.flatnonzero(time > 0.0)))
            for why, time in kept if time.sum() >= SHOWN
        ),
    )  # fmt: skip


class _Planning:
    """The work on one program."""

    def __init__(self, simulation: CutSimulation, moves: FeedMoves, written: FeedMoves) -> None:
        self.simulation, self.moves, self.written, self.rules = simulation, moves, written, moves.rules
        self.notes: list[str] = []
        self.teachers: list[Teacher] = []
        self.sources = [np.full(len(each), SOURCES.index(FEED)) for each in moves.before]
        """(n,) of each stretch what sets its speeds; from `cap` on, which limit does where one does."""
        self.worst: dict[tuple[str, bool], Overload] = {}
        lines = int(moves.toolpath.block.max(initial=0)) + 1
        self.kept: dict[str, Floats] = defaultdict(lambda: np.zeros(lines))
        """By reason, time of each line that keeps its feed so [s]."""
        self.finishing = np.zeros(2)
        """Where a surface is made that stays: at the program's feed, and at that which all else would allow [s]."""
        self.times = np.zeros(2)
        """Of what is cut: with all teachers, and without the heaviest time [s]."""
        self.air_feed = self.rules.air_feed or self.rules.machine_feed or moves.highest
        if self.rules.air_feed is None:
            fastest = self.rules.machine_feed is None
            whose = "the highest feed of the program" if fastest else "as fast as the slowest linear axis"
            self.notes.append(f"in air: {self.air_feed * 60e3:.6g} mm/min, {whose} (--air-feed)")

    def guessed(self) -> list[Floats]:
        """The feeds as they are; what they might be is told."""
        before = list(self.moves.before)
        box = guessed_stock(self.moves.toolpath, self.moves.tools).solid.box
        corners = "" if box is None else f" = {[[round(1e3 * value, 1) for value in corner] for corner in box]}"
        try:
            times = np.array([[(each.before, each.after) for each in self.operation_times(self.feeds())]])
            old, new = times.reshape(-1, 2).sum(axis=0)
            might = f"; were it that, its {format_time(old)} at feed would be {format_time(new)}"
        except UsageError as error:
            might = f"; with a stock that is known it needs more: {error}"
        self.teachers, self.worst = [], {}
        self.kept.clear()
        self.notes.append(
            "the stock is a guess, and on a guess no feed is raised: tell it on the set-up sheet, like [stock] "
            f"box{corners}{might}"
        )
        return before

    def feeds(self) -> list[Floats]:
        """Those by the rules, of each stretch."""
        known = taught(self.written) if self.rules.way == "learned" else {}
        self.teachers = [each for key in sorted(known) for each in known[key].teachers]
        found = [self.of_stretch(k, known) for k in range(len(self.moves.stretches))]
        if self.times[1] > (1.0 + HARDLY) * self.times[0]:
            self.notes.append(
                f"the answer hangs on few teachers: without the heaviest {100.0 * HEAVIEST:g} percent of the time what "
                f"is cut would take {format_time(self.times[1])} in place of {format_time(self.times[0])}; look at them"
            )
        self.tell_rubbing()
        if self.finishing[0] - self.finishing[1] > SHOWN and not self.simulation.guessed:
            own, might = map(format_time, self.finishing.tolist())
            self.notes.append(
                f"for {own} the tool makes surfaces that stay, and keeps the program's feed: with --finishing these "
                f"places would take {might}, and their surface would be made at another feed"
            )
        return found

    def of_stretch(self, k: int, known: Mapping[tuple[str, float], Taught]) -> Floats:
        """(n,) the feeds of stretch k."""
        stretch, before, rules = self.moves.stretches[k], self.moves.before[k], self.rules
        why = np.where(stretch.air, NEAR_CUT if rules.way == "air" else IN_AIR, MAY_CUT)
        if self.moves.operation(stretch) in rules.left_alone:
            self.tell_kept(k, before, before, np.full(len(before), LEFT))
            return before
        stands = before <= STANDS
        most = np.maximum(self.air_feed, before)
        speed = np.where(stretch.air, most, before)
        # above this the program's own feed is lowered
        bound = np.full(len(before), math.inf)
        if rules.way != "air":
            loaded = ~stretch.air & ~stands
            cap, why = self.cap(k, known, why)
            lower = rules.lower or rules.way == "limits"
            bound = np.where(loaded & lower, cap, math.inf)
            cap = np.minimum(cap, most)
            if math.isfinite(rules.raise_at_most):
                cap = np.minimum(cap, rules.raise_at_most * self.written.before[k])
            speed = np.where(loaded, cap if lower else np.maximum(cap, before), speed)
        if not rules.finishing:
            finishes = finishing_stations(self.simulation, self.moves, stretch, (speed > before) & ~stands)
            self.finishing += [self.moves.time(k, each)[finishes].sum() for each in (before, speed)]
            speed, why = np.where(finishes, before, speed), np.where(finishes, FINISHES, why)
        place, steps = self.moves.places[k], rules.steps
        sets = np.where(why == AS_TAUGHT, SOURCES.index(TAUGHT), self.sources[k])
        sets = np.where((speed >= most) & (most > before), SOURCES.index(AIR), sets)
        sets = np.where(speed != before, sets, SOURCES.index(FEED))
        self.sources[k] = sets[slowest_within(place.way, speed, steps.margin)]
        kept = before
        if (bound < before).any():
            lowered = stepped(place, np.minimum(bound, most.max()), steps)
            within = over_window(place.way, bound, steps.margin, np.minimum)
            kept = np.where(within >= before, before, np.minimum(before, lowered))
        # a step of the feed may be below what the program has, and may keep
        found = np.where(stands, before, np.maximum(stepped(place, speed, steps), kept))
        self.tell_kept(k, before, found, why)
        return found

    def cap(self, k: int, known: Mapping[tuple[str, float], Taught], why: Ints) -> tuple[Floats, Ints]:
        """(n,) most speed at each station of stretch k by teachers or limits [m/s], the program's where neither tells
        anything; and (n,) what holds it."""
        moves, stretch, before = self.moves, self.moves.stretches[k], self.moves.before[k]
        tool, found, speed = moves.tool(stretch), before.copy(), np.maximum(before, 1e-9)
        why = np.where(why == MAY_CUT, NOT_TOLD, why)
        for turns, at in moves.by_spindle(stretch):
            limits = self.rules.limits_of(tool, abs(turns) * moves.ratio_of(stretch))
            if self.rules.way == "learned":
                if (tool, turns) not in known:
                    continue
                loads = moves.forces(stretch, stretch.possible, turns).loads(speed)
                held, allowed = self.learned(k, known[tool, turns], loads, at)
            elif limits.names:
                forces = moves.forces(stretch, stretch.possible, turns)
                # the axis turns as far on a way, however fast
                turning = turning_of(stretch.stations.axis, moves.places[k].way, stretch.possible)
                most = max(self.air_feed, float(before.max()))
                within = speeds_within(forces, moves.places[k], limits, most, turning)
                self.tell_overload(stretch, limits, 1.0 + np.where(at, within.exceeded, 0.0), True)
                allowed = np.where(within.exceeded > 0.0, before, within.speed)
                words = np.array([SOURCES.index(name.replace("_", " ")) for name in limits.names])
                holds = np.where(within.holds >= 0, words[within.holds], SOURCES.index(FEED))
                self.sources[k] = np.where(at, holds, self.sources[k])
                self.tell_overload(stretch, limits, np.where(at, before / allowed.clip(1e-12), 0.0), False)
                loads, held = forces.loads(speed), np.where(within.exceeded > 0.0, EDGES, AT_LIMIT)
            else:
                break
            # what is cut without a chip that is known has no load that is known
            allowed = np.where(loads.chip > 0.0, allowed, np.minimum(allowed, before))
            found = np.where(at, allowed, found)
            why = np.where(at & (why != IN_AIR), held, why)
        return found, why

    def learned(self, k: int, known: Taught, loads: CutLoads, at: Bools) -> tuple[Ints, Floats]:
        """(n,) what holds the speed, and the most speed by teachers, at stations `at` of stretch k."""
        before = self.moves.before[k]
        speed = np.maximum(before, 1e-9)
        found = []
        for taken in (known.best, known.hardly):
            allowed, teacher = learned_speeds(loads, taken, speed)
            # no feed makes an edge shorter that is longer than any teacher's
            found.append((np.where(teacher >= 0, allowed, before), teacher))
        cut = at & (loads.chip > 0.0) & (before > STANDS)
        most = np.maximum(np.minimum(self.air_feed, self.rules.raise_at_most * speed), speed)
        for j, (allowed, _) in enumerate(found):
            self.times[j] += self.moves.time(k, np.clip(allowed, speed, most))[cut].sum()
        allowed, teacher = found[0]
        return np.where(teacher >= 0, AS_TAUGHT, LONG_EDGE), allowed

    def tell_kept(self, k: int, before: Floats, after: Floats, why: Ints) -> None:
        """Add for how long feeds (n,) of a stretch stay, and why (n,)."""
        time = np.where(np.abs(after - before) <= 1e-9 * before, self.moves.time(k, before), 0.0)
        for each in np.unique(why[time > 0.0]).tolist():
            there = why == each
            np.add.at(self.kept[REASONS[each]], self.moves.stretches[k].stations.block[there], time[there])

    def tell_rubbing(self) -> None:
        """Note how long each tool cuts chips that are thinner than its edge is sharp."""
        times: dict[str, float] = defaultdict(float)
        for k, stretch in enumerate(self.moves.stretches):
            if self.moves.figures(stretch).teeth is None:
                continue
            for turns, at in self.moves.by_spindle(stretch, stretch.cutting):
                forces, feed = self.written.forces(stretch, stretch.certain, turns), self.written.before[k]
                thin = at & (feed / (abs(turns) * forces.tooth_count) < RUBBING)
                times[self.moves.tool(stretch)] += float(self.written.time(k, feed)[thin].sum())
        self.notes += [
            f"tool {tool}: for {format_time(time)} it cuts less than {1e6 * RUBBING:g} um per tooth, which an edge of "
            "carbide hardly does: it may rub"
            for tool, time in times.items() if time > SHOWN
        ]  # fmt: skip

    def tell_overload(self, stretch: CutStretch, limits: CutLimits, share: Floats, always: bool) -> None:
        """Keep the worst place of a tool at which the shares (n,) of its limits are above 1."""
        k, tool = int(share.argmax()), self.moves.tool(stretch)
        if share[k] > 1.0 + 1e-6:
            found = Overload(int(stretch.stations.block[k]), tool, ", ".join(limits.names), float(share[k]), always)
            worst = self.worst.setdefault((tool, always), found)
            if worst.share < found.share:
                self.worst[tool, always] = found

    def overloads(self) -> tuple[Overload, ...]:
        """The worst first."""
        return tuple(sorted(self.worst.values(), key=lambda each: -each.share))

    def operation_times(self, after: Sequence[Floats]) -> tuple[OperationFeeds, ...]:
        """By operation, in the order of the program."""
        operations = self.moves.toolpath.operations
        times = np.zeros((len(operations), 2))
        for k, stretch in enumerate(self.moves.stretches):
            times[stretch.operation] += [self.moves.time(k, each[k]).sum() for each in (self.written.before, after)]
        return tuple(
            OperationFeeds(each.name, each.tool, float(old), float(new))
            for each, (old, new) in zip(operations, times)
            if old > 0.0
        )


def neighbours(lines: Ints) -> tuple[tuple[int, int], ...]:
    """First and last of each row of lines (n,) that ascend by one."""
    parts = np.split(lines, np.flatnonzero(np.diff(lines) > 1) + 1) if len(lines) else []
    return tuple((int(part[0]), int(part[-1])) for part in parts)


def finishing_stations(simulation: CutSimulation, moves: FeedMoves, stretch: CutStretch, asked: Bools) -> Bools:
    """(n,) which of some stations make a surface that is left at the end: a larger, lower tool is in it.

    A pass that finds nothing more to cut is one of them: it takes what bending left.
    """
    figures = moves.figures(stretch)
    off = stretch.resolution
    wider = replace(
        figures,
        diameter=figures.diameter + 2.0 * off,
        corner_radius=figures.corner_radius + off if figures.corner_radius > 0.0 else 0.0,
    )
    stations = stretch.stations.where(asked)
    lower: Stations = replace(stations, tip=stations.tip - off * stations.axis)
    depth = simulation.left.nominal.depth_in_material((ToolProfile.of(wider).cutting,), lower)
    found = asked.copy()
    found[asked] = depth > 0.5 * off
    return found
