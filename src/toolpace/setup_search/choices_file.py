"""`Choices` from a TOML file.

[units]        length = "mm", angle = "deg"; or m, in, rad
[choose]       turn, tilt, swing, x, y, z, tool_length: one value, a list of those at hand, or {from = 0, to = 45};
               solution: "both", "free", "+", "-", or a list of these
[[forbidden]]  name; joints with the positions between which the machine must not be: X = [100, 300]
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from toolpace.common.files.toml import TableFile
from toolpace.programs.reading.setup_file import ANGLES, LENGTHS, TablesInUnits
from toolpace.setup_search.choices import Choice, Choices, Zone, is_angle

FILE = TableFile("file of choices", longest=100_000)
MOST = 100
"""Values of a list, and zones."""
ANGLED, PLACES = ("turn", "tilt", "swing"), ("x", "y", "z")
KEYS = (*ANGLED, *PLACES, "tool_length", "solution")
SOLUTIONS = {"free": 0.0, "+": 1.0, "-": -1.0}
FARTHEST, LONGEST_TOOL, MOST_TURN = 100.0, 10.0, 4.0 * math.pi
"""Most of a shift [m], of a tool [m], of an angle [rad]: more is a slip of units."""


def load_choices(path: str | Path) -> Choices:
    """The choices in a file. Raises UsageError naming file, key, value and cure."""
    return choices_of_text(FILE.text(path), str(path))


def choices_of_text(text: str, source: str = "choices") -> Choices:
    """Choices from the text of a file; `source` names it in messages. Raises UsageError."""
    return _File(source, FILE.table(text, source), "the file", ("units", "choose", "forbidden")).read()


class _File(TablesInUnits):
    """One reading of one file."""

    def read(self) -> Choices:
        choose = self.table("choose")
        self.known("[choose]", choose, KEYS)
        chosen: dict[str, Any] = {key: self.choice(key, value) for key, value in choose.items() if key != "solution"}
        if "solution" in choose:
            chosen["side"] = self.solution(choose["solution"])
        return Choices(**chosen, forbidden=self.zones(), source=self.source)

    def choice(self, key: str, value: object) -> Choice:
        """One value, a list, or a range."""
        place = f"[choose] {key}"
        if isinstance(value, dict):
            self.known(place, value, ("from", "to"))
            if "from" not in value or "to" not in value:
                self.fail(place, f"= {value!r:.40} is no range; write {{from = 0, to = 45}}")
            low, high = self.figure(place, key, value["from"]), self.figure(place, key, value["to"])
            if not low <= high:
                self.fail(place, f"runs from {value['from']} to {value['to']}; write the lower one first")
            return Choice.between(low, high)
        listed = value if isinstance(value, list) else [value]
        if not 0 < len(listed) <= MOST:
            self.fail(place, f"lists {len(listed)} values; write 1 to {MOST}, or a range like {{from = 0, to = 45}}")
        if key in PLACES and len(listed) > 1:
            self.fail(
                place, f"= {value!r:.40} is a list; a place is one value or a range, like {{from = -50, to = 50}}"
            )
        return Choice(tuple(dict.fromkeys(self.figure(place, key, each) for each in listed)))

    def figure(self, place: str, key: str, value: object) -> float:
        unit, scale = (self.angle, ANGLES[self.angle]) if key in ANGLED else (self.length, LENGTHS[self.length])
        found = self.number(place, value, unit) * scale
        most = MOST_TURN if key in ANGLED else LONGEST_TOOL if key == "tool_length" else FARTHEST
        if not abs(found) <= most:
            self.fail(place, f"= {value!r:.40} is more than {most / scale:g} {unit}: check its unit")
        if key == "tool_length" and found < 0.0:
            self.fail(place, f"= {value!r:.40} is below zero; write it from the spindle nose to the tip")
        return found

    def number(self, place: str, value: object, unit: str) -> float:
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            self.fail(place, f"= {value!r:.40} is not a number; write it in {unit}, like 12.5")
        if value != value:
            self.fail(place, f"= nan is not a number; write it in {unit}, like 12.5")
        return float(value) if abs(value) < 1e300 else math.copysign(math.inf, value)

    def solution(self, value: object) -> Choice:
        """Which solutions may be taken; "both" stands for all three words."""
        words = [*SOLUTIONS] if value == "both" else value if isinstance(value, list) else [value]
        for word in words:
            if not isinstance(word, str) or word not in SOLUTIONS:
                self.fail("[choose] solution", f"= {word!r:.40} is not known; write 'both', 'free', '+' or '-'")
        if not words:
            self.fail("[choose] solution", "= [] leaves none; write 'both', 'free', '+' or '-'")
        return Choice(tuple(sorted({SOLUTIONS[str(word)] for word in words})))

    def zones(self) -> tuple[Zone, ...]:
        tables = self.raw.get("forbidden", [])
        if not isinstance(tables, list) or not all(isinstance(each, dict) for each in tables):
            self.fail("forbidden", "is not a list of tables; write each zone under [[forbidden]]")
        if len(tables) > MOST:
            self.fail("forbidden", f"lists {len(tables)} zones; {MOST} are the most")
        return tuple(self.zone(number, table) for number, table in enumerate(tables, start=1))

    def zone(self, number: int, table: Mapping[str, Any]) -> Zone:
        name = table.get("name", f"{number}")
        if not isinstance(name, str) or not 0 < len(name) <= 100:
            self.fail(f"[[forbidden]] {number}", f"name = {name!r:.40} is no name; write it in quotes")
        bounds = {key: self.bounds(name, key, value) for key, value in table.items() if key != "name"}
        if not bounds:
            self.fail(f"[[forbidden]] {name}", "bounds no joint; write like X = [100, 300], in positions of the joint")
        return Zone(name, bounds)

    def bounds(self, name: str, joint: str, value: object) -> tuple[float, float]:
        """Lowest and highest position of a joint [length or angle of the file: `Choices.checked` tells which]."""
        place = f"[[forbidden]] {name}: {joint[:40]}"
        if not isinstance(value, list) or len(value) != 2:
            self.fail(place, f"= {value!r:.40} is not two positions; write like [100, 300], or [100, inf]")
        unit, scale = (self.angle, ANGLES[self.angle]) if is_angle(joint) else (self.length, LENGTHS[self.length])
        low, high = (self.number(place, each, unit) * scale for each in value)
        if low >= high:
            self.fail(place, f"= {value!r:.40} holds nothing; write the lower position first")
        return low, high
