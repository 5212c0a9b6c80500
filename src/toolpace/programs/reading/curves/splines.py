"""Cubic B-splines of programs."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from toolpace.common.arrays import Floats, Ints
from toolpace.programs.reading.curves.arcs import SAG

DEGREE = 3
KNOT_DECIMALS = 10
"""Knots that agree to so many decimals are one knot: programs write seven."""


class SplineError(ValueError):
    """A spline that cannot be; the message says why and what to write."""


class Spline(NamedTuple):
    """A cubic B-spline from its first control point to its last."""

    knots: Floats
    """(n + 4,) from 0 to 1, not falling; the first four and the last four are equal."""
    points: Floats
    """(n, 3) control points [m]."""

    @staticmethod
    def clamped(inner: Floats, points: Floats) -> Spline:
        """Spline of control points (n, 3) with knots (n - 4,) between 0 and 1; SplineError where they do not fit."""
        inner = np.round(np.asarray(inner, dtype=float), KNOT_DECIMALS)
        if len(points) != len(inner) + DEGREE + 1:
            raise SplineError(
                f"{len(points)} control points need {len(points) - DEGREE - 1} inner knots, and there are "
                f"{len(inner)}: is the program complete?"
            )
        knots = np.concatenate((np.zeros(DEGREE + 1), inner, np.ones(DEGREE + 1)))
        if (np.diff(knots) < 0).any():
            raise SplineError("the knots do not rise from 0 to 1: correct them")
        if len(inner) >= DEGREE + 1 and (inner[DEGREE:] - inner[:-DEGREE] <= 0).any():
            raise SplineError("a knot stands more than three times, where the curve breaks: write two curves")
        if len(inner) and (inner[0] <= 0 or inner[-1] >= 1):
            raise SplineError("an inner knot is 0 or 1, where the curve begins and ends: leave it out")
        return Spline(knots, np.asarray(points, dtype=float))

    def pieces(self) -> int:
        """How many chords keep within SAG."""
        return int(self._chords()[1].sum())

    def parameters(self) -> Floats:
        """Parameters (k,) > 0 up to 1 of the ends of chords that keep within SAG of the curve."""
        spans, count = self._chords()
        length = np.diff(self.knots)[spans]
        span = np.repeat(np.arange(len(spans)), count)
        step = np.arange(1, len(span) + 1) - np.repeat(np.cumsum(count) - count, count)
        t = self.knots[spans][span] + length[span] * (step / count[span])
        t[-1] = 1.0
        return np.asarray(t)

    def evaluate(self, t: Floats) -> Floats:
        """Points (k, 3) [m] at parameters t (k,), by de Boor's recursion."""
        k, p = self.knots, DEGREE
        j = np.clip(np.searchsorted(k, t, side="right") - 1, p, len(k) - p - 2)
        d = [self.points[j - p + i] for i in range(p + 1)]
        for r in range(1, p + 1):
            for i in range(p, r - 1, -1):
                left, right = k[j - p + i], k[j + 1 + i - r]
                share = ((t - left) / (right - left))[:, None]
                d[i] = (1 - share) * d[i - 1] + share * d[i]
        return np.asarray(d[p])

    def _chords(self) -> tuple[Ints, Ints]:
        """Spans (m,) of some length, and how many chords each takes.

        The second derivative is linear within a span, between two of its control points; a chord over a step h is off
        by at most h^2 / 8 of its greatest value (de Boor 1978, A Practical Guide to Splines).
        """
        spans = np.flatnonzero(np.diff(self.knots) > 0)
        bend = np.linalg.norm(self._second_derivatives(), axis=1)
        most = np.maximum(bend[spans - DEGREE], bend[spans - DEGREE + 1])
        count = np.ceil(np.diff(self.knots)[spans] * np.sqrt(most / (8 * SAG)))
        return spans, np.maximum(1, count).astype(np.int64)

    def _second_derivatives(self) -> Floats:
        """Control points (n - 2, 3) of the second derivative."""
        k, p = self.knots, DEGREE
        n = len(self.points)
        first = p * np.diff(self.points, axis=0) / _width(k[p + 1 : n + p] - k[1:n])
        return np.asarray((p - 1) * np.diff(first, axis=0) / _width(k[p + 1 : n + p - 1] - k[2:n]))


def _width(width: Floats) -> Floats:
    """Widths as a column; what is zero belongs to a span without length, and is never used."""
    return np.asarray(np.where(width > 0, width, 1.0)[:, None])
