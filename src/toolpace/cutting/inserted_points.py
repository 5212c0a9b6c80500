"""A tool path with points inserted where the bending of the tool may change."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from toolpace.common.arrays import Bools, Floats, Ints
from toolpace.machine.machine import Machine
from toolpace.path.fit.polyline import great_circle
from toolpace.programs.toolpath import ToolPath, columns_at, no_normals

PARTS = 48
"""Points over the length of a blend: straight lines between them miss the blend by 0.2 percent of the bending."""
NEAR = 0.25
"""Share of their distance within which a point of the program stands for one that would be put in."""
CHUNK = 64
"""Of so many places one is kept in any case; a power of two."""


@dataclass(frozen=True)
class Places:
    """The points of a program and those between, at which bending is told."""

    toolpath: ToolPath
    """As it is programmed, of n points."""
    origin: Ints
    """(n,) point of the program that each is or leads to."""
    way: Floats
    """(n,) way of the tip up to each [m]."""

    def needed(self, shift: Floats, straight: float) -> Ints:
        """The places (k,) that a path shifted by (n, 3) [m] takes, to be within `straight` [m] between them."""
        return needed(self.way, shift, np.append(np.diff(self.origin) > 0, True), straight)

    def shifted(self, shift: Floats, kept: Ints) -> ToolPath:
        """The tool path of the places `kept` (k,), with its tips moved by `shift` (n, 3) [m]."""
        path = self.toolpath
        return replace(
            path,
            tip=path.tip[kept] + shift[kept],
            axis=path.axis[kept],
            feed=path.feed[kept],
            least_time=np.diff(np.cumsum(path.least_time)[kept], prepend=0.0),
            block=path.block[kept],
            stop=path.stop[kept],
            dwell=path.dwell[kept],
            rotary=None if path.rotary is None else path.rotary[kept],
            rapid=path.rapid[kept],
            operation=path.operation[kept],
            tip_tolerance=path.tip_tolerance[kept],
            axis_tolerance=path.axis_tolerance[kept],
            tool_length=path.tool_length[kept],
            bow=path.bow[kept],
        )


def places_of(toolpath: ToolPath, machine: Machine, cut: Ints, blend: float) -> Places:
    """The places of a program whose ways are cut where `cut` (n,) is not negative. Raises ReachError.

    Points are put in wherever bending can be, blended over a length [m]: that far about all that is cut.
    """
    steps = toolpath.way_length[1:]
    way = np.concatenate([[0.0], np.cumsum(steps)])
    between = _between(way, cut, blend)
    cell = np.searchsorted(way, between, side="right") - 1
    share = (between - way[cell]) / steps[cell]
    # each way: first the points put in, then its own
    order = np.argsort(np.concatenate([cell + share, np.arange(1.0, len(way))]), kind="stable")
    leads = np.concatenate([cell + 1, np.arange(1, len(way))])[order]
    part = np.concatenate([share, np.ones(len(way) - 1)])[order]
    origin = np.concatenate([[0], leads])
    dense = _with_points(toolpath, machine, origin, np.concatenate([[1.0], part]))
    return Places(dense, origin, np.cumsum(dense.way_length))


def _between(way: Floats, cut: Ints, blend: float) -> Floats:
    """Where along the way points are put in, ascending [m]."""
    step = blend / PARTS
    ways = np.flatnonzero(cut[1:] >= 0)
    low, high = way[ways] - blend, way[ways + 1] + blend
    # ends of ways ascend, so that stretches that touch are found by neighbours
    head = np.flatnonzero(np.concatenate([[True], low[1:] > high[:-1]]))
    low, high = low[head], np.append(high[head[1:] - 1], high[-1])
    first = np.ceil(np.maximum(low, 0.0) / step).astype(np.int64)
    count = np.floor(np.minimum(high, way[-1]) / step).astype(np.int64) + 1 - first
    count = np.maximum(count, 0)
    lattice = (np.arange(count.sum()) - np.repeat(np.cumsum(count) - count - first, count)) * step
    after = np.clip(np.searchsorted(way, lattice), 1, len(way) - 1)
    free = np.minimum(np.abs(lattice - way[after - 1]), np.abs(way[after] - lattice)) > NEAR * step
    found: Floats = lattice[free]
    return found


def _with_points(toolpath: ToolPath, machine: Machine, origin: Ints, share: Floats) -> ToolPath:
    """A tool path of points a share (k,) of the way to its points `origin` (k,)."""
    own = share == 1.0
    before, u = np.maximum(origin - 1, 0), share[:, None]
    tip = toolpath.tip[origin] - (1.0 - u) * toolpath.way[origin]
    tip[own] = toolpath.tip[origin[own]]
    rotary, axis = None, toolpath.axis[origin].copy()
    if toolpath.rotary is not None:
        chosen = machine.choose_rotary(toolpath)
        rotary = chosen[before] + u * (chosen[origin] - chosen[before])
        axis[~own] = machine.axis_at(rotary[~own])
    else:
        a, b = toolpath.axis[before[~own]], toolpath.axis[origin[~own]]
        axis[~own] = great_circle(a, b, u[~own])
    begins = np.concatenate([[True], own[:-1]])
    part = share - np.where(begins, 0.0, np.concatenate([[0.0], share[:-1]]))
    return replace(
        toolpath,
        tip=tip,
        axis=axis,
        least_time=toolpath.least_time[origin] * part,
        normal=no_normals(),
        rotary=rotary,
        rotary_joints=() if rotary is None else tuple(machine.geometry.rotary_joints),
        **columns_at(toolpath, origin, own),
    )


def needed(way: Floats, value: Floats, fixed: Bools, straight: float) -> Ints:
    """The places (k,) of n along a way [m] between which a value (n, d) is within `straight` of a straight line.

    All that are `fixed` are among them, both ends too. Between two of these, or in a CHUNK, every place is kept, or
    every second, fourth, ...: as few as do.
    """
    at = np.arange(len(way))
    corner = fixed | (at % CHUNK == 0) | (at == at[-1])
    corners = np.flatnonzero(corner)
    chunk = np.minimum(np.searchsorted(corners, at, side="right") - 1, len(corners) - 2)
    first, last = corners[chunk], corners[chunk + 1]
    stride = np.ones(len(corners) - 1, dtype=np.int64)
    for wider in 2 ** np.arange(1, CHUNK.bit_length()):
        before = first + (at - first) // wider * wider
        after = np.minimum(before + wider, last)
        whole = way[after] - way[before]
        share = (way - way[before]) / np.where(whole > 0.0, whole, 1.0)
        off = value - value[before] - share[:, None] * (value[after] - value[before])
        worst = np.maximum.reduceat(np.sqrt((off**2).sum(axis=1)), corners[:-1])
        stride[(worst <= straight) & (stride == wider // 2)] = wider
    return np.flatnonzero(corner | ((at - first) % stride[chunk] == 0))
