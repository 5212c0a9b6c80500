"""What every block of a random program is written with: a seed, a machine, words and their values."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from testbed.true_tip.chain import Chain

BUILTIN = Path(__file__).parents[2] / "src" / "toolpace" / "machine" / "builtin"
MACHINES = (
    "xyzac-trunnion", "xyzbc-trunnion", "xyzab-trunnion-inch", "xyzbc-table", "xyzab-table", "linuxcnc-xyzac-trt",
    "xyzbc-head", "xyzac-head", "linuxcnc-xyzbc-bridgemill", "xyzbc-nutating", "xyzbc-nutating-large",
    "xyzbc-millturn",
)  # fmt: skip
MM = 1e-3


class Words:
    """Words at random, and what stands in the program at a time."""

    def __init__(self, seed):
        self.rng = rng = np.random.default_rng(seed)
        self.machine = MACHINES[seed % len(MACHINES)]
        self.chain = Chain((BUILTIN / f"{self.machine}.toml").read_text())
        self.inch = bool(rng.random() < 0.2)
        self.unit = 25.4 * MM if self.inch else MM
        self.zero = np.round(rng.uniform(-0.2, 0.5, 3), 4)
        self.presets = {str(k): np.round(rng.uniform(-0.1, 0.1, 3), 4) for k in (1, 2, 3)}
        self.tools = {str(k): round(float(rng.uniform(0.03, 0.25)), 5) for k in (1, 2, 3)}
        self.lines = [f"BEGIN PGM S{seed} {'INCH' if self.inch else 'MM'}"]
        self.steps: list[tuple[int, str, tuple]] = []
        self.plane = self.turned = self.tip = self.spatial = self.told_angles = False
        self.axial_before = self.oversize = False
        self.kinds: set[str] = set()
        self.under: set[str] = set()
        """Transformations in force, before the plane or in it."""
        self.loose = self.chance(0.15)
        """Whether the program may write what is refused."""
        self.said: set[str] = set()

    # Words

    def chance(self, share):
        return bool(self.rng.random() < share)

    def pick(self, *choices):
        return choices[int(self.rng.integers(len(choices)))]

    def say(self, text, method="", *arguments):
        """A block, and the method for it."""
        for line in text.split("\n"):
            self.lines.append(line)
        if method:
            self.said.add(method)
            self.steps.append((len(self.lines), method, arguments))

    def number(self, low, high, digits=3):
        return round(float(self.rng.uniform(low, high)), digits)

    def axes(self, letters, low=-60.0, high=60.0):
        """Words of some of these letters, with value [m] and whether incremental."""
        told, given = [], {}
        for letter in letters:
            if self.chance(0.7):
                adds, value = self.chance(0.25), self.number(low, high)
                value = value / 3.0 if adds else value
                value = round(value, 4)
                told.append(f"{'I' if adds else ''}{letter}{value:+g}")
                given[letter] = (value * self.unit, adds)
        return " ".join(told), given

    def rotary(self, incremental=True):
        """Words of some rotary axes, with value [deg] and whether incremental."""
        told, given = [], {}
        for name in self.chain.rotary:
            low, high = np.degrees(self.chain.travel[name])
            adds = incremental and self.chance(0.2)
            span = 4.0 if adds else min(35.0, 0.6 * high, -0.6 * low)
            if high - low > 1000.0 and not adds and self.chance(0.2):
                span = 300.0  # an axis without end
            value = self.number(-span, span)
            if self.chance(0.7):
                told.append(f"{'I' if adds else ''}{name}{value:+g}")
                given[name] = (value, adds)
        return " ".join(told), given

    def feed(self):
        return self.pick("FMAX", "F1500", "F800")
