"""The virtual control: it knows where the machine is, and turns what a language says into moves.

A control language reads its blocks and calls these methods, in the order in which a controller would act. All figures
are in SI units; what letters, units and codes mean is the language's matter.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from toolpace.reading.arcs import Arc
from toolpace.reading.control import affine
from toolpace.reading.control.affine import Matrix
from toolpace.reading.control.feed import Feed, FeedRules
from toolpace.reading.control.kinematics import Kinematics, Poses
from toolpace.reading.control.moves import FEED, JUMP, RAPID, Moves, Rate
from toolpace.reading.control.orientation import Orientation
from toolpace.reading.control.placement import INSIDE, Datum, Placement
from toolpace.reading.control.setup import Position, SetUp
from toolpace.reading.control.unroll import Told, Unroll
from toolpace.reading.findings import Findings
from toolpace.reading.points import refuse_still
from toolpace.reading.source import Source
from toolpace.toolpath import Operation, ToolPath
from toolpace.units import MILLIMETRE

LONGEST_DWELL = 86400.0
"""A day [s]: a longer dwell is a slip of units."""
MOST_BLOCKS = 2_000_000
"""Blocks that are executed: more is taken for a loop without end."""
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
        setup: SetUp | None = None,
        *,
        findings: Findings,
        rules: Rules | None = None,
        default_feed: float | None = None,
        controller: str = "",
        most_blocks: int = MOST_BLOCKS,
    ) -> None:
        self.source, self.findings, self.rules = source, findings, rules or Rules()
        self.setup, self.controller = setup or SetUp(), controller
        self.poses = Poses(machine)
        self.slots = self.poses.slots()
        self.datum = Datum(self.poses, self.setup)
        self.orientation = Orientation(self.poses)
        self.feed = Feed(source, self.rules.feed, default_feed)
        rotary = len(self.poses.rotary)
        self.moves = Moves(rotary)
        self.words = [0.0] * (3 + rotary)
        """Where the machine is, in the program's coordinates [m, rad]; zero before it is told."""
        self.named = 0
        """Bits of X, Y, Z named so far."""
        self.line = 0
        """Of the block at hand."""
        self.blocks, self.most_blocks = 0, most_blocks
        """Blocks that were executed, those of loops and calls each time, and how many there may be."""
        self.operations: list[Operation] = [Operation()]
        self.offset = ""
        self.frame: Matrix = affine.IDENTITY
        self.turn: tuple[float, ...] = (0.0,) * rotary
        self.tip_mode, self.tilted = False, False
        self.tool, self.length_of = "", ""
        self.compensated = False
        self._fixed_at: list[float] | None = None
        self.placement = self._placement()
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
        self.blocks += 1
        if self.blocks > self.most_blocks:
            self.source.fail(
                f"more than {self.most_blocks} blocks have been executed: is there a loop without end? "
                "--max-blocks N allows more",
                line,
            )

    # Where the program's coordinates are

    def _placement(self) -> Placement:
        return self.datum.placement(
            offset=self.offset,
            frame=self.frame,
            turn=self.turn,
            tip_mode=self.tip_mode or self.tilted,
            length=self.datum.length(self.length_of or self.tool),
            compensated=self.compensated,
            fixed_at=self._fixed_at,
        )

    def _replaced(self) -> None:
        """Read the place of the machine in new coordinates: it stays where it is."""
        old, new = self.placement, self._placement()
        if new == old:
            return
        place = old.place(self.words)
        another = (old.tip_mode, old.longer) != (new.tip_mode, new.longer)
        if another and self.poses.machine is not None:
            if old.tip_mode != new.tip_mode:
                self.need_linear_joints()
            place = self.poses.to_joints(place, old.longer) if old.tip_mode else place
            place = self.poses.to_tip(place, new.longer) if new.tip_mode else place
        self.words, self.placement = new.words(place), new
        if another and len(self.moves):
            self.moves.add(place, Rate(), self.line, JUMP, new.tip_mode, self.named, new.longer)

    def set_offset(self, name: str) -> None:
        """Make a work offset the one in force; "" is none but its stand-in."""
        if name:
            self.findings.used.offsets.setdefault(name)
        if self.setup.offsets and name and name not in self.setup.offsets:
            self.findings.assumed(f"{name} is not on the set-up sheet: the origin of the part stands for it")
        self.offset = name
        self._replaced()

    def set_frame(self, frame: Matrix, *, tilted: bool = False) -> None:
        """Shift and turn the program's coordinates in those of the work offset, in place of what was before.

        tilted: a plane that the tool is turned to, fixed to the part: X, Y and Z are the tip there.
        """
        self.frame, self.tilted = frame, tilted
        self._replaced()

    def set_rotary_shift(self, turn: tuple[float, ...]) -> None:
        """Shift the rotary words [rad]."""
        self.turn = turn
        self._replaced()

    def set_tip_mode(self, on: bool) -> None:
        """Switch tool-centre-point mode; the machine stays where it is, so that its coordinates change."""
        if on and not self.tip_mode and self.rules.fixed_where_switched:
            self._fixed_at = self.placement.place(self.words)[3:]
        if not on:
            self._fixed_at = None
        self.tip_mode = on
        self._replaced()

    def set_length(self, tool: str | None) -> None:
        """Reckon with the length of a tool of the table; None: with none."""
        if tool is not None:
            self._know(tool)
        self.compensated, self.length_of = tool is not None, tool or self.length_of
        self._replaced()

    def _know(self, tool: str) -> None:
        """Note that a tool is used, and that the sheet does not have it."""
        if not tool:
            return
        self.findings.used.tools.setdefault(tool)
        if self.setup.tools and self.setup.tool(tool) is None:
            self.findings.assumed(f"tool {tool} is not on the set-up sheet: it is as long as the machine's own")

    def set_position(self, words: dict[str, float]) -> None:
        """Give the place where the machine is these words: the frame is shifted (G92)."""
        wanted = list(self.words)
        for letter, value in words.items():
            wanted[self.slot(letter)] = value
        off = [a - b for a, b in zip(self.words, wanted)]
        self.turn = tuple(a + b for a, b in zip(self.turn, off[3:]))
        self.set_frame(affine.product(self.frame, affine.shift(off)), tilted=self.tilted)

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
        frame = self.placement.matrix
        length = arc.length()
        if frame is not affine.IDENTITY:
            arc = _framed(arc, frame)
        self.moves.arcs[len(self.moves)] = arc
        self._move(words, named, rapid, number, length)

    def _move(
        self, words: list[float], named: int, rapid: bool, number: float | None, length: float | None = None
    ) -> None:
        placement = self.placement
        if not placement.tip_mode:
            self.need_linear_joints()
        rate = Rate() if rapid else self._rate(words, number, length)
        self.words, self.named = words, self.named | named
        kind = RAPID if rapid else FEED
        self.moves.add(placement.place(words), rate, self.line, kind, placement.tip_mode, self.named, placement.longer)

    def _rate(self, words: list[float], number: float | None, length: float | None) -> Rate:
        if self.placement.tip_mode or self.feed.rules.turning == "xyz":
            return self.feed.rate(number, self.line)
        before = self.words
        length = math.dist(words[:3], before[:3]) if length is None else length
        return self.feed.rate(number, self.line, length, math.dist(words[3:], before[3:]))

    def shorten(self, words: list[float]) -> None:
        """End the last motion, which was straight, at words (3 + rotary) that lie on its way."""
        place = self.placement.place(words)
        last = self.moves.rows[-1]
        self.moves.rows[-1] = (*place, *last[len(place) :])
        self.words = words

    def begin_here(self) -> None:
        """Take the place where the machine is, as far as it is known, for the start of the path."""
        if not len(self.moves):
            self.named = ALL
            place = self.placement
            self.moves.add(place.place(self.words), Rate(), self.line, RAPID, place.tip_mode, ALL, place.longer)

    def straight_in_machine(self, coordinates: dict[str, float], *, rapid: bool = True) -> None:
        """Move to machine coordinates by axis letter [m, rad], without offsets, frames and tool length.

        Without a set-up sheet machine coordinates are stand-ins: what lies beyond travel ends at its end.
        """
        if self.poses.machine is None or not coordinates:
            self.findings.assumed("without a machine, moves in machine coordinates are passed over")
            return
        self.findings.used.machine_zero = True
        self.need_linear_joints()
        place = self.placement.place(self.words)
        if self.placement.tip_mode:
            place = self.poses.to_joints(place, self.placement.longer)
        for letter in coordinates:
            self.slot(letter)
        wanted = self._within_travel(self.datum.joints_of(coordinates, place), coordinates)
        named = sum(1 << self.slots[letter] for letter in coordinates if self.slots[letter] < 3)
        rate = Rate() if rapid else self.feed.rate(None, self.line)
        kind = RAPID if rapid else FEED
        self.named |= named
        self.moves.add(wanted, rate, self.line, kind, False, self.named)
        if self.placement.tip_mode:
            wanted = self.poses.to_tip(wanted, self.placement.longer)
            self.moves.add(wanted, Rate(), self.line, JUMP, True, self.named, self.placement.longer)
        self.words = self.placement.words(wanted)

    def _within_travel(self, joints: list[float], coordinates: dict[str, float]) -> list[float]:
        machine = self.poses.machine
        assert machine is not None
        if self.setup.machine_zero or self.setup.references:
            return joints
        self.findings.assumed(
            "machine coordinates and reference points count from the upper ends of the travel of X, Y and Z, 1 mm "
            "inside (--setup FILE tells others)"
        )
        columns = [*self.poses.linear, *self.poses.rotary]
        for letter in coordinates:
            slot = self.slots[letter]
            low, high = (float(end) for end in machine.travel[columns[slot]])
            if not low <= joints[slot] <= high:
                self.findings.assumed(f"machine coordinates of {letter} beyond its travel end at the end of travel")
            inside = min(INSIDE, 0.5 * (high - low)) if slot < 3 else 0.0
            joints[slot] = min(max(joints[slot], low + inside), high - inside)
        return joints

    def reference(self, number: int, letters: list[str]) -> None:
        """Go to a reference point with the axes of these letters, at rapid; all axes where there is none."""
        self.findings.used.references.setdefault(number)
        wanted = self.datum.reference(number)
        self.straight_in_machine({letter: wanted[letter] for letter in letters or wanted if letter in wanted})
        self.stop()

    def need_linear_joints(self) -> None:
        """ProgramError where words are joints and the machine has no X, Y, Z."""
        machine = self.poses.machine
        if machine is not None and len(self.poses.linear) < 3:
            self.source.fail(
                f"machine '{machine.name}' lacks a joint X, Y or Z (it has {', '.join(self.poses.joints)}): "
                "switch tool-centre-point mode on (G43.4 or M428) before the first motion",
                self.line,
            )

    # The tool axis

    def rotary_for(self, axis: list[float], sign: int = 0) -> list[float]:
        """Rotary words that bring the tool to an axis (3,) on the part, the nearest to where the machine is.

        sign: of the two solutions the one with the second rotary joint below (-1) or above (1) zero; 0: either.
        Raises ProgramError.
        """
        present = self.placement.place(self.words)[3:]
        wanted, fault = self.orientation.rotary(axis, present, sign)
        if fault:
            self.source.fail(fault, self.line)
        shift = self.placement.shift or (0.0,) * len(wanted)
        return [a - b for a, b in zip(wanted, shift)]

    def plane_axis(self) -> list[float]:
        """The direction (3,) on the part that the tool has when it stands upright on the plane of the frame."""
        return self.direction_on_part((0.0, 0.0, 1.0))

    def direction_on_part(self, direction: affine.Vector) -> list[float]:
        """A direction (3,) of the program's coordinates as a unit vector on the part; zero stays zero."""
        found = affine.direct(self._placement_of_tip().matrix, direction)
        length = math.hypot(*found) or 1.0
        return [value / length for value in found]

    def _placement_of_tip(self) -> Placement:
        return self.placement if self.placement.tip_mode else self.datum.placement(
            offset=self.offset, frame=self.frame, turn=self.turn, tip_mode=True, length=self.datum.own_length,
            compensated=True, fixed_at=None,
        )  # fmt: skip

    def turn_to_plane(self, *, follow: bool = False, rapid: bool = True, sign: int = 0) -> None:
        """Turn the rotary joints until the tool stands upright on the plane of the frame.

        follow: the tip keeps its place on the part; else the linear joints keep theirs.
        """
        wanted = self.rotary_for(self.plane_axis(), sign)
        if follow:
            self.straight([*self.words[:3], *wanted], 0, rapid=rapid)
        else:
            self.turn_joints(wanted, rapid=rapid)

    def turn_joints(self, wanted: list[float], *, rapid: bool) -> None:
        """Turn the rotary joints to words (rotary) [rad]; the linear joints stay, also where words are the tip."""
        place = self.placement.place(self.words)
        joints = self.poses.to_joints(place, self.placement.longer) if self.placement.tip_mode else place
        shift = self.placement.shift or (0.0,) * len(wanted)
        joints = [*joints[:3], *(a + b for a, b in zip(wanted, shift))]
        rate = Rate() if rapid else self.feed.rate(None, self.line)
        self.moves.add(joints, rate, self.line, RAPID if rapid else FEED, False, self.named)
        if self.placement.tip_mode:
            joints = self.poses.to_tip(joints, self.placement.longer)
            self.moves.add(joints, Rate(), self.line, JUMP, True, self.named, self.placement.longer)
        self.words = self.placement.words(joints)

    # All but motion

    def stop(self) -> None:
        """Come to rest."""
        self.moves.stop()

    def dwell(self, seconds: float) -> None:
        """Come to rest and wait."""
        if not 0 <= seconds <= LONGEST_DWELL:
            self.source.fail(f"dwell of {seconds:g} s is not between 0 and a day: check its unit", self.line)
        if not len(self.moves):
            self.findings.ignored("dwell before the first position")
        self.moves.dwell(seconds)

    def change_tool(self, tool: str) -> None:
        """Take another tool; the machine stops, and stays where it is."""
        self.stop()
        self.tool = tool
        self._know(tool)
        self._begin(Operation(self.operations[-1].name, tool))
        self._replaced()

    def begin_operation(self, name: str) -> None:
        """Begin a part of the program that has a name of its own."""
        self._begin(Operation(name.strip(), self.operations[-1].tool))

    def _begin(self, operation: Operation) -> None:
        last = self.moves.rows[-1][-2] if self.moves.rows else -1
        if last < self.moves.operation:
            self.operations.pop()  # nothing moved in it
        self.operations.append(operation)
        self.moves.operation = len(self.operations) - 1

    def tolerance(self, said: str) -> None:
        """A tolerance that the program asks for: told, not obeyed."""
        self.findings.ignored(said)

    def toolpath(self) -> ToolPath:
        """The points of all moves. Raises ProgramError."""
        if not len(self.moves):
            refuse_still(self.source, 0)
        told = Told(dict(self.findings.skipped), tuple(self.operations), self.controller, self.findings.assumptions)
        return Unroll(self.source, self.poses, self.moves.table()).toolpath(self.blocks, told)


def _framed(arc: Arc, frame: Matrix) -> Arc:
    """The arc in the coordinates that the frame stands in; its radii grow where the frame scales."""
    u, w = affine.direct(frame, arc.u), affine.direct(frame, arc.w)
    grown = max(math.hypot(*u), math.hypot(*w))
    if abs(grown - 1.0) < 1e-9:
        grown = 1.0
    return Arc(
        affine.apply(frame, arc.centre),
        (u[0] / grown, u[1] / grown, u[2] / grown),
        (w[0] / grown, w[1] / grown, w[2] / grown),
        arc.r0 * grown,
        arc.r1 * grown,
        arc.sweep,
        affine.direct(frame, arc.rise),
    )


def upright(axis: list[float]) -> bool:
    """Whether a direction is +z."""
    return abs(axis[0]) < MILLIMETRE * 1e-6 and abs(axis[1]) < MILLIMETRE * 1e-6 and axis[2] > 0.0
