"""A random program's set-up sheet, the words of its control, and the places that it must reach."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


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
