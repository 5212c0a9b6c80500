"""What a program of LinuxCNC means by its manual, to the last digit: a second reading, which decides for itself.

`rs274` prints four decimals and leaves arcs to the machine: whether an arc is a whole circle or none it does not tell.
Here it is decided as "G-Codes" and "Coordinate System" have it, and arcs as the machine's `pmCircleInit` does it.
Blocks of words alone are read: lines, arcs, planes, units, distances, work offsets with rotation, G92, G52, lengths,
G53, G28.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field

import numpy as np

from testbed.linuxcnc.canon import INCH, Judged, Motion
from testbed.linuxcnc.job import OFFSETS, Job
from toolpace.common.arrays import Floats

LETTERS = "XYZABC"
EXACT = 1e-3
"""The unit [mm] of places that are not printed: the comparison then looks 0.3 nm close."""
ONE_POINT = 1e-8
"""pmCircleInit's CART_FUZZ: ends so close [mm], or turned so little [mm2], make a whole circle."""
PLANES = {"G17": (0, 1, 2), "G18": (2, 0, 1), "G19": (1, 2, 0)}
"""First and second axis, and the normal."""
_WORD = re.compile(r"([A-Z])([-+]?[0-9.]+)")
MOTIONS = ("G0", "G1", "G2", "G3")


class ErrorOfManualError(Exception):
    """What the manual calls an error."""


@dataclass
class Offset:
    """A work offset."""

    origin: Floats = field(default_factory=lambda: np.zeros(6))
    turn: float = 0.0
    """R [deg]."""


class SecondReading:
    """A machine that has read some blocks; lengths in mm, angles in degrees."""

    def __init__(self, job: Job) -> None:
        self.offsets = {name: Offset(_place(job.offsets.get(name, {}))) for name in OFFSETS}
        self.references = {"G28": _place(job.references.get(1, {})), "G30": _place(job.references.get(2, {}))}
        self.tools = job.tools
        self.at = np.zeros(6)
        """The machine's place."""
        self.system, self.plane, self.motion = "G54", "G17", ""
        self.unit, self.absolute, self.centre_absolute = 1.0, True, False
        self.shift, self.suspended = np.zeros(6), np.zeros(6)
        self.tool = np.zeros(6)
        self.feed = 0.0
        self.motions: list[Motion] = []

    # Places: machine = turn (words + G92) + origin + tool

    def machine(self, words: Floats) -> Floats:
        moved = words + self.shift
        moved[:2] = turned(moved[:2], self.offsets[self.system].turn)
        return np.asarray(moved + self.offsets[self.system].origin + self.tool)

    def words(self) -> Floats:
        """The place at hand in the program's coordinates."""
        found = self.at - self.tool - self.offsets[self.system].origin
        found[:2] = turned(found[:2], -self.offsets[self.system].turn)
        return np.asarray(found - self.shift)

    # Blocks

    def block(self, text: str) -> None:
        """Execute a block. Raises ErrorOfManualError."""
        found = _WORD.findall(text)
        codes = [letter + f"{float(number):g}" for letter, number in found if letter in "GM"]
        words = {letter: float(number) for letter, number in found if letter not in "GMN"}
        if "F" in words:
            self.feed = words["F"] * self.unit
        for code in codes:
            self.mode(code, words)
        axes = {slot: words[letter] * self.scale(slot) for slot, letter in enumerate(LETTERS) if letter in words}
        for code in codes:
            if self.special(code, words, axes):
                return
        self.motion = next((code for code in codes if code in MOTIONS), self.motion)
        circle = self.motion in ("G2", "G3") and words.keys() & set("IJKR")
        if "G53" in codes:
            target = self.at.copy()
            for slot, value in axes.items():
                target[slot] = value
            self.go(target, rapid=self.motion == "G0")
        elif circle or (axes and "G43.1" not in codes):
            target = self.target(axes)
            if circle:
                self.arc(words, target)
            else:
                self.go(self.machine(target), rapid=self.motion == "G0")

    def mode(self, code: str, words: dict[str, float]) -> None:
        if code in ("G20", "G21"):
            self.unit = INCH if code == "G20" else 1.0
        elif code in PLANES:
            self.plane = code
        elif code in OFFSETS:
            self.system = code
        elif code in ("G90", "G91"):
            self.absolute = code == "G90"
        elif code in ("G90.1", "G91.1"):
            self.centre_absolute = code == "G90.1"
        elif code == "G43":
            self.tool = np.zeros(6)
            self.tool[2] = self.tools[int(words["H"])]
        elif code == "G49":
            self.tool = np.zeros(6)

    def special(self, code: str, words: dict[str, float], axes: dict[int, float]) -> bool:
        """What takes the axes of a block for something other than its motion."""
        if code == "G43.1":
            for slot, value in axes.items():
                self.tool[slot] = value
        elif code == "G10":
            name = self.system if not words["P"] else OFFSETS[int(words["P"]) - 1]
            self.set_offset(name, axes, words.get("R"), by_place=words["L"] == 20)
        elif code == "G92":
            here = self.words()
            for slot, value in axes.items():
                self.shift[slot] += here[slot] - value
            self.suspended = self.shift.copy()
        elif code == "G52":
            for slot, value in axes.items():
                self.shift[slot] = value
            self.suspended = self.shift.copy()
        elif code in ("G92.1", "G92.2", "G92.3"):
            self.suspended = np.zeros(6) if code == "G92.1" else self.suspended
            self.shift = self.suspended.copy() if code == "G92.3" else np.zeros(6)
        elif code in self.references:
            if axes:
                self.go(self.machine(self.target(axes)), rapid=True)
            last = self.at.copy()
            for slot in axes or range(6):
                last[slot] = self.references[code][slot]
            self.go(last, rapid=True)
        else:
            return False
        return True

    def set_offset(self, name: str, axes: dict[int, float], turn: float | None, *, by_place: bool) -> None:
        """G10 L2, and G10 L20: the place at hand has these words then."""
        offset = self.offsets[name]
        offset.turn = offset.turn if turn is None else turn
        if by_place:
            words = np.zeros(6)
            for slot, value in axes.items():
                words[slot] = value
            words += self.shift
            words[:2] = turned(words[:2], offset.turn)
            axes = {slot: float((self.at - self.tool - words)[slot]) for slot in axes}
        for slot, value in axes.items():
            offset.origin[slot] = value

    # Motions

    def scale(self, slot: int) -> float:
        return self.unit if slot < 3 else 1.0

    def target(self, axes: dict[int, float]) -> Floats:
        here = self.words()
        for slot, value in axes.items():
            here[slot] = value if self.absolute else here[slot] + value
        return here

    def go(self, end: Floats, *, rapid: bool) -> None:
        rate = math.inf if rapid else self.rate()
        self.motions.append(Motion(0, rapid, self.at, end, EXACT, rate, rate / self.unit))
        self.at = end

    def rate(self) -> float:
        if not self.feed:
            raise ErrorOfManualError("no feed rate")
        return self.feed

    def arc(self, words: dict[str, float], target: Floats) -> None:
        first, second, normal = PLANES[self.plane]
        here = self.words()
        rate = self.rate()
        start, end = here[[first, second]], target[[first, second]]
        left = self.motion == "G3"
        if "R" in words:
            centre = centre_by_radius(start, end, words["R"] * self.unit, left)
        else:
            given = np.array([words.get("IJK"[slot], 0.0) for slot in (first, second)]) * self.unit
            centre = given if self.centre_absolute else start + given
        a, b = start - centre, end - centre
        if "R" not in words:
            refuse_radii(float(np.linalg.norm(a)) / self.unit, float(np.linalg.norm(b)) / self.unit, self.unit)
        sweep = sweep_of(a, b, left) + (1 if left else -1) * 2.0 * math.pi * (words.get("P", 1.0) - 1.0)
        middle, axis = here.copy(), np.zeros(3)
        middle[first], middle[second] = centre
        axis[normal] = 1.0
        axis[:2] = turned(axis[:2], self.offsets[self.system].turn)
        before, self.at = self.at, self.machine(target)
        place = self.machine(middle)[:3]
        self.motions.append(
            Motion(0, False, before, self.at, EXACT, rate, rate / self.unit, normal, tuple(axis), tuple(place), sweep)
        )

    def judged(self, text: str) -> Judged:
        """The motions of a whole program, up to what the manual calls an error."""
        try:
            for line in text.splitlines():
                self.block(line)
        except ErrorOfManualError as error:
            return Judged(self.motions, 0.0, str(error), exact=True)
        return Judged(self.motions, 0.0, "", exact=True)


def turned(place: Floats, angle: float) -> Floats:
    """X and Y, turned by an angle [deg]."""
    c, s = math.cos(math.radians(angle)), math.sin(math.radians(angle))
    return np.array([c * place[0] - s * place[1], s * place[0] + c * place[1]])


def sweep_of(a: Floats, b: Floats, left: bool) -> float:
    """Angle [rad] from spoke a to spoke b (2,), below zero to the right: a whole turn where they are on one ray."""
    way = 1.0 if left else -1.0
    b = b * np.linalg.norm(a) / np.linalg.norm(b)
    side = way * float(a[0] * b[1] - a[1] * b[0])
    angle = math.acos(max(-1.0, min(1.0, float(a @ b) / float(a @ a))))
    # the arc cosine loses half the digits of small angles
    angle = math.asin(min(1.0, abs(side) / float(a @ a))) if angle < 1e-3 else angle
    return way * (angle if side >= ONE_POINT else 2.0 * math.pi - angle)


def refuse_radii(first: float, last: float, unit: float) -> None:
    """Raise ErrorOfManualError where the radii at both ends of an arc differ by too much; in units of the program."""
    most, off = math.sqrt(2.0) * (0.002 if unit == INCH else 0.02), abs(last - first)
    if off > 100.0 * most or (off > most and off > 1e-3 * max(first, last)):
        raise ErrorOfManualError("the radius to the end of the arc differs from that to its start")


def centre_by_radius(start: Floats, end: Floats, radius: float, left: bool) -> Floats:
    """Of the two centres (2,) that far from both ends: the nearer way round for R above zero, the longer below."""
    chord = end - start
    length = float(np.linalg.norm(chord))
    if length < 1e-6:
        raise ErrorOfManualError("R, and the end is the start")
    half = length / 2.0
    high = math.sqrt(max(radius * radius - half * half, 0.0))
    left_of = np.array([-chord[1], chord[0]]) / length
    return np.asarray((start + end) / 2.0 + left_of * high * (1.0 if left == (radius > 0.0) else -1.0))


def _place(named: dict[str, float]) -> Floats:
    return np.array([named.get(letter, 0.0) for letter in LETTERS])


def by_manual(job: Job) -> Judged:
    """The motions of a program, each to the last digit. `error` where the manual calls a block an error."""
    return SecondReading(job).judged(job.text)
