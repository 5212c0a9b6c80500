"""The interface of a joint run between two stops: positions, derivatives, and a cap on its speed."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from toolpace.common.arrays import Floats, Ints, gate_methods, number
from toolpace.common.errors import PathError, UsageError
from toolpace.common.value_objects import counted, one_line
from toolpace.common.workers import Lock

PLACED = ("evaluate", "speed_cap", "with_cap", "block_at")
"""Methods of a run that take parameters (n,)."""


class AxisRun(ABC):
    """One stretch between two stops, three times differentiable but for its `breaks`."""

    s0: float
    s1: float
    breaks: Floats
    """(k,) parameter values inside the run where the third derivative or the speed cap may jump."""
    hints: Floats
    """(h,) parameter values between which the run is smooth on the scale of a mesh cell; may be empty."""
    dwell: float = 0.0
    """Time to wait at the end [s]."""
    tool_length: float = math.nan
    """Of the tool in the spindle [m]; nan: as long as the machine's own."""
    smooth_cap: bool = False
    """Whether the speed cap is as smooth as the path between breaks."""
    blocks: int = 0
    """Number of blocks of a program that it follows; 0 where there is no program."""

    def __init_subclass__(cls) -> None:
        """Have arrays of parameters that a caller gives go through the gate."""
        gate_methods(cls, PLACED, "s")

    def entries(self) -> tuple[Floats, Ints]:
        """Parameters (b + 1,) between which the ways of a tool path lie, and the points (b,) that they lead to; none
        where it follows no tool path."""
        return np.zeros(1), np.zeros(0, dtype=np.int64)

    def deviations(self) -> tuple[Floats, Floats, Floats] | None:
        """Parameters (k + 1,), and between each two the largest distance of the tip [m] (k,) and angle of the tool axis
        [rad] (k,) from the program; None where no path was fitted."""
        return None

    def __repr__(self) -> str:
        blocks = counted(self.blocks, "block") if self.blocks else ""
        return one_line(self, f"s {self.s0:.6g} to {self.s1:.6g}", blocks)

    @abstractmethod
    def evaluate(self, s: Floats) -> Floats:
        """(4, n, joints): positions and three derivatives along s, from the right at a break [m or rad over s]."""

    @abstractmethod
    def speed_cap(self, s: Floats) -> Floats:
        """(n,) most ds/dt that feed and block times allow, from the right at a break; inf without a cap."""

    def cap_names(self, s: Floats) -> tuple[Ints, tuple[str, ...]]:
        """(n,) what sets the cap at s (n,), as an index in the names that come with it."""
        return np.zeros(len(s), dtype=np.int64), ("feed",)

    def with_cap(self, s: Floats) -> tuple[Floats, Floats]:
        """Both of these: the path (4, n, joints) and the cap (n,) on ds/dt."""
        return self.evaluate(s), self.speed_cap(s)

    def place(self, s: float) -> str:
        """A parameter in words, with the block where there is a program."""
        block = int(self.block_at(np.array([s]))[0])
        return f"s = {s:.9g}" + (f" (block {block})" if block else "")

    def block_at(self, s: Floats) -> Ints:
        """(n,) line number of the block at s; 0 where there is no program."""
        return np.zeros(len(s), dtype=np.int64)


gate_methods(AxisRun, PLACED, "s")


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
            value = np.asarray(self.cap(s), dtype=float)
        if value.shape not in ((), s.shape):
            raise PathError(f"path: speed_cap(s) has shape {value.shape} for {len(s)} values of s, not (n,)")
        cap = np.broadcast_to(value, s.shape).copy()
        if not (cap >= 0.0).all():
            k = int(np.argmin(cap >= 0.0))
            raise PathError(f"path: speed_cap(s) is {cap[k]:g} at s = {s[k]:.9g}; give a positive number, or inf")
        return cap
