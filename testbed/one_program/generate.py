"""Programs at random, by a seed: the same in every run."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from testbed.one_program.machine import Kinematics
from testbed.one_program.nodes import (
    Arc,
    By,
    Call,
    Dwell,
    Frame,
    Holes,
    Home,
    Line,
    Node,
    Offset,
    Plane,
    Program,
    Repeat,
    Row,
    Stop,
    Tip,
    Tool,
    Turn,
)
from toolpace.common.arrays import Floats

MACHINES = ("xyzac-trunnion", "xyzbc-head", "xyzbc-nutating", "xyzbc-trunnion", "xyzac-head")
HOLES = ("drill", "dwell", "peck", "break", "tap", "bore", "bore and dwell")
LEVEL = 40.0
"""Height from which holes are drilled and subprograms begin."""


class Generator:
    """Makes one program."""

    def __init__(self, seed: int, machines: Sequence[str] = MACHINES) -> None:
        self.rng = np.random.default_rng(seed)
        self.seed = seed
        self.machine = Kinematics.load(machines[int(self.rng.integers(len(machines)))])
        self.with_setup = bool(self.rng.random() < 0.6)
        self.clearance = float(self.rng.choice([0.5, 0.8, 1.0, 0.254]))
        self.tools: dict[str, float] = {}
        self.offsets: dict[str, Floats] = {}
        self.tool = "1"
        self.planar = True
        """Whether holes with pecks may stand here: they are not scaled."""

    def program(self) -> Program:
        """All of it."""
        zero = None
        if self.with_setup:
            self.tools = {str(n): self._round(60.0, 240.0) for n in (1, 2, 3)}
            self.offsets = {name: self._place(60.0) for name in ("G54", "G55", "G56")}
            zero = np.array([self._round(300.0, 600.0), self._round(300.0, 600.0), self._round(300.0, 600.0)])
        first = ("1", "G54") if self.with_setup else ("1", "")
        body = tuple(node for _ in range(int(self.rng.integers(3, 8))) for node in self._part())
        return Program(
            self.seed, self.machine.name, self.offsets, self.tools, zero, first, self._above(), self.clearance, body
        )

    # Numbers

    def _round(self, low: float, high: float, digits: int = 2) -> float:
        return round(float(self.rng.uniform(low, high)), digits)

    def _place(self, size: float = 50.0) -> Floats:
        return np.array([self._round(-size, size) for _ in range(3)])

    def _above(self) -> Floats:
        return np.array([*self._place()[:2], LEVEL])

    def _speed(self) -> float:
        return float(self.rng.integers(20, 400) * 10)

    def _perhaps_rapid(self) -> float:
        return 0.0 if self.rng.random() < 0.3 else self._speed()

    def _rotary(self) -> Floats:
        """Positions whose other solution is farther off, wherever the joints are: of a small set."""
        tilting, turning = self._round(8.0, 40.0, 1), self._round(-35.0, 35.0, 1)
        first, second = self.machine.letters
        # the joint that tilts is A, or B; C turns
        return np.array([turning, tilting] if first == "C" and second != "C" else [tilting, turning])

    # Parts

    def _part(self) -> list[Node]:
        """Nodes that leave frames and modes as they were; they begin from anywhere."""
        choice = self.rng.random()
        if choice < 0.32:
            return self._simple(int(self.rng.integers(1, 5)))
        if choice < 0.40:
            return [self._framed(1)]
        if choice < 0.52:
            return [Line(self._above(), 0.0), self._holes()]
        if choice < 0.62:
            turned: list[Node] = [Turn(np.full(3, np.nan), self._rotary(), 0.0)] if self.rng.random() < 0.3 else []
            return [*turned, self._tip(), *self._upright()]
        if choice < 0.74:
            return [self._plane(), *self._upright()]
        if choice < 0.80:
            return self._indexed()
        if choice < 0.86:
            return self._again()
        if choice < 0.90:
            return [Row(self._place(), self._place(6.0), int(self.rng.integers(2, 6)), self._perhaps_rapid())]
        return self._of_shop()

    def _simple(self, count: int) -> list[Node]:
        made: list[Node] = []
        for _ in range(count):
            choice = self.rng.random()
            if choice < 0.35:
                made.append(Line(self._place(), self._perhaps_rapid()))
            elif choice < 0.5:
                made.append(By(self._place(20.0), self._perhaps_rapid()))
            elif choice < 0.85:
                made += self._arc()
            elif choice < 0.95:
                made.append(Dwell(int(self.rng.integers(1, 3000)) / 1000))
            else:
                made.append(Stop())
        return made

    def _arc(self) -> list[Node]:
        """A line to its start, and an arc: a full circle, part of one, or a helix."""
        start = self._place()
        plane = int(self.rng.integers(3))
        u, v, n = ((0, 1, 2), (2, 0, 1), (1, 2, 0))[plane]
        centre = np.array(start)
        centre[u] += self._round(2.0, 30.0)
        centre[v] += self._round(-30.0, 30.0)
        spoke = start - centre
        angle = 0.0 if self.rng.random() < 0.25 else self._round(20.0, 340.0, 1)
        c, s = np.cos(np.deg2rad(angle)), np.sin(np.deg2rad(angle))
        to = np.array(start)
        to[u], to[v] = centre[u] + c * spoke[u] - s * spoke[v], centre[v] + s * spoke[u] + c * spoke[v]
        if angle == 0.0:
            to = np.array(start)
        if self.rng.random() < 0.35:
            to[n] += self._round(-15.0, 15.0)
        turns = int(self.rng.integers(1, 4)) if self.rng.random() < 0.2 else 0
        return [
            Line(start, self._perhaps_rapid()),
            Arc(plane, centre, to, bool(self.rng.random() < 0.5), turns, self._speed()),
        ]

    def _holes(self) -> Node:
        kind = str(self.rng.choice(HOLES)) if self.planar else "drill"
        top = self._round(5.0, LEVEL - 2.0, 1)
        peck = self._round(2.0, 6.0, 1)
        depth = peck * int(self.rng.integers(2, 5)) if self.rng.random() < 0.6 else self._round(4.0, 30.0, 1)
        count = int(self.rng.integers(1, 5))
        row, ring = None, None
        first = self._place()[:2]
        places = [tuple(self._place()[:2]) for _ in range(count)]
        style = self.rng.random()
        if style < 0.25:
            row = (self._round(-9.0, 9.0), self._round(2.0, 9.0))
            places = [(first[0] + k * row[0], first[1] + k * row[1]) for k in range(count)]
        elif style < 0.5:
            ring = (float(first[0]), float(first[1]), self._round(5.0, 30.0), self._round(-90.0, 90.0, 1))
            angles = [np.deg2rad(ring[3] + 360.0 * k / count) for k in range(count)]
            places = [(ring[0] + ring[2] * float(np.cos(a)), ring[1] + ring[2] * float(np.sin(a))) for a in angles]
        return Holes(
            kind,
            top,
            round(top - depth, 6),
            bool(self.rng.random() < 0.5),
            tuple((float(x), float(y)) for x, y in places),
            self._speed(),
            int(self.rng.integers(100, 2000)) / 1000 if "dwell" in kind else 0.0,
            peck if kind in ("peck", "break") else 0.0,
            self.clearance,
            row,
            ring,
        )

    def _framed(self, depth: int) -> Node:
        kind = str(self.rng.choice(["shift", "shift", "turn", "turn", "mirror", "scale"]))
        before, size = self.planar, 20.0
        if kind == "shift":
            value = self._place(size)
        elif kind == "turn":
            slot = 2.0 if self.rng.random() < 0.7 else float(self.rng.integers(3))
            value = np.array([slot, float(self.rng.choice([90.0, 180.0, self._round(-170.0, 170.0, 1)]))])
        elif kind == "mirror":
            value = np.array([-1.0, 1.0, 1.0]) if self.rng.random() < 0.5 else np.array([1.0, -1.0, 1.0])
        else:
            value = np.full(3, float(self.rng.choice([0.5, 2.0, 1.25, 0.8])))
        self.planar = before and kind in ("shift", "turn")
        body = self._simple(int(self.rng.integers(1, 4)))
        if self.rng.random() < 0.3 and kind != "scale":
            body += [Line(self._above(), 0.0), self._holes()]
        if depth < 3 and self.rng.random() < 0.4:
            body.append(self._framed(depth + 1))
        self.planar = before
        return Frame(kind, value, tuple(body))

    def _upright(self) -> list[Node]:
        """Away from the part, and the rotary joints back to zero, slides standing: as posts do between operations."""
        return [Turn(np.full(3, np.nan), np.zeros(2), 0.0), Line(self._above(), 0.0)]

    def _tip(self) -> Node:
        body: list[Node] = []
        for _ in range(int(self.rng.integers(2, 6))):
            seconds = 0.0 if self.rng.random() < 0.2 else self._round(0.1, 3.0)
            vector = bool(self.rng.random() < 0.5)
            body.append(Turn(self._place(), self._rotary(), seconds, vector))
            if self.rng.random() < 0.3:
                body.append(Line(self._place(), self._perhaps_rapid()))
            if self.rng.random() < 0.2:
                body += self._arc()
            if self.rng.random() < 0.1:
                body.append(Dwell(0.25))
        if self.rng.random() < 0.3:
            kind = str(self.rng.choice(["shift", "turn"]))
            value = self._place(20.0) if kind == "shift" else np.array([2.0, self._round(-170.0, 170.0, 1)])
            body.append(Frame(kind, value, (Turn(self._place(), self._rotary(), 1.5), *self._simple(2))))
        return Tip(tuple(body))

    def _plane(self) -> Node:
        body: list[Node] = [Line(self._above(), 0.0), *self._simple(int(self.rng.integers(1, 4)))]
        if self.rng.random() < 0.6:
            body += [Line(self._above(), 0.0), self._holes()]
        if self.rng.random() < 0.3:
            value = self._place(20.0)
            body.append(Frame("shift", value, tuple(self._simple(2))))
        spin = self._round(-170.0, 170.0, 1)
        return Plane(self._place(20.0), spin, self._rotary(), bool(self.rng.random() < 0.4), tuple(body))

    def _indexed(self) -> list[Node]:
        """Slides while the rotary joints stand turned, or turn."""
        made: list[Node] = [Turn(np.full(3, np.nan), self._rotary(), 0.0)]
        if self.rng.random() < 0.5:
            made += self._simple(2)
        if self.rng.random() < 0.5:
            made.append(Turn(self._place(), self._rotary(), self._round(0.2, 4.0)))
        return [*made, *self._upright()]

    def _again(self) -> list[Node]:
        ways = tuple(By(self._place(8.0), self._perhaps_rapid()) for _ in range(int(self.rng.integers(1, 4))))
        body: tuple[Node, ...] = ways
        if self.rng.random() < 0.5:
            body = (Line(self._place(), self._speed()), *self._simple(3), *ways)
        name = int(self.rng.integers(1, 9)) * 100 + int(self.rng.integers(100))
        if self.rng.random() < 0.5:
            return [Repeat(int(self.rng.integers(2, 5)), body)]
        return [Call(name, body), Line(self._place(), self._speed()), Call(name, body)]

    def _of_shop(self) -> list[Node]:
        """What belongs to the machine: tools, offsets, machine coordinates."""
        choice = self.rng.random()
        if not self.with_setup:
            return [Line(self._above(), 0.0), self._another_tool(8), Line(self._above(), 0.0)]
        if choice < 0.4:
            return [self._another_tool(3), Line(self._above(), 0.0)]
        if choice < 0.7:
            return [Offset(str(self.rng.choice(["G54", "G55", "G56"]))), Line(self._above(), 0.0)]
        slots = [2] if self.rng.random() < 0.6 else [0, 1]
        return [Home({slot: self._round(-200.0, -1.0) for slot in slots}), Line(self._above(), self._perhaps_rapid())]

    def _another_tool(self, count: int) -> Node:
        self.tool = str(self.rng.choice([str(n) for n in range(1, count + 1) if str(n) != self.tool]))
        return Tool(self.tool)


def generate(seed: int, machines: Sequence[str] = MACHINES) -> Program:
    """The program of a seed, for one of the machines."""
    return Generator(seed, machines).program()
