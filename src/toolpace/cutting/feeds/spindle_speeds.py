"""Speeds of the spindle by operation, of those that the tool table allows: where the motion is faster at them.

    of operations that one S word governs, or more that hang together
        the speeds that range, cutting speed and stability chart allow     at the diameter and the depth of their cut
        of these that at which the cut takes the least time                the same chip, or that which limits allow
        none where it gains little, or a surface is made that stays

At the same feed per tooth forces are the same at any speed, as far as coefficients do not depend on it; power grows in
proportion. Where power is limited and the chip is not at its limit, a slower spindle with thicker chips may be faster.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np

from toolpace.common.arrays import Floats, Ints
from toolpace.common.errors import UsageError
from toolpace.cutting.engagement.table import EngagementTable
from toolpace.cutting.feeds.feed_moves import FeedMoves
from toolpace.cutting.feeds.feed_plan import finishing_stations
from toolpace.cutting.feeds.limits import speeds_within
from toolpace.cutting.feeds.rules import FeedRules
from toolpace.cutting.feeds.schedule import Places
from toolpace.cutting.forces.engaged import CutLoads, turning_of
from toolpace.cutting.simulation.operation_cut import CutStretch
from toolpace.cutting.simulation.simulate import CutSimulation
from toolpace.cutting.tool_profile import ToolProfile
from toolpace.programs.tool_figures import ToolFigures
from toolpace.programs.toolpath import ToolPath

SPEEDS = 7
"""That are tried between the least and the most, where limits hold: chips are thicker at the slower ones."""
STATIONS = 100
"""About how many are looked at, evenly spread: which speed is the fastest is asked, not by how much."""
WORTH = 0.02
"""Share of the time of what is cut that another speed gains at least."""
ROUND = 10.0 / 60.0
"""Speeds that are written are multiples of that, rounded down [1/s]."""
FINISHING = 0.01
"""Share of the time in the cut in which a surface may be made that stays."""


@dataclass(frozen=True)
class OperationSpeed:
    """The spindle speed of one operation."""

    name: str
    tool: str
    before: float
    """Turns per second of the program, the most of several [1/s]; nan where nothing tells them."""
    ratio: float
    """Of the new speed to that; 1 where it stays."""
    diameter: float
    """Largest diameter at which it cuts: of a tilted ball less than its own [m]; nan where it cuts nothing."""
    depth: float
    """Most depth of the cut along the axis [m]."""
    stable_depth: float
    """Depth above which the tool chatters at the new speed [m]; nan where nothing tells it."""
    line: int
    """Of the deepest cut."""
    reason: str
    """Why the speed is that."""

    @property
    def after(self) -> float:
        """Turns per second [1/s]."""
        return self.before * self.ratio

    @property
    def chatters(self) -> bool:
        """Whether the cut is deeper than what its stability chart has at that speed."""
        return self.depth > self.stable_depth


@dataclass(frozen=True)
class _Cut:
    """Stations of a stretch that may be cut, thinned out."""

    stretch: CutStretch
    turns: float
    """Of the program [1/s], signed."""
    engagement: EngagementTable
    places: Places
    way: Floats
    """(n,) that each stands for [m]."""
    before: Floats
    """(n,) feed of the program [m/s]."""
    turning: Floats
    """(n, 2) of the axis per metre [rad/m]."""


def spindle_speeds(
    simulation: CutSimulation,
    toolpath: ToolPath,
    tools: Sequence[ToolFigures | None],
    rules: FeedRules,
    together: Sequence[Collection[int]],
) -> tuple[OperationSpeed, ...]:
    """The spindle speed of each operation, in the order of the program.

    together: operations whose speeds can only be changed by one factor, by index; of the others the speed stays. Raises
    UsageError as `plan_feeds`.
    """
    moves = FeedMoves.of(simulation, toolpath, tools, rules, None)
    found: dict[int, OperationSpeed] = {}
    for group in together:
        ratio, reason = _Choice(simulation, moves, group).made()
        found |= {each: _told(moves, each, ratio, reason) for each in group}
    alone = "no S word of its own"
    return tuple(
        found[k] if k in found else _told(moves, k, 1.0, alone) for k in range(len(toolpath.operations))
    )


class _Choice:
    """The choice of one factor for some operations."""

    def __init__(self, simulation: CutSimulation, moves: FeedMoves, group: Collection[int]) -> None:
        self.simulation, self.moves, self.rules = simulation, moves, moves.rules
        self.stretches = [
            (k, each) for k, each in enumerate(moves.stretches)
            if each.operation in group and not each.air.all()
        ]  # fmt: skip

    def made(self) -> tuple[float, str]:
        """The factor, and why."""
        reason = self.stays()
        if reason:
            return 1.0, reason
        low, high, holds = self.bounds()
        if high < low:
            return 1.0, f"{holds} allows none of the range"
        # of one ratio for all, what is rounded down stays within the bounds
        before = max(abs(turns) for _, each in self.stretches for turns, _ in self.moves.by_spindle(each))
        high = max(math.floor(high * before / ROUND + 1e-9) * ROUND / before, low)
        ratios = np.geomspace(low, high, SPEEDS if self.rules.way == "limits" else 2)
        ratios = np.maximum(np.floor(ratios * before / ROUND + 1e-9) * ROUND / before, low)
        ratios[-1] = high
        steady = [each for each in ratios.tolist() if self.is_stable(each)]
        if not steady:
            return 1.0, "at each speed of the range the cut is deeper than its stability chart has"
        cuts = self.cuts()
        times = [self.time(cuts, each) for each in steady]
        best = int(np.argmin(times))
        own = self.time(cuts, 1.0) if low <= 1.0 <= high else math.inf
        if not times[best] < (1.0 - WORTH) * own:
            return 1.0, "no other speed of the range makes the cut 2 percent faster"
        return steady[best], holds if steady[best] >= high * (1.0 - 1e-9) else "the fastest within the limits"

    def stays(self) -> str:
        """Why no speed is looked for; empty where one is."""
        if not self.stretches:
            return "nothing is cut"
        if self.simulation.guessed:
            return "the stock is a guess"
        if any(self.moves.operation(each) in self.rules.left_alone for _, each in self.stretches):
            return "the operation is left as it is (--leave)"
        if any(self.moves.figures(each).spindle_range is None for _, each in self.stretches):
            return "the tool has no spindle_range on the set-up sheet"
        if not self.rules.finishing:
            cut = finishes = 0.0
            for k, each in self.stretches:
                time = self.moves.time(k, self.moves.before[k])
                cut += float(time[~each.air].sum())
                finishes += float(time[finishing_stations(self.simulation, self.moves, each, ~each.air)].sum())
            if finishes > FINISHING * cut:
                return "a surface is made that stays (--finishing)"
        return ""

    def bounds(self) -> tuple[float, float, str]:
        """Least and most factor, and what holds the most."""
        low, high, holds = 0.0, self.rules.raise_at_most, "raise_at_most"
        for _, each in self.stretches:
            figures = self.moves.figures(each)
            assert figures.spindle_range is not None
            diameter = cutting_diameter(each, figures)
            for turns, _ in self.moves.by_spindle(each):
                least, most = (speed / abs(turns) for speed in figures.spindle_range)
                low = max(low, least)
                if most < high:
                    high, holds = most, "spindle_range"
                if figures.cutting_speed is not None and diameter > 0.0:
                    fastest = figures.cutting_speed / (math.pi * diameter * abs(turns))
                    if fastest < high:
                        high, holds = fastest, f"cutting_speed at a diameter of {1e3 * diameter:.3g} mm"
        return low, high, holds

    def is_stable(self, ratio: float) -> bool:
        """Whether no cut is deeper than its stability chart has, as far as that reaches, that is not so already."""
        for _, each in self.stretches:
            chart, depth = self.moves.figures(each).stability, float(each.possible.depth[~each.air].max(initial=0.0))
            if chart is not None:
                for turns, _ in self.moves.by_spindle(each):
                    if depth > chart.least(abs(turns) * ratio, abs(turns) * ratio):
                        return False
        return True

    def cuts(self) -> list[_Cut]:
        """What is cut, thinned out to STATIONS."""
        found = []
        every = max(sum(int((~each.air).sum()) for _, each in self.stretches) // STATIONS, 1)
        for k, each in self.stretches:
            place, way = self.moves.places[k], self.moves.ways(k)
            turning = turning_of(each.stations.axis, place.way, each.possible)
            for turns, at in self.moves.by_spindle(each, ~each.air):
                chosen: Ints = np.flatnonzero(at)
                kept = chosen[::every]
                if not len(kept):
                    continue
                # each stands for the way up to the next
                stands_for = np.add.reduceat(way[chosen], np.arange(0, len(chosen), every))
                found.append(
                    _Cut(each, turns, each.possible.at(kept), Places(place.x[kept], np.cumsum(way[kept])),
                         stands_for, self.moves.before[k][kept], turning[kept])
                )  # fmt: skip
        return found

    def time(self, cuts: Sequence[_Cut], ratio: float) -> float:
        """What is cut takes [s] at a factor of the program's speed; inf where the spindle does not give enough."""
        return sum(float((each.way / self.speeds(each, ratio)).sum()) for each in cuts)

    def speeds(self, cut: _Cut, ratio: float) -> Floats:
        """(n,) of the tip [m/s]; those that the machine can do, and above zero."""
        tool, rules = self.moves.tool(cut.stretch), self.rules
        turns = abs(cut.turns) * ratio
        forces = self.moves.forces(cut.stretch, cut.engagement, turns)
        fastest = max(rules.air_feed or rules.machine_feed or self.moves.highest, float(cut.before.max(initial=0.0)))
        most = np.minimum(np.minimum(rules.raise_at_most * cut.before, fastest), math.inf)
        if rules.way == "limits":
            limits = rules.limits_of(tool, turns)
            if limits.names:
                within = speeds_within(forces, cut.places, limits, fastest, cut.turning)
                allowed = np.where(within.exceeded > 0.0, cut.before, within.speed)
                return np.maximum(np.minimum(allowed, most), 1e-9)
        speed = np.minimum(ratio * cut.before, most)
        if rules.material_of(tool) is not None and not self.gives(forces.loads(speed), turns, cut, ratio):
            return np.full(len(speed), 1e-9)
        return np.maximum(speed, 1e-9)

    def gives(self, loads: CutLoads, turns: float, cut: _Cut, ratio: float) -> bool:
        """Whether the spindle gives torque and power for these loads, at another speed than the program's."""
        spindle = self.rules.spindle
        torque = spindle.torque is None or float(np.abs(loads.torque).max(initial=0.0)) <= spindle.torque.at(turns)
        power = spindle.power is None or float(np.abs(loads.power).max(initial=0.0)) <= spindle.power.at(turns)
        return ratio == 1.0 or (torque and power)


def cutting_diameter(stretch: CutStretch, figures: ToolFigures) -> float:
    """Largest diameter at which the tool of a stretch may cut [m]; 0 where it cuts nothing."""
    profile, table = ToolProfile.of(figures), stretch.possible
    loaded = np.repeat(~stretch.air, np.diff(table.first_arc))
    slices = np.unique(table.slice[loaded])
    # a slice is in material where its middle is: material may end just below the middle of the next one
    ends = np.concatenate([slices, slices + 1.5]) * table.slice_height
    at_end = 2.0 * profile.flat_radius if (table.bottom[~stretch.air] > 0.0).any() else 0.0
    if not len(slices):
        return at_end
    return max(2.0 * float(profile.surface(np.minimum(ends, profile.length))[0].max()), at_end)


def _told(moves: FeedMoves, operation: int, ratio: float, reason: str) -> OperationSpeed:
    """The speed of an operation with what it cuts."""
    toolpath = moves.toolpath
    own = [(k, each) for k, each in enumerate(moves.stretches) if each.operation == operation]
    before, diameter, depth, line, stable = math.nan, math.nan, 0.0, 0, math.nan
    for _, each in own:
        loaded = ~each.air
        if not loaded.any():
            continue
        figures = moves.figures(each)
        try:
            turns = float(np.abs(moves.spindle(each)[loaded]).max())
        except UsageError:
            continue
        before = np.fmax(before, turns)
        diameter = np.fmax(diameter, cutting_diameter(each, figures))
        deepest = int(np.where(loaded, each.possible.depth, 0.0).argmax())
        if each.possible.depth[deepest] > depth:
            depth, line = float(each.possible.depth[deepest]), int(each.stations.block[deepest])
        if figures.stability is not None:
            stable = figures.stability.least(before * ratio, before * ratio)
    name = toolpath.operations[operation]
    return OperationSpeed(
        name.name, name.tool, float(before), ratio, float(diameter), depth, stable, line, reason
    )
