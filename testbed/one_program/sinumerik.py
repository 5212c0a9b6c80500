"""Sinumerik, after "Fundamentals" (PF), "Job Planning" (PJ), "NC Programming" (PN) and "Cycles" (PZ)."""

from __future__ import annotations

import numpy as np

from testbed.one_program import frames
from testbed.one_program.motion import TIP, Circle, Move
from testbed.one_program.nodes import Frame, Holes, Plane, Program, Row
from testbed.one_program.word_address import WordAddress
from testbed.one_program.words import text
from testbed.one_program.written_out import AXES
from toolpace.common.arrays import Floats


class Sinumerik(WordAddress):
    """840D, 828D, One."""

    name = "sinumerik"
    unit_words = ("G710", "G700")
    swivel_stops = True

    def __init__(self, program: Program) -> None:
        super().__init__(program)
        self.fixed_where_switched = False
        self.word = 0
        self.fresh = False
        """Whether the coordinates have changed since the last motion."""

    def parameters(self) -> dict[str, object]:
        return {"feed_turning": self.turning}

    # Numbers: R parameters, distances in one word

    def number(self, value: float) -> str:
        if self.chance(0.06):
            self.said["variables"] += 1
            half, index = round(float(self.rng.uniform(-9.0, 9.0)), 3), self.next_variable()
            self.block(f"R{index}={text(half)}")
            return f"=R{index}+({text(value - half)})"
        return text(value)

    # The program

    def header(self) -> None:
        self.block("; ONE PROGRAM")
        self.block("G90 G710 G17 G94 G40")
        tool, offset = self.program.first
        self.block(f"T{tool} M6")
        self.block("D1")
        if offset:
            self.block(offset)

    def footer(self) -> None:
        self.block("M30")
        self.lines += [line for routine in self.routines for line in routine]

    def say_offset(self, name: str) -> bool:
        self.fresh = True
        return super().say_offset(name)

    def say_tool(self, number: str) -> None:
        self.fresh = True
        self.block(f"T{number}")
        self.block("M6")
        self.block("D1")
        self.said["tool"] += 1

    def say_dwell(self, seconds: float) -> None:
        self.block(f"G4 F{text(seconds)}")

    def say_home(self, to: dict[int, float]) -> bool:
        words = " ".join(f"{'XYZ'[slot]}{text(self.length(value))}" for slot, value in to.items())
        self.block(f"SUPA G0 {words}" if self.chance(0.5) else f"G53 G0 {words}")
        self.motion = "G0"
        return True

    # Motion

    def say_move(self, move: Move, target: Floats, *, by: Floats | None = None, vector: bool = False) -> None:
        # a distance behind a new frame counts from the last place as it was called before (SD42440 = 1)
        by = None if self.fresh else by
        self.fresh = False
        if by is not None and not move.turns and self.chance(0.5):
            self.said["incremental"] += 1
            feed = self.feed_words(move)
            words = " ".join(f"{'XYZ'[k]}=IC({text(self.length(by[k]))})" for k in range(3))
            self.block(f"{self.motion_word('G0' if move.rapid else 'G1')}{words}{feed}")
            return
        super().say_move(move, target, by=by, vector=vector)

    def turn_words(self, move: Move, vector: bool) -> str:
        if not vector:
            return self.rotary_words(move.rotary[1])
        self.said["tool vector"] += 1
        axis = np.linalg.solve(self.coordinates[:3, :3], self.machine.axis(move.rotary[1]))
        return " ".join(f"{letter}3={text(value)}" for letter, value in zip("ABC", axis))

    def say_arc(self, move: Move, circle: Circle, target: Floats, plane: int, left: bool) -> None:
        # what TURN means of an arc that ends over its start no manual says in one sentence
        whole = circle.sweep / (2.0 * np.pi)
        self.turns = abs(whole - round(whole)) > 1e-9
        super().say_arc(move, circle, target, plane, left)
        self.fresh = False

    def one_arc(self, circle: Circle, target: Floats, plane: int, left: bool, feed: str) -> None:
        rest = circle.sweep % (2.0 * np.pi)
        full = min(rest, 2.0 * np.pi - rest) < 1e-9
        whole = round(circle.sweep / (2.0 * np.pi)) if full else int(circle.sweep / (2.0 * np.pi))
        turns = whole - 1 if full else whole
        first, second = AXES[plane]
        words = self.words(target)
        style = self.rng.random()
        radius = float(np.linalg.norm(circle.u))
        if not full and not turns and style < 0.3:
            self.said["arc by radius"] += 1
            how = f"CR={text(self.length(radius if circle.sweep <= np.pi else -radius))}"
        elif not full and not turns and style < 0.4 and np.abs(circle.rise).max() < 1e-9:
            self.said["arc through a place"] += 1
            middle = circle.at(0.5)
            named = " ".join(f"{letter}1={text(self.length(value))}" for letter, value in zip("IJK", middle))
            self.motion = "CIP"
            self.block(f"CIP {words} {named}{feed}")
            return
        elif style < 0.7:
            how = " ".join(f"{'IJK'[k]}=AC({text(self.length(circle.centre[k]))})" for k in (first, second))
        else:
            how = " ".join(f"{'IJK'[k]}{text(self.length(-circle.u[k]))}" for k in (first, second))
        if turns:
            self.said["turns of an arc"] += 1
            how += f" TURN={turns}"
        self.block(f"{self.motion_word('G3' if left else 'G2')}{words} {how}{feed}")

    # Frames: in any order, each in those before

    def begin_frame(self, node: Frame, matrix: Floats) -> bool:
        self.fresh = True
        if self.mode == TIP or self.under is not None:
            return False
        within = any(kind != "plane" for kind, _ in self.native)
        word = "A" if within else ""
        if node.kind == "shift":
            self.block(f"{word}TRANS {self.words(node.value)}")
        elif node.kind == "turn":
            slot, angle = int(node.value[0]), text(float(node.value[1]))
            if self.chance(0.5):
                self.plane_word = ("G19", "G18", "G17")[slot]
                self.block(self.plane_word)
                self.block(f"{word}ROT RPL={angle}")
            else:
                self.block(f"{word}ROT {'XYZ'[slot]}{angle}")
        elif node.kind == "mirror":
            named = " ".join(f"{letter}0" for letter, sign in zip("XYZ", node.value) if sign < 0.0)
            self.block(f"{word}MIRROR {named}")
        else:
            self.block(f"{word}SCALE " + " ".join(f"{k}{text(v)}" for k, v in zip("XYZ", node.value)))
        return True

    def end_frame(self, kind: str) -> None:
        """All of them anew but the last."""
        self.fresh = True
        self.block("TRANS")
        for other, matrix in self.native:
            if other == "shift":
                self.block(f"ATRANS {' '.join(f'{k}{text(self.length(v))}' for k, v in zip('XYZ', matrix[:3, 3]))}")
            elif other == "turn":
                angles = frames.moving(matrix[:3, :3])
                # one after the other, each about the axes as turned
                for letter, angle in zip("XYZ", angles):
                    self.block(f"AROT {letter}{text(angle)}")
            elif other in ("mirror", "scale"):
                word = "AMIRROR" if other == "mirror" else "ASCALE"
                values = matrix.diagonal()[:3]
                chosen = [(k, v) for k, v in zip("XYZ", values) if other == "scale" or v < 0.0]
                self.block(f"{word} " + " ".join(f"{k}{text(v) if other == 'scale' else '0'}" for k, v in chosen))

    # Five axes

    def begin_tip(self) -> None:
        self.fresh = True
        self.block("TRAORI")
        # rotary axes in proportion between two tool vectors
        self.block("ORIMKS")
        self.block("ORIAXES")

    def end_tip(self) -> None:
        self.fresh = True
        self.block("TRAFOOF")

    def say_plane_with_turn(self, node: Plane, matrix: Floats) -> bool:
        """_DIR tells which of the two solutions, by the sign of the joint that tilts; it ends at rest."""
        if self.native or self.under is not None or self.chance(0.4):
            return False
        tilting = float(node.rotary[0 if self.machine.letters[1] == "C" else 1])
        self.swivel(matrix, 1 if tilting > 0.0 else -1, follow=node.follow)
        return True

    def begin_plane(self, node: Plane, matrix: Floats) -> bool:
        if self.native or self.under is not None:
            return False
        self.swivel(matrix, 0)
        return True

    def swivel(self, matrix: Floats, direction: int, *, follow: bool = False) -> None:
        self.fresh = True
        angles = frames.moving(matrix[:3, :3])
        at = ",".join(text(self.length(v)) for v in matrix[:3, 3])
        turned = ",".join(text(v) for v in angles)
        self.block(f'CYCLE800(0,"",{10 * follow},57,{at},{turned},0,0,0,{direction},0,1)')
        self.native.append(("plane", matrix))

    def end_plane(self) -> None:
        self.native.pop()
        self.fresh = True
        self.block("CYCLE800()")

    # Cycles

    def say_holes(self, node: Holes) -> bool:
        depth, peck = node.top - node.bottom, node.peck
        whole = abs(depth / peck - round(depth / peck)) < 1e-9 if peck else True
        if not whole or (peck and node.kind == "peck" and node.clearance <= 0.0):
            return False
        if self.plane_word != "G17":
            self.block("G17")
            self.plane_word = "G17"
        seen = self.seen()
        places = [frames.on(seen, np.array([x, y, node.top])) for x, y in node.places]
        top = float(places[0][2])
        back = top if node.to_top else float(self.here()[2])

        def shown(value: float) -> str:
            return text(self.length(value))

        gap = 0.0 if peck else 1.25
        levels = f"{shown(back)},{shown(top - gap)},{shown(gap)},{shown(top - depth)},"
        if node.kind == "drill":
            cycle = f"CYCLE81({levels})"
        elif node.kind == "dwell":
            cycle = f"CYCLE82({levels},{text(node.seconds)})"
        elif node.kind == "peck":
            cycle = f"CYCLE83({levels},,{shown(peck)},0,0,0,1,1,3,{shown(peck)},,,{shown(node.clearance)})"
        elif node.kind == "break":
            cycle = f"CYCLE83({levels},,{shown(peck)},0,0,0,1,0,3,{shown(peck)},{shown(node.clearance)})"
            return False
        elif node.kind in ("bore", "bore and dwell"):
            speed = shown(node.speed)
            cycle = f"CYCLE85({levels},{text(node.seconds)},{speed},{speed})"
        else:
            return False
        self.mode_of_feed("G94")
        self.feed = self.length(node.speed)
        self.block(f"G0 F{text(self.feed)}")
        self.block(f"MCALL {cycle}")
        # HOLES1 begins at the end that is nearer
        away = [float(np.hypot(*(place - self.here())[:2])) for place in (places[0], places[-1])]
        if node.row and len(places) > 1 and away[0] < away[1]:
            self.said["row of holes"] += 1
            step = seen[:3, :3] @ np.array([*node.row, 0.0])
            angle, pitch = np.rad2deg(np.arctan2(step[1], step[0])), float(np.hypot(*step[:2]))
            x, y = places[0][:2]
            self.block(f"HOLES1({shown(x)},{shown(y)},{text(float(angle))},0,{shown(pitch)},{len(places)})")
        elif node.ring:
            self.said["ring of holes"] += 1
            x, y, _ = frames.on(seen, np.array([*node.ring[:2], node.top]))
            turned = np.rad2deg(np.arctan2(seen[1, 0], seen[0, 0]))
            self.block(
                f"HOLES2({shown(x)},{shown(y)},{shown(node.ring[2])},{text(node.ring[3] + turned)},0,{len(places)})"
            )
        else:
            for place in places:
                self.block(self.words(place[:2], "XY", (0, 1)))
        self.block("MCALL")
        self.motion = ""
        return True

    # Flow

    def routine(self, text: list[str]) -> int:
        key = tuple(text)
        if key not in self.known:
            self.known[key] = 2000 + len(self.known)
            self.routines.append([f"%_N_L{self.known[key]}_SPF", *text, "M17"])
        return self.known[key]

    def say_repeat(self, times: int, text: list[str]) -> bool:
        style = self.rng.random()
        self.word += 1
        if style < 0.3:
            self.block(f"L{self.routine(text)} P{times}")
        elif style < 0.5:
            self.lines += ["R90=0", "REPEAT", *text, "R90=R90+1", f"UNTIL R90>={times}"]
        elif style < 0.75:
            self.lines += [f"MARK{self.word}:", *text, f"REPEAT MARK{self.word} P={times - 1}"]
        else:
            self.lines += [f"FOR R90=1 TO {times}", *text, "ENDFOR"]
        return True

    def say_call(self, name: int, text: list[str]) -> bool:
        self.block(f"L{self.routine(text)}")
        return True

    def say_row(self, node: Row) -> bool:
        motion = self.row_motion(node)
        words = " ".join(
            f"{letter}={text(self.length(start))}+R30*({text(self.length(step))})"
            for letter, start, step in zip("XYZ", node.start, node.step)
        )
        self.lines += ["R30=0", f"WHILE R30<{node.times}", f"{motion} {words}", "R30=R30+1", "ENDWHILE"]
        return True
