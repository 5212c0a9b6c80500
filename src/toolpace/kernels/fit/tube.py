"""The input of a fit: the roughness of the cells, and the samples of the tube.

A sample has six neighbouring coefficients of g coordinates, the first of them number `first`.
"""

from __future__ import annotations

from typing import NamedTuple

from toolpace.kernels.arrays import Floats, Ints


class Roughness(NamedTuple):
    """What is minimised."""

    third: Floats
    """(cells, 3, 6) rows that integrate the squared third derivative; see `quintic_spline.third_rows`."""
    weight: Floats
    """(g,) of each coordinate."""


class Samples(NamedTuple):
    """Where a spline is compared with its target."""

    first: Ints
    """(m,) first coefficient that matters."""
    rows: Floats
    """(m, 6) basis values."""
    target: Floats
    """(m, g)"""
    metric: Floats
    """(m, g, g) squares of deviations."""


class Tube(NamedTuple):
    """How far the spline may be from its target."""

    radius: Floats
    """(m,)"""
    pull: Floats
    """(m,) weight of the squared deviation beside the roughness: what keeps the Newton matrix regular."""


class Free(NamedTuple):
    """The coefficients low ... high - 1 are free, the others stay."""

    low: int
    high: int
