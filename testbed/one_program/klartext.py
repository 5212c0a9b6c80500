"""Heidenhain Klartext, after the user's manuals of iTNC 530 and TNC 640."""

from __future__ import annotations

import numpy as np

from testbed.one_program import frames
from testbed.one_program.motion import PLAIN, TIP, Circle, Move
from testbed.one_program.nodes import Frame, Holes, Plane, Program, Row
from testbed.one_program.writer import INCH, Writer
from testbed.one_program.written_out import AXES
from toolpace.common.arrays import Floats


def signed(value: float) -> str:
    """A number with its sign, as Klartext writes it."""
    shown = f"{value:+.12f}".rstrip("0").rstrip(".")
    return "+0" if shown in ("-0", "+0") else shown


class Klartext(Writer):
    """iTNC 530, TNC 640 and TNC7."""

    name = "heidenhain"

    def __init__(self, program: Program) -> None:
        super().__init__(program)
        self.inch = bool(self.rng.random() < 0.3)
        self.feed = ""
        self.routines: list[list[str]] = []
        self.known: dict[tuple[str, ...], int] = {}
        self.label, self.variables = 10, 0
        # of a vector of inches and degrees no manual says in what F counts
        self.turning = "vector" if not self.inch and self.chance(0.5) else "xyz"
        self.fixed_where_switched = self.chance(0.5)

    def parameters(self) -> dict[str, object]:
        return {"feed_when_turning": self.turning, "part_frame_where_switched": self.fixed_where_switched}

    # Numbers

    def chance(self, share: float) -> bool:
        return bool(self.rng.random() < share)

    def length(self, millimetres: float) -> float:
        return millimetres / INCH if self.inch else millimetres

    def value(self, value: float) -> str:
        """A number, or a parameter that was set to it."""
        if self.chance(0.06):
            self.said["variables"] += 1
            self.variables = self.variables % 18 + 1
            half = round(float(self.rng.uniform(-9.0, 9.0)), 3)
            if self.chance(0.5):
                self.block(f"FN 0: Q{self.variables} = {signed(value)}")
            else:
                self.block(f"Q{self.variables} = {signed(half)} + {signed(value - half)}")
            return f"+Q{self.variables}"
        return signed(value)

    def words(self, values: Floats, named: tuple[int, ...] = (0, 1, 2), prefix: str = "") -> str:
        return " ".join(f"{prefix}{'XYZ'[k]}{self.value(self.length(values[k]))}" for k in named)

    def rotary_words(self, rotary: Floats) -> str:
        return " ".join(f"{letter}{self.value(value)}" for letter, value in zip(self.machine.letters, rotary))

    def speed(self, millimetres: float) -> str:
        """F: in a program of inches tenths of an inch a minute."""
        return f"{self.length(millimetres) * (10.0 if self.inch else 1.0):.12f}".rstrip("0").rstrip(".")

    def feed_words(self, move: Move) -> str:
        if move.rapid:
            return " FMAX"
        way = move.length
        if move.turns and self.mode == PLAIN and self.turning == "vector":
            way = float(np.hypot(way, np.linalg.norm(move.rotary[1] - move.rotary[0])))
        told = f" F{self.speed(way * 60.0 / move.seconds)}"
        if told == self.feed and not self.whole:
            return ""
        self.feed = told
        return told

    def forget(self) -> None:
        self.feed, self.variables = "", 0

    # The program

    def header(self) -> None:
        self.block(f"BEGIN PGM ONE {'INCH' if self.inch else 'MM'}")
        tool, offset = self.program.first
        self.block(f"TOOL CALL {tool} Z S3000")
        if offset:
            self.say_offset(offset)

    def footer(self) -> None:
        self.block("M30")
        for routine in self.routines:
            self.lines += routine
        self.block(f"END PGM ONE {'INCH' if self.inch else 'MM'}")
        self.lines = [f"{number} {line}" for number, line in enumerate(self.lines)]

    # Motion

    def say_move(self, move: Move, target: Floats, *, by: Floats | None = None, vector: bool = False) -> None:
        way = target - self.here()
        named = tuple(k for k in range(3) if self.whole or not self.world.moves or abs(way[k]) > 1e-11)
        feed = self.feed_words(move)
        if move.turns and vector and self.mode == TIP:
            self.said["tool vector"] += 1
            axis = np.linalg.solve(self.coordinates[:3, :3], self.machine.axis(move.rotary[1]))
            tool = " ".join(f"T{letter}{signed(value)}" for letter, value in zip("XYZ", axis))
            self.block(f"LN {self.words(target)} NX+0 NY+0 NZ+1 {tool}{feed}")
            return
        rotary = f" {self.rotary_words(move.rotary[1])}" if move.turns else ""
        if by is not None and not rotary and (self.whole or self.chance(0.8)):
            self.said["incremental"] += 1
            self.block(f"L {self.words(by, prefix='I')}{feed}")
            return
        words = f"{self.words(target, named)}{rotary}".strip()
        if words:
            self.block(f"L {words}{feed}")

    def say_arc(self, move: Move, circle: Circle, target: Floats, plane: int, left: bool) -> None:
        if plane:
            self.said["plane of arcs"] += 1
            self.block(f"TOOL CALL {'ZYX'[plane]}")
        feed = self.feed_words(move)
        self.one_arc(circle, target, plane, f"DR{'+' if left else '-'}", feed)
        if plane:
            self.block("TOOL CALL Z")

    def one_arc(self, circle: Circle, target: Floats, plane: int, sense: str, feed: str) -> None:
        first, second = sorted(AXES[plane])
        normal = 3 - first - second
        flat = abs(circle.rise[normal]) < 1e-10
        whole = circle.sweep / (2.0 * np.pi)
        ends = self.words(target, (first, second))
        radius = float(np.linalg.norm(circle.u))
        if flat and whole < 1.0 - 1e-9 and self.chance(0.4):
            self.said["arc by radius"] += 1
            self.block(f"CR {ends} R{signed(self.length(radius if whole <= 0.5 else -radius))} {sense}{feed}")
            return
        self.block(f"CC {self.words(circle.centre, (first, second))}")
        if flat and whole < 1.0 + 1e-9:
            self.block(f"C {ends} {sense}{feed}")
            return
        self.said["helix"] += 1
        turned = signed(np.rad2deg(circle.sweep) * (1.0 if sense == "DR+" else -1.0))
        rise = signed(self.length(float(circle.rise[normal])))
        self.block(f"CP IPA{turned} I{'XYZ'[normal]}{rise} {sense}{feed}")

    # States

    def say_dwell(self, seconds: float) -> None:
        if self.chance(0.5):
            self.block("CYCL DEF 9.0 DWELL TIME")
            self.block(f"CYCL DEF 9.1 DWELL {seconds:g}")
        else:
            self.block(f"FUNCTION DWELL TIME{seconds:g}")

    def say_stop(self) -> None:
        self.block(str(self.rng.choice(["STOP", "M0", "M1"])))

    def say_tool(self, number: str) -> None:
        self.block(f"TOOL CALL {number} Z S3000")
        self.said["tool"] += 1

    def say_offset(self, name: str) -> bool:
        self.block(f"CYCL DEF 247 DATUM SETTING ~\n  Q339=+{int(name[1:]) - 53} ;DATUM NUMBER")
        return True

    def say_home(self, to: dict[int, float]) -> bool:
        words = " ".join(f"{'XYZ'[slot]}{signed(self.length(value))}" for slot, value in to.items())
        self.block(f"L {words} FMAX M91")
        return True

    # Frames: one of each kind, before a plane and in it, in the order of the program

    def begin_frame(self, node: Frame, matrix: Floats) -> bool:
        kinds = [kind for kind, _ in self.native]
        level = kinds[kinds.index("plane") + 1 :] if "plane" in kinds else kinds
        if node.kind in level or self.mode == TIP or self.under is not None:
            return False
        if node.kind == "turn" and node.value[0] != 2.0:
            return False
        if node.kind == "shift":
            self.shift(node.value)
        elif node.kind == "turn":
            self.block("CYCL DEF 10.0 ROTATION")
            self.block(f"CYCL DEF 10.1 ROT{signed(float(node.value[1]))}")
        elif node.kind == "mirror":
            self.block("CYCL DEF 8.0 MIRROR IMAGE")
            self.block("CYCL DEF 8.1 " + " ".join(k for k, v in zip("XYZ", node.value) if v < 0.0))
        else:
            self.block("CYCL DEF 11.0 SCALING")
            self.block(f"CYCL DEF 11.1 SCL {node.value[0]:g}")
        return True

    def shift(self, by: Floats) -> None:
        if self.chance(0.5):
            self.block(f"TRANS DATUM AXIS {self.words(by)}")
            return
        words = [self.words(by, (k,)) for k in range(3)]
        self.block("CYCL DEF 7.0 DATUM SHIFT")
        for k, word in enumerate(words, 1):
            self.block(f"CYCL DEF 7.{k} {word}")

    def end_frame(self, kind: str) -> None:
        if kind == "shift":
            self.block("CYCL DEF 7.0 DATUM SHIFT")
            for k, letter in enumerate("XYZ", 1):
                self.block(f"CYCL DEF 7.{k} {letter}+0")
        elif kind == "turn":
            self.block("CYCL DEF 10.0 ROTATION")
            self.block("CYCL DEF 10.1 ROT+0")
        elif kind == "mirror":
            self.block("CYCL DEF 8.0 MIRROR IMAGE")
            self.block("CYCL DEF 8.1")
        else:
            self.block("CYCL DEF 11.0 SCALING")
            self.block("CYCL DEF 11.1 SCL1")

    # Five axes

    def begin_tip(self) -> None:
        self.block("M128" if self.chance(0.5) else "FUNCTION TCPM F TCP AXIS POS PATHCTRL AXIS")
        if self.fixed_where_switched:
            self.under = frames.undo(self.machine.carried(self.world.rotary)) @ self.world.base

    def end_tip(self) -> None:
        self.block("M129" if self.chance(0.5) else "FUNCTION RESET TCPM")

    def say_plane_with_turn(self, node: Plane, matrix: Floats) -> bool:
        return self.tilt(matrix, "MOVE DIST0 FMAX" if node.follow else "TURN FMAX")

    def begin_plane(self, node: Plane, matrix: Floats) -> bool:
        return self.tilt(matrix, "STAY")

    def tilt(self, matrix: Floats, how: str) -> bool:
        if self.native or self.under is not None:
            return False
        self.shift(matrix[:3, 3])
        turned = matrix[:3, :3]
        style = int(self.rng.integers(4 if how == "STAY" else 3))
        a, b, c = map(signed, frames.fixed(turned))
        if style == 0:
            self.block(f"PLANE SPATIAL SPA{a} SPB{b} SPC{c} {how}")
        elif style == 1:
            first, middle, last = map(signed, frames.euler(turned))
            self.block(f"PLANE EULER EULPR{first} EULNU{middle} EULROT{last} {how}")
        elif style == 2:
            vectors = {"B": turned[:, 0], "N": turned[:, 2]}
            told = [f"{name}{k}{signed(v)}" for name, vector in vectors.items() for k, v in zip("XYZ", vector)]
            self.block(f"PLANE VECTOR {' '.join(told)} {how}")
        else:
            self.block("CYCL DEF 19.0 WORKING PLANE")
            self.block(f"CYCL DEF 19.1 A{a} B{b} C{c}")
        self.native.append(("plane", matrix))
        return True

    def end_plane(self) -> None:
        self.native.pop()
        self.block("PLANE RESET STAY")
        self.end_frame("shift")

    # Cycles

    def say_holes(self, node: Holes) -> bool:
        level = float(self.here()[2])
        seen = self.seen()
        places = [frames.on(seen, np.array([x, y, node.top])) for x, y in node.places]
        top = float(places[0][2])
        # pecks count from the surface, which is where the feed begins then
        gap = 0.0 if node.peck else 1.25
        surface = top - gap
        second = 0.0 if node.to_top else level - surface

        def shown(value: float) -> str:
            return signed(self.length(value))

        common = {
            200: shown(gap), 201: shown(node.bottom - node.top + gap), 206: self.speed(node.speed),
            203: shown(surface), 204: shown(second), 211: f"{node.seconds:g}",
        }  # fmt: skip
        number, more = {
            "drill": (200, {202: shown(100.0), 210: "+0"}),
            "dwell": (200, {202: shown(100.0), 210: "+0"}),
            "tap": (206, {}),
            "bore": (201, {208: "+0"}),
            "bore and dwell": (201, {208: "+0"}),
            "peck": (205, {202: shown(node.peck), 212: "+0", 205: "+0", 258: shown(node.clearance),
                           259: shown(node.clearance), 257: "+0", 256: "+0", 208: "FMAX"}),
            "break": (203, {202: shown(node.peck), 210: "+0", 212: "+0", 213: "+99", 205: "+0",
                            208: "FMAX", 256: shown(node.clearance)}),
        }[node.kind]  # fmt: skip
        told = [f"  Q{key}={value} ;FIGURE" for key, value in (common | more).items()]
        self.block(f"CYCL DEF {number} HOLES ~\n" + " ~\n".join(told))
        # a pattern goes from hole to hole at the height of its call, where that lies above the second clearance
        if node.to_top and len(places) > 1:
            for place in places:
                self.at(place)
        elif node.ring and self.chance(0.6):
            self.ring(node, seen)
        elif node.row and len(places) > 1 and self.chance(0.6):
            self.row_of_holes(node, seen, places)
        else:
            for place in places:
                self.at(place)
        return True

    def at(self, place: Floats) -> None:
        words = self.words(place, (0, 1))
        if self.chance(0.7):
            self.block(f"L {words} FMAX M99")
        else:
            self.block(f"L {words} FMAX")
            self.block("CYCL CALL")

    def ring(self, node: Holes, seen: Floats) -> None:
        assert node.ring is not None
        self.said["ring of holes"] += 1
        x, y, _ = frames.on(seen, np.array([*node.ring[:2], node.top]))
        start = node.ring[3] + float(np.rad2deg(np.arctan2(seen[1, 0], seen[0, 0])))
        told = f"X{self.value(self.length(x))} Y{self.value(self.length(y))} D{signed(self.length(2.0 * node.ring[2]))}"
        self.block(f"PATTERN DEF CIRC1 ({told} START{signed(start)} NUM{len(node.places)} Z+0)")
        self.block("CYCL CALL PAT FMAX")

    def row_of_holes(self, node: Holes, seen: Floats, places: list[Floats]) -> None:
        assert node.row is not None
        self.said["row of holes"] += 1
        step = seen[:3, :3] @ np.array([*node.row, 0.0])
        angle, pitch = float(np.rad2deg(np.arctan2(step[1], step[0]))), float(np.hypot(step[0], step[1]))
        told = self.words(places[0], (0, 1))
        told += f" D{signed(self.length(pitch))} NUM{len(places)} ROT{signed(angle)} Z+0"
        self.block(f"PATTERN DEF ROW1 ({told})")
        self.block("CYCL CALL PAT FMAX")

    # Flow

    def routine(self, text: list[str]) -> int:
        key = tuple(text)
        if key not in self.known:
            self.label += 1
            self.known[key] = self.label
            self.routines.append([f"LBL {self.label}", *text, "LBL 0"])
        return self.known[key]

    def say_repeat(self, times: int, text: list[str]) -> bool:
        if self.chance(0.6):
            self.label += 1
            self.lines += [f"LBL {self.label}", *text, f"CALL LBL {self.label} REP {times - 1}"]
        else:
            self.label += 1
            self.lines += [
                "Q90 = +0", f"LBL {self.label}", *text, "Q90 = Q90 + 1",
                f"FN 12: IF +Q90 LT +{times} GOTO LBL {self.label}",
            ]  # fmt: skip
        return True

    def say_call(self, name: int, text: list[str]) -> bool:
        self.block(f"CALL LBL {self.routine(text)}")
        return True

    def say_row(self, node: Row) -> bool:
        self.label += 1
        feed = f"F{self.speed(node.speed)}" if node.speed else "FMAX"
        self.block("Q80 = +0")
        self.block(f"LBL {self.label}")
        for k in range(3):
            start, step = signed(self.length(node.start[k])), signed(self.length(node.step[k]))
            self.block(f"Q{81 + k} = {start} + Q80 * ({step})")
        self.block(f"L X+Q81 Y+Q82 Z+Q83 {feed}")
        self.block("Q80 = Q80 + 1")
        self.block(f"CALL LBL {self.label} REP {node.times - 1}" if node.times > 1 else "; once")
        return True
