"""Random motions of a program, in the words of its control."""

from __future__ import annotations

import numpy as np

from testbed.fanuc_frames.sheet import Dialect, Place, Sheet
from testbed.fanuc_frames.truth import Truth


class Motions:
    """Lines of a program and the places behind them; `truth` says where a motion ends."""

    rng: np.random.Generator
    by: Dialect
    sheet: Sheet
    truth: Truth
    letters: str
    """Of the rotary axes."""
    unit: float
    """Millimetres of a unit of length."""
    vectors: bool
    """Whether words tell the direction of the tool."""

    def __init__(self):
        self.lines: list[str] = []
        self.places: list[Place] = []

    def text(self):
        return "\n".join(self.lines) + "\n"

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
