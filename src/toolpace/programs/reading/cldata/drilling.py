"""The active CYCLE, and the moves that it makes of a GOTO."""

from __future__ import annotations

import math

from toolpace.programs.reading.cldata.cycles import Cycle, CycleReader, Step
from toolpace.programs.reading.cldata.feed import ClFeed
from toolpace.programs.reading.cldata.meanings import CANCELLED_BY
from toolpace.programs.reading.cldata.track import RAPID, Point, Track
from toolpace.programs.reading.cldata.words import Statement
from toolpace.programs.reading.findings import Findings
from toolpace.programs.reading.source import Source

MOST_STEPS = 2_000_000
"""Most moves that the cycles of a program make: more is a slip of a number, and would fill memory."""


class Drilling:
    """The cycle between CYCLE/.. and CYCLE/OFF: each GOTO is a hole in it."""

    def __init__(self, source: Source, track: Track, feed: ClFeed, findings: Findings) -> None:
        self.source, self.track, self.feed, self.findings = source, track, feed, findings
        self._reader = CycleReader(source, feed, findings)
        self.active = False
        self._cycle: Cycle | None = None
        """The last cycle; None where it was refused, or there was none."""
        self._line = 0
        self._plane: Point | None = None
        """The tip before the cycle."""
        self._plan: tuple[Step, ...] | None = None
        """Steps of each hole, where they are the same at all."""
        self._steps = 0

    def cycle(self, statement: Statement, unit: float) -> None:
        """Begin a cycle, take the last one again (CYCLE/ON), or end it (CYCLE/OFF)."""
        first = statement.minors[0] if statement.minors else ""
        if first in CANCELLED_BY:
            if not self.active:
                self.findings.ignored("CYCLE")
            self.active = False
            return
        if first == "INIT":
            self._reader.begin()
            return
        if first != "ON":
            self._cycle = self._reader.read(statement, unit)
        elif self._cycle is None:
            self.findings.refused("CYCLE/ON", statement.line, "no cycle stands before it: write the cycle")
        self.active, self._line, self._plane = True, statement.line, self.track.tip
        self._plan = None

    def end(self) -> None:
        """The operation is over, and its cycle with it."""
        if self.active:
            self.findings.assumed("a CYCLE without CYCLE/OFF ends with its operation")
        self.active = False

    def hole(self, point: Point, line: int) -> None:
        """The moves at a point: along its tool axis, rapids between holes at the height where they are left."""
        axis, cycle = self.track.unit_axis(line), self._cycle
        if cycle is None:
            # It was refused: who goes on all the same sees the places come to.
            self.track.move(point, line, RAPID)
            return
        cut = self.feed.caps(line, cycle.feed)
        x, y, z = point
        i, j, k = axis
        steps = self._steps_at(cycle, point, axis)
        for height, feeds, dwells, stops in steps:
            self.track.move((x + height * i, y + height * j, z + height * k), line, cut if feeds else RAPID)
            if stops:
                self.track.stop()
            if dwells and cycle.dwell:
                self.track.stop(self.feed.seconds(cycle.dwell, cycle.dwell_revolutions, "CYCLE", self._line))
        self._steps += len(steps)
        if self._steps > MOST_STEPS:
            self.source.fail(f"cycles make more than {MOST_STEPS} moves up to here: correct STEP", line)

    def _steps_at(self, cycle: Cycle, point: Point, axis: Point) -> tuple[Step, ...]:
        if cycle.returns_to_plane and self._plane is not None:
            return tuple(cycle.steps(sum((self._plane[i] - point[i]) * axis[i] for i in range(3))))
        if self._plan is None:
            self._plan = tuple(cycle.steps(-math.inf))
        return self._plan
