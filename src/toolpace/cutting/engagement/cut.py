"""The engagement of a tool along stations, while the stock is cut.

    for each pose, at most a cell apart, so that ridges between them stay small:
        cut the stock at the poses more than two cells behind
        at a station: for each slice of the tool, at angles where it moves outward:
            depth in material; between one in and one outside, the border by bisection
    cut the rest

The stock is cut behind the pose looked at: what the tool moves into is then two cells thick in the direction of the
feed, where between two poses it is a few hundredths of a millimetre. The borders are those of the stock that is met.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Protocol

import numpy as np

from toolpace.common.arrays import Floats, Ints, numbers
from toolpace.common.errors import UsageError
from toolpace.cutting.engagement.stations import Stations
from toolpace.cutting.engagement.table import EngagementTable
from toolpace.cutting.tool_profile import ToolProfile

if TYPE_CHECKING:
    from toolpace.kernels.cutting.cut_along import Above
    from toolpace.kernels.cutting.dexels import Field
    from toolpace.kernels.cutting.intrusion import Blocks

RIDGE = 0.02
"""Most height of what is left between two poses, in cells."""
LEAST_CONTACT = 0.05
"""A contact that is nowhere deeper is not seen, in cells."""
SLICES = 60
"""Most slices, where no height is wanted."""
FOOT = 0.02
"""Height above the tip at which a cut is seen that is less deep than half a slice, in slices."""
PORTION = 4096
"""Poses after which is looked anew where material is left, for what is above the edge."""
FINEST = 16
"""Most poses in a cell's length of motion."""
SIDEWAYS = 1e-6
"""Share of the motion across the axis below which it counts as along it."""


class Dexels(Protocol):
    """What is cut: a `DexelStock`."""

    field: Field
    content: float | None

    @property
    def resolution(self) -> float:
        """Largest side of a cell [m]."""

    @property
    def bounds(self) -> tuple[Floats, Floats]:
        """Lowest and highest corner (3,) of the box about it [m]."""

    @property
    def frame(self) -> Floats:
        """Rows (3, 3): directions of the rays, in the frame of the part."""

    def volume(self) -> float:
        """[m3]"""

    def blocks(self) -> Blocks:
        """Where each block of rays has material."""

    def spare(self, nodes: int) -> None:
        """Have at least so many free nodes."""


def cut(stock: Dexels, profile: ToolProfile, stations: Stations, slice_height: float | None = None) -> EngagementTable:
    """Cut the stock with the cutting part of a tool along stations, and tell what it met at each.

    slice_height: of the table [m]; the stock's resolution, or a sixtieth of the edge, if that is more. The stock is
    changed. Between stations the tip goes straight and the axis turns evenly. UsageError for axes that are no unit
    vectors.
    """
    from toolpace.kernels.cutting.contact import Arcs, Slices
    from toolpace.kernels.cutting.cut_along import ARCS, Found, Poses, cut_along

    tip = numbers(stations.tip, "stations: tip", ("n", 3), unit="m")
    axis = numbers(stations.axis, "stations: axis", ("n", 3))
    n, cell, before = len(tip), stock.resolution, stock.volume()
    if len(axis) != n or np.abs(np.linalg.norm(axis, axis=1) - 1.0).max(initial=0.0) > 1e-6:
        raise UsageError("stations: axis holds no unit vectors, one for each tip; give directions of length 1")
    height = slice_height or max(cell, profile.length / SLICES)
    feed, across, along = feed_frames(tip, axis)
    tips, axes, travel, station, look = _poses(profile, tip, axis, cell)
    low, high = _heights(stock, profile, tips, axes)
    poses = Poses(tips @ stock.frame.T, axes @ stock.frame.T, travel, station, low, high, look)
    count = max(math.ceil(profile.length / height - 1e-9), 1)
    middles = height * (np.arange(count) + 0.5)
    surface = profile.surface(np.minimum(middles, profile.length))
    beyond = profile.surface(np.minimum(middles + height, profile.length))[0]
    foot = np.array([FOOT * height, *np.ravel(profile.surface(np.array([FOOT * height])))])
    slices = Slices(np.asarray(middles), *surface, beyond, foot, profile.flat_radius, height)
    zeros = [np.zeros(shape) for shape in (n, (n, 2), n, n, n, n, n)]
    found = Found(feed @ stock.frame.T, np.zeros(n, np.int64), *zeros)
    arcs = Arcs(np.empty(0, np.int64), np.empty(0), np.empty(0))
    progress: Ints = np.zeros(3, np.int64)
    for until in [*range(PORTION, len(poses.travel), PORTION), len(poses.travel)] if n else []:
        above = _above(stock, profile)
        done = False
        while not done:
            if progress[ARCS] + 64 * count > len(arcs.slice):
                more = max(256 * count, len(arcs.slice) // 2)
                arcs = Arcs(*(np.concatenate([each, np.empty(more, each.dtype)]) for each in arcs))
            stock.spare(_most_rays(stock, profile))
            least = LEAST_CONTACT * cell
            done = cut_along(
                stock.field, profile.cutting, above, slices, poses, found, arcs, progress, cell, least, until
            )
    stock.content = max(before - float(found.removed.sum()), 0.0)
    used = int(progress[ARCS])
    return EngagementTable(
        slice_height=height,
        feed_direction=feed,
        across=across,
        along=along,
        first_arc=np.concatenate([[0], found.last_arc]).astype(np.int64),
        slice=arcs.slice[:used].copy(),
        entry=arcs.entry[:used].copy(),
        exit=arcs.exit[:used].copy(),
        bottom=found.flat,
        removed=found.removed,
        width=found.width,
        depth=found.depth,
        top=found.top,
        penetration=found.penetration,
        chip_share=found.chip_share,
    )


def feed_frames(tip: Floats, axis: Floats) -> tuple[Floats, Floats, Floats]:
    """Direction of the feed across the axis (n, 3), and the shares (n,) of the motion across and along the axis."""
    motion = np.diff(tip, axis=0, prepend=tip[:1])
    along = np.einsum("ij,ij->i", motion, axis)
    feed = motion - along[:, None] * axis
    size, whole = np.linalg.norm(feed, axis=1), np.linalg.norm(motion, axis=1)
    moves = size > SIDEWAYS * whole
    # what stands in where there is none: the last one, made perpendicular to the axis of now
    last = np.maximum.accumulate(np.where(moves, np.arange(len(tip)), -1))
    stand_in = np.where((last < 0)[:, None], [1.0, 0.0, 0.0], feed[last] / np.where(moves, size, 1.0)[last, None])
    for other in (stand_in, np.array([[1.0, 0.0, 0.0]]), np.array([[0.0, 1.0, 0.0]])):
        flat = other - np.einsum("ij,ij->i", other + 0.0 * axis, axis)[:, None] * axis
        length = np.linalg.norm(flat, axis=1)
        use = ~moves & (length > 0.1)
        feed[use], size[use], moves = flat[use], length[use], moves | use
    share = along / np.where(whole > 0.0, whole, 1.0)
    return feed / size[:, None], np.sqrt(np.maximum(0.0, 1.0 - share**2)) * (whole > 0.0), share


def _poses(profile: ToolProfile, tip: Floats, axis: Floats, cell: float) -> tuple[Floats, Floats, Floats, Ints, Ints]:
    """Poses close enough to be cut one after the other: tip, axis, way, station of each, and whether it is one."""
    if not len(tip):
        return tip, axis, np.zeros(0), np.zeros(0, np.int64), np.zeros(0, np.int64)
    step, turn = np.diff(tip, axis=0), np.diff(axis, axis=0)
    most = np.maximum(
        np.linalg.norm(step, axis=1), np.linalg.norm(step + profile.length * turn, axis=1)
    ) + profile.radius * np.linalg.norm(turn, axis=1)
    spacing = np.full(len(most), min(cell, math.sqrt(8.0 * profile.radius * RIDGE * cell)))
    if profile.flat_radius > 0.0:
        # an edge that moves askew to the flat leaves teeth between two poses; so does one that a turning axis moves
        way = np.einsum("ij,ij->i", step, axis[1:])
        along = np.abs(way) + profile.flat_radius * np.linalg.norm(turn, axis=1)
        across = np.linalg.norm(step - way[:, None] * axis[1:], axis=1)
        teeth = along * across / np.maximum(along**2 + across**2, 1e-30)
        spacing = np.minimum(spacing, np.maximum(0.05 * cell / np.maximum(teeth, 1e-9), cell / FINEST))
    count = np.maximum(np.ceil(most / spacing - 1e-9), 1.0).astype(np.int64)
    station = np.concatenate([[0], np.repeat(np.arange(1, len(tip)), count)])
    ends = np.concatenate([[0], np.cumsum(count)])
    before = np.maximum(station - 1, 0)
    share = (np.arange(len(station)) - ends[before]) / np.concatenate([count, [1]])[before]
    share[0] = 0.0
    last = np.minimum(before + 1, len(tip) - 1)
    tips = tip[before] + share[:, None] * (tip[last] - tip[before])
    axes = axis[before] + share[:, None] * (axis[last] - axis[before])
    axes /= np.linalg.norm(axes, axis=1)[:, None]
    travel = np.concatenate([[0.0], np.cumsum(np.repeat(most / count, count))])
    look = np.zeros(len(station), np.int64)
    look[ends] = 1
    return tips, axes, travel, station, look


def _heights(stock: Dexels, profile: ToolProfile, tip: Floats, axis: Floats) -> tuple[Floats, Floats]:
    """Between which heights above the tip (m,) the tool may meet the box about the stock."""
    low, high = np.zeros(len(tip)), np.full(len(tip), profile.length)
    for d in range(3):
        lean = axis[:, d]
        reach = profile.radius * np.sqrt(np.maximum(1.0 - lean**2, 0.0))
        least, most = stock.bounds[0][d] - reach - tip[:, d], stock.bounds[1][d] + reach - tip[:, d]
        # across a direction all heights are alike: a lean too small to divide by is as good as none
        safe = np.where(np.abs(lean) > 1e-12, lean, np.inf)
        a, b = np.minimum(least / safe, most / safe), np.maximum(least / safe, most / safe)
        across = np.isinf(safe)
        outside = across & ((least > 0.0) | (most < 0.0))
        low = np.where(across, np.where(outside, 1.0, low), np.maximum(low, a))
        high = np.where(across, np.where(outside, 0.0, high), np.minimum(high, b))
    return low, high


def _above(stock: Dexels, profile: ToolProfile) -> Above:
    """Shank and holder, and where there may be material."""
    from toolpace.kernels.cutting.cut_along import Above

    solids = [*profile.shank, *profile.holder]
    pieces = np.concatenate([np.zeros((0, 6)), *solids])
    first: Ints = np.cumsum([0, *map(len, solids)])
    part = np.repeat(np.arange(2), [len(profile.shank), len(profile.holder)])
    return Above(pieces, first, part, stock.blocks(), np.zeros((1, 6)), np.zeros(3))


def _most_rays(stock: Dexels, profile: ToolProfile) -> int:
    """At most how many rays the tool meets at a pose."""
    wide = 2.0 * profile.radius
    span = profile.length + wide
    field = stock.field
    found = 0
    for d in range(3):
        cells = [min(int(span / field.step[k]) + 3, int(field.cells[k])) for k in ((d + 1) % 3, (d + 2) % 3)]
        found += cells[0] * cells[1]
    return found
