"""What a stretch of the motion cuts, station by station, and the sums of an operation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from toolpace.common.arrays import Bools, Floats
from toolpace.common.value_objects import counted, one_line
from toolpace.cutting.engagement.stations import Stations
from toolpace.cutting.engagement.table import EngagementTable
from toolpace.programs.tool_figures import ToolFigures
from toolpace.programs.toolpath import Operation

RATE_WINDOW = 0.05
"""Over how long a removal rate is a mean [s]: from one station to the next it jumps by the cells that are counted."""
THINNEST = 0.05
"""Share of the resolution: a layer that is thinner on its mean counts as none. Between two poses a round tool leaves
ridges that the next pass removes, of step^2 / (8 R): 0.005 mm for a step of 0.2 mm of a tool of 2 mm."""


@dataclass(frozen=True, eq=False, repr=False)
class CutStretch:
    """Neighbouring stations of one operation, all at feed or all at rapid; the first is where the motion comes from."""

    stations: Stations
    operation: int
    """Index of it in the program."""
    rapid: bool
    engagement: EngagementTable
    """With the stock as its figures are."""
    certain: EngagementTable
    """With the stock smaller by its uncertainty all round: what is cut in any case."""
    possible: EngagementTable
    """With the stock larger by it: nothing else can be cut."""
    removed_above: tuple[float, float, float]
    """Volume that shank and holder took out of the smallest, the nominal and the largest stock: where they meet it, it
    goes [m3]."""
    resolution: float
    """[m]"""

    def __repr__(self) -> str:
        kind = "rapid" if self.rapid else "feed"
        return one_line(self, kind, counted(len(self.stations), "station"), f"{self.removed * 1e9:.4g} mm3")

    @property
    def seconds(self) -> Floats:
        """(n,) time of the way to each station [s]; 0 to the first."""
        return self.stations.moving_time

    @property
    def removed(self) -> float:
        """Volume [m3]."""
        return float(self.engagement.removed.sum()) + self.removed_above[1]

    def contact(self, engagement: EngagementTable) -> Bools:
        """(n,) whether something is cut on the way to each station."""
        return in_contact(self.stations, engagement, self.resolution)

    @property
    def cutting(self) -> Bools:
        """(n,) whether something is cut in any case, wherever within its uncertainty the stock is."""
        return self.contact(self.certain)

    @property
    def air(self) -> Bools:
        """(n,) whether nothing can be cut, wherever within its uncertainty the stock is."""
        return ~(self.contact(self.possible) | self.contact(self.engagement) | self.cutting)


def in_contact(stations: Stations, engagement: EngagementTable, resolution: float) -> Bools:
    """(n,) whether a layer is cut that is thicker, on the mean over the way and the depth, than THINNEST of a cell."""
    step = np.linalg.norm(np.diff(stations.tip, axis=0, prepend=stations.tip[:1]), axis=1)
    height = np.maximum(np.maximum(engagement.depth, engagement.width), resolution)
    # where the tool only turns, or hardly moves, it sweeps an area of a cell's width at least
    swept = np.maximum(step, 0.05 * resolution) * height
    thick: Bools = engagement.removed > THINNEST * resolution * swept
    return thick


@dataclass(frozen=True)
class OperationCut:
    """What one operation cuts."""

    name: str
    tool: str
    """As the program calls it."""
    air: float
    """Time at feed in which nothing can be cut [s]."""
    cutting: float
    """Time at feed in which something is cut in any case [s]."""
    uncertain: float
    """Time at feed in which that depends on where, within its uncertainty, the stock ends [s]."""
    rapid: float
    """Time of its rapids [s]."""
    removed: float
    """Volume, with what rapids, shank and holder take [m3]."""
    removed_range: tuple[float, float]
    """The same of the least and the largest stock [m3]."""
    mean_rate: float
    """Volume that the edges take at feed, over the time in which something may be cut [m3/s]."""
    peak_rate: float
    """Most volume that the edges take at feed over RATE_WINDOW [m3/s]."""
    width: float
    """Most width of the cut across the feed, at feed [m]."""
    depth: float
    """Most depth of the cut along the tool axis, at feed [m]."""
    figures: ToolFigures | None = None
    """Of the tool; None where none was needed."""

    @property
    def feed_time(self) -> float:
        """Time at feed [s]."""
        return self.air + self.cutting + self.uncertain


def operation_cut(operation: Operation, figures: ToolFigures | None, stretches: Sequence[CutStretch]) -> OperationCut:
    """The sums of the stretches of one operation."""
    air = cutting = whole = rapid = width = depth = peak = at_feed = 0.0
    removed = np.zeros(3)
    for each in stretches:
        seconds = each.seconds
        removed += [engagement.removed.sum() for engagement in (each.certain, each.engagement, each.possible)]
        removed += each.removed_above
        if each.rapid:
            # what a crash takes is no cut
            rapid += float(seconds.sum())
            continue
        at_feed += float(each.engagement.removed.sum())
        peak = max(peak, float(removal_rate(each)[1].max(initial=0.0)))
        contact = each.contact(each.engagement)
        width = max(width, float(each.engagement.width[contact].max(initial=0.0)))
        depth = max(depth, float(each.engagement.depth[contact].max(initial=0.0)))
        whole += float(seconds.sum())
        air += float(seconds[each.air].sum())
        cutting += float(seconds[each.cutting].sum())
    loaded = whole - air
    return OperationCut(
        name=operation.name,
        tool=operation.tool,
        air=air,
        cutting=cutting,
        uncertain=max(whole - air - cutting, 0.0),
        rapid=rapid,
        removed=float(removed[1]),
        removed_range=(float(removed[0]), float(removed[2])),
        mean_rate=at_feed / loaded if loaded > 0.0 else 0.0,
        peak_rate=peak,
        width=width,
        depth=depth,
        figures=figures,
    )


def removal_rate(stretch: CutStretch) -> tuple[Floats, Floats]:
    """Times (k + 1,) [s], RATE_WINDOW apart, and the removal rate between each two (k,) [m3/s]."""
    time = stretch.stations.time
    count = max(1, round(float(time[-1] - time[0]) / RATE_WINDOW)) if len(time) > 1 else 1
    grid = np.linspace(time[0], time[-1], count + 1)
    volume = np.interp(grid, time, np.cumsum(stretch.engagement.removed))
    width = np.diff(grid)
    rate = np.divide(np.diff(volume), width, where=width > 0.0, out=np.zeros(count))
    return grid, rate


def feed_and_rapid(stations: Stations) -> list[tuple[Stations, bool]]:
    """A part of one operation, cut where rapids begin and end, and each rapid at the borders of its blocks.

    Each piece begins with the last station of the one before. What one rapid has gone through, the next does not meet.
    """
    rapid: Bools = stations.rapid[1:] if len(stations) > 1 else stations.rapid
    block = stations.block[1:] if len(stations) > 1 else stations.block
    changes = (np.diff(rapid) != 0) | ((np.diff(block) != 0) & rapid[1:])
    edges = [0, *(np.flatnonzero(changes) + 1).tolist(), len(rapid)]
    return [(stations.part(first, last + 1), bool(rapid[first])) for first, last in pairwise(edges)]
