"""Motions by which paths are ranked: limits held at the nodes, a tenth of a plan's time; between them too where a run
would hardly move otherwise.

Held at the nodes only, the pace may fall to next to nothing between two of them (a drill that turns back on its own
way). Such a motion tells nothing of its path, and one run of that kind is enough to hide all others.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from toolpace.axispath.run import AxisRun
from toolpace.laws.law import TimeLaw
from toolpace.machine.limits import Limits
from toolpace.planning.endstate import EndState
from toolpace.planning.optimal.planner import Optimal
from toolpace.planning.planned_run import PlannedRun
from toolpace.workers import Progress, Workers

CRAWLING, CRAWL_LOOKS = 1e-2, 256
"""Share of its mean pace below which a motion hardly moves, and how often it is looked at."""
AT_NODES, BETWEEN = Optimal(guard=False, bound=False), Optimal(bound=False)
"""Where limits are held."""


@dataclass(frozen=True)
class Ranking:
    """The optimal planner, as quickly as it tells which of two paths is the faster."""

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
        return BETWEEN.plan_run(run, limits, start, end, workers, progress)


def crawls(law: TimeLaw) -> bool:
    """Whether a motion hardly moves for half of its time."""
    s = law.at(np.linspace(0.0, law.duration, CRAWL_LOOKS + 1))[0]
    slow = np.diff(s) < CRAWLING * (s[-1] - s[0]) / CRAWL_LOOKS
    return bool(2 * slow.sum() > CRAWL_LOOKS)
