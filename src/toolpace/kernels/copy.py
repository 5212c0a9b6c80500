"""The copy of one array into another."""

from __future__ import annotations

from toolpace.kernels.arrays import Floats
from toolpace.kernels.jit import jit


@jit(inline=True)
def copy(values: Floats, into: Floats) -> None:
    """Write values (n,) to the first n places of an array (n or more,).

    For `into[:] = values` numba compiles the text of an error, should the shapes differ: 7 s of a first run.
    """
    for k in range(len(values)):
        into[k] = values[k]
