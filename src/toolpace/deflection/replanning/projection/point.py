"""A projection: the point of a path, with a bound of how much nearer another could be."""

from __future__ import annotations

from dataclasses import dataclass

from toolpace.common.arrays import Floats
from toolpace.common.value_objects import ByValue, one_line


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
