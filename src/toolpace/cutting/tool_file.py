"""A `CuttingTool` from a TOML file, each figure checked with its unit.

    [tool]         diameter, teeth; helix, stick_out, runout, runout_angle, only
    [bending]      youngs_modulus (and diameter), or stiffness, or compliance; blend
    [cutting]      spindle_speed, Ktc, Krc (or material, cutter); Kac, Kte, Kre, Kae, spindle, force
    [engagement]   milling, axial_depth, radial_depth; the same under [engagement.operations.NAME]

docs/design/bending.md says what each means.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Literal, TypeVar

import numpy as np

from toolpace.common import units
from toolpace.common.errors import UsageError, did_you_mean
from toolpace.common.files.toml import TableFile, Tables
from toolpace.cutting.compliance import Bending
from toolpace.cutting.forces.material import Material
from toolpace.machine.cutting_tool import (
    FORCES,
    MILLINGS,
    OTHER_WORDS,
    Coefficients,
    Cut,
    Cutter,
    CuttingTool,
    Engagement,
    Milling,
)

FILE = TableFile("tool file", longest=100_000)
LONGEST_LENGTH = 1.0
"""Most of a length in it [m]: more is a slip of units."""
MOST_TEETH = 100
"""Of a cutter: more is a slip."""
SPINDLES = ("clockwise", "counterclockwise")
CUTS: tuple[Milling | Literal["none"], ...] = (*MILLINGS, "none")
PARTS = ("tool", "bending", "cutting", "engagement")
KEYS = {
    "tool": ("diameter", "teeth", "helix", "stick_out", "runout", "runout_angle", "only"),
    "bending": ("youngs_modulus", "diameter", "stiffness", "compliance", "blend"),
    "cutting": ("spindle_speed", "material", "cutter", "Ktc", "Krc", "Kac", "Kte", "Kre", "Kae", "spindle", "force"),
    "engagement": ("milling", "axial_depth", "radial_depth", "operations"),
}
Table = Mapping[str, object]
Value = TypeVar("Value")
Word = TypeVar("Word", bound=str)


def load_tool(path: str | Path) -> CuttingTool:
    """The tool in a file. Raises UsageError naming file, key, value and cure."""
    return tool_of_bytes(tool_bytes(path), str(path))


def tool_bytes(path: str | Path) -> bytes:
    """What a tool file holds, read once (it may be a pipe) and no further than one can go. Raises UsageError."""
    return FILE.data(path)


def tool_of_bytes(data: bytes, source: str) -> CuttingTool:
    """A tool from what its file holds; `source` names it in messages. Raises UsageError."""
    raw = FILE.table(FILE.text_of(data, source), source)
    return replace(_File(source, raw).read(), data=data)


class _File(Tables):
    """One reading of one file."""

    def read(self) -> CuttingTool:
        self.refuse_unknown_keys("the file", self.raw, PARTS)
        tool, bending, cutting, engagement = (self.part(name) for name in PARTS)
        cutter = self.cutter(tool)
        blend = self.length("[bending]", bending, "blend", cutter.diameter)
        if engagement.get("milling") == "stock":
            self.refuse_beside_stock(bending, engagement)
        return self.made(
            lambda: CuttingTool(
                compliance=self.bending(bending, tool, cutter).compliance,
                cut=self.cut(cutting, cutter, self.engaged("[engagement]", engagement, cutter, tool)),
                blend=blend,
                force=self.word("[cutting]", cutting, "force", FORCES, "mean"),
                operations=self.operations(engagement, cutting, cutter, tool),
                only=self.names(tool),
                youngs_modulus=self.modulus(bending) if "youngs_modulus" in bending else None,
                source=self.source,
            )
        )

    def made(self, make: Callable[[], Value]) -> Value:
        """What the figures make; where they contradict each other the file is named."""
        try:
            return make()
        except UsageError as error:
            text = str(error)
            raise UsageError(text if text.startswith(self.source) else f"{self.source}: {text}") from None

    def cutter(self, tool: Table) -> Cutter:
        teeth = tool.get("teeth")
        if isinstance(teeth, bool) or not isinstance(teeth, int) or not 1 <= teeth <= MOST_TEETH:
            self.fail("[tool]", f"teeth = {teeth!r:.40}: write how many, from 1 to {MOST_TEETH}, like teeth = 2")
        return Cutter(
            diameter=self.length("[tool]", tool, "diameter"),
            teeth=teeth,
            helix=self.quantity("[tool]", tool, "helix", units.parse_angle, "30deg", 0.0),
            # A dial gauge shows both sides.
            runout=0.5 * self.length("[tool]", tool, "runout", 0.0),
            runout_angle=self.quantity("[tool]", tool, "runout_angle", units.parse_angle, "90deg", 0.0),
        )

    def bending(self, bending: Table, tool: Table, cutter: Cutter) -> Bending:
        """From the one of three ways to say it that is there."""
        keys = [key for key in ("youngs_modulus", "stiffness", "compliance") if key in bending]
        if len(keys) != 1:
            found = f"has {' and '.join(keys)}" if keys else "says nothing of stiffness"
            self.fail(
                "[bending]",
                f'{found}; write one of youngs_modulus = "580GPa", stiffness = ["9N/um", "9N/um", "200N/um"] or '
                "compliance (3 x 3, um/N)",
            )
        if keys == ["youngs_modulus"]:
            if "stick_out" not in tool:
                self.fail("[tool]", 'stick_out is missing: youngs_modulus needs it; write it like stick_out = "30mm"')
            modulus = self.modulus(bending)
            bar = self.length("[bending]", bending, "diameter", cutter.diameter)
            return Bending.cantilever(bar, self.length("[tool]", tool, "stick_out"), modulus)
        if "diameter" in bending:
            self.fail("[bending]", f"diameter goes with youngs_modulus, and {keys[0]} is there; remove one of both")
        if keys == ["stiffness"]:
            three = self.three("[bending]", bending, "stiffness", '["9N/um", "9N/um", "200N/um"]')
            place = "[bending] stiffness"
            springs = [
                self.quantity(place, {k: each}, k, units.parse_stiffness, "9N/um") for k, each in zip("xyz", three)
            ]
            return Bending.of_stiffness(*springs)
        rows = self.three("[bending]", bending, "compliance", "[[0.1, 0, 0], [0, 0.1, 0], [0, 0, 0.005]] in um/N")
        matrix = [[self.number("[bending]", "compliance", each) * 1e-6 for each in self.row(row)] for row in rows]
        return self.made(lambda: Bending(np.array(matrix)))

    def modulus(self, bending: Table) -> float:
        return self.quantity("[bending]", bending, "youngs_modulus", units.parse_pressure, "580GPa")

    def refuse_beside_stock(self, bending: Table, engagement: Table) -> None:
        """Raise UsageError for what the stock and the sheet's tool tell already."""
        if "youngs_modulus" not in bending:
            self.fail("[bending]", 'with milling = "stock" the tool bends as a bar; write its youngs_modulus')
        for key in ("axial_depth", "radial_depth", "operations"):
            if key in engagement:
                self.fail("[engagement]", f'{key} beside milling = "stock": the stock tells it; remove one of both')

    def row(self, row: object) -> list[object]:
        if not isinstance(row, list) or len(row) != 3:
            self.fail("[bending]", f"compliance has the row {row!r:.40}; write three numbers [um/N]")
        return row

    def engaged(self, place: str, table: Table, cutter: Cutter, tool: Table) -> Engagement | None:
        """What is in the material; None where nothing is."""
        milling = self.word(place, table, "milling", CUTS)
        if milling == "none":
            return None
        if milling == "stock":
            if place != "[engagement]":
                self.fail(place, 'milling = "stock" is for all operations; write it under [engagement]')
            return Engagement(milling)
        axial = self.length(place, table, "axial_depth")
        if "stick_out" in tool and axial > (out := self.length("[tool]", tool, "stick_out")):
            self.fail(place, f"axial_depth = {table['axial_depth']!r} is more than the stick_out of {out * 1e3:g} mm")
        radial = cutter.diameter if milling == "slot" else self.length(place, table, "radial_depth")
        if radial > cutter.diameter:
            self.fail(
                place,
                f"radial_depth = {table['radial_depth']!r} is more than the diameter of {cutter.diameter * 1e3:g} mm; "
                'give at most that, or milling = "slot"',
            )
        return Engagement(milling, axial, radial)

    def cut(self, cutting: Table, cutter: Cutter, engagement: Engagement | None) -> Cut:
        if engagement is None:
            self.fail("[engagement]", 'milling = "none" says that nothing cuts; write how most operations do')

        known = self.material(cutting)

        def edge(key: str, usual: float) -> float:
            return self.quantity("[cutting]", cutting, key, units.parse_edge_force, "25N/mm", usual)

        def chip(key: str, usual: float | None) -> float:
            return self.quantity("[cutting]", cutting, key, units.parse_pressure, "1800MPa", usual)

        coefficients = Coefficients(
            chip("Ktc", known.tangential if known else None),
            chip("Krc", known.radial if known else None),
            chip("Kac", known.axial if known else 0.0),
            edge("Kte", known.tangential_edge if known else 0.0),
            edge("Kre", known.radial_edge if known else 0.0),
            edge("Kae", known.axial_edge if known else 0.0),
        )
        return Cut(
            cutter,
            coefficients,
            engagement,
            self.quantity("[cutting]", cutting, "spindle_speed", units.parse_spindle_speed, "18000rpm"),
            self.word("[cutting]", cutting, "spindle", SPINDLES, SPINDLES[0]) == SPINDLES[0],
        )

    def material(self, cutting: Table) -> Coefficients | None:
        """The coefficients of a material that the file names; what else it states takes their place."""
        name, cutter = cutting.get("material"), cutting.get("cutter", "")
        if name is None and not cutter:
            return None
        if not isinstance(name, str) or not isinstance(cutter, str):
            self.fail("[cutting]", 'material and cutter are words; write them like material = "Al7075-T6"')
        if name.endswith(".toml"):
            # a copy of this file alone is kept with a plan
            self.fail("[cutting]", f"material = {name!r:.40} is a file; write its coefficients here")
        try:
            return Material.load(name, cutter).coefficients
        except UsageError as error:
            self.fail("[cutting]", f"material: {error}")

    def operations(self, engagement: Table, cutting: Table, cutter: Cutter, tool: Table) -> dict[str, Cut | None]:
        """By name; what a table does not say is as in all other operations."""
        tables = engagement.get("operations", {})
        if not isinstance(tables, dict):
            self.fail("[engagement]", "operations is not a table; write [engagement.operations.NAME]")
        found: dict[str, Cut | None] = {}
        for name, table in tables.items():
            place = f"[engagement.operations.{name[:40]}]"
            if not isinstance(table, dict):
                self.fail(place, f"= {table!r:.40} is not a table; write it under that heading")
            self.refuse_unknown_keys(place, table, KEYS["engagement"][:-1])
            engaged = self.engaged(place, {**engagement, **table}, cutter, tool)
            found[name] = None if engaged is None else self.cut(cutting, cutter, engaged)
        return found

    def part(self, name: str) -> Table:
        found = self.raw.get(name)
        if not isinstance(found, dict):
            self.fail(f"[{name}]", f"is {'missing' if found is None else 'not a table'}; write it under that heading")
        self.refuse_unknown_keys(f"[{name}]", found, KEYS[name])
        return found

    def names(self, tool: Table) -> tuple[str, ...]:
        found = tool.get("only", [])
        if not isinstance(found, list) or not all(isinstance(each, str) for each in found):
            self.fail("[tool]", f'only = {found!r:.40}: write the tools as the program calls them, like only = ["1"]')
        return tuple(found)

    def three(self, place: str, table: Table, key: str, example: str) -> list[object]:
        found = table[key]
        if not isinstance(found, list) or len(found) != 3:
            self.fail(place, f"{key} = {found!r:.40} is not a list of three; write it like {key} = {example}")
        return found

    def word(self, place: str, table: Table, key: str, words: tuple[Word, ...], usual: Word | None = None) -> Word:
        found = table.get(key, usual)
        if found is None:
            self.fail(place, f"{key} is missing; write one of {', '.join(words)}")
        for word in words:
            if found == word:
                return word
        other = OTHER_WORDS.get(str(found).strip().lower().split(" ")[0]) if key == "milling" else None
        hint = f"did you mean '{other}'?" if other else did_you_mean(str(found)[:40], words)
        self.fail(place, f"{key} = {found!r:.40} is not known; {hint}")

    def length(self, place: str, table: Table, key: str, usual: float | None = None) -> float:
        """Above zero, but where it is left out or may be nothing."""
        found = self.quantity(place, table, key, units.parse_length, "4mm", usual)
        if not found <= LONGEST_LENGTH:
            self.fail(place, f"{key} = {table[key]!r:.40} is more than {LONGEST_LENGTH:g} m: check its unit")
        if found == 0.0 and usual != 0.0:
            self.fail(place, f'{key} = {table[key]!r:.40} is nothing; give more than zero, like "4mm"')
        return found

    def quantity(
        self,
        place: str,
        table: Table,
        key: str,
        parse: Callable[[str], float],
        example: str,
        usual: float | None = None,
    ) -> float:
        """A figure with its unit, in SI; the usual one where it is left out."""
        if key not in table:
            if usual is None:
                self.fail(place, f'{key} is missing; write it like {key} = "{example}"')
            return usual
        value = table[key]
        if not isinstance(value, str):
            self.fail(place, f'{key} = {value!r:.40} has no unit; write it in quotes, like {key} = "{example}"')
        try:
            return parse(value)
        except UsageError as error:
            self.fail(place, f"{key}: {error}")

    def number(self, place: str, key: str, value: object) -> float:
        if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) < 1e12:
            self.fail(place, f"{key} holds {value!r:.40}, which is no finite number; write it in um/N, like 0.1")
        return float(value)
