"""What all writers share: they follow the model through a program, and say each node natively, or by simpler nodes.

The control's coordinates are known to the writer as a frame of their own. Where they are not those of the model, since
the dialect has no word for a frame or the writer chose not to use it, the words are worked out for them.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable

import numpy as np

from testbed.one_program import frames
from testbed.one_program.dialect import Dialect
from testbed.one_program.machine import Kinematics
from testbed.one_program.motion import PLAIN, TILT, TIP, Move, World
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
from testbed.one_program.written_out import NORMAL, circle_of, drilled, matrix_of
from toolpace.common.arrays import Floats

INCH = 25.4


class CannotWriteError(Exception):
    """The dialect has no words for this motion."""


class Writer(Dialect):
    """One writing of one program; subclasses know the words."""

    def __init__(self, program: Program) -> None:
        self.program = program
        self.rng = np.random.default_rng(program.seed + 7)
        self.machine = Kinematics.load(program.machine)
        self.world = World(self.machine, program.offsets, program.tools, program.machine_zero)
        self.lines: list[str] = []
        self.said: Counter[str] = Counter()
        """Concepts that were said natively."""
        self.expanded: Counter[str] = Counter()
        """Concepts that were written out by other means."""
        self.mode = PLAIN
        """What the control takes words for: a plane may be written as a tip."""
        self.native: list[tuple[str, Floats]] = []
        """Frames that the control is in, by kind."""
        self.under: Floats | None = None
        """(4, 4) of the control's coordinates without `native`, where they are not those of the work offset."""
        self.inch = False
        self.whole = False
        """Whether every axis is named: text that is used again depends on nothing before it."""
        self.handlers: dict[type, Callable[..., None]] = {
            Line: self.line, By: self.by, Arc: self.arc, Turn: self.turn, Dwell: self.wait, Stop: self.halt,
            Tool: self.change, Offset: self.offset, Home: self.home, Holes: self.holes, Frame: self.framed,
            Tip: self.tip, Plane: self.plane, Repeat: self.repeat, Call: self.call, Row: self.row,
        }  # fmt: skip

    def parameters(self) -> dict[str, object]:
        """What the builder of the machine has set: options of the controller's file."""
        return {}

    # The program

    def write(self) -> str:
        """The text. Raises CannotWriteError."""
        program, world = self.program, self.world
        world.tool, world.offset = program.first
        self.header()
        self.run([Line(program.begin, 0.0), *program.body])
        if len(world.moves) < 2:
            self.run([By(np.array([1.0, 2.0, 3.0]), 600.0)])
        self.footer()
        return "\n".join(self.lines) + "\n"

    def run(self, body: Iterable[Node]) -> None:
        """Nodes, one after the other."""
        for node in body:
            self.handlers[type(node)](node)

    def block(self, text: str) -> None:
        """A line of text."""
        self.lines.append(text)

    # Coordinates

    @property
    def coordinates(self) -> Floats:
        """The control's (4, 4), in the space of the mode."""
        made = self.world.base if self.under is None else self.under
        for _, matrix in self.native:
            made = made @ matrix
        return made

    def seen(self) -> Floats:
        """The model's coordinates in the control's (4, 4)."""
        made = frames.undo(self.coordinates) @ self.world.frame
        near = np.round(made)
        return np.where(np.abs(made - near) < 1e-13, near, made)

    def here(self) -> Floats:
        """Where the machine is (3,), in the control's words."""
        return frames.on(frames.undo(self.coordinates), self.world.place())

    # Motion

    def line(self, node: Line) -> None:
        move = self.world.move(node.to, rapid=not node.speed, speed=node.speed)
        self.make(move, frames.on(self.seen(), node.to))

    def make(self, move: Move, target: Floats, *, by: Floats | None = None, vector: bool = False) -> None:
        """Say a straight motion and make it."""
        if not move.still or not self.world.moves:
            self.say_move(move, target, by=by, vector=vector)
        self.world.add(move)

    def by(self, node: By) -> None:
        to = self.world.here() + node.way
        seen = self.seen()
        move = self.world.move(to, rapid=not node.speed, speed=node.speed)
        self.make(move, frames.on(seen, to), by=seen[:3, :3] @ node.way)

    def arc(self, node: Arc) -> None:
        circle = circle_of(node, self.world.here())
        move = self.world.move(node.to, rapid=False, speed=node.speed, circle=circle)
        seen = self.seen()
        told = circle.seen(seen)
        normal = np.cross(told.u, told.w)
        normal /= np.linalg.norm(normal)
        slot = int(np.argmax(np.abs(normal)))
        stretched = np.linalg.svd(seen[:3, :3])[1]
        if abs(abs(normal[slot]) - 1.0) > 1e-12 or np.ptp(stretched) > 1e-9:
            if self.points_only or self.any_arc(move):
                self.say_arc(move, told, frames.on(seen, node.to), -1, True)
                self.world.add(move)
                return
            raise CannotWriteError("an arc that lies in no plane of the control")
        if not self.arc_fits(slot):
            raise CannotWriteError("an arc in another plane than that of a turn")
        self.say_arc(move, told, frames.on(seen, node.to), NORMAL.index(slot), bool(normal[slot] > 0.0))
        self.world.add(move)

    def arc_fits(self, slot: int) -> bool:
        """Whether arcs across X, Y or Z (0, 1, 2) may stand in the frames that are there."""
        return True

    def any_arc(self, move: Move) -> bool:
        """Whether arcs may lie in any plane."""
        return False

    def turn(self, node: Turn) -> None:
        stands = bool(np.isnan(node.to).any())
        to = self.world.here() if stands else node.to
        move = self.world.move(to, node.rotary, rapid=not node.seconds, seconds=node.seconds)
        if self.mode != self.world.mode:
            raise CannotWriteError("rotary joints that turn in a plane")
        self.make(move, self.here() if stands else frames.on(self.seen(), to), vector=node.vector)

    # States

    def wait(self, node: Dwell) -> None:
        self.say_dwell(node.seconds)
        self.world.dwell(node.seconds)

    def halt(self, node: Stop) -> None:
        self.say_stop()
        self.world.stop()

    def change(self, node: Tool) -> None:
        self.say_tool(node.number)
        if node.number != self.world.tool:
            self.world.tool = node.number
        self.world.stop()

    def offset(self, node: Offset) -> None:
        if self.say_offset(node.name):
            self.said["work offset"] += 1
        else:
            self.expanded["work offset"] += 1
            self.under = self.world.base if self.under is None else self.under
        self.world.offset = node.name

    def home(self, node: Home) -> None:
        world = self.world
        assert world.machine_zero is not None
        joints = world.joints.copy()
        for slot, value in node.to.items():
            joints[slot] = world.machine_zero[slot] + value
        to = frames.on(frames.undo(world.frame), joints - world.home(world.length))
        move = world.move(to, rapid=True)
        if not move.still:
            if self.say_home(node.to):
                self.said["machine coordinates"] += 1
            else:
                self.expanded["machine coordinates"] += 1
                self.say_move(move, frames.on(self.seen(), to))
        world.add(move)

    # Frames and modes

    def framed(self, node: Frame) -> None:
        matrix = matrix_of(node)
        native = self.begin_frame(node, matrix)
        (self.said if native else self.expanded)[node.kind] += 1
        if native:
            self.native.append((node.kind, matrix))
        self.world.layers.append(matrix)
        self.run(node.body)
        self.world.layers.pop()
        if native:
            self.native.pop()
            self.end_frame(node.kind)

    def tip(self, node: Tip) -> None:
        self.enter_tip()
        self.world.mode = TIP
        self.said["tip mode"] += 1
        self.run(node.body)
        self.world.mode = PLAIN
        self.leave_tip()

    def enter_tip(self) -> None:
        self.begin_tip()
        self.mode = TIP

    def leave_tip(self) -> None:
        self.end_tip()
        self.mode, self.under = PLAIN, None

    def plane(self, node: Plane) -> None:
        world = self.world
        normal = self.machine.axis(node.rotary)
        x = np.cross([0.0, 1.0, 0.0], normal)
        upright = np.eye(4)
        upright[:3, :3] = np.column_stack([x / np.linalg.norm(x), np.cross(normal, x / np.linalg.norm(x)), normal])
        matrix = frames.shift(node.at) @ upright @ frames.about(2, node.spin)
        native = self.say_plane_with_turn(node, matrix)
        if native:
            world.mode = TIP if node.follow else PLAIN
            world.add(world.move(world.here(), node.rotary, rapid=True))
            world.mode = PLAIN
            if self.swivel_stops:
                world.stop()
        else:
            self.turn_before(node)
            native = self.begin_plane(node, matrix)
        (self.said if native else self.expanded)["tilted plane"] += 1
        if not native:
            self.enter_tip()
        else:
            self.mode = TILT
        world.mode = TILT
        world.layers.append(matrix)
        self.run(node.body)
        world.layers.pop()
        world.mode = PLAIN
        if native:
            self.end_plane()
            self.mode, self.under = PLAIN, None
        else:
            self.leave_tip()

    def turn_before(self, node: Plane) -> None:
        """The turn to a plane, by words of the rotary joints."""
        if not node.follow:
            self.run([Turn(np.full(3, np.nan), node.rotary, 0.0)])
            return
        self.enter_tip()
        self.world.mode = TIP
        self.run([Turn(self.world.here(), node.rotary, 0.0)])
        self.world.mode = PLAIN
        self.leave_tip()

    # Holes

    def upright(self) -> bool:
        """Whether the model's Z is the control's, with the same unit."""
        seen = self.seen()
        off = max(float(np.abs(part - [0.0, 0.0, 1.0]).max()) for part in (seen[:3, 2], seen[2, :3]))
        return off < 1e-13

    def holes(self, node: Holes) -> None:
        strokes = list(drilled(node, float(self.world.here()[2])))
        if self.upright() and self.say_holes(node):
            self.said[f"cycle {node.kind}"] += 1
            self.follow(strokes)
        else:
            self.expanded[f"cycle {node.kind}"] += 1
            self.run(strokes)

    def follow(self, body: Iterable[Line | Dwell | Stop]) -> None:
        """Make motions that are said already."""
        for node in body:
            if isinstance(node, Line):
                self.world.add(self.world.move(node.to, rapid=not node.speed, speed=node.speed))
            elif isinstance(node, Dwell):
                self.world.dwell(node.seconds)
            else:
                self.world.stop()

    # Flow

    def rendered(self, body: tuple[Node, ...]) -> list[str]:
        """The text of nodes that begin from anywhere, while the model goes through them."""
        lines, whole = self.lines, self.whole
        state = self.rng.bit_generator.state
        self.rng = np.random.default_rng(len(body))
        self.lines, self.whole = [], True
        self.forget()
        self.run(body)
        self.forget()
        text, self.lines, self.whole = self.lines, lines, whole
        self.rng = np.random.default_rng()
        self.rng.bit_generator.state = state
        return text

    def repeat(self, node: Repeat) -> None:
        texts = [self.rendered(node.body) for _ in range(node.times)]
        if all(text == texts[0] for text in texts) and self.say_repeat(node.times, texts[0]):
            self.said["repeat"] += 1
        else:
            self.expanded["repeat"] += 1
            self.lines += [line for text in texts for line in text]
        self.forget()

    def call(self, node: Call) -> None:
        text = self.rendered(node.body)
        if self.say_call(node.name, text):
            self.said["subprogram"] += 1
        else:
            self.expanded["subprogram"] += 1
            self.lines += text
        self.forget()

    def row(self, node: Row) -> None:
        lines = [Line(node.start + k * node.step, node.speed) for k in range(node.times)]
        if bool(np.abs(self.seen() - np.eye(4)).max() < 1e-13) and self.say_row(node):
            self.said["loop"] += 1
            self.follow(lines)
            self.forget()
        else:
            self.expanded["loop"] += 1
            self.run(lines)
