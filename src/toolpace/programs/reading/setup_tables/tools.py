"""The tool table of a set-up sheet: what the control knows of a tool, and the shape that cuts."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any

from toolpace.common.files import reason
from toolpace.common.units import DEGREE, LONGEST_TOOL, MILLIMETRE, MINUTE, WIDEST_TOOL, parse_feed, parse_power
from toolpace.programs.reading.coordinates.setup import Tool
from toolpace.programs.reading.setup_tables.quantities import Quantities
from toolpace.programs.spindle_figures import SpeedCurve, SpindleFigures
from toolpace.programs.tool_figures import KINDS, Frustum, ToolFigures, ToolKind

CONTROL_KEYS = ("length", "radius", "corner_radius")
LENGTH_KEYS = ("flute_length", "stick_out", "shank_diameter", "barrel_radius")
ANGLE_KEYS = ("taper", "point_angle", "helix")
SHAPE_KEYS = (
    "kind", "diameter", *LENGTH_KEYS, *ANGLE_KEYS, "teeth", "pitch", "runout", "shank", "holder", "material",
    "spindle_speed", "spindle", "spindle_range", "cutting_speed", "stability",
)  # fmt: skip
SPINDLES = ("clockwise", "counterclockwise")
LONGEST_CHART = 2_000_000
"""Characters of a file of a stability chart."""
CHART = "lines such as 8000, 2.5 (turns per minute, depth in mm), the speeds ascending"
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


_SEPARATORS = re.compile(r"[ \t]*[,;\t][ \t]*|[ \t]+")
_NUMBER = re.compile(r"[-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?")


class ToolTables(Quantities):
    """The tables [tools.NAME], and that of the spindle; `folder` is the sheet's, which names of files count from."""

    folder = Path()

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
        if "diameter" not in table and radius is None:
            return Tool(found.get("length"), None, corner, added=self.added(place, table, corner))
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
        else:
            diameter = 2.0 * (radius or 0.0)
        assumed = []
        kind = self.kind(place, table, diameter, corner)
        if "kind" not in table:
            assumed.append(f'kind is not told, and taken as "{kind}" from diameter and corner radius')
        told = self.told(place, table)
        if kind == "drill" and "point_angle" not in table:
            told["point_angle"] = POINT
            assumed.append(f"point_angle of the drill is not told, and taken as {POINT / DEGREE:g} deg")
        return ToolFigures(
            kind, diameter, corner or 0.0, **told, source=f"{self.source}: {place}", assumed=tuple(assumed)
        )

    def added(self, place: str, table: Mapping[str, object], corner: float | None) -> dict[str, Any]:
        """What a table without a diameter tells of a shape, by the fields of ToolFigures."""
        found = self.told(place, table)
        if "kind" in table:
            found["kind"] = self.word(place, "kind", table["kind"], KINDS)
        if corner is not None:
            found["corner_radius"] = corner
        return found

    def told(self, place: str, table: Mapping[str, object]) -> dict[str, Any]:
        """The figures of a table but kind, diameter and corner radius, by the fields of ToolFigures."""
        found: dict[str, Any] = {
            key: self.length_of(place, key, table[key], LONGEST_TOOL) for key in LENGTH_KEYS if key in table
        }
        found |= {key: self.angle_of(place, key, table[key]) for key in ANGLE_KEYS if key in table}
        readers: dict[str, Callable[[], object]] = {
            "teeth": lambda: self.teeth(place, table),
            "pitch": lambda: self.pitch(place, table),
            # a dial gauge shows both sides
            "runout": lambda: 0.5 * self.length_of(place, "runout", table["runout"], WIDEST_TOOL),
            "shank": lambda: self.pieces(place, table, "shank"),
            "holder": lambda: self.pieces(place, table, "holder"),
            "material": lambda: self.text(place, "material", table["material"], 100),
            "spindle_speed": lambda: self.turns_of(place, "spindle_speed", table["spindle_speed"]),
            "spindle_range": lambda: self.spindle_range(place, table),
            "cutting_speed": lambda: self.cutting_speed(place, table),
            "stability": lambda: self.stability(place, table),
        }
        found |= {key: reader() for key, reader in readers.items() if key in table}
        if "spindle" in table:
            found["clockwise"] = self.word(place, "spindle", table["spindle"], SPINDLES) == SPINDLES[0]
        return found

    def spindle_range(self, place: str, table: Mapping[str, object]) -> tuple[float, float] | None:
        """Least and most speed that may be chosen [1/s]."""
        found = table.get("spindle_range")
        if found is None:
            return None
        if not isinstance(found, list) or len(found) != 2:
            self.fail(place, f"spindle_range = {found!r:.40}: write two speeds in rpm, like [6000, 12000]")
        low, high = (self.turns_of(place, "spindle_range", each) for each in found)
        return low, high

    def cutting_speed(self, place: str, table: Mapping[str, object]) -> float | None:
        """[m/s]: a number in m/min, or text with a unit of its own."""
        found = table.get("cutting_speed")
        if found is None or isinstance(found, str):
            return None if found is None else self.parsed(place, "cutting_speed", found, parse_feed)
        return self.number(place, "cutting_speed", found, "m/min") / MINUTE

    def stability(self, place: str, table: Mapping[str, object]) -> SpeedCurve | None:
        """Depths over speeds: a list of both, or the name of a file of them, which counts from the sheet's folder."""
        found = table.get("stability")
        if found is None:
            return None
        if isinstance(found, str):
            return self.stability_file(place, self.folder / self.text(place, "stability", found))

        def depth(value: object) -> float:
            return self.length_of(place, "stability", value, LONGEST_TOOL)

        return self.curve(place, "stability", found, depth)

    def stability_file(self, place: str, file: Path) -> SpeedCurve:
        """The chart of a file, with a heading or without."""
        try:
            with file.open(encoding="utf-8-sig") as stream:
                lines = stream.read(LONGEST_CHART).splitlines()
        except (OSError, ValueError) as error:
            why = reason(error) if isinstance(error, OSError) else "not a text file"
            self.fail(place, f"stability = {file.name[:40]!r}: cannot be read ({why}); give a file with {CHART}")
        rows: list[tuple[float, float]] = []
        for number, line in enumerate(lines, start=1):
            words = _SEPARATORS.split(line.split("#", 1)[0].strip())
            if words == [""] or (not rows and not _NUMBER.fullmatch(words[0])):
                continue
            if len(words) != 2 or not all(map(_NUMBER.fullmatch, words)):
                self.fail(place, f"stability: line {number} of {file.name[:40]} is {line[:40]!r}; write {CHART}")
            rows.append((float(words[0]) / MINUTE, float(words[1]) * MILLIMETRE))
        return self.made(lambda: SpeedCurve(tuple(each[0] for each in rows), tuple(each[1] for each in rows)))

    def curve(self, place: str, key: str, value: object, figure: Callable[[object], float]) -> SpeedCurve:
        """A list of points, each a spindle speed and a figure."""
        if not isinstance(value, list) or not all(isinstance(each, list) and len(each) == 2 for each in value):
            self.fail(place, f"{key} = {value!r:.40}: write points of rpm and value, like [[6000, 2], [8000, 3]]")
        points = [(self.turns_of(place, key, speed), figure(each)) for speed, each in value]
        return self.made(lambda: SpeedCurve(tuple(each[0] for each in points), tuple(each[1] for each in points)))

    def spindle(self) -> SpindleFigures:
        """The table [spindle]: power [kW] and torque [Nm] over speed."""
        table = self.table("spindle")
        self.refuse_unknown_keys("[spindle]", table, ("power", "torque"))

        def power(value: object) -> float:
            if isinstance(value, str):
                return self.parsed("[spindle]", "power", value, parse_power)
            return 1e3 * self.number("[spindle]", "power", value, "kW")

        found: dict[str, SpeedCurve] = {}
        if "power" in table:
            found["power"] = self.curve("[spindle]", "power", table["power"], power)
        if "torque" in table:
            found["torque"] = self.curve(
                "[spindle]", "torque", table["torque"], lambda each: self.number("[spindle]", "torque", each, "Nm")
            )
        return SpindleFigures(**found)

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
    told = tool.added if figures is None else {each.name: getattr(figures, each.name) for each in fields(figures)}
    plain = ("kind", "diameter", "corner_radius", *LENGTH_KEYS, *ANGLE_KEYS, "teeth", "material")
    # of a drill without a point it is told, since another one would be assumed
    table |= {
        key: told[key] for key in plain
        if key in told
        and (told[key] not in (None, "", 0.0, math.inf) or (key == "point_angle" and told.get("kind") == "drill"))
    }  # fmt: skip
    for key in ("shank", "holder"):
        if told.get(key):
            table[key] = [[piece.length, piece.lower_diameter, piece.upper_diameter] for piece in told[key]]
    if told.get("pitch"):
        table["pitch"] = list(told["pitch"])
    if told.get("runout"):
        table["runout"] = 2.0 * told["runout"]
    if told.get("spindle_speed") is not None:
        table["spindle_speed"] = f"{told['spindle_speed']!r} 1/s"
    if not told.get("clockwise", True):
        table["spindle"] = SPINDLES[1]
    if told.get("spindle_range") is not None:
        table["spindle_range"] = [f"{each!r} 1/s" for each in told["spindle_range"]]
    if told.get("cutting_speed") is not None:
        table["cutting_speed"] = f"{told['cutting_speed']!r} m/s"
    if told.get("stability") is not None:
        table["stability"] = _points(told["stability"])
    return table


def spindle_table(spindle: SpindleFigures) -> dict[str, object]:
    """What the sheet says of the machine's spindle, so that it reads as exactly this one."""
    table: dict[str, object] = {}
    if spindle.power is not None:
        table["power"] = [[speed, f"{value!r} W"] for speed, value in _points(spindle.power)]
    if spindle.torque is not None:
        table["torque"] = _points(spindle.torque)
    return table


def _points(curve: SpeedCurve) -> list[list[object]]:
    return [[f"{speed!r} 1/s", value] for speed, value in zip(curve.speed, curve.value)]


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
