"""The motions of a program as rows, with the strokes of its holes and the operations that they belong to."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple, Protocol

import numpy as np

from toolpace.common.arrays import Bools, Floats, Ints
from toolpace.programs.commanded import BLENDED
from toolpace.programs.reading.arcs import Arc
from toolpace.programs.reading.splines import Bezier
from toolpace.programs.toolpath import Operation

RAPID, FEED, JUMP = 0.0, 1.0, 2.0
"""Kinds of rows. A jump is no motion: it re-reads the same place in the other mode (tip or joints)."""


class Stroke(NamedTuple):
    """A straight way to a level, and what is done there."""

    level: float
    """Coordinate of the program along the line [m]."""
    rapid: bool = True
    speed: float = 0.0
    """Of a way at feed [m/s]; 0: that in force."""
    stop: bool = False
    dwell: float = 0.0
    """[s]"""


class StrokeTable(NamedTuple):
    """Strokes of a hole as arrays: the motions that one row of moves stands for.

    A hole takes ten of them, and a program has thousands of holes that are alike: what they share is kept once.
    """

    offset: Floats
    """(k, 3) from the row's position to the end of each [m]."""
    rate: Floats
    """(k, 3): speed [m/s], turn [rad/s], time [s]."""
    kind: Floats
    stop: Bools
    dwell: Floats


class Expansion:
    """Rows of moves, some of which stand for strokes, to the rows of single motions."""

    def __init__(self, rows: int, strokes: dict[int, StrokeTable]) -> None:
        count = np.ones(rows, dtype=np.int64)
        alike: dict[int, tuple[StrokeTable, list[int]]] = {}
        for row, table in strokes.items():
            alike.setdefault(id(table), (table, []))[1].append(row)
        for table, of in alike.values():
            count[of] = len(table.kind)
        self.row: Ints = np.repeat(np.arange(rows), count)
        """Of each motion, the row that it comes from."""
        self.last: Ints = np.cumsum(count) - 1
        """Of each row, its last motion."""
        self.strokes = [
            (table, self.last[of][:, None] + np.arange(1 - len(table.kind), 1)) for table, of in alike.values()
        ]
        """Strokes (k,), and the motions (holes, k) that they are."""


class Rate(NamedTuple):
    """What F says of a motion: speed of X, Y, Z [m/s] and of rotations in place [rad/s], or its time [s]."""

    speed: float = math.inf
    turn: float = math.inf
    time: float = 0.0


class Joining(NamedTuple):
    """How motions meet, as the program asks for."""

    mode: int = BLENDED
    tolerance: float = math.inf
    """Of blending [m]; inf where the program asks for none, nan before it has asked for anything."""
    cam_tolerance: float = math.nan
    """Within which straight motions may be taken as one [m]; nan where the program does not say."""


class ProgramTolerance(NamedTuple):
    """How far motions may stray from their way, by the program's own words; nan where it tells nothing."""

    tip: float = math.nan
    """[m]"""
    axis: float = math.nan
    """[rad]"""


class Dynamics(NamedTuple):
    """What the program says of the control's acceleration and of corners; nan where it says nothing."""

    brisk: float = math.nan
    """1: without limit of jerk (BRISK), 0: with one (SOFT)."""
    rounded: float = math.nan
    """1: corners are rounded within a tolerance (G641 to G645, CYCLE832), 0: they are not (G64)."""
    mode: float = math.nan
    """Set of limits that is in force: 0 DYNNORM, 1 DYNFINISH, 2 DYNSEMIFIN, 3 DYNROUGH, 4 DYNPREC, 5 DYNPOS."""
    smooth: float = math.nan
    """R of LinuxCNC's G64: 0 the planner without limit of jerk, 0.1 to 1 that with one, and its share of speeds."""


class Stage(Protocol):
    """What may stand between the motions of a program and the moves, and lays other ways in their place."""

    compensates: bool
    """Whether the program's contour is being followed beside it; else the way back to it is still to come."""

    @property
    def kept(self) -> list[float]:
        """Words (3 + rotary) that axes keep which a motion in machine coordinates does not name."""

    def move(self, start: list[float], end: list[float], arc: Arc | None, rate: Rate, kind: float) -> None:
        """A motion of the program between words (3 + rotary)."""

    def redirect(self, end: list[float]) -> None:
        """The last motion of the program, which was straight, ends earlier."""

    def other_motion(self, what: str) -> None:
        """A motion that is no line and no arc of a contour comes next, or coordinates change."""


class Moves:
    """Rows of motions, appended one by one; stops and dwells are noted at the last position."""

    def __init__(self, rotary: int) -> None:
        self.rotary = rotary
        self.kind = 3 + rotary + 4
        """Column of the kind."""
        self.operation = 0
        """Of the motions that are added from now on."""
        self.rows: list[tuple[float, ...]] = []
        self.arcs: dict[int, Arc] = {}
        self.curves: dict[int, Bezier] = {}
        self.strokes: dict[int, StrokeTable] = {}
        """Rows that stand for several motions along one line."""
        self.in_strokes = 0
        """How many motions those are."""
        self.stops: set[int] = set()
        self.exact: set[int] = set()
        """Rows at rest at their ends by the mode alone."""
        self.switched: set[int] = set()
        """Rows behind which the control switches something that the path does not need rest for."""
        self.dwells: dict[int, float] = {}
        self.waited = 0.0
        """Dwells before the first position [s]."""
        self.joinings: list[tuple[int, Joining]] = [(0, Joining(tolerance=math.nan))]
        """How rows meet, from which on."""
        self.normals: dict[int, tuple[float, float, float]] = {}
        """Unit vectors out of the part at the ends of rows, on the part."""
        self.tolerance: list[tuple[int, ProgramTolerance]] = [(0, ProgramTolerance())]
        """How far rows may stray, from which on."""
        self.dynamics: list[tuple[int, Dynamics]] = [(0, Dynamics())]
        """Acceleration and corners of rows, from which on."""
        self.spindle: list[tuple[int, tuple[float]]] = [(0, (math.nan,))]
        """Turns per second of the spindle [1/s], signed by its sense, from which row on; nan: not told."""

    def __len__(self) -> int:
        return len(self.rows)

    def add(
        self,
        position: list[float],
        rate: Rate,
        line: int,
        kind: float,
        tip_mode: bool,
        named: int,
        tool_length: float,
    ) -> None:
        """Note a motion to `position` (3 + rotary); `named` has a bit for each of X, Y, Z named so far.

        `tool_length`: of the tool whose tip is meant [m].
        """
        self.rows.append((*position, *rate, line, kind, tip_mode, named, self.operation, tool_length))

    def stop(self) -> None:
        """Come to rest at the last position; before the first there is nothing to stop."""
        if self.rows:
            self.stops.add(len(self.rows) - 1)

    def stop_by_mode(self) -> None:
        """Come to rest at the last position, since every motion does in the mode in force."""
        if self.rows:
            self.exact.add(len(self.rows) - 1)

    def switch(self) -> None:
        """Note that something is switched at the last position: spindle, coolant, a table."""
        if self.rows:
            self.switched.add(len(self.rows) - 1)

    @property
    def joining(self) -> Joining:
        """How motions meet that are added now."""
        return self.joinings[-1][1]

    def join(self, joining: Joining) -> None:
        """Note how motions meet from now on."""
        if joining != self.joining:
            self.joinings.append((len(self.rows), joining))

    def ask(self, **tolerances: float) -> None:
        """Note how far motions may stray from now on: tip [m], axis [rad]; what is no length above zero is told no
        more."""
        changed = {name: value if value > 0.0 else math.nan for name, value in tolerances.items()}
        self.tolerance.append((len(self.rows), self.tolerance[-1][1]._replace(**changed)))

    def drive(self, **dynamics: float) -> None:
        """Note what the program says of acceleration and corners from now on: fields of Dynamics."""
        self.dynamics.append((len(self.rows), self.dynamics[-1][1]._replace(**dynamics)))

    def turn(self, spindle: float) -> None:
        """Note how fast the spindle turns from now on [1/s]: above zero clockwise, 0 where it stands."""
        self.spindle.append((len(self.rows), (spindle,)))

    def dwell(self, seconds: float) -> None:
        """Come to rest at the last position and wait."""
        self.stop()
        if self.rows:
            last = len(self.rows) - 1
            self.dwells[last] = self.dwells.get(last, 0.0) + seconds
        else:
            self.waited += seconds

    def stand(self) -> None:
        """Take some place for that where a program waits that moves nothing."""
        self.add([0.0] * (3 + self.rotary), Rate(), 1, FEED, True, 0, 0.0)
        self.dwells[0] = self.waited

    def table(self) -> MoveTable:
        """The motions as arrays, from the start of the path on."""
        width = 3 + self.rotary
        array = np.array(self.rows, dtype=float).reshape(len(self.rows), width + 9)
        expansion = Expansion(len(array), self.strokes)
        array, last = array[expansion.row], expansion.last
        stop, dwell = np.zeros(len(array), dtype=np.bool_), np.zeros(len(array))
        for strokes, motions in expansion.strokes:
            array[motions, :3] += strokes.offset
            array[motions, width : width + 3], array[motions, self.kind] = strokes.rate, strokes.kind
            stop[motions], dwell[motions] = strokes.stop, strokes.dwell
        stop[last[list(self.stops)]] = True
        dwell[last[list(self.dwells)]] += list(self.dwells.values())
        at_rest, switched = stop.copy(), stop.copy()
        at_rest[last[list(self.exact)]] = True
        switched[last[list(self.switched)]] = True
        joining = self._from_then_on(self.joinings)[expansion.row]
        tolerance = self._from_then_on(self.tolerance)[expansion.row]
        dynamics = self._from_then_on(self.dynamics)[expansion.row]
        spindle = self._from_then_on(self.spindle)[expansion.row, 0]
        normal = np.full((len(array), 3), np.nan)
        for i, out in self.normals.items():
            normal[last[i]] = out
        first = self._start(array[:, self.kind], array[:, width + 6].astype(int)) if len(array) else 0
        reread = first
        while reread + 1 < len(array) and array[reread + 1, self.kind] == JUMP:
            reread += 1
        if reread > first and array[reread, -1] != array[first, -1] and array[reread, -2] == array[first, -2]:
            # no way leads to the start: of the same tool it is the tip that is reckoned with where the motion begins
            dwell[reread] += dwell[first:reread].sum()
            array[reread, width + 3 : width + 5] = array[first, width + 3 : width + 5]  # of the block that came there
            first = reread
        arcs = {int(last[i]) - first: arc for i, arc in self.arcs.items() if last[i] > first}
        curves = {int(last[i]) - first: curve for i, curve in self.curves.items() if last[i] > first}
        array, joining, tolerance = array[first:], joining[first:], tolerance[first:]
        at_rest, switched, dwell = at_rest[first:], switched[first:], dwell[first:]
        return MoveTable(
            array[:, :width], array[:, width:], at_rest, dwell, arcs, curves, switched, joining, tolerance,
            normal[first:], dynamics[first:], spindle[first:],
        )  # fmt: skip

    def _from_then_on(self, changes: Sequence[tuple[int, tuple[float, ...]]]) -> Floats:
        """(rows, k) what was told from a row on, of each row."""
        begin = np.array([row for row, _ in changes])
        rows = np.diff(np.append(begin, len(self.rows)))
        return np.repeat(np.array([each for _, each in changes], dtype=float), rows, axis=0)

    @staticmethod
    def _start(kind: Floats, named: Ints) -> int:
        """Row at whose end the path starts.

        Where the machine stands before the program is unknown, so the path starts where the program first has
        all the axes it uses positioned: leading rapids that position them one after the other are passed over,
        but no motion at feed ever is, except the way to the first position.
        """
        complete = int(named[-1])
        for index in range(len(named)):
            if named[index] == complete:
                return index
            if index and kind[index] == FEED:
                return index - 1
        return len(named) - 1


class MoveTable(NamedTuple):
    """Moves as arrays; row 0 is the place where the path starts."""

    position: Floats
    """(n, 3 + rotary) [m, rad] at the end of each row, in the coordinates of its mode."""
    columns: Floats
    """(n, 9): speed [m/s], turn [rad/s], time [s], line, kind, tip mode, named, operation, tool length
    [m]."""
    stop: Bools
    dwell: Floats
    arcs: dict[int, Arc]
    curves: dict[int, Bezier]
    switched: Bools
    """(n,) whether a control comes to rest whatever the mode: stops, and where something is switched."""
    joining: Floats
    """(n, 3) Joining of each row."""
    tolerance: Floats
    """(n, 2) ProgramTolerance of each row."""
    normal: Floats
    """(n, 3) out of the part at the end of each row; nan where none was told."""
    dynamics: Floats
    """(n, 3) Dynamics of each row."""
    spindle: Floats
    """(n,) turns per second of the spindle [1/s], signed by its sense; nan where it is not told."""


class Operations:
    """What motions belong to: each is noted with the operation that is the last when it is added."""

    def __init__(self, moves: Moves) -> None:
        self.moves = moves
        self.all: list[Operation] = [Operation()]

    def begin(self, *, name: str | None = None, tool: str | None = None) -> None:
        """Begin the next one, of this name, or with this tool; what is not given stays."""
        last = self.all[-1]
        if not self._moved():
            self.all.pop()
        lengths = last.told_lengths if tool is None else ()
        self.all.append(
            Operation(last.name if name is None else name.strip(), last.tool if tool is None else tool, lengths)
        )
        self.moves.operation = len(self.all) - 1

    def tell_length(self, length: float) -> None:
        """The tool of the present one is reckoned with another length than its table's [m]."""
        last = self.all[-1]
        if length not in last.told_lengths:
            self.all[-1] = replace(last, told_lengths=(*last.told_lengths, length))

    def _moved(self) -> bool:
        """Whether there was any motion in the last one."""
        return bool(self.moves.rows) and self.moves.rows[-1][-2] >= self.moves.operation
