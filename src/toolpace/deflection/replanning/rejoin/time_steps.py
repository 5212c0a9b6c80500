"""The time steps of a rejoin motion, short at its start.

Cubic splines on them, in the coefficients c_0 to c_N+2; c_k has its say about the mean of t_k-2, t_k-1 and t_k.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from toolpace.common.arrays import Floats

FIRST = (0.125, 0.125, 0.25, 0.5)
"""Lengths of the first steps, over that of the others."""
PIECES, FINER = 18, 48
"""Steps of constant jerk: more where these find no way, or a long one. A motion at its limits leaves no room but for
one whose jerk changes just when its own does."""


@dataclass(frozen=True, eq=False)
class Mesh:
    """Steps over a time, and what a spline on them is made of."""

    times: Floats
    """(N + 1,) ends of the steps [s]."""
    places: Floats
    """(N + 3,) where each coefficient has its say: the coefficients of t."""
    squares: Floats
    """(N + 3,) the coefficients of t^2."""
    paces: Floats
    """(N,) where the control points of velocity have theirs, of c_k + 1 and c_k."""
    stencil: Floats
    """(4, N, 4) weights of c_k to c_k + 3 in the control points k of position, velocity, acceleration and jerk."""

    @classmethod
    @lru_cache(4)
    def of(cls, period: float, pieces: int) -> Mesh:
        """Over a time [s]."""
        unit = unit_mesh(pieces)
        orders = period ** -np.arange(4.0)[:, None, None]
        return cls(
            unit.times * period, unit.places * period, unit.squares * period**2, unit.paces * period,
            unit.stencil * orders,
        )  # fmt: skip

    def end_coefficients(self, state: Floats) -> Floats:
        """(3, m) last coefficients of splines with a state (3, m) at the end, where the steps are even."""
        h = self.times[-1] - self.times[-2]
        middle = state[0] - h * h / 6.0 * state[2]
        beside = h * h / 2.0 * state[2]
        return np.stack([middle - h * state[1] + beside, middle, middle + h * state[1] + beside])

    def jerks(self, c: Floats) -> Floats:
        """(N, m) of coefficients (N + 3, m)."""
        weights = self.stencil[3]
        found: Floats = sum(weights[:, d, None] * c[d : len(weights) + d] for d in range(4))
        return found


@lru_cache(2)
def unit_mesh(pieces: int) -> Mesh:
    """Over one second."""
    shares = np.array([*FIRST, *np.ones(pieces - len(FIRST))])
    times = np.concatenate([[0.0], np.cumsum(shares) / shares.sum()])
    first, last = times[1], times[-1] - times[-2]
    t = np.concatenate([[-2.0 * first, -first], times, times[-1] + last * np.arange(1.0, 4.0)])  # t_-2 is the first
    a, b, c = (t[i : i + pieces + 3] for i in range(3))
    k = np.arange(pieces)
    widths = (
        (t[k + 3] - t[k]) / 3.0, (t[k + 3] - t[k + 1]) / 2.0, t[k + 3] - t[k + 2],
        (t[k + 4] - t[k + 1]) / 3.0, (t[k + 4] - t[k + 2]) / 2.0, (t[k + 5] - t[k + 2]) / 3.0,
    )  # fmt: skip
    stencil = np.zeros((4, pieces, 4))
    stencil[0, :, 0] = 1.0
    slopes = [difference(d, w) for d, w in enumerate((widths[0], widths[3], widths[5]))]
    bends = [(slopes[1] - slopes[0]) / widths[1][:, None], (slopes[2] - slopes[1]) / widths[4][:, None]]
    stencil[1], stencil[2] = slopes[0], bends[0]
    stencil[3] = (bends[1] - bends[0]) / widths[2][:, None]
    return Mesh(times, (a + b + c) / 3.0, (a * b + b * c + c * a) / 3.0, ((b + c) / 2.0)[:pieces], stencil)


def difference(d: int, width: Floats) -> Floats:
    """(n, 4) weights of (c_k+d+1 - c_k+d) / width."""
    weights = np.zeros((len(width), 4))
    weights[:, d], weights[:, d + 1] = -1.0 / width, 1.0 / width
    return weights
