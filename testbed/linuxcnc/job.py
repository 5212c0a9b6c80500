"""A program for LinuxCNC with the tables of its controller, and the machine on which both readings are compared."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from testbed.linuxcnc.canon import INCH
from toolpace.common.arrays import Bools, Floats
from toolpace.common.units import DEGREE, MILLIMETRE
from toolpace.programs.reading.coordinates.setup import SetUp, Tool

OFFSETS = ("G54", "G55", "G56", "G57", "G58", "G59", "G59.1", "G59.2", "G59.3")
AXES = "XYZAC"
OF_PARAMETERS = dict(zip("XYZABC", range(1, 7)))


class Cartesian:
    """A machine with linear joints along its axes, and rotary ones, A and C, that carry nothing."""

    name = "cartesian"
    joints = tuple(AXES)
    rotary = (3, 4)
    travel: Floats = np.array([[-np.inf, np.inf]] * 5)
    tool_length = 0.075

    def forward(self, q: Floats, /) -> tuple[Floats, Floats]:
        """Tip (n, 3) and tool axis (n, 3)."""
        return q[:, :3] - [0.0, 0.0, self.tool_length], np.tile([0.0, 0.0, 1.0], (len(q), 1))

    def rotary_solutions(self, axis: Floats, /) -> tuple[Floats, Bools]:
        """It turns to no axis."""
        return np.full((len(axis), 2, 2), np.nan), np.zeros(len(axis), dtype=bool)


@dataclass(frozen=True)
class Job:
    """A program, and the controller's tables."""

    text: str
    offsets: dict[str, dict[str, float]] = field(default_factory=dict)
    """Work offsets by name and axis letter [mm, deg]."""
    references: dict[int, dict[str, float]] = field(default_factory=dict)
    """Of G28 (1) and G30 (2)."""
    tools: dict[int, float] = field(default_factory=dict)
    """Lengths [mm] by number."""
    radii: dict[int, float] = field(default_factory=dict)
    """Of tools [mm], by number."""
    numbered: bool = True
    """Whether N words are the numbers of their lines."""
    beside: Path | None = None
    """A folder with the files that the program calls."""

    def parameters(self) -> dict[int, float]:
        """Of the interpreter: 5161 and 5181 on are the references, 5221 on the offsets, twenty apart."""
        found = {5220: 1.0}
        for first, places in ((5160, self.references.get(1, {})), (5180, self.references.get(2, {}))):
            found |= {first + OF_PARAMETERS[letter]: _table(letter, value) for letter, value in places.items()}
        for name, place in self.offsets.items():
            first = 5220 + 20 * OFFSETS.index(name)
            found |= {first + OF_PARAMETERS[letter]: _table(letter, value) for letter, value in place.items()}
        return found

    def setup(self) -> SetUp:
        """The same tables as our set-up sheet."""
        zero = dict.fromkeys(AXES, 0.0)
        return SetUp(
            offsets={name: {a: _si(a, self.offsets.get(name, {}).get(a, 0.0)) for a in AXES} for name in OFFSETS},
            references={n: {a: _si(a, self.references.get(n, {}).get(a, 0.0)) for a in AXES} for n in (1, 2)},
            machine_zero=zero,
            tools={
                str(n): Tool(length * MILLIMETRE, self.radii[n] * MILLIMETRE if n in self.radii else None)
                for n, length in self.tools.items()
            },
            start=zero,
        )


def _table(letter: str, value: float) -> float:
    return value if letter in "ABC" else value / INCH


def _si(letter: str, value: float) -> float:
    return value * (DEGREE if letter in "ABC" else MILLIMETRE)
