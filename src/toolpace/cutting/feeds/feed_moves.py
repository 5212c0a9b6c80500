"""The moves at feed of a program that is cut: their tools, spindle speeds, feeds and forces."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from toolpace.common.arrays import Bools, Floats
from toolpace.common.errors import UsageError
from toolpace.cutting.engagement.table import EngagementTable
from toolpace.cutting.feeds.rules import FeedRules
from toolpace.cutting.feeds.schedule import Places
from toolpace.cutting.forces.engaged import EngagedForces
from toolpace.cutting.simulation.operation_cut import CutStretch
from toolpace.cutting.simulation.simulate import CutSimulation
from toolpace.machine.cutting_tool import Coefficients
from toolpace.programs.tool_figures import ToolFigures
from toolpace.programs.toolpath import ToolPath

ANY = Coefficients(1e9, 1e9)
"""Where no force is asked for."""


@dataclass(frozen=True)
class FeedMoves:
    """The stretches at feed of a program, each with its places and the program's feeds."""

    toolpath: ToolPath
    tools: Sequence[ToolFigures | None]
    """Of each operation."""
    rules: FeedRules
    reached: Floats | None
    """(points,) speed that the control reaches on the way to each point [m/s]; None: that of the motion."""
    stretches: tuple[CutStretch, ...]
    places: tuple[Places, ...]
    before: tuple[Floats, ...]
    """(n,) of each stretch, the program's feed on the way to each station [m/s], times the `ratio` of its operation,
    which is the same chip; 0 where none is known."""
    ratio: tuple[float, ...] = ()
    """Of each operation, its spindle speed over that of the program; empty where they are the same."""

    @classmethod
    def of(
        cls,
        simulation: CutSimulation,
        toolpath: ToolPath,
        tools: Sequence[ToolFigures | None],
        rules: FeedRules,
        reached: Floats | None,
        ratio: Sequence[float] = (),
    ) -> FeedMoves:
        """Those of a program that was cut; ratio: of the spindle speed of each operation to the program's."""
        stretches = tuple(each for each in simulation.stretches if not each.rapid and len(each.stations) > 1)
        own = toolpath.most_speed
        feeds = (own[each.stations.point] for each in stretches)
        return cls(
            toolpath, tools, rules, reached, stretches,
            tuple(Places.of(toolpath, each.stations) for each in stretches),
            tuple(
                np.where(np.isfinite(feed), feed, 0.0) * (ratio[each.operation] if ratio else 1.0)
                for each, feed in zip(stretches, feeds)
            ),
            tuple(ratio),
        )  # fmt: skip

    @property
    def highest(self) -> float:
        """Feed of the program [m/s]."""
        return max((float(each.max(initial=0.0)) for each in self.before), default=0.0)

    def ways(self, k: int) -> Floats:
        """(n,) length of the way to each station of stretch k [m]."""
        ways: Floats = np.diff(self.places[k].way, prepend=self.places[k].way[:1])
        return ways

    def time(self, k: int, feeds: Floats) -> Floats:
        """(n,) on the way to each station of stretch k at feeds (n,) [s]."""
        way = self.ways(k)
        times: Floats = np.divide(way, feeds, out=np.zeros(len(way)), where=feeds > 0.0)
        return times

    def operation(self, stretch: CutStretch) -> str:
        """Name of that of a stretch."""
        return self.toolpath.operations[stretch.operation].name

    def speed_reached(self, stretch: CutStretch) -> Floats:
        """(n,) on the way to each station [m/s]."""
        stations = stretch.stations
        if self.reached is not None:
            reached: Floats = self.reached[stations.point]
            return reached
        steps = np.linalg.norm(np.diff(stations.tip, axis=0, prepend=stations.tip[:1]), axis=1)
        moved: Floats = np.divide(steps, stretch.seconds, out=np.zeros(len(steps)), where=stretch.seconds > 0.0)
        return moved

    def ratio_of(self, stretch: CutStretch) -> float:
        """Of the spindle speed of a stretch to the program's."""
        return self.ratio[stretch.operation] if self.ratio else 1.0

    def forces(self, stretch: CutStretch, engagement: EngagementTable, turns: float) -> EngagedForces:
        """Of the tool of a stretch in an engagement, where the program has turns per second [1/s]. Raises UsageError
        without teeth."""
        tool, figures = self.tool(stretch), self.figures(stretch)
        _check_teeth(tool, figures)
        turns = abs(turns) * self.ratio_of(stretch)
        return EngagedForces(engagement, figures, self.rules.material_of(tool) or ANY, turns)

    def spindle(self, stretch: CutStretch) -> Floats:
        """(n,) turns per second of the program [1/s], signed by the sense. Raises UsageError where nothing tells
        them."""
        figures = self.figures(stretch)
        speed = self.toolpath.spindle[stretch.stations.point]
        told = _is_told(speed)
        _check_speed(self.tool(stretch), figures, told)
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

    def by_spindle(self, stretch: CutStretch, chosen: Bools | None = None) -> Iterator[tuple[float, Bools]]:
        """Each spindle speed that the program has in a stretch [1/s], and (n,) the stations that have it, of the chosen
        ones."""
        spindle = self.spindle(stretch)
        for turns in np.unique(spindle if chosen is None else spindle[chosen]).tolist():
            at = spindle == turns
            yield turns, at if chosen is None else at & chosen


def check_tools(toolpath: ToolPath, tools: Sequence[ToolFigures | None], rules: FeedRules) -> None:
    """Raise UsageError where `rules` need teeth or a spindle speed of a tool, and its figures do not tell them: before
    the work on a plan and a cut. tools: of each operation."""
    for k, (operation, figures) in enumerate(zip(toolpath.operations, tools)):
        cuts = (toolpath.operation == k) & ~toolpath.rapid
        if figures is None or not cuts[1:].any() or operation.name in rules.left_alone:
            continue
        if rules.way == "learned" or (rules.way == "limits" and rules.limits_of(operation.tool).names):
            _check_teeth(operation.tool, figures)
            _check_speed(operation.tool, figures, _is_told(toolpath.spindle[1:][cuts[1:]]))


def _is_told(speed: Floats) -> Bools:
    return np.asarray(np.isfinite(speed) & (speed != 0.0))


def _check_teeth(tool: str, figures: ToolFigures) -> None:
    if figures.teeth is None:
        raise UsageError(f"tool {tool}: the number of teeth is not known; write teeth in its table of the set-up sheet")


def _check_speed(tool: str, figures: ToolFigures, told: Bools) -> None:
    """told: whether the program tells it, at each place."""
    if not told.all() and figures.spindle_speed is None:
        raise UsageError(
            f"tool {tool}: the spindle speed is not known; write spindle_speed in its table of the set-up sheet"
        )
