"""What the tool does over time: in air or in material, removal rate, engagement, and the loads of the edge."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np

from toolpace.common.arrays import Bools, Floats, Ints
from toolpace.common.errors import UsageError
from toolpace.cutting.engagement.table import EngagementTable
from toolpace.cutting.forces.engaged import CutLoads, EngagedForces
from toolpace.cutting.forces.tool_beam import bends
from toolpace.cutting.simulation.operation_cut import CutStretch
from toolpace.cutting.simulation.simulate import CutSimulation
from toolpace.machine.cutting_tool import Coefficients
from toolpace.programs.tool_figures import ToolFigures
from toolpace.programs.toolpath import ToolPath

STATES = ("air", "cutting", "not sure", "rapid")
"""What the tool is doing; their order is that of the page's colours."""
RESTS = -1
"""The state of a tool that stands, or is changed."""
SHORTEST, MOST = 0.02, 6000
"""Least length of an interval [s], and most intervals."""
ANY = Coefficients(1e9, 1e9)
"""Where no force is shown: the chip does not depend on the material."""


Role = Literal["", "before", "after", "limit"]
"""Of a track among those of its panel, where feeds before and after are compared."""


@dataclass(frozen=True)
class Track:
    """A quantity over time."""

    name: str
    panel: str
    """Key of PANELS."""
    unit: str
    values: Floats
    """(k,) in the unit; 0 where nothing is cut; nan where there is no limit."""
    role: Role = ""


PANELS = {
    "program_feed": "Feed that the control reaches, mm/min",
    "removal": "Removal rate, cm³/min",
    "engagement": "Width and depth of the cut, mm",
    "chip": "Thickest chip, µm",
    "force": "Largest cutting force, N",
    "deflection": "Largest deflection of the tip, µm",
}
"""In the order in which they stand below each other."""
LOADS = ("force", "chip", "removal")
"""Panels whose values colour the path: the first that is there."""


@dataclass(frozen=True)
class CutTracks:
    """What happens in each of k intervals of time, equally long."""

    state: Ints
    """(k,) index in STATES of what the tool does in its middle; RESTS where it does nothing."""
    tracks: tuple[Track, ...]
    """The mean of the removal rate, of all else the largest."""

    def loads(self) -> list[tuple[int, Track]]:
        """What may colour the path: the tracks of force, else of the chip, else the removal rate, with their places."""
        panel = next((each for each in LOADS if any(track.panel == each for track in self.tracks)), "")
        return [(k, each) for k, each in enumerate(self.tracks) if each.panel == panel and each.role != "limit"]


def cut_tracks(
    simulation: CutSimulation, toolpath: ToolPath, duration: float, material: Coefficients | None = None
) -> CutTracks:
    """Those of a motion [s]; the chip where teeth and spindle speed are known, forces with a material."""
    edges = interval_edges(duration)
    count = len(edges) - 1
    state = np.full(count, RESTS)
    rows = {name: np.zeros(count) for name in ("removed", "width", "depth", "chip", "force", "deflection")}
    tools = tools_by_operation(simulation)
    loaded: set[str] = set()
    for each in simulation.stretches:
        time, engagement = each.stations.time, each.engagement
        rows["removed"] += spread(edges, time, engagement.removed)
        interval = Intervals(edges, time)
        state[interval.inside] = states_of(each)[interval.station]
        contact = each.contact(engagement)
        interval.raise_to(rows["width"], np.where(contact, engagement.width, 0.0))
        interval.raise_to(rows["depth"], np.where(contact, engagement.depth, 0.0))
        tool = None if each.rapid else tools.get(each.operation)
        for values, at in loads_of(each, tool, toolpath, material):
            found = {"chip": values.chip}
            if material is not None:
                found["force"] = values.resultant
            if material is not None and tool is not None and bends(tool):
                found["deflection"] = np.nan_to_num(values.deflection)
            loaded |= set(found)
            for name, peak in found.items():
                interval.raise_to(rows[name], np.where(at & contact, peak, 0.0))
    rate = rows["removed"] / np.diff(edges)
    tracks = [
        Track("removal rate", "removal", "cm³/min", 60e6 * rate),
        Track("width", "engagement", "mm", 1e3 * rows["width"]),
        Track("depth", "engagement", "mm", 1e3 * rows["depth"]),
        Track("chip", "chip", "µm", 1e6 * rows["chip"]),
        Track("force", "force", "N", rows["force"]),
        Track("deflection", "deflection", "µm", 1e6 * rows["deflection"]),
    ]
    shown = tuple(each for each in tracks if each.panel in ("removal", "engagement") or each.name in loaded)
    return CutTracks(state, shown)


def interval_edges(duration: float) -> Floats:
    """(k + 1,) ends of the intervals of a motion [s]."""
    count = int(np.clip(duration / SHORTEST, 1, MOST))
    found: Floats = np.linspace(0.0, duration, count + 1)
    return found


def tools_by_operation(simulation: CutSimulation) -> dict[int, ToolFigures | None]:
    """The tool of each operation that moves, by its index in the program."""
    moving = sorted({each.operation for each in simulation.stretches})
    return dict(zip(moving, (each.figures for each in simulation.operations)))


def loads_of(
    stretch: CutStretch, tool: ToolFigures | None, toolpath: ToolPath, material: Coefficients | None
) -> Iterator[tuple[CutLoads, Bools]]:
    """The loads at the stations of a stretch, at the speed of the motion, and at which of them (n,) they hold: at
    those of each spindle speed. None where tool, teeth or spindle speed are not known."""
    for forces, at in forces_of(stretch, stretch.engagement, tool, toolpath, material):
        try:
            loads = forces.along(stretch.stations)
        except UsageError:
            return
        yield loads, at


def forces_of(
    stretch: CutStretch,
    engagement: EngagementTable,
    tool: ToolFigures | None,
    toolpath: ToolPath,
    material: Coefficients | None,
) -> Iterator[tuple[EngagedForces, Bools]]:
    """Forces in an engagement of a stretch, and at which stations (n,) they are those of its spindle speed."""
    if tool is None or not tool.teeth or len(stretch.stations) < 2:
        return
    turns = np.abs(toolpath.spindle[stretch.stations.point])
    turns = np.where(np.isfinite(turns) & (turns > 0.0), turns, tool.spindle_speed or math.nan)
    for each in np.unique(turns[np.isfinite(turns)]).tolist():
        yield EngagedForces(engagement, tool, material or ANY, each), turns == each


class Intervals:
    """Which intervals of time a stretch fills, and with which of its stations."""

    def __init__(self, edges: Floats, time: Floats) -> None:
        middle = 0.5 * (edges[1:] + edges[:-1])
        # the way that the middle of an interval is on; of shorter ways the largest values
        self.inside = np.flatnonzero((middle >= time[0]) & (middle <= time[-1]))
        self.station = np.minimum(np.searchsorted(time, middle[self.inside]), len(time) - 1)
        self.interval = np.clip(np.searchsorted(edges, time, side="right") - 1, 0, len(middle) - 1)

    def raise_to(self, row: Floats, values: Floats) -> None:
        """Raise a row (k,) to the largest of the values (n,) of the stations in each interval."""
        row[self.inside] = np.maximum(row[self.inside], values[self.station])
        np.maximum.at(row, self.interval, values)


def spread(edges: Floats, time: Floats, amount: Floats) -> Floats:
    """(k,) of amounts on the way to each station (n,), how much falls between each two edges (k + 1,)."""
    if len(time) < 2:
        return np.zeros(len(edges) - 1)
    whole: Floats = np.diff(np.interp(edges, time, np.cumsum(amount) - amount[0]))
    return whole


def states_of(stretch: CutStretch) -> Ints:
    """(n,) index in STATES of the way to each station."""
    if stretch.rapid:
        return np.full(len(stretch.stations), STATES.index("rapid"))
    return np.where(stretch.air, 0, np.where(stretch.cutting, 1, 2))
