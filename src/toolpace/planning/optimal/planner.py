"""The optimal planner: minimum-time motion within velocity, acceleration, jerk and feed limits.

of a run between two states:
  nodes of s, close together where a first idea of the motion is quick to change
  z = (ds/dt)^2, a cubic spline over them:  the fastest within the limits at the nodes        (an interior point)
  where jerk limits are infinite, or nearly so: finer cells where the acceleration switches         (switches)
  repeat while z passes a limit between nodes, or falls too far there                              (the guard)
      cut the cells that pass it by far, put rows where the others pass it most, and solve again around them
  what is left above the guarantee: slow down about it
  multipliers of the limits: no z on these nodes takes less time than ...                             (the bound)
  where that is far off: a finer mesh, or a proof, about the places that keep it so                 (another try)
without a bound, too, where the guard took much longer than the limits at the nodes do
"""

from __future__ import annotations

import contextlib
from dataclasses import dataclass

import numpy as np

from toolpace.common.errors import InfeasibleError
from toolpace.common.workers import UNTOLD, Progress, Workers
from toolpace.machine.limits import Limits
from toolpace.motion.laws import SplineLaw
from toolpace.path.axis_run import AxisRun
from toolpace.planning.bound.relaxation import bound_long_run, places_in_time
from toolpace.planning.mesh.nodes import first_mesh
from toolpace.planning.optimal.acceleration_switches import may_switch, sharpened
from toolpace.planning.optimal.fallback_strategies import FAR, Plan, fallback_plan
from toolpace.planning.optimal.friction_turns import exceeded_turns, turns, with_breaks
from toolpace.planning.optimal.inter_sample_limits import MOST_ROUNDS, held_between_nodes, without_falls
from toolpace.planning.optimal.meshed_run import MeshedRun
from toolpace.planning.optimal.solve import Stalled, start_from
from toolpace.planning.optimal.windows import solve_run
from toolpace.planning.options import Options, check_flag, check_mesh
from toolpace.planning.path_at_probes import CachedPath
from toolpace.planning.planned_run import AT_REST, EndState, PlannedRun, check_state

START_SHARE = 0.4
"""Share of the guess at which a solve starts: well inside, where an interior point is quickest."""
MESHED, SOLVED, GUARDED, BOUNDED = 0.03, 0.25, 0.75, 0.95
"""Shares of a run's planning, for progress, that are done with the mesh, the first solve, the guard, and the bound."""


@dataclass(frozen=True)
class Optimal(Options):
    """The fastest motion within all limits, and a lower bound of how fast any could be on its mesh."""

    mesh: int | None = None
    """Number of mesh cells of each run, at least 8; None: as many as the motion asks for."""
    guard: bool = True
    """Whether limits hold between the nodes too; without it they hold at the nodes only."""
    bound: bool = True
    """Whether a lower bound of the duration is worked out."""

    def __post_init__(self) -> None:
        check_mesh(self.name, self.mesh)
        check_flag(self.name, "guard", self.guard)
        check_flag(self.name, "bound", self.bound)

    @property
    def name(self) -> str:
        """Its short name."""
        return "optimal"

    def plan_run(
        self, run: AxisRun, limits: Limits, start: EndState, end: EndState, workers: Workers, progress: Progress
    ) -> PlannedRun:
        """The fastest law of one run. Raises InfeasibleError where no motion within the limits joins both states."""
        found = self._planned(run, limits, start, end, workers, progress)
        for of_all in (False, True) if self.guard else ():
            exceeded = exceeded_turns(run, limits, found.law)
            if not len(exceeded):
                break
            run = with_breaks(run, turns(run, limits) if of_all else exceeded)
            with contextlib.suppress(InfeasibleError):  # what is exceeded at a turn stands in the usage
                found = self._planned(run, limits, start, end, workers, UNTOLD)
        return found

    def _planned(
        self, run: AxisRun, limits: Limits, start: EndState, end: EndState, workers: Workers, progress: Progress
    ) -> PlannedRun:
        """The same, without looking at turns of joints that are no breaks of the run."""
        part = progress.part(0.0, GUARDED) if self.bound else progress
        fixed = self.mesh is not None
        cache = CachedPath(run)
        law, at_nodes = held_law(run, limits, self.mesh, start, end, self.guard, workers, part, cache=cache)
        if not self.bound and (fixed or law.duration <= (1.0 + FAR) * at_nodes):
            return PlannedRun(law, mesh_points(law))
        bound = bound_long_run(run, limits, law, start, end, workers, progress.part(GUARDED, BOUNDED), cache)
        first = Plan(law, bound)

        def with_cells(cells: int) -> SplineLaw:
            return fastest_law(run, limits, cells, start, end, self.guard, workers)[0]

        best, notes = fallback_plan(run, limits, first, start, end, fixed, self.guard, workers, with_cells, at_nodes)
        progress(1.0)
        if not self.bound:
            return PlannedRun(best.law, mesh_points(best.law), notes=notes)
        return PlannedRun(
            best.law, mesh_points(best.law), best.bound.seconds, places_in_time(run, best.law, best.bound), notes
        )


def fastest_law(
    run: AxisRun,
    limits: Limits,
    cells: int | None = None,
    start: EndState = AT_REST,
    end: EndState = AT_REST,
    guard: bool = True,
    workers: Workers | None = None,
    progress: Progress = UNTOLD,
    most_rounds: int = MOST_ROUNDS,
) -> tuple[SplineLaw, int]:
    """The fastest law of one run, and the number of its mesh points.

    `cells` fixes the mesh; without it the mesh is refined where the motion asks for it. `guard` holds the limits
    between the nodes too, in `most_rounds` of solving anew before the law is slowed down. Raises InfeasibleError where
    no motion within the limits joins both ends.
    """
    law, _ = held_law(run, limits, cells, start, end, guard, workers or Workers(), progress, most_rounds)
    return law, mesh_points(law)


def held_law(
    run: AxisRun,
    limits: Limits,
    cells: int | None,
    start: EndState,
    end: EndState,
    guard: bool,
    workers: Workers,
    progress: Progress = UNTOLD,
    most_rounds: int = MOST_ROUNDS,
    cache: CachedPath | None = None,
) -> tuple[SplineLaw, float]:
    """The fastest law, as `fastest_law` has it, and the duration of that with limits held at the nodes only [s].

    `cache` keeps what is learnt of the path.
    """
    check_state(run, limits, start, run.s0)
    check_state(run, limits, end, run.s1)
    nodes, rough = first_mesh(run, limits, (start.speed**2, end.speed**2), cells)
    meshed = MeshedRun.after_guess(run, limits, nodes, (start, end), rough, cache)
    progress(MESHED)
    try:
        begin = start_from(meshed, rough.s, rough.z, START_SHARE)
        del rough  # of a long run it takes much memory
        c = solve_run(meshed, begin, 1.0, workers, progress.part(MESHED, SOLVED))
        law = SplineLaw(meshed.nodes, c, meshed.rest)
        at_nodes, part = law.duration, progress.part(SOLVED, 1.0)
        if cells is None and may_switch(limits, law):
            law = law_with_switches(meshed, law, guard, workers, part, most_rounds)
        elif guard:
            law = held_between_nodes(meshed, law, cells is not None, workers, part, most_rounds)
        elif cells is None:
            law = without_falls(meshed, law, workers)
    except Stalled as stall:
        raise no_motion(run, stall, cells) from None
    progress(1.0)
    return law, at_nodes


def law_with_switches(
    meshed: MeshedRun, law: SplineLaw, guard: bool, workers: Workers, progress: Progress, most_rounds: int
) -> SplineLaw:
    """The fastest law of a run on finer cells where its acceleration switches; with `guard`, held between the nodes.

    Where the guard takes away more than the switches have won, the mesh before is tried too.
    """
    finer, sharp = sharpened(meshed, law, workers)
    if not guard:
        return sharp
    held = held_between_nodes(finer, sharp, False, workers, progress, most_rounds)
    if held.duration <= law.duration or finer is meshed:
        return held
    with contextlib.suppress(Stalled):
        again = held_between_nodes(meshed, law, False, workers, UNTOLD, most_rounds)
        held = min(held, again, key=lambda one: one.duration)
    return held


def mesh_points(law: SplineLaw) -> int:
    """The number of its nodes, those at rest with them."""
    return len(law.nodes) + sum(rest > 0.0 for rest in law.rest)


def no_motion(run: AxisRun, stall: Stalled, cells: int | None) -> InfeasibleError:
    """The error of a run on which the solver found no point within the limits."""
    block = int(run.block_at(np.array([stall.place]))[0])
    return InfeasibleError(
        f"no motion from and to the given states found: {stall.limit} is exceeded near s = {stall.place:.9g}"
        + (f" (block {block})" if block else "")
        + "; start or end more slowly"
        + (f", or leave the mesh of {cells} cells to the planner" if cells is not None else "")
    )
