"""The spline of a run during the fit: breaks and coefficients."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from toolpace.common.arrays import Floats


@dataclass(frozen=True)
class Spline:
    """Breaks and the coefficients of tip (n, 3) and turn (n, d), which are worked on in place; all in tolerances."""

    breaks: Floats
    tip: Floats
    turn: Floats

    @property
    def is_finite(self) -> bool:
        """Whether all coefficients are numbers."""
        return bool(np.isfinite(self.tip).all() and np.isfinite(self.turn).all())

    def pieces(self) -> Floats:
        """Taylor coefficients (cells, 6, 3 + d) at the left end of each cell."""
        from toolpace.kernels.fit.quintic_spline import pieces

        return pieces(knots_of(self.breaks), np.concatenate([self.tip, self.turn], axis=1))

    def copy(self) -> Spline:
        """One that may be worked on while this one stays."""
        return Spline(self.breaks, self.tip.copy(), self.turn.copy())

    def over(self, breaks: Floats) -> Spline:
        """The same curve over finer breaks."""
        from toolpace.kernels.fit.quintic_spline import recast

        x = recast(self.breaks, self.pieces(), knots_of(breaks))
        for end in (0, -1):
            x[end] = np.concatenate([self.tip[end], self.turn[end]])
        return Spline(breaks, x[:, :3].copy(), x[:, 3:].copy())


def knots_of(breaks: Floats) -> Floats:
    """Knots with both ends six-fold."""
    return np.concatenate([np.repeat(breaks[:1], 5), breaks, np.repeat(breaks[-1:], 5)])
