"""Compensation by the rules of LinuxCNC's interpreter.

Facts from its manual, "Cutter Compensation", and from the motions of the interpreter itself (`rs274` of version 2.9):
where the two differ, or the manual says nothing, the interpreter moves the machine. It knows one element back, lets a
corner of up to 0.05 rad be none, and refuses a trimmed line that would go backwards, or a trimmed arc that would
sweep more than the program's, but at the end of an element alone where the next corner is an inside one or a line's.
"""

from __future__ import annotations

import cmath
import math

from toolpace.common.units import MILLIMETRE, MINUTE
from toolpace.programs.reading.arcs import Arc
from toolpace.programs.reading.compensation.elements import Line, Turn, unit
from toolpace.programs.reading.compensation.stage import Laid, Leaving, OffsetStage, as_speed
from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.control.moves import RAPID, Rate

NO_CORNER = 0.05
"""Angle up to which two elements go straight on [rad]."""
RIGHT_ANGLE = 1e-4
"""Cosine below which the chord of an entry arc stands across its radius."""
SAME_TO_PLANNER = 1e-6
"""Ends of an arc so close [m] that it may be a whole turn, or nothing."""
SLOWEST = 0.1 / MINUTE
"""Speed that a block under G93 does not go below, in lengths of the program a second."""
IN_MACHINE = "a motion in machine coordinates"
GOUGES = "the tool does not fit into the inside corner before this block: take a smaller tool, or round the corner"


class LinuxcncStage(OffsetStage):
    """The stage between G41 or G42 and G40."""

    def __init__(self, control: Control, side: int, radius: float, plane: int, unit_of_length: float) -> None:
        """unit_of_length: of the program [m]; tolerances are in it."""
        super().__init__(control, side, radius, plane)
        self.unit = unit_of_length
        self.entered = False
        """Whether the first element was there."""
        self.aside = 0j
        """Unit vector from the program's point to the centre."""
        self.start_is_known = False
        """Whether the interpreter remembers where the motions that wait begin: only then does it look for gouges."""

    def move(self, start: list[float], end: list[float], arc: Arc | None, rate: Rate, kind: float) -> None:
        """A motion of the program between words (3 + rotary). Raises ProgramError."""
        rate = as_speed(rate, start, end, arc, SLOWEST * self.unit)
        path = self.element(start, end, arc)
        if not self.entered:
            self._enter(start, end, path, rate, kind)
        elif path is None:
            self.waiting.append(self.add(self.at, start, end, None, rate, kind))
        else:
            self._follow(path, start, end, rate, kind)

    def redirect(self, end: list[float]) -> None:
        """Not asked for: the language has no corners that are written behind their lines."""
        self.fail("a rounded corner under cutter compensation is not read: write the corner out")

    def other_motion(self, what: str) -> None:
        """ProgramError: the interpreter refuses it."""
        self.fail(f"{what} under cutter compensation: write G40 before it")

    def pause(self) -> None:
        """M0, M1, M60, and the end of the program: what waits is settled."""
        self._settle(self.at)
        self.start_is_known = False

    def leave(self) -> None:
        """G40: the next straight motion goes from the centre's place to its own end."""
        if self.entered:
            self._settle(self.at)
        self.control.stage = LeavingLinuxcnc(self) if self.entered else None

    # The first element

    def _enter(self, start: list[float], end: list[float], path: Line | Turn | None, rate: Rate, kind: float) -> None:
        goal = self.point(end)
        if abs(goal - self.at) <= self.radius:
            self.fail(
                f"the first motion behind G41 or G42 has {abs(goal - self.at) * 1e3:.6g} mm in the plane, and must be "
                f"longer than the tool's radius of {self.radius * 1e3:.6g} mm: begin farther away"
            )
        self.entered = True
        assert path is not None
        if isinstance(path, Turn):
            self._check_fit(path, abs(path.start - path.centre))
            self._lay_main(self._entry_arc(path), start, end, rate, kind)
            self.waiting[-1].sweep = 0.0  # its own sweep is not looked at
            self.aside = self._aside(path.ends)
            return
        self.aside = self._aside(path.begins)
        line = Line(self.at, goal + self.radius * self.aside)
        self._lay_main(line, start, end, rate, kind)
        self.start_is_known = True
        # it asks whether the trimmed entry still leads to the side of the tool
        self.waiting[-1].along = self.aside

    def _entry_arc(self, path: Turn) -> Turn:
        """From where the tool is to the offset end, about a centre on the program's last spoke."""
        end = path.end + self.radius * self._aside(path.ends)
        inward = unit(path.centre - end)
        chord = self.at - end
        cosine = (unit(chord) * inward.conjugate()).real
        if abs(cosine) < RIGHT_ANGLE:
            self.fail("no entry arc leads from here to the end of this block: begin elsewhere, or enter by a line")
        return Turn(self.at, end, end + inward * abs(chord) / 2.0 / cosine, path.sweep).between(self.at, end)

    # Later elements

    def _follow(self, path: Line | Turn, start: list[float], end: list[float], rate: Rate, kind: float) -> None:
        corner, aside = path.start, self._aside(path.begins)
        outside = self._outside(path)
        before = self.waiting[0].path if self.waiting else None
        if isinstance(path, Turn):
            self._check_fit(path, path.radius)
        if self._is_inside(outside, path, before):
            if not self.waiting:
                self.fail("M0 or M1 stands before an inside corner, and the interpreter gouges it: move it elsewhere")
            self._settle(self._meeting(outside, path, before))
        elif outside > NO_CORNER:
            if isinstance(path, Line):
                self._settle(self.at)
            self._round(corner, corner + self.radius * aside, start, end, rate, kind)
        else:
            self.waiting = []
        offset = path.end + self.radius * self._aside(path.ends)
        way = self._arc_way(path, offset) if isinstance(path, Turn) else Line(self.at, offset)
        self._lay_main(way, start, end, rate, kind)
        laid = self.waiting[-1]
        laid.along, laid.sweep = path.ends, path.sweep if isinstance(path, Turn) else 0.0
        self.aside, self.start_is_known = self._aside(path.ends), True

    def _arc_way(self, path: Turn, offset: complex) -> Turn:
        way = path.between(self.at, offset)
        if abs(abs(path.sweep) - abs(way.sweep)) > math.pi and abs(offset - self.at) < SAME_TO_PLANNER:
            self.fail("the tool's way along this circle closes but for a rounding: write it as two arcs")
        return way

    def _lay_main(self, way: Line | Turn, start: list[float], end: list[float], rate: Rate, kind: float) -> None:
        begun = self.at
        self.wait(self.add(way.end, start, end, way, rate, kind), begun)

    def _aside(self, direction: complex) -> complex:
        return 1j * self.side * direction

    def _outside(self, path: Line | Turn) -> float:
        """Turn of the corner away from the tool [rad], from -90 to 270 degrees: below zero it is an inside one."""
        ended = self.aside / (1j * self.side)
        turned = -self.side * cmath.phase(path.begins * ended.conjugate())
        return turned + 2.0 * math.pi if turned < -math.pi / 2.0 else turned

    def _is_inside(self, outside: float, path: Line | Turn, before: Line | Turn | None) -> bool:
        if outside < -NO_CORNER or outside > math.pi + NO_CORNER:
            return True
        if isinstance(path, Turn):  # a turn on the spot before an arc that the tool goes round
            return abs(outside - math.pi) < NO_CORNER and not path.holds(self.side)
        return outside > math.pi - NO_CORNER and isinstance(before, Turn) and not before.holds(self.side)

    def _round(
        self, corner: complex, to: complex, start: list[float], end: list[float], rate: Rate, kind: float
    ) -> None:
        """Go about an outside corner, at the height before the block; a rapid goes straight."""
        self.waiting = []
        words = list(end)
        normal = 3 - self.first - self.second
        words[normal] = start[normal]
        way: Line | Turn = Line(self.at, to)
        if kind != RAPID:
            way = Turn(self.at, to, corner, -self.side * 1.0).between(self.at, to)
        self.add(to, start, words, way, rate, kind)

    def _check_fit(self, path: Turn, radius: float) -> None:
        if path.holds(self.side) and radius <= self.radius:
            self.fail(
                f"the tool of radius {self.radius * 1e3:.6g} mm does not fit into this arc of radius "
                f"{radius * 1e3:.6g} mm: take a smaller one, or write a larger arc"
            )

    # Inside corners

    def _meeting(self, outside: float, path: Line | Turn, before: Line | Turn | None) -> complex:
        """Where the centre's ways before and behind an inside corner meet. Raises ProgramError."""
        if isinstance(path, Line):
            if isinstance(before, Turn):
                return self._arc_and_line(path, before)
            back = self.radius / math.tan((outside + math.pi) / 2.0)
            return self.at - back * self.aside / (1j * self.side)
        if isinstance(before, Turn):
            return self._arc_and_arc(path, before)
        return self._line_and_arc(outside, path)

    def _share(self, value: float) -> float:
        if not -1.0 <= value <= 1.0:
            self.fail(GOUGES)
        return value

    def _arc_and_line(self, path: Line, before: Turn) -> complex:
        held = before.holds(self.side)
        across = path.begins * 1j * before.sense
        full = before.radius + (self.radius if held else -self.radius)
        far = full * (across * unit(before.centre - path.start).conjugate()).real
        share = self._share((far - self.radius if held else far + self.radius) / before.radius)
        sense = -1.0 if held == (before.sense > 0) else 1.0
        return before.centre - before.radius * across * cmath.exp(1j * sense * math.acos(share))

    def _line_and_arc(self, outside: float, path: Turn) -> complex:
        held = path.holds(self.side)
        along = self.aside / (1j * self.side)
        reach = path.radius - self.radius if held else path.radius + self.radius
        height = -path.radius * math.cos(outside)
        share = self._share((height + self.radius if held else height - self.radius) / reach)
        turned = path.sense * math.asin(share)
        spoke = cmath.exp(1j * turned) if held else -cmath.exp(-1j * turned)
        return path.centre + reach * along * spoke

    def _arc_and_arc(self, path: Turn, before: Turn) -> complex:
        reach = path.radius - self.radius if path.holds(self.side) else path.radius + self.radius
        apart = path.centre - before.centre
        if not before.radius or not abs(apart):
            self.fail("two arcs about one centre meet in a corner that the tool cannot follow: write one arc")
        share = (before.radius**2 + abs(apart) ** 2 - reach**2) / (2.0 * before.radius * abs(apart))
        turned = math.acos(self._share(share)) * path.sense
        turned = turned if before.holds(self.side) else -turned
        return before.centre + before.radius * unit(apart) * cmath.exp(1j * turned)

    # Ends of motions

    def _settle(self, end: complex) -> None:
        """Move the ends of the motions that wait. Raises ProgramError where one would gouge."""
        for laid in self.waiting:
            self._check(laid, end)
        self.move_end(end)

    def _check(self, laid: Laid, end: complex) -> None:
        if isinstance(laid.path, Turn):
            centre = laid.path.centre
            if abs(abs(end - centre) - laid.path.radius) > 0.01 * self.unit:
                self.fail(GOUGES)
            sweep = laid.path.between(self.begun, end).sweep
            slack = 0.0254 if self.unit == MILLIMETRE else 0.001
            if laid.sweep and self.start_is_known and abs(sweep) > abs(laid.sweep) + slack:
                self.fail(GOUGES)
        elif self.start_is_known and (laid.along.conjugate() * (end - self.begun)).real < 0.0:
            self.fail(GOUGES)


class Uncompensated(OffsetStage):
    """G41 or G42 with a radius of zero: the contour is the way, and what compensation forbids is forbidden."""

    def move(self, start: list[float], end: list[float], arc: Arc | None, rate: Rate, kind: float) -> None:
        """Laid as it is."""
        self.at = self.point(end)
        self.control.lay(end, rate, kind, arc)

    def redirect(self, end: list[float]) -> None:
        """Not asked for: the language has no corners that are written behind their lines."""

    def other_motion(self, what: str) -> None:
        """ProgramError, but for machine coordinates, which the interpreter refuses with a radius alone."""
        if what != IN_MACHINE:
            self.fail(f"{what} under cutter compensation: write G40 before it")

    def pause(self) -> None:
        """Nothing waits."""

    def leave(self) -> None:
        """G40."""
        self.control.stage = None


class LeavingLinuxcnc(Leaving):
    """The interpreter takes the program's point for the machine's from G40 on: each straight motion goes there."""

    def __init__(self, stage: LinuxcncStage) -> None:
        super().__init__(stage)
        self.unit = stage.unit

    def ask_machine(self) -> None:
        """A change of the tool: the interpreter asks where the machine is, and goes on from there."""
        self.control.words = self.control.reached()

    @property
    def kept(self) -> list[float]:
        """Words of the program's own point."""
        return self.control.words

    def move(self, start: list[float], end: list[float], arc: Arc | None, rate: Rate, kind: float) -> None:
        """A straight motion ends the stage. Raises ProgramError."""
        if arc is not None:
            self.stage.fail(self.cure)
        self.control.stage = None
        self.control.lay(end, as_speed(rate, start, end, arc, SLOWEST * self.unit), kind)
