"""The shape of the stock, of the finished part and of fixtures, as a set-up sheet or a program tells them."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

UNCERTAINTIES = {"machined": 0.1e-3, "sawn": 1e-3, "cast": 2e-3, "forged": 2e-3}
"""How far the surface of a stock may be from where it is told to be, by kind of stock [m]."""
Vector = tuple[float, float, float]


@dataclass(frozen=True)
class Solid:
    """A body in the frame of the part: one of a box, a cylinder and a mesh."""

    box: tuple[Vector, Vector] | None = None
    """Its least and its most corner [m]."""
    cylinder: tuple[Vector, Vector, float] | None = None
    """The centres of both ends, and the diameter [m]."""
    mesh: Path | None = None
    """A file (STL, 3MF, OBJ)."""
    mesh_unit: float | None = None
    """Metres per unit of the mesh; None: as the file tells, else mm."""
    frame: str = ""
    """The work offset ("G54") whose coordinates the figures are in; empty: the frame of the part."""
    source: str = ""
    """Where it is told: the sheet and its table, or the line of the program."""


@dataclass(frozen=True)
class StockFigures:
    """What is cut."""

    solid: Solid
    uncertainty: float = UNCERTAINTIES["machined"]
    """How far its surface may be from where it is told to be [m]."""
    guessed: bool = False
    """Whether it is the box around all cutting moves, for want of a better one: nothing is concluded from it."""


@dataclass(frozen=True)
class WorkpieceFigures:
    """All solids that a sheet or a program tells of."""

    stock: StockFigures | None = None
    finished_part: Solid | None = None
    """What is to be left: what is cut below it is a gouge."""
    gouge_tolerance: float = 0.1e-3
    """By how much the tool may be below the finished part [m]."""
    fixtures: tuple[tuple[str, Solid], ...] = field(default_factory=tuple)
    """By name."""
