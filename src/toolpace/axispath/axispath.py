"""Joint positions along a path: all that a planner needs to know."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from toolpace.arrays import Floats
from toolpace.axispath.callable import CallableRun
from toolpace.axispath.follow import FollowRun, branches_of
from toolpace.axispath.run import AxisRun
from toolpace.errors import UsageError

if TYPE_CHECKING:
    from toolpace.machine.machine import Machine
    from toolpace.path.path import Path


@dataclass(frozen=True)
class AxisPath:
    """Runs one after the other, each from rest to rest."""

    runs: tuple[AxisRun, ...]
    joints: tuple[str, ...]
    machine: Machine | None = None
    first_dwell: float = 0.0
    """Time to wait before anything moves [s]."""

    @classmethod
    def from_callable(
        cls,
        f: Callable[[Floats, int], npt.ArrayLike],
        s0: float = 0.0,
        s1: float = 1.0,
        *,
        joints: Sequence[str] | None = None,
        speed_cap: float | Callable[[Floats], npt.ArrayLike] = np.inf,
        breaks: npt.ArrayLike = (),
        hints: npt.ArrayLike = (),
    ) -> AxisPath:
        """A path given by a function: f(s (n,), order) -> (n, joints), the order-th derivative for orders 0 to 3.

        `speed_cap` limits ds/dt; `breaks` names the values of s where the third derivative or the cap jumps; `hints`
        (optional) values of s between which the path is simple, such as the knots of a spline: the mesh takes no
        fewer cells. f and `speed_cap` are never called from two threads at once.
        """
        if not (np.isfinite(s0) and np.isfinite(s1) and s1 > s0):
            raise UsageError(f"path: s runs from {s0:g} to {s1:g}; it must increase")
        run = CallableRun(f, float(s0), float(s1), speed_cap, np.unique(np.asarray(breaks, dtype=float)), hints)
        count = run.evaluate(np.array([s0, s1])).shape[2]
        names = tuple(joints) if joints else tuple(f"q{i + 1}" for i in range(count))
        if len(names) != count:
            raise UsageError(f"path: {len(names)} joint names for {count} joints")
        return cls((run,), names)

    @classmethod
    def follow(cls, path: Path, machine: Machine) -> AxisPath:
        """The joints of a machine that carries tool tip and tool axis along a path."""
        branches = branches_of(path, machine)
        runs = tuple(FollowRun(run, machine, branch) for run, branch in zip(path.runs, branches))
        return cls(runs, machine.joints, machine, path.first_dwell)


