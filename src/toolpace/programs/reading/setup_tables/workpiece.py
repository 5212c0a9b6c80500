"""Stock, finished part and fixtures of a set-up sheet: the tables [stock], [finished_part], [fixtures.NAME]."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from toolpace.common.units import FARTHEST_PART
from toolpace.common.units import LENGTHS as MESH_UNITS
from toolpace.programs.reading.coordinates.setup import offset_name
from toolpace.programs.reading.setup_tables.quantities import Quantities, Vector
from toolpace.programs.stock_figures import (
    MOST_UNCERTAINTY,
    UNCERTAINTIES,
    Solid,
    StockFigures,
    WorkpieceFigures,
)

SHAPES = ("box", "cylinder", "mesh", "mesh_unit")
SOLID_KEYS = (*SHAPES, "frame", "origin", "x", "z")
MOST_FIXTURES = 100
STOCK_TO_FILL_IN = """\
# What is cut: take the # away, and put in the stock's own figures. Without them the box around all cutting moves is a
# guess, from which nothing is concluded.{extent}
# [stock]
# box = [[0, 0, -20], [100, 60, 0]]  # least and most corner, as the program's X, Y, Z count
# (or cylinder = {{ diameter = 50, height = 40 }}, its upper end at Z0; or mesh = "stock.stl")
# kind = "sawn"  # or "machined", "cast", "forged"; or uncertainty = 0.5: how far its surface may be elsewhere
"""


class WorkpieceTables(Quantities):
    """The tables of all solids; `folder` is that of the sheet, which the names of meshes count from."""

    folder = Path()

    def workpiece(self) -> WorkpieceFigures:
        stock, part, fixtures = (self.table(name) for name in ("stock", "finished_part", "fixtures"))
        if len(fixtures) > MOST_FIXTURES:
            self.fail("[fixtures]", f"lists {len(fixtures)} fixtures; {MOST_FIXTURES} are the most")
        figures: dict[str, Any] = {}
        if stock:
            figures["stock"] = self.stock(stock)
        if part:
            self.refuse_unknown_keys("[finished_part]", part, (*SOLID_KEYS, "tolerance"))
            figures["finished_part"] = self.solid("[finished_part]", part)
            if "tolerance" in part:
                tolerance = self.length_of("[finished_part]", "tolerance", part["tolerance"], MOST_UNCERTAINTY)
                if tolerance < 0.0:
                    self.fail("[finished_part]", f"tolerance = {part['tolerance']!r} is below zero; correct it")
                figures["gouge_tolerance"] = tolerance
        clamps = tuple((name, self.fixture(name, table)) for name, table in fixtures.items())
        return WorkpieceFigures(**figures, fixtures=clamps)

    def stock(self, table: Mapping[str, object]) -> StockFigures:
        self.refuse_unknown_keys("[stock]", table, (*SOLID_KEYS, "uncertainty", "kind"))
        uncertainty = UNCERTAINTIES["machined"]
        if "kind" in table:
            uncertainty = UNCERTAINTIES[self.word("[stock]", "kind", table["kind"], tuple(UNCERTAINTIES))]
        if "uncertainty" in table:
            uncertainty = self.length_of("[stock]", "uncertainty", table["uncertainty"], MOST_UNCERTAINTY)
        solid = self.solid("[stock]", table)
        return self.made(lambda: StockFigures(solid, uncertainty))

    def fixture(self, name: str, table: object) -> Solid:
        place = f"[fixtures.{name[:40]}]"
        if not isinstance(table, dict):
            self.fail("[fixtures]", f"{name[:40]} = {table!r:.40} is not a table; write it under {place}")
        self.refuse_unknown_keys(place, table, SOLID_KEYS)
        return self.solid(place, table)

    def solid(self, place: str, table: Mapping[str, object]) -> Solid:
        """The body that a table tells of."""
        figures: dict[str, Any] = {"source": f"{self.source}: {place}"}
        if "box" in table:
            figures["box"] = self.box(place, table["box"])
        if "cylinder" in table:
            figures["cylinder"] = self.cylinder(f"{place} cylinder", table["cylinder"])
        if "mesh" in table:
            figures["mesh"] = (self.folder / self.text(place, "mesh", table["mesh"])).absolute()
        if "mesh_unit" in table:
            figures["mesh_unit"] = self.word(place, "mesh_unit", table["mesh_unit"], tuple(MESH_UNITS))
        if "frame" in table:
            figures["frame"] = self.frame(place, table["frame"])
        if "origin" in table:
            figures["origin"] = self.place_of(place, "origin", table["origin"], FARTHEST_PART)
        for key in ("x", "z"):
            if key in table:
                figures[key] = self.direction_of(place, key, table[key])
        return self.made(lambda: Solid(**figures))

    def frame(self, place: str, value: object) -> str:
        """The name of a work offset: one of the sheet, where it lists any."""
        name = offset_name(self.text(place, "frame", value, 100))
        listed = {offset_name(each) for each in self.table("offsets")}
        if listed and name not in listed:
            self.fail(place, f"frame = {value!r:.40} is not among the work offsets of the sheet; list [offsets.{name}]")
        return name

    def box(self, place: str, value: object) -> tuple[Vector, Vector]:
        """Least and most corner [m]."""
        if not isinstance(value, list) or len(value) != 2:
            self.fail(
                place, f"box = {value!r:.40}: write its least and its most corner, like [[0, 0, -20], [100, 60, 0]]"
            )
        low, high = (self.place_of(place, "box", each, FARTHEST_PART) for each in value)
        if any(a > b for a, b in zip(low, high)):
            self.fail(place, f"box = {value!r:.60}: its least corner is not below its most; write the least one first")
        return low, high

    def cylinder(self, place: str, value: object) -> tuple[Vector, Vector, float]:
        """Centres of both ends, and diameter [m]: `from` and `to`, or `height` about Z with the upper end at `top`."""
        if not isinstance(value, dict):
            self.fail(place, f"= {value!r:.40}: write it like cylinder = {{ diameter = 50, height = 40, top = 0 }}")
        self.refuse_unknown_keys(place, value, ("diameter", "from", "to", "height", "top"))
        if "diameter" not in value:
            self.fail(place, "has no diameter; write it")
        diameter = self.length_of(place, "diameter", value["diameter"], FARTHEST_PART)
        ends, height = {"from", "to"} & set(value), {"height", "top"} & set(value)
        if len(ends) == 2 and not height:
            lower, upper = (self.place_of(place, key, value[key], FARTHEST_PART) for key in ("from", "to"))
            return lower, upper, diameter
        if ends or "height" not in value:
            self.fail(place, "needs the centres of both ends, from and to; or height, and top where it is not at Z0")
        high, top = (self.length_of(place, key, value.get(key, 0.0), FARTHEST_PART) for key in ("height", "top"))
        if high <= 0.0:
            self.fail(place, f"height = {value['height']!r} is not above zero; write how high it is")
        return (0.0, 0.0, top - high), (0.0, 0.0, top), diameter


def workpiece_tables(workpiece: WorkpieceFigures, unit: float = 1.0) -> dict[str, dict[str, object]]:
    """What the sheet says of the workpiece, so that it reads as this one: exactly where the unit is 1 m."""

    def length(value: float) -> float:
        return value if unit == 1.0 else round(value / unit, 9) + 0.0

    def solid_table(solid: Solid) -> dict[str, object]:
        table: dict[str, object] = {}
        if solid.box is not None:
            table["box"] = [[*map(length, corner)] for corner in solid.box]
        if solid.mesh is not None:
            table["mesh"] = str(solid.mesh)
        table |= {key: value for key in ("mesh_unit", "frame") if (value := getattr(solid, key))}
        if solid.origin != Solid.origin:
            table["origin"] = [*map(length, solid.origin)]
        for key, usual in (("x", Solid.x), ("z", Solid.z)):
            if (direction := getattr(solid, key)) != usual:
                table[key] = [*direction]
        if solid.cylinder is not None:
            lower, upper, diameter = solid.cylinder
            ends = {"from": [*map(length, lower)], "to": [*map(length, upper)]}
            table["cylinder"] = {"diameter": length(diameter), **ends}
        return table

    tables: dict[str, dict[str, object]] = {}
    stock, part = workpiece.stock, workpiece.finished_part
    if stock is not None and not stock.guessed:
        tables["stock"] = {"uncertainty": length(stock.uncertainty), **solid_table(stock.solid)}
    if part is not None:
        tables["finished_part"] = {"tolerance": length(workpiece.gouge_tolerance), **solid_table(part)}
    if workpiece.fixtures:
        tables["fixtures"] = {name: solid_table(solid) for name, solid in workpiece.fixtures}
    return tables
