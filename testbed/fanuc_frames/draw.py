"""Random programs of frames and tools, with the place of the machine behind every motion."""

from __future__ import annotations

import numpy as np

from testbed.fanuc_frames.five_axes import STOPS, FiveAxes
from testbed.fanuc_frames.sheet import DIALECTS, Sheet
from testbed.fanuc_frames.truth import Truth
from testbed.true_tip.cases import BUILTIN
from testbed.true_tip.cases import MACHINES as EVERY

MACHINES = tuple(name for name in EVERY if name != "paper-ab")
"""But one whose X and Y run against those of the part: there words of joints and of the tip are not the same."""
MOST = 18
"""Statements of a program."""


class Program(FiveAxes):
    """One program of a seed; `places` is the truth."""

    def __init__(self, seed):
        super().__init__()
        self.rng = rng = np.random.default_rng(seed)
        self.by = DIALECTS[("fanuc", "fanuc", "mazak", "haas")[seed % 4]]
        self.machine = MACHINES[(seed // 4) % len(MACHINES)]
        self.with_rotary = bool(rng.random() < 0.25)
        self.sheet = self._sheet()
        self.truth = Truth((BUILTIN / f"{self.machine}.toml").read_text(), self.sheet)
        self.letters = self.truth.chain.rotary
        if self.with_rotary:
            for values in self.sheet.offsets.values():
                values[self.letters[-1]] = round(float(rng.uniform(-20.0, 20.0)), 3)
            self.truth.offsets = {name: dict(values) for name, values in self.sheet.offsets.items()}
        self.unit = 25.4 if rng.random() < 0.25 else 1.0
        self.vectors = False
        self._head()
        for _ in range(MOST):
            if not self._statement():
                break
        self.say("M30")

    def _sheet(self):
        rng = self.rng

        def place(size=60.0):
            return {letter: round(float(rng.uniform(-size, size)), 4) for letter in "XYZ"}

        names = ["G54", "G55", "G57", self.by.numbered.format(3), self.by.numbered.format(5)]
        tools = {k: round(float(rng.uniform(60.0, 220.0)), 3) for k in (1, 2, 3)}
        zero = np.round(rng.uniform(-100.0, 100.0, 3), 4)
        return Sheet(zero, {name: place() for name in names}, tools, place(150.0))

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
