"""Taylor coefficients of splines of degree five, packed by what each piece tells of the next.

All derivatives but the fifth go on at a break, so that the Taylor shift of a piece by its length predicts five of the
six coefficients of the next up to rounding. What is left, by the bits of the numbers, takes about a byte. Every
`STRETCH` pieces a prediction begins anew: stretches are packed and unpacked side by side.
"""

from __future__ import annotations

import numpy as np

from toolpace.common.arrays import Floats, Ints
from toolpace.motion.files.packed_integers import bits_of

STRETCH = 64
"""Pieces in a row of which each is predicted by the one before."""


def left_of_splines(coefficients: Floats, lengths: Floats) -> Ints:
    """(6, d, n) what a prediction leaves of the coefficients (n, 6, d) of pieces of these lengths (n,)."""
    bits = bits_of(coefficients).reshape(coefficients.shape)
    guess = np.zeros_like(bits)
    with np.errstate(all="ignore"):
        guess[1:] = bits_of(shifted(coefficients[:-1], lengths[:-1])).reshape(guess[1:].shape)
    guess[::STRETCH] = 0
    return np.ascontiguousarray((bits - guess).transpose(1, 2, 0))


def splines_of(left: Ints, lengths: Floats) -> Floats:
    """The coefficients (n, 6, d) that `left_of_splines` took."""
    orders, columns, count = left.shape
    stretches = -(-count // STRETCH)
    rows = np.zeros((stretches * STRETCH, orders, columns), dtype=np.int64)
    rows[:count] = left.transpose(2, 0, 1)
    h = np.zeros(stretches * STRETCH)
    h[:count] = lengths
    rows, h = rows.reshape(stretches, STRETCH, orders, columns), h.reshape(stretches, STRETCH)
    with np.errstate(all="ignore"):
        for k in range(1, STRETCH):
            before = np.ascontiguousarray(rows[:, k - 1]).view(np.float64)
            rows[:, k] += bits_of(shifted(before, h[:, k - 1])).reshape(before.shape)
    found: Floats = rows.reshape(-1, orders, columns)[:count].view(np.float64)
    return found


def shifted(coefficients: Floats, lengths: Floats) -> Floats:
    """(n, 6, d) the Taylor coefficients at the right ends of pieces, by Horner's rule (Shaw and Traub, 1974)."""
    found, h = coefficients.copy(), lengths[:, None]
    for first in range(found.shape[1] - 1):
        for order in range(found.shape[1] - 2, first - 1, -1):
            found[:, order] += h * found[:, order + 1]
    return found
