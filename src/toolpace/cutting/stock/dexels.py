"""The stock as dexels: three grids of rays with their intervals of material."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from toolpace.common.arrays import Floats, Ints, number, numbers
from toolpace.common.errors import UsageError
from toolpace.common.units import format_figure
from toolpace.common.value_objects import one_line
from toolpace.cutting.stock.mesh_topology import box_triangles

if TYPE_CHECKING:
    from toolpace.cutting.engagement.stations import Stations
    from toolpace.cutting.engagement.table import EngagementTable
    from toolpace.cutting.tool_profile import ToolProfile
    from toolpace.kernels.cutting.dexels import Field
    from toolpace.kernels.cutting.intrusion import Blocks


def _turned(about_x: float, about_y: float, about_z: float) -> Floats:
    """A rotation (3, 3), by three angles [rad]."""
    turn = np.eye(3)
    for d, angle in enumerate((about_x, about_y, about_z)):
        one = np.eye(3)
        one[d - 2, d - 2] = one[d - 1, d - 1] = math.cos(angle)
        one[d - 1, d - 2], one[d - 2, d - 1] = math.sin(angle), -math.sin(angle)
        turn = one @ turn
    return turn


FRAME: Floats = _turned(0.031, 0.023, 0.037)
"""Rows: directions of the rays in the frame of the part. They are askew to it by one to two degrees: faces of parts are
mostly along its axes, and rays along a face see its place within half a cell only. Askew, they see it in the mean."""
CELLS = 500
"""Cells along the longest side, where nothing else is wanted."""
MEMORY = 512e6
"""Bytes that the rays of a stock may take, where nothing else is wanted."""
NODE = 24
"""Bytes of an interval of material."""
SPARE = 0.25
"""Nodes for further intervals, as a share of the rays."""
TOO_FINE = 2**31
"""Most rays."""


@dataclass(eq=False, repr=False)
class DexelStock:
    """Material, in the frame of the part. Changed by `cut`; a `copy` keeps what is."""

    field: Field
    """The rays, for kernels."""
    bounds: tuple[Floats, Floats]
    """Lowest and highest corner (3,) of the box about the material, in the frame of the part [m]."""
    content: float | None = None
    """Volume [m3] less what was cut; None: what the rays see."""

    def __repr__(self) -> str:
        size = " x ".join(f"{1e3 * side:.4g}" for side in self.field.step * self.field.cells)
        return one_line(self, f"{size} mm", f"resolution {1e3 * self.resolution:.3g} mm")

    @staticmethod
    def box(
        low: npt.ArrayLike, high: npt.ArrayLike, resolution: float | None = None, memory: float = MEMORY
    ) -> DexelStock:
        """A box between two corners (3,) [m], in cells of at most `resolution` [m].

        Without one, 500 cells along the longest side, or as many as `memory` [bytes] holds. UsageError for a box
        without volume, and for a resolution that needs more memory.
        """
        low, high = numbers(low, "stock: low", (3,), unit="m"), numbers(high, "stock: high", (3,), unit="m")
        _refuse_flat(high - low)
        stock = DexelStock.mesh(box_triangles(low, high), resolution, memory)
        stock.content = float(np.prod(high - low))
        return stock

    @staticmethod
    def cylinder(
        start: npt.ArrayLike,
        end: npt.ArrayLike,
        diameter: float,
        resolution: float | None = None,
        memory: float = MEMORY,
    ) -> DexelStock:
        """A cylinder between the centres (3,) [m] of its ends; see `box` for the rest."""
        from toolpace.kernels.cutting.casting import fill_revolved

        start, end = numbers(start, "stock: start", (3,), unit="m"), numbers(end, "stock: end", (3,), unit="m")
        radius = 0.5 * number(diameter, "stock: diameter", least=0.0, above=True, unit="m")
        length = float(np.linalg.norm(end - start))
        if not length > 0.0:
            raise UsageError("stock: both ends of the cylinder are at one place; give two")
        axis = (end - start) / length
        wide = radius * np.sqrt(np.maximum(1.0 - axis**2, 0.0))
        around = np.minimum(start, end) - wide, np.maximum(start, end) + wide
        start, end, axis = start @ FRAME.T, end @ FRAME.T, axis @ FRAME.T
        wide = radius * np.sqrt(np.maximum(1.0 - axis**2, 0.0))
        stock = _empty(np.minimum(start, end) - wide, np.maximum(start, end) + wide, resolution, memory)
        fill_revolved(stock.field, np.array([[0.0, length, radius, 0.0, 0.0, radius]]), start, axis)
        stock.bounds = around
        stock.content = math.pi * radius**2 * length
        return stock

    @staticmethod
    def mesh(triangles: npt.ArrayLike, resolution: float | None = None, memory: float = MEMORY) -> DexelStock:
        """A closed mesh of triangles (n, 3, 3) [m], counterclockwise seen from outside; see `box` for the rest.

        UsageError for a mesh that is open or inside out.
        """
        corners = numbers(triangles, "stock: triangles", ("n", 3, 3), unit="m")
        if not len(corners):
            raise UsageError("stock: the mesh has no triangle; give a closed mesh")
        _refuse_flat(np.ptp(corners, axis=(0, 1)))
        around = corners.min(axis=(0, 1)), corners.max(axis=(0, 1))
        corners = np.ascontiguousarray(corners @ FRAME.T)
        stock = _empty(corners.min(axis=(0, 1)), corners.max(axis=(0, 1)), resolution, memory)
        stock.bounds = around
        if wrong := _cast(stock, corners):
            raise UsageError(
                f"stock: {wrong} of {stock.field.first[3]} rays do not leave the mesh as they enter it; "
                "give a closed mesh whose triangles are counterclockwise seen from outside"
            )
        return stock

    @property
    def resolution(self) -> float:
        """Largest side of a cell [m]."""
        return float(self.field.step.max())

    @property
    def frame(self) -> Floats:
        """Rows (3, 3): directions of the rays, in the frame of the part."""
        return FRAME

    @property
    def memory(self) -> int:
        """Bytes that the rays take."""
        return NODE * len(self.field.low)

    def volume(self) -> float:
        """Volume of the material [m3]: that of the start less all that was cut.

        What is cut is known better than the difference of what the rays see (`volume_by_rays`).
        """
        if self.content is None:
            self.content = self.volume_by_rays()
        return self.content

    def volume_by_rays(self) -> float:
        """Volume of the material [m3]: the mean of what the three directions see."""
        from toolpace.kernels.cutting.dexels import lengths

        return sum(lengths(self.field)) / 3.0

    def copy(self) -> DexelStock:
        """The same material, which is changed apart."""
        field = self.field
        return DexelStock(
            field._replace(
                low=field.low.copy(), high=field.high.copy(), following=field.following.copy(), pool=field.pool.copy()
            ),
            self.bounds,
            self.content,
        )

    def depths(self, points: npt.ArrayLike, most: float | None = None) -> Floats:
        """How deep points (n, 3) [m] are in material, below zero outside [m]; `most`, four cells, at most either way.

        Exact near a plane, within a cell at edges and corners.
        """
        from toolpace.kernels.cutting.dexels import depths_at

        points = numbers(points, "stock: points", ("n", 3), unit="m")
        most = 4.0 * self.resolution if most is None else most
        found = np.empty(len(points))
        # a ray that crosses a face askew is in material for longer than the face is away
        depths_at(self.field, np.ascontiguousarray(points @ FRAME.T), 2.0 * most, found)
        return np.clip(found, -most, most)

    def contains(self, points: npt.ArrayLike) -> npt.NDArray[np.bool_]:
        """Whether points (n, 3) [m] are in material."""
        return np.asarray(self.depths(points) > 0.0)

    def triangles(self, points: int = 200) -> Floats:
        """The surface as a closed mesh (n, 3, 3) [m]; see `stock.surface.triangles`."""
        from toolpace.cutting.stock.surface import triangles

        found: Floats = triangles(self.field, points) @ FRAME
        return found

    def grown(self, distance: float) -> DexelStock:
        """The stock with all that is within a distance [m] of it: never less, at most a cell's diagonal more.

        What is narrower than a cell where no ray meets it is not there, and does not grow.
        """
        distance = number(distance, "stock: distance", least=0.0, unit="m")
        field = self.field
        margin = np.ceil(distance / field.step + 1e-9).astype(np.int64) + 2
        target = _rays(field.origin - margin * field.step, field.step, field.cells + 2 * margin)
        wider = distance + 2.0 * self.resolution
        target.bounds = self.bounds[0] - wider, self.bounds[1] + wider
        return self._offset(target, distance, outward=True)

    def shrunk(self, distance: float) -> DexelStock:
        """The stock without all that is within a distance [m] of air: never more, at most a cell's diagonal less."""
        distance = number(distance, "stock: distance", least=0.0, unit="m")
        return self._offset(DexelStock(self.copy().field, self.bounds), distance, outward=False)

    def depth_in_material(self, solids: Sequence[Floats], stations: Stations) -> Floats:
        """How deep any of some solids of a `ToolProfile` is in material at stations (n,) [m]; 0 where none is.

        The depth is the distance of the deepest place from the surface of the solid. What touches between the rays, by
        less than half a cell, may not be seen.
        """
        return self.deepest(solids, stations)[0]

    def deepest(self, solids: Sequence[Floats], stations: Stations) -> tuple[Floats, Floats]:
        """`depth_in_material`, and the deepest places (n, 3) [m]; nan where there is none."""
        from toolpace.kernels.cutting.intrusion import deepest_along

        tips = numbers(stations.tip, "stations: tip", ("n", 3), unit="m")
        axes = numbers(stations.axis, "stations: axis", (len(tips), 3))
        tips, axes = np.ascontiguousarray(tips @ FRAME.T), np.ascontiguousarray(axes @ FRAME.T)
        blocks = self.blocks()
        depths, places = np.zeros(len(tips)), np.full((len(tips), 3), np.nan)
        for solid in solids:
            deepest_along(self.field, blocks, numbers(solid, "solid", ("n", 6)), tips, axes, depths, places)
        return depths, places @ FRAME

    def cut(self, profile: ToolProfile, stations: Stations, slice_height: float | None = None) -> EngagementTable:
        """Cut with a tool's cutting part along stations, and tell what it met; see `engagement.cut`."""
        from toolpace.cutting.engagement.cut import cut

        return cut(self, profile, stations, slice_height)

    def _offset(self, target: DexelStock, distance: float, *, outward: bool) -> DexelStock:
        """Grow into a target without material, or shrink one that is a copy."""
        from toolpace.kernels.cutting.offset import grow, shrink

        work, rays = (grow, self.field.first) if outward else (shrink, self.field.first)
        for d in range(3):
            ray, end = int(rays[d]), int(rays[d + 1])
            while ray < end:
                across = 2 * np.ceil(distance / self.field.step).astype(np.int64) + 5
                target.spare(max(64 * int(across[(d + 1) % 3] * across[(d + 2) % 3]), len(target.field.low) // 8))
                ray = work(self.field, target.field, d, distance, ray)
        return target

    def on_same_rays(self, triangles: Floats) -> DexelStock:
        """A closed mesh (n, 3, 3) [m] as material on the rays of this stock, as far as they see it."""
        stock = _rays(self.field.origin, self.field.step, self.field.cells)
        stock.bounds = self.bounds
        _cast(stock, np.ascontiguousarray(triangles @ FRAME.T))
        return stock

    def intervals(self) -> tuple[Ints, Floats, Floats]:
        """Ray (k,), begin and end (k,) along it [m] of each interval of material."""
        field = self.field
        ray = np.flatnonzero(field.low[: field.first[3]] <= field.high[: field.first[3]])
        node, rays, nodes = ray, [ray], [ray]
        while len(node):
            more = field.following[node] >= 0
            ray, node = ray[more], field.following[node[more]]
            rays.append(ray)
            nodes.append(node)
        every = np.concatenate(nodes)
        return np.concatenate(rays), field.low[every], field.high[every]

    def places_on(self, rays: Ints, along: Floats) -> Floats:
        """(k, 3) the places on rays (k,), so far along them (k,) [m], in the frame of the part."""
        field, found = self.field, np.empty((len(rays), 3))
        direction = np.searchsorted(field.first, rays, side="right") - 1
        for d in range(3):
            here, u, v = direction == d, (d + 1) % 3, (d + 2) % 3
            row, column = np.divmod(rays[here] - field.first[d], field.cells[u])
            found[here, u] = field.origin[u] + (column + 0.5) * field.step[u]
            found[here, v] = field.origin[v] + (row + 0.5) * field.step[v]
            found[here, d] = along[here]
        return np.asarray(found @ FRAME)

    def blocks(self) -> Blocks:
        """Where each block of rays has material."""
        from toolpace.kernels.cutting.intrusion import BLOCK, Blocks, blocks_of

        across = -(-self.field.cells // BLOCK)
        first: Ints = np.concatenate([[0], np.cumsum([across[d - 2] * across[d - 1] for d in range(3)])])
        blocks = Blocks(first, np.full(first[3], np.inf), np.full(first[3], -np.inf))
        blocks_of(self.field, blocks)
        return blocks

    def spare(self, nodes: int) -> None:
        """Have at least so many free nodes."""
        from toolpace.kernels.cutting.dexels import FREE, FREE_COUNT

        field = self.field
        missing = nodes - int(field.pool[FREE_COUNT])
        if missing > 0:
            count = len(field.low)
            more = max(missing, count // 4)
            following = np.arange(count + 1, count + more + 1)
            following[-1] = field.pool[FREE]
            field.pool[FREE] = count
            field.pool[FREE_COUNT] += more
            self.field = field._replace(
                low=np.concatenate([field.low, np.ones(more)]),
                high=np.concatenate([field.high, np.zeros(more)]),
                following=np.concatenate([field.following, following]),
            )


def resolution_within(low: Floats, high: Floats, memory: float = MEMORY) -> float:
    """The resolution [m] of a stock between two corners, where none is wanted: that of `DexelStock.box`."""
    sides = high - low
    faces = float(sides[0] * sides[1] + sides[1] * sides[2] + sides[2] * sides[0])
    return max(float(sides.max()) / CELLS, math.sqrt(1.1 * faces * NODE * (1.0 + SPARE) / memory))


def _refuse_flat(sides: Floats) -> None:
    if not (sides > 0.0).all():
        shown = " x ".join(f"{1e3 * side:g}" for side in sides)
        raise UsageError(f"stock: it is {shown} mm; give one with a length, a width and a height above 0")


def _cast(stock: DexelStock, corners: Floats) -> int:
    """Put a mesh (n, 3, 3), in the frame of the rays, into a stock; return how many rays do not leave it as they enter
    it."""
    from toolpace.kernels.cutting.casting import crossings, fill

    wrong = 0
    for d in range(3):
        rays = int(stock.field.first[d + 1] - stock.field.first[d])
        counts = np.zeros(rays + 1, np.int64)
        crossings(stock.field, corners, d, counts, np.empty(0), np.empty(0, np.int64))
        offset = np.concatenate([[0], np.cumsum(counts[:-1])])
        places, ways = np.empty(offset[-1]), np.empty(offset[-1], np.int64)
        crossings(stock.field, corners, d, offset.copy(), places, ways)
        stock.spare(int(np.maximum(counts // 2 - 1, 0).sum()))
        wrong += fill(stock.field, d, offset, places, ways)
    return wrong


def check_memory(points: Floats, resolution: float, memory: float, stocks: int = 1) -> None:
    """Raise UsageError where several stocks with these points (..., 3) [m] take more memory [bytes] at a resolution
    [m]."""
    turned = points @ FRAME.T
    axes = tuple(range(turned.ndim - 1))
    _cell_counts(turned.min(axis=axes), turned.max(axis=axes), resolution, memory, stocks)


def _cell_counts(low: Floats, high: Floats, resolution: float | None, memory: float, stocks: int = 1) -> Ints:
    """How many cells (3,) there are between two corners (3,) along the rays; memory: of all stocks [bytes]."""
    room = memory / stocks
    cell = resolution_within(low, high, room) if resolution is None else resolution
    cell = number(cell, "stock: resolution", least=0.0, above=True, unit="m")
    wanted = np.ceil((high - low) / cell - 1e-9)
    faces = [float(wanted[(d + 1) % 3] * wanted[(d + 2) % 3]) for d in range(3)]
    taken = NODE * (1.0 + SPARE) * sum(faces)
    if not taken <= max(room, NODE * 64.0):
        coarser = 1e3 * resolution_within(low, high, room)
        several = f" for {stocks} stocks (as large as told, smaller and larger)" if stocks > 1 else ""
        raise UsageError(
            f"stock: cells of {1e3 * cell:g} mm take {format_figure(stocks * taken / 1e6)} MB{several}, and "
            f"{format_figure(memory / 1e6)} MB are allowed; give cells of {coarser:.2g} mm or more, or more memory"
        )
    counts: Ints = np.maximum(wanted, 1.0).astype(np.int64)
    return counts


def _empty(low: Floats, high: Floats, resolution: float | None, memory: float) -> DexelStock:
    """Rays without material between two corners."""
    count = _cell_counts(low, high, resolution, memory)
    return _rays(low, (high - low) / count, count)


def _rays(origin: Floats, step: Floats, count: Ints) -> DexelStock:
    """Rays without material."""
    from toolpace.kernels.cutting.dexels import Field

    faces = [count[(d + 1) % 3] * count[(d + 2) % 3] for d in range(3)]
    first: Ints = np.concatenate([[0], np.cumsum(faces)]).astype(np.int64)
    rays = int(first[3])
    nothing = np.full(rays, -1, np.int64)
    field = Field(origin, step, count, first, np.ones(rays), np.zeros(rays), nothing, np.array([-1, 0]))
    stock = DexelStock(field, (origin, origin))
    stock.spare(int(SPARE * rays) + 64)
    return stock
