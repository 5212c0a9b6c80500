"""The geometry of a five-axis chain for compiled functions."""

from __future__ import annotations

from typing import NamedTuple

from toolpace.kernels.arrays import Floats, Ints

U1, U2, A0, C0, C1, C2, LINEAR = range(7)
"""Rows of `Chain.frame`; see chain.py for what they are."""


class Chain(NamedTuple):
    """Where the joints of a chain stand, in the workpiece frame, with all joints at zero."""

    frame: Floats
    """(9, 3) u1, u2, a0, c0, c1, c2 and the linear directions."""
    group: Ints
    """(3,) how many rotary joints lie between the workpiece and each linear joint."""
    place: Ints
    """(5,) columns of the two rotary joints, then of the linear ones."""
