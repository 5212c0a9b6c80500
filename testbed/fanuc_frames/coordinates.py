"""Random statements that move, mirror, scale and turn the coordinates, or change the tool."""

from __future__ import annotations

import numpy as np

from testbed.fanuc_frames.motions import Motions
from testbed.fanuc_frames.truth import Laid


class Coordinates(Motions):
    """Offsets, tool lengths, and what is laid over the coordinates."""

    with_rotary: bool
    """Whether offsets have words of a rotary axis."""

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
