"""The final plan of an optimised path, on a mesh refined until the gap is small.

Such a path has many joints at their limits at once, and little else than its own pace will do: what its mesh cannot
hold between the nodes has to be slowed down, and the bound on the path tells by how much.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from toolpace.common.workers import Progress, Workers
from toolpace.machine.limits import Limits
from toolpace.path.axis_run import AxisRun
from toolpace.planning.bound.relaxation import bound_long_run, places_in_time
from toolpace.planning.endstate import EndState
from toolpace.planning.optimal.planner import fastest_law
from toolpace.planning.planned_run import PlannedRun

CELLS = 150.0, 300.0, 75.0
"""Mesh cells in the time in which an acceleration builds up; the next where one leaves too much."""
LEFT = 3e-3
"""Distance to the lower bound, as a share of it, that is too much: the rounds did not end, and all was slowed down."""
ROUNDS = 10
"""Of holding limits between the nodes."""
FEWEST, MOST = 1000, 1_000_000
"""Of a run."""
SOLVED = 0.7
"""Share of the work, for progress, before the bound."""


@dataclass(frozen=True)
class FinalMesh:
    """The optimal planner on a mesh of given density."""

    duration: float
    """About that of the whole motion [s]."""
    length: float
    """Of the parameter of all runs together."""
    ramp: float
    """In which time an acceleration builds up [s]."""

    @property
    def name(self) -> str:
        """That of the planner whose motions these are."""
        return "optimal"

    def plan_run(
        self, run: AxisRun, limits: Limits, start: EndState, end: EndState, workers: Workers, progress: Progress
    ) -> PlannedRun:
        """The law of one run, with its bound. Raises InfeasibleError."""
        time = self.duration * (run.s1 - run.s0) / self.length
        best: PlannedRun | None = None
        for number, dense in enumerate(CELLS):
            # how many there will be nobody knows
            told = progress.part(1.0 - 0.5**number, 1.0 - 0.5 ** (number + 1))
            cells = int(np.clip(dense * time / self.ramp, FEWEST, MOST))
            solving = told.part(0.0, SOLVED)
            law, points = fastest_law(run, limits, cells, start, end, True, workers, solving, ROUNDS)
            bound = bound_long_run(run, limits, law, start, end, workers, told.part(SOLVED, 1.0))
            if best is None or law.duration < best.law.duration:
                best = PlannedRun(law, points, bound.seconds, places_in_time(run, law, bound))
            if law.duration <= (1.0 + LEFT) * bound.seconds:
                break
        assert best is not None
        progress(1.0)
        return best
