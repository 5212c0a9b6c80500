"""Random programs of frames, distances, polar places, arcs, holes and units, against matrices of this file.

The rules: frames multiply to the right, and TRANS, ROT, SCALE, MIRROR replace; a distance counts from the last
programmed end, in whatever frame (SD42440 = 1); axes that a block does not name stay where they are.
"""

from __future__ import annotations

import math
import random

import numpy as np
import pytest

from tests.support.sinumerik import read
from toolpace.common.errors import ProgramError

PLANES = ((0, 1), (2, 0), (1, 2))
INCH = 25.4


class UnsureError(Exception):
    """The next block asks for what no manual tells."""


def shift(by):
    made = np.eye(4)
    made[:3, 3] = by
    return made


def turn(axis, degrees):
    made, a, b = np.eye(4), (axis + 1) % 3, (axis + 2) % 3
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    made[a, a], made[a, b], made[b, a], made[b, b] = c, -s, s, c
    return made


def named(axes, values):
    return " ".join(f"{'XYZ'[axis]}{value}" for axis, value in zip(axes, values))


class Program:
    """Blocks at random, and the places [mm] that the tool passes."""

    def __init__(self, seed):
        self.random = random.Random(seed)
        self.lines, self.passed = [], []
        self.frame, self.offsets, self.offset = np.eye(4), {}, 1
        self.place, self.programmed = np.zeros(3), np.zeros(3)
        self.unsure, self.absolute, self.unit, self.plane, self.pole = set(), True, 1.0, 0, None
        for number in (1, 2, 3):
            by, axis, degrees = self.several(50), self.random.randrange(3), self.random.choice([0, self.value(90)])
            self.offsets[number] = shift(by) @ turn(axis, degrees)
            words = ",".join(f"{letter},{value}" for letter, value in zip("XYZ", by))
            self.lines.append(f"$P_UIFR[{number}]=CTRANS({words}):CROT({'XYZ'[axis]},{degrees})")
        self.lines.append("G54 G0 X0 Y0 Z0 F1000")
        blocks = (self.frames, self.frames, self.line, self.line, self.line, self.arc, self.polar, self.hole, self.mode)
        self.ends_unsure = False
        try:
            for _ in range(self.random.randint(5, 18)):
                self.random.choice(blocks)()
        except UnsureError:
            self.ends_unsure = True

    def value(self, most=20.0):
        return round(self.random.uniform(-most, most), 3)

    def several(self, most=20.0):
        return [self.value(most) for _ in range(3)]

    def chain(self):
        return np.linalg.inv(self.offsets[1]) @ self.offsets[self.offset] @ self.frame

    def here(self):
        return (np.linalg.inv(self.chain()) @ [*self.place, 1.0])[:3]

    def pass_by(self, words):
        self.passed.append((self.chain() @ [*words, 1.0])[:3])

    def go(self, words, axes):
        shifted = {axis for axis in range(3) if abs(self.programmed[axis] - self.here()[axis]) > 1e-9}
        self.unsure = (self.unsure | shifted) - set(axes)
        self.pass_by(words)
        self.place, self.programmed = self.passed[-1], words

    def frames(self):
        kind, added = self.random.choice(["TRANS", "ROT", "RPL", "SCALE", "MIRROR", "G54", "G55", "G56"]), True
        axes = [axis for axis in range(3) if self.random.random() < 0.6] or [0]
        if kind[0] == "G":
            self.offset = int(kind[1:]) - 53
            self.lines.append(kind)
        else:
            made, words = self.made(kind, axes)
            added = self.random.random() < 0.6
            self.frame = self.frame @ made if added else made
            self.lines.append(f"{'A' * added}{kind.replace('RPL', 'ROT')} {words}")
        self.pole = None

    def made(self, kind, axes):
        if kind == "RPL":
            degrees = self.value(180)
            return turn((2, 1, 0)[self.plane], degrees), f"RPL={degrees}"
        if kind == "ROT":
            angles = dict(zip(axes, self.several(80)))
            made = turn(2, angles.get(2, 0)) @ turn(1, angles.get(1, 0)) @ turn(0, angles.get(0, 0))
            return made, named(*zip(*self.random.sample(sorted(angles.items()), len(angles))))
        values = [self.value() if kind == "TRANS" else round(self.random.uniform(0.5, 2), 3) for _ in axes]
        if kind == "SCALE" and self.random.random() < 0.6:
            axes, values = [0, 1, 2], values[:1] * 3
        by = np.full(3, 0.0 if kind == "TRANS" else 1.0)
        by[axes] = -1.0 if kind == "MIRROR" else values
        return shift(by * self.unit) if kind == "TRANS" else np.diag([*by, 1.0]), named(axes, values)

    def words(self, axes):
        """Ends of a motion along axes, and how they are written."""
        ends, written = self.here(), []
        for axis in axes:
            form, value = self.random.choice(["", "", "", "IC", "AC"]), self.value()
            if form == "IC" or (not form and not self.absolute):
                if axis in self.unsure:
                    self.lines.append(f"G1 {'XYZ'[axis]}=IC({value})")
                    raise UnsureError
                ends[axis] = self.programmed[axis] + value * self.unit
            else:
                ends[axis] = value * self.unit
            written.append(f"{'XYZ'[axis]}={form}({value})" if form else f"{'XYZ'[axis]}{value}")
        return ends, " ".join(written)

    def line(self):
        axes = [axis for axis in range(3) if self.random.random() < 0.6] or [self.random.randrange(3)]
        ends, written = self.words(axes)
        self.lines.append(f"{self.random.choice(['G0', 'G1'])} {written}")
        self.go(ends, axes)

    def arc(self):
        axes = PLANES[self.plane]
        across = self.chain()[:3, axes]
        if not np.allclose(across.T @ across, (across[:, 0] @ across[:, 0]) * np.eye(2)) or self.unsure & set(axes):
            return  # controls cut no ellipse
        begin = self.here()[list(axes)]
        ends, written = self.words(axes)
        chord = ends[list(axes)] - begin
        size = math.hypot(*chord)
        radius = round(size * self.random.uniform(0.55, 2) / self.unit, 3) * self.unit
        clockwise, longer = self.random.random() < 0.5, self.random.random() < 0.3
        side = 1.0 if clockwise == longer else -1.0
        height = math.sqrt(radius**2 - size**2 / 4)
        centre = begin + chord / 2 + side * height / size * np.array([-chord[1], chord[0]])
        first, last = (math.atan2(*(place - centre)[::-1]) for place in (begin, begin + chord))
        swept = -((first - last) % math.tau) if clockwise else (last - first) % math.tau
        middle = self.here()
        middle[list(axes)] = centre + radius * np.array([math.cos(first + swept / 2), math.sin(first + swept / 2)])
        height_axis = 3 - sum(axes)
        middle[height_axis] = (self.here()[height_axis] + ends[height_axis]) / 2
        self.pass_by(middle)
        i, j = (centre - begin) / self.unit
        about = f"{'IJK'[axes[0]]}={i:.9f} {'IJK'[axes[1]]}={j:.9f}"
        by_radius = f"CR={'-' * longer}{radius / self.unit:.3f}"
        self.lines.append(f"{'G2' if clockwise else 'G3'} {written} {self.random.choice([about, by_radius])}")
        self.go(ends, axes)

    def polar(self):
        axes = PLANES[self.plane]
        if self.pole is None or self.random.random() < 0.3:
            pole = self.several()[:2]
            self.lines.append(f"G111 {named(axes, pole)}")
            self.pole = np.array(pole) * self.unit
        radius, angle = round(self.random.uniform(0.5, 20), 3), self.value(180)
        ends = self.here()
        ends[list(axes)] = self.pole + radius * self.unit * np.array(
            [math.cos(math.radians(angle)), math.sin(math.radians(angle))]
        )
        self.lines.append(f"G1 RP={radius} AP={angle}")
        self.go(ends, axes)

    def hole(self):
        axis, bottom = (2, 1, 0)[self.plane], self.value(5)
        self.lines.append(f"CYCLE81({bottom + 15:.3f},{bottom + 5:.3f},1,{bottom:.3f})")
        for height in (bottom, bottom + 15):
            ends = self.here()
            ends[axis] = round(height, 3) * self.unit
            self.go(ends, [axis])

    def mode(self):
        kind = self.random.choice(["message", "plane", "distances", "unit"])
        if kind == "plane":
            self.plane, self.pole = self.random.randrange(3), None
        elif kind == "distances":
            self.absolute = not self.absolute
        elif kind == "unit":
            self.unit = INCH if self.unit == 1.0 else 1.0
        said = {
            "message": self.random.choice(['MSG("A")', "M8", "G4 F1"]), "plane": f"G{17 + self.plane}",
            "distances": "G90" if self.absolute else "G91", "unit": "G71" if self.unit == 1.0 else "G70",
        }  # fmt: skip
        self.lines.append(said[kind])


def missed(tip, places):
    """The first of places [mm] that a way does not pass, in their order; None where it passes all."""
    begin, way = tip[:-1], np.diff(tip, axis=0)
    at = 0
    for place in places:
        along = ((place - begin[at:]) * way[at:]).sum(axis=1) / np.maximum((way[at:] ** 2).sum(axis=1), 1e-30)
        off = place - begin[at:] - np.clip(along, 0.0, 1.0)[:, None] * way[at:]
        near = np.flatnonzero(np.linalg.norm(off, axis=1) < 5e-3)
        if not len(near):
            return place
        at += near[0]
    return None


@pytest.mark.parametrize("first", range(0, 120, 20))
def test_random_words(first):
    """The tool passes all places in their order, ends at the last, and what no manual tells is refused."""
    refused = 0
    for seed in range(first, first + 20):
        program = Program(seed)
        if not program.passed:
            continue
        text = "\n".join(program.lines)
        if program.ends_unsure:
            refused += 1
            with pytest.raises(ProgramError, match="is a distance, and"):
                read(text, start="")
            continue
        tip = read(text, start="").tip * 1e3
        assert missed(tip, program.passed) is None, text
        assert tip[-1] == pytest.approx(program.place, abs=1e-5), text
    assert refused < 15
