"""Drilling cycles of cutter-location data, and the moves that they make of a GOTO."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

from toolpace.common.units import INCH
from toolpace.programs.reading.cldata.state import PER_MINUTE, PER_REVOLUTION, ClFeed, Feed
from toolpace.programs.reading.cldata.track import RAPID, Point, Track
from toolpace.programs.reading.cldata.words import CANCELLED_BY, NUMBER, Statement, numbers
from toolpace.programs.reading.control.cycles import MOST_PECKS
from toolpace.programs.reading.findings import Findings
from toolpace.programs.reading.source import Source

GAP = 0.01 * INCH
"""How far a peck steps back, or stays off the last one, where the program leaves it to the control [m].

LinuxCNC's is 0.010 inch (G73, G83).
"""
TYPES = frozenset(("DRILL", "DEEP", "DEEP2", "BRKCHP", "FACE", "TAP", "BORE", "REAM", "CSINK", "CBORE", "DRAG"))
VALUES = frozenset(
    ("RAPTO", "FEDTO", "RTRCTO", "STEP", "DWELL", "DEPTH", "CLEAR", "RETURN", "BACK", "REV", "TIMES", "AUTO")
) | {"1STPECK", "SUBPECK"}
SAID = frozenset(("OPTION", "CAM", "TIMES"))
"""Words of which nothing follows for the motion, as far as is known."""
CURE = "write RAPTO and FEDTO (or DEPTH and CLEAR) of a plain cycle, or let the CAM system write GOTO points"
CURE_OF_PLACES = f"what its numbers mean is set in the post-processor: {CURE}"
MOST_STEPS = 2_000_000
"""Most moves that the cycles of a program make: more is a slip of a number, and would fill memory."""


class Step(NamedTuple):
    """A straight way along the tool axis."""

    height: float
    """Over the point of the hole [m]."""
    feeds: bool = False
    """At the feed of the cycle; else a rapid."""
    dwells: bool = False
    stops: bool = False


@dataclass(frozen=True)
class Cycle:
    """What is done at each point between CYCLE and CYCLE/OFF; heights over the point along the tool axis [m]."""

    clear: float
    """Where the hole is come to and left."""
    start: float
    """Where the feed begins."""
    bottom: float
    retract: float
    """Where the tool is left after it; never below `start`."""
    feed: Feed | None
    """None: FEDRAT's."""
    pecks: tuple[float, ...] = ()
    """Depths of the pecks [m], the last for all that follow; empty: one way down."""
    breaks_chips: bool = False
    """Pecks step back by `back`, else to `start`."""
    back: float = GAP
    feeds_out: bool = False
    stops: bool = False
    """Whether the motion comes to rest at the bottom: the spindle turns back."""
    dwell: float | None = None
    """Wait at the bottom [s], or in revolutions."""
    dwell_revolutions: bool = False
    dwells_at_pecks: bool = False
    returns_to_plane: bool = False
    """Whether it is left at the height from which the first hole was come to, where that is higher."""

    def steps(self, plane: float) -> Iterator[Step]:
        """Steps of a hole; `plane` is the height of the tip before the cycle."""
        retract = max(self.retract, plane) if self.returns_to_plane else self.retract
        yield Step(max(self.clear, retract))
        yield Step(self.start)
        for depth in self._peck_ends():
            yield Step(depth, feeds=True, dwells=self.dwells_at_pecks)
            if self.breaks_chips:
                yield Step(min(self.start, depth + self.back))
            else:
                yield Step(self.start)
                yield Step(min(self.start, depth + GAP))
        yield Step(self.bottom, feeds=True, dwells=True, stops=self.stops)
        if self.feeds_out:
            yield Step(self.start, feeds=True)
        yield Step(retract)

    def _peck_ends(self) -> Iterator[float]:
        """Ends of all pecks but the last, which is the bottom."""
        depth = self.start
        for number in range(MOST_PECKS):
            peck = self.pecks[min(number, len(self.pecks) - 1)] if self.pecks else 0.0
            depth -= peck
            if peck <= 0.0 or depth <= self.bottom + 1e-9:
                return
            yield depth


class CycleReader:
    """Reads CYCLE in the forms of NX, of Creo and with fixed places; what is not known is refused."""

    def __init__(self, source: Source, feed: ClFeed, findings: Findings) -> None:
        self.source, self.feed, self.findings = source, feed, findings
        self.depths = False
        """Whether FEDTO is how deep a hole is, above zero; else where it ends, below zero."""

    def begin(self) -> None:
        """CYCLE/INIT, which SolidWorks CAM writes before each cycle: its FEDTO is a depth."""
        self.depths = True
        self.findings.assumed("FEDTO of CYCLE is the depth of the hole, as CYCLE/INIT of SolidWorks CAM has it")

    def read(self, statement: Statement, unit: float) -> Cycle | None:
        """The cycle of a statement such as CYCLE/DRILL,RAPTO,3,FEDTO,-10,MMPM,250; None where it is refused."""
        groups = _grouped(statement)
        if not groups:
            self._refuse(statement, "")
            return None
        allowed = TYPES | VALUES | SAID | PER_MINUTE.keys() | PER_REVOLUTION.keys()
        strange = next((word for word in groups if word not in allowed), None)
        if strange is not None or statement.minors[0] not in TYPES:
            self._refuse(statement, strange or statement.minors[0])
            return None
        for word, words in groups.items():
            if word in SAID:
                self.findings.assumed(f"{word} of CYCLE is taken to move nothing")
            if word in VALUES - {"DWELL", "AUTO", "RTRCTO"} and len(words) != 1 and not (word == "STEP" and words):
                self.source.fail(f"{word} of CYCLE takes one number: write it like {word},5", statement.line)
        lengths = {
            word: [value * unit for value in numbers(self.source, statement, words)] for word, words in groups.items()
        }
        kind = statement.minors[0]
        # A number after the type is a place, or the diameter of a countersink, of which the depth would follow.
        worded = not any(lengths[word] for word in TYPES.intersection(groups))
        if worded and "FEDTO" in groups and "RAPTO" in groups:
            cycle = self._of_nx(lengths)
        elif worded and "DEPTH" in groups and "CLEAR" in groups:
            cycle = self._of_creo(lengths)
        else:
            found = self._of_places(kind, lengths)
            if found is None:
                self._refuse(statement, kind, CURE if worded else CURE_OF_PLACES)
                return None
            cycle = found
        cycle = self._with_manner(replace(cycle, feed=self._feed(groups, statement, unit)), groups, lengths)
        if not any(cycle.pecks) and ("DEEP" in groups or "BRKCHP" in groups):
            self.findings.assumed("CYCLE with DEEP or BRKCHP but no STEP is taken to go down in one way")
        self._check(cycle, statement)
        return cycle

    def _of_nx(self, groups: dict[str, list[float]]) -> Cycle:
        start, bottom = groups["RAPTO"][0], -groups["FEDTO"][0] if self.depths else groups["FEDTO"][0]
        if bottom == 0.0:
            self.findings.assumed("CYCLE with FEDTO,0 has no depth: it feeds to the point itself")
        retract = max(groups["RTRCTO"][0], start) if groups.get("RTRCTO") else start
        return Cycle(max(start, retract), start, bottom, retract, None)

    def _of_creo(self, groups: dict[str, list[float]]) -> Cycle:
        clear, down = groups["CLEAR"][0], groups["RAPTO"][0] if "RAPTO" in groups else 0.0
        to_plane = "RETURN" in groups and groups["RETURN"][0] == 0.0
        if to_plane:
            self.findings.assumed("CYCLE with RETURN,0 goes back to the height from which the first hole was come to")
        retract = groups["RETURN"][0] if "RETURN" in groups and not to_plane else clear
        start = clear - down
        return Cycle(clear, start, -groups["DEPTH"][0], max(retract, start), None, returns_to_plane=to_plane)

    def _of_places(self, kind: str, groups: dict[str, list[float]]) -> Cycle | None:
        """CYCLE/type,z,f,unit,r; with threads per inch before r in TAP, an increment after it in DEEP and BRKCHP."""
        units = [word for word in groups if word in PER_MINUTE or word in PER_REVOLUTION]
        after = groups[units[0]] if len(units) == 1 else []
        if len(groups) != 2 or kind == "CSINK" or len(groups[kind]) != 2:
            return None
        if len(after) != (2 if kind in ("TAP", "DEEP", "BRKCHP") else 1):
            return None
        self.findings.assumed(
            "CYCLE without keywords is read as depth, feed, unit, (threads per inch,) rapid height (, increment)"
        )
        start = after[1] if kind == "TAP" else after[0]
        pecks = (after[1],) if kind in ("DEEP", "BRKCHP") else ()
        return Cycle(start, start, -groups[kind][0], start, None, pecks=pecks)

    def _with_manner(self, cycle: Cycle, groups: dict[str, list[str]], lengths: dict[str, list[float]]) -> Cycle:
        """Pecks, waits and the way out."""
        feeds_out = bool({"TAP", "BORE", "REAM"} & groups.keys()) and "DRAG" not in groups
        if feeds_out and "TAP" not in groups:
            self.findings.assumed("CYCLE with BORE or REAM is taken to feed out as it feeds in")
        pecks = tuple(lengths["STEP"]) if "STEP" in groups else cycle.pecks
        if "DEEP2" in groups:
            pecks = tuple(depth for word in ("1STPECK", "SUBPECK") for depth in lengths.get(word, ()))
        elif "DEEP" not in groups and "BRKCHP" not in groups:
            pecks = ()
        if any(pecks) and ("DEEP" in groups or "DEEP2" in groups or "BACK" not in groups):
            self.findings.assumed("pecks of CYCLE step back by, or stay off the last one by, 0.254 mm")
        wait = groups.get("DWELL") or groups.get("REV")
        return replace(
            cycle,
            feeds_out=feeds_out,
            stops="TAP" in groups,
            pecks=pecks,
            breaks_chips="BRKCHP" in groups,
            back=lengths["BACK"][0] if "BACK" in groups else GAP,
            dwell=float(wait[0].replace("D", "E")) if wait else None,
            dwell_revolutions="REV" in groups,
            dwells_at_pecks="BRKCHP" in groups and "BACK" not in groups,
        )

    def _feed(self, groups: dict[str, list[str]], statement: Statement, unit: float) -> Feed | None:
        for word, words in groups.items():
            if word in PER_MINUTE or word in PER_REVOLUTION:
                values = numbers(self.source, statement, groups[statement.minors[0]] or words)
                # With fixed places the feed stands before its unit, as the second number.
                place = 1 if groups[statement.minors[0]] else 0
                if len(values) <= place:
                    self.source.fail(f"{word} of CYCLE takes a number: write it like {word},250", statement.line)
                return self.feed.of(values[place], word, unit, statement)
        return None

    def _check(self, cycle: Cycle, statement: Statement) -> None:
        if cycle.bottom > cycle.start:
            self.source.fail(
                f"CYCLE feeds from {cycle.start * 1e3:.6g} mm to {cycle.bottom * 1e3:.6g} mm over the point, "
                "which is up: FEDTO is negative below the point, DEPTH positive",
                statement.line,
            )
        if min(cycle.pecks, default=0.0) < 0 or cycle.back < 0:
            self.source.fail("STEP and BACK of CYCLE must not be negative: correct them", statement.line)
        depth, last = cycle.start - cycle.bottom, cycle.pecks[-1] if cycle.pecks else 0.0
        if last > 0 and depth / last > MOST_PECKS:
            self.source.fail(f"a hole takes more than {MOST_PECKS} pecks: correct STEP", statement.line)

    def _refuse(self, statement: Statement, word: str, cure: str = CURE) -> None:
        self.findings.refused(f"CYCLE/{word[:20]}", statement.line, cure)


def _grouped(statement: Statement) -> dict[str, list[str]]:
    """Words of the statement, each with the numbers after it."""
    groups: dict[str, list[str]] = {}
    words: list[str] = []
    for minor in statement.minors:
        if NUMBER.fullmatch(minor):
            words.append(minor)
        else:
            words = groups[minor] = []
    return groups


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
