"""Canonical calls of LinuxCNC's interpreter, as its command `rs274` prints them, as motions in machine coordinates.

What it prints: positions in the coordinates of the program, four decimals, in the unit in force; offsets and
rotation each time that they change. Its canon adds them in this order (LinuxCNC, src/emc/task/emccanon.cc,
`rotate_and_offset_pos`): G92, rotation about Z, work offset, tool.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from toolpace.common.arrays import Floats

INCH = 25.4
"""[mm]"""
LINE_PRINT = re.compile(r"\s*\d+\s+N([0-9.]+)\s*([A-Z_][A-Z_0-9]*)\((.*)\)\s*$")
_NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+|nan|inf)(?:[eE][-+]?\d+)?")
_NORMALS = {"XY": 2, "XZ": 1, "YZ": 0}
UNSAID = ("NURBS_FEED", "NURBS_G5_FEED", "NURBS_G6_FEED", "STRAIGHT_PROBE", "RIGID_TAP")
"""Motions of which the print does not tell the way: splines (only how many points they have), probes."""


@dataclass(frozen=True)
class Motion:
    """A straight way or an arc to `end`; `normal` is of X, Y, Z, or -1 where it is straight."""

    line: int
    """N word of its block; 0 where it has none."""
    rapid: bool
    start: Floats
    """(6,) X Y Z [mm] A B C [deg], of the machine."""
    end: Floats
    unit: float
    """Of the printed decimals [mm]."""
    rate: float = math.inf
    """F [mm/min]."""
    turn: float = math.inf
    """The same of a rotation in place [deg/min]."""
    normal: int = -1
    axis: tuple[float, float, float] = (0.0, 0.0, 1.0)
    centre: tuple[float, float, float] = (0.0, 0.0, 0.0)
    sweep: float = 0.0
    """[rad], about `axis`."""
    waited: float = 0.0
    """Dwells before it, since the beginning of the program [s]."""

    def otherwise(self, near: float) -> Motion | None:
        """The other motion that an arc may be, whose ends lie within `near` [mm] of one ray as they are printed.

        A whole turn more or less; without one, the straight way. None where the ends tell: ends that are printed alike
        are one.
        """
        axis, way = np.array(self.axis), (self.end - self.start)[:3]
        if np.linalg.norm(way - (way @ axis) * axis) < 1e-9:
            return None
        whole = math.copysign(2.0 * math.pi, self.sweep)
        rest = math.remainder(self.sweep, whole)
        if self.normal < 0 or abs(rest) * self.radius() > near:
            return None
        if rest * whole > 0.0:  # beyond whole turns, or none: one more
            return replace(self, sweep=self.sweep + whole)
        return replace(self, sweep=self.sweep - whole) if abs(self.sweep) > 9.0 else replace(self, normal=-1)

    def length(self) -> float:
        """Of X, Y, Z [mm]; where none moves, of the rotary axes [deg]."""
        way = self.end - self.start
        if self.normal >= 0:
            first, last = self.radius(), self.radius(at_end=True)
            return math.hypot(0.5 * (first + last) * self.sweep, last - first, float(way[:3] @ np.array(self.axis)))
        return float(np.linalg.norm(way[:3])) if self.travels() else float(np.linalg.norm(way[3:]))

    def radius(self, at_end: bool = False) -> float:
        """Of an arc, at its start or its end [mm]."""
        axis, spoke = np.array(self.axis), (self.end if at_end else self.start)[:3] - np.array(self.centre)
        return float(np.linalg.norm(spoke - (spoke @ axis) * axis))

    def travels(self) -> bool:
        """Whether one of X, Y, Z moves."""
        return self.normal >= 0 or float(np.abs((self.end - self.start)[:3]).max()) > 2e-4 * self.unit

    def seconds(self) -> float:
        """Its time at the programmed feed; zero for a rapid."""
        return 0.0 if self.rapid else 60.0 * self.length() / (self.rate if self.travels() else self.turn)


@dataclass(frozen=True)
class Judged:
    """What the interpreter made of a program."""

    motions: list[Motion]
    waited: float
    """All dwells [s]."""
    error: str
    """Its refusal; empty where it read the program to its end."""
    exact: bool = False
    """Whether places are told to the last digit; else to four decimals, which hide whether an arc is a whole turn."""


@dataclass
class _Canon:
    """State of the canonical machine; lengths in mm."""

    unit: float = 1.0
    words: Floats = field(default_factory=lambda: np.zeros(6))
    """Position (6,) in the coordinates of the program, as printed last, [mm, deg]."""
    shift: Floats = field(default_factory=lambda: np.zeros(6))
    offset: Floats = field(default_factory=lambda: np.zeros(6))
    tool: Floats = field(default_factory=lambda: np.zeros(6))
    turned: float = 0.0
    rate: float = 0.0
    turn: float = 0.0
    per_turn: bool = False
    spindle: float = 0.0
    plane: str = "XY"
    waited: float = 0.0
    ended: bool = False
    motions: list[Motion] = field(default_factory=list)
    place: Floats = field(default_factory=lambda: np.zeros(6))
    """Where the machine is (6,)."""
    coarsest: float = 1.0
    """Of the units so far: places and offsets that were printed in it keep its rounding."""

    def scaled(self, values: list[float]) -> Floats:
        return np.array(values) * np.array([self.unit] * 3 + [1.0] * 3)

    def machine(self, words: Floats) -> Floats:
        moved = words + self.shift
        moved[:3] = self.rotated(moved[:3])
        found: Floats = moved + self.offset + self.tool
        return found

    def rotated(self, vector: Floats) -> Floats:
        c, s = math.cos(math.radians(self.turned)), math.sin(math.radians(self.turned))
        return np.array([c * vector[0] - s * vector[1], s * vector[0] + c * vector[1], vector[2]])

    def feed(self, values: list[float]) -> None:
        self.rate, self.turn = values[0] * self.unit, values[0]

    def speeds(self) -> tuple[float, float]:
        times = self.spindle if self.per_turn else 1.0
        return self.rate * times, self.turn * times

    # Calls

    def straight(self, line: int, values: list[float], *, rapid: bool) -> None:
        self.words = self.scaled(values[:6])
        end = self.machine(self.words)
        speeds = (math.inf, math.inf) if rapid else self.speeds()
        self.motions.append(Motion(line, rapid, self.place, end, self.coarsest, *speeds, waited=self.waited))
        self.place = end

    def arc(self, line: int, values: list[float]) -> None:
        first, second, centre1, centre2, turns, along, *rotary = values
        normal = _NORMALS[self.plane]
        slots = ((1, 2), (2, 0), (0, 1))[normal]
        end, centre = [0.0] * 3, [0.0] * 3
        end[slots[0]], end[slots[1]], end[normal] = first, second, along
        centre[slots[0]], centre[slots[1]] = centre1, centre2
        self.words = self.scaled([*end, *rotary])
        about = np.concatenate([np.array(centre) * self.unit, np.zeros(3)])
        axis = np.zeros(3)
        axis[normal] = 1.0
        axis = self.rotated(axis)
        middle, target = self.machine(about)[:3], self.machine(self.words)
        sweep = _sweep(self.place[:3] - middle, target[:3] - middle, axis, int(turns), self.unit)
        self.motions.append(
            Motion(
                line, False, self.place, target, self.coarsest, *self.speeds(), normal,
                tuple(axis.tolist()), tuple(middle.tolist()), sweep, self.waited,
            )
        )  # fmt: skip
        self.place = target

    def g5x(self, values: list[float]) -> None:
        self.offset = self.scaled(values[1:7])

    def g92(self, values: list[float]) -> None:
        self.shift = self.scaled(values[:6])

    def tool_offset(self, values: list[float]) -> None:
        self.tool = self.scaled(values[:6])

    def rotation(self, values: list[float]) -> None:
        self.turned = values[0]

    def units(self, text: str) -> None:
        self.unit = INCH if "INCHES" in text else 1.0
        self.coarsest = max(self.coarsest, self.unit)

    def dwell(self, values: list[float]) -> None:
        self.waited += values[0]


def _sweep(a: Floats, b: Floats, axis: Floats, turns: int, unit: float) -> float:
    """Angle from spoke a to spoke b about an axis: `turns` is 1 for the first turn on the left, -1 on the right.

    Spokes on one ray are the ends of a full circle, however long each is (LinuxCNC's pmCircleInit).
    """
    a, b = a - (a @ axis) * axis, b - (b @ axis) * axis
    angle = math.atan2(float(np.cross(a, b) @ axis), float(a @ b))
    near = abs(angle) * float(np.linalg.norm(a)) < 3e-4 * unit
    if turns > 0:
        angle = 0.0 if near else angle % (2 * math.pi)
        whole = turns if near else turns - 1
        return angle + 2 * math.pi * whole
    angle = 0.0 if near else -(-angle % (2 * math.pi))
    whole = turns if near else turns + 1
    return angle + 2 * math.pi * whole


def read_calls(text: str, error: str = "") -> Judged:
    """Motions of a printed list of canonical calls."""
    canon = _Canon()
    calls: dict[str, Callable[[int, list[float]], None]] = {
        "STRAIGHT_TRAVERSE": lambda line, values: canon.straight(line, values, rapid=True),
        "STRAIGHT_FEED": lambda line, values: canon.straight(line, values, rapid=False),
        "ARC_FEED": canon.arc,
        "SET_G5X_OFFSET": lambda line, values: canon.g5x(values),
        "SET_G92_OFFSET": lambda line, values: canon.g92(values),
        "USE_TOOL_LENGTH_OFFSET": lambda line, values: canon.tool_offset(values),
        "SET_XY_ROTATION": lambda line, values: canon.rotation(values),
        "DWELL": lambda line, values: canon.dwell(values),
        "SET_FEED_RATE": lambda line, values: canon.feed(values),
        "SET_FEED_MODE": lambda line, values: setattr(canon, "per_turn", values[-1] == 1.0),
        "SET_SPINDLE_SPEED": lambda line, values: setattr(canon, "spindle", abs(values[-1])),
        "PROGRAM_END": lambda line, values: setattr(canon, "ended", True),
    }
    for row in text.splitlines():
        match = LINE_PRINT.match(row)
        if match is None or canon.ended:
            continue
        number, name, inside = match.groups()
        if name in UNSAID:
            raise ValueError(f"{name}: `rs274` does not print where it goes")
        if name == "USE_LENGTH_UNITS":
            canon.units(inside)
        elif name == "SELECT_PLANE":
            canon.plane = inside[-2:]
        elif name in calls:
            line = int(number) if number.isdigit() else 0
            calls[name](line, [float(value) for value in _NUMBER.findall(inside)])
    return Judged(canon.motions, canon.waited, error)
