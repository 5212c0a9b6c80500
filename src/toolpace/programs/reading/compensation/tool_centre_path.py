"""The way of a tool's centre beside a contour, from approach to departure."""

from __future__ import annotations

import cmath
import math
from dataclasses import replace
from typing import NoReturn

from toolpace.programs.reading.arcs import ROUNDING, Arc
from toolpace.programs.reading.compensation.corners import ROUNDED, TANGENT, Corners, Followed, between, gone, offset
from toolpace.programs.reading.compensation.elements import (
    Element,
    Line,
    Turn,
    is_behind,
    turning,
    turning_away,
    unit,
)
from toolpace.programs.reading.compensation.stage import AROUND, TOUCHING, Laid, Leaving, OffsetStage, Rules
from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.control.moves import FEED, Rate

ACROSS_ALONE = "across the plane, which is not read where a block without a motion shifts the tool: move it elsewhere"
BEGINS_STRAIGHT = "compensation begins with a straight motion, and this is an arc: write a line before it"
BESIDE = (
    "the tool's centre goes {:.6g} mm beside the contour, the radius on the set-up sheet: where the program is the "
    "centre's path and the control holds wear alone, give --compensation program"
)

STAYS = "behind the end of a compensation the tool's centre stays beside the contour until a block moves in its plane"



class Follower(Corners):
    """The stage between the words that begin and end a compensation."""

    def __init__(self, control: Control, side: int, radius: float, plane: int, rules: Rules) -> None:
        super().__init__(control, side, radius, plane, rules)
        self.at = self.begun = self.point(control.reached())
        self.speed = Rate(), FEED
        """Rate and kind of the last element."""
        self.entering: Line | None = None
        """The motion that leads to the contour, until the contour is there."""
        self.paused = False
        """Whether the program has stopped since then."""
        self.leads_across = False
        """Whether a line leads across the contour to where the next element begins."""
        if rules.assumed:
            control.findings.assumed(rules.assumed)

    def move(self, start: list[float], end: list[float], arc: Arc | None, rate: Rate, kind: float) -> None:
        """A motion of the program between words (3 + rotary). Raises ProgramError."""
        if start[3:] != end[3:]:
            self.fail("a rotary axis turns under cutter compensation, which is not read: let the CAM system compensate")
        if rate.time:
            self.fail("a time of a block (G93) under cutter compensation is not read: write a feed a minute")
        path = self.element(start, end, arc)
        if path is None or (arc is None and abs(path.end - path.start) < ROUNDING):
            if self.leads_across and self.rules.shifts:
                self.fail(f"a motion {ACROSS_ALONE}")
            self.waiting.append(self.add(self.at, start, end, None, rate, kind))
            self.idle += self.last is not None or self.entering is not None
        elif self.last is None and self.entering is None and not self.leads_across:
            self._enter(path, start, end, rate, kind)
        else:
            self._follow(path, start, end, rate, kind)

    def redirect(self, end: list[float]) -> None:
        """The last element, a line, ends earlier: its corner was cut or rounded by the program."""
        point = self.point(end)
        if self.entering is not None:
            self.entering = replace(self.entering, end=point)
            self._shift_ends(point)
        elif self.last is not None:
            element = replace(self.last.element, end=point)
            way = self._way(element)
            self.last = replace(self.last, element=element, way=way)
            self._shift_ends(way.end)

    def other_motion(self, what: str) -> None:
        """ProgramError: what it does to the offset is not sure."""
        self.fail(f"{what} under cutter compensation is not read: end the compensation before it")

    def pause(self) -> None:
        """The contour ends here, or the program. Raises ProgramError where its last element was a gouge."""
        last, was_paused, self.paused = self.last, self.paused, True
        if last is None or was_paused:
            return
        if gone(last.way, last.begins, last.way.end) < -ROUNDED:
            self.refuse_gouge()
        self.see(between(last.way, last.begins, last.way.end))

    def behind_block(self, moved: bool) -> None:
        """A block of the program has ended, with or without a motion."""
        begun = self.last is not None or self.entering is not None
        if not moved:
            self.idle += begun
            self.leads_across = self.leads_across or (self.rules.shifts and not begun)
        elif not begun and self.rules.shifts and not self.leads_across:
            self.fail(f"compensation begins beside a motion {ACROSS_ALONE}")

    def resume(self, at: complex) -> None:
        """Compensation goes on behind a suppression, from a point of the plane."""
        self.at, self.last, self.waiting, self.leads_across = at, None, [], True
        self.idle, self.paused = 0, False

    # The ends of the contour

    def begin_across(self, along: complex) -> None:
        """The centre stands across the beginning of the contour, at the program's point, and goes along there."""
        corner = self.point(self.control.words)
        self.entering = Line(corner - along, corner)

    def _enter(self, path: Element, start: list[float], end: list[float], rate: Rate, kind: float) -> None:
        if not isinstance(path, Line):
            self.fail(BEGINS_STRAIGHT)
        self.entering, self.paused = path, False
        begun = self.at
        self.wait(self.add(path.end, start, end, Line(begun, path.end), rate, kind), begun)

    def _arrive(
        self, entering: Line, path: Element, way: Element, start: list[float], words: list[float], rate: Rate,
        kind: float,
    ) -> None:  # fmt: skip
        """Go from the line that enters to where the first element begins."""
        corner = path.start
        turned = -self.side * turning(entering.begins, path.begins)
        if self.rules.ends == TOUCHING and is_behind(self.begun, corner, path.begins, self.side):
            along = self.touching(corner - self.begun, 1)
            line = Line(self.begun, corner + self.radius * 1j * self.side * along)
            came = Followed(Line(corner - along, corner), line, self.begun)
            self.go_round(came, path, way, turning_away(along, path.begins, self.side), start, words, rate, kind)
        elif self.rules.ends == AROUND and turned > TANGENT:
            self.round_in_lines(Followed(entering, entering, self.begun), path, way, start, words, rate, kind)
        else:
            self.finish(way.start)

    def touching(self, way: complex, sense: int) -> complex:
        """Direction of the line that touches the circle about a contour's end, by the way to it (sense 1) or from (-1).

        Raises ProgramError where that is shorter than the radius.
        """
        if abs(way) <= self.radius:
            self.fail("the place beside the contour lies within the tool's radius of its end: go farther away")
        return unit(way) * cmath.exp(1j * sense * self.side * math.asin(self.radius / abs(way)))

    # Corners

    def _follow(self, path: Element, start: list[float], end: list[float], rate: Rate, kind: float) -> None:
        if self.idle > self.rules.most_idle:
            self.fail(
                f"{self.idle} blocks before this one move nothing in the plane of the compensation, and the control "
                f"looks over {self.rules.most_idle} of them: write them elsewhere"
            )
        if self.paused:
            self.fail("M0 or M1 stands before this element, and the control does not look over it: move it elsewhere")
        way = self._way(path)
        words = self.at_corner(start, end)
        if self.entering is not None:
            self._arrive(self.entering, path, way, start, words, rate, kind)
            self.entering = None
        elif self.leads_across:
            if self.rules.shifts and not isinstance(path, Line):
                self.fail(BEGINS_STRAIGHT)
            self.lines([way.start], start, words, rate, kind)
            self.leads_across = False
        else:
            assert self.last is not None
            self.corner(self.last, path, way, start, words, rate, kind)
        begun = self.at
        laid = self.add(way.end, start, end, between(way, begun, way.end), self._rate(path, rate), kind)
        self.wait(laid, begun)
        self.last, self.idle, self.speed = Followed(path, way, begun), 0, (rate, kind)

    def _way(self, path: Element) -> Element:
        found = offset(path, self.side * self.radius)
        if found is None:
            assert isinstance(path, Turn)
            self.fail(
                f"the tool of radius {self.radius * 1e3:.6g} mm does not fit into this arc of radius "
                f"{path.radius * 1e3:.6g} mm, and {self.rules.gouge}: take a smaller tool, or write a larger arc"
            )
        return found

    def trimmed(self, laid: Laid, end: complex) -> Element | None:
        """The motion that waits, to another end."""
        if laid.path is None:
            return None
        if isinstance(laid.path, Line) or self.last is None:
            return Line(self.begun, end)
        return between(self.last.way, self.begun, end)

    def _shift_ends(self, end: complex) -> None:
        """Move the ends of what waits, and let it wait on."""
        waiting = self.waiting
        self.move_end(end)
        self.waiting = waiting

    def _rate(self, path: Element, rate: Rate) -> Rate:
        """Speed of the centre on an element."""
        return rate._replace(speed=rate.speed * self.rules.share_of_feed(path, self.side, self.radius))


def follow(control: Control, side: int, radius: float, plane: int, rules: Rules) -> None:
    """Follow the contour from now on. Raises ProgramError where it is not read.

    side: 1 left of it, -1 right. radius: of the tool [m]. plane: 0 XY, 1 ZX, 2 YZ.
    """

    def fail(message: str) -> NoReturn:
        control.source.fail(message, control.line)

    if not len(control.moves):
        fail("compensation begins before the program has gone to a place: position with G0 before it")
    if control.placement.tip_mode and not control.coordinates.tilted:
        fail("cutter compensation in tool-centre-point mode is not read: let the CAM system compensate")
    if is_scaled(control):
        fail("cutter compensation in scaled coordinates is not read: let the CAM system apply the scale")
    control.findings.assumed(BESIDE.format(radius * 1e3))
    control.stage = Follower(control, side, radius, plane, rules)


def is_scaled(control: Control) -> bool:
    """Whether a length of the program is another one on the part, where the tool's radius is what it is."""
    matrix = control.placement.matrix
    return any(abs(math.hypot(*(row[k] for row in matrix)) - 1.0) > ROUNDING for k in range(3))


def leave(follower: Follower) -> None:
    """The word that ends the compensation. Raises ProgramError."""
    if follower.last is None and follower.entering is not None:
        follower.fail("the compensation ends before it has followed a contour: take its words out")
    follower.pause()
    follower.control.stage = None if follower.last is None else Departing(follower)


def leave_here(follower: Follower) -> None:
    """End the compensation across the contour's end; the program goes on from where the centre is.

    Raises ProgramError.
    """
    leave(follower)
    follower.control.stage, follower.control.words = None, follower.control.reached()


class Departing(Leaving):
    """Leaves a contour: across its end, or round the corner to the way that leads away."""

    def __init__(self, follower: Follower) -> None:
        super().__init__(follower)
        self.follower, self.moves = follower, len(follower.control.moves)
        self.is_new = True
        """Whether the block of the word that ends it goes on."""

    def behind_block(self, moved: bool) -> None:
        """A block has ended: where it is that of the word, and moved nothing, the tool may be shifted back."""
        is_new, self.is_new = self.is_new, False
        if not (is_new and self.follower.rules.shifts):
            return
        if moved:
            self.follower.fail(f"compensation ends beside a motion {ACROSS_ALONE}")
        self.control.stage = None
        self.control.lay(self.control.words, *self.follower.speed)

    def move(self, start: list[float], end: list[float], arc: Arc | None, rate: Rate, kind: float) -> None:
        """The first straight motion in the plane leads away. Raises ProgramError."""
        follower, last = self.follower, self.follower.last
        path = follower.element(start, end, arc)
        if path is None:
            self.control.findings.assumed(STAYS)
        elif isinstance(path, Line) and last is not None:
            self._lead_away(last, path, start, end, rate, kind)
        super().move(start, end, arc, rate, kind)

    def _lead_away(
        self, last: Followed, path: Line, start: list[float], end: list[float], rate: Rate, kind: float
    ) -> None:
        """To where the way away begins, where that is not across the contour's end."""
        follower, corner, side = self.follower, path.start, self.follower.side
        words, rules = follower.at_corner(start, end), follower.rules
        turned = -side * turning(last.element.ends, path.begins)
        if rules.ends == TOUCHING and is_behind(path.end, corner, last.element.ends, side):
            self._need_no_motion()
            along = follower.touching(path.end - corner, -1)
            line = Line(corner + follower.radius * 1j * side * along, path.end)
            turned = turning_away(last.element.ends, along, side)
            follower.go_round(last, Line(corner, corner + along), line, turned, start, words, rate, kind)
        elif rules.ends == AROUND and turned > TANGENT:
            self._need_no_motion()
            follower.round_in_lines(last, path, path, start, words, rate, kind)

    def _need_no_motion(self) -> None:
        if len(self.control.moves) != self.moves:
            self.stage.fail(
                "motions stand between the end of the compensation and the way that leads away, which goes round the "
                "contour's end: write that way first"
            )


class Suppressed(OffsetStage):
    """The stage between CUTCONON and CUTCONOF of a Sinumerik.

    "They are displaced, however, by the vector from the end point of the last compensated block to its offset point",
    and behind it "a linear block is inserted" to where the next element begins (Programming Guide Advanced, 04.00,
    8.4, "Maintain tool radius compensation at constant level").
    """

    def __init__(self, follower: Follower) -> None:
        """Raises ProgramError where the contour has no element yet, or its last one was a gouge."""
        if follower.last is None:
            follower.fail("CUTCONON stands before the first element of the contour: write it behind that")
        follower.pause()
        super().__init__(follower.control, follower.side, follower.radius, follower.plane)
        self.follower, self.at = follower, follower.at
        self.shift = follower.last.way.end - follower.last.element.end

    def move(self, start: list[float], end: list[float], arc: Arc | None, rate: Rate, kind: float) -> None:
        """A motion of the program between words (3 + rotary), shifted. Raises ProgramError."""
        path = self.follower.element(start, end, arc)
        goal = self.point(end) + self.shift
        shifted: Line | Turn | None = None
        if isinstance(path, Turn):
            shifted = Turn(self.at, goal, path.centre + self.shift, path.sweep)
        self.add(goal, start, end, shifted, rate, kind)

    def redirect(self, end: list[float]) -> None:
        """Corners of lines. Raises ProgramError."""
        self.fail("a rounded corner under CUTCONON is not read: write the corner out")

    def other_motion(self, what: str) -> NoReturn:
        """ProgramError."""
        self.fail(f"{what} under CUTCONON is not read: write CUTCONOF, and end the compensation before it")

    def pause(self) -> None:
        """Nothing waits."""

    def resume(self) -> None:
        """The next element is compensated, and a line leads to where it begins."""
        self.follower.resume(self.at)
        self.control.stage = self.follower
