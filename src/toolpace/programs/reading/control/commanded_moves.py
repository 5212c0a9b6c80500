"""Commanded moves with lengths, directions and arcs, from the motions of a program."""

from __future__ import annotations

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.programs.commanded import Commanded
from toolpace.programs.reading.control.moves import JUMP, RAPID, MoveTable
from toolpace.programs.reading.coordinates.kinematics import Poses
from toolpace.programs.reading.curves.arcs import Arc
from toolpace.programs.reading.curves.beziers import BezierTable
from toolpace.programs.reading.points import SAME, ProgramFacts, refuse_still
from toolpace.programs.reading.source import Source


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
    joining, asked = table.joining[kept], table.asked[kept, 0]
    ways = _Ways(way[kept])
    for entry, row in enumerate(kept.tolist()):
        if row in table.arcs:
            ways.bend(entry, table.arcs[row])
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
        length=ways.length,
        begin=ways.begin,
        end=ways.end,
        radius=ways.radius,
        centre=ways.centre,
        normal=ways.normal,
        sweep=ways.sweep,
        line=line[kept].astype(np.int64),
        stop=stop,
        joining=joining[:, 0].astype(np.int64),
        # what blending says goes before what a cycle asks for (CYCLE832, cycle 32)
        tolerance=np.where(np.isinf(joining[:, 1]) & ~np.isnan(asked), asked, joining[:, 1]),
        cam_tolerance=joining[:, 2],
        dynamics=table.dynamics[kept],
        dwell=np.add.reduceat(table.dwell, kept),
        operation=operation[kept].astype(np.int64),
        operations=facts.operations,
        blocks=facts.blocks,
        source=source.name,
        controller=facts.controller,
    )


class _Ways:
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
        table.joining[of], table.asked[of], table.normal[of], table.dynamics[of],
    )  # fmt: skip
