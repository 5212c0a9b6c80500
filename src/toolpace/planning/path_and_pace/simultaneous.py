"""Simultaneous optimisation of path and speed law, repeated while it gains.

from a path and its motion, with limits held at the nodes
    repeat:  the path changed together with its pace, window by window;  its motion;  much faster?  once more
    the whole plan of the fastest one, on a mesh refined until the gap is small

Such a path has many joints at their limits at once, and little else than its own pace will do: what its mesh cannot
hold between the nodes has to be slowed down, and the bound on the path tells by how much.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from toolpace.common.errors import InfeasibleError, ReachError
from toolpace.common.workers import Progress, Workers
from toolpace.machine.limits import Limits
from toolpace.machine.machine import Machine
from toolpace.motion.laws import SplineLaw, TimeLaw
from toolpace.motion.trajectory import Trajectory
from toolpace.path.axis_path import AxisPath
from toolpace.path.axis_run import AxisRun
from toolpace.path.fit.polyline import PlaceTolerances
from toolpace.path.path import Path
from toolpace.planning.bound.relaxation import bound_long_run, places_in_time
from toolpace.planning.limit_tolerances import PROMISED
from toolpace.planning.optimal.planner import fastest_law
from toolpace.planning.path_and_pace.candidate_evaluation import CheapEvaluation
from toolpace.planning.path_and_pace.local_refit import refitted
from toolpace.planning.path_and_pace.segment import THOROUGH
from toolpace.planning.planned_run import EndState, PlannedRun
from toolpace.planning.planner import plan
from toolpace.programs.toolpath import ToolPath

ROUNDS = 5
"""Most changes."""
ENOUGH = 3e-3
"""Share of the duration that a change must gain for another to follow."""
SHARES = 1.0, 0.4
"""Of the tolerance of the axis that may be used: the next where the plan of what came out had to be slowed down."""
CHANGED = 0.8
"""Share of the work, for progress, before the last plan."""
CELLS = 150.0, 300.0, 75.0
"""Mesh cells in the time in which an acceleration builds up; the next where one leaves too much."""
LEFT = 3e-3
"""Distance to the lower bound, as a share of it, that is too much: the rounds did not end, and all was slowed down."""
GUARD_ROUNDS = 10
"""Of holding limits between the nodes."""
FEWEST_CELLS, MOST_CELLS = 1000, 1_000_000
"""Of a run."""
SOLVED = 0.7
"""Share of the work, for progress, before the bound."""


@dataclass(frozen=True, eq=False, repr=False)
class SimultaneousOptimisation:
    """A program whose path may be changed together with its pace."""

    toolpath: ToolPath
    tolerances: PlaceTolerances
    """All that is asked for."""
    ramp: float
    """In which time an acceleration builds up [s]."""

    def faster(
        self,
        path: Path,
        fitted: PlaceTolerances,
        machine: Machine,
        check: Callable[[AxisPath], None],
        progress: Progress,
    ) -> tuple[Path, Trajectory] | None:
        """A changed path and its plan, from one that was fitted within the tolerances `fitted` on; None where there is
        none. `check` raises ReachError where joints will not do."""
        allowed = self.tolerances.counting_in(fitted)
        best: tuple[Path, Trajectory] | None = None
        for number, share in enumerate(SHARES):
            part = progress.part(1.0 - 0.5**number, 1.0 - 0.5 ** (number + 1))
            room = np.maximum(allowed.room * [1.0, share], np.minimum(allowed.room, 1.0))
            if number > 0 and np.array_equal(room, allowed.room):
                break
            found = self._planned(path, replace(allowed, room=room), machine, check, part)
            if found is not None and (best is None or found[1].duration < best[1].duration):
                best = found
            if found is not None and found[1].duration <= (1.0 + LEFT) * found[1].lower_bound:
                break
        progress(1.0)
        return best

    def _planned(
        self,
        path: Path,
        allowed: PlaceTolerances,
        machine: Machine,
        check: Callable[[AxisPath], None],
        progress: Progress,
    ) -> tuple[Path, Trajectory] | None:
        """The path changed within the tolerances, and its whole plan."""
        try:
            path, motion = self._changed(path, allowed, machine, progress.part(0.0, CHANGED))
            axis_path = AxisPath.follow(path, machine)
            check(axis_path)
            planner = FinalMesh(motion.duration, sum(run.s1 - run.s0 for run in path.runs), self.ramp)
            found = plan(axis_path, machine, planner=planner, progress=progress.part(CHANGED, 1.0))
        except (InfeasibleError, ReachError):
            return None
        found = kept_to_the_promise(found)
        return (path, found) if found.usage().worst <= PROMISED else None

    def _changed(
        self, path: Path, allowed: PlaceTolerances, machine: Machine, progress: Progress
    ) -> tuple[Path, Trajectory]:
        """The path changed while that gains, and its motion with limits held at the nodes."""
        motion = plan(path, machine, planner=CheapEvaluation())
        for number in range(ROUNDS):
            # how many there will be nobody knows; the first ones gain the most
            part = progress.part(1.0 - 0.5**number, 1.0 - 0.5 ** (number + 1))
            changed = refitted(self.toolpath, machine, path, motion, allowed, self.ramp, THOROUGH, part)
            faster = plan(changed, machine, planner=CheapEvaluation())
            gained = 1.0 - faster.duration / motion.duration
            if gained > 0.0:
                path, motion = changed, faster
            if gained < ENOUGH:
                break
        return path, motion


def kept_to_the_promise(motion: Trajectory) -> Trajectory:
    """A motion between rests, slowed down as a whole where the look between its nodes missed something narrow."""
    used = motion.usage().worst
    if used <= PROMISED:
        return motion

    def slowed(law: TimeLaw) -> TimeLaw:
        assert isinstance(law, SplineLaw)
        return law.slowed(used**2)

    return replace(motion, laws=tuple(map(slowed, motion.laws)))


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
            part = progress.part(1.0 - 0.5**number, 1.0 - 0.5 ** (number + 1))
            cells = int(np.clip(dense * time / self.ramp, FEWEST_CELLS, MOST_CELLS))
            solving = part.part(0.0, SOLVED)
            law, points = fastest_law(run, limits, cells, start, end, True, workers, solving, GUARD_ROUNDS)
            bound = bound_long_run(run, limits, law, start, end, workers, part.part(SOLVED, 1.0))
            if best is None or law.duration < best.law.duration:
                best = PlannedRun(law, points, bound.seconds, places_in_time(run, law, bound))
            if law.duration <= (1.0 + LEFT) * bound.seconds:
                break
        assert best is not None
        progress(1.0)
        return best
