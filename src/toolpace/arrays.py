"""The three kinds of arrays that are passed around: numbers in SI units, indices and line numbers, marks."""

from __future__ import annotations

import numpy as np

from toolpace.kernels.arrays import Bools, Floats, Ints

__all__ = ["Bools", "Floats", "Ints", "frozen"]


def frozen(values: Floats) -> Floats:
    """The values in C order as they may not be written to; a kernel is compiled anew for arrays of another kind."""
    view = np.ascontiguousarray(values, dtype=float).view()
    view.flags.writeable = False
    return view
