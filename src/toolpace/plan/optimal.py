"""The optimal planner: the fastest motion along a path within velocity, acceleration, jerk and feed."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import numpy.typing as npt

from toolpace.axispath import AxisPath, AxisRun
from toolpace.errors import InfeasibleError
from toolpace.kernels import cubic
from toolpace.limits import Limits
from toolpace.plan.bound import bound_run
from toolpace.plan.endstate import AT_REST, EndState, check_state
from toolpace.plan.mesh import first_mesh, ramp_time, split
from toolpace.plan.peaks import cell_peaks
from toolpace.plan.problem import ALLOWED, Problem, discretise
from toolpace.plan.solve import MOST_MENDED, Stalled, mend, slower, solve_long, start_from, stretches
from toolpace.timelaw import SplineLaw
from toolpace.trajectory import Trajectory

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Bools = npt.NDArray[np.bool_]

START_SHARE = 0.4
"""Share of the guess at which a solve starts."""
START_LOSS = 0.03
"""Share of z by which a solve that starts from a solution is slowed down first."""
WARM_SPREAD = 0.03
"""First gap of such a solve, relative to the duration."""
REFINE_ROUNDS = 6
LEAST_CELL = 1e-3
"""Time of a cell, as a share of that in which an acceleration builds up, below which it is cut no further."""
GUARANTEE = 1.0 + 9e-5
"""Usage between nodes that is never passed, a rounding below what is promised."""
REFINE_ABOVE = 1.003
"""Usage between nodes from which a cell is cut rather than its limits lowered."""
QUARTER_ABOVE = 1.05
FLOOR = 0.3
"""Where z dips between two nodes: what it starts from on the finer mesh, as a share of z at the nodes."""
MOST_ROUNDS = 20
OVERSHOOT = 1.2
URGE = 1.3
MOST_OVERSHOOT = 6.0
"""How far a limit is lowered, as a multiple of how far it was passed; by how much more after each round; at most."""


def plan_run(
    run: AxisRun,
    limits: Limits,
    *,
    cells: int | None = None,
    start: EndState = AT_REST,
    end: EndState = AT_REST,
    guard: bool = True,
) -> tuple[SplineLaw, int]:
    """The fastest law of one run, and the number of its mesh points.

    `cells` fixes the mesh; without it the mesh is refined where the motion asks for it. `guard` holds the limits
    between the nodes too: where a solution breaks one, the mesh is refined there, or the rows of that place are
    tightened, and it is solved again. Raises InfeasibleError where no motion within the limits joins both ends.
    """
    check_state(run, limits, start, run.s0)
    check_state(run, limits, end, run.s1)
    nodes, rough = first_mesh(run, limits, (start.speed**2, end.speed**2), cells)
    problem = discretise(run, limits, nodes, start, end)
    problem.clock = np.interp(problem.nodes, rough.s, rough.t)
    problem.ramp = min(ramp_time(limits), rough.t[-1])
    try:
        c = solve_long(problem, start_from(problem, rough.s, rough.z, START_SHARE), spread=1.0)
        law = SplineLaw(problem.nodes, c, problem.rest)
        if guard:
            law = guarded(run, limits, problem, law, (start, end), fixed=cells is not None)
    except Stalled as stall:
        block = int(run.block_at(np.array([stall.place]))[0])
        raise InfeasibleError(
            f"no motion within the limits found: stuck near s = {stall.place:.9g}"
            + (f" (block {block})" if block else "")
            + "; if the run starts or ends in motion, let it do so more slowly"
        ) from None
    return law, len(law.nodes) + sum(rest > 0.0 for rest in law.rest)


def guarded(
    run: AxisRun, limits: Limits, problem: Problem, law: SplineLaw, ends: tuple[EndState, EndState], fixed: bool
) -> SplineLaw:
    """The law with its limits held between the nodes too. Raises Stalled where that cannot be had.

    Where a limit is passed, the mesh is refined (unless it is fixed) or the rows there are tightened, and the
    surroundings are solved again. What that leaves, slowing the whole motion down takes away.
    """
    c = law.c
    peak = cell_peaks(run, limits, law)
    for round_ in range(MOST_ROUNDS):
        dips = law.dips()
        wrong = (peak.max(axis=1) > ALLOWED) | dips
        if not wrong.any():
            break
        worst = float(peak.max())
        parts = np.where(dips, 4, 1 if fixed or round_ >= REFINE_ROUNDS else halves(peak))
        parts[np.diff(law.times) < problem.ramp * LEAST_CELL] = 1
        if parts.max() > 1:
            problem, c = refined(run, limits, problem, law, parts, ends)
            wrong = np.repeat(wrong, parts)
            peak = np.repeat(np.where(parts[:, None] > 1, 1.0, peak), parts, axis=0)
        else:
            problem.clock = law.times
        problem.tighten(peak, min(OVERSHOOT * URGE ** max(round_ - 2, 0), MOST_OVERSHOOT), reach=1 + round_ // 3)
        try:
            c, moved = resolve(problem, c, wrong, START_LOSS + 1.0 - 1.0 / min(worst, 1.5))
        except Stalled:
            break
        law = SplineLaw(problem.nodes, c, problem.rest)
        peak[moved] = cell_peaks(run, limits, law, moved)
    return kept(law, cell_peaks(run, limits, law))


def refined(
    run: AxisRun, limits: Limits, problem: Problem, law: SplineLaw, parts: Ints, ends: tuple[EndState, EndState]
) -> tuple[Problem, Floats]:
    """The problem with its cells cut into so many parts, and the same spline on the finer mesh."""
    inner = split(problem.nodes, parts)
    outer = [run.s0] if problem.rest[0] else [], [run.s1] if problem.rest[1] else []
    finer = discretise(run, limits, np.concatenate([outer[0], inner, outer[1]]), *ends)
    finer.clock, finer.ramp = np.interp(finer.nodes, law.nodes, law.times), problem.ramp
    finer.lower(np.repeat(problem.lowered, np.append(parts, 1), axis=0))
    c = cubic.on_finer_knots(problem.nodes, law.cells, finer.nodes)
    least = FLOOR * np.interp(cubic.control_points(finer.nodes), problem.nodes, law.z_at_nodes())
    return finer, np.maximum(c, least)


def kept(law: SplineLaw, peak: Floats) -> SplineLaw:
    """The law, slowed down as a whole where all rounds have left a trifle above the guarantee (cells, 3)."""
    speed, acceleration, jerk = peak.max(axis=0)
    worst = max(speed, acceleration, jerk)
    if worst <= GUARANTEE:
        return law
    if not (law.rest[0] > 0.0 and law.rest[1] > 0.0 and np.isfinite(worst)) or law.dips().any():
        raise Stalled(float(law.nodes[int(peak.max(axis=1).argmax())]))
    return law.slowed(max(1.0, speed**2, acceleration, jerk ** (2.0 / 3.0)))


def halves(peak: Floats) -> Ints:
    """Parts into which the cells of these peaks (cells, 3) are cut."""
    worst = peak.max(axis=1)
    return np.where(worst > QUARTER_ABOVE, 4, np.where(worst > REFINE_ABOVE, 2, 1))


def resolve(problem: Problem, c: Floats, wrong: Bools, loss: float) -> tuple[Floats, Ints]:
    """New coefficients after the rows or the mesh at the marked cells changed, and the cells that moved.

    Only stretches around those cells are solved again, unless they are most of the run.
    """
    everything = np.arange(len(problem.nodes) - 1)
    parts = stretches(problem, wrong)
    if sum(part.high - part.low for part in parts) < MOST_MENDED * len(everything):
        try:
            mended, solved = mend(problem, c, parts, loss, WARM_SPREAD)
        except Stalled:
            pass
        else:
            moved = [np.arange(max(low - 1, 0), min(high + 1, len(everything))) for low, high, _, _ in solved]
            return mended, np.unique(np.concatenate(moved))
    return solve_long(problem, slower(problem, c, loss), WARM_SPREAD), everything


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
    whole = runs[-1].s1 - runs[0].s0

    def one(k: int) -> tuple[SplineLaw, int, float]:
        states = start if k == 0 else AT_REST, end if k == last else AT_REST
        law, count = plan_run(runs[k], limits, cells=cells, start=states[0], end=states[1], guard=guard)
        least = bound_run(runs[k], limits, law, *states).seconds if bound else 0.0
        return law, count, least if np.isfinite(least) else 0.0

    laws, points, least, done = [], 0, axis_path.first_dwell, 0.0
    with ThreadPoolExecutor(max_workers=os.cpu_count() or 1) as pool:
        for run, (law, count, seconds) in zip(runs, pool.map(one, range(len(runs)))):
            laws.append(law)
            points += count
            least += seconds + run.dwell
            done += (run.s1 - run.s0) / whole
            if progress is not None:
                progress(min(done, 1.0))
    return Trajectory(
        axis_path,
        limits,
        tuple(laws),
        lower_bound=least if bound else 0.0,
        mesh_points=points,
        solve_seconds=time.perf_counter() - began,
    )
