"""Where the machine is by the words of a program: offsets, shifts, mirrors, scales, turns, planes, tip mode.

Written from the manuals: points are carried one step after the other, nothing is put together into one matrix before.
Lengths are millimetres, angles degrees, as in programs.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from testbed.true_tip.chain import Chain, rotation


def turned(axis, degrees):
    """(3, 3) turn about X, Y or Z (0, 1, 2)."""
    return rotation(np.eye(3)[axis], [np.radians(degrees)])[0]


def euler(first, second, third):
    """(3, 3) turns about Z, the new X, the new Z."""
    return turned(2, first) @ turned(0, second) @ turned(2, third)


@dataclass
class Laid:
    """What lies over the coordinates, in the order of the manuals: mirror, scale, turn."""

    mirrors: dict = field(default_factory=dict)
    """Place by slot."""
    factors: np.ndarray = field(default_factory=lambda: np.ones(3))
    about: np.ndarray = field(default_factory=lambda: np.zeros(3))
    angle: float = 0.0
    centre: np.ndarray = field(default_factory=lambda: np.zeros(3))
    normal: int = 2
    moved: np.ndarray = field(default_factory=lambda: np.zeros(3))
    """By which a three-dimensional turn moves the origin, too."""

    def mirrored(self, point):
        """A point (3,) on the other side."""
        point = np.array(point)
        for slot, place in self.mirrors.items():
            point[slot] = 2.0 * place - point[slot]
        return point

    def to(self, point):
        """A point (3,) of the program, in the coordinates of the offset: mirrored, then scaled, then turned."""
        about, centre = self.mirrored(self.about), self.mirrored(self.centre)
        point = about + self.factors * (self.mirrored(point) - about)
        centre = about + self.factors * (centre - about)
        hands = sum(slot != self.normal for slot in self.mirrors)
        angle = -self.angle if hands % 2 else self.angle
        return centre + turned(self.normal, angle) @ (point - centre) + self.moved


class Truth:
    """One machine on which a program runs."""

    def __init__(self, text, sheet):
        self.chain = Chain(text)
        self.sheet = sheet
        self.offsets = {name: dict(values) for name, values in sheet.offsets.items()}
        self.offset = "G54"
        self.external, self.local, self.position = (dict.fromkeys(self.letters, 0.0) for _ in range(3))
        self.laid = Laid()
        self.plane = None
        """Origin (3,) and axes (3, 3) of the tilted plane, in the coordinates of the offset."""
        self.tip = False
        self.fixed = np.zeros(2)
        """Rotary joints at which tip mode fixed the coordinates."""
        self.tool, self.length = 1, None
        """The tool in the spindle; whose length counts, or None."""
        self.q = np.zeros(5)
        """Joints in the order of the machine file [m, rad]."""
        self.upright = self.columns(np.zeros(2))

    @property
    def letters(self):
        return [*"XYZ", *self.chain.rotary]

    def slot(self, letter):
        return self.chain.names.index(letter)

    def joints(self, linear, rotary):
        """(5,) in the order of the file, of X, Y, Z [mm] and rotary joints by name [deg]."""
        q = np.zeros(5)
        for letter, value in zip("XYZ", linear):
            q[self.slot(letter)] = value * 1e-3
        for letter, value in zip(self.chain.rotary, rotary):
            q[self.slot(letter)] = np.radians(value)
        return q

    def linear(self, q=None):
        q = self.q if q is None else q
        return np.array([q[self.slot(letter)] for letter in "XYZ"]) * 1e3

    def rotary(self):
        return np.degrees([self.q[self.slot(letter)] for letter in self.chain.rotary])

    def at(self, q, length):
        """The tip (3,) on the part [mm], of a tool of a length [mm]."""
        return self.chain.forward(q, length * 1e-3)[0][0] * 1e3

    def axis(self, rotary):
        return self.chain.forward(self.joints(np.zeros(3), rotary), 0.0)[1][0]

    def columns(self, rotary):
        """(3, 3) motion of the tip on the part by X, Y, Z."""
        here = self.at(self.joints(np.zeros(3), rotary), 0.0)
        return np.stack([self.at(self.joints(step, rotary), 0.0) - here for step in np.eye(3)], axis=1)

    def turns_part(self, rotary):
        """Rotary joints of which those of the head are zero: a joint of the head changes no column."""
        kept = np.zeros(2)
        for k in range(2):
            alone = np.zeros(2)
            alone[k] = 20.0
            kept[k] = rotary[k] if np.abs(self.columns(alone) - self.upright).max() > 1e-9 else 0.0
        return kept

    # Words

    def shift(self):
        """(3,) mm and (2,) degrees by which words are shifted from the machine's zero."""
        total = dict.fromkeys(self.letters, 0.0)
        for part in (self.offsets[self.offset], self.external, self.local, self.position):
            for letter, value in part.items():
                total[letter] += value
        return np.array([total[x] for x in "XYZ"]), np.array([total[x] for x in self.chain.rotary])

    def _to(self, words, rotary):
        """Linear joints (3,) [mm], or where words are the tip that (3,), of words at rotary joints."""
        point = self.laid.to(words)
        linear, _ = self.shift()
        if self.plane is None and not self.tip:
            length = self.sheet.tools[self.length] if self.length else 0.0
            lift = np.linalg.solve(self.upright, self.axis(np.zeros(2)))
            return self.sheet.zero + linear + point + lift * length
        held = np.zeros(2) if self.plane is not None else self.turns_part(self.fixed)
        if self.plane is not None:
            point = self.plane[0] + self.plane[1] @ point
        start = self.at(self.joints(self.sheet.zero + linear, held), 0.0)
        return start + self.columns(held) @ np.linalg.solve(self.upright, point)

    def reckoned(self):
        """Length [mm] with which the control reckons where words are the tip."""
        return self.sheet.tools[self.length or self.tool]

    def words(self):
        """X, Y, Z and rotary words of where the machine is."""
        _, turn = self.shift()
        rotary = self.rotary()
        origin = self._to(np.zeros(3), rotary)
        columns = np.stack([self._to(step, rotary) - origin for step in np.eye(3)], axis=1)
        here = self.linear() if self.plane is None and not self.tip else self.at(self.q, self.reckoned())
        return np.linalg.solve(columns, here - origin), rotary - turn

    def move(self, words, rotary_words):
        """Go to words (3,) and rotary words (2,)."""
        _, turn = self.shift()
        rotary = np.asarray(rotary_words) + turn
        there = self._to(words, rotary)
        if self.plane is None and not self.tip:
            self.q = self.joints(there, rotary)
            return
        named = {letter: np.radians([value]) for letter, value in zip(self.chain.rotary, rotary)}
        self.q = self.chain.joints(there[None] * 1e-3, named, self.reckoned() * 1e-3)[0]

    # Planes

    def normal(self):
        """The direction (3,) on the part across the plane in force."""
        return self.columns(np.zeros(2)) @ np.linalg.solve(self.upright, self.plane[1][:, 2])

    def stands(self, normal):
        """Rotary joints (k, 2) [deg] that bring the tool to a direction (3,): every solution, by Newton's steps."""
        found = []
        for first in range(-135, 180, 90):
            for second in range(-135, 180, 90):
                angles = self._newton(np.array([first, second], float), normal)
                if angles is not None:
                    angles = (angles + 180.0) % 360.0 - 180.0
                    if not any(np.abs((angles - other + 180.0) % 360.0 - 180.0).max() < 1e-5 for other in found):
                        found.append(angles)
        return found

    def _newton(self, angles, normal):
        for _ in range(30):
            axis = self.axis(angles)
            off = normal - axis
            if np.abs(off).max() < 1e-13:
                break
            slopes = np.stack([self.axis(angles + 1e-5 * step) - self.axis(angles - 1e-5 * step) for step in np.eye(2)])
            step, *_ = np.linalg.lstsq(slopes.T / 2e-5, off, rcond=None)
            angles = angles + np.clip(step, -40.0, 40.0)
        return angles if np.abs(normal - self.axis(angles)).max() < 1e-10 else None

    def nearest(self, normal):
        """Rotary joints to which G53.1 turns, "least movement" first of the master axis; None where that is a tie."""
        low, high = np.degrees([self.chain.travel[name] for name in self.chain.rotary]).T
        present, choices = self.rotary(), []
        for angles in self.stands(normal):
            near = angles + 360.0 * np.round((present - angles) / 360.0)
            every = [near[k] + 360.0 * np.arange(-3, 4) for k in (0, 1)]
            every = [[v for v in every[k] if low[k] - 1e-7 <= v <= high[k] + 1e-7] for k in (0, 1)]
            if all(every):
                choices.append([min(each, key=lambda v, k=k: abs(v - present[k])) for k, each in enumerate(every)])
        table = [np.abs(self.columns(20.0 * step) - self.upright).max() > 1e-9 for step in np.eye(2)]
        names = self.chain.rotary
        # from the bed: of two joints of one kind the one that carries the other; of one of each kind that of the table
        if all(table):
            order = sorted((0, 1), key=lambda k: self.chain.workpiece.index(names[k]))
        elif not any(table):
            order = sorted((0, 1), key=lambda k: self.chain.tool.index(names[k]))
        else:
            order = sorted((0, 1), key=lambda k: not table[k])
        ranked = sorted((*(round(abs(c[k] - present[k]), 5) for k in order), *self._away(c, order), c) for c in choices)
        if not ranked or (len(ranked) > 1 and ranked[0][:4] == ranked[1][:4]):
            return None
        return np.array(ranked[0][-1])

    @staticmethod
    def _away(angles, order):
        return [round(abs((angles[k] + 180.0) % 360.0 - 180.0), 5) for k in order]
