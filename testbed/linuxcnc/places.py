"""Random programs of lines and arcs of all forms, whole circles and nearly so, under shifts and turns."""

from __future__ import annotations

import math
import random

from testbed.linuxcnc.job import OFFSETS, Job

CENTRES = {17: ("XY", "IJ"), 18: ("ZX", "KI"), 19: ("YZ", "JK")}


class Places:
    """The program while it is written."""

    def __init__(self, seed: int) -> None:
        self.random = random.Random(seed)
        self.lines: list[str] = []
        self.plane, self.inch, self.turns = 17, False, self.random.random() < 0.5
        """turns: whether offsets are turned, and then shifted by none of G92 and G52."""

    def number(self, most: float = 40.0) -> float:
        return round(self.random.uniform(-most, most) / (20.0 if self.inch else 1.0), self.random.randint(0, 4))

    def place(self, letters: str = "XYZ") -> str:
        named = [letter for letter in letters if self.random.random() < 0.6] or [letters[0]]
        return " ".join(f"{letter}{self.number():g}" for letter in named)

    def line(self) -> None:
        turned = f" {self.random.choice('AC')}{self.number():g}" if self.random.random() < 0.2 else ""
        self.lines.append(f"G{self.random.randint(0, 1)} {self.place()}{turned}")

    def arc(self) -> None:
        """A start, and an arc from it that is written with some digits, and may miss its circle a little."""
        choose, unit = self.random.choice, 0.05 if self.inch else 1.0
        (first, second), (i, j) = CENTRES[self.plane]
        angle = math.radians(choose([0, 90, 180, 270, 45, self.random.uniform(0, 360)]))
        sweep = math.radians(choose([0, 0, 360, 90, 180, 270, self.random.uniform(1, 359), 1e-4, -1e-4]))
        radius = choose([1, 5, 12.5, self.random.uniform(0.5, 30)]) * unit
        reach = radius + choose([0, 0, 0, 1e-5, 1e-3, 5e-3, 0.02]) * unit
        start, digits = (self.number(), self.number()), choose([3, 4, 5])
        end = [
            reach * math.cos(angle + sweep) - radius * math.cos(angle),
            reach * math.sin(angle + sweep) - radius * math.sin(angle),
        ]
        absolute = self.random.random() < 0.5
        self.lines.append(f"G90 G0 {first}{start[0]:g} {second}{start[1]:g}")
        if absolute:
            end = [end[0] + start[0], end[1] + start[1]]
        words = [f"{letter}{value:.{digits}f}" for letter, value in zip((first, second), end)]
        centre = [-radius * math.cos(angle), -radius * math.sin(angle)]
        if self.random.random() < 0.25 and 0.1 < sweep < 6.0:
            # a little longer, so that it reaches
            words.append(f"R{math.copysign(reach * 1.001 + 1e-3 * unit, math.pi - sweep):.{digits}f}")
        else:
            if sweep == 0.0 and self.random.random() < 0.5:
                words = []
            by_place = self.random.random() < 0.2
            centre = [centre[0] + start[0] * by_place, centre[1] + start[1] * by_place]
            words += [f"{letter}{value:.{digits}f}" for letter, value in zip((i, j), centre)]
            words.insert(0, "G90.1" if by_place else "G91.1")
        if self.random.random() < 0.3:
            words.append(f"P{self.random.randint(1, 3)}")
        if self.random.random() < 0.3:
            words.append(f"{'ZYX'[self.plane - 17]}{self.number():g}")
        self.lines.append(f"G{90 if absolute else 91} G{self.random.randint(2, 3)} {' '.join(words)}")

    def state(self) -> None:
        kind = self.random.randint(0, 9)
        if kind == 0:
            self.plane = self.random.randint(17, 19)
            self.lines.append(f"G{self.plane}")
        elif kind == 1:
            self.inch = self.random.random() < 0.5
            # lengths that were put in force in the other unit are told otherwise by `rs274`
            self.lines.append(f"G49 G{20 if self.inch else 21}")
        elif kind == 2:
            self.lines.append(f"G{self.random.randint(90, 91)}")
        elif kind == 3:
            self.lines.append(self.random.choice(OFFSETS))
        elif kind == 4:
            turn = f" R{self.random.choice([30, 45, 90, -17.5])}" if self.turns and self.random.random() < 0.7 else ""
            self.lines.append(f"G10 L2 P{self.random.randint(0, 9)} {self.place()}{turn}")
        elif kind == 5:
            self.lines.append(f"G10 L20 P{self.random.randint(0, 9)} X{self.number():g} Y{self.number():g}")
        elif kind == 6 and not self.turns:
            word = self.random.choice(["G92", "G52", "G92.1", "G92.2", "G92.3"])
            self.lines.append(word if "." in word else f"{word} {self.place()}")
        elif kind == 7:
            self.lines.append(self.random.choice([f"G43 H{self.random.randint(1, 2)}", "G49", f"G43.1 {self.place()}"]))
        elif kind == 8:
            self.lines.append(f"G90 G53 G{self.random.randint(0, 1)} {self.place()}")
        else:
            self.lines.append(f"G{self.random.choice([28, 30])} {self.place()}")


def places_job(seed: int) -> Job:
    """A program of words alone, with offsets, reference points and lengths of tools."""
    writer = Places(seed)
    for _ in range(writer.random.randint(2, 9)):
        writer.random.choice([writer.line, writer.arc, writer.arc, writer.state, writer.state])()
    writer.inch = False
    tables = [{letter: writer.number() for letter in "XYZC" if writer.random.random() < 0.5} for _ in range(11)]
    offsets = {name: table for name, table in zip(OFFSETS, tables) if writer.random.random() < 0.5}
    text = "\n".join(["G21 G90 G94 G17 G91.1 F600", *writer.lines, "M2"]) + "\n"
    return Job(text, offsets, {1: tables[9], 2: tables[10]}, {1: 50.0, 2: 80.5}, numbered=False)
