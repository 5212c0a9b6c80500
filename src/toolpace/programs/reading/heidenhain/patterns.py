"""Hole patterns: cycles 220 and 221, PATTERN DEF."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable

from toolpace.common.units import DEGREE
from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.control.cycles import MOST_HOLES, laid_out, on_circle, on_grid
from toolpace.programs.reading.expressions import BlockError
from toolpace.programs.reading.heidenhain.contour.straight_lines import Motion, Step
from toolpace.programs.reading.heidenhain.drilling import Holes, Items
from toolpace.programs.reading.heidenhain.parameters import Parameters, Value, evaluate
from toolpace.programs.reading.heidenhain.state import OF_AXIS
from toolpace.programs.reading.heidenhain.words import VALUE, PathWords, signed

_PART = re.compile(r"(POS|ROW|PAT|FRAME|CIRC|PITCHCIRC)[0-9]+\s*\(([^()]*)\)")
_VALUED = re.compile(r"(ROTX|ROTY|ROT|NUMX|NUMY|NUM|START|STEP|DX|DY|[DXYZ])\s*(" + VALUE + ")")
Place = tuple[float, float, float]
"""Along both axes of the plane, and how high the surface is above Q203 [m]."""


class Patterns:
    """Places of holes, and their drilling one after the other."""

    def __init__(self, control: Control, holes: Holes, motion: Motion, parameters: Parameters) -> None:
        self.control, self.holes, self.motion, self.parameters = control, holes, motion, parameters
        self.parts: list[tuple[str, dict[str, Value]]] = []

    def circle(self, items: Items) -> None:
        """220: the last cycle on a circle."""
        if items.get(365, 0.0) != 0.0:
            cure = "write Q365=0: the way from hole to hole on the circle is not read"
            self.control.refuse("CYCL DEF 220 with Q365=1", cure)
        figures = self.figures(items, (216, 217, 244, 245, 246, 241))
        x, y, diameter, start, end, count = figures
        holes = self.count(count)
        whole = abs((end - start) % 360.0) < 1e-9
        step = items.get(247, 0.0)
        if not isinstance(step, float) or step == 0.0:
            step = (end - start) / (holes if whole else max(holes - 1, 1))
        self.at_once(items, self.on_circle(x, y, diameter, start, step, holes))

    def grid(self, items: Items) -> None:
        """221: the last cycle on a grid."""
        x, y, dx, dy, columns, rows, angle = self.figures(items, (225, 226, 237, 238, 242, 243, 224))
        self.at_once(items, self.on_grid(x, y, dx, dy, self.count(columns), self.count(rows), angle))

    def at_once(self, items: Items, places: list[Place]) -> None:
        """Run the last cycle at each, with the levels that the pattern gives."""
        if not self.holes.number:
            raise BlockError("no cycle is defined before this pattern: write CYCL DEF 200 .. before it")
        self.holes.amend({q: items[q] for q in (200, 203, 204) if q in items})
        self.run(places, rapid=True, low=items.get(301, 1.0) == 0.0)

    def figures(self, items: Items, wanted: Iterable[int]) -> list[float]:
        """Numbers of a pattern. Raises BlockError."""
        found = []
        for q in wanted:
            value = items.get(q)
            if not isinstance(value, float):
                raise BlockError(f"the pattern lacks Q{q}: write all of its parameters")
            found.append(value)
        return found

    def count(self, value: float) -> int:
        """How many. Raises BlockError."""
        if value != int(value) or not 1 <= value <= MOST_HOLES:
            raise BlockError(f"a count of {value:g} holes must be a whole number from 1 to {MOST_HOLES}")
        return int(value)

    def on_circle(self, x: float, y: float, diameter: float, start: float, step: float, count: int) -> list[Place]:
        """Places on a circle; angles in degrees."""
        unit, radius = self.motion.state.unit, diameter / 2.0
        angles = [(start + k * step) * DEGREE for k in range(count)]
        return [(a * unit, b * unit, 0.0) for a, b in on_circle(x, y, radius, angles)]

    def on_grid(
        self, x: float, y: float, dx: float, dy: float, columns: int, rows: int, angle: float, border: bool = False
    ) -> list[Place]:
        """Places of rows that are gone through to and fro, turned about the first; its border alone where asked."""
        if columns * rows > MOST_HOLES:
            raise BlockError(f"a pattern of {columns} times {rows} holes has more than {MOST_HOLES}")
        unit = self.motion.state.unit
        grid = on_grid([k * dx for k in range(columns)], [k * dy for k in range(rows)], border=border)
        return [(a * unit, b * unit, 0.0) for a, b in laid_out(grid, x, y, angle * DEGREE)]

    # PATTERN DEF

    def compile(self, text: str) -> Step:
        """PATTERN DEF. Raises BlockError."""
        text = text.removeprefix("DEF")
        unread = _PART.sub("", text) + "".join(_VALUED.sub("", inner) for _, inner in _PART.findall(text))
        if rest := unread.strip():
            raise BlockError(f"'{rest[:20]}' is not read in PATTERN DEF: check its spelling")
        parts = [
            (kind, {name: signed(value, self.parameters) for name, value in _VALUED.findall(inner)})
            for kind, inner in _PART.findall(text)
        ]
        if not parts:
            raise BlockError("PATTERN DEF has no POS, ROW, PAT, FRAME, CIRC or PITCHCIRC: write one")

        def run() -> None:
            self.parts = parts

        return run

    def at_places(self, words: PathWords) -> Step:
        """CYCL CALL PAT: between the holes at the feed of the block, at the height of the call or at the second
        clearance ("depending on which is greater", TNC 640 Klartext, "Calling the cycle in connection with point
        tables")."""

        def run() -> None:
            if not self.parts:
                raise BlockError("no pattern is defined here: write PATTERN DEF before its call")
            rapid = self.motion.set_feed(words)
            places = [place for kind, figures in self.parts for place in self.places(kind, figures)]
            self.run(places, rapid=rapid, low=False, least=self.control.words[self.motion.state.tool_axis])

        return run

    def at_place(self, words: PathWords) -> Step:
        """CYCL CALL POS: the coordinate along the tool axis shifts the surface. Its F holds in its own block only."""
        axes = self.motion.resolved(words)

        def run() -> None:
            feed, before = self.control.feed, (self.control.feed.mode, self.control.feed.value, self.control.feed.turn)
            rapid = self.motion.set_feed(words)
            target, _ = self.motion.target(axes)
            tool_axis = self.motion.state.tool_axis
            lift = target[tool_axis] if any(axis[0] == tool_axis for axis in axes) else 0.0
            first, second = OF_AXIS[tool_axis]
            self.run([(target[first], target[second], lift)], rapid=rapid, low=False)
            feed.mode, feed.value, feed.turn = before

        return run

    def places(self, kind: str, figures: dict[str, Value]) -> list[Place]:
        """Places of one part of a pattern."""

        def figure(name: str, default: float | None = None) -> float:
            found = figures.get(name, default)
            if found is None:
                raise BlockError(f"{kind} of PATTERN DEF lacks {name}: write it")
            return evaluate(found)

        x, y = figure("X"), figure("Y")
        if kind == "POS":
            found = self.on_grid(x, y, 0.0, 0.0, 1, 1, 0.0)
        elif kind == "ROW":
            found = self.on_grid(x, y, figure("D"), 0.0, self.count(figure("NUM")), 1, figure("ROT", 0.0))
        elif kind in ("PAT", "FRAME"):
            if figure("ROTX", 0.0) or figure("ROTY", 0.0):
                self.control.refuse("ROTX ROTY of PATTERN DEF", "write the places as POS")
                return []
            counts = self.count(figure("NUMX")), self.count(figure("NUMY"))
            found = self.on_grid(
                x, y, figure("DX"), figure("DY"), *counts, figure("ROT", 0.0), border=kind == "FRAME"
            )  # fmt: skip
        else:
            holes, start = self.count(figure("NUM")), figure("START", 0.0)
            step = figure("STEP") if kind == "PITCHCIRC" else 360.0 / holes
            found = self.on_circle(x, y, figure("D"), start, step, holes)
        lift = figure("Z", 0.0) * self.motion.state.unit
        return [(u, v, lift) for u, v, _ in found]

    def run(self, places: list[Place], *, rapid: bool, low: bool, least: float = -math.inf) -> None:
        """Drill at each place; from one to the next at the height `least` [m] or higher.

        A tool that is below the clearance goes up before it goes aside ("Calling a cycle with CYCL CALL POS").
        """
        tool_axis = self.motion.state.tool_axis
        first, second = OF_AXIS[tool_axis]
        for k, (u, v, lift) in enumerate(places, start=1):
            words = list(self.control.words)
            if not rapid and len(self.control.moves):
                words[tool_axis] = max(words[tool_axis], self.holes.clearance() + lift)
                self.control.straight(list(words), 1 << tool_axis, rapid=False)
            words[first], words[second] = u, v
            if not rapid and len(self.control.moves):
                self.control.straight(words, 1 << first | 1 << second, rapid=False)
            self.holes.call(words, lift=lift, low=low, least_back=least if k < len(places) else -math.inf)
