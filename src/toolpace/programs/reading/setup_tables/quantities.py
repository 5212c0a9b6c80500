"""Figures of a file in its own units, or each with a unit of its own ("12mm"); every error names file, table and key.

Lengths are in mm and angles in deg unless a table [units] says otherwise.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, TypeVar

from toolpace.common.errors import UsageError, did_you_mean
from toolpace.common.files.toml import Tables
from toolpace.common.units import DEGREE, INCH, MILLIMETRE, MINUTE, parse_angle, parse_length, parse_spindle_speed

LENGTHS = {"mm": MILLIMETRE, "m": 1.0, "in": INCH}
ANGLES = {"deg": DEGREE, "rad": 1.0}
MOST_TURN = 1e6
"""Most of an angle [rad]: more is a slip."""
Vector = tuple[float, float, float]
Word = TypeVar("Word", bound=str)
Made = TypeVar("Made")


class TablesInUnits(Tables):
    """One reading of such a file."""

    def __init__(self, source: str, raw: Mapping[str, Any], name: str, tables: tuple[str, ...]) -> None:
        """name: what the file is called in messages; tables: those that it may have."""
        super().__init__(source, raw)
        self.refuse_unknown_keys(name, raw, tables)
        units = self.table("units")
        self.refuse_unknown_keys("[units]", units, ("length", "angle"))
        self.length = self._unit(units, "length", LENGTHS, "mm")
        self.angle = self._unit(units, "angle", ANGLES, "deg")

    def _unit(self, units: Mapping[str, object], key: str, scales: Mapping[str, float], usual: str) -> str:
        found = units.get(key, usual)
        if not isinstance(found, str) or found not in scales:
            self.fail("[units]", f"{key} = {found!r:.40} is not known; write one of {', '.join(map(repr, scales))}")
        return found


class Quantities(TablesInUnits):
    """Figures of a sheet in SI."""

    def quantity(
        self, place: str, key: str, value: object, unit: str, scales: Mapping[str, float], most: float
    ) -> float:
        """A number in its unit, in m or rad."""
        found = self.number(place, key, value, unit) * scales[unit]
        if not abs(found) <= most:
            self.fail(place, f"{key} = {value!r:.40} is more than {most / scales[unit]:g} {unit}: check its unit")
        return found

    def length_of(self, place: str, key: str, value: object, most: float) -> float:
        """A length [m]: a number in the sheet's unit, or text with a unit of its own."""
        if isinstance(value, str):
            return self.parsed(place, key, value, parse_length)
        return self.quantity(place, key, value, self.length, LENGTHS, most)

    def angle_of(self, place: str, key: str, value: object) -> float:
        """An angle [rad]: a number in the sheet's unit, or text with a unit of its own."""
        if isinstance(value, str):
            return self.parsed(place, key, value, parse_angle)
        return self.quantity(place, key, value, self.angle, ANGLES, MOST_TURN)

    def turns_of(self, place: str, key: str, value: object) -> float:
        """Turns per second [1/s]: a number in turns per minute, or text with a unit of its own."""
        if isinstance(value, str):
            return self.parsed(place, key, value, parse_spindle_speed)
        return self.number(place, key, value, "rpm") / MINUTE

    def parsed(self, place: str, key: str, value: str, parse: Callable[[str], float]) -> float:
        """A figure with a unit of its own, in SI."""
        try:
            return parse(value)
        except UsageError as error:
            self.fail(place, f"{key}: {error}")

    def place_of(self, place: str, key: str, value: object, most: float) -> Vector:
        """A place (3,) [m]."""
        x, y, z = (self.length_of(place, key, each, most) for each in self.three(place, key, value))
        return x, y, z

    def direction_of(self, place: str, key: str, value: object) -> Vector:
        """A direction (3,), of any length above zero."""
        x, y, z = (self.number(place, key, each) for each in self.three(place, key, value))
        if not math.hypot(x, y, z) > 0.0:
            self.fail(place, f"{key} has no length; write a direction, like {key} = [0, 0, 1]")
        return x, y, z

    def three(self, place: str, key: str, value: object) -> list[object]:
        """A list of three."""
        if not isinstance(value, list) or len(value) != 3:
            self.fail(place, f"{key} = {value!r:.40} is not three numbers; write it like {key} = [0, 0, 1]")
        return value

    def word(self, place: str, key: str, value: object, words: tuple[Word, ...]) -> Word:
        """One of these words."""
        for each in words:
            if value == each:
                return each
        self.fail(place, f"{key} = {value!r:.40} is not known; {did_you_mean(str(value)[:40], words)}")

    def text(self, place: str, key: str, value: object, longest: int = 1000) -> str:
        """A text as it stands there."""
        if not isinstance(value, str) or not 0 < len(value) <= longest or "\0" in value:
            self.fail(place, f'{key} = {value!r:.40} is no text; write it in quotes, like {key} = "name"')
        return value

    def number(self, place: str, key: str, value: object, unit: str = "") -> float:
        """A finite number as it stands there."""
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            self.fail(
                place, f"{key[:40]} = {value!r:.40} is not a number; write it{f' in {unit}' * bool(unit)} like 12.5"
            )
        try:
            found = float(value)
        except OverflowError:
            found = math.inf
        if not math.isfinite(found):
            self.fail(place, f"{key[:40]} = {str(value)[:40]} is not finite; write a number")
        return found

    def made(self, make: Callable[[], Made]) -> Made:
        """What the figures make; where they contradict each other the message is as short as all others."""
        try:
            return make()
        except UsageError as error:
            raise UsageError(str(error)[: self.longest]) from None
