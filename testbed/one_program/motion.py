"""What a program means: where the machine is, and the motions that it makes."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from testbed.one_program import frames
from testbed.one_program.machine import Kinematics
from toolpace.common.arrays import Floats

STILL = 1e-8
"""Motions that are shorter [mm, deg] are none."""
PLAIN, TIP, TILT = "plain", "tip", "tilt"
"""What words are: slides, with the table and the head where they stand; the tip on the part; the tip in a plane on
the part."""


@dataclass(frozen=True)
class Circle:
    """centre + cos(sweep t) u + sin(sweep t) w + t rise."""

    centre: Floats
    u: Floats
    w: Floats
    sweep: float
    rise: Floats

    def at(self, t: float | Floats) -> Floats:
        """A point (3,) at a share of the way, or points (n, 3)."""
        share = np.asarray(t, dtype=float)[..., None]
        angle = self.sweep * share
        return np.asarray(self.centre + np.cos(angle) * self.u + np.sin(angle) * self.w + share * self.rise)

    def seen(self, frame: Floats) -> Circle:
        """The same in what a frame stands in."""
        turned = frame[:3, :3]
        return Circle(frames.on(frame, self.centre), turned @ self.u, turned @ self.w, self.sweep, turned @ self.rise)

    @property
    def length(self) -> float:
        """[mm]."""
        return float(np.hypot(np.linalg.norm(self.u) * self.sweep, np.linalg.norm(self.rise)))


@dataclass
class Move:
    """One motion; X, Y, Z are slides (from where the tip is at the part's origin) or the tip on the part."""

    world: World
    slides: bool
    start: Floats
    end: Floats
    rotary: tuple[Floats, Floats]
    """Before and behind [deg]."""
    length_of_tool: float
    tool: str
    rapid: bool
    seconds: float = 0.0
    circle: Circle | None = None
    stop: bool = False
    dwell: float = 0.0

    @property
    def turns(self) -> bool:
        """Whether rotary joints move."""
        return bool(np.abs(self.rotary[1] - self.rotary[0]).max() > STILL)

    @property
    def still(self) -> bool:
        """Whether nothing moves."""
        return not self.turns and self.circle is None and bool(np.abs(self.end - self.start).max() <= STILL)

    @property
    def length(self) -> float:
        """Of the way of X, Y, Z [mm]."""
        return self.circle.length if self.circle else float(np.linalg.norm(self.end - self.start))

    def pose(self, t: float | Floats) -> tuple[Floats, Floats, Floats]:
        """Tip, tool axis (3,) and rotary joints (2,) [deg] at a share of the way; or as many of each (n, ...)."""
        share = np.asarray(t, dtype=float)[..., None]
        place = self.circle.at(t) if self.circle else self.start + share * (self.end - self.start)
        turned = share * (self.rotary[1] - self.rotary[0])
        rotary = self.rotary[0] + turned if self.turns else self.rotary[1]
        machine = self.world.machine
        if self.slides:
            place = machine.tip(place + self.world.home(self.length_of_tool), rotary, self.length_of_tool)
        return place, machine.axis(rotary), rotary


@dataclass
class World:
    """The machine in the middle of a program."""

    machine: Kinematics
    offsets: dict[str, Floats]
    """Origins on the part of work offsets (3,) at zero rotary joints."""
    tools: dict[str, float]
    """Lengths."""
    machine_zero: Floats | None = None
    """Joints at which machine coordinates are zero; None where there is no set-up sheet."""
    offset: str = ""
    tool: str = ""
    mode: str = PLAIN
    layers: list[Floats] = field(default_factory=list)
    """Frames (4, 4), each in the one before."""
    joints: Floats = field(default_factory=lambda: np.zeros(3))
    rotary: Floats = field(default_factory=lambda: np.zeros(2))
    moves: list[Move] = field(default_factory=list)
    homes: dict[float, Floats] = field(default_factory=dict)

    @property
    def length(self) -> float:
        """Of the tool at hand."""
        return self.tools.get(self.tool, self.machine.own_length)

    def home(self, length: float) -> Floats:
        """Slides (3,) at which the tip is in the part's origin, rotary joints at zero."""
        if length not in self.homes:
            self.homes[length] = self.machine.linear(np.zeros(3), np.zeros(2), length)
        return self.homes[length]

    @property
    def base(self) -> Floats:
        """The work offset (4, 4)."""
        return frames.shift(self.offsets.get(self.offset, np.zeros(3)))

    @property
    def frame(self) -> Floats:
        """Program coordinates (4, 4) in the space of the mode."""
        made = self.base
        for layer in self.layers:
            made = made @ layer
        return made

    def place(self) -> Floats:
        """X, Y, Z (3,) in the space of the mode."""
        if self.mode == PLAIN:
            return self.joints - self.home(self.length)
        return self.machine.tip(self.joints, self.rotary, self.length)

    def here(self) -> Floats:
        """X, Y, Z (3,) in the program's coordinates."""
        return frames.on(frames.undo(self.frame), self.place())

    def move(
        self,
        target: Floats,
        rotary: Floats | None = None,
        *,
        rapid: bool,
        speed: float = 0.0,
        seconds: float = 0.0,
        circle: Circle | None = None,
    ) -> Move:
        """The motion to program coordinates (3,), which `add` then makes; speed [mm/min], or seconds in all."""
        wanted = self.rotary if rotary is None else np.asarray(rotary, dtype=float)
        end = frames.on(self.frame, np.asarray(target, dtype=float))
        seen = circle.seen(self.frame) if circle else None
        made = Move(
            self,
            self.mode == PLAIN,
            self.place(),
            end,
            (self.rotary, wanted),
            self.length,
            self.tool,
            rapid,
            circle=seen,
        )
        if not rapid:
            made.seconds = seconds or made.length * 60.0 / speed
        return made

    def add(self, move: Move) -> None:
        """Make a motion."""
        tip, _, rotary = move.pose(1.0)
        self.joints, self.rotary = self.machine.linear(tip, rotary, self.length), rotary
        if not move.still or not self.moves:
            self.moves.append(move)

    def stop(self) -> None:
        """Come to rest."""
        if self.moves:
            self.moves[-1].stop = True

    def dwell(self, seconds: float) -> None:
        """Wait."""
        self.stop()
        self.moves[-1].dwell += seconds
