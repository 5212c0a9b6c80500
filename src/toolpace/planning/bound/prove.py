"""A tighter bound of a plan by branch and bound, within a time budget."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from toolpace.common.arrays import Floats, number
from toolpace.common.errors import UsageError
from toolpace.common.units import refuse_other_unit
from toolpace.common.workers import UNTOLD, CallersProgress, Progress, Workers
from toolpace.machine.limits import Limits
from toolpace.motion.laws import SplineLaw
from toolpace.motion.trajectory import Trajectory
from toolpace.path.axis_run import AxisRun
from toolpace.planning.bound.branch_and_bound import Allowance, Part, close
from toolpace.planning.bound.continuous import with_continuous_bound
from toolpace.planning.bound.gap_localisation import Place, losses_by_knot, open_places, settled
from toolpace.planning.bound.problem import Knots
from toolpace.planning.bound.relaxation import (
    STANDS_STILL,
    Bound,
    Relaxation,
    bound_long_run,
    coefficients,
    places_in_time,
    problem_of,
    relaxed,
)
from toolpace.planning.mesh.initial_guess import ramp_time
from toolpace.planning.optimal.problem import Problem
from toolpace.planning.optimal.solve import Stalled, slower, solve
from toolpace.planning.planned_run import AT_REST, EndState, PlannedRun, total_bound

GAP = 1e-4
"""What is to be proved, unless something else is asked for: duration / bound - 1."""
START_LOSS, START_SPREAD = 0.1, 0.1
"""How the search for a better motion starts where limits hold at the nodes only: the plan, so much slower."""


WIDEST_GAP = 0.5
"""A gap that is worth proving."""


def prove(
    trajectory: Trajectory,
    *,
    gap: float = GAP,
    within: float = 60.0,
    progress: Callable[[float], None] | None = None,
) -> Trajectory:
    """The same motion with its lower bound raised, until it is no more than `gap` from the best or `within` [s] is up.

    Its bound of the continuous problem is worked out too, where there is one (see `continuous.py`).
    For plans of the optimal planner. What is proved before the time is up counts. `progress` is called with the share
    of the gap that is closed. Raises UsageError for the motion of another planner.
    """
    if not all(isinstance(law, SplineLaw) for law in trajectory.laws):
        raise UsageError(f"prove: a plan of the planner '{trajectory.planner}' has no mesh to prove anything on")
    gap = number(gap, "prove: gap", least=0.0)
    within = number(within, "prove: within", least=0.0, endless=True, unit="s")
    refuse_other_unit(gap, WIDEST_GAP, "prove: gap", "give a share: 0.01 percent is 1e-4")
    until = time.monotonic() + within
    runs, limits = trajectory.axis_path.runs, trajectory.limits
    laws = [law for law in trajectory.laws if isinstance(law, SplineLaw)]
    reported = CallersProgress(progress)
    workers = Workers(reported)
    bounds = workers.each(
        lambda k: bound_long_run(runs[k], limits, laws[k], *end_states(laws[k]), workers=workers), range(len(runs))
    )
    open_ = np.array([bound.duration - bound.seconds for bound in bounds])
    total = max(float(open_.sum()), 1e-300)
    done = 0.0
    for k in np.argsort(-open_).tolist():
        if bounds[k].gap > gap and time.monotonic() < until:
            share = open_[k] / total
            part = reported.part(done, done + share)
            states = end_states(laws[k])
            bounds[k] = prove_run(
                runs[k], limits, laws[k], gap, Allowance(until), *states, workers=workers, progress=part
            )
        done += open_[k] / total
    unmeshed = with_continuous_bound(trajectory, workers)
    reported(1.0)
    proved = [
        PlannedRun(law, 0, bound.seconds, places_in_time(run, law, bound))
        for run, law, bound in zip(runs, laws, bounds, strict=True)
    ]
    lower_bound, places = total_bound(trajectory.axis_path, proved)
    return replace(unmeshed, lower_bound=max(lower_bound, trajectory.lower_bound), open_places=places)


def end_states(law: SplineLaw) -> tuple[EndState, EndState]:
    """How a law starts and ends."""
    t = np.array([0.0, law.duration])
    _, speed, acceleration, _ = law.at(t)
    start, end = (
        EndState(float(speed[k]), float(acceleration[k])) if law.rest[k] == 0.0 else AT_REST for k in range(2)
    )
    return start, end


def prove_run(
    run: AxisRun,
    limits: Limits,
    law: SplineLaw,
    target: float,
    allowance: Allowance,
    start: EndState = AT_REST,
    end: EndState = AT_REST,
    workers: Workers | None = None,
    progress: Progress = UNTOLD,
) -> Bound:
    """The bound of a run's plan, raised until the gap is at most `target` or the allowance is spent.

    Place by place: the multipliers may change in a part around it; what lies outside is priced by those found. So
    what is gained at places whose parts do not overlap adds up. Limits that depend on the speed are those of planes
    above them that touch them at the plan: in a narrow range both are the same.
    """
    workers = workers or Workers()
    problem = problem_of(run, limits, law, start, end)
    knots, c = Knots(problem), coefficients(law)
    found, least = relaxed(knots, c, np.zeros_like(knots.cap), knots.cap), 0.0
    if knots.lines is not None:
        least = found.value
        speeds = [np.sqrt(np.minimum(knots.state(each)[:, 0], knots.cap)) for each in (c, found.c)]
        knots, _ = knots.within_planes(c, speeds, exact=True)
        found = relaxed(knots, c, np.zeros_like(knots.cap), knots.cap)
    dual = settled(knots, found.dual)
    pace = knots.state(c)[:, 0] ** -0.5
    planned = float(knots.weight @ pace)
    value, losses = losses_by_knot(knots, c, dual)
    first, wanted = value, planned / (1.0 + target)
    places = []
    ramp = min(ramp_time(limits), law.duration)
    for place in open_places(found.wait > STANDS_STILL * pace, losses, law.times, ramp):
        gained = 0.0
        if value < wanted and not allowance.is_spent:

            def closed(gain: float, before: float = value) -> None:
                progress(min((before + gain - first) / (wanted - first), 1.0))

            part = part_around(knots, place, found, dual, law.times)
            lost = place.open - to_gain(problem, c, place)
            gained = close(part, lost, wanted - value, allowance, ramp, workers, Progress(closed))
        value += gained
        places.append((law.nodes[place.first], law.nodes[place.last], place.open - gained))
    kept = np.array(places).reshape(-1, 3)
    return Bound(law.duration, planned, max(value, found.value, least), kept, found.steps)


def part_around(knots: Knots, place: Place, found: Relaxation, dual: Floats, clock: Floats) -> Part:
    """The part around a place."""
    part = knots.part(place.low, place.high, found.c, dual)
    mine = slice(place.low, place.high + 1)
    prices = knots.of_part(part, place.low, dual)
    c = found.c[place.low : place.high + 3]
    return Part(part, clock[mine], Relaxation(part.value(prices), prices, found.wait[mine], c, 0))


def to_gain(problem: Problem, c: Floats, place: Place) -> float:
    """What a plan loses in a part against the best motion that holds the limits at the nodes only [s]."""
    piece = problem.stretch(place.low, place.high)
    mine = c[place.low : place.high + 3]
    try:
        best = solve(piece, slower(piece, mine, START_LOSS), START_SPREAD)
    except Stalled:
        return 0.0
    basis, place_of = piece.basis[:, 0], piece.first[:, None] + np.arange(4)
    paces = [np.einsum("pj,pj->p", basis, of[place_of]) ** -0.5 for of in (mine, best)]
    return max(float(piece.weight @ (paces[0] - paces[1])), 0.0)
