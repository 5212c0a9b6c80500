"""G-code: LinuxCNC, Fanuc, Haas, Mazak and what they share."""

from __future__ import annotations

import numpy as np

from testbed.one_program import frames
from testbed.one_program.motion import PLAIN, TIP, Circle, Move
from testbed.one_program.nodes import Frame, Holes, Plane, Program, Row
from testbed.one_program.writer import AXES, INCH, Writer
from toolpace.arrays import Floats

CYCLES = {
    "drill": "G81", "dwell": "G82", "peck": "G83", "break": "G73", "tap": "G84", "bore": "G85", "bore and dwell": "G89",
}  # fmt: skip
RANK = {"shift": 0, "turn": 1, "plane": 1, "scale": 2, "mirror": 3}
"""The order in which frames act, whatever the order of the program."""


def text(value: float) -> str:
    """A number, with its point."""
    shown = f"{value:.12f}".rstrip("0")
    return "0." if shown in ("-0.", "0.") else shown


class WordAddress(Writer):
    """The words that all have; class attributes tell what differs."""

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

    # Frames

    def fits(self, kind: str) -> bool:
        """Whether a frame acts inside those that are there."""
        return all(RANK[other] < RANK[kind] for other, _ in self.native)

    def begin_frame(self, node: Frame, matrix: Floats) -> bool:
        kind = node.kind
        if not self.fits(kind) or self.mode == TIP or self.under is not None or not self.has(kind):
            return False
        if kind == "shift":
            self.block(f"G52 {self.words(node.value)}")
        elif kind == "turn":
            slot = int(node.value[0])
            self.plane_word = ("G19", "G18", "G17")[slot]
            zero = " ".join(f"{letter}0." for k, letter in enumerate("XYZ") if k != slot)
            self.block(self.plane_word)
            self.block(f"G68 {zero} R{text(float(node.value[1]))}")
        elif kind == "mirror":
            named = " ".join(f"{letter}0." for letter, sign in zip("XYZ", node.value) if sign < 0.0)
            self.block(f"{self.mirror[0]} {named}")
        else:
            factor = float(node.value[0])
            how = f"P{factor / self.factor:.0f}" if self.factor != 1.0 else f"P{text(factor)}"
            self.block(f"G51 X0. Y0. Z0. {how}")
        return True

    def has(self, kind: str) -> bool:
        return kind == "shift" or (kind == "turn" and self.rotates) or (kind in ("scale", "mirror") and self.scales)

    def end_frame(self, kind: str) -> None:
        named = "X0." if kind == "mirror" else ""
        self.block(
            {
                "shift": "G52 X0. Y0. Z0.",
                "turn": "G69",
                "scale": "G50",
                "mirror": f"{self.mirror[1]} {named} Y0." if named else "",
            }[kind]
        )

    # Five axes

    def begin_tip(self) -> None:
        self.tip_word = self.tip_words[int(self.rng.integers(len(self.tip_words)))]
        word = self.tip_word[0]
        self.block(f"{word} H{self.world.tool}" if word.startswith("G43") else word)
        if self.fixed_where_switched:
            self.under = frames.undo(self.machine.carried(self.world.rotary)) @ self.world.base

    def end_tip(self) -> None:
        self.vector_mode = False
        self.block(self.tip_word[1])
        if self.tip_word[1] == "G49":
            self.block(f"G43 H{self.world.tool}")

    def say_plane_with_turn(self, node: Plane, matrix: Floats) -> bool:
        return not node.follow and self.begin_plane(node, matrix)

    def tilt(self, matrix: Floats) -> None:
        angles = frames.euler(matrix[:3, :3])
        how = " ".join(f"{letter}{text(value)}" for letter, value in zip("IJK", angles))
        self.block(f"G68.2 {self.words(matrix[:3, 3])} {how}")
        self.native.append(("plane", matrix))

    def begin_plane(self, node: Plane, matrix: Floats) -> bool:
        """G53.1 turns what has not been turned before it."""
        if not self.planes or not self.fits("plane") or self.under is not None:
            return False
        self.tilt(matrix)
        self.block("G53.1")
        return True

    def end_plane(self) -> None:
        self.native.pop()
        self.block("G69")

    # Cycles

    def say_holes(self, node: Holes) -> bool:
        if node.kind not in CYCLES:
            return False
        if self.plane_word != "G17":
            self.block("G17")
            self.plane_word = "G17"
        if self.vector_mode:
            self.switch_vectors(False)
        self.mode_of_feed("G94")
        feed = self.length(node.speed)
        seen = self.seen()
        places = [frames.on(seen, np.array([x, y, node.top])) for x, y in node.places]
        bottom = places[0][2] + node.bottom - node.top
        words = [CYCLES[node.kind], f"Z{text(self.length(bottom))}", f"R{text(self.length(float(places[0][2])))}"]
        if node.seconds:
            words.append(f"P{node.seconds * 1000:.0f}" if self.milliseconds else f"P{text(node.seconds)}")
        if node.peck:
            words.append(f"Q{text(self.length(node.peck))}")
        first = self.words(places[0][:2], "XY", (0, 1))
        self.block(f"{'G99' if node.to_top else 'G98'} {' '.join(words)} {first} F{text(feed)}")
        if node.row and len(places) > 1 and self.chance(0.7):
            self.said["repeats of a cycle"] += 1
            step = self.words((seen[:3, :3] @ [*node.row, 0.0])[:2], "XY", (0, 1))
            self.in_steps(step, len(places) - 1, bottom - places[0][2], places[0][2])
        else:
            for place in places[1:]:
                self.block(self.words(place[:2], "XY", (0, 1)))
        self.block("G80")
        self.motion, self.feed = "", feed
        return True

    def in_steps(self, step: str, count: int, depth: float, top: float) -> None:
        """Holes at distances: R and Z keep what they were given."""
        self.block("G91")
        level = self.length(float(top - self.here()[2]))
        self.block(f"{step} R{text(level)} Z{text(self.length(float(depth)))} {self.repeats}{count}")
        self.block("G90")

    # Flow

    def say_repeat(self, times: int, text: list[str]) -> bool:
        number = self.routine(text)
        self.block(f"M98 P{number} L{times}")
        return True

    def routine(self, text: list[str]) -> int:
        """The number of a subprogram with this text."""
        key = tuple(text)
        if key not in self.known:
            self.known[key] = 2000 + len(self.known)
            self.routines.append([f"O{self.known[key]}", *text, "M99"])
        return self.known[key]

    def say_call(self, name: int, text: list[str]) -> bool:
        self.block(f"M98 P{self.routine(text)}")
        return True

    def row_words(self, node: Row) -> str:
        return " ".join(
            f"{letter}[{text(self.length(start))}+#30*{bracket(self.length(step))}]"
            for letter, start, step in zip("XYZ", node.start, node.step)
        )

    def row_motion(self, node: Row) -> str:
        if not node.speed:
            return "G0"
        self.mode_of_feed("G94")
        return f"G1 F{text(self.length(node.speed))}"

    def say_row(self, node: Row) -> bool:
        if self.vector_mode:
            return False
        motion = self.row_motion(node)
        self.block("#30=0")
        self.block(f"WHILE [#30 LT {node.times}] DO1")
        self.block(f"{motion} {self.row_words(node)}")
        self.block("#30=#30+1")
        self.block("END1")
        return True


def bracket(value: float) -> str:
    """A number that may follow an operator."""
    return f"[{text(value)}]"
