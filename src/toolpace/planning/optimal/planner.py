"""The optimal planner: the fastest motion along a path within velocity, acceleration, jerk and feed."""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np

from toolpace.axispath.axispath import AxisPath
from toolpace.axispath.run import AxisRun
from toolpace.errors import InfeasibleError
from toolpace.laws.spline import SplineLaw
from toolpace.machine.limits import Limits
from toolpace.planning.bound.pieces import bound_long_run
from toolpace.planning.bound.relaxation import Bound, summed
from toolpace.planning.endstate import AT_REST, EndState, check_state
from toolpace.planning.mesh.guess import ramp_time
from toolpace.planning.mesh.nodes import first_mesh
from toolpace.planning.optimal.guard import guarded
from toolpace.planning.optimal.meshed_run import Course
from toolpace.planning.optimal.solve import Stalled, start_from
from toolpace.planning.optimal.windows import solve_run
from toolpace.trajectory import Trajectory
from toolpace.workers import Crew, Tally, Tell, part_of, untold

START_SHARE = 0.4
"""Share of the guess at which a solve starts."""
MESHED, SOLVED, GUARDED = 0.03, 0.25, 0.75
"""Shares of a run's planning that are done with the mesh, the first solve, and the guard."""


def plan_run(
    run: AxisRun,
    limits: Limits,
    *,
    cells: int | None = None,
    start: EndState = AT_REST,
    end: EndState = AT_REST,
    guard: bool = True,
    crew: Crew | None = None,
    tell: Tell = untold,
) -> tuple[SplineLaw, int]:
    """The fastest law of one run, and the number of its mesh points.

    `cells` fixes the mesh; without it the mesh is refined where the motion asks for it. `guard` holds the limits
    between the nodes too: where a solution breaks one, the mesh is refined there, or the rows of that place are
    tightened, and it is solved again. Raises InfeasibleError where no motion within the limits joins both ends.
    """
    crew = crew or Crew()
    check_state(run, limits, start, run.s0)
    check_state(run, limits, end, run.s1)
    nodes, rough = first_mesh(run, limits, (start.speed**2, end.speed**2), cells)
    course = Course(run, limits, nodes, (start, end), max(rough.highest, start.speed**2, end.speed**2))
    course.clock = np.interp(course.nodes, rough.s, rough.t)
    course.ramp = min(ramp_time(limits), rough.t[-1])
    tell(MESHED)
    try:
        begin = start_from(course, rough.s, rough.z, START_SHARE)
        del rough
        law = SplineLaw(course.nodes, solve_run(course, begin, 1.0, crew, part_of(tell, MESHED, SOLVED)), course.rest)
        if guard:
            law = guarded(course, law, cells is not None, crew, part_of(tell, SOLVED, GUARDED))
    except Stalled as stall:
        block = int(run.block_at(np.array([stall.place]))[0])
        raise InfeasibleError(
            f"no motion from and to the given states found: {stall.limit} is passed near s = {stall.place:.9g}"
            + (f" (block {block})" if block else "")
            + "; start or end more slowly"
            + (f", or leave the mesh of {cells} cells to the planner" if cells is not None else "")
        ) from None
    tell(GUARDED)
    return law, len(law.nodes) + sum(rest > 0.0 for rest in law.rest)


def plan_optimal(
    axis_path: AxisPath,
    limits: Limits,
    *,
    cells: int | None = None,
    start: EndState = AT_REST,
    end: EndState = AT_REST,
    guard: bool = True,
    bound: bool = True,
    progress: Callable[[float], None] | None = None,
) -> Trajectory:
    """The fastest trajectory along all runs; `start` is the state at the start of the first, `end` of the last.

    `bound` asks for the lower bound of the duration too.
    """
    began = time.perf_counter()
    runs = axis_path.runs
    last = len(runs) - 1
    lengths = np.array([run.s1 - run.s0 for run in runs])
    tally = Tally(progress, (lengths / lengths.sum()).tolist())
    crew = Crew(tally)

    def one(k: int) -> tuple[SplineLaw, int, Bound | None]:
        states = start if k == 0 else AT_REST, end if k == last else AT_REST
        tell = tally.of(k)
        try:
            law, count = plan_run(
                runs[k], limits, cells=cells, start=states[0], end=states[1], guard=guard, crew=crew, tell=tell
            )
            least = None
            if bound:
                least = bound_long_run(runs[k], limits, law, *states, crew, part_of(tell, GUARDED, 1.0))
        except BaseException:
            # without this run the others are of no use
            crew.stopped = True
            raise
        tell(1.0)
        return law, count, least

    planned = crew.aside(lambda: crew.each(one, range(len(runs))))
    laws = tuple(law for law, _, _ in planned)
    bounds = [least for _, _, least in planned if least is not None]
    lower_bound, open_places = summed(axis_path, laws, bounds) if bound else (0.0, ())
    return Trajectory(
        axis_path,
        limits,
        laws,
        lower_bound=lower_bound,
        open_places=open_places,
        mesh_points=sum(count for _, count, _ in planned),
        solve_seconds=time.perf_counter() - began,
    )
