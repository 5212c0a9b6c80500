"""Shapes of tools from their names and from comments, by rules in a controller's file ([[tools]]).

    [[tools]]
    pattern = '(?P<kind>SCHAFT|PLAN)_D(?P<diameter>[\\d.]+)(?:_N)?_AP(?P<flute_length>[\\d.]+)'
    kinds = { SCHAFT = "flat", PLAN = "face" }

Shops and post-processors write them in ways of their own, so that nothing is read without such a rule.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any

import msgspec

from toolpace.common.errors import UsageError, did_you_mean
from toolpace.common.units import DEGREE, LENGTHS
from toolpace.programs.reading.coordinates.setup import tool_name
from toolpace.programs.tool_figures import KINDS, ToolFigures
from toolpace.programs.toolpath import Operation

OF_LENGTH = ("diameter", "corner_radius", "flute_length", "stick_out", "shank_diameter", "barrel_radius")
OF_ANGLE = ("taper", "point_angle", "helix")
GROUPS = ("tool", "kind", *OF_LENGTH, *OF_ANGLE, "teeth", "material")
LONGEST = 500
"""Most characters of a name or a line that is looked at."""


class ToolRule(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """How a name or a comment tells the shape of a tool; of several rules the first that fits decides."""

    pattern: str
    """Regular expression, in any case of letters, with named groups: those of the set-up sheet's figures (GROUPS), in
    `unit` and degrees. It is looked for in the names of tools; with a group `tool`, in the lines of the program."""
    kind: str = ""
    """Of all tools that it fits; else by the group `kind`, or from the corner radius."""
    kinds: dict[str, str] = {}
    """What words of the group `kind` mean."""
    unit: str = "mm"

    def fault(self) -> str:
        """What is wrong with it, and the cure; empty where nothing is."""
        groups = re.compile(self.pattern).groupindex
        for group in groups:
            if group not in GROUPS:
                return f"the group '{group[:40]}' of a pattern of [[tools]] is not known: {did_you_mean(group, GROUPS)}"
        if "diameter" not in groups:
            return "a pattern of [[tools]] has no group 'diameter': write it like (?P<diameter>[0-9.]+)"
        for kind in (self.kind or KINDS[0], *self.kinds.values()):
            if kind not in KINDS:
                return f"kind '{kind[:40]}' of [[tools]] is not known: {did_you_mean(kind, KINDS)}"
        if self.unit not in LENGTHS:
            return f"unit '{self.unit[:40]}' of [[tools]] is not known: {did_you_mean(self.unit, LENGTHS)}"
        return ""

    @property
    def of_lines(self) -> bool:
        """Whether it is looked for in the lines of the program."""
        return "tool" in re.compile(self.pattern).groupindex

    def figures(self, text: str, source: str) -> tuple[str, ToolFigures] | None:
        """The tool that the text names ("" where the rule is of names), and its shape; None where it fits none.

        What fits and contradicts itself is none.
        """
        found = re.search(self.pattern, text[:LONGEST], re.IGNORECASE)
        if found is None:
            return None
        words = {name: word.replace(",", ".") for name, word in found.groupdict().items() if word}
        try:
            figures: dict[str, Any] = {key: float(words[key]) * LENGTHS[self.unit] for key in OF_LENGTH if key in words}
            figures |= {key: float(words[key]) * DEGREE for key in OF_ANGLE if key in words}
            if "teeth" in words:
                figures["teeth"] = int(words["teeth"])
            corner = figures.get("corner_radius", 0.0)
            kinds = {word.lower(): kind for word, kind in self.kinds.items()}
            kind: Any = self.kind or kinds.get(words.get("kind", "").lower())
            ball = corner > 0.0 and abs(corner - 0.5 * figures["diameter"]) < 1e-6 * figures["diameter"]
            kind = kind or ("ball" if ball else "bull" if corner else "flat")
            material = words.get("material", "")
            return words.get("tool", ""), ToolFigures(kind, **figures, material=material, source=source)
        except (KeyError, ValueError, UsageError):
            return None


def with_rules(
    operations: Iterable[Operation], rules: Sequence[ToolRule], lines: Sequence[str], source: str
) -> tuple[Operation, ...]:
    """The operations, with the shapes of tools that the program tells by these rules and not otherwise.

    lines: of the program. What a line says of a tool goes before its name.
    """
    of_lines = [rule for rule in rules if rule.of_lines]
    by_line: dict[str, ToolFigures] = {}
    for number, line in enumerate(lines if of_lines else (), start=1):
        fits = (rule.figures(line, f"{source}:{number}: comment") for rule in of_lines)
        if (found := next(filter(None, fits), None)) is not None:
            by_line.setdefault(tool_name(found[0]), found[1])
    of_names = [rule for rule in rules if not rule.of_lines]

    def shape(operation: Operation) -> ToolFigures | None:
        if operation.figures is not None or not operation.tool:
            return operation.figures
        if (figures := by_line.get(tool_name(operation.tool))) is not None:
            return figures
        fits = (rule.figures(operation.tool, f"{source}: name of tool {operation.tool}") for rule in of_names)
        found = next(filter(None, fits), None)
        return None if found is None else found[1]

    return tuple(replace(each, figures=shape(each)) for each in operations)
