"""The three kinds of arrays that are passed around: numbers in SI units, indices and line numbers, marks."""

from __future__ import annotations

from toolpace.kernels.arrays import Bools, Floats, Ints

__all__ = ["Bools", "Floats", "Ints"]
