"""The simulation of what a planned motion cuts.

simulate a cut:
  stations of the motion                    poses close together, by operation
  the stock, and the same smaller and larger by its uncertainty
  of each stretch at feed or at rapid, in the order of time:
    what cutting part, shank and holder meet, in each of the three stocks     engagement, removed volume
    what they meet of the finished part and of fixtures                       these are not cut
    findings
  sums by operation
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from toolpace.common.arrays import Bools, Floats
from toolpace.common.value_objects import counted, one_line
from toolpace.common.workers import CallersProgress
from toolpace.cutting.engagement.stations import Stations
from toolpace.cutting.engagement.table import EngagementTable
from toolpace.cutting.simulation.findings import (
    PART,
    STOCK,
    Contact,
    FeedWay,
    Finding,
    FindingKind,
    air_findings,
    findings_of,
    left_findings,
    worst_first,
)
from toolpace.cutting.simulation.left_above_part import LeftAbovePart, left_above_part
from toolpace.cutting.simulation.operation_cut import CutStretch, OperationCut, feed_and_rapid, operation_cut
from toolpace.cutting.simulation.stock_range import Met, Solids, Stock, StockRange, meet_all
from toolpace.cutting.stock.dexels import DexelStock
from toolpace.cutting.tool_profile import ToolProfile
from toolpace.programs.tool_figures import ToolFigures
from toolpace.programs.toolpath import Operation

TOLD = 0.2
"""Share of the resolution from which a collision is told: less may be the ridges that a cut leaves, and rounding."""
UNSEEN = 0.8
"""Share of the resolution from which a collision is told in any case: between the rays an edge or a corner of the stock
is seen up to 0.56 of a cell less deep than it is (on 1296 random places of a tilted cone at a box)."""


@dataclass(frozen=True)
class ToolInUse:
    """A tool of the program, as the simulation takes it."""

    figures: ToolFigures
    profile: ToolProfile


@dataclass(frozen=True)
class Surroundings:
    """What must not be cut."""

    finished_part: Stock | None = None
    gouge_tolerance: float = 0.0
    """By how much the tool may be below the finished part [m]."""
    fixtures: Mapping[str, Stock] | None = None
    part_mesh: Floats | None = None
    """The finished part as triangles (n, 3, 3) [m]: what is left above it is told; None: it is not."""


@dataclass(frozen=True, eq=False, repr=False)
class CutSimulation:
    """What a program cuts."""

    operations: tuple[OperationCut, ...]
    """Those that move, in the order of the program."""
    stretches: tuple[CutStretch, ...]
    """EngagementTable station by station, in the order of time."""
    findings: tuple[Finding, ...]
    """The worst first."""
    stock_volume: float
    """Before the program [m3]."""
    left_volume: float
    """After it [m3]."""
    left: StockRange
    """The stock after the program: that of the next one."""
    resolution: float
    """Size of a cell [m]."""
    smallest_contact: float
    """Collisions less deep may not be seen [m]."""
    above_part: LeftAbovePart | None = None
    """What is left above the finished part; None without one, and of a guessed stock."""
    assumed: tuple[str, ...] = ()
    """What stands in for what nobody told, a sentence each."""

    def __repr__(self) -> str:
        return one_line(
            self,
            counted(len(self.operations), "operation"),
            f"removed {self.removed_volume * 1e9:.6g} mm3",
            "guessed stock" if self.guessed else "",
            counted(len(self.collisions), "collision"),
        )

    @property
    def uncertainty(self) -> float:
        """How far the surface of the stock may be from where it is said to be [m]."""
        return self.left.uncertainty

    @property
    def guessed(self) -> bool:
        """Whether the stock is a guess: then neither air nor collisions with it are findings."""
        return self.left.guessed

    @property
    def removed_volume(self) -> float:
        """[m3]"""
        return float(sum(each.removed for each in self.operations))

    @property
    def air(self) -> float:
        """Time at feed in which nothing can be cut [s]."""
        return float(sum(each.air for each in self.operations))

    @property
    def cutting(self) -> float:
        """Time at feed in which something is cut in any case [s]."""
        return float(sum(each.cutting for each in self.operations))

    @property
    def collisions(self) -> tuple[Finding, ...]:
        """The findings that spoil tool, part or machine."""
        return tuple(each for each in self.findings if each.collision)


def cut_stations(
    parts: Sequence[Stations],
    operations: Sequence[Operation],
    tools: Sequence[ToolInUse | None],
    stock: StockRange,
    surroundings: Surroundings,
    *,
    resolution: float,
    assumed: Sequence[str] = (),
    after_operation: Callable[[int, Stock], None] = lambda operation, stock: None,
    progress: Callable[[float], None] | None = None,
) -> CutSimulation:
    """Cut a stock along stations, each part of one operation, with its tool; the stock is changed.

    tools: of each operation, None where it has none: what it does is passed over. `after_operation` is given the index
    in `CutSimulation.operations` of each operation when it ends, and the stock then.
    """
    report = CallersProgress(progress)
    before = stock.nominal.volume()
    count, done, ended = sum(len(part) for part in parts) or 1, 0, 0
    stretches: list[CutStretch] = []
    findings: list[Finding] = []
    for k, part in enumerate(parts):
        operation = int(part.operation[-1])
        tool = tools[operation]
        for stations, rapid in feed_and_rapid(part):
            if tool is not None:
                cut = _Cut(stock, surroundings, tool, TOLD * resolution, resolution)
                stretch, met = cut.along(stations, operation, rapid)
                stretches.append(stretch)
                findings += cut.findings(stretch, met, operations[operation], stock.guessed)
            done += len(stations)
            report(done / count)
        if tool is not None and (k + 1 == len(parts) or int(parts[k + 1].operation[-1]) != operation):
            after_operation(ended, stock.nominal)
            ended += 1
    above = None
    if surroundings.part_mesh is not None and not stock.guessed:
        above, more = _left(stretches, operations, stock, surroundings, TOLD * resolution)
        findings += more
    by_operation = [[each for each in stretches if each.operation == k] for k in range(len(operations))]
    if not stock.guessed:
        findings += air_findings(stretches, operations)
    return CutSimulation(
        operations=tuple(
            operation_cut(operation, None if tool is None else tool.figures, each)
            for operation, tool, each in zip(operations, tools, by_operation)
            if each
        ),
        stretches=tuple(stretches),
        findings=worst_first(findings),
        stock_volume=before,
        left_volume=stock.nominal.volume(),
        left=stock,
        resolution=resolution,
        smallest_contact=UNSEEN * resolution,
        above_part=above,
        assumed=tuple(assumed),
    )


def _left(
    stretches: Sequence[CutStretch],
    operations: Sequence[Operation],
    stock: StockRange,
    surroundings: Surroundings,
    least: float,
) -> tuple[LeftAbovePart, list[Finding]]:
    """What is left above the finished part, from `least` [m] on, and the findings of it."""
    assert surroundings.part_mesh is not None
    nominal, smallest = stock.nominal, stock.smallest
    assert isinstance(nominal, DexelStock) and isinstance(smallest, DexelStock)
    above = left_above_part(nominal, surroundings.part_mesh, max(surroundings.gouge_tolerance, least))
    middles = np.array([0.5 * (each.place + each.foot) for each in above.regions]).reshape(-1, 3)
    feeds = [
        FeedWay(each.stations, operations[each.operation].name, operations[each.operation].tool)
        for each in stretches
        if not each.rapid
    ]
    return above, left_findings(above.regions, smallest.contains(middles), feeds)


def reach_of(figures: ToolFigures) -> float:
    """How far above the tip the tool goes, with its holder [m]."""
    length = figures.stick_out or figures.flute_length or figures.diameter
    return length + sum(piece.length for piece in figures.holder)


class _Cut:
    """Cuts with one tool."""

    def __init__(
        self, stock: StockRange, surroundings: Surroundings, tool: ToolInUse, least: float, resolution: float
    ) -> None:
        self.stock, self.surroundings, self.tool = stock, surroundings, tool
        self.least, self.resolution = least, resolution

    def along(self, stations: Stations, operation: int, rapid: bool) -> tuple[CutStretch, list[Met]]:
        """The stretch, and what the tool met in each of the three stocks."""
        met = meet_all(self.stock, self.tool.profile, stations, rapid, self.least)
        certain, nominal, possible = (each.engagement for each in met)
        smallest, middle, largest = (each.removed_above for each in met)
        above = smallest, middle, largest
        return CutStretch(stations, operation, rapid, nominal, certain, possible, above, self.resolution), met

    def findings(self, stretch: CutStretch, met: Sequence[Met], operation: Operation, guessed: bool) -> list[Finding]:
        """What is wrong along a stretch."""
        words = operation.name, operation.tool
        contacts = list(self.with_surroundings(stretch))
        if not guessed:
            contacts += self.with_stock(stretch, met)
        return findings_of(stretch.stations, contacts, *words)

    def with_stock(self, stretch: CutStretch, met: Sequence[Met]) -> Iterator[Contact]:
        """Rapids, shank and holder in the stock, and cuts above the flutes."""
        smallest, nominal, largest = met
        above = whole_runs(largest.shank > self.least, self.above_flutes(largest.engagement))
        everywhere = np.ones(len(above), dtype=np.bool_)
        kinds: tuple[tuple[FindingKind, str, Bools], ...] = (
            ("rapid", "cutting", everywhere),
            ("flute", "shank", above),
            ("shank", "shank", ~above),
            ("holder", "holder", everywhere),
        )
        for kind, part, where in kinds:
            depths: list[Floats] = [getattr(each, part) for each in (smallest, nominal, largest)]
            depth = np.where(depths[1] > self.least, depths[1], depths[2])
            yield Contact(kind, STOCK, np.where(where & (depth > self.least), depth, 0.0), depths[0] > self.least)

    def above_flutes(self, engagement: EngagementTable) -> Bools:
        """(n,) whether the edge is in material up to its end, below a shank that is no wider: it is too short."""
        figures, count = self.tool.figures, len(engagement.removed)
        wide = max([figures.shank_diameter or 0.0, *(piece.lower_diameter for piece in figures.shank[:1])])
        if figures.flute_length is None or wide > figures.diameter * (1.0 + 1e-6):
            return np.zeros(count, dtype=np.bool_)
        top = np.zeros(count)
        station = np.repeat(np.arange(count), np.diff(engagement.first_arc))
        np.maximum.at(top, station, (engagement.slice + 1.0) * engagement.slice_height)
        reached: Bools = top > figures.flute_length - 1.5 * max(self.resolution, engagement.slice_height)
        return reached

    def with_surroundings(self, stretch: CutStretch) -> Iterator[Contact]:
        """The cutting part below the finished part, and any part in a fixture."""
        stations, around = stretch.stations, self.surroundings
        certain = np.ones(len(stations), dtype=np.bool_)
        if around.finished_part is not None:
            depth = around.finished_part.depth_in_material((self.tool.profile.cutting,), stations)
            # below this the cells cannot tell
            allowed = max(around.gouge_tolerance, self.least)
            yield Contact("gouge", PART, np.where(depth > allowed, depth, 0.0), certain)
        for name, fixture in (around.fixtures or {}).items():
            profile = self.tool.profile
            parts: tuple[tuple[FindingKind, Solids], ...] = (
                ("rapid" if stretch.rapid else "gouge", (profile.cutting,)),
                ("shank", profile.shank),
                ("holder", profile.holder),
            )
            for kind, solids in parts:
                depth = fixture.depth_in_material(solids, stations)
                yield Contact(kind, f"fixture {name}", np.where(depth > self.least, depth, 0.0), certain)


def whole_runs(contact: Bools, marked: Bools) -> Bools:
    """(n,) all of each run of neighbours in `contact` (n,) that one is `marked` (n,) of."""
    run = np.cumsum(np.diff(contact, prepend=False))
    found: Bools = contact & (np.bincount(run, marked & contact, int(run[-1]) + 1)[run] > 0.0)
    return found
