"""The shape of the stock, of the finished part and of fixtures, as a set-up sheet or a program tells them."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from pathlib import Path

from toolpace.common.errors import UsageError
from toolpace.common.units import FARTHEST_PART, LENGTHS

UNCERTAINTIES = {"machined": 0.1e-3, "sawn": 1e-3, "cast": 2e-3, "forged": 2e-3}
"""How far the surface of a stock may be from where it is told to be, by kind of stock [m]."""
MOST_UNCERTAINTY = 0.1
"""[m]: more is a slip of units."""
MESH_SUFFIXES = (".stl", ".3mf", ".obj")
RIGHT_ANGLE = 1e-6
"""By how much the cosine of the angle between the directions of x and z may differ from zero."""
Vector = tuple[float, float, float]


@dataclass(frozen=True)
class Solid:
    """A body: one of a box, a cylinder and a mesh. Raises UsageError, with the cure, for what is no body."""

    box: tuple[Vector, Vector] | None = None
    """Its least and its most corner [m]."""
    cylinder: tuple[Vector, Vector, float] | None = None
    """The centres of both ends, and the diameter [m]."""
    mesh: Path | None = None
    """A file (STL, 3MF, OBJ)."""
    mesh_unit: str = ""
    """Unit of the mesh's coordinates (a key of common/units.py `LENGTHS`); empty: as the file tells, else mm."""
    frame: str = ""
    """The work offset ("G54") whose coordinates the body is placed in; empty: the frame of the part."""
    origin: Vector = (0.0, 0.0, 0.0)
    """Where the zero of the figures above lies, in that frame [m]."""
    x: Vector = (1.0, 0.0, 0.0)
    """Direction of their x, in that frame; at a right angle to `z`."""
    z: Vector = (0.0, 0.0, 1.0)
    """Direction of their z."""
    source: str = field(default="", compare=False)
    """Where it is told: the sheet and its table, or the line of the program."""

    def __post_init__(self) -> None:
        if reason := self._fault():
            raise UsageError(f"{self.source or 'solid'}: {reason}")

    def _fault(self) -> str:
        """What makes it no body, with the cure; empty where it is one."""
        shapes = [name for name in ("box", "cylinder", "mesh") if getattr(self, name) is not None]
        if len(shapes) != 1:
            found = f"has {' and '.join(shapes)}" if shapes else "tells no shape"
            return f"{found}; give one of box, cylinder and mesh"
        vectors = [self.origin, self.x, self.z, *(self.box or ()), *(self.cylinder or ())[:2]]
        if not all(len(vector) == 3 and all(map(math.isfinite, vector)) for vector in vectors):
            return "a place or a direction in it is not three finite numbers; correct it"
        if any(abs(value) > FARTHEST_PART for vector in (*vectors[:1], *vectors[3:]) for value in vector):
            return f"a place in it is more than {FARTHEST_PART:g} m away: check its unit"
        if self.box is not None and not all(low < high for low, high in zip(*self.box)):
            return "box is empty; give its least corner first, then its most"
        if self.cylinder is not None:
            lower, upper, diameter = self.cylinder
            if not (0.0 < diameter <= FARTHEST_PART and math.dist(lower, upper) > 0.0):
                return "cylinder is empty; give a diameter above zero, and two ends that are apart"
        if self.mesh_unit and self.mesh_unit not in LENGTHS:
            return f"mesh_unit = {self.mesh_unit!r:.40} is not known; write one of {', '.join(LENGTHS)}"
        if self.mesh_unit and self.mesh is None:
            return "mesh_unit without mesh; remove it"
        long = math.hypot(*self.x) * math.hypot(*self.z)
        if not long > 0.0 or abs(sum(a * b for a, b in zip(self.x, self.z))) > RIGHT_ANGLE * long:
            return "x and z are not two directions at a right angle; correct one"
        return ""


@dataclass(frozen=True)
class StockFigures:
    """What is cut."""

    solid: Solid
    uncertainty: float = UNCERTAINTIES["machined"]
    """How far its surface may be from where it is told to be [m]."""
    guessed: bool = False
    """Whether it is the box around all cutting moves, for want of a better one: nothing is concluded from it."""

    def __post_init__(self) -> None:
        if not 0.0 <= self.uncertainty <= MOST_UNCERTAINTY:
            raise UsageError(
                f"{self.solid.source or 'stock'}: uncertainty is {self.uncertainty * 1e3:g} mm, and must be between 0 "
                f"and {MOST_UNCERTAINTY * 1e3:g} mm: check its unit"
            )


@dataclass(frozen=True)
class WorkpieceFigures:
    """All solids that a sheet or a program tells of."""

    stock: StockFigures | None = None
    finished_part: Solid | None = None
    """What is to be left: what is cut below it is a gouge."""
    gouge_tolerance: float = 0.1e-3
    """By how much the tool may be below the finished part [m]."""
    fixtures: tuple[tuple[str, Solid], ...] = ()
    """By name."""

    def without_offsets(self) -> WorkpieceFigures:
        """Those bodies that lie in the frame of the part, whatever the work offsets are."""
        stock, part = self.stock, self.finished_part
        return replace(
            self,
            stock=None if stock is None or stock.solid.frame else stock,
            finished_part=None if part is None or part.frame else part,
            fixtures=tuple(each for each in self.fixtures if not each[1].frame),
        )
