"""A run that a function of (s, order) gives."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from toolpace.common.arrays import Floats
from toolpace.common.errors import PathError
from toolpace.common.workers import Lock
from toolpace.path.axispath.cap import SpeedCap
from toolpace.path.axispath.run import AxisRun
from toolpace.path.axispath.sides import Sides


class CallableRun(AxisRun):
    """A run given by a function of (s, order)."""

    def __init__(
        self,
        f: Callable[[Floats, int], npt.ArrayLike],
        s0: float,
        s1: float,
        speed_cap: float | Callable[[Floats], npt.ArrayLike],
        breaks: Floats,
        hints: Floats | None = None,
    ) -> None:
        # a caller's function may remember what it was asked last
        self.f, self.lock = f, Lock()
        self.cap = SpeedCap(speed_cap, self.lock)
        self.smooth_cap = not callable(speed_cap)
        self.s0, self.s1, self.sides = s0, s1, Sides(breaks, s0, s1)
        self.breaks = self.sides.breaks
        places = np.zeros(0) if hints is None else hints
        places = places[(places > s0) & (places < s1)]
        self.hints = np.unique(np.concatenate([[s0], places, [s1]])) if len(places) else places

    def evaluate(self, s: Floats) -> Floats:
        s = self.sides.aside(s)
        with self.lock:
            given = [self.f(s, order) for order in range(4)]
        values = [_real(value, f"f(s, {order})") for order, value in enumerate(given)]
        for order, value in enumerate(values):
            if value.ndim != 2 or value.shape != (len(s), values[0].shape[-1]):
                raise PathError(
                    f"path: f(s, {order}) has shape {value.shape} for {len(s)} values of s, not (n, joints)"
                )
            if not np.isfinite(value).all():
                where = s[np.argmin(np.isfinite(value).all(axis=1))]
                raise PathError(f"path: f(s, {order}) is not finite at s = {where:.9g}")
        return np.stack(values)

    def speed_cap(self, s: Floats) -> Floats:
        return self.cap.at(self.sides.aside(s))


def _real(value: npt.ArrayLike, name: str) -> Floats:
    """What a caller's function gave, as real numbers of any shape. Raises PathError where it gave others."""
    found = np.asarray(value)
    if found.dtype.kind not in "iuf":
        raise PathError(f"path: {name} gives {found.dtype}; give real numbers (n, joints)")
    return found.astype(np.float64, copy=False)
