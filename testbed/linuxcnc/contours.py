"""Random contours under cutter compensation for LinuxCNC: inside and outside corners, arcs, gouges, entries and exits.

Lines have no number: what waits for its corner is printed by the interpreter under the number of a later block.
"""

from __future__ import annotations

import cmath
import math
from random import Random

from testbed.linuxcnc.job import Job

PLANES = {"G17": ("X", "Y", "Z", "I", "J"), "G18": ("Z", "X", "Y", "K", "I")}
"""First and second axis, the normal, and the words of the centre; compensation is in these planes alone."""
BESIDE = (
    "M3 S900", "M8", "M9", "G4 P.5", "(said)", "F700", "S800", "G90.1", "G91.1", "#1=3", "G94 F500", "M0",
)  # fmt: skip
"""Blocks between the elements of a contour, nearly all allowed there."""
FORBIDDEN = (
    "G55", "G92 X0", "G61", "G64", "G21", "G43 H1", "G49", "T2 M6", "G28", "G53 G0 X1", "G98", "G81 X1 Y1 Z-2 R1",
    "G41 D1", "G42 D2", "G10 L2 P1 X1", "M48", "M62 P1", "G17 G1 X3 Y2", "G19", "G52 X1", "M66 P0 L0",
    "G5 X1 Y1 I1 J1 P1 Q1", "G10 L2 P5 X4", "G18",
)  # fmt: skip
"""Blocks that the interpreter refuses under compensation, most of them."""


class Contour:
    """Writes one program."""

    def __init__(self, seed: int) -> None:
        self.random = Random(seed)
        self.lines: list[str] = []
        self.inch = self.random.random() < 0.25
        self.absolute, self.centre_absolute = True, False
        self.plane = "G18" if self.random.random() < 0.3 else "G17"
        self.scale = 25.4 if self.inch else 1.0
        self.digits = 4 if self.inch else 3
        self.at, self.height = 0j, 0.0
        self.inverse = False

    def chance(self, share: float) -> bool:
        return self.random.random() < share

    def number(self, value: float) -> str:
        return f"{value / self.scale:.{self.digits}f}"

    def apart(self, height: float) -> float:
        """A height that is another one, also as it is printed."""
        return height if abs(height - self.height) > 0.1 else height + 1.0

    def to(self, point: complex, height: float | None = None) -> list[str]:
        """Words to a point of the plane; the writer is there, as rounded, then."""
        first, second, normal, _, _ = PLANES[self.plane]
        words = []
        base = 0j if self.absolute else self.at
        reached = []
        for letter, value, old, start in (
            (first, point.real, self.at.real, base.real), (second, point.imag, self.at.imag, base.imag),
        ):  # fmt: skip
            text = self.number(value - start)
            new = float(text) * self.scale + start
            if abs(value - old) < 1e-9 and self.chance(0.5):
                new = old
            else:
                words.append(letter + text)
            reached.append(new)
        self.at = complex(reached[0], reached[1])
        if height is not None:
            base_height = 0.0 if self.absolute else self.height
            text = self.number(height - base_height)
            self.height = float(text) * self.scale + base_height
            words.append(normal + text)
        return words

    def feed(self) -> str:
        if self.inverse:
            return f"F{self.random.uniform(2, 40):.1f}"
        return f"F{self.random.uniform(100, 2000) / self.scale:.1f}" if self.chance(0.15) else ""

    def line(self, point: complex, *, rapid: float = 0.1, rise: float = 0.06) -> None:
        height = self.apart(self.random.uniform(-8, 8)) if self.chance(rise) else None
        turned = f"A{self.random.uniform(-40, 40):.2f}" if self.chance(0.02) else ""
        word = "G0" if self.chance(rapid) else "G1"
        self.put(word, *self.to(point, height), turned, self.feed() if word == "G1" else "")

    def arc(self, centre: complex, sweep: float) -> None:
        """An arc about a centre [mm] from where the writer is."""
        i, j = PLANES[self.plane][3:]
        start = self.at
        end = centre + (start - centre) * cmath.exp(1j * sweep)
        word = "G3" if sweep > 0 else "G2"
        height = self.random.uniform(-8, 8) if self.chance(0.06) else None
        words = self.to(end, height)
        radius = abs(start - centre)
        whole = abs(abs(sweep) - 2 * math.pi) < 1e-9
        if self.chance(0.3) and not whole and abs(sweep) < 5.5 and not 3.0 < abs(sweep) < 3.3:
            words.append(f"R{self.number(radius if abs(sweep) < math.pi else -radius)}")
        else:
            base = 0j if self.centre_absolute else start
            words += [i + self.number((centre - base).real), j + self.number((centre - base).imag)]
        if self.chance(0.03):
            words.append("P2")
        self.put(word, *words, self.feed())

    def put(self, *words: str) -> None:
        self.lines.append(" ".join(word for word in words if word))

    def beside(self) -> None:
        """What stands between elements and moves nothing in the plane."""
        if self.chance(0.5):
            normal = PLANES[self.plane][2]
            for _ in range(self.random.choice([1, 2, 2])):
                height = self.apart(self.random.uniform(-8, 8))
                text = self.number(height - (0.0 if self.absolute else self.height))
                self.height = float(text) * self.scale + (0.0 if self.absolute else self.height)
                self.put(self.random.choice(["G0", "G1"]), normal + text, self.feed() if self.inverse else "")
                if self.inverse and self.lines[-1].startswith("G0"):
                    self.lines[-1] = self.lines[-1].split(" F")[0]
            return
        block = self.random.choice(BESIDE[:-1]) if self.chance(0.97) else BESIDE[-1]
        if self.inverse and "F" in block:
            return
        if block in ("G90.1", "G91.1"):
            self.centre_absolute = block == "G90.1"
        self.put(block)

    def distance(self) -> None:
        self.absolute = not self.absolute
        self.put("G90" if self.absolute else "G91")


def contour(writer: Contour, radius: float) -> None:
    """One contour: entry, elements, exit."""
    random = writer.random
    side = random.choice(["G41", "G42"])
    if not writer.absolute:
        writer.distance()
    begin = complex(random.uniform(-30, 30), random.uniform(-30, 30))
    writer.put("G0", *writer.to(begin, random.uniform(-5, 5)))
    kind = random.random()
    if kind < 0.5:
        word = f"{side} D{random.choice([1, 1, 1, 2])}"
    elif kind < 0.75:
        word = f"{side}.1 D{writer.number(2 * radius)}"
    else:
        word = f"{side} D0" if random.random() < 0.3 else side
    same_block = writer.chance(0.3)
    if not same_block:
        writer.put(word)
    # how large the elements are beside the tool: gouges, or none
    size = random.choice([1.2, 3.0, 3.0, 8.0]) * radius
    heading = random.uniform(-math.pi, math.pi)
    entry = writer.at + cmath.rect(radius * random.choice([0.8, 1.5, 2.0, 3.0, 3.0, 3.0, 4.0, 6.0, 6.0, 9.0]), heading)
    if writer.chance(0.12):
        centre = (writer.at + entry) / 2 + (entry - writer.at) * 1j * random.uniform(-1, 1)
        sweep = cmath.phase((entry - centre) / (writer.at - centre))
        writer.arc(centre, sweep if writer.chance(0.8) else sweep - math.copysign(2 * math.pi, sweep))
    else:
        writer.line(entry, rapid=0.3)
    if same_block:
        writer.lines[-1] = f"{word} {writer.lines[-1]}" if " D" not in writer.lines[-1] else writer.lines[-1]
    gentle = writer.chance(0.6)
    for _ in range(random.randint(1, 7)):
        if writer.chance(0.2):
            writer.beside()
        if writer.chance(0.05):
            writer.distance()
        most = 1.2 if gentle else math.pi
        turned = random.uniform(-most, most)
        if writer.chance(0.25):
            turned = random.choice([0.0, 0.0, math.pi / 2, -math.pi / 2, math.pi, 0.03, -0.03, 0.06, -0.06, 2.2, -2.2])
        heading += turned
        length = size * random.uniform(0.3, 3.0)
        if writer.chance(0.55):
            writer.line(writer.at + cmath.rect(length, heading))
        else:
            sense = random.choice([-1, 1])
            centre = writer.at + cmath.rect(length, heading + sense * math.pi / 2)
            sweep = sense * random.choice([random.uniform(0.1, 3), random.uniform(0.1, 6.1), math.pi / 2, 2 * math.pi])
            writer.arc(centre, sweep)
            heading += sweep
    if writer.chance(0.04):
        writer.put(random.choice(FORBIDDEN))
    _leave(writer, heading, size)


def _leave(writer: Contour, heading: float, size: float) -> None:
    random = writer.random
    if writer.chance(0.2):
        writer.beside()
    kind = random.random()
    goal = writer.at + cmath.rect(size * 2, heading + random.uniform(-2, 2))
    if kind < 0.05:
        return  # the program ends, or the next contour is refused
    if kind < 0.5:
        writer.put("G40")
        if writer.chance(0.15):
            writer.put(random.choice(["G49", "G55", "G54", "G92.1", "T1 M6", "G53 G0 Y3", "G28 Z1", "G41 D1"]))
        writer.line(goal, rapid=0.5)
    elif kind < 0.97:
        writer.line(goal, rapid=0.5)
        writer.lines[-1] = f"G40 {writer.lines[-1]}"
    else:
        writer.put("G40")
        writer.arc(writer.at + cmath.rect(size, heading), 1.0)


def random_contour(seed: int) -> Job:
    """A program of one or two contours, with its table of tools."""
    writer = Contour(seed)
    random = writer.random
    radius = round(random.uniform(0.5, 6.0), 3)
    writer.put("G20" if writer.inch else "G21", "G90 G94 G91.1", writer.plane, f"F{600 / writer.scale:.1f} M3 S1000")
    if writer.chance(0.2):
        writer.put("G54" if writer.chance(0.5) else "G10 L2 P1 X3 Y-2 R20")
    writer.put(random.choice(["T1 M6", "T1 M6", "T2 M6", ""]))
    if writer.chance(0.08):
        writer.inverse = True
        writer.put("G93")
    for _ in range(random.choice([1, 1, 1, 2])):
        contour(writer, radius)
        if not writer.inverse and writer.chance(0.1):
            writer.put("F500")
    writer.put("M2")
    return Job("\n".join(writer.lines) + "\n", tools={1: 50.0, 2: 30.0}, radii={1: radius, 2: round(radius * 0.7, 3)})
