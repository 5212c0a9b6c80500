"""Speed-dependent weights of the spline fit, from the speed law of a motion along the path.

A path P(s) that is passed at the pace s(t) has the acceleration and the jerk

    P'' v^2 + P' a        P''' v^3 + 3 P'' v a + P' j            v, a, j = ds/dt, d2s/dt2, d3s/dt3

and its roughness at that pace is the integral of their squares. Where the motion is slow by itself a bend costs next
to nothing; where it is fast it costs time. The pace is smoothed, s(t) being a mean over a short time: what is best for
a pace that dips for a moment would keep the dip. Both are linear in P, so that a cell has rows as its third derivative
has: jerk at the two points of Gauss' rule, acceleration in the middle.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from toolpace.common.arrays import Floats, number, numbers
from toolpace.common.errors import UsageError

ACCELERATION = 8.0
"""What acceleration counts beside jerk, both over their limits: a wide tube is left to it, a narrow one to jerk."""
GAUSS_POINTS = np.array([-1.0, 0.0, 1.0]) / np.sqrt(3.0)
"""Of the rows in a cell, from -1 to 1."""
WEIGHTS = np.array([0.5, 1.0, 0.5])
"""Of their squares, in cell lengths."""
SLOWEST = 0.02
"""Least speed in the weights of a fit, as a share of the highest: what is passed more slowly weighs next to nothing."""
STEPS_OF_MEAN, MOST_STEPS = 4, 1_000_000
"""Places in the time over which that speed is a mean, and most of them in all."""


@dataclass(frozen=True, eq=False)
class SpeedWeights:
    """The pace of a motion along one run, by which the roughness of a fit is weighed."""

    s: Floats
    """(n,) ascending parameters, from the start of the run on [m]."""
    pace: Floats
    """(3, n) ds/dt there and its first two derivatives by time, smoothed [m/s, m/s^2, m/s^3]."""
    ramp: float
    """The time in which an acceleration builds up [s]."""
    power: float
    """Of ds/dt in the weight of the squared third derivative: 5 is the integral over time, 6 that over the way."""

    def __post_init__(self) -> None:
        s = numbers(self.s, "speed weights: s", ("n",), unit="m")
        if len(s) < 2 or (np.diff(s) < 0.0).any():
            raise UsageError("speed weights: s must ascend, and have two places at least")
        object.__setattr__(self, "s", s)
        object.__setattr__(self, "pace", numbers(self.pace, "speed weights: pace", (3, len(s))))
        if not (self.pace[0] > 0.0).all():
            raise UsageError("speed weights: pace[0] is ds/dt, and must lie above zero everywhere")
        number(self.ramp, "speed weights: ramp", least=0.0, above=True, unit="s")
        number(self.power, "speed weights: power")

    def mean_with(self, other: SpeedWeights) -> SpeedWeights:
        """The mean of both paces: what goes to and fro between two motions settles."""
        before = np.stack([np.interp(self.s, other.s, each) for each in other.pace])
        return SpeedWeights(self.s, 0.5 * (self.pace + before), self.ramp, self.power)

    def rows(self, breaks: Floats, unit: float) -> tuple[Floats, Floats]:
        """Rows (cells, 3, 6) whose products with the coefficients, squared and summed, are the roughness of a cell, and
        what it weighs (cells,) where its third derivative alone counts, at the highest pace 1.

        Breaks (cells + 1,) are in units [m], from the start of the run.
        """
        breaks = numbers(breaks, "speed weights: breaks", ("n",))
        if len(breaks) < 2 or not (np.diff(breaks) > 0.0).all():
            raise UsageError("speed weights: breaks must ascend, and be two at least")
        unit = number(unit, "speed weights: unit", least=0.0, above=True, unit="m")
        h = np.diff(breaks)
        inside = 0.5 * h[:, None] * (1.0 + GAUSS_POINTS)
        at = unit * (breaks[:-1, None] + inside)
        # in units of the highest pace, and of the time in which it passes one unit of length
        top = self.pace[0].max()
        v, a, j = (np.interp(at, self.s, each) * (unit / top) ** k / top for k, each in enumerate(self.pace))
        first, second, third = basis_derivatives(breaks, inside)
        rows = third * (v**3)[:, :, None] + 3.0 * second * (v * a)[:, :, None] + first * j[:, :, None]
        felt = second * (v**2)[:, :, None] + first * a[:, :, None]
        rows[:, 1] = ACCELERATION * unit / (top * self.ramp) * felt[:, 1]
        share = np.sqrt(WEIGHTS * h[:, None] * v ** (self.power - 6.0))
        weight: Floats = v.mean(axis=1) ** self.power
        return rows * share[:, :, None], weight


def weights_of_motion(
    at: Callable[[Floats], Floats], s0: float, duration: float, smoothed: float, ramp: float, power: float
) -> SpeedWeights:
    """Weights by the speed of a time law, `at` (n,) -> (4, n), that begins at `s0`; see `TimeLaw.speed_weights`."""
    count = int(np.clip(np.ceil(STEPS_OF_MEAN * duration / smoothed), 2, MOST_STEPS)) + 1
    t = np.linspace(0.0, duration, count)
    before = at(np.maximum(t - 0.5 * smoothed, 0.0))
    after = at(np.minimum(t + 0.5 * smoothed, duration))
    pace = (after[:3] - before[:3]) / smoothed
    least = SLOWEST * pace[0].max()
    pace[1:, pace[0] < least] = 0.0
    pace[0] = np.maximum(pace[0], least)
    return SpeedWeights(at(t)[0] - s0, pace, ramp, power)


def basis_derivatives(breaks: Floats, inside: Floats) -> list[Floats]:
    """Derivatives 1 to 3, each (cells, k, 6), of the six basis functions of each cell, `inside` (cells, k) of its left
    end."""
    from toolpace.kernels.fit.quintic_spline import pieces
    from toolpace.path.fit.spline import knots_of

    cells = len(breaks) - 1
    # of any six neighbouring coefficients each has a column of its own
    coefficient = np.zeros((cells + 5, 6))
    coefficient[np.arange(cells + 5), np.arange(cells + 5) % 6] = 1.0
    column = (np.arange(cells)[:, None] + np.arange(6)) % 6
    taylor = np.take_along_axis(pieces(knots_of(breaks), coefficient), column[:, None, :], axis=2)
    out = []
    for _ in range(3):
        taylor = taylor[:, 1:] * np.arange(1.0, taylor.shape[1])[:, None]
        value = np.zeros((*inside.shape, 6))
        for power in reversed(range(taylor.shape[1])):
            value = value * inside[:, :, None] + taylor[:, power, None]
        out.append(value)
    return out
