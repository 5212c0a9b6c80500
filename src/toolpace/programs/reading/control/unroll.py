"""Points along the motions of a program, dense enough for straight moves between them.

Two things are curved in the workpiece frame although the program's words move in proportion: the tool axis
while rotary joints turn, and the tip while they turn with tool-centre-point mode off. Their curvature is not
known beforehand, nor simply that of splines with weights, so the pieces are measured, against the chord and the
great circle at three places inside, and cut into more until all agree; the gap falls with the square of their number.
"""

from __future__ import annotations

import numpy as np

from toolpace.common.arrays import Bools, Floats, Ints
from toolpace.programs.reading.arcs import Arc, ArcTable
from toolpace.programs.reading.control.moves import FEED, JUMP, RAPID, MoveTable
from toolpace.programs.reading.coordinates.kinematics import Poses
from toolpace.programs.reading.points import SAME, ProgramFacts, ProgramPoints, assemble, programmed_lengths
from toolpace.programs.reading.source import Source
from toolpace.programs.reading.splines import Bezier, BezierTable
from toolpace.programs.toolpath import ToolPath

TIP_GAP = 0.45e-6
"""Most distance of the tip from the chords [m]; a tenth below the promised half micrometre."""
AXIS_GAP = 0.9e-4
"""Most angle between the tool axis and the great circle [rad]; a tenth below the promised 1e-4."""
FIRST_TURN = np.deg2rad(5.0)
"""Most rotation of a piece before measuring [rad], so that three places inside see the whole of it."""
MOST_PIECES_OF_BLOCK = 1_000_000
MOST_PIECES = 4_000_000
"""Most points of one block, and of a program: what asks for more would fill memory before it is planned."""
CHUNK = 100_000
"""ProgramPoints that are measured at a time, to keep memory low."""
INSIDE = np.array([0.25, 0.5, 0.75])
"""Shares of a piece at which it is measured against chord and great circle."""


class Unroll:
    """The motions of a table as functions of a fraction from 0 to 1 of each."""

    def __init__(self, source: Source, poses: Poses, table: MoveTable) -> None:
        self.source, self.poses = source, poses
        self.end = table.position
        self.start = np.vstack([self.end[:1], self.end[:-1]])
        self.speed, self.turn, self.time, line, kind, tip_mode, _, operation, self.tool_length = table.columns.T
        jump = kind == JUMP
        self.start[jump] = self.end[jump]
        self.is_feed = kind == FEED
        self.line: Ints = line.astype(np.int64)
        self.operation: Ints = operation.astype(np.int64)
        self.is_rapid = kind == RAPID
        self.tip_mode: Bools = tip_mode > 0
        self.stop, self.dwell, self.tolerance = table.stop, table.dwell, table.tolerance
        self.normal, self.spindle = table.normal, table.spindle
        self.arcs = ArcTable(list(table.arcs.values()))
        self.arc = np.full(len(self.end), -1)
        self.arc[list(table.arcs)] = np.arange(len(table.arcs))
        self.rotation = np.linalg.norm((self.end - self.start)[:, 3:], axis=1)
        self.length = np.linalg.norm((self.end - self.start)[:, :3], axis=1)
        self.pieces = np.ones(len(self.end), dtype=np.int64)
        self.curves = BezierTable(list(table.curves.values()))
        self.curve = np.full(len(self.end), -1)
        self.curve[list(table.curves)] = np.arange(len(table.curves))
        curved: list[tuple[int, Arc | Bezier]] = [*table.arcs.items(), *table.curves.items()]
        for row, way in curved:
            self.length[row] = way.length()
            self.pieces[row] = way.pieces()

    def evaluate(self, move: Ints, t: Floats) -> tuple[Floats, Floats, Floats]:
        """Tip, tool axis and rotary joints at fractions t (k,) of moves (k,)."""
        position = self.end[move]
        inside = np.flatnonzero(t < 1)
        of, share = move[inside], t[inside]
        position[inside] = self.start[of] + share[:, None] * (self.end[of] - self.start[of])
        curved = self.arc[of] >= 0
        position[inside[curved], :3] = self.arcs.evaluate(self.arc[of[curved]], share[curved])
        curved = self.curve[of] >= 0
        position[inside[curved], :3] = self.curves.evaluate(self.curve[of[curved]], share[curved])
        tip, axis = self.poses.place(position, self.tip_mode[move], self.tool_length[move])
        return tip, axis, position[:, 3:]

    def refine(self) -> None:
        """Choose how many pieces each move needs."""
        turning = self.rotation > SAME
        turned = np.ceil(self.rotation / FIRST_TURN)
        self._refuse_endless(turned)
        self.pieces = np.where(turning, np.maximum(self.pieces, turned.astype(np.int64)), self.pieces)
        self._refuse_endless(self.pieces)
        todo = np.flatnonzero((turning & (self.poses.machine is not None)) | (self.curve >= 0))
        for _ in range(8):
            if not len(todo):
                break
            excess = self._excess(todo)
            todo, excess = todo[excess > 1], excess[excess > 1]
            wanted = self.pieces.astype(float)
            wanted[todo] = np.maximum(np.ceil(wanted[todo] * np.sqrt(1.1 * excess)), wanted[todo] + 1)
            self._refuse_endless(wanted)
            self.pieces = wanted.astype(np.int64)

    def _excess(self, moves: Ints) -> Floats:
        """Largest gap of each move over what is allowed, as a ratio."""
        tip, axis = self._gaps(moves).T
        starts = np.concatenate([[0], np.cumsum(self.pieces[moves])[:-1]])
        return np.asarray(np.maximum.reduceat(np.maximum(tip / TIP_GAP, axis / AXIS_GAP), starts))

    def _gaps(self, moves: Ints) -> Floats:
        """(k, 2) most distance of the tip from the chord [m] and of the axis from the great circle [rad], each piece
        of the moves."""
        pieces, found, first = np.cumsum(self.pieces[moves]), [np.zeros((0, 2))], 0
        while first < len(moves):
            done = pieces[first - 1] if first else 0
            last = max(first + 1, int(np.searchsorted(pieces, done + CHUNK, side="right")))
            found.append(self._gaps_at_once(moves[first:last]))
            first = last
        return np.concatenate(found)

    def _gaps_at_once(self, moves: Ints) -> Floats:
        move, piece, count = _pieces_of(moves, self.pieces[moves])
        tip0, axis0, _ = self.evaluate(move, piece / count)
        tip1, axis1, _ = self.evaluate(move, (piece + 1) / count)
        worst = np.zeros((len(move), 2))
        for inside in INSIDE:
            tip, axis, _ = self.evaluate(move, (piece + inside) / count)
            gap = np.linalg.norm(tip - tip0 - inside * (tip1 - tip0), axis=1)
            turn = np.linalg.norm(axis - slerp(axis0, axis1, float(inside)), axis=1)
            worst = np.maximum(worst, np.stack([gap, turn], axis=1))
        return worst

    def bows(self, move: Ints) -> Floats:
        """(n,) how far the tip leaves the chord of each piece [m]; `move` (n,) is that of each piece of all moves."""
        turning = (self.rotation > SAME) & ~self.tip_mode & (self.poses.machine is not None)
        curved = (self.arc >= 0) | (self.curve >= 0) | turning
        bow = np.zeros(len(move))
        gap = self._gaps(np.flatnonzero(curved))[:, 0]
        bow[curved[move]] = np.where(gap > SAME, gap, 0.0)
        return bow

    def _refuse_endless(self, pieces: Floats | Ints) -> None:
        worst = int(np.argmax(pieces))
        if not pieces[worst] <= MOST_PIECES_OF_BLOCK or not pieces.sum() <= MOST_PIECES:
            self.source.fail(
                f"this block turns {np.rad2deg(self.rotation[worst]):.6g} deg over "
                f"{self.length[worst] * 1e3:.6g} mm of way and would take {float(pieces[worst]):.3g} points "
                f"(at most {MOST_PIECES_OF_BLOCK} a block, {MOST_PIECES} in all): "
                "check its numbers, or split the program",
                int(self.line[worst]),
            )

    def normals(self, move: Ints, t: Floats) -> Floats:
        """(k, 3) unit vectors out of the part at fractions t (k,) of moves: from that at the start to that at the end,
        where the program tells one there; that at the end alone where it does not."""
        end, start = self.normal[move], self.normal[np.maximum(move - 1, 0)]
        start = np.where(np.isnan(start), end, start)
        between = start + t[:, None] * (end - start)
        length = np.linalg.norm(between, axis=1)[:, None]
        return np.asarray(np.where(length > SAME, between / np.maximum(length, SAME), end))

    def caps(self) -> tuple[Floats, Floats]:
        """Feed [m/s] and least time [s] of each move, from what F means in its mode."""
        travels = self.length > SAME
        turns = self.rotation > SAME
        # The speed word speaks of the joints X, Y, Z outside tip mode: no cap on the tip, but a time.
        by_time = self.is_feed & travels & turns & ~self.tip_mode
        in_place = self.is_feed & ~travels & turns
        timed = self.is_feed & (self.time > 0)
        least_time = np.zeros(len(self.end))
        least_time[by_time] = (self.length / self.speed)[by_time]
        least_time[in_place] = (self.rotation / self.turn)[in_place]
        least_time[timed] = self.time[timed]
        feed = np.where(self.is_feed & ~by_time & ~in_place & ~timed, self.speed, np.inf)
        return feed, least_time

    def toolpath(self, facts: ProgramFacts) -> ToolPath:
        """The points of all moves; inserted ones share the block number and the least time of their block."""
        self.refine()
        move, piece, count = _pieces_of(np.arange(len(self.end)), self.pieces)
        tip, axis, rotary = self.evaluate(move, (piece + 1) / count)
        feed, least_time = self.caps()
        ends = piece + 1 == count
        points = ProgramPoints(
            tip,
            axis,
            feed=feed[move],
            least_time=least_time[move] / count,
            block=self.line[move],
            stop=self.stop[move] & ends,
            dwell=np.where(ends, self.dwell[move], 0.0),
            rapid=self.is_rapid[move],
            operation=self.operation[move],
            tolerance=self.tolerance[move],
            normal=self.normals(move, (piece + 1) / count),
            rotary=None if self.poses.machine is None else rotary,
            rotary_joints=self.poses.rotary_names,
            tool_length=programmed_lengths(self.tool_length[move], self.poses.machine),
            bow=self.bows(move),
            spindle=self.spindle[move],
        )
        return assemble(self.source, points, facts)


def slerp(a: Floats, b: Floats, t: float | Floats) -> Floats:
    """Unit vectors at fraction t from a to b (n, 3) along the great circle (Shoemake 1985, slerp)."""
    angle = 2 * np.arcsin(np.clip(np.linalg.norm(b - a, axis=1) / 2, 0, 1))
    small = angle < 1e-9
    sine = np.where(small, 1.0, np.sin(angle))
    first = np.where(small, 1 - t, np.sin((1 - t) * angle) / sine)
    second = np.where(small, t, np.sin(t * angle) / sine)
    return np.asarray(first[:, None] * a + second[:, None] * b)


def _pieces_of(moves: Ints, pieces: Ints) -> tuple[Ints, Ints, Ints]:
    """For every piece of the moves: its move, its number from 0, and how many pieces its move has."""
    total = np.repeat(pieces, pieces)
    first = np.repeat(np.cumsum(pieces) - pieces, pieces)
    return np.repeat(moves, pieces), np.arange(len(total)) - first, total
