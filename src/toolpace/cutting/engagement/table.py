"""The engagement of a tool along a motion: at each station, the arcs of each slice of the tool that are in material.

Angles as in cutting/forces: phi is measured at the tool axis, seen from the spindle, from the normal on the left of
the feed, clockwise; 90 degrees is straight ahead. The feed is the motion of the tip from the station before, across the
axis; where the tool moves along its axis only (ACROSS), the last feed across it stands in, at first the frame's x.
"""

from __future__ import annotations

from dataclasses import dataclass, field, fields, replace

import numpy as np

from toolpace.common.arrays import Floats, Ints


@dataclass(frozen=True)
class EngagementTable:
    """Of n stations of one tool, with k arcs in all."""

    slice_height: float
    """Along the axis; slice j is from j to j + 1 of it above the tip [m]."""
    feed_direction: Floats
    """(n, 3) unit vector of the feed across the axis, workpiece frame."""
    across: Floats
    """(n,) share of the motion of the tip that is across the axis; -1 to 1 of the rest is along it (see `along`)."""
    along: Floats
    """(n,) share of the motion of the tip that is along the axis, above zero away from the tip."""
    first_arc: Ints
    """(n + 1,) arcs of station i are first_arc[i] to first_arc[i + 1]."""
    slice: Ints
    """(k,) of the tool, from the tip upwards."""
    entry: Floats
    """(k,) angle at which an edge enters material [rad], 0 to 2 pi."""
    exit: Floats
    """(k,) angle at which it leaves it, above `entry`, by 2 pi at most."""
    bottom: Floats
    """(n,) share of the end of the tool (flat bottom, point of a drill) that cuts, by area across the axis."""
    removed: Floats
    """(n,) volume removed on the way to the station [m3]."""
    width: Floats
    """(n,) most width of the cut across the feed, in any slice [m]."""
    depth: Floats
    """(n,) how far up the tool it is in material, from its lowest slice in material to its highest [m]."""
    top: Floats = field(default_factory=lambda: np.zeros(0))
    """(n,) height above the tip up to which it is in material, of its highest slice in material [m]: that slice counts
    from its lower end up to there. (0,) where it was not looked for: the whole slice counts."""
    penetration: Floats = field(default_factory=lambda: np.zeros((0, 2)))
    """(n, 2) how deep shank and holder are in material when the station is reached [m]: the largest distance of a point
    of them within material to its surface. They remove nothing themselves; what they met is removed at the end of a
    stretch, so that a collision is told once and with its whole depth. (0, 2) where it was not looked for."""
    chip_share: Floats = field(default_factory=lambda: np.zeros(0))
    """(n,) thickest chip over the feed per tooth of even teeth: how far the surface moves outward in material at most,
    over the way of the tip. It is looked for up to where material ends, which arcs tell to half a slice only. (0,)
    where it was not looked for, 0 where the tip stands."""

    def at(self, stations: Ints) -> EngagementTable:
        """Of some stations (m,)."""
        n, count = len(self.along), np.diff(self.first_arc)[stations]
        within = np.arange(int(count.sum())) - np.repeat(np.cumsum(count) - count, count)
        arc = np.repeat(self.first_arc[stations], count) + within
        own = {each.name: getattr(self, each.name) for each in fields(self) if each.name not in _OF_ARCS}
        of_stations = {name: value[stations] for name, value in own.items() if np.ndim(value) and len(value) == n}
        of_arcs = {name: getattr(self, name)[arc] for name in ("slice", "entry", "exit")}
        return replace(self, first_arc=np.append(0, np.cumsum(count)), **of_arcs, **of_stations)


_OF_ARCS = frozenset({"first_arc", "slice", "entry", "exit"})
