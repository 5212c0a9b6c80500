"""The virtual control: the machine's position, and moves from commands.

A control language reads its blocks and calls these methods, in the order in which a controller would act. All figures
are in SI units; what letters, units and codes mean is the language's matter.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

from toolpace.programs.commanded import Commanded
from toolpace.programs.reading.control.commanded_moves import commanded_of
from toolpace.programs.reading.control.feed import Feed, FeedRules
from toolpace.programs.reading.control.moves import FEED, JUMP, RAPID, Moves, MoveTable, Rate, Stage
from toolpace.programs.reading.control.operations import Operations
from toolpace.programs.reading.control.unroll import Unroll
from toolpace.programs.reading.controllers.controller import Controller
from toolpace.programs.reading.coordinates import affine
from toolpace.programs.reading.coordinates.active_frame import Coordinates
from toolpace.programs.reading.coordinates.affine import Matrix
from toolpace.programs.reading.coordinates.kinematics import Kinematics, Poses
from toolpace.programs.reading.coordinates.orientation import Orientation
from toolpace.programs.reading.coordinates.placement import Datum, Placement
from toolpace.programs.reading.coordinates.setup import OFFSETS_UNSAID, ZERO_UNSAID, Position
from toolpace.programs.reading.coordinates.tool_lengths import NO_SHEET, NO_TOOL, NOT_LISTED, ONLY_TOOL
from toolpace.programs.reading.curves.arcs import SPIRAL, SPIRAL_SAID, Arc
from toolpace.programs.reading.curves.beziers import Bezier
from toolpace.programs.reading.execution_limit import Effort
from toolpace.programs.reading.findings import Findings
from toolpace.programs.reading.options import ReadOptions
from toolpace.programs.reading.points import ProgramFacts, refuse_still
from toolpace.programs.reading.source import Source
from toolpace.programs.toolpath import ToolPath

LONGEST_DWELL = 86400.0
"""A day [s]: a longer dwell is a slip of units."""
TURNED = (
    "tip mode fixes X, Y, Z to the part where the table stands turned then; with tip_frame_where_switched = false in "
    "the controller's file it is where the table is at zero"
)
STILL = 1e-9
"""Rotary positions that are zero [rad]."""
ALL = 7
"""Bits of X, Y and Z."""


@dataclass(frozen=True)
class Rules:
    """What differs from controller to controller in what the machine does."""

    feed: FeedRules = field(default_factory=FeedRules)
    fixed_where_switched: bool = False
    """Whether tip mode fixes the program's frame to the workpiece where its rotary joints stand when it is switched
    on; else where they are zero."""


class Control:
    """One run of one program on one machine."""

    def __init__(
        self,
        source: Source,
        machine: Kinematics | None,
        controller: Controller,
        options: ReadOptions,
        findings: Findings,
        rules: Rules | None = None,
    ) -> None:
        self.source, self.controller, self.options, self.findings = source, controller, options, findings
        self.rules, self.setup = rules or Rules(), options.setup
        self.poses = Poses(machine)
        self.slots = self.poses.slots()
        self.datum = Datum(self.poses, self.setup)
        self.orientation = Orientation(self.poses)
        self.feed = Feed(source, self.rules.feed, options.default_feed)
        rotary = len(self.poses.rotary)
        self.moves = Moves(rotary)
        self.operations = Operations(self.moves)
        self.words = [0.0] * (3 + rotary)
        """Where the machine is, in the program's coordinates [m, rad]; zero before it is told."""
        self.named = 0
        """Bits of X, Y, Z named so far."""
        self.line = 0
        """Of the block at hand."""
        self.effort = Effort(source, options.most_blocks)
        self.stage: Stage | None = None
        """What follows the program's contour beside it, where it is not the way itself."""
        self.tool = ""
        self.coordinates = Coordinates(self.datum, (0.0,) * rotary)
        self.placement = self.coordinates.placement(self.tool)
        self.moved_in = self.placement
        """In which coordinates the last motion was."""
        if self.setup.start and machine is not None:
            self._start(self.setup.start)

    def _start(self, coordinates: Position) -> None:
        """Begin where the sheet says that the machine stands, in machine coordinates; there the path starts."""
        self.words = self.placement.words(self.datum.joints_of(coordinates, [0.0] * len(self.words)))
        self.named = sum(1 << self.slots[letter] for letter in coordinates if self.slots.get(letter, 3) < 3)
        if self.named == ALL:
            self.line = 1  # lines count from there; no block leads to the start
            self.begin_here()

    def begin_block(self, line: int) -> None:
        """Execute a block of this line next; ProgramError where there have been too many."""
        self.line = line
        self.effort.block(line, len(self.moves))

    # Where the program's coordinates are

    def _replaced(self) -> None:
        """Read the place of the machine in new coordinates: it stays where it is."""
        self.effort.changes += 1
        old, new = self.placement, self.coordinates.placement(self.tool)
        if self.coordinates.reckons and not self.setup.tools and self.poses.machine is not None:
            self.findings.assumed(NO_SHEET.format(self.datum.own_length * 1e3, self.poses.machine.name))
        if new == old:
            return
        if self.stage is not None:
            self.stage.other_motion("a change of coordinates")
        place = old.place(self.words)
        stands = place if self.stage is None else old.place(self.reached())
        another = (old.tip_mode, old.tool_length) != (new.tip_mode, new.tool_length)
        if another and self.poses.machine is not None:
            if old.tip_mode != new.tip_mode:
                self.need_linear_joints()
            place, stands = self._seen_by(new, old, place), self._seen_by(new, old, stands)
        self.words, self.placement = new.words(place), new
        if self.coordinates.tilted and new.shift and any(self.poses.carried(list(new.shift))):
            self.source.fail(
                "a tilted plane while a rotary axis of the table is shifted (by its work offset, or by the program): "
                "where controls lay the plane then depends on their parameters; set that shift to zero, and turn the "
                "part by the plane's own angles",
                self.line,
            )
        if new.tool_length != self.datum.length(self.tool):
            self.operations.tell_length(new.tool_length)
        if another and len(self.moves):
            if old.tool_length != new.tool_length:
                self.stop()  # the joints stand while another tip is reckoned with
            self.moves.add(stands, Rate(), self.line, JUMP, new.tip_mode, self.named, new.tool_length)

    def _seen_by(self, new: Placement, old: Placement, place: list[float]) -> list[float]:
        """A place of one placement as another has it: joints, or the tip of its tool."""
        place = self.poses.to_joints(place, old.tool_length) if old.tip_mode else place
        return self.poses.to_tip(place, new.tool_length) if new.tip_mode else place

    def set_offset(self, name: str) -> None:
        """Make a work offset the one in force; "" is none but its stand-in."""
        if name:
            self.findings.used.offsets.setdefault(name)
        if name and not self.setup.offsets:
            self.findings.assumed(OFFSETS_UNSAID)
        elif name and name not in self.setup.offsets:
            self.findings.assumed(f"{name} is not on the set-up sheet: the origin of the part stands for it")
        elif name and self.setup.lacks_zero and self.poses.machine is not None:
            self.findings.assumed(ZERO_UNSAID)
        self.coordinates.offset = name
        self._replaced()

    def add_offset(self, name: str) -> None:
        """A work offset that the program tells and the set-up sheet does not: it counts from the machine's zero."""
        setup = replace(self.setup, offsets={**self.setup.offsets, name: {}})
        self.setup = self.coordinates.datum.setup = setup

    def words_in(self, offset: str, frame: Matrix, turn: tuple[float, ...]) -> list[float]:
        """Words (3 + rotary) that the machine's place has in another work offset, with a frame and a rotary shift."""
        other = replace(self.coordinates, offset=offset, frame=frame, turn=turn).placement(self.tool)
        return other.words(self.placement.place(self.words))

    def set_frame(self, frame: Matrix, *, tilted: bool = False) -> None:
        """Shift and turn the program's coordinates in those of the work offset, in place of what was before.

        tilted: a plane that the tool is turned to, fixed to the part: X, Y and Z are the tip there.
        """
        ends = self.coordinates.tilted and not tilted
        self.coordinates.frame, self.coordinates.tilted = frame, tilted
        if ends and self.coordinates.tip_mode:
            self._say_where_fixed()
        self._replaced()

    def set_rotary_shift(self, turn: tuple[float, ...]) -> None:
        """Shift the rotary words [rad]."""
        self.coordinates.turn = turn
        self._replaced()

    def set_tip_mode(self, on: bool) -> None:
        """Switch tool-centre-point mode; the machine stays where it is, so that its coordinates change."""
        coordinates = self.coordinates
        if on and not coordinates.tip_mode and self.rules.fixed_where_switched:
            coordinates.fixed_at = self.placement.place(self.words)[3:]
            if not coordinates.tilted:
                self._say_where_fixed()
        if not on:
            coordinates.fixed_at = None
        coordinates.tip_mode = on
        self._replaced()

    def _say_where_fixed(self) -> None:
        """Say that tip mode began with the table turned; in a tilted plane that is no matter."""
        fixed = self.coordinates.fixed_at or []
        if fixed and any(abs(turned) > STILL for turned in self.poses.carried(fixed)):
            self.findings.assumed(TURNED)

    def set_length(self, tool: str | None, oversize: float = 0.0) -> None:
        """Reckon with the length of a tool of the table, and that much more [m]; None: with none."""
        if tool is not None:
            self._know(tool)
        coordinates = self.coordinates
        coordinates.off = tool is None and (coordinates.off or coordinates.compensated or coordinates.tip_mode)
        if tool is None and coordinates.named_for != self.tool:
            coordinates.length_of = ""  # of the tool before
        coordinates.compensated, coordinates.length_of = tool is not None, tool or coordinates.length_of
        coordinates.told, coordinates.oversize, coordinates.named_for = None, oversize, self.tool
        self._replaced()

    def set_tool_offset(self, x: float, y: float, length: float) -> None:
        """Reckon with a tool of this length [m], whose tip is x and y beside the spindle."""
        coordinates = self.coordinates
        coordinates.compensated, coordinates.told, coordinates.named_for = True, (x, y, length), self.tool
        coordinates.off = False
        self._replaced()

    def _know(self, tool: str) -> None:
        """Note that a tool is used, and that the sheet does not have it."""
        if not tool:
            return
        self.findings.used.tools.setdefault(tool)
        if self.setup.tools and self.setup.tool(tool) is None:
            self.findings.assumed(NOT_LISTED.format(tool))

    def set_position(self, words: dict[str, float]) -> None:
        """Give the place where the machine is these words: the frame is shifted (G92)."""
        wanted = list(self.words)
        for letter, value in words.items():
            wanted[self.slot(letter)] = value
        off = [a - b for a, b in zip(self.words, wanted)]
        coordinates = self.coordinates
        coordinates.turn = tuple(a + b for a, b in zip(coordinates.turn, off[3:]))
        self.set_frame(affine.product(coordinates.frame, affine.shift(off)), tilted=coordinates.tilted)

    # Motion

    def slot(self, letter: str) -> int:
        """Column of an axis letter in the words; ProgramError where the machine has no such axis."""
        found = self.slots.get(letter)
        if found is not None:
            return found
        machine = self.poses.machine
        if machine is None:
            self.source.fail(
                f"rotary word {letter} needs the machine: give --machine NAME (machine= in Python)", self.line
            )
        joints = ", ".join(self.poses.joints)
        self.source.fail(
            f"machine '{machine.name}' has no axis {letter}, its joints are {joints}: "
            "choose the machine the program was written for",
            self.line,
        )

    def straight(self, words: list[float], named: int, *, rapid: bool, number: float | None = None) -> None:
        """Move straight to words (3 + rotary).

        named: bits of X, Y, Z that the block names. number: F of the block, where feed is by inverse time.
        """
        self._move(words, named, rapid, number)

    def arc(
        self, words: list[float], named: int, arc: Arc, number: float | None = None, *, rapid: bool = False
    ) -> None:
        """Move along an arc, which is given in the program's coordinates as the words are."""
        if not len(self.moves):
            self.source.fail("an arc cannot be the first motion, its start is not known: position with G0", self.line)
        self.findings.arcs += 1
        if abs(arc.r1 - arc.r0) > SPIRAL_SAID:
            self.findings.assumed(SPIRAL)
        frame = self.placement.matrix
        if frame is not affine.IDENTITY and not affine.keeps_circle(frame, arc):
            self.source.fail(
                "an arc in coordinates that are scaled unevenly: controls cut no ellipse; scale it in the CAM system",
                self.line,
            )
        self._move(words, named, rapid, number, arc)

    def spline(self, curves: list[Bezier], named: int, number: float | None = None) -> None:
        """Move along Bezier curves that follow each other, in the program's coordinates; rotary words stay."""
        placement, turned = self.placement, self.words[3:]
        if not len(self.moves):
            self.source.fail("a spline cannot be the first motion, its start is not known: position with G0", self.line)
        if not placement.tip_mode:
            self.need_linear_joints()
        if self.stage is not None:
            self.stage.other_motion("a spline")
        lengths = [curve.length() for curve in curves]
        total = max(math.fsum(lengths), math.ulp(0.0))
        rate = self._rate([*curves[-1].points[-1], *turned], number, total)
        self.named |= named
        for curve, length in zip(curves, lengths):
            self.words = [*curve.points[-1], *turned]
            self.effort.changes += 1
            self.moves.curves[len(self.moves)] = affine.carried_curve(placement.matrix, curve)
            part = rate._replace(time=rate.time * (length / total))
            place = placement.place(self.words)
            self.moves.add(place, part, self.line, FEED, placement.tip_mode, self.named, placement.tool_length)

    def _move(
        self, words: list[float], named: int, rapid: bool, number: float | None, arc: Arc | None = None
    ) -> None:
        if not self.placement.tip_mode:
            self.need_linear_joints()
        kind = RAPID if rapid else FEED
        rate = Rate() if rapid else self._rate(words, number, None if arc is None else arc.length())
        start, self.words, self.named = self.words, words, self.named | named
        self.moved_in = self.placement
        if self.stage is not None:
            self.stage.move(start, words, arc, rate, kind)
        else:
            self.lay(words, rate, kind, arc)

    def lay(self, words: list[float], rate: Rate, kind: float, arc: Arc | None = None) -> None:
        """Note a motion to words (3 + rotary), straight or along an arc of the program's coordinates."""
        placement, moves = self.placement, self.moves
        if arc is not None:
            moves.arcs[len(moves)] = self._carried(arc)
        place = placement.place(words)
        moves.add(place, rate, self.line, kind, placement.tip_mode, self.named, placement.tool_length)

    def relay(self, row: int, words: list[float], arc: Arc | None = None) -> None:
        """End a motion that was noted elsewhere, at words (3 + rotary), along another arc where it was one."""
        place = self.placement.place(words)
        self.moves.rows[row] = (*place, *self.moves.rows[row][len(place) :])
        self.moves.arcs.pop(row, None)
        if arc is not None:
            self.moves.arcs[row] = self._carried(arc)

    def _carried(self, arc: Arc) -> Arc:
        frame = self.placement.matrix
        return arc if frame is affine.IDENTITY else affine.carried(frame, arc)

    def _rate(self, words: list[float], number: float | None, length: float | None) -> Rate:
        if self.placement.tip_mode or self.feed.rules.turning == "xyz":
            return self.feed.rate(number, self.line)
        before = self.words
        length = math.dist(words[:3], before[:3]) if length is None else length
        return self.feed.rate(number, self.line, length, math.dist(words[3:], before[3:]))

    def redirect(self, places: list[list[float]]) -> None:
        """End the last motions, which were straight, elsewhere: at words (3 + rotary) each."""
        if self.stage is not None:
            self.stage.redirect(places[-1])
        else:
            for row, words in enumerate(places, start=len(self.moves) - len(places)):
                self.relay(row, words)
        self.words = places[-1]

    def reached(self) -> list[float]:
        """Words (3 + rotary) of the place where the machine is, which a stage may have led beside the program's."""
        return self.placement.words(list(self.moves.rows[-1][: len(self.words)])) if len(self.moves) else self.words

    def begin_here(self) -> None:
        """Take the place where the machine is, as far as it is known, for the start of the path."""
        if not len(self.moves):
            self.named = ALL
            place = self.placement
            self.moves.add(place.place(self.words), Rate(), self.line, RAPID, place.tip_mode, ALL, place.tool_length)

    def need_linear_joints(self) -> None:
        """ProgramError where words are joints and the machine has no X, Y, Z."""
        machine = self.poses.machine
        if machine is not None and len(self.poses.linear) < 3:
            self.source.fail(
                f"machine '{machine.name}' lacks a joint X, Y or Z (it has {', '.join(self.poses.joints)}): "
                "switch tool-centre-point mode on (G43.4 or M428) before the first motion",
                self.line,
            )

    # All but motion

    def stop(self) -> None:
        """Come to rest."""
        self.moves.stop()

    def dwell(self, seconds: float) -> None:
        """Come to rest and wait."""
        self.check_dwell(seconds)
        if not len(self.moves):
            self.findings.ignored("dwell before the first position")
        self.moves.dwell(seconds)

    def check_dwell(self, seconds: float) -> None:
        """ProgramError where nobody waits so long."""
        if not 0 <= seconds <= LONGEST_DWELL:
            self.source.fail(f"dwell of {seconds:g} s is not between 0 and a day: check its unit", self.line)

    def change_tool(self, tool: str) -> None:
        """Take another tool; the machine stops, and stays where it is."""
        self.stop()
        if tool != self.tool and not self.coordinates.compensated:
            self.coordinates.length_of = ""
        self.tool = tool
        self._know(tool)
        self.operations.begin(tool=tool)
        self._replaced()

    def toolpath(self) -> ToolPath:
        """The points of all moves. Raises ProgramError."""
        return Unroll(self.source, self.poses, self._table()).toolpath(self._facts())

    def commanded(self) -> Commanded:
        """The moves themselves, without points between; the place where it waits of a program that only does.

        Raises ProgramError.
        """
        if not len(self.moves) and self.moves.waited > 0.0:
            self.moves.stand()
        return commanded_of(self._table(), self.poses, self.source, self._facts())

    def _facts(self) -> ProgramFacts:
        tools = self.setup.tools
        if tools and self.poses.machine is not None and not self.findings.used.tools:
            self.findings.assumed(ONLY_TOOL.format(next(iter(tools))) if len(tools) == 1 else NO_TOOL)
        return ProgramFacts.of(
            self.findings, self.effort.blocks, tuple(self.operations.all), controller=self.controller.name
        )

    def _table(self) -> MoveTable:
        if not len(self.moves):
            refuse_still(self.source, 0)
        return self.moves.table()
