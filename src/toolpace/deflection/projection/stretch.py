"""The stretches of a path that a projection searches, and the point that it finds."""

from __future__ import annotations

from dataclasses import dataclass

from toolpace.common.arrays import Floats, numbers
from toolpace.common.errors import UsageError
from toolpace.common.value_objects import ByValue, one_line
from toolpace.path.path import Path
from toolpace.path.run import PathRun

BORDER = 1e-12
"""How far an interval may reach beyond its run by rounding."""


@dataclass(frozen=True)
class Stretch:
    """A run from one parameter to another."""

    index: int
    """Of the run."""
    run: PathRun
    low: float
    high: float

    def tip(self, s: Floats) -> Floats:
        """(4, n, 3) tip and three derivatives at s (n,)."""
        jets: Floats = self.run.evaluate(s).tip
        return jets


def stretches(path: Path, interval: tuple[float, float] | None) -> list[Stretch]:
    """All runs of a path, or the `interval` (from s, to s) of one of them.

    Raises UsageError where there is none, and where several have it.
    """
    if interval is None:
        return [Stretch(index, run, run.s0, run.s1) for index, run in enumerate(path.runs)]
    low, high = numbers(interval, "deflection: interval", (2,)).tolist()
    found = [
        Stretch(index, run, max(low, run.s0), min(high, run.s1))
        for index, run in enumerate(path.runs)
        if run.s0 - BORDER <= low < high <= run.s1 + BORDER
    ]
    if not found:
        raise UsageError(f"deflection: the path has no interval from s = {interval}; give one inside a run")
    if len(found) > 1:
        raise UsageError(
            f"deflection: {len(found)} runs of the path have an interval from s = {interval}; project on the one that"
            " is meant: Path((path.runs[k],))"
        )
    return found


@dataclass(frozen=True, eq=False, repr=False)
class Projection(ByValue):
    """The point of a path that is nearest to a deflection."""

    s: float
    """Parameter on the path."""
    run: int
    """Index of the run."""
    tip: Floats
    """(3,) [m]."""
    distance: float
    """From the deflection [m]."""
    steps: int
    """Rounds of halving, or steps of the descent."""
    within: float
    """No point that was looked for is nearer by more than this [m]; inf by the potential field, which cannot tell."""
    proven: bool
    """Whether bounds of the path itself stand behind `within`; of a path given as a function only samples can."""

    def __repr__(self) -> str:
        return one_line(self, f"s {self.s:.9g} of run {self.run}", f"{self.distance * 1e3:.6g} mm away")
