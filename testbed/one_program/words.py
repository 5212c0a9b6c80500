"""Words and motions of G-code: numbers, feeds, lines, arcs, and what stands beside them."""

from __future__ import annotations

import numpy as np

from testbed.one_program.motion import PLAIN, TIP, Circle, Move
from testbed.one_program.nodes import Program
from testbed.one_program.writer import INCH, Writer
from testbed.one_program.written_out import AXES
from toolpace.common.arrays import Floats


def text(value: float) -> str:
    """A number, with its point."""
    shown = f"{value:.12f}".rstrip("0")
    return "0." if shown in ("-0.", "0.") else shown


class Words(Writer):
    """What all say of motions; class attributes tell what differs."""

    name = "iso"
    variable = True
    planes = True
    vectors = True
    turns = True
    """Whether P of an arc counts whole turns."""
    scales = True
    factor = 1.0
    """What a whole number of scaling counts."""
    mirror = ("G51.1", "G50.1")
    turning: str
    """What F divides outside tip mode where rotary joints turn: the way of X, Y, Z, or mm and degrees as one."""
    by_radius = False
    """Whether F of an arc under G93 is the feed over the radius."""
    milliseconds = False
    fixed_where_switched: bool
    """Whether tip mode fixes the frame to the part where the table stands; a parameter of the machine."""
    repeats = "L"
    rotates = True
    tip_words = (("G43.4", "G49"),)
    numbered = "G54.1 P"
    after_cycle = ""

    def __init__(self, program: Program) -> None:
        super().__init__(program)
        self.feed_mode, self.feed, self.spindle = "", 0.0, 0.0
        self.motion, self.plane_word, self.absolute = "", "", True
        self.routines: list[list[str]] = []
        self.known: dict[tuple[str, ...], int] = {}
        self.counter = 0
        self.tip_word = self.tip_words[0]
        self.vector_mode = False
        self.variables = 0
        self.turning = "vector" if self.chance(0.5) else "xyz"
        self.fixed_where_switched = self.chance(0.5)

    def parameters(self) -> dict[str, object]:
        clearance = self.program.clearance
        return {
            "peck_clearance_mm": clearance,
            "chip_break_mm": clearance,
            "turning": self.turning,
            "tip_frame_where_switched": self.fixed_where_switched,
            # numbers have more digits here than the increment system keeps
            "values_are_rounded": False,
        }

    # Numbers

    def chance(self, share: float) -> bool:
        return bool(self.rng.random() < share)

    def length(self, millimetres: float) -> float:
        return millimetres / INCH if self.inch else millimetres

    def number(self, value: float) -> str:
        """A number, or an expression that comes to it."""
        if self.variable and self.chance(0.06):
            self.said["variables"] += 1
            half = round(float(self.rng.uniform(-9.0, 9.0)), 3)
            index = self.next_variable()
            self.block(f"{self.letter}{index}={text(half)}")
            return self.expression(index, value - half)
        return text(value)

    letter = "#"

    def next_variable(self) -> int:
        """One that no other word of the block has."""
        self.variables = self.variables % 18 + 1
        return self.variables

    def expression(self, index: int, rest: float) -> str:
        return f"[#{index}+{text(rest)}]"

    def words(self, values: Floats, letters: str = "XYZ", named: tuple[int, ...] = (0, 1, 2)) -> str:
        """Axis words of lengths."""
        return " ".join(f"{letters[k]}{self.number(self.length(values[k]))}" for k in named)

    def rotary_words(self, rotary: Floats) -> str:
        return " ".join(f"{letter}{self.number(value)}" for letter, value in zip(self.machine.letters, rotary))

    # Modes

    def forget(self) -> None:
        self.variables = 0
        self.feed_mode = self.motion = self.plane_word = ""
        self.feed = 0.0
        self.block(self.absolute_word)
        self.absolute = True

    absolute_word = "G90"

    def feed_words(self, move: Move) -> str:
        """What tells the control how fast; a mode of feed may change for it."""
        if move.rapid:
            return ""
        turning = move.turns and self.mode == PLAIN
        way = self.length(move.length)
        if turning and self.turning == "vector":
            way = float(np.hypot(way, np.linalg.norm(move.rotary[1] - move.rotary[0])))
        style = self.rng.random()
        if self.inverse and style < 0.15:
            number = 60.0 / move.seconds
            if move.circle is not None and self.by_radius:
                number *= move.circle.length / float(np.linalg.norm(move.circle.u))
            self.mode_of_feed(self.inverse)
            self.said["inverse time"] += 1
            self.feed = 0.0
            return f" F{text(number)}"
        per_minute = way * 60.0 / move.seconds
        if style < 0.25 and not turning:
            self.mode_of_feed("G95")
            self.said["feed per revolution"] += 1
            if not self.spindle or self.feed == 0.0:
                self.spindle = float(self.rng.integers(10, 80) * 100)
                self.block(f"S{self.spindle:g}")
            value = per_minute / self.spindle
        else:
            self.mode_of_feed("G94")
            value = per_minute
        if value == self.feed and not self.whole:
            return ""
        self.feed = value
        return f" F{text(value)}"

    inverse = "G93"

    def mode_of_feed(self, word: str) -> None:
        if word != self.feed_mode:
            self.feed_mode, self.feed = word, 0.0
            self.block(word)

    def motion_word(self, word: str) -> str:
        same, self.motion = word == self.motion, word
        return "" if same and not self.whole and self.chance(0.7) else word + " "

    def perhaps_unit(self) -> None:
        """Go over to the other unit now and then."""
        if not self.whole and self.chance(0.03):
            self.inch = not self.inch
            self.said["unit"] += 1
            self.block(self.unit_words[self.inch])
            self.feed = 0.0

    unit_words = ("G21", "G20")

    # The program

    def header(self) -> None:
        self.block("%")
        self.block("O1234 (ONE PROGRAM)")
        self.opening()

    def opening(self) -> None:
        """Modes, tool and offset."""
        self.block("G90 G21 G17 G94 G40")
        tool, offset = self.program.first
        self.block(f"T{tool} M6")
        if offset:
            self.block(offset)
        self.block(f"G43 H{tool}")

    def footer(self) -> None:
        self.block("M30")
        for routine in self.routines:
            self.lines += routine
        self.block("%")

    # Motion

    def say_move(self, move: Move, target: Floats, *, by: Floats | None = None, vector: bool = False) -> None:
        self.perhaps_unit()
        way = target - self.here()
        if self.polar(move, target, way):
            return
        named = tuple(k for k in range(3) if self.whole or not self.world.moves or abs(way[k]) > 1e-11)
        feed = self.feed_words(move)
        rotary = ""
        if move.turns:
            vector = vector and self.mode == TIP and self.vectors
            rotary = self.turn_words(move, vector)
        if by is not None and self.chance(0.8 if not self.whole else 2.0) and not rotary:
            self.said["incremental"] += 1
            words = self.words(by, named=(0, 1, 2))
            self.block("G91")
            self.block(f"{self.motion_word('G0' if move.rapid else 'G1')}{words}{feed}")
            self.block("G90")
            return
        words = f"{self.words(target, named=named)} {rotary}".strip()
        if words:
            self.block(f"{self.motion_word('G0' if move.rapid else 'G1')}{words}{feed}")

    def polar(self, move: Move, target: Floats, way: Floats) -> bool:
        """Say a motion in the plane by radius and angle, now and then."""
        return False

    def turn_words(self, move: Move, vector: bool) -> str:
        if vector:
            if not self.vector_mode:
                self.switch_vectors(True)
            self.said["tool vector"] += 1
            axis = np.linalg.solve(self.coordinates[:3, :3], self.machine.axis(move.rotary[1]))
            axis = axis * (1.0 if self.chance(0.7) else 1.7)
            return " ".join(f"{letter}{text(value)}" for letter, value in zip("IJK", axis))
        if self.vector_mode:
            self.switch_vectors(False)
        return self.rotary_words(move.rotary[1])

    def switch_vectors(self, on: bool) -> None:
        self.vector_mode = on
        self.block(f"G43.5 H{self.world.tool}" if on else f"G43.4 H{self.world.tool}")

    def say_arc(self, move: Move, circle: Circle, target: Floats, plane: int, left: bool) -> None:
        self.perhaps_unit()
        if self.vector_mode:
            self.switch_vectors(False)
        word = ("G17", "G18", "G19")[plane]
        if word != self.plane_word:
            self.block(word)
            self.plane_word = word
            self.said["plane of arcs"] += 1
        if circle.sweep > 2.0 * np.pi + 1e-9 and not self.turns:
            self.in_turns(move, circle, target, plane, left)
            return
        feed = self.feed_words(move)
        self.one_arc(circle, target, plane, left, feed)

    def in_turns(self, move: Move, circle: Circle, target: Floats, plane: int, left: bool) -> None:
        """Whole turns one after the other, and the rest."""
        self.expanded["turns of an arc"] += 1
        feed = self.feed_words(move)
        if self.feed_mode == self.inverse:
            self.mode_of_feed("G94")
            self.feed = self.length(move.length) * 60.0 / move.seconds
            feed = f" F{text(self.feed)}"
        at, whole = 0.0, 2.0 * np.pi / circle.sweep
        start = circle
        while at < 1.0 - 1e-12:
            share = min(whole, 1.0 - at)
            if 1.0 - at - whole < 1e-9:
                share = 1.0 - at
            rise = circle.rise * share
            part = Circle(start.centre, start.u, start.w, circle.sweep * share, rise)
            at += share
            end = circle.at(at) if at < 1.0 - 1e-12 else target
            self.one_arc(part, end, plane, left, feed)
            start = Circle(start.centre + rise, start.u, start.w, 0.0, rise)

    def one_arc(self, circle: Circle, target: Floats, plane: int, left: bool, feed: str) -> None:
        full = abs(circle.sweep % (2.0 * np.pi)) < 1e-9 or abs(circle.sweep % (2.0 * np.pi) - 2.0 * np.pi) < 1e-9
        turns = round(circle.sweep / (2.0 * np.pi) - 0.5 + 1e-9)
        first, second = AXES[plane]
        spoke = -circle.u
        words = self.words(target)
        if not full and turns == 0 and self.chance(0.4):
            self.said["arc by radius"] += 1
            radius = float(np.linalg.norm(circle.u)) * (1.0 if circle.sweep <= np.pi else -1.0)
            how = f"R{text(self.length(radius))}"
        else:
            letters = "IJK"
            how = (
                f"{letters[first]}{text(self.length(spoke[first]))} {letters[second]}{text(self.length(spoke[second]))}"
            )
            count = turns if full else turns + 1
            if count > 1:
                self.said["turns of an arc"] += 1
                how += f" P{count}"
        self.block(f"{self.motion_word('G3' if left else 'G2')}{words} {how}{feed}")

    # States

    def say_dwell(self, seconds: float) -> None:
        self.block(f"G4 P{seconds * 1000:.0f}" if self.milliseconds else f"G4 P{text(seconds)}")

    def say_stop(self) -> None:
        self.block("M0" if self.chance(0.5) else "M1")

    def say_tool(self, number: str) -> None:
        self.block(f"T{number} M6")
        self.block(f"G43 H{number}")
        self.said["tool"] += 1

    def say_offset(self, name: str) -> bool:
        self.block(name)
        return True

    def say_home(self, to: dict[int, float]) -> bool:
        words = " ".join(f"{'XYZ'[slot]}{text(self.length(value))}" for slot, value in to.items())
        self.block(f"G53 G0 {words}")
        self.motion = "G0"
        return True


def bracket(value: float) -> str:
    """A number that may follow an operator."""
    return f"[{text(value)}]"
