"""The kinematics of the model: a product of turns, from the numbers of a machine file, in millimetres and degrees."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from testbed.one_program import frames
from toolpace.common.arrays import Floats

FILES = Path(__file__).parents[2] / "src" / "toolpace" / "machine" / "builtin"


@dataclass(frozen=True)
class Joint:
    """A rotary joint: its letter, axis (3,) and a point (3,) of it, in the frame of the bed at zero."""

    letter: str
    axis: Floats
    point: Floats


@dataclass(frozen=True)
class Kinematics:
    """A machine of X, Y, Z and two rotary joints; X, Y and Z carry the tool."""

    name: str
    table: tuple[Joint, ...]
    """From the bed to the part."""
    head: tuple[Joint, ...]
    """From the slides to the spindle."""
    letters: tuple[str, str]
    """Of the rotary joints, in the order of the columns of a tool path: those of the table first."""
    origin: Floats
    """(3,) of the part, at zero."""
    nose: Floats
    """(3,) of the spindle, at zero."""
    own_length: float
    top: Floats
    """(3,) upper ends of travel of X, Y, Z."""
    known: dict[tuple[bool, float, float], Floats] = field(default_factory=dict)
    """Products of single rotary positions: those that stand are asked for again and again."""

    @staticmethod
    @cache
    def load(name: str) -> Kinematics:
        """From a built-in machine file in millimetres and degrees."""
        told: dict[str, Any] = tomllib.loads((FILES / f"{name}.toml").read_text())
        chain, joints = told["chain"], told["joints"]
        assert chain["tool"][:3] == ["X", "Y", "Z"] and told["units"] == {"length": "mm", "angle": "deg"}

        def rotary(letter: str) -> Joint:
            return Joint(letter, np.array(joints[letter]["direction"], float), np.array(joints[letter]["point"], float))

        table, head = tuple(map(rotary, chain["workpiece"])), tuple(map(rotary, chain["tool"][3:]))
        first, second = (joint.letter for joint in (*table, *head))
        origin, nose = (np.array(chain[key], float) for key in ("workpiece_origin", "spindle_nose"))
        top = np.array([joints[letter]["travel"][1] for letter in "XYZ"], float)
        return Kinematics(name, table, head, (first, second), origin, nose, chain["tool_length"], top)

    def _product(self, chain: tuple[Joint, ...], rotary: Floats) -> Floats:
        """Of rotary positions (2,), or of many (n, 2)."""
        key = (chain is self.table, float(rotary.flat[0]), float(rotary.flat[1]))
        if rotary.ndim == 1 and key in self.known:
            return self.known[key]
        made = np.eye(4)
        for joint in chain:
            made = made @ frames.turn(joint.axis, rotary[..., self.letters.index(joint.letter)], joint.point)
        if rotary.ndim == 1:
            self.known[key] = made
        return made

    def carried(self, rotary: Floats) -> Floats:
        """Points of the part to where the table has carried them, about the part's origin at zero (4, 4)."""
        return frames.shift(-self.origin) @ self._product(self.table, rotary) @ frames.shift(self.origin)

    def linear(self, tip: Floats, rotary: Floats, length: float) -> Floats:
        """Joints X, Y, Z (3,) of a tip on the part."""
        held = frames.on(self._product(self.head, rotary), self.nose - [0.0, 0.0, length])
        return np.asarray(frames.on(self._product(self.table, rotary), self.origin + tip) - held)

    def tip(self, linear: Floats, rotary: Floats, length: float) -> Floats:
        """The tip (3,) on the part of joints X, Y, Z."""
        held = frames.on(self._product(self.head, rotary), self.nose - [0.0, 0.0, length])
        return np.asarray(frames.on(frames.undo(self._product(self.table, rotary)), linear + held) - self.origin)

    def axis(self, rotary: Floats) -> Floats:
        """The unit vector (3,) from the tip to the spindle, on the part."""
        table, head = self._product(self.table, rotary), self._product(self.head, rotary)
        turned = np.swapaxes(table[..., :3, :3], -1, -2) @ head[..., :3, 2, None]
        return np.asarray(turned[..., 0])
