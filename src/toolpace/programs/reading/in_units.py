"""TOML tables in mm and deg, unless a table [units] says otherwise."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from toolpace.common.files.toml import Tables
from toolpace.common.units import DEGREE, INCH, MILLIMETRE

LENGTHS = {"mm": MILLIMETRE, "m": 1.0, "in": INCH}
ANGLES = {"deg": DEGREE, "rad": 1.0}


class TablesInUnits(Tables):
    """One reading of such a file."""

    def __init__(self, source: str, raw: Mapping[str, Any], name: str, tables: tuple[str, ...]) -> None:
        """name: what the file is called in messages; tables: those that it may have."""
        super().__init__(source, raw)
        self.known(name, raw, tables)
        units = self.table("units")
        self.known("[units]", units, ("length", "angle"))
        self.length = self._unit(units, "length", LENGTHS, "mm")
        self.angle = self._unit(units, "angle", ANGLES, "deg")

    def _unit(self, units: Mapping[str, object], key: str, known: Mapping[str, float], usual: str) -> str:
        found = units.get(key, usual)
        if not isinstance(found, str) or found not in known:
            self.fail("[units]", f"{key} = {found!r:.40} is not known; write one of {', '.join(map(repr, known))}")
        return found
