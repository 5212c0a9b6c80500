"""The points of cutter-location data while they are read, and the tool path from them."""

from __future__ import annotations

import math

import numpy as np

from toolpace.common.arrays import Floats, Ints
from toolpace.programs.reading.arcs import SAG, Arc, ArcTable
from toolpace.programs.reading.cldata.state import Caps
from toolpace.programs.reading.control.unroll import slerp
from toolpace.programs.reading.points import FARTHEST, ProgramFacts, ProgramPoints, ToolLengths, assemble, unit_axes
from toolpace.programs.reading.source import Source
from toolpace.programs.reading.splines import Spline
from toolpace.programs.toolpath import Operation, ToolPath

MOST_POINTS = 50_000_000
"""Most points of curves: more is a slip of numbers, and would fill memory."""

RAPID = None
"""In place of the caps of a motion."""
_FREE = Caps(math.inf)

Point = tuple[float, float, float]


class Track:
    """Tip and axis as they stand, the points that were reached, and the operation that they belong to."""

    def __init__(self, source: Source) -> None:
        self.source = source
        self.tip: Point | None = None
        self.axis: Point = (0.0, 0.0, 1.0)
        self._unit_of = (self.axis, self.axis)
        """An axis as it was written, and at length 1."""
        self.spindle = math.nan
        """Turns of the spindle per second [1/s], signed by its sense; nan where nothing tells them."""
        self._rows: list[tuple[float, ...]] = []
        self._stops: set[int] = set()
        self._dwells: dict[int, float] = {}
        self._arcs: dict[int, Arc] = {}
        self._splines: dict[int, Spline] = {}
        self._operations: list[Operation] = []
        self._next: Operation | None = Operation()
        """The operation that begins with the next point."""

    @property
    def points(self) -> int:
        """How many points were reached, curves not laid out."""
        return len(self._rows)

    @property
    def operation(self) -> Operation:
        """The operation of the next point."""
        return self._next or self._operations[-1]

    @property
    def begins(self) -> bool:
        """Whether no point of the operation was reached yet."""
        return self._next is not None

    def begin(self, operation: Operation, *, always: bool = False) -> None:
        """The next points belong to another operation; to the same one where it is equal, unless `always`."""
        if always or self._next is not None or operation != self._operations[-1]:
            self._next = operation

    def unit_axis(self, line: int) -> Point:
        """The tool axis at length 1; ProgramError where it has no direction."""
        if self._unit_of[0] != self.axis:
            i, j, k = unit_axes(self.source, np.array([self.axis]), np.array([line]))[0].tolist()
            self._unit_of = (self.axis, (i, j, k))
        return self._unit_of[1]

    def move(self, tip: Point, line: int, caps: Caps | None, curve: Arc | Spline | None = None) -> None:
        """Reach a point [m], straight or along a curve; as a rapid (RAPID) where nothing bounds it."""
        if not max(map(abs, tip)) <= FARTHEST:
            self.source.fail("this point is more than a kilometre away: check the numbers and UNITS", line)
        if self._next is not None:
            self._operations.append(self._next)
            self._next = None
        row = len(self._rows)
        if isinstance(curve, Arc):
            self._arcs[row] = curve
        elif curve is not None:
            self._splines[row] = curve
        self.tip = tip
        rapid = caps is None or row == 0
        rate = caps if caps is not None and row else _FREE
        self._rows.append((*tip, *self.axis, *rate, line, len(self._operations) - 1, rapid, self.spindle))

    def stop(self, seconds: float = 0.0) -> None:
        """The motion rests at the last point."""
        if self._rows:
            last = len(self._rows) - 1
            self._stops.add(last)
            self._dwells[last] = self._dwells.get(last, 0.0) + seconds

    def toolpath(self, blocks: int, lengths: ToolLengths) -> ToolPath:
        """All points; on curves so many that chords keep within half a micrometre."""
        table = np.array(self._rows, dtype=float).reshape(len(self._rows), 12)
        line = table[:, 8].astype(np.int64)
        axis = unit_axes(self.source, table[:, 3:6], line)
        move, t, inside = self._pieces(line)
        tip, axes = table[move, :3], axis[move]
        rest = t < 1
        tip[rest] = inside
        axes[rest] = slerp(axis[move[rest] - 1], axis[move[rest]], t[rest])
        last = np.flatnonzero(~rest)
        stop, dwell = np.zeros(len(move), dtype=bool), np.zeros(len(move))
        stop[last[sorted(self._stops)]] = True
        for row, seconds in self._dwells.items():
            dwell[last[row]] = seconds
        curved = np.isin(move, [*self._arcs, *self._splines])
        operations, operation = tuple(self._operations), table[move, 9].astype(np.int64)
        points = ProgramPoints(
            tip,
            axes,
            feed=table[move, 6],
            least_time=table[move, 7] * _shares(tip, move),
            block=line[move],
            stop=stop,
            dwell=dwell,
            rapid=table[move, 10] > 0,
            operation=operation,
            tool_length=lengths.along(operations, operation, line[move]) if operations else None,
            bow=np.where(curved, SAG, 0.0),
            spindle=table[move, 11],
        )
        return assemble(self.source, points, ProgramFacts.of(lengths.findings, blocks, operations))

    def _pieces(self, line: Ints) -> tuple[Ints, Floats, Floats]:
        """Row of each point (n,), how far along its curve it is (n,), and those points that are inside curves."""
        count = np.ones(len(line), dtype=np.int64)
        for row, arc in self._arcs.items():
            count[row] = arc.pieces()
        for row, spline in self._splines.items():
            count[row] = spline.pieces()
        total = np.cumsum(count)
        if len(total) and total[-1] > MOST_POINTS:
            first = int(np.searchsorted(total, MOST_POINTS))
            self.source.fail(
                f"curves take more than {MOST_POINTS} points up to here: check the numbers", int(line[first])
            )
        move = np.repeat(np.arange(len(line)), count)
        t = (np.arange(len(move)) - np.repeat(total - count, count) + 1) / count[move]
        points = np.zeros((len(move), 3))
        which = np.full(len(line), -1)
        which[list(self._arcs)] = np.arange(len(self._arcs))
        on_arc = which[move] >= 0
        points[on_arc] = ArcTable(list(self._arcs.values())).evaluate(which[move[on_arc]], t[on_arc])
        for row, spline in self._splines.items():
            piece = slice(total[row] - count[row], total[row])
            t[piece] = spline.parameters()
            points[piece] = spline.evaluate(t[piece])
        return move, t, points[t < 1]


def _shares(tip: Floats, move: Ints) -> Floats:
    """Share (n,) of each piece in the length of its row, along which the time of the row is spread."""
    length = np.zeros(len(tip))
    length[1:] = np.linalg.norm(np.diff(tip, axis=0), axis=1)
    total, count = np.bincount(move, weights=length)[move], np.bincount(move)[move]
    spread = (count > 1) & (total > 0)
    return np.asarray(np.where(spread, length, 1.0) / np.where(spread, total, count))
