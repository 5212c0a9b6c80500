"""Cheap and full evaluation of candidate paths by their optimal motions.

Held at the nodes only, the pace may fall to next to nothing between two of them (a drill that turns back on its own
way). Finer cells there nearly always mend it. Where they do not, the motion tells nothing of its path, and one run of
that kind is enough to hide all others. Holding limits between the nodes is most of a plan, so such a run is planned in
whole, and not again where its path is the one taken.

In full, each run is planned along the path whose cheap motion is the fastest in that run, and along the next where that
takes longer than cheap motions tell: no run holds up another, and none is planned twice for the sake of another.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from toolpace.common.errors import InfeasibleError, ReachError
from toolpace.common.workers import Progress, Workers
from toolpace.machine.limits import Limits
from toolpace.motion.laws import TimeLaw
from toolpace.path.axis_run import AxisRun
from toolpace.planning.optimal.planner import Optimal
from toolpace.planning.planned_run import EndState, PlannedRun
from toolpace.planning.planner import Planner

CRAWLING, CRAWL_LOOKS = 1e-2, 256
"""Share of its mean pace below which a motion hardly moves, and how often it is looked at."""
AT_NODES, BETWEEN, FULL = Optimal(guard=False, bound=False), Optimal(bound=False), Optimal()
"""Where limits are held; a whole plan has its bound too."""
USUAL_LOSS = 3e-2
"""Share by which a whole plan of a run takes longer than its motion held at the nodes where all is well: 5e-4 to 3.5e-3
where it mills, up to 2.6e-2 where it pecks, and of paths of the same run alike to 1e-4 and 3e-3. Only where a plan
loses more is the next path planned."""


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


class Alternative(NamedTuple):
    """One of the paths that a run may take."""

    hoped: float
    """Duration of its motion held at the nodes [s]; 0 where none is known."""
    run: AxisRun
    candidate: int
    """Number of the path that it is of."""
    planned: PlannedRun | None = None
    """Its whole plan, where there is one already."""


@dataclass(frozen=True, eq=False)
class BestOfRuns:
    """A planner that takes the best of several paths of each run."""

    planner: Planner
    alternatives: Mapping[AxisRun, Sequence[Alternative]]
    """By the run that is asked for: those that may take its place, itself among them."""
    check: Callable[[AxisRun], None]
    """Raises ReachError where the joints along a run will not do."""
    taken: dict[AxisRun, Alternative] = field(default_factory=dict)
    """By the run that is asked for: the one that took its place."""

    @property
    def name(self) -> str:
        """That of the planner whose motions these are."""
        return self.planner.name

    def plan_run(
        self, run: AxisRun, limits: Limits, start: EndState, end: EndState, workers: Workers, progress: Progress
    ) -> PlannedRun:
        """The law of the best path of one run. Raises InfeasibleError or ReachError where none will do: that of the run
        that is asked for."""
        best: PlannedRun | None = None
        enough, problem = 0.0, None
        # nobody knows of one without a cheap motion, and it may be the best: it comes last
        for number, each in enumerate(sorted(self.alternatives[run], key=lambda each: each.hoped or np.inf)):
            if best is not None and each.hoped > 0.0 and best.law.duration <= max(enough, each.hoped):
                continue
            part = progress.part(1.0 - 0.5**number, 1.0 - 0.5 ** (number + 1))
            try:
                self.check(each.run)
                found = each.planned or self.planner.plan_run(each.run, limits, start, end, workers, part)
            except (InfeasibleError, ReachError) as error:
                problem = error if problem is None or each.run is run else problem
                continue
            if best is None or found.law.duration < best.law.duration:
                best, enough, self.taken[run] = found, (1.0 + USUAL_LOSS) * each.hoped, each
        if best is None:
            assert problem is not None
            raise problem
        progress(1.0)
        return best


def crawls(law: TimeLaw) -> bool:
    """Whether a motion hardly moves for half of its time."""
    s = law.at(np.linspace(0.0, law.duration, CRAWL_LOOKS + 1))[0]
    slow = np.diff(s) < CRAWLING * (s[-1] - s[0]) / CRAWL_LOOKS
    return bool(2 * slow.sum() > CRAWL_LOOKS)
