"""What all steps of random programs have: a machine, a set-up sheet, numbers, and motions by words."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from testbed.sinumerik_frames.truth import DEG, MM, Truth
from testbed.true_tip.cases import BUILTIN
from testbed.true_tip.chain import Chain

MACHINES = (
    "xyzac-trunnion", "xyzbc-trunnion", "xyzab-trunnion-inch", "xyzbc-table", "xyzab-table", "linuxcnc-xyzac-trt",
    "xyzbc-head", "xyzac-head", "linuxcnc-xyzbc-bridgemill", "xyzbc-nutating", "xyzbc-nutating-large", "xyzbc-millturn",
    "paper-ab",
)  # fmt: skip
Act = Callable[[Truth, "Found"], None]


class Found(ABC):
    """What the act of a step may ask of the path that was read: the rotary joints that a direction was reached with."""

    @abstractmethod
    def rotary(self, direction: np.ndarray) -> dict[str, float]:
        """Joints by name [rad], that bring the tool to a direction (3,) on the part."""


@dataclass
class Step:
    """A block, and its act."""

    text: str
    act: Act
    straight: bool = False
    """Whether X, Y and Z go straight in it: the tip on the part where they mean that, else the slides."""
    counts: bool = True
    """Whether distances behind it count from where the machine is; else from the words of before (SD42440 = 1)."""


class Maker:
    """The machine, the sheet and the blocks of one program of a seed."""

    def __init__(self, seed: int, machine: str | None = None) -> None:
        self.rng = np.random.default_rng(seed)
        self.machine = machine or MACHINES[seed % len(MACHINES)]
        self.chain = Chain((BUILTIN / f"{self.machine}.toml").read_text())
        self.length = round(float(self.chain.own_length * self.rng.uniform(0.5, 1.5)), 5)
        self.heads = [name for name in self.chain.tool if name in self.chain.rotary]
        self.tables = [name for name in self.chain.workpiece if name in self.chain.rotary]
        self.carried = self.rng.random() < 0.4
        """Whether offsets and shifts have words of the table's axes, with which planes are refused."""
        self.inches = bool(self.rng.random() < 0.2)
        """Whether the program is in inches (G700)."""
        self.zero = np.round(self.rng.uniform(-0.2, 0.5, 3), 4)
        self.offsets = self._offsets()
        self.steps: list[Step] = []
        self.traori = self.tilted = self.waiting = self.upon = False
        """TRAORI; a plane of CYCLE800; one whose axes the program must turn; a frame of TOROT upon another."""
        self.assigned = False
        """Whether $P_PFRAME was assigned, upon which G58 and G59 are refused."""
        self.even = True
        """Whether no uneven scale is in force."""
        self.kind = "ORIEULER"

    def _offsets(self):
        made = {None: (np.zeros(3), {})}
        for name in ("G54", "G55", "G505"):
            turned = {}
            for letter in self.chain.rotary:
                if self.rng.random() < 0.3 and (letter in self.heads or self.carried):
                    turned[letter] = float(np.round(self.rng.uniform(-20, 20), 3)) * DEG
            made[name] = (np.round(self.rng.uniform(-0.1, 0.1, 3), 4), turned)
        return made

    def truth(self):
        """The control before the first block."""
        made = Truth(self.chain, self.length, self.zero, self.offsets, 25.4 * MM if self.inches else MM)
        made.offset = "G54"
        return made

    def sheet(self):
        """The set-up sheet."""
        parts = ["[units]", 'length = "mm"', 'angle = "deg"', "[tools.1]", f"length = {self.length / MM:.6f}"]
        parts += ["[machine_zero]", *(f"{x} = {v / MM:.6f}" for x, v in zip("XYZ", self.zero))]
        for name, (at, turned) in self.offsets.items():
            if name is None:
                continue
            parts += [f"[offsets.{name}]", *(f"{x} = {v / MM:.6f}" for x, v in zip("XYZ", at))]
            parts += [f"{x} = {v / DEG:.6f}" for x, v in turned.items()]
        return "\n".join(parts) + "\n"

    def text(self):
        """The program."""
        return "\n".join(step.text for step in self.steps) + "\n"

    # Numbers

    def number(self, most):
        return float(np.round(self.rng.uniform(-most, most), 3))

    def some(self, letters, least=1):
        """Some of the letters, in any order."""
        count = int(self.rng.integers(least, len(letters) + 1))
        return [str(x) for x in self.rng.permutation(list(letters))[:count]]

    def angle(self, letter):
        """An angle that every machine reaches [deg]."""
        return self.number(25.0 if letter != "C" else 60.0)

    # Steps

    def say(self, text, act: Act, *, straight=False, counts=True):
        self.steps.append(Step(text, act, straight, counts))

    def _motion(self, place):
        """A block with words by letter."""
        slides = {x: v for x, v in place.items() if x in "XYZ"}
        turned = {x: v for x, v in place.items() if x not in "XYZ"}
        words = " ".join(f"{x}{v:.3f}" if x in "XYZ" else f"{x}={v:.3f}" for x, v in place.items())

        def act(truth, found):
            joints = {x: v * DEG + truth.shifts()[x] for x, v in turned.items()}
            if truth.tilted and not truth.traori and not slides:
                truth.turn(joints)
            else:
                truth.move(slides, joints)

        self.say(f"{'G0' if self.rng.random() < 0.3 else 'G1'} {words}", act, straight=True)
