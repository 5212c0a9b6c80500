"""Bodies in the frame of the part, from what a set-up sheet or a program tells; and the guess where nothing is told."""

from __future__ import annotations

import math
import warnings
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from toolpace.common.arrays import Bools, Floats
from toolpace.common.errors import UnitWarning, UsageError
from toolpace.common.units import LENGTHS, MILLIMETRE
from toolpace.cutting.stock.mesh_file import load_mesh
from toolpace.cutting.stock.mesh_topology import box_triangles
from toolpace.programs.reading.coordinates.kinematics import Kinematics
from toolpace.programs.reading.coordinates.setup import SetUp
from toolpace.programs.reading.coordinates.work_coordinates import placement_of_offset
from toolpace.programs.stock_figures import Solid, StockFigures
from toolpace.programs.tool_figures import ToolFigures
from toolpace.programs.toolpath import ToolPath

SQUARE = 1e-9
"""How far a direction may be off an axis of the frame for a box to be taken as a box."""
SURE_OF_UNIT = 0.1
"""How near the sizes of mesh and program have to be, in parts, for another unit to be named."""
UNIT_NAMES = {"in": "inches", "m": "metres", "cm": "centimetres"}
FACETS = 256
"""Of a cylinder that is drawn as a mesh."""


@dataclass(frozen=True, eq=False)
class Body:
    """A body in the frame of the part: a box along its axes, a cylinder, or a closed mesh."""

    box: tuple[Floats, Floats] | None = None
    """Its least and its most corner, (3,) each [m]."""
    cylinder: tuple[Floats, Floats, float] | None = None
    """The centres of both ends, (3,) each, and the diameter [m]."""
    mesh: Floats | None = None
    """(n, 3, 3) corners of triangles, counterclockwise seen from outside [m]."""
    unit_assumed: bool = False
    """Of a mesh: whether nothing tells its unit, which is taken to be mm."""
    notes: tuple[str, ...] = ()
    """What was repaired of the mesh, a sentence each."""

    @property
    def bounds(self) -> tuple[Floats, Floats]:
        """Its least and its most corner, (3,) each [m]."""
        if self.box is not None:
            return self.box
        if self.cylinder is not None:
            lower, upper, diameter = self.cylinder
            axis = (upper - lower) / np.linalg.norm(upper - lower)
            wide = 0.5 * diameter * np.sqrt(np.maximum(1.0 - axis**2, 0.0))
            return np.minimum(lower, upper) - wide, np.maximum(lower, upper) + wide
        assert self.mesh is not None
        return self.mesh.min(axis=(0, 1)), self.mesh.max(axis=(0, 1))

    @property
    def volume(self) -> float:
        """[m3]; of a mesh whose parts overlap, each of them counts."""
        if self.box is not None:
            return float(np.prod(self.box[1] - self.box[0]))
        if self.cylinder is not None:
            lower, upper, diameter = self.cylinder
            return float(0.25 * math.pi * diameter**2 * np.linalg.norm(upper - lower))
        assert self.mesh is not None
        a, b, c = (self.mesh[:, k] - self.mesh[0, 0] for k in range(3))
        return float(np.einsum("ij,ij->", a, np.cross(b, c))) / 6.0

    def triangles(self) -> Floats:
        """(n, 3, 3) corners of triangles, counterclockwise seen from outside [m]; a cylinder has 256 facets, whose
        corners are on it."""
        if self.box is not None:
            return box_triangles(*self.box)
        return _cylinder_triangles(*self.cylinder) if self.cylinder is not None else self.mesh  # type: ignore[return-value]


def body_of(solid: Solid, machine: Kinematics | None, setup: SetUp) -> Body:
    """A body in the frame of the part. Raises UsageError where its mesh is none, or its work offset is not listed.

    machine: with the part mounted as the sheet says; it places work offsets.
    """
    placement = np.eye(4) if not solid.frame else placement_of_offset(machine, setup, solid.frame)
    own = np.eye(4)
    x, z = (np.array(each) / np.linalg.norm(each) for each in (solid.x, solid.z))
    own[:3, :3], own[:3, 3] = np.column_stack([x, np.cross(z, x), z]), solid.origin
    matrix = placement @ own
    if solid.mesh is not None:
        mesh = load_mesh(solid.mesh, solid.mesh_unit)
        return Body(mesh=_moved(mesh.triangles, matrix), unit_assumed=mesh.unit_assumed, notes=mesh.notes)
    if solid.cylinder is not None:
        lower, upper, diameter = solid.cylinder
        ends = _moved(np.array([lower, upper]), matrix)
        return Body(cylinder=(ends[0], ends[1], diameter))
    assert solid.box is not None
    low, high = (np.array(corner) for corner in solid.box)
    turn = np.abs(matrix[:3, :3])
    if (np.minimum(turn, np.abs(1.0 - turn)) < SQUARE).all():
        corners = _moved(np.array([low, high]), matrix)
        return Body(box=(corners.min(axis=0), corners.max(axis=0)))
    return Body(mesh=_moved(box_triangles(low, high), matrix))


def _moved(points: Floats, matrix: Floats) -> Floats:
    """Points (..., 3) by a placement (4, 4)."""
    exact = (np.abs(matrix - np.eye(4)) == 0.0).all()
    if exact:
        return points
    moved: Floats = np.ascontiguousarray(points @ matrix[:3, :3].T + matrix[:3, 3])
    return moved


def _cylinder_triangles(lower: Floats, upper: Floats, diameter: float) -> Floats:
    axis = (upper - lower) / np.linalg.norm(upper - lower)
    across = np.eye(3)[int(np.argmin(np.abs(axis)))]
    u = np.cross(axis, across) / np.linalg.norm(np.cross(axis, across))
    angle = 2.0 * math.pi * np.arange(FACETS) / FACETS
    ring = 0.5 * diameter * (np.outer(np.cos(angle), u) + np.outer(np.sin(angle), np.cross(axis, u)))
    near, far = lower + ring, upper + ring
    near_next, far_next = np.roll(near, -1, axis=0), np.roll(far, -1, axis=0)
    first, last = np.broadcast_to(lower, near.shape), np.broadcast_to(upper, far.shape)
    faces = [(near, near_next, far_next), (near, far_next, far), (first, near_next, near), (last, far, far_next)]
    return np.concatenate([np.stack(face, axis=1) for face in faces])


def cutting_bounds(toolpath: ToolPath, figures: Sequence[ToolFigures | None]) -> tuple[Floats, Floats] | None:
    """Least and most corner (3,) [m] of what the ends of the tools pass at feed; None where nothing moves at feed.

    figures: of the tool of each operation; one that is None is taken as a point.
    """
    cutting: Bools = ~toolpath.rapid
    cutting = cutting & ((toolpath.way_length > 0.0) | (np.arange(len(toolpath)) == 0))
    cutting[0] = False
    if not cutting.any():
        return None
    radius = np.array([0.0 if each is None else 0.5 * each.diameter for each in figures])[toolpath.operation]
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    before = np.maximum(np.flatnonzero(cutting) - 1, 0)
    for tips, axes in (
        (toolpath.tip[cutting], toolpath.axis[cutting]),
        (toolpath.way_start[cutting], toolpath.axis[before]),
    ):
        # a disc across the axis, and as far up the axis
        wide = radius[cutting, None] * np.sqrt(np.maximum(1.0 - axes**2, 0.0))
        top = tips + radius[cutting, None] * axes
        low = np.minimum(low, np.minimum(tips - wide, top).min(axis=0))
        high = np.maximum(high, np.maximum(tips + wide, top).max(axis=0))
    return low, high


def guessed_stock(toolpath: ToolPath, figures: Sequence[ToolFigures | None]) -> StockFigures:
    """The box around all moves at feed, grown by the radius of each tool: nothing may be concluded from it.

    figures: of the tool of each operation. Raises UsageError where the program has no move at feed, or no tool.
    """
    bounds = cutting_bounds(toolpath, figures)
    name = toolpath.source or "the program"
    if bounds is None:
        raise UsageError(f"{name}: has no move at feed, and so cuts nothing; tell the stock")
    low, high = (tuple(corner.tolist()) for corner in bounds)
    if not all(a < b for a, b in zip(low, high)):
        raise UsageError(
            f"{name}: no box is around its moves at feed without the diameters of its tools; tell the tools "
            "([tools.N] diameter), or the stock ([stock] box)"
        )
    return StockFigures(Solid(box=(low, high), source="the box around all moves at feed"), guessed=True)


def check_stock_place(
    body: Body, toolpath: ToolPath, figures: Sequence[ToolFigures | None], name: str = "[stock]"
) -> None:
    """Raise UsageError where no move at feed comes near a stock; ask (UnitWarning) where its unit can hardly be meant.

    `name` is the stock's, for messages. figures: of the tool of each operation.
    """
    bounds = cutting_bounds(toolpath, figures)
    if bounds is None:
        return
    low, high = body.bounds
    size, room = float((high - low).max()), float((bounds[1] - bounds[0]).max())
    unit = _other_unit(size, room) if body.unit_assumed else ""
    cure = "check its place (origin, frame) and unit"
    if unit:
        cure = f'is it in {UNIT_NAMES[unit]}? Then write mesh_unit = "{unit}"'
    gap = np.maximum(np.maximum(low - bounds[1], bounds[0] - high), 0.0)
    if (away := float(np.linalg.norm(gap))) > 0.0:
        raise UsageError(
            f"{name}: lies {away * 1e3:.4g} mm away from all moves at feed, from {_place(low)} to {_place(high)} mm; "
            f"they go from {_place(bounds[0])} to {_place(bounds[1])} mm; {cure}"
        )
    if unit:
        warnings.warn(
            f"{name}: is {size * 1e3:.4g} mm long, and the moves at feed reach over {room * 1e3:.4g} mm; {cure}",
            UnitWarning,
            stacklevel=2,
        )


def _other_unit(size: float, room: float) -> str:
    """The unit in which a mesh that was read in mm would be as long as the program's moves; empty: none, or mm."""
    for unit in UNIT_NAMES:
        scale = LENGTHS[unit] / MILLIMETRE
        if abs(math.log(room / (size * scale))) < SURE_OF_UNIT * math.log(scale) + 0.3:
            return unit
    return ""


def _place(point: Floats) -> str:
    return "[" + ", ".join(f"{value * 1e3:.4g}" for value in point) + "]"
