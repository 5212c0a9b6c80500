"""Doubles, columns of small whole numbers, and coefficients of splines, packed into few bytes.

Numbers of a motion are multiples of a power of two (motion/sampling.py), so that they are whole numbers beside an
exponent. What is left of these by a good prediction is small. It is packed as

    exponents and widths -- bytes of all numbers, the lowest of each first, then the next ... -- zlib, runs only

Of the formats tried (docs/design/set_points.md) this one needs no other library, and is as small as the best.

Splines are of degree five, and each piece is packed by what the one before it predicts. All derivatives but the fifth
go on at a break, so that the Taylor shift of a piece by its length predicts five of the six coefficients of the next up
to rounding. What is left, by the bits of the numbers, takes about a byte. Every `STRETCH` pieces a prediction begins
anew: stretches are packed and unpacked side by side.
"""

from __future__ import annotations

import zlib
from collections.abc import Sequence

import numpy as np

from toolpace.common.arrays import Floats, Ints

BITS = 62
"""Most bits of a whole number: sums and differences of two fit into 64."""
FARTHEST = 500
"""Largest exponent of a grid: its square is a number still."""
AS_THEY_ARE = 1 << 14
"""In place of an exponent: the numbers are on no grid, and their bits are taken."""
_LEVEL, _WINDOW, _MEMORY = 6, 15, 9
"""Of zlib; with runs only the level says nothing."""
STRETCH = 64
"""Pieces in a row of which each is predicted by the one before."""


class DamagedError(ValueError):
    """Packed data are not as they were written."""


def whole_numbers(values: Floats) -> tuple[Ints, int]:
    """Whole numbers and exponent: values (n,) are numbers times 2 ** exponent, with the largest exponent there is.

    Exact for all but the sign of zero. What is on no such grid, or not finite, is told by its bits, with `AS_THEY_ARE`.
    """
    largest = float(np.abs(values).max(initial=0.0))
    if largest == 0.0:
        return np.zeros(len(values), dtype=np.int64), 0
    top = int(np.frexp(largest)[1]) if np.isfinite(largest) else FARTHEST + BITS
    if abs(top) < FARTHEST:
        scaled = values * 2.0 ** (BITS - top)
        numbers = scaled.astype(np.int64)
        if (numbers == scaled).all():
            together = int(np.bitwise_or.reduce(numbers))
            spare = (together & -together).bit_length() - 1
            return numbers >> spare, top - BITS + spare
    return bits_of(values), AS_THEY_ARE


def values_of(numbers: Ints, exponent: int) -> Floats:
    """The values (n,) that `whole_numbers` took. Raises DamagedError for an exponent that it never tells."""
    if exponent == AS_THEY_ARE:
        bits: Floats = numbers.view(np.float64)
        return bits
    if abs(exponent) > FARTHEST + BITS:
        raise DamagedError
    found: Floats = numbers.astype(np.float64) * 2.0**exponent
    return found


def bits_of(values: Floats) -> Ints:
    """The bits of doubles (n,) as whole numbers."""
    bits: Ints = np.ascontiguousarray(values, dtype=np.float64).view(np.int64)
    return bits


def pack(columns: Sequence[Ints], exponents: Sequence[int]) -> bytes:
    """Columns (n,) of whole numbers of 8 bytes and exponents (k,), packed; small numbers take little."""
    folded = [((each << 1) ^ (each >> 63)).view(np.uint64) for each in columns]
    widths = [(int(np.bitwise_or.reduce(each)).bit_length() + 7) // 8 if len(each) else 0 for each in folded]
    parts = [np.array(exponents, dtype="<i2").tobytes(), bytes(widths)]
    for each, width in zip(folded, widths):
        octets = each.astype("<u8", copy=False).view(np.uint8).reshape(-1, 8)
        parts += [np.ascontiguousarray(octets[:, k]).tobytes() for k in range(width)]
    packer = zlib.compressobj(_LEVEL, zlib.DEFLATED, _WINDOW, _MEMORY, zlib.Z_RLE)
    return b"".join([packer.compress(b"".join(parts)), packer.flush()])


def unpack(data: bytes, rows: int, columns: int, exponents: int) -> tuple[list[Ints], list[int]]:
    """The columns (rows,) and the exponents that were packed. Raises DamagedError where it is not as many of them."""
    head = 2 * exponents + columns
    try:
        reader = zlib.decompressobj()
        content = reader.decompress(data, head + 8 * rows * columns + 1)
    except zlib.error:
        raise DamagedError from None
    if not reader.eof or reader.unused_data or len(content) < head:
        raise DamagedError
    widths = content[2 * exponents : head]
    if max(widths, default=0) > 8 or len(content) != head + rows * sum(widths):
        raise DamagedError
    found, at = [], head
    for width in widths:
        octets = np.zeros((rows, 8), dtype=np.uint8)
        octets[:, :width] = np.frombuffer(content, np.uint8, rows * width, at).reshape(width, rows).T
        at += rows * width
        folded = octets.view("<u8").ravel().astype(np.uint64, copy=False)
        found.append((folded >> np.uint64(1)).view(np.int64) ^ -(folded & np.uint64(1)).view(np.int64))
    return found, np.frombuffer(content, "<i2", exponents).tolist()


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
