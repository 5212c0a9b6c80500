"""The largest loads of each tool, before and after."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.common.errors import UsageError
from toolpace.cutting.feeds.feed_moves import FeedMoves
from toolpace.cutting.forces.tool_beam import bends

RATE = 5
"""Stations over which a removal rate is a mean."""


@dataclass(frozen=True)
class LargestLoad:
    """The largest that a tool takes of one kind, where something may be cut, at the speeds before and after."""

    tool: str
    kind: str
    """chip [m], removal_rate [m3/s]; with a material force [N], torque [N m], power [W], deflection [m]."""
    before: float
    after: float


def largest_loads(
    written: FeedMoves, moves: FeedMoves, before: Sequence[Floats], after: Sequence[Floats]
) -> tuple[LargestLoad, ...]:
    """The largest loads of each tool, as the program is written and as its moves are after; of one whose figures do not
    tell them, none.

    before, after: speeds of each stretch on the way to each of its stations [m/s].
    """
    found: dict[tuple[str, str], Floats] = {}
    for k, stretch in enumerate(moves.stretches):
        tool, figures = moves.tool(stretch), moves.figures(stretch)
        try:
            loads = [_loads_at(each, k, speed[k]) for each, speed in ((written, before), (moves, after))]
        except UsageError:
            continue
        told = {"chip", "removal_rate"}
        if moves.rules.material_of(tool) is not None:
            told |= {"force", "torque", "power"} | ({"deflection"} if bends(figures) else set())
        for kind in told & set(loads[0]):
            most = found.setdefault((tool, kind), np.zeros(2))
            np.maximum(most, [each[kind] for each in loads], out=most)
    return tuple(LargestLoad(*key, float(a), float(b)) for key, (a, b) in sorted(found.items()))


def removal_rate(removed: Floats, way: Floats, feed: Floats) -> Floats:
    """(n,) volume in time [m3/s] at feeds (n,), from the volume removed (n,) on the way (n,) to each station.

    Between two stations the volume is counted in cells: over RATE of them it is known.
    """
    rate: Floats = np.divide(removed, way, out=np.zeros(len(way)), where=way > 0.0) * feed
    return np.convolve(rate, np.full(RATE, 1.0 / RATE), mode="same") if len(way) > RATE else rate


def _loads_at(moves: FeedMoves, k: int, feed: Floats) -> dict[str, float]:
    """The largest of each kind along stretch k at speeds (n,) [m/s]."""
    stretch, way = moves.stretches[k], moves.ways(k)
    rate = removal_rate(stretch.possible.removed, way, feed)
    largest: dict[str, float] = defaultdict(float, removal_rate=float(rate.max(initial=0.0)))
    for turns, at in moves.by_spindle(stretch):
        loads = moves.forces(stretch, stretch.possible, turns).loads(feed)
        kinds = {
            "chip": loads.chip, "force": loads.resultant, "torque": np.abs(loads.torque),
            "power": np.abs(loads.power), "deflection": np.nan_to_num(loads.deflection),
        }  # fmt: skip
        for kind, values in kinds.items():
            largest[kind] = max(largest[kind], float(values[at & ~stretch.air].max(initial=0.0)))
    return dict(largest)
