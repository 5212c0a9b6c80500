"""What of G-code each controller says in its own way."""

from __future__ import annotations

import numpy as np

from testbed.one_program import frames
from testbed.one_program.motion import TIP, Circle, Move
from testbed.one_program.nodes import Frame, Holes, Plane, Program, Row, Turn
from testbed.one_program.word_address import WordAddress
from testbed.one_program.words import text
from testbed.one_program.written_out import AXES
from toolpace.common.arrays import Floats


class Iso(WordAddress):
    """The words that most share: variables and loops as LinuxCNC has them are not among them."""

    name = "iso"


class Fanuc(WordAddress):
    """0i, 16i to 31i."""

    name = "fanuc"
    turns = False
    factor = 0.001
    by_radius = True
    milliseconds = True
    repeats = "K"

    def say_repeat(self, times: int, text: list[str]) -> bool:
        number = self.routine(text)
        self.block(f"M98 P{number} L{times}" if self.chance(0.5) else f"M98 P{times:04d}{number:04d}")
        return True


class Mazak(Fanuc):
    """Smooth and Matrix."""

    name = "mazak"
    repeats = "L"


class Haas(WordAddress):
    """NGC and UMC."""

    name = "haas"
    turns = False
    planes = False
    vectors = False
    mirror = ("G101", "G100")
    milliseconds = True
    tip_words = (("G234", "G49"), ("G43.4", "G49"))

    def begin_tip(self) -> None:
        super().begin_tip()
        if self.tip_word[0] == "G234":
            self.lines[-1] += f" H{self.world.tool}"

    def begin_plane(self, node: Plane, matrix: Floats) -> bool:
        """G254: parallel to the machine, about the work offset as the table has carried it."""
        if self.native or self.machine.head:
            return False
        self.block("G254")
        turned = np.eye(4)
        turned[:3, :3] = self.machine.carried(self.world.rotary)[:3, :3].T
        self.native.append(("plane", turned))
        return True

    def say_plane_with_turn(self, node: Plane, matrix: Floats) -> bool:
        return False

    def end_plane(self) -> None:
        self.native.pop()
        self.block("G255")


class LinuxCnc(WordAddress):
    """LinuxCNC."""

    name = "linuxcnc"
    planes = False
    vectors = False
    scales = False
    rotates = False
    tip_words = (("M428", "M429"), ("G43.4", "G49"))

    def __init__(self, program: Program) -> None:
        super().__init__(program)
        self.word = 100

    def header(self) -> None:
        self.opening()
        # taps stop where the spindle rests
        self.block("M3 S500")

    def footer(self) -> None:
        # a subprogram stands before its first call
        self.lines = [line for routine in self.routines for line in routine] + self.lines
        self.block("M2")

    def routine(self, text: list[str]) -> int:
        key = tuple(text)
        if key not in self.known:
            self.known[key] = 2000 + len(self.known)
            number = self.known[key]
            self.routines.append([f"o{number} sub", *text, f"o{number} endsub"])
        return self.known[key]

    def say_call(self, name: int, text: list[str]) -> bool:
        self.block(f"o{self.routine(text)} call")
        return True

    def say_repeat(self, times: int, text: list[str]) -> bool:
        self.word += 1
        self.lines += [f"o{self.word} repeat [{times}]", *text, f"o{self.word} endrepeat"]
        return True

    def say_row(self, node: Row) -> bool:
        motion = self.row_motion(node)
        self.word += 1
        self.block("#30=0")
        self.block(f"o{self.word} while [#30 LT {node.times}]")
        self.block(f"{motion} {self.row_words(node)}")
        self.block("#30=[#30+1]")
        self.block(f"o{self.word} endwhile")
        return True

    def say_holes(self, node: Holes) -> bool:
        # its interpreter feeds out to the level that is gone back to, and not to R alone (rs274, convert_cycle)
        if node.kind in ("tap", "bore and dwell") and not node.to_top:
            return False
        return super().say_holes(node)


class MillPlus(WordAddress):
    """MillPlus IT, as far as posts for it tell."""

    name = "millplus"
    turns = False
    scales = False
    rotates = False
    vectors = False
    inverse = ""
    unit_words = ("G71", "G70")
    letter = "E"
    tip_words = (("G141", "G40"),)

    def expression(self, index: int, rest: float) -> str:
        return ""

    def number(self, value: float) -> str:
        if self.variable and self.chance(0.06):
            self.said["variables"] += 1
            index = self.next_variable()
            self.block(f"E{index}={text(value)}")
            return f"=E{index}"
        return text(value)

    def parameters(self) -> dict[str, object]:
        return {"turning": self.turning}

    def header(self) -> None:
        self.block("%PM1234")
        self.block("N1234 (ONE PROGRAM)")
        self.block("G90 G71 G17 G94 G40")
        tool, offset = self.program.first
        self.block(f"T{tool} M6")
        if offset:
            self.block(offset)

    def footer(self) -> None:
        self.block("M30")

    def say_tool(self, number: str) -> None:
        self.block(f"T{number} M6")
        self.said["tool"] += 1

    def say_dwell(self, seconds: float) -> None:
        self.block(f"G4 X{text(seconds)}")
        self.motion = ""

    def say_home(self, to: dict[int, float]) -> bool:
        words = " ".join(f"{'XYZ'[slot]}{text(self.length(value))}" for slot, value in to.items())
        self.block(f"G74 {words} L1")
        self.motion = ""
        return True

    def begin_frame(self, node: Frame, matrix: Floats) -> bool:
        if node.kind != "shift" or self.native or self.mode == TIP or self.under is not None:
            return False
        self.block(f"G93 {self.words(node.value)}" if self.chance(0.5) else f"G92 {self.words(node.value)}")
        return True

    def end_frame(self, kind: str) -> None:
        self.block("G93 X0. Y0. Z0.")

    # Five axes: X, Y and Z are those of the part after the table has turned it

    def begin_tip(self) -> None:
        self.block("G141 L2=0 F2=15000.")
        self.stands()

    def stands(self) -> None:
        turned = np.eye(4)
        turned[:3, :3] = self.machine.carried(self.world.rotary)[:3, :3].T
        self.under = self.world.base @ turned

    def end_tip(self) -> None:
        self.block("G40")

    def turn(self, node: Turn) -> None:
        super().turn(node)
        if self.mode == TIP:
            self.stands()

    def say_move(self, move: Move, target: Floats, *, by: Floats | None = None, vector: bool = False) -> None:
        if move.turns and self.mode == TIP:
            turned = np.eye(4)
            turned[:3, :3] = self.machine.carried(move.rotary[1])[:3, :3].T
            target = frames.on(frames.undo(self.world.base @ turned), move.end)
            self.perhaps_unit()
            feed = self.feed_words(move)
            rotary = self.rotary_words(move.rotary[1])
            self.block(f"{self.motion_word('G0' if move.rapid else 'G1')}{self.words(target)} {rotary}{feed}")
            return
        super().say_move(move, target, by=by, vector=False)

    def one_arc(self, circle: Circle, target: Floats, plane: int, left: bool, feed: str) -> None:
        first, second = AXES[plane]
        words = self.words(target)
        centre = circle.centre
        how = f"{'IJK'[first]}{text(self.length(centre[first]))} {'IJK'[second]}{text(self.length(centre[second]))}"
        self.block(f"{self.motion_word('G3' if left else 'G2')}{words} {how}{feed}")

    def say_plane_with_turn(self, node: Plane, matrix: Floats) -> bool:
        if node.follow or self.native or self.under is not None:
            return False
        self.block(f"G93 {self.words(matrix[:3, 3])}")
        self.block("G7 " + self.angles(matrix) + " L1=1")
        self.native.append(("plane", matrix))
        return True

    def angles(self, matrix: Floats) -> str:
        told = frames.fixed(matrix[:3, :3])
        return " ".join(f"{letter}5={text(value)}" for letter, value in zip("ABC", told))

    def begin_plane(self, node: Plane, matrix: Floats) -> bool:
        if self.native or self.under is not None:
            return False
        self.block(f"G93 {self.words(matrix[:3, 3])}")
        self.block("G7 " + self.angles(matrix))
        self.native.append(("plane", matrix))
        return True

    def end_plane(self) -> None:
        self.native.pop()
        self.block("G7 L1=0")
        self.block("G93 X0. Y0. Z0.")

    # Cycles: from the surface, which is where the feed begins here

    def say_holes(self, node: Holes) -> bool:
        if node.kind not in ("drill", "tap", "bore", "dwell"):
            return False
        seen = self.seen()
        places = [frames.on(seen, np.array([x, y, node.top])) for x, y in node.places]
        level = self.here()[2]
        back = 0.0 if node.to_top else float(level - places[0][2])
        self.mode_of_feed("G94")
        if self.plane_word != "G17":
            self.block("G17")
            self.plane_word = "G17"
        feed = self.length(node.speed)
        gap = 1.5
        depth = f"Z{text(self.length(node.bottom - node.top + gap))} Y{text(self.length(gap))}"
        word = {"drill": "G81", "dwell": "G81", "tap": "G84", "bore": "G85"}[node.kind]
        dwell = f" X{text(node.seconds)}" if node.seconds else ""
        self.block(f"{word} {depth} B{text(self.length(back))}{dwell} F{text(feed)}")
        for place in places:
            self.block(f"G79 {self.words(place - [0.0, 0.0, gap])}")
        self.motion, self.feed = "", feed
        return True

    def say_repeat(self, times: int, text: list[str]) -> bool:
        return False

    def say_call(self, name: int, text: list[str]) -> bool:
        return False

    def say_row(self, node: Row) -> bool:
        return False
