"""Paths by their jets: functions of s (n,) that give position and three derivatives (4, n, joints) at once."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from toolpace.common.arrays import Floats
from toolpace.path.axis_path import AxisPath

Jets = Callable[[Floats], Floats]


class Remembered:
    """A callable f(s, order) made of one that gives all orders at once; the last s is remembered."""

    def __init__(self, jets: Jets) -> None:
        self.jets, self.lock = jets, threading.Lock()
        self.s = np.empty(0)
        self.values = np.empty((4, 0, 0))

    def __call__(self, s: Floats, order: int) -> Floats:
        # two runs may share it, and be asked from two threads
        with self.lock:
            if s is not self.s and not np.array_equal(s, self.s):
                self.s, self.values = np.array(s), self.jets(s)
            return self.values[order]

    def forget(self) -> None:
        """Forget the last s: the next planner asked on the same mesh shall pay for the path, too."""
        self.s = np.empty(0)


def path_of(jets: Jets, s0: float = 0.0, s1: float = 1.0, **options: Any) -> AxisPath:
    """An AxisPath of one run; options as of `AxisPath.from_callable`."""
    return AxisPath.from_callable(Remembered(jets), s0, s1, **options)


def harmonics(random: np.random.Generator, joints: int, modes: int = 4) -> Jets:
    """A smooth random path, each joint a sum of harmonics."""
    number = np.pi * np.arange(1, modes + 1)
    a, b = random.normal(size=(2, modes, joints)) / np.arange(1, modes + 1)[:, None] ** 1.5

    def jets(s: Floats) -> Floats:
        angle = s[:, None] * number
        turned = [angle + 0.5 * np.pi * order for order in range(4)]
        return np.stack([(np.sin(t) * number**k) @ a + (np.cos(t) * number**k) @ b for k, t in enumerate(turned)])

    return jets


def straight(way: npt.ArrayLike) -> Jets:
    """A straight line from zero that gains `way` (joints,) a unit of s."""
    slope = np.asarray(way, dtype=float)

    def jets(s: Floats) -> Floats:
        out = np.zeros((4, len(s), len(slope)))
        out[0], out[1] = s[:, None] * slope, slope
        return out

    return jets


def standing(place: Floats) -> Jets:
    """A path that stays at a place (joints,)."""
    return lambda s: np.stack([np.tile(place, (len(s), 1)), *np.zeros((3, len(s), len(place)))])


def along(jets: Jets, g: Jets) -> Jets:
    """A path at the parameter g(s): g gives (4, n). The chain rule to third order."""

    def composed(s: Floats) -> Floats:
        x, x1, x2, x3 = g(s)
        q = jets(x)
        d1, d2, d3 = x1[:, None], x2[:, None], x3[:, None]
        return np.stack(
            [
                q[0],
                q[1] * d1,
                q[2] * d1**2 + q[1] * d2,
                q[3] * d1**3 + 3.0 * q[2] * d1 * d2 + q[1] * d3,
            ]
        )

    return composed


def beside(*parts: Jets) -> Jets:
    """All joints of several paths."""
    return lambda s: np.concatenate([part(s) for part in parts], axis=2)
