"""A joint run from a function of (s, order), and the sides of its breaks."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from toolpace.common.arrays import Floats
from toolpace.common.errors import PathError
from toolpace.common.workers import Lock
from toolpace.path.axispath.cap import SpeedCap
from toolpace.path.axispath.run import AxisRun

ROUNDINGS = 8.0
"""How far aside it is asked, and how far the function's own break may be from what is told, in roundings of s."""


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


class Sides:
    """Breaks of a run from s0 to s1; those that lie within rounding of each other are one."""

    def __init__(self, breaks: Floats, s0: float, s1: float) -> None:
        """Take the breaks (k,) in order."""
        self.width = ROUNDINGS * float(np.spacing(max(abs(s0), abs(s1))))
        inside = breaks[(breaks > s0) & (breaks < s1)]
        new = np.diff(inside, prepend=-np.inf) > 3.0 * self.width
        self.first, self.last = inside[new], inside[np.append(new[1:], True)] if len(inside) else inside
        # what is an end of the run but for rounding has one side only
        at_start, at_end = self.first <= s0 + 2.0 * self.width, self.last >= s1 - 2.0 * self.width
        self.only_right, self.only_left = at_start, at_end & ~at_start
        self.breaks: Floats = self.first[~at_start & ~at_end]
        """(j,) the breaks inside the run, each told once."""

    def aside(self, s: Floats) -> Floats:
        """(n,) where to ask for the path at s (n,): what is at a break, or above it, belongs to its right side."""
        if len(self.first) == 0:
            return s
        after = np.searchsorted(self.first, s, side="right") - 1
        k = np.maximum(after, 0)
        right = (after >= 0) & (s < self.last[k] + self.width)
        out = np.where(right, np.where(self.only_left[k], self.first[k] - self.width, self.last[k] + self.width), s)
        k = np.minimum(after + 1, len(self.first) - 1)
        left = (after + 1 < len(self.first)) & (s > self.first[k] - self.width) & ~right
        aside: Floats = np.where(
            left, np.where(self.only_right[k], self.last[k] + self.width, self.first[k] - self.width), out
        )
        return aside
