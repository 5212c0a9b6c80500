"""The state of the virtual control, and the limit of executed blocks beyond which a program counts as endless."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace

from toolpace.common.errors import ProgramError
from toolpace.programs.reading.arcs import ROUNDING
from toolpace.programs.reading.control.feed import SENSES, Feed, FeedRules
from toolpace.programs.reading.control.moves import JUMP, RAPID, Moves, Operations, Rate, Stage
from toolpace.programs.reading.controllers.controller import Controller
from toolpace.programs.reading.coordinates import affine
from toolpace.programs.reading.coordinates.affine import Matrix
from toolpace.programs.reading.coordinates.kinematics import Kinematics, Orientation, Poses
from toolpace.programs.reading.coordinates.setup import OFFSETS_UNSAID, ZERO_UNSAID, Position
from toolpace.programs.reading.coordinates.work_coordinates import Coordinates, Datum, Placement
from toolpace.programs.reading.findings import Findings
from toolpace.programs.reading.options import ReadOptions
from toolpace.programs.reading.points import NO_SHEET
from toolpace.programs.reading.source import Source

REPEATED = 400_000
"""Steps beyond which a short program runs in a loop: a few seconds of reading."""
A_LINE, MOST_REPEATED = 100, 4_000_000
"""Of a longer one so many for each of its lines, and at most: subprograms are called for each part on a table."""
ONCE = 30
"""Steps that a line may take which is executed once: its block, its motions, and a change."""
CHANGED = 20
"""Steps that a change of frames, offsets or modes takes, or a spline, by the time that it needs."""
TURNED = (
    "tip mode fixes X, Y, Z to the part where the table stands turned then; with tip_frame_where_switched = false in "
    "the controller's file it is where the table is at zero"
)
ALL = 7
"""Bits of X, Y and Z."""


class EndlessError(ProgramError):
    """A program that has been executed for longer than its length explains."""


class Effort:
    """Counts blocks, and steps by the time that they take to read."""

    def __init__(self, source: Source, most_blocks: int | None) -> None:
        self.source, self.most_blocks = source, most_blocks
        self.blocks = 0
        """Blocks that were executed, those of loops and calls each time."""
        self.changes = 0
        """Of frames, offsets and modes, and splines."""
        self.lines_beside: Callable[[], int] = lambda: 0
        """Lines of the files that the program calls."""
        self.enough = _enough(len(source.lines))

    def block(self, line: int, motions: int) -> None:
        """A block more is executed, with so many motions noted before it. Raises EndlessError."""
        self.blocks += 1
        if self.most_blocks is not None:
            if self.blocks > self.most_blocks:
                self._fail(f"more than {self.most_blocks} blocks have been executed", line)
        elif self.blocks + motions + CHANGED * self.changes > self.enough:
            self.enough = _enough(len(self.source.lines) + self.lines_beside())
            if self.blocks + motions + CHANGED * self.changes > self.enough:
                self._fail(f"{self.blocks} blocks have been executed of {len(self.source.lines)} lines", line)

    def _fail(self, what: str, line: int) -> None:
        self.source.fail(f"{what}: is there a loop without end? --max-blocks N allows more", line, EndlessError)


def _enough(lines: int) -> int:
    """Steps that a program of so many lines may take."""
    return ONCE * lines + max(REPEATED, min(A_LINE * lines, MOST_REPEATED))


@dataclass(frozen=True)
class Rules:
    """What differs from controller to controller in what the machine does."""

    feed: FeedRules = field(default_factory=FeedRules)
    fixed_where_switched: bool = False
    """Whether tip mode fixes the program's frame to the workpiece where its rotary joints stand when it is switched
    on; else where they are zero."""


class ControlState:
    """Where the machine is in one run of one program, and what its words mean there."""

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
        self._take_teeth()
        self.sense: int | None = None
        """In which the spindle turns: 1 clockwise, -1 counterclockwise, 0 not at all; None: no word told it."""
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

    def refuse(self, word: str, cure: str) -> None:
        """Note a word of the block at hand that is not read, and what to write instead."""
        self.findings.refused(word, self.line, cure)

    def begin_block(self, line: int) -> None:
        """Execute a block of this line next; ProgramError where there have been too many."""
        self.line = line
        self.effort.block(line, len(self.moves))

    def _replaced(self) -> None:
        """Read the place of the machine in new coordinates: it stays where it is."""
        self.effort.changes += 1
        old, new = self.placement, self.coordinates.placement(self.tool)
        if self.coordinates.reckons and not self.setup.tells_lengths and self.poses.machine is not None:
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

    def frame_of_stock(self) -> str:
        """The work offset in force, where the set-up sheet places it; else "", the frame of the part."""
        return self.coordinates.offset if self.coordinates.offset in self.options.setup.offsets else ""

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
        if fixed and any(abs(turned) > ROUNDING for turned in self.poses.carried(fixed)):
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
        coordinates.programmed, coordinates.oversize, coordinates.named_for = None, oversize, self.tool
        self._replaced()

    def set_tool_offset(self, x: float, y: float, length: float) -> None:
        """Reckon with a tool of this length [m], whose tip is x and y beside the spindle."""
        coordinates = self.coordinates
        coordinates.compensated, coordinates.programmed, coordinates.named_for = True, (x, y, length), self.tool
        coordinates.off = False
        self._replaced()

    def _know(self, tool: str) -> None:
        """Note that a tool is used, and that the sheet does not have it."""
        if not tool:
            return
        self.findings.used.tools.setdefault(tool)
        if doubt := self.setup.length_doubt(tool):
            self.findings.assumed(doubt)

    def turn_spindle(self, speed: float | None = None, word: str = "") -> None:
        """S [1/s], or an M function by which the spindle turns; others change nothing."""
        if speed is not None:
            self.feed.spindle = speed
        self.sense = SENSES.get(word, self.sense)
        has_speed = self.feed.spindle > 0.0 or self.sense == 0
        self.moves.turn((1.0 if self.sense is None else self.sense) * self.feed.spindle if has_speed else math.nan)

    def set_position(self, words: dict[str, float]) -> None:
        """Give the place where the machine is these words: the frame is shifted (G92)."""
        wanted = list(self.words)
        for letter, value in words.items():
            wanted[self.slot(letter)] = value
        off = [a - b for a, b in zip(self.words, wanted)]
        coordinates = self.coordinates
        coordinates.turn = tuple(a + b for a, b in zip(coordinates.turn, off[3:]))
        self.set_frame(affine.product(coordinates.frame, affine.shift(off)), tilted=coordinates.tilted)

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

    def stop(self) -> None:
        """Come to rest."""
        self.moves.stop()

    def change_tool(self, tool: str) -> None:
        """Take another tool; the machine stops, and stays where it is."""
        self.stop()
        if tool != self.tool and not self.coordinates.compensated:
            self.coordinates.length_of = ""
        self.tool = tool
        self._take_teeth()
        self._know(tool)
        self.operations.begin(tool=tool)
        self._replaced()

    def _take_teeth(self) -> None:
        """Those of the tool in the spindle, for feeds per tooth."""
        figures = self.setup.figures_of(self.tool, self.findings.tool_shapes.get(self.tool))
        self.feed.teeth = None if figures is None else figures.teeth
