"""Materials that are cut, with their force coefficients: data files with source, validity and spread.

    name = "Al7075-T6"
    note = "..."

    [[coefficients]]                 # as many as are published; the first is taken where no cutter is named
    cutter = "carbide, dry"
    Ktc = "767.01N/mm2"              # Ktc, Krc, Kac, Kte, Kre, Kae; what is left out is not known and counts as none
    source = "..."
    validity = "..."
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Any

from toolpace.common import units
from toolpace.common.errors import UsageError, did_you_mean
from toolpace.common.files.toml import TableFile, Tables
from toolpace.common.value_objects import one_line
from toolpace.machine.cutting_tool import Coefficients

FILE = TableFile("material file", longest=100_000)
KEYS: dict[str, tuple[str, Callable[[str], float], str]] = {
    "Ktc": ("tangential", units.parse_pressure, "800N/mm2"),
    "Krc": ("radial", units.parse_pressure, "300N/mm2"),
    "Kac": ("axial", units.parse_pressure, "200N/mm2"),
    "Kte": ("tangential_edge", units.parse_edge_force, "15N/mm"),
    "Kre": ("radial_edge", units.parse_edge_force, "12N/mm"),
    "Kae": ("axial_edge", units.parse_edge_force, "3N/mm"),
}
"""Of a set of coefficients: the field, how its unit is read, an example."""
TEXTS = ("cutter", "source", "validity")


@dataclass(frozen=True, repr=False)
class Material:
    """One published set of coefficients of a material, and how far all of its sets lie apart."""

    name: str
    coefficients: Coefficients
    cutter: str
    """What it was measured with."""
    source: str
    validity: str
    """Where the figures hold, as far as the source tells."""
    spread: Mapping[str, tuple[float, float]]
    """Least and most of each coefficient in all sets of the file that tell it [Pa], [N/m]."""
    others: tuple[str, ...] = ()
    """The cutters of the other sets."""

    def __repr__(self) -> str:
        return one_line(self, self.name, self.cutter, self.source)

    @classmethod
    def load(cls, name: str | Path, cutter: str = "") -> Material:
        """A built-in material by its name, or one in a file (a path that ends in .toml).

        cutter: words that the wanted set's cutter has; the first set without. Raises UsageError with the names that
        there are, and for files with anything else in them than is told above.
        """
        text = str(name)
        if text.endswith(".toml"):
            return _chosen(_read(FILE.text(text), text), cutter)
        found = {_plain(each.name): each for each in resources.files("toolpace.cutting.materials").iterdir()}
        wanted = _plain(f"{text}.toml")
        if wanted not in found:
            raise UsageError(f"material '{text[:40]}' is not known; {did_you_mean(text[:40], cls.names())}")
        return _chosen(_read(found[wanted].read_text("utf-8"), found[wanted].name), cutter)

    @staticmethod
    def names() -> list[str]:
        """Of all built-in materials."""
        files = resources.files("toolpace.cutting.materials").iterdir()
        return sorted(each.name.removesuffix(".toml") for each in files if each.name.endswith(".toml"))


def _plain(name: str) -> str:
    return name.lower().replace(" ", "").replace("-", "").replace("_", "")


def _chosen(sets: list[Material], cutter: str) -> Material:
    for each in sets:
        if cutter.lower() in each.cutter.lower():
            return each
    hint = did_you_mean(cutter[:40], [each.cutter for each in sets])
    raise UsageError(f"{sets[0].name} has no coefficients for the cutter '{cutter[:40]}'; {hint}")


def _read(text: str, source: str) -> list[Material]:
    raw = FILE.table(text, source)
    tables = Tables(source, raw)
    tables.refuse_unknown_keys("the file", raw, ("name", "note", "coefficients"))
    sets = raw.get("coefficients")
    if not isinstance(sets, list) or not sets or not all(isinstance(each, dict) for each in sets):
        tables.fail("[[coefficients]]", "is missing; write at least one set under that heading")
    if not isinstance(raw.get("name"), str):
        tables.fail("name", 'is missing; write it like name = "Al7075-T6"')
    figures = [_figures(tables, each) for each in sets]
    spread = {
        field: (min(known), max(known))
        for field, _, _ in KEYS.values()
        if (known := [each[field] for each in figures if field in each])
    }
    cutters = [each["cutter"] for each in sets]
    return [
        Material(
            name=raw["name"],
            coefficients=Coefficients(**each),
            cutter=table["cutter"],
            source=table["source"],
            validity=table["validity"],
            spread=spread,
            others=tuple(cutter for k, cutter in enumerate(cutters) if k != number),
        )
        for number, (each, table) in enumerate(zip(figures, sets))
    ]


def _figures(tables: Tables, table: dict[str, Any]) -> dict[str, float]:
    """The coefficients that a set tells, by field."""
    tables.refuse_unknown_keys("[[coefficients]]", table, (*TEXTS, *KEYS))
    for key in TEXTS:
        if not isinstance(table.get(key), str):
            tables.fail("[[coefficients]]", f'{key} is missing; write it in quotes, like {key} = "..."')
    found = {}
    for key, (field, parse, example) in KEYS.items():
        if key not in table:
            if key in ("Ktc", "Krc"):
                tables.fail("[[coefficients]]", f'{key} is missing; write it like {key} = "{example}"')
            continue
        if not isinstance(table[key], str):
            tables.fail("[[coefficients]]", f'{key} has no unit; write it in quotes, like {key} = "{example}"')
        try:
            found[field] = parse(table[key])
        except UsageError as error:
            tables.fail("[[coefficients]]", f"{key}: {error}")
    return found
