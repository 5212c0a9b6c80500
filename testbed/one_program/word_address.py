"""G-code of LinuxCNC, Fanuc, Haas, Mazak: frames, planes, cycles, loops and calls, as far as they share them."""

from __future__ import annotations

import numpy as np

from testbed.one_program import frames
from testbed.one_program.motion import TIP
from testbed.one_program.nodes import Frame, Holes, Plane, Row
from testbed.one_program.words import Words, bracket, text
from toolpace.common.arrays import Floats

CYCLES = {
    "drill": "G81", "dwell": "G82", "peck": "G83", "break": "G73", "tap": "G84", "bore": "G85", "bore and dwell": "G89",
}  # fmt: skip
WITHIN = {
    "shift": (),
    "plane": ("shift",),
    "mirror": ("shift", "plane"),
    "scale": ("shift", "plane", "mirror"),
    "turn": ("shift", "mirror", "scale"),
}
"""Kinds of frames, and those within which each may begin: "G51.1, G51 and G68 in this order" (Fanuc)."""


class WordAddress(Words):
    """The words that all have for more than motions."""

    # Frames

    turned = 2
    """Slot of the normal of the plane that G68 turns."""

    def fits(self, kind: str) -> bool:
        """Whether a frame acts inside those that are there."""
        return all(other in WITHIN[kind] for other, _ in self.native)

    def begin_frame(self, node: Frame, matrix: Floats) -> bool:
        kind = node.kind
        if not self.fits(kind) or self.mode == TIP or self.under is not None or not self.has(kind):
            return False
        if kind == "shift":
            self.block(f"G52 {self.words(node.value)}")
        elif kind == "turn":
            slot = self.turned = int(node.value[0])
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

    def arc_fits(self, slot: int) -> bool:
        """ "The coordinate rotation plane and arc [...] plane must be the same" (Fanuc, alarm 144)."""
        return slot == self.turned or not any(kind == "turn" for kind, _ in self.native)

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
