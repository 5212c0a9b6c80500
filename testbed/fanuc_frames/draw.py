"""Random programs of frames and tools, with the place of the machine behind every motion."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from testbed.fanuc_frames.truth import Laid, Truth, euler, turned
from testbed.true_tip.cases import BUILTIN
from testbed.true_tip.cases import MACHINES as EVERY

STOPS = "the rule of G53.1 leaves it open which position the rotary axes take"
MACHINES = tuple(name for name in EVERY if name != "paper-ab")
"""But one whose X and Y run against those of the part: there words of joints and of the tip are not the same."""
MOST = 18
"""Statements of a program."""


@dataclass
class Sheet:
    """A set-up sheet, in millimetres and degrees."""

    zero: np.ndarray
    offsets: dict
    tools: dict
    reference: dict

    def text(self):
        parts = ["[units]", 'length = "mm"', 'angle = "deg"', "[machine_zero]"]
        parts += [f"{letter} = {value!r}" for letter, value in zip("XYZ", self.zero.tolist())]
        for name, values in self.offsets.items():
            parts += [f'[offsets."{name}"]', *(f"{letter} = {value!r}" for letter, value in values.items())]
        for number, length in self.tools.items():
            parts += [f"[tools.{number}]", f"length = {length!r}"]
        parts += ["[references.1]", *(f"{letter} = {value!r}" for letter, value in self.reference.items())]
        return "\n".join(parts) + "\n"


@dataclass
class Place:
    """Where the machine is behind a line of the program."""

    line: int
    q: np.ndarray
    """(5,) joints [m, rad]."""
    length: float
    """Of the tool in the spindle [mm]."""
    normal: np.ndarray | None = None
    """Where the rotary joints stand on a plane: its direction (3,), and they are to be taken from the reader."""
    nearest: np.ndarray | None = None
    """The rotary joints (2,) [deg] that the rule of G53.1 chooses."""
    above: float | None = None
    """How far above the tip [mm] the point is that keeps its place (G53.6); None: the linear joints do."""


@dataclass
class Dialect:
    """What the words are called."""

    name: str
    numbered: str = "G54.1 P{}"
    tip: tuple = ("G43.4", "G43.5")
    mirror: tuple = ("G51.1", "G50.1")
    life: float = 1000.0
    """A whole P that is life size."""
    plane: str = "euler"
    stand: tuple = ("G53.1", "G53.6")
    plane_off: str = "G69"
    fixed_where_switched: bool = True
    zero_is_local: bool = False


DIALECTS = {
    "fanuc": Dialect("fanuc"),
    "mazak": Dialect("mazak"),
    "haas": Dialect(
        "haas", "G154 P{}", ("G234",), ("G101", "G100"), 1.0, "order", ("G253",), "G269", False, True
    ),
}


class Program:
    """One program of a seed; `places` is the truth."""

    def __init__(self, seed):
        self.rng = rng = np.random.default_rng(seed)
        self.by = DIALECTS[("fanuc", "fanuc", "mazak", "haas")[seed % 4]]
        self.machine = MACHINES[(seed // 4) % len(MACHINES)]
        self.lines, self.places = [], []
        self.with_rotary = bool(rng.random() < 0.25)
        self.sheet = self._sheet()
        self.truth = Truth((BUILTIN / f"{self.machine}.toml").read_text(), self.sheet)
        self.letters = self.truth.chain.rotary
        if self.with_rotary:
            for values in self.sheet.offsets.values():
                values[self.letters[-1]] = round(float(rng.uniform(-20.0, 20.0)), 3)
            self.truth.offsets = {name: dict(values) for name, values in self.sheet.offsets.items()}
        self.unit = 25.4 if rng.random() < 0.25 else 1.0
        self.plane_off = ""
        """The word that ends the plane in force, where it is not the usual one."""
        self.vectors = False
        """Whether words tell the direction of the tool."""
        self.follows = False
        """Whether tip mode is on in the plane in force."""
        self._head()
        for _ in range(MOST):
            if not self._statement():
                break
        self.say("M30")

    def text(self):
        return "\n".join(self.lines) + "\n"

    def _sheet(self):
        rng = self.rng

        def place(size=60.0):
            return {letter: round(float(rng.uniform(-size, size)), 4) for letter in "XYZ"}

        names = ["G54", "G55", "G57", self.by.numbered.format(3), self.by.numbered.format(5)]
        tools = {k: round(float(rng.uniform(60.0, 220.0)), 3) for k in (1, 2, 3)}
        zero = np.round(rng.uniform(-100.0, 100.0, 3), 4)
        return Sheet(zero, {name: place() for name in names}, tools, place(150.0))

    # Writing

    def say(self, text):
        self.lines.append(text)

    def number(self, low, high, places=3):
        return round(float(self.rng.uniform(low, high)), places)

    def word(self, letter, value):
        """A word of millimetres or degrees, with a point."""
        return f"{letter}{value / (self.unit if letter in 'XYZ' else 1.0):.8f}".rstrip("0")

    def words(self, letters, values):
        return " ".join(self.word(letter, value) for letter, value in zip(letters, values))

    def chance(self, share):
        return bool(self.rng.random() < share)

    def note(self, **more):
        self.places.append(Place(len(self.lines), self.truth.q.copy(), self.sheet.tools[self.truth.tool], **more))

    def _head(self):
        self.say("%")
        self.say("O1000")
        self.say(f"G{21 if self.unit == 1.0 else 20} G90 G94 G17 G40 G49 G80 F1000.")
        self.say("T1 M6")
        self.say("G54")
        self.say("G43 H1")
        self.truth.length = 1
        self._go(full=True)

    # Motions

    def _rotary_words(self):
        low, high = np.degrees([self.truth.chain.travel[name] for name in self.letters]).T
        most = [30.0 if low[k] < 0.0 < high[k] else 0.0 for k in (0, 1)]
        return np.round([self.rng.uniform(max(-m, 0.8 * a), min(m, 0.8 * b)) for m, a, b in zip(most, low, high)], 3)

    def _go(self, full=False, turn=None):
        """A straight motion to some words, absolute or not."""
        truth, rng = self.truth, self.rng
        words, rotary = truth.words()
        turn = (full or self.chance(0.3)) if turn is None else turn
        wanted = np.round(rng.uniform(-40.0, 40.0, 3), 3)
        named = np.array([True] * 3) if full else rng.random(3) < 0.7
        if truth.plane is not None or self.vectors:
            turn = False
        if not named.any() and not turn:
            named = np.array([True, True, False])
        relative = not full and self.chance(0.2)
        parts = ["G91" if relative else "G90", "G1" if self.chance(0.5) else "G0"]
        for k, letter in enumerate("XYZ"):
            if named[k]:
                parts.append(self.word(letter, wanted[k]))
        goal = np.where(named, words + wanted if relative else wanted, words)
        angles = rotary.copy()
        if turn:
            new = self._rotary_words()
            turned_axes = [True, True] if full else [self.chance(0.7), self.chance(0.7)]
            for k, letter in enumerate(self.letters):
                if turned_axes[k]:
                    parts.append(self.word(letter, new[k]))
                    angles[k] = rotary[k] + new[k] if relative else new[k]
        self.say(" ".join(parts))
        truth.move(goal, angles)
        self.note()
        if relative:
            self.say("G90")

    def _arc(self):
        """Half a circle in XY, by its centre."""
        laid = self.truth.laid
        if np.ptp(laid.factors) > 1e-12 or (laid.angle and laid.normal != 2):
            return
        words, rotary = self.truth.words()
        i, j, z = self.number(-15.0, 15.0), self.number(-15.0, 15.0), self.number(-5.0, 5.0)
        if abs(i) + abs(j) < 1.0:
            return
        ends = " ".join(self.word(x, v) for x, v in zip("XYZ", (round(2 * i, 3), round(2 * j, 3), z)))
        self.say(f"G91 G{self.rng.integers(2, 4)} {ends} I{i / self.unit:.8f} J{j / self.unit:.8f}")
        self.truth.move(words + np.round([2 * i, 2 * j, z], 3), rotary)
        self.note()
        self.say("G90 G1")

    # Statements

    def _statement(self):
        truth, laid = self.truth, self.truth.laid
        plain = not laid.mirrors and laid.angle == 0.0 and np.all(laid.factors == 1.0) and not laid.moved.any()
        choices = [self._go, self._go, self._arc, self._machine_place]
        if truth.plane is None and not truth.tip:
            if plain:
                choices += [self._offset, self._local, self._position, self._set_offset, self._tool]
                choices += [self._plane, self._plane, self._tip_mode, self._tip_mode, self._mirror, self._three_d]
                choices += [self._carried] * 2 * (self.by.name == "haas")
            if not laid.angle and np.all(laid.factors == 1.0):
                choices += [self._mirror]
            if not laid.angle and np.all(laid.factors == 1.0) and not laid.moved.any():
                choices += [self._scale]
            if not laid.moved.any() and np.all(laid.factors > 0.0):
                choices += [self._turn]
            if not plain:
                choices += [self._end_laid] * 3
        elif truth.plane is not None:
            choices += [self._end_plane] * 2 + [self._upon] * (self.by.plane == "euler")
        else:
            choices += [self._tip_off] * 2 + [self._direction] * 4 * self.vectors
        return choices[int(self.rng.integers(len(choices)))]() is not STOPS

    def _offset(self):
        names = list(self.truth.offsets)
        self.truth.offset = names[int(self.rng.integers(len(names)))]
        self.say(self.truth.offset)

    def _given(self, rotary=True):
        """Some axis words [mm, deg]."""
        letters = [x for x in "XYZ" if self.chance(0.6)]
        if rotary and self.with_rotary and self.chance(0.4):
            letters.append(self.letters[-1])
        return {x: self.number(-20.0, 20.0) for x in letters or ["X"]}

    def _local(self):
        given = self._given() if self.chance(0.7) else dict.fromkeys("XYZ", 0.0)
        self.say("G52 " + " ".join(self.word(x, v) for x, v in given.items()))
        self.truth.local |= given

    def _position(self):
        given = self._given()
        words, rotary = self.truth.words()
        present = dict(zip(self.truth.letters, [*words, *rotary]))
        self.say("G92 " + " ".join(self.word(x, v) for x, v in given.items()))
        for letter, value in given.items():
            self.truth.position[letter] += present[letter] - value

    def _set_offset(self):
        """G10 L2 and L20, absolute or not."""
        given, relative = self._given(), self.chance(0.3)
        kind = int(self.rng.integers(3))
        if kind == 0:
            to = self.truth.local if self.by.zero_is_local else self.truth.external
            how = "L2 P0"
        elif kind == 1:
            number = (1, 2, 4)[int(self.rng.integers(3))]
            to, how = self.truth.offsets[f"G{53 + number}"], f"L2 P{number}"
        else:
            number = (3, 5)[int(self.rng.integers(2))]
            to, how = self.truth.offsets[self.by.numbered.format(number)], f"L20 P{number}"
        words = " ".join(self.word(x, v) for x, v in given.items())
        self.say(f"{'G91' if relative else 'G90'} G10 {how} {words}")
        for letter, value in given.items():
            to[letter] = to.get(letter, 0.0) + value if relative else value
        if relative:
            self.say("G90")

    def _tool(self):
        truth = self.truth
        truth.tool = int(self.rng.integers(1, 4))
        self.say(f"T{truth.tool} M6")
        how = int(self.rng.integers(4))
        words, rotary = truth.words()
        z = self.number(-30.0, 30.0)
        goal = np.array([*words[:2], z])
        if how == 0 or (how > 1 and self.by.name == "haas"):
            self.say(f"G43 H{truth.tool}")
            truth.length = truth.tool
            return
        if how == 1 or truth.length is None:
            self.say(f"G0 G43 {self.word('Z', z)} H{truth.tool}")
        elif how == 2:
            # under G91 the axis goes by the word and by the difference of the lengths
            self.say(f"G91 G0 G43 {self.word('Z', z)} H{truth.tool}")
            goal[2] = words[2] + z
        else:
            self.say(f"G0 {self.word('Z', z)} H{truth.tool}")
        truth.length = truth.tool
        truth.move(goal, rotary)
        self.note()
        self.say("G90")

    def _machine_place(self):
        if self.chance(0.5):
            value = self.number(-50.0, 50.0)
            self.say(f"G90 G53 G0 {self.word('Z', value)}")
        else:
            value = self.sheet.reference["Z"]
            self.say("G91 G28 Z0")
        linear = self.truth.linear()
        linear[2] = self.sheet.zero[2] + value
        self.truth.q = self.truth.joints(linear, self.truth.rotary())
        self.note()
        self.say("G90 G1")

    # Laid over the coordinates

    def _mirror(self):
        slot = int(self.rng.integers(2))
        value = 0.0 if self.by.name == "haas" else self.number(-10.0, 10.0)
        self.say(f"{self.by.mirror[0]} {self.word('XY'[slot], value)}")
        self.truth.laid.mirrors[slot] = value

    def _scale(self):
        laid, words = self.truth.laid, self.truth.words()[0]
        # without its centre it is about the place where the tool is, in coordinates without the scale before
        before = laid.about + laid.factors * (words - laid.about)
        named = {x: self.number(-20.0, 20.0) for x in "XYZ" if self.chance(0.7)}
        about = np.array([named.get(x, before[k]) for k, x in enumerate("XYZ")])
        if self.chance(0.6):
            factors = np.full(3, float(self.rng.choice([0.5, 2.0, 0.8])))
            how = f"P{factors[0] * self.by.life:.0f}" if self.by.life > 1.0 else f"P{factors[0]:.1f}"
        elif self.by.life > 1.0:
            factors = np.array([float(self.rng.choice([0.5, 2.0, 1.0, -1.0])) for _ in range(3)])
            factors[0] = 2.0 if np.all(factors == 1.0) else factors[0]
            how = " ".join(f"{x}{v * self.by.life:.0f}" for x, v in zip("IJK", factors))
        else:
            return
        self.say(f"G51 {' '.join(self.word(x, v) for x, v in named.items())} {how}")
        laid.factors, laid.about = factors, about

    def _turn(self):
        laid, words = self.truth.laid, self.truth.words()[0]
        normal = 2 if self.chance(0.7) or laid.angle else int(self.rng.integers(2))
        if laid.angle and normal != laid.normal:
            return
        plane, inside = {2: ("G17", "XY"), 1: ("G18", "ZX"), 0: ("G19", "YZ")}[normal]
        # the tool in coordinates without the turn before, scales undone
        here = laid.to(words)
        undone = Laid(laid.mirrors, laid.factors, laid.about)
        origin = undone.to(np.zeros(3))
        here = np.linalg.solve(np.stack([undone.to(step) - origin for step in np.eye(3)], axis=1), here - origin)
        named = {x: self.number(-20.0, 20.0) for x in inside if self.chance(0.7)}
        centre = np.array([named.get(x, here[k]) for k, x in enumerate("XYZ")])
        centre[normal] = 0.0
        angle = self.number(-120.0, 120.0)
        self.say(f"{plane} G68 {' '.join(self.word(x, v) for x, v in named.items())} {self.word('R', angle)}")
        laid.angle, laid.centre, laid.normal = angle, centre, normal
        self.say("G17")
        # both axes that turn are named in the motion behind it
        goal, rotary = np.round(self.rng.uniform(-30.0, 30.0, 3), 3), self.truth.words()[1]
        self.say("G1 " + " ".join(self.word(x, v) for x, v in zip("XYZ", goal)))
        self.truth.move(goal, rotary)
        self.note()

    def _three_d(self):
        """G68 with a vector along the tool: about Z, and the origin is the centre."""
        at, angle = np.round(self.rng.uniform(-20.0, 20.0, 3), 3), self.number(-120.0, 120.0)
        way = 1.0 if self.chance(0.7) else -1.0
        laid = self.truth.laid
        self.say(f"G68 {self.words('XYZ', at)} I0 J0 K{way:.0f}. {self.word('R', angle)}")
        laid.angle, laid.normal, laid.centre, laid.moved = way * angle, 2, np.zeros(3), at
        self._go(full=True)

    def _end_laid(self):
        laid = self.truth.laid
        if laid.angle or laid.moved.any():
            self.say("G69")
            laid.angle, laid.moved, laid.centre = 0.0, np.zeros(3), np.zeros(3)
        elif np.any(laid.factors != 1.0):
            self.say("G50")
            laid.factors, laid.about = np.ones(3), np.zeros(3)
        elif laid.mirrors:
            slot = next(iter(laid.mirrors))
            self.say(f"{self.by.mirror[1]} {'XY'[slot]}0")
            del laid.mirrors[slot]

    # Five axes

    def _plane_words(self, at, angles):
        """The plane in words; its axes (3, 3)."""
        rng = self.rng
        place = " ".join(self.word(x, v) for x, v in zip("XYZ", at))
        if self.by.plane == "order":
            order = "".join(map(str, rng.permutation([1, 2, 3])))
            made = np.eye(3)
            for digit in order:
                made = turned(int(digit) - 1, angles[int(digit) - 1]) @ made
            return [f"G268 {place} {self.words('IJK', angles)} Q{order}"], made, at
        made = euler(*angles)
        kind = int(rng.integers(4))
        if kind < 2:
            how = " ".join(self.word(x, v) for x, v in zip("IJK", angles))
            return [f"G68.2 {'P0 ' if kind else ''}{place} {how}"], made, at
        if kind == 2:
            lines = [f"G68.2 P3 Q1 {place} " + " ".join(f"{x}{v:.12f}" for x, v in zip("IJK", made[:, 0]))]
            return [*lines, "G68.2 P3 Q2 " + " ".join(f"{x}{v:.12f}" for x, v in zip("IJK", made[:, 2]))], made, at
        beside = np.round(rng.uniform(-10.0, 10.0, 3), 3) if self.chance(0.4) else np.zeros(3)
        more = self.number(-40.0, 40.0) if self.chance(0.4) else 0.0
        points = np.round([at, at + 70.0 * made[:, 0], at + 60.0 * made[:, 1] - 25.0 * made[:, 0]], 6)
        x = points[1] - points[0]
        z = np.cross(x, points[2] - points[0])
        x, z = x / np.linalg.norm(x), z / np.linalg.norm(z)
        found = np.stack([x, np.cross(z, x), z], axis=1)
        lines = [f"G68.2 P2 Q{k + 1} {self.words('XYZ', point)}" for k, point in enumerate(points)]
        if beside.any() or more:
            lines.insert(0, f"G68.2 P2 Q0 {self.words('XYZ', beside)} {self.word('R', more)}")
        return lines, found @ turned(2, more), points[0] + found @ beside

    def _plane(self):
        low, high = np.degrees([self.truth.chain.travel[name] for name in self.letters]).T
        most = min(25.0, *(0.7 * max(-a, b) for a, b in zip(low, high)))
        angles = np.array([self.number(-170.0, 170.0), self.number(2.0, most), self.number(-170.0, 170.0)])
        if self.by.plane == "order":
            angles[:2] = self.number(-0.6 * most, 0.6 * most), self.number(3.0, 0.6 * most)
        lines, axes, at = self._plane_words(np.round(self.rng.uniform(-30.0, 30.0, 3), 3), angles)
        for line in lines:
            self.say(line)
        self.truth.plane = (at, axes)
        return self._stand()

    def _carried(self):
        """Haas G254: the work offset goes with the table, its axes stay parallel to the machine's."""
        truth = self.truth
        self.say("G254")
        self.plane_off = "G255"
        made = truth.columns(truth.turns_part(truth.rotary())) @ np.linalg.inv(truth.upright)
        truth.plane = (np.zeros(3), made)
        self._go(full=True, turn=False)

    def _upon(self):
        """G68.4: a plane upon the plane."""
        at, angles = np.round(self.rng.uniform(-10.0, 10.0, 3), 3), np.round(self.rng.uniform(-8.0, 8.0, 3), 3)
        first, axes = self.truth.plane
        place = " ".join(self.word(x, v) for x, v in zip("XYZ", at))
        self.say(f"G68.4 {place} " + " ".join(self.word(x, v) for x, v in zip("IJK", angles)))
        self.truth.plane = (first + axes @ at, axes @ euler(*angles))
        return self._stand()

    def _stand(self):
        """G53.1 or G53.6, where the tool is upright on the plane, and a motion there."""
        normal = self.truth.normal()
        word = self.by.stand[int(self.rng.integers(len(self.by.stand)))]
        above = None
        if word == "G53.6":
            above = self.number(5.0, 80.0) if self.chance(0.4) else 0.0
            word += f" {self.word('R', above)}" if above else ""
        nearest = self.truth.nearest(normal)
        if nearest is not None and not self.follows and self.chance(0.2):
            self.say(f"G0 {self.words(self.letters, nearest - self.truth.shift()[1])}")
            above = None
        else:
            self.say(word)
        self.note(normal=normal, nearest=nearest, above=above)
        if nearest is None:
            return STOPS
        self._stood(nearest, above)
        if self.chance(0.3) and self.by.name != "haas":
            self.follows = True
            self.say(f"G43.4 H{self.truth.tool}")
            self.truth.length = self.truth.tool
        self._go(full=True, turn=False)
        return None

    def _stood(self, rotary, above):
        """The rotary joints turn; the linear ones, the tip, or a point of the tool, keep their places."""
        truth = self.truth
        if above is None:
            truth.q = truth.joints(truth.linear(), rotary)
            return
        point = truth.at(truth.q, truth.reckoned()) + above * truth.axis(truth.rotary())
        tip = point - above * truth.axis(rotary)
        named = {letter: np.radians([value]) for letter, value in zip(self.letters, rotary)}
        truth.q = truth.chain.joints(tip[None] * 1e-3, named, truth.reckoned() * 1e-3)[0]

    def _turn_in_plane(self):
        """Rotary words alone: nothing follows them, or in tip mode the tip keeps its place."""
        truth = self.truth
        words, _ = truth.words()
        angles = self._rotary_words()
        self.say(f"G0 {self.words(self.letters, angles)}")
        if self.follows:
            truth.move(words, angles)
        else:
            truth.q = truth.joints(truth.linear(), angles + truth.shift()[1])
        self.note()

    def _end_plane(self):
        if self.chance(0.4):
            self._turn_in_plane()
        self.follows = False
        self.say(self.plane_off or self.by.plane_off)
        self.plane_off = ""
        self.truth.plane = None
        self.say("G49")
        self.truth.length = None
        if self.chance(0.8):
            self.truth.length = self.truth.tool
            self.say(f"G43 H{self.truth.tool}")

    def _tip_mode(self):
        truth = self.truth
        if self.chance(0.5):
            self._go(full=True)
        word = self.by.tip[int(self.rng.integers(len(self.by.tip)))]
        self.say(f"{word} H{truth.tool}")
        truth.length = truth.tool
        truth.tip = True
        truth.fixed = truth.rotary() if self.by.fixed_where_switched else np.zeros(2)
        self.vectors = word == "G43.5"
        self._go(full=True)

    def _direction(self):
        """G43.5: words tell the direction of the tool, in the coordinates of the program."""
        truth = self.truth
        low, high = np.degrees([truth.chain.travel[name] for name in self.letters]).T
        present = truth.rotary()
        angles = np.clip(present + np.round(self.rng.uniform(-6.0, 6.0, 2), 3), 0.9 * low, 0.9 * high)
        axis = truth.axis(angles)
        if np.abs(axis[:2]).max() < 0.1:
            return  # near the pole another position may be as near
        held = truth.turns_part(truth.fixed)
        vector = truth.upright @ np.linalg.solve(truth.columns(held), axis)
        goal = np.round(self.rng.uniform(-40.0, 40.0, 3), 3)
        where = " ".join(self.word(x, v) for x, v in zip("XYZ", goal))
        self.say(f"G1 {where} " + " ".join(f"{x}{v:.12f}" for x, v in zip("IJK", vector)))
        nearest = min(truth.stands(axis), key=lambda each: np.abs((each - present + 180.0) % 360.0 - 180.0).max())
        if np.abs((nearest - angles + 180.0) % 360.0 - 180.0).max() > 1e-6:
            self.lines.pop()
            return
        _, turn = truth.shift()
        truth.move(goal, angles - turn)
        self.note()

    def _tip_off(self):
        self.say("G49")
        self.truth.tip, self.truth.length, self.vectors = False, None, False
        self.say(f"G43 H{self.truth.tool}")
        self.truth.length = self.truth.tool
