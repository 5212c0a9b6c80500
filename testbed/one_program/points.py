"""Cutter-location data as NX writes it: points of the tip and tool axes on the part, and no machine."""

from __future__ import annotations

import numpy as np

from testbed.one_program import frames
from testbed.one_program.motion import Circle, Move
from testbed.one_program.nodes import Frame, Holes, Offset, Program
from testbed.one_program.writer import INCH, Writer
from toolpace.common.arrays import Floats

CONTROLS_OWN = 0.254
"""How far a deep hole's pecks stay off the last one: no word tells it [mm]."""


class Points(Writer):
    """CLSF; frames, offsets and modes are worked out, since points are on the part."""

    name = "cldata"
    points_only = True

    def __init__(self, program: Program) -> None:
        super().__init__(program)
        self.inch = bool(self.rng.random() < 0.3)
        self.feed, self.axis = "", ""
        self.spindle = 0.0

    def length(self, millimetres: float) -> float:
        return millimetres / INCH if self.inch else millimetres

    def figures(self, values: Floats, lengths: bool = True) -> str:
        return ",".join(f"{self.length(value) if lengths else value:.13f}" for value in values)

    def header(self) -> None:
        self.block("PARTNO ONE PROGRAM")
        self.block("UNITS/INCHES" if self.inch else "UNITS/MM")
        self.say_tool(self.program.first[0])

    def footer(self) -> None:
        self.block("END-OF-PATH")
        self.block("FINI")

    def say_tool(self, number: str) -> None:
        self.said["tool"] += bool(self.world.moves)
        if self.world.moves:
            self.block("END-OF-PATH")
        self.block(f"TOOL PATH/STEP{len(self.lines)},TOOL,T{number}")
        self.block("TLDATA/MILL,10.0000,0.0000,75.0000,0.0000,0.0000")
        self.block(f"LOAD/TOOL,{number}")
        # the spindle stops the motion, as the change of tool does
        self.spindle = float(self.rng.integers(10, 80) * 100)
        self.block(f"SPINDL/RPM,{self.spindle:g},CLW")
        self.feed, self.axis = "", ""

    def on_part(self) -> Floats:
        """The space of the mode (4, 4) on the part, with the rotary joints where they are."""
        if self.world.mode != "plain":
            return np.eye(4)
        world = self.world
        home, made = world.home(world.length), np.eye(4)
        made[:3, 3] = self.machine.tip(home, world.rotary, world.length)
        for k in range(3):
            made[:3, k] = self.machine.tip(home + np.eye(3)[k], world.rotary, world.length) - made[:3, 3]
        return made

    def feed_block(self, move: Move) -> None:
        if move.rapid:
            self.block("RAPID")
            return
        tip = move.pose(0.0)[0], move.pose(1.0)[0]
        way = move.length if not (move.turns and move.slides) else float(np.linalg.norm(tip[1] - tip[0]))
        speed = self.length(way) * 60.0 / move.seconds
        units = ("MMPR", "IPR") if self.rng.random() < 0.15 else ("MMPM", "IPM")
        if units[0] == "MMPR":
            self.said["feed per revolution"] += 1
            speed /= self.spindle
        words = [units[self.inch], f"{speed:.12f}"]
        told = f"FEDRAT/{words[0]},{words[1]}" if self.rng.random() < 0.5 else f"FEDRAT/{words[1]},{words[0]}"
        if told != self.feed:
            self.block(told)
            self.feed = told

    def goto(self, tip: Floats, axis: Floats) -> None:
        told = self.figures(axis, lengths=False)
        tail = f",{told}" if told != self.axis or self.rng.random() < 0.3 else ""
        self.axis = told
        self.block(f"GOTO/{self.figures(tip)}{tail}")

    def say_move(self, move: Move, target: Floats, *, by: Floats | None = None, vector: bool = False) -> None:
        tip, axis, _ = move.pose(1.0)
        self.feed_block(move)
        if by is not None and not move.turns and self.world.moves and self.rng.random() < 0.5:
            self.said["incremental"] += 1
            self.block(f"GODLTA/{self.figures(tip - move.pose(0.0)[0])}")
            return
        self.goto(tip, axis)

    def say_arc(self, move: Move, circle: Circle, target: Floats, plane: int, left: bool) -> None:
        assert move.circle is not None
        told = move.circle.seen(self.on_part()) if move.slides else move.circle
        normal = np.cross(told.u, told.w)
        normal /= np.linalg.norm(normal)
        radius = float(np.linalg.norm(told.u))
        self.feed_block(move)
        turns = told.sweep / (2.0 * np.pi)
        count = round(turns) if abs(turns - round(turns)) < 1e-9 else int(turns) + 1
        if count > 1:
            self.in_turns(move, told, normal)
            return
        self.circle(told.centre, normal, radius)
        tip, axis, _ = move.pose(1.0)
        self.goto(tip, axis)

    def in_turns(self, move: Move, told: Circle, normal: Floats) -> None:
        """Turn by turn."""
        self.expanded["turns of an arc"] += 1
        step, at = 2.0 * np.pi / told.sweep, 0.0
        axis = move.pose(1.0)[1]
        while at < 1.0 - 1e-9:
            self.circle(told.centre + at * told.rise, normal, float(np.linalg.norm(told.u)))
            at = min(at + step, 1.0) if 1.0 - at - step > 1e-9 else 1.0
            self.goto(told.at(at) if at < 1.0 else move.pose(1.0)[0], axis)

    def circle(self, centre: Floats, normal: Floats, radius: float) -> None:
        """NX: eleven numbers, clockwise about the vector; Creo: seven, by the right-hand rule."""
        if self.rng.random() < 0.6:
            self.said["circle of NX"] += 1
            vector = self.figures(-normal, lengths=False)
            tail = ",0.0500,0.5000,10.0000,0.0000"
        else:
            self.said["circle of Creo"] += 1
            vector, tail = self.figures(normal, lengths=False), ""
        self.block(f"CIRCLE/{self.figures(centre)},{vector},{self.length(radius):.13f}{tail}")

    def any_arc(self, move: Move) -> bool:
        return True

    def say_dwell(self, seconds: float) -> None:
        self.block(f"DELAY/{seconds:g}")

    def say_stop(self) -> None:
        self.block("STOP" if self.rng.random() < 0.5 else "OPSTOP")

    def offset(self, node: Offset) -> None:
        self.expanded["work offset"] += 1
        self.world.offset = node.name

    def begin_tip(self) -> None:
        self.block("MULTAX/ON")

    def end_tip(self) -> None:
        self.block("MULTAX/OFF")

    def begin_frame(self, node: Frame, matrix: Floats) -> bool:
        return False

    # Cycles: along the tool

    def upright(self) -> bool:
        seen = (self.on_part() @ self.world.frame)[:3, :3]
        axis = self.machine.axis(self.world.rotary)
        return bool(np.abs(seen[:, 2] - axis).max() < 1e-12 and np.abs(seen.T @ seen - np.eye(3)).max() < 1e-12)

    def say_holes(self, node: Holes) -> bool:
        level = float(self.world.here()[2])
        gap = 1.25
        words = {"drill": "DRILL", "dwell": "DRILL", "tap": "TAP", "bore": "BORE", "bore and dwell": "BORE"}
        step = self.length(node.peck)
        if node.clearance == CONTROLS_OWN:
            words["peck"] = f"DRILL,DEEP,STEP,{step:.13f}"
        words["break"] = f"BRKCHP,STEP,{step:.13f},BACK,{self.length(node.clearance):.13f}"
        if node.kind not in words:
            return False
        on_part = self.on_part() @ self.world.frame
        axis = self.machine.axis(self.world.rotary)
        if node.to_top:
            # the first is gone over at the height before the cycle
            self.block("RAPID")
            self.goto(frames.on(on_part, np.array([*node.places[0], level])), axis)
        back = "" if node.to_top else f",RTRCTO,{self.length(level - node.top + gap):.13f}"
        depth, unit = self.length(node.bottom - node.top + gap), "IPM" if self.inch else "MMPM"
        dwell = f",DWELL,{node.seconds:g}" if node.seconds else ""
        self.block(
            f"CYCLE/{words[node.kind]},RAPTO,{self.length(gap):.13f},FEDTO,{depth:.13f}{back},"
            f"{unit},{self.length(node.speed):.12f}{dwell}"
        )
        for x, y in node.places:
            self.goto(frames.on(on_part, np.array([x, y, node.top - gap])), axis)
        self.block("CYCLE/OFF")
        self.feed = ""
        return True
