"""Random statements of tilted planes, tip mode and tool vectors."""

from __future__ import annotations

import numpy as np

from testbed.fanuc_frames.coordinates import Coordinates
from testbed.fanuc_frames.truth import euler, turned

STOPS = "the rule of G53.1 leaves it open which position the rotary axes take"


class FiveAxes(Coordinates):
    """Planes that the tool stands on, and motions in which the tip keeps its place."""

    plane_off = ""
    """The word that ends the plane in force, where it is not the usual one."""
    follows = False
    """Whether tip mode is on in the plane in force."""

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
