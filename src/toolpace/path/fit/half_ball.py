"""Ellipsoids inside one half of the tolerance tube, for tolerances on one side.

Of the ball of radius 1 about the program's tip the half with n . d >= 0 may be used. In it lies the ellipsoid

    |d across n|^2 / b^2 + (n . d - a)^2 / a^2 <= 1        b = sqrt(3) / 2,  a = sqrt(3) / 4

of most volume (65 percent of the half ball). So the tube is still one ball at each sample, only about another place and
in another metric, and no solver has to know of sides. Where a run starts and ends the curve is at the program's point
itself: towards these places the ellipsoid shrinks.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from toolpace.common.arrays import Floats

ACROSS, ALONG = np.sqrt(3.0) / 2.0, np.sqrt(3.0) / 4.0
"""Half axes b and a [radii of the ball]."""
FADE = 2.0
"""Length from an end of a run over which the ellipsoid grows to its size [tolerances]."""
LEAST = 0.01
"""Size below which its metric is that of this one: at the end itself it would have none."""


@dataclass(frozen=True)
class HalfBall:
    """On which side of a run its curve must be; all in tolerances."""

    s: Floats
    """(k + 1,) parameters of the vertices."""
    out: Floats
    """(k + 1, 3) unit vectors there, away from the part."""

    def outward(self, at: Floats) -> Floats:
        """(n, 3) unit vectors at parameters (n,)."""
        return unit(np.stack([np.interp(at, self.s, each) for each in self.out.T], axis=1))

    def size(self, at: Floats) -> Floats:
        """(n,) of the ellipsoid there, at most 1."""
        return np.asarray(np.clip(np.minimum(at - self.s[0], self.s[-1] - at) / FADE, 0.0, 1.0))

    def centre(self, at: Floats) -> Floats:
        """(n, 3) of the ellipsoid, from the program's tip on."""
        return np.asarray(ALONG * self.size(at)[:, None] * self.outward(at))

    def metric(self, at: Floats) -> Floats:
        """(n, 3, 3) what a way from the centre is, squared: 1 on the ellipsoid."""
        out, size = self.outward(at), np.maximum(self.size(at), LEAST)
        along = out[:, :, None] * out[:, None, :]
        shape = (np.eye(3) - along) / ACROSS**2 + along / ALONG**2
        return np.asarray(shape / size[:, None, None] ** 2)

    def distance(self, off: Floats, at: Floats) -> Floats:
        """(n,) of places `off` (n, 3) the program's tip from the centre, in the metric."""
        way = off - self.centre(at)
        return np.asarray(np.sqrt(np.einsum("na,nab,nb->n", way, self.metric(at), way)))


def unit(vectors: Floats) -> Floats:
    """(n, 3) the vectors at length 1; what has none stays as it is."""
    length = np.linalg.norm(vectors, axis=1)[:, None]
    return np.asarray(vectors / np.where(length > 0.0, length, 1.0))
