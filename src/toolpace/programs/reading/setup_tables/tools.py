"""The tool table of a set-up sheet: what the control knows of a tool, and the shape that cuts."""

from __future__ import annotations

import math
from collections.abc import Mapping

from toolpace.common.units import DEGREE, LONGEST_TOOL, WIDEST_TOOL
from toolpace.programs.reading.coordinates.setup import Tool
from toolpace.programs.reading.setup_tables.quantities import Quantities
from toolpace.programs.tool_figures import KINDS, Frustum, ToolFigures, ToolKind

CONTROL_KEYS = ("length", "radius", "corner_radius")
LENGTH_KEYS = ("flute_length", "stick_out", "shank_diameter", "barrel_radius")
ANGLE_KEYS = ("taper", "point_angle", "helix")
SHAPE_KEYS = (
    "kind", "diameter", *LENGTH_KEYS, *ANGLE_KEYS, "teeth", "pitch", "runout", "shank", "holder", "material",
    "spindle_speed", "spindle",
)  # fmt: skip
SPINDLES = ("clockwise", "counterclockwise")
POINT = 118.0 * DEGREE
"""Of a twist drill whose point nobody tells [rad]."""
WIDEST_RADIUS = 0.75
"""Of a tool's `radius` over its diameter: more is a diameter in place of a radius."""
PIECE = "[[40, 12, 12], [20, 12, 30]]"
SHAPE_SAID = "# Its shape, for what it cuts: take the # away, and put in the tool's own figures.\n"
TO_FILL_IN = {
    "kind": 'kind = "flat"  # or "bull", "ball", "taper", "barrel", "lens", "drill", "chamfer", "face"',
    "diameter": "diameter = 0.0",
    "flute_length": "flute_length = 0.0  # from the tip to where the edges end",
    "stick_out": "stick_out = 0.0  # from the tip to the holder",
    "teeth": "teeth = 0",
    "holder": "holder = [[0.0, 0.0, 0.0]]  # length, lower and upper diameter of each piece, upwards",
}
"""Lines for figures that nothing tells."""


class ToolTables(Quantities):
    """The tables [tools.NAME]."""

    def tool(self, place: str, table: Mapping[str, object]) -> Tool:
        self.refuse_unknown_keys(place, table, (*CONTROL_KEYS, *SHAPE_KEYS))
        if not table:
            self.fail(
                place, f"says nothing; write length, from the spindle nose to the tip [{self.length}], or its diameter"
            )
        found = {key: self.length_of(place, key, table[key], LONGEST_TOOL) for key in CONTROL_KEYS if key in table}
        for key, value in found.items():
            if value < 0.0:
                cure = "it from the spindle nose, above zero"
                if key != "length":
                    cure = "the tool's own, from zero on: for a negative one of a control G41 and G42 change places"
                self.fail(place, f"{key} = {table[key]!r} is below zero; write {cure}")
        radius, corner = found.get("radius"), found.get("corner_radius")
        if not set(SHAPE_KEYS) & set(table):
            return Tool(found.get("length"), radius, corner)
        figures = self.made(lambda: self.figures(place, table, radius, corner))
        if figures.kind not in ("taper", "chamfer"):
            if radius is not None and radius > WIDEST_RADIUS * figures.diameter:
                self.fail(place, f"radius = {table['radius']!r} with diameter = {table.get('diameter')!r}: correct one")
            radius = 0.5 * figures.diameter if radius is None else radius
        if figures.kind in ("flat", "bull", "ball"):
            corner = figures.corner_radius
        return Tool(found.get("length"), radius, corner, figures)

    def figures(
        self, place: str, table: Mapping[str, object], radius: float | None, corner: float | None
    ) -> ToolFigures:
        """The shape of a tool; `radius` and `corner` are those that the control's table has [m]."""
        if "diameter" in table:
            diameter = self.length_of(place, "diameter", table["diameter"], WIDEST_TOOL)
        elif radius is None:
            self.fail(place, f"has no diameter; write that of the cutting part [{self.length}]")
        else:
            diameter = 2.0 * radius
        assumed = []
        kind = self.kind(place, table, diameter, corner)
        if "kind" not in table:
            assumed.append(f'kind is not told, and taken as "{kind}" from diameter and corner radius')
        lengths = {key: self.length_of(place, key, table[key], LONGEST_TOOL) for key in LENGTH_KEYS if key in table}
        angles = {key: self.angle_of(place, key, table[key]) for key in ANGLE_KEYS if key in table}
        if kind == "drill" and "point_angle" not in table:
            angles["point_angle"] = POINT
            assumed.append(f"point_angle of the drill is not told, and taken as {POINT / DEGREE:g} deg")
        return ToolFigures(
            kind, diameter, corner or 0.0, **lengths, **angles,
            teeth=self.teeth(place, table),
            pitch=self.pitch(place, table),
            # a dial gauge shows both sides
            runout=0.5 * self.length_of(place, "runout", table.get("runout", 0.0), WIDEST_TOOL),
            shank=self.pieces(place, table, "shank"),
            holder=self.pieces(place, table, "holder"),
            material=self.text(place, "material", table["material"], 100) if "material" in table else "",
            spindle_speed=self.turns_of(place, "spindle_speed", table["spindle_speed"])
            if "spindle_speed" in table
            else None,
            clockwise=self.word(place, "spindle", table.get("spindle", SPINDLES[0]), SPINDLES) == SPINDLES[0],
            source=f"{self.source}: {place}",
            assumed=tuple(assumed),
        )  # fmt: skip

    def kind(self, place: str, table: Mapping[str, object], diameter: float, corner: float | None) -> ToolKind:
        """That of the sheet; where it tells none, by the corner radius."""
        if "kind" in table:
            return self.word(place, "kind", table["kind"], KINDS)
        if not corner:
            return "flat"
        return "ball" if abs(corner - 0.5 * diameter) <= 1e-6 * diameter else "bull"

    def teeth(self, place: str, table: Mapping[str, object]) -> int | None:
        found = table.get("teeth")
        if found is None:
            return None
        if isinstance(found, bool) or not isinstance(found, int):
            self.fail(place, f"teeth = {found!r:.40} is no whole number; write how many, like teeth = 3")
        return found

    def pitch(self, place: str, table: Mapping[str, object]) -> tuple[float, ...]:
        found = table.get("pitch", [])
        if not isinstance(found, list):
            self.fail(place, f"pitch = {found!r:.40} is no list; write the angles between teeth, like [118, 122, 120]")
        return tuple(self.angle_of(place, "pitch", each) for each in found)

    def pieces(self, place: str, table: Mapping[str, object], key: str) -> tuple[Frustum, ...]:
        """Cylinders and cones from the tip's side upwards."""
        found = table.get(key, [])
        if not isinstance(found, list) or not all(isinstance(each, list) and len(each) == 3 for each in found):
            self.fail(
                place, f"{key} = {found!r:.40}: write each piece as [length, lower diameter, upper], like {PIECE}"
            )
        return tuple(Frustum(*(self.length_of(place, key, each, LONGEST_TOOL) for each in piece)) for piece in found)


def tool_table(tool: Tool) -> dict[str, object]:
    """What the sheet says of a tool, in m and rad, so that it reads as exactly this one."""
    table: dict[str, object] = {**tool.control_figures()}
    figures = tool.figures
    if figures is None:
        return table
    table |= {"kind": figures.kind, "diameter": figures.diameter}
    values = {key: getattr(figures, key) for key in ("corner_radius", *LENGTH_KEYS, *ANGLE_KEYS, "teeth", "material")}
    # of a drill without a point it is told, since another one would be assumed
    table |= {
        key: value
        for key, value in values.items()
        if value not in (None, "", 0.0, math.inf) or (key == "point_angle" and figures.kind == "drill")
    }
    for key, pieces in (("shank", figures.shank), ("holder", figures.holder)):
        if pieces:
            table[key] = [[piece.length, piece.lower_diameter, piece.upper_diameter] for piece in pieces]
    if figures.pitch:
        table["pitch"] = list(figures.pitch)
    if figures.runout:
        table["runout"] = 2.0 * figures.runout
    if figures.spindle_speed is not None:
        table["spindle_speed"] = f"{figures.spindle_speed!r} 1/s"
    if not figures.clockwise:
        table["spindle"] = SPINDLES[1]
    return table


def lines_to_fill_in(table: Mapping[str, object]) -> str:
    """Comments for what a tool's table does not tell of its shape."""
    missing = [f"# {line}\n" for key, line in TO_FILL_IN.items() if key not in table]
    return SHAPE_SAID + "".join(missing) if missing else ""


def tool_table_to_fill_in(tool: Tool | None, own_length: float) -> dict[str, object]:
    """What a sheet to fill in says of a tool, in mm and deg; `own_length` [m] where nothing tells its length."""
    table = {"length": own_length} | ({} if tool is None else tool_table(tool))

    def shown(key: str, value: object) -> object:
        if isinstance(value, list):
            return [shown(key, each) for each in value]
        if not isinstance(value, float):
            return value
        return round(math.degrees(value) if key in (*ANGLE_KEYS, "pitch") else value * 1e3, 9) + 0.0

    return {key: shown(key, value) for key, value in table.items()}
