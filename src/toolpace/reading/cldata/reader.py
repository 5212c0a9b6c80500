"""Reads cutter-location data: APT and NX CLSF."""

from __future__ import annotations

import math
from collections import Counter

import numpy as np

from toolpace.reading.arcs import Arc, ArcError, ArcTable, arc_about
from toolpace.reading.cldata.feed import ClFeed
from toolpace.reading.cldata.words import CANCELLABLE, CANCELLED_BY, ENDS, PASSED, STOPS, Statement, numbers, statements
from toolpace.reading.control.unroll import slerp
from toolpace.reading.points import assemble, unit_axes
from toolpace.reading.source import Source
from toolpace.toolpath import ToolPath
from toolpace.units import INCH, MILLIMETRE

UNITS = {"MM": MILLIMETRE, "INCHES": INCH, "INCH": INCH, "IN": INCH, "CM": 1e-2, "M": 1.0}
LONGEST_DELAY = 86400.0
"""A day [s]: a longer delay is a slip of units."""
MOST_TURNS = 1000
"""Most times that an arc is gone round: more is a slip, and would fill memory with points."""


class ClReader:
    """One reading of one program; `run` does it. Points are tips in the workpiece frame: no machine is needed."""

    def __init__(self, source: Source, *, default_feed: float | None = None) -> None:
        self.source = source
        self.unit = MILLIMETRE
        self.feed = ClFeed(source, default_feed)
        self.rapid = False
        self.tip: tuple[float, float, float] | None = None
        self.axis = (0.0, 0.0, 1.0)
        self.circle: tuple[Statement, list[float], int] | None = None
        self.frame: list[str] | None = None
        self.rows: list[tuple[float, ...]] = []
        self.stops: set[int] = set()
        self.dwells: dict[int, float] = {}
        self.arcs: dict[int, Arc] = {}
        self.skipped: Counter[str] = Counter()
        self.count = 0
        self.actions = {
            "GOTO": self._goto,
            "FROM": self._goto,
            "GODLTA": self._godlta,
            "CIRCLE": self._circle,
            "TLAXIS": self._tool_axis,
            "RAPID": self._rapid,
            "FEDRAT": self._fedrat,
            "DELAY": self._delay,
            "UNITS": self._units,
            "MSYS": self._msys,
            "ORIGIN": self._origin,
        }

    def run(self) -> ToolPath:
        """Execute every statement, then lay the points of arcs."""
        for statement in statements(self.source):
            self.count += 1
            action = self.actions.get(statement.major)
            if action is not None:
                action(statement)
            elif statement.major in ENDS:
                break
            elif statement.major in STOPS:
                self.feed.spindle(statement)
                if self.rows:
                    self.stops.add(len(self.rows) - 1)
            elif statement.major in PASSED or self._cancels(statement):
                self.skipped[statement.major] += 1
            else:
                self.source.fail(
                    f"statement {statement.major[:20]} is not known here and might move something: "
                    "remove it, or let the CAM system write GOTO points",
                    statement.line,
                )
        if self.circle is not None:
            self.source.fail(
                "CIRCLE is not followed by the GOTO to its end: the program is cut off", self.circle[0].line
            )
        return self._toolpath()

    @staticmethod
    def _cancels(statement: Statement) -> bool:
        return statement.major in CANCELLABLE and statement.minors[:1] != [] and statement.minors[0] in CANCELLED_BY

    def _goto(self, statement: Statement) -> None:
        values = numbers(self.source, statement)
        if len(values) == 6:
            self.axis = (values[3], values[4], values[5])
        elif len(values) != 3:
            self.source.fail(
                f"{statement.major} has {len(values)} numbers: it takes x, y, z, or x, y, z, i, j, k",
                statement.line,
            )
        unit = self.unit
        self._move((values[0] * unit, values[1] * unit, values[2] * unit), statement)

    def _godlta(self, statement: Statement) -> None:
        values = [value * self.unit for value in numbers(self.source, statement)]
        if self.tip is None:
            self.source.fail("GODLTA before any position: begin with GOTO or FROM", statement.line)
        if len(values) == 1:
            i, j, k = unit_axes(self.source, np.array([self.axis]), np.array([statement.line]))[0].tolist()
            values = [values[0] * i, values[0] * j, values[0] * k]
        if len(values) != 3:
            self.source.fail(
                f"GODLTA has {len(values)} numbers: it takes dx, dy, dz, or one along the axis",
                statement.line,
            )
        x, y, z = self.tip
        self._move((x + values[0], y + values[1], z + values[2]), statement)

    def _move(self, tip: tuple[float, float, float], statement: Statement) -> None:
        line = statement.line
        if self.circle is not None:
            self.arcs[len(self.rows)] = self._arc(tip)
        if statement.major == "FROM" and self.rows:
            self.source.fail("FROM names the start, but points stand before it: write GOTO", line)
        feed = math.inf if self.rapid or self.tip is None else self.feed.speed(line)
        self.rapid = False
        if max(map(abs, tip)) > 1e3:
            self.source.fail("this point is more than a kilometre away: check the numbers and UNITS", line)
        self.tip = tip
        self.rows.append((*tip, *self.axis, feed, line))

    def _circle(self, statement: Statement) -> None:
        words, turns = statement.minors, 1
        if "TIMES" in words:
            at = words.index("TIMES")
            count = numbers(self.source, statement, words[at + 1 :])
            if len(count) != 1 or count[0] != int(count[0]) or not 1 <= count[0] <= MOST_TURNS:
                self.source.fail(f"TIMES takes one whole number from 1 to {MOST_TURNS}", statement.line)
            words, turns = words[:at], int(count[0])
        values = numbers(self.source, statement, words)
        if len(values) < 7:
            self.source.fail(f"CIRCLE has {len(values)} numbers: it takes centre, direction and radius", statement.line)
        if self.tip is None:
            self.source.fail("CIRCLE before any position: begin with GOTO or FROM", statement.line)
        self.circle = (statement, values, turns)

    def _arc(self, end: tuple[float, float, float]) -> Arc:
        """Arc from the last point to `end` about the pending CIRCLE.

        Siemens' description of the CLSF record (CLSF Manager, CIRCLE) gives its direction for clockwise motion:
        clockwise for one who looks at the tip of the vector, so against the right-hand rule. TIMES,n asks for n
        turns of a helix.
        """
        assert self.circle is not None and self.tip is not None
        (statement, values, turns), self.circle = self.circle, None
        centre = [value * self.unit for value in values[:3]]
        length = math.hypot(*values[3:6])
        if abs(length - 1) > 0.02:
            self.source.fail(f"the direction of CIRCLE has length {length:.4g}, not 1: correct it", statement.line)
        try:
            arc = arc_about(self.tip, end, centre, [-value / length for value in values[3:6]], turns)
        except ArcError as error:
            self.source.fail(str(error), statement.line)
        radius = abs(values[6]) * self.unit
        if abs(arc.r0 - radius) > max(5e-5, 5e-3 * radius):
            self.source.fail(
                f"CIRCLE says radius {radius * 1e3:.6g} mm, but it starts {arc.r0 * 1e3:.6g} mm from its axis: "
                "check the centre and the radius",
                statement.line,
            )
        return arc

    def _tool_axis(self, statement: Statement) -> None:
        values = numbers(self.source, statement)
        if len(values) != 3:
            self.source.fail(f"TLAXIS has {len(values)} numbers: it takes i, j, k", statement.line)
        self.axis = (values[0], values[1], values[2])

    def _rapid(self, statement: Statement) -> None:
        self.rapid = True

    def _fedrat(self, statement: Statement) -> None:
        self.feed.set(statement, self.unit)

    def _delay(self, statement: Statement) -> None:
        seconds = self.feed.delay(statement)
        if not 0 <= seconds <= LONGEST_DELAY:
            self.source.fail("DELAY is not between 0 and a day: its number is seconds", statement.line)
        if self.rows:
            last = len(self.rows) - 1
            self.stops.add(last)
            self.dwells[last] = self.dwells.get(last, 0.0) + seconds

    def _units(self, statement: Statement) -> None:
        name = statement.minors[0] if statement.minors else ""
        if name not in UNITS:
            self.source.fail(f"UNITS/{name[:20]} is not known: use UNITS/MM or UNITS/INCHES", statement.line)
        self.unit = UNITS[name]

    def _msys(self, statement: Statement) -> None:
        # Points are written in this system; a change in the middle would shift them against each other.
        if self.rows and self.frame is not None and statement.minors != self.frame:
            self.source.fail("MSYS changes the coordinates between points: write one program a system", statement.line)
        self.frame = statement.minors
        self.skipped["MSYS"] += 1

    def _origin(self, statement: Statement) -> None:
        if any(numbers(self.source, statement)):
            self.source.fail(
                "ORIGIN shifts the points: write them in the workpiece frame, with ORIGIN/0,0,0",
                statement.line,
            )
        self.skipped["ORIGIN"] += 1

    def _toolpath(self) -> ToolPath:
        """Points of the rows; on arcs so many that chords keep within half a micrometre."""
        table = np.array(self.rows, dtype=float).reshape(len(self.rows), 8)
        line = table[:, 7].astype(np.int64)
        axis = unit_axes(self.source, table[:, 3:6], line)
        pieces = np.ones(len(table), dtype=np.int64)
        which = np.full(len(table), -1)
        for number, (row, arc) in enumerate(self.arcs.items()):
            pieces[row], which[row] = arc.pieces(), number
        move = np.repeat(np.arange(len(table)), pieces)
        piece = np.arange(len(move)) - np.repeat(np.cumsum(pieces) - pieces, pieces)
        t = (piece + 1) / pieces[move]
        tip, axes = table[move, :3], axis[move]
        inside = t < 1
        tip[inside] = ArcTable(list(self.arcs.values())).evaluate(which[move[inside]], t[inside])
        axes[inside] = slerp(axis[move[inside] - 1], axis[move[inside]], t[inside])
        stop, dwell = np.zeros(len(move), dtype=bool), np.zeros(len(move))
        last = np.cumsum(pieces) - 1
        stop[last[sorted(self.stops)]] = True
        for row, seconds in self.dwells.items():
            dwell[last[row]] = seconds
        return assemble(
            self.source,
            tip=tip,
            axis=axes,
            feed=table[move, 6],
            least_time=np.zeros(len(move)),
            block=line[move],
            stop=stop,
            dwell=dwell,
            blocks=self.count,
            skipped=dict(self.skipped),
        )
