"""Feeds of a program and the loads at them, before and after, over the time of its motion.

Feeds are those that the control reaches by its model. Loads are of what may be cut (the largest stock), as limits are
held.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.common.errors import UsageError
from toolpace.cutting.feeds.feed_plan import FeedPlan
from toolpace.cutting.feeds.largest_loads import removal_rate
from toolpace.cutting.feeds.rules import FeedRules
from toolpace.cutting.feeds.schedule import Places
from toolpace.cutting.forces.tool_beam import bends
from toolpace.cutting.simulation.operation_cut import CutStretch
from toolpace.cutting.simulation.simulate import CutSimulation
from toolpace.programs.tool_figures import ToolFigures
from toolpace.programs.toolpath import ToolPath
from toolpace.results.workpiece.tracks import (
    CutTracks,
    Intervals,
    Role,
    Track,
    cut_tracks,
    forces_of,
    interval_edges,
    tools_by_operation,
)

KINDS = {
    "program_feed": ("mm/min", 60e3),
    "removal": ("cm³/min", 60e6),
    "chip": ("µm", 1e6),
    "force": ("N", 1.0),
    "deflection": ("µm", 1e6),
}
"""Panel to unit and the factor from SI."""
LIMITS = {"removal": "removal_rate", "chip": "chip", "force": "force", "deflection": "deflection"}
"""Panel to the field of CutLimits."""


def feed_tracks(
    plan: FeedPlan, simulation: CutSimulation, toolpath: ToolPath, duration: float, rules: FeedRules,
    reached: Sequence[Sequence[Floats]], turned: ToolPath,
) -> CutTracks:
    """Those of a plan of feeds over a motion [s], which is that of the program as it was.

    reached: before and after, of each stretch the speed on the way to each station (n,) [m/s]. turned: the program with
    the spindle speeds after.
    """
    edges = interval_edges(duration)
    rows: dict[tuple[str, Role], Floats] = {}
    tools = tools_by_operation(simulation)
    stretches = [each for each in simulation.stretches if not each.rapid and len(each.stations) > 1]
    for stretch, place, before, after in zip(stretches, plan.places, *reached):
        interval = Intervals(edges, stretch.stations.time)
        tool = tools.get(stretch.operation)
        name = toolpath.operations[stretch.operation].tool
        feeds: tuple[tuple[Role, Floats, ToolPath], ...] = (("before", before, toolpath), ("after", after, turned))
        for role, feed, path in feeds:
            for panel, values in loads_at(stretch, place, feed, tool, path, rules).items():
                row = rows.setdefault((panel, role), np.zeros(len(edges) - 1))
                interval.raise_to(row, values)
        for panel, limit in limits_of(rules, name).items():
            row = rows.setdefault((panel, "limit"), np.zeros(len(edges) - 1))
            interval.raise_to(row, np.full(len(after), limit))
    tracks = []
    for panel, (unit, scale) in KINDS.items():
        roles: tuple[Role, ...] = ("before", "after", "limit")
        for role in roles:
            if (panel, role) in rows:
                found = rows[panel, role]
                shown = np.where(found > 0.0, found, np.nan) if role == "limit" else found
                tracks.append(Track(role, panel, unit, scale * shown, role))
    state = cut_tracks(simulation, toolpath, duration).state
    return CutTracks(state, tuple(tracks))


def loads_at(
    stretch: CutStretch, place: Places, feed: Floats, tool: ToolFigures | None, toolpath: ToolPath, rules: FeedRules
) -> dict[str, Floats]:
    """By panel, (n,) at the stations of a stretch at speeds (n,) [m/s], in SI units."""
    way = np.diff(place.way, prepend=place.way[:1])
    rate = removal_rate(stretch.possible.removed, way, feed)
    found: dict[str, Floats] = {"program_feed": feed, "removal": rate}
    material = rules.material_of(toolpath.operations[stretch.operation].tool)
    for forces, at in forces_of(stretch, stretch.possible, tool, toolpath, material):
        try:
            loads = forces.loads(feed)
        except UsageError:
            break
        kinds: Mapping[str, Floats] = {"chip": loads.chip}
        if material is not None:
            kinds = {**kinds, "force": loads.resultant}
            if tool is not None and bends(tool):
                kinds = {**kinds, "deflection": np.nan_to_num(loads.deflection)}
        for panel, values in kinds.items():
            found[panel] = np.maximum(found.get(panel, np.zeros(len(feed))), np.where(at, values, 0.0))
    return found


def limits_of(rules: FeedRules, tool: str) -> dict[str, float]:
    """By panel, the limits of a tool that are shown, in SI units."""
    if rules.way != "limits":
        return {}
    found = rules.limits_of(tool)
    return {panel: value for panel, name in LIMITS.items() if (value := getattr(found, name)) is not None}
