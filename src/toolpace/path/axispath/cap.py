"""A cap on ds/dt along a joint path, from a number or a function."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from toolpace.common.arrays import Floats, number
from toolpace.common.errors import PathError, UsageError
from toolpace.common.workers import Lock


class SpeedCap:
    """Most ds/dt along a run."""

    def __init__(self, cap: float | Callable[[Floats], npt.ArrayLike], lock: Lock | None = None) -> None:
        """Take a number, or a function of s (n,) that is never called from two threads at once.

        `lock` is that of other functions of the same caller. UsageError for what is no number above zero.
        """
        if not callable(cap):
            try:
                cap = number(cap, "path: speed_cap", least=0.0, above=True, endless=True)
            except UsageError as error:
                raise UsageError(f"{error}, or a function of s") from None
        self.cap = cap
        self.lock = lock or Lock()

    def at(self, s: Floats) -> Floats:
        """(n,) the cap at s (n,). Raises PathError where a function gives something else."""
        if not callable(self.cap):
            return np.full(s.shape, self.cap)
        with self.lock:
            given = np.asarray(self.cap(s), dtype=float)
        if given.shape not in ((), s.shape):
            raise PathError(f"path: speed_cap(s) has shape {given.shape} for {len(s)} values of s, not (n,)")
        cap = np.broadcast_to(given, s.shape).copy()
        if not (cap >= 0.0).all():
            k = int(np.argmin(cap >= 0.0))
            raise PathError(f"path: speed_cap(s) is {cap[k]:g} at s = {s[k]:.9g}; give a positive number, or inf")
        return cap
