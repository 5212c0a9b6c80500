"""The C interface of a follower's step: `step(piece, length, state, given, out)` on the arrays of layout.py."""

from __future__ import annotations

from typing import Any

import numba

from toolpace.kernels.follow.layout import INPUTS, OUTPUTS, STATE
from toolpace.kernels.follow.step import step

TYPES: Any = numba.types
POINTER = TYPES.CPointer(TYPES.float64)


def step_for_c() -> Any:
    """Compile the door; `address` of what is returned is the function's, good as long as that lives."""

    def door(piece: Any, length: Any, state: Any, given: Any, out: Any) -> None:
        step(
            numba.carray(piece, (length,)),
            numba.carray(state, (STATE,)),
            numba.carray(given, (INPUTS,)),
            numba.carray(out, (OUTPUTS,)),
        )

    return numba.cfunc(TYPES.void(POINTER, TYPES.int64, POINTER, POINTER, POINTER))(door)
