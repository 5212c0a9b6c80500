"""A joint run from a function of a caller, with the sides of its breaks and a check of its derivatives.

All limits are held on what a function says of its derivatives: where these are not those of its positions, a motion
breaks limits that it is told to keep. Over a short cell of the parameter

    f(b, k) - f(a, k) = integral of f(s, k + 1) from a to b

the integral by the rule of Gauss with eight places. Where both differ the cell is cut again and again: at a jump of a
derivative they differ in one part of the cell, at a narrow turn not in the shortest ones, and where the derivative is
another function's in most of them, however short.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence

import numpy as np
import numpy.typing as npt

from toolpace.common.arrays import Bools, Floats
from toolpace.common.errors import PathError
from toolpace.common.workers import Lock
from toolpace.path.axis_run import AxisRun, SpeedCap

ROUNDINGS = 8.0
"""How far aside it is asked, and how far the function's own break may be from what is told, in roundings of s."""
CELLS = 64
"""Cells that are looked at along a path."""
LENGTH = 1e-3
"""Length of a cell, as a share of the path's."""
PARTS, LEVELS = 16, 3
"""Into how many parts a cell is cut where both sides differ, and how often."""
OFF = 1e-3
"""Share of a change by which its derivative's integral may differ from it."""
DIFFERENCE_ROUNDINGS = 256.0
"""How many roundings of the values may be in a difference."""
NOISE = 1e-6
"""Share of the even derivative, range over length to its order, below which one is noise: 1 - tanh(x)^2 is a rounding
far from its bend, and that over a small width cubed is told as a derivative."""


@functools.cache
def gauss() -> tuple[Floats, Floats]:
    """Places (10,) in a cell from 0 to 1: its ends, and those of Gauss' rule. The weights (8,) of the rule; sum 2."""
    x, weights = np.polynomial.legendre.leggauss(8)
    return np.concatenate([[0.0], 0.5 * (1.0 + x), [1.0]]), weights


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
        points = np.zeros(0) if hints is None else hints
        points = points[(points > s0) & (points < s1)]
        self.hints = np.unique(np.concatenate([[s0], points, [s1]])) if len(points) else points

    def evaluate(self, s: Floats) -> Floats:
        s = self.sides.aside(s)
        with self.lock:
            results = [self.f(s, order) for order in range(4)]
        values = [_real(value, f"f(s, {order})") for order, value in enumerate(results)]
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


def check_derivatives(
    evaluate: Callable[[Floats], Floats], s0: float, s1: float, columns: Sequence[str], name: str = "path"
) -> None:
    """Raise PathError where derivatives are not those of the order below, or not finite.

    `evaluate` gives value and derivatives 1 to 3 (4, n, c) at places (n,); `columns` (c,) are called so in the message.
    """
    length = LENGTH * (s1 - s0)
    golden = np.modf(np.arange(CELLS) * 0.5 * (np.sqrt(5.0) - 1.0))[0]
    starts = s0 + (np.arange(CELLS) + golden) / CELLS * (s1 - s0 - length)
    values = evaluate((starts[:, None] + length * gauss()[0]).ravel())[0]
    noise = NOISE * np.ptp(values, axis=0) / (s1 - s0) ** np.arange(1, 4)[:, None, None]
    off, _, _ = _compared(evaluate, starts, length, noise, name)
    for order, column in np.argwhere(off.any(axis=1)):
        cell = int(np.argmax(off[order, :, column]))
        start, width = float(starts[cell]), length
        for _ in range(LEVELS - 1):
            width /= PARTS
            parts = np.asarray(start + width * np.arange(PARTS), dtype=np.float64)
            still, now_declared, now_measured = _compared(evaluate, parts, width, noise, name)
            bad = still[order, :, column]
            if bad.sum() <= PARTS // 2:
                break
            start = float(parts[np.argmax(bad)])
            at = int(np.argmax(bad))
            declared, measured = now_declared[order, at, column], now_measured[order, at, column]
        else:
            raise PathError(
                f"{name}: f(s, {order + 1}) is not the derivative of f(s, {order}): at s = {start:.9g} it is "
                f"{declared:.6g} for {columns[column]}, where f(s, {order}) changes by {measured:.6g}; correct "
                "the function, or give points to Path.fit or AxisPath.from_waypoints"
            )


def _compared(
    evaluate: Callable[[Floats], Floats], starts: Floats, length: float, noise: Floats, name: str
) -> tuple[Bools, Floats, Floats]:
    """Of cells (n,) of one length: which are off (3, n, c); the derivative told, and the one found (3, n, c).

    `noise` (3, 1, c) is what derivatives may be off by.
    """
    points, of_rule = gauss()
    s = starts[:, None] + length * points
    jets = evaluate(s.ravel()).reshape(4, *s.shape, -1)
    if not np.isfinite(jets).all():
        order, cell, place, _ = np.argwhere(~np.isfinite(jets))[0]
        raise PathError(f"{name}: f(s, {order}) is not finite at s = {s[cell, place]:.9g}")
    change = jets[:3, :, -1] - jets[:3, :, 0]
    inside, weights = jets[1:, :, 1:-1], 0.5 * length * of_rule[None, None, :, None]
    integral, size = (weights * inside).sum(axis=2), (weights * np.abs(inside)).sum(axis=2)
    eps = float(np.finfo(float).eps)
    # a column that stands still may be what is left of terms as large as another column
    values = np.abs(jets[:3]).max(axis=(2, 3))[:, :, None]
    rounding = eps * (values + np.abs(s).max() * np.abs(jets[1:]).max(axis=2))
    allowed = OFF * np.maximum(np.abs(change), size) + DIFFERENCE_ROUNDINGS * rounding + length * noise
    off = np.abs(change - integral) > allowed
    return off, integral / length, change / length
