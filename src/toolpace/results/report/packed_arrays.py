"""Arrays of a page as text: whole numbers in differences, their bytes apart by place, all deflated together.

A browser decodes them by itself (`DecompressionStream`); player/arrays.js is the other half.
"""

from __future__ import annotations

import base64
import zlib

import numpy as np
import numpy.typing as npt

LARGEST = 2**30
"""Of the whole numbers that figures become: their differences fit into 32 bits."""
MISSING = -(2**31)
"""Stands where there is no value."""


class PackedArrays:
    """Gathers arrays; `text` holds all of them, and each `add` returns what a page needs to find its own."""

    def __init__(self) -> None:
        self._parts: list[bytes] = []
        self._length = 0

    @property
    def text(self) -> str:
        """All of them: deflated, in base 64."""
        return base64.b64encode(zlib.compress(b"".join(self._parts), 9)).decode("ascii")

    def add(self, values: npt.ArrayLike, unit: float = 1.0) -> dict[str, object]:
        """Keep values (n,) as multiples of a unit, or of a larger one where that would be too many; what is not finite
        is missing."""
        figures = np.asarray(values, dtype=np.float64)
        there = np.isfinite(figures)
        top = float(np.abs(figures[there]).max(initial=0.0))
        unit = max(unit, top / LARGEST)
        whole = np.where(there, np.round(np.where(there, figures, 0.0) / unit), MISSING).astype(np.int64)
        steps = np.diff(whole, prepend=0)
        # missing values make steps beyond 32 bits, which come back by wrapping around
        small = _folded(steps.astype(np.uint64).astype(np.uint32).view(np.int32))
        width = 1 if small.max(initial=0) < 1 << 8 else 2 if small.max(initial=0) < 1 << 16 else 4
        planes = small.astype("<u4").view(np.uint8).reshape(-1, 4)[:, :width]
        return {"n": len(whole), "width": width, "unit": unit, **self._put(np.ascontiguousarray(planes.T).tobytes())}

    def add_bytes(self, data: bytes) -> dict[str, object]:
        """Keep bytes as they are."""
        return {"n": len(data), **self._put(data)}

    def _put(self, data: bytes) -> dict[str, object]:
        at = self._length
        self._parts.append(data)
        self._length += len(data)
        return {"at": at}


def _folded(steps: npt.NDArray[np.int32]) -> npt.NDArray[np.uint32]:
    """0, -1, 1, -2, ... as 0, 1, 2, 3, ...: small steps of both signs have small bytes."""
    return ((steps << 1) ^ (steps >> 31)).view(np.uint32)
