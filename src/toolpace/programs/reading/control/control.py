"""The virtual control: moves from commands, and the tool path or the commanded moves from them.

A control language reads its blocks and calls these methods, in the order in which a controller would act. All figures
are in SI units; what letters, units and codes mean is the language's matter.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.programs.commanded import Commanded
from toolpace.programs.reading.arcs import SPIRAL, SPIRAL_SAID, Arc
from toolpace.programs.reading.control.moves import FEED, JUMP, RAPID, MoveTable, Rate
from toolpace.programs.reading.control.state import ControlState
from toolpace.programs.reading.control.unroll import Unroll
from toolpace.programs.reading.coordinates import affine
from toolpace.programs.reading.coordinates.kinematics import Poses
from toolpace.programs.reading.feeds import LONGEST_DWELL
from toolpace.programs.reading.points import NO_TOOL, ONLY_TOOL, SAME, ProgramFacts, refuse_still
from toolpace.programs.reading.source import Source
from toolpace.programs.reading.splines import Bezier, BezierTable
from toolpace.programs.toolpath import ToolPath

FARTHEST = 1e6
"""Most of an axis word [mm, inch or deg]: a kilometre is a slip, and unbounded numbers lose their digits."""


class Control(ControlState):
    """One run of one program on one machine."""

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

    def _move(self, words: list[float], named: int, rapid: bool, number: float | None, arc: Arc | None = None) -> None:
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
        self._place_stock()
        return ProgramFacts.of(
            self.findings, self.effort.blocks, tuple(self.operations.all), controller=self.controller.name
        )

    def _place_stock(self) -> None:
        """Put the stock that the program tells before it chooses a work offset into the first that it chooses."""
        workpiece, first = self.findings.workpiece, next(iter(self.findings.used.offsets), "")
        if workpiece.stock is not None and not workpiece.stock.solid.frame and first in self.options.setup.offsets:
            solid = replace(workpiece.stock.solid, frame=first)
            self.findings.workpiece = replace(workpiece, stock=replace(workpiece.stock, solid=solid))

    def _table(self) -> MoveTable:
        if not len(self.moves):
            refuse_still(self.source, 0)
        return self.moves.table()


def commanded_of(table: MoveTable, poses: Poses, source: Source, facts: ProgramFacts) -> Commanded:
    """The moves of a table; a row that moves nothing hands its stop and its dwell on to the one before.

    Raises ProgramError where nothing moves or waits.
    """
    table = _with_chords(table)
    speed, turn, time, line, kind, tip_mode, _, operation, tool_length = table.columns.T
    way = np.diff(table.position, axis=0, prepend=table.position[:1])
    way[kind == JUMP] = 0.0
    moved = np.abs(way).max(axis=1) > SAME
    moved[[0, *table.arcs]] = True
    kept = np.flatnonzero(moved)
    if len(kept) < 2 and not table.dwell.any():
        refuse_still(source, len(moved))
    # where the words change their meaning the control waits, too
    stop = np.logical_or.reduceat(table.switched | (kind == JUMP), kept)
    joining = table.joining[kept]
    blending, of_cycle = joining[:, 1], table.tolerance[kept, 0]
    if not np.isfinite(blending).any():
        # the words for blending tell no tolerance: what a cycle asks for counts (CYCLE832, cycle 32, G187)
        blending = np.where(np.isnan(of_cycle), blending, of_cycle)
    segments = _Segments(way[kept])
    for entry, row in enumerate(kept.tolist()):
        if row in table.arcs:
            segments.bend(entry, table.arcs[row])
    return Commanded(
        words=table.position[kept],
        way=way[kept],
        rotary_joints=poses.rotary_names,
        tip_mode=tip_mode[kept] > 0,
        tool_length=tool_length[kept] if poses.machine is not None else np.full(len(kept), np.nan),
        rapid=kind[kept] == RAPID,
        speed=speed[kept],
        turn=turn[kept],
        time=time[kept],
        length=segments.length,
        begin=segments.begin,
        end=segments.end,
        radius=segments.radius,
        centre=segments.centre,
        normal=segments.normal,
        sweep=segments.sweep,
        line=line[kept].astype(np.int64),
        stop=stop,
        joining=joining[:, 0].astype(np.int64),
        tolerance=blending,
        axis_tolerance=table.tolerance[kept, 1],
        cam_tolerance=joining[:, 2],
        dynamics=table.dynamics[kept],
        dwell=np.add.reduceat(table.dwell, kept),
        operation=operation[kept].astype(np.int64),
        operations=facts.operations,
        blocks=facts.blocks,
        source=source.name,
        controller=facts.controller,
    )


class _Segments:
    """Lengths and directions of X, Y, Z over moves: straight ones, until they are bent."""

    def __init__(self, way: Floats) -> None:
        count = len(way)
        self.length = np.linalg.norm(way[:, :3], axis=1)
        self.begin = way[:, :3] / np.where(self.length > SAME, self.length, np.inf)[:, None]
        self.end = self.begin.copy()
        self.radius, self.sweep = np.full(count, np.inf), np.zeros(count)
        self.centre, self.normal = np.full((count, 3), np.nan), np.zeros((count, 3))

    def bend(self, entry: int, arc: Arc) -> None:
        """Make a move an arc."""
        u, w, rise = np.array(arc.u), np.array(arc.w), np.array(arc.rise)
        angle = arc.sweep
        self.length[entry], self.radius[entry], self.sweep[entry] = arc.length(), 0.5 * (arc.r0 + arc.r1), abs(angle)
        self.centre[entry], self.normal[entry] = arc.centre, np.cross(u, w) * np.sign(angle)
        growth = arc.r1 - arc.r0
        for direction, radius, turned in ((self.begin, arc.r0, 0.0), (self.end, arc.r1, angle)):
            spoke, across = np.cos(turned) * u + np.sin(turned) * w, np.cos(turned) * w - np.sin(turned) * u
            tangent = growth * spoke + angle * radius * across + rise
            direction[entry] = tangent / np.linalg.norm(tangent)


def _with_chords(table: MoveTable) -> MoveTable:
    """The table with the straight pieces of its splines in their place."""
    if not table.curves:
        return table
    count = np.ones(len(table.position), dtype=np.int64)
    rows = np.array(list(table.curves))
    count[rows] = [min(curve.pieces(), 1000) for curve in table.curves.values()]
    of = np.repeat(np.arange(len(count)), count)
    last = np.cumsum(count) - 1
    position = table.position[of]
    curves = BezierTable(list(table.curves.values()))
    for k, row in enumerate(rows):
        inside = np.arange(last[row] - count[row] + 1, last[row])
        share = np.arange(1, count[row]) / count[row]
        position[inside, :3] = curves.evaluate(np.full(len(inside), k), share)
    columns = table.columns[of]
    columns[:, 2] /= count[of]  # a time that F gives is that of the whole
    is_last = np.zeros(len(of), dtype=bool)
    is_last[last] = True
    return MoveTable(
        position, columns, table.stop[of] & is_last, np.where(is_last, table.dwell[of], 0.0),
        {int(last[row]): arc for row, arc in table.arcs.items()}, {}, table.switched[of] & is_last,
        table.joining[of], table.tolerance[of], table.normal[of], table.dynamics[of], table.spindle[of],
    )  # fmt: skip
