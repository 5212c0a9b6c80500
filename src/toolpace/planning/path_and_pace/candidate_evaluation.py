"""Cheap and full evaluation of candidate paths by their optimal motions.

Held at the nodes only, the pace may fall to next to nothing between two of them (a drill that turns back on its own
way). Such a motion tells nothing of its path, and one run of that kind is enough to hide all others. Holding limits
between the nodes is most of a plan, so such a run is planned in whole, and not again where its path is the one taken.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from toolpace.common.workers import Progress, Workers
from toolpace.machine.limits import Limits
from toolpace.motion.laws import TimeLaw
from toolpace.path.axis_run import AxisRun
from toolpace.planning.endstate import EndState
from toolpace.planning.optimal.planner import Optimal
from toolpace.planning.planned_run import PlannedRun

CRAWLING, CRAWL_LOOKS = 1e-2, 256
"""Share of its mean pace below which a motion hardly moves, and how often it is looked at."""
AT_NODES, BETWEEN, FULL = Optimal(guard=False, bound=False), Optimal(bound=False), Optimal()
"""Where limits are held; a whole plan has its bound too."""


@dataclass(frozen=True, eq=False)
class CheapEvaluation:
    """The optimal planner, as quickly as it tells which of two paths is the faster."""

    whole: dict[AxisRun, PlannedRun] | None = None
    """Where the plans of runs go that hold their limits between the nodes, in whole; None: nobody asks for them."""

    @property
    def name(self) -> str:
        """That of the planner whose motions these are."""
        return "optimal"

    def plan_run(
        self, run: AxisRun, limits: Limits, start: EndState, end: EndState, workers: Workers, progress: Progress
    ) -> PlannedRun:
        """The law of one run. Raises InfeasibleError."""
        planned = AT_NODES.plan_run(run, limits, start, end, workers, progress)
        if not crawls(planned.law):
            return planned
        if self.whole is None:
            return BETWEEN.plan_run(run, limits, start, end, workers, progress)
        self.whole[run] = FULL.plan_run(run, limits, start, end, workers, progress)
        return self.whole[run]


@dataclass(frozen=True, eq=False)
class FullEvaluation:
    """The optimal planner, for what a ranking has not planned in whole already."""

    whole: Mapping[AxisRun, PlannedRun]

    @property
    def name(self) -> str:
        """That of the planner whose motions these are."""
        return "optimal"

    def plan_run(
        self, run: AxisRun, limits: Limits, start: EndState, end: EndState, workers: Workers, progress: Progress
    ) -> PlannedRun:
        """The law of one run. Raises InfeasibleError."""
        known = self.whole.get(run)
        return FULL.plan_run(run, limits, start, end, workers, progress) if known is None else known


def crawls(law: TimeLaw) -> bool:
    """Whether a motion hardly moves for half of its time."""
    s = law.at(np.linspace(0.0, law.duration, CRAWL_LOOKS + 1))[0]
    slow = np.diff(s) < CRAWLING * (s[-1] - s[0]) / CRAWL_LOOKS
    return bool(2 * slow.sum() > CRAWL_LOOKS)
