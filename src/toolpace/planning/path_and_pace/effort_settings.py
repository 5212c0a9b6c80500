"""Discretisation and stopping of the simultaneous optimisation, by effort."""

from __future__ import annotations

from typing import NamedTuple


class EffortSettings(NamedTuple):
    """The discretisation of the change, and when its methods are at their end."""

    longest: float
    """Most time from knot to knot, in that in which an acceleration builds up."""
    places: int
    """In each cell, evenly spread, at which limits are held."""
    gap: float
    """At which the interior-point method ends, relative to the time."""
    steps: int
    """After which it ends in any case."""
    seams: bool
    """Whether windows over the seams of the others follow."""


THOROUGH = EffortSettings(0.08, 4, 1e-2, 60, True)
"""All that is to be had, nearly."""
QUICK = EffortSettings(0.08, 2, 0.1, 14, False)
"""Most of it for a tenth of the time: between its places limits are passed a little, which the plan of the path
mends."""
