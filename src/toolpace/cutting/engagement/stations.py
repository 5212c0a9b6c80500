"""Stations: poses of the tool along a motion, close enough that the stock may be cut at each of them in turn."""

from __future__ import annotations

from dataclasses import dataclass

from toolpace.common.arrays import Bools, Floats, Ints


@dataclass(frozen=True)
class Stations:
    """n poses; entry i speaks of pose i and of the way from i - 1 to i, all with one tool."""

    tip: Floats
    """(n, 3) tip, workpiece frame [m]."""
    axis: Floats
    """(n, 3) unit vectors from the tip to the spindle."""
    time: Floats
    """(n,) when the pose is passed [s]."""
    block: Ints
    """(n,) line of the program."""
    operation: Ints
    """(n,) index of the operation."""
    rapid: Bools
    """(n,)"""
