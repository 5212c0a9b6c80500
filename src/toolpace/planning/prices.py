"""Prices of limits: the time that one percent more of each limit would gain, from the multipliers of a plan's optimum.

With T the least duration and l a limit, dT / dl is minus the sum of the multipliers of its rows times what the rows'
bounds grow by (the envelope theorem; Boyd and Vandenberghe 2004, section 5.6):

    acceleration  |r . (z, z', z'')| <= 1             multiplier
    jerk          |r . (z, z', z'')| <= z^(-1/2)      multiplier times z^(-1/2)
    velocity, feed              z <= cap              multiplier times 2 cap, for the limit that makes the cap
    torque        tau <= limit                        multiplier times the motor's limit, over the scale of its row
    any, in a cell next to rest z <= cap              multiplier times cap times 2, 1 or 2/3: how z there grows with it

The multipliers are those of the plan's own mesh, of an optimum found again from its motion. One figure checks all: with
k times the velocity, k^2 times the acceleration and k^3 times the jerk every motion takes 1 / k of the time, so that
the prices of feed and velocity, twice those of acceleration and three times those of jerk sum to a hundredth of it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.common.errors import UsageError
from toolpace.common.workers import Workers
from toolpace.kernels.optimal import newton, solver
from toolpace.machine.dynamics.torques import JointTorque
from toolpace.machine.limits import Limits
from toolpace.motion.laws import SplineLaw
from toolpace.motion.trajectory import Trajectory
from toolpace.path.axis_run import AxisRun
from toolpace.planning.bound.relaxation import OVERLAP_RAMPS, SAMPLES, borders, coefficients_of, highest_speed
from toolpace.planning.mesh.initial_guess import ramp_time
from toolpace.planning.optimal.own_rows import LineRows
from toolpace.planning.optimal.problem import (
    REST_POWERS,
    REST_STATES,
    Problem,
    discretise,
    rest_caps_by_limit,
    with_rows_between,
)
from toolpace.planning.optimal.solve import MOST_STEPS, SPREAD, TOLERANCE, reliefs, slower, starts_from
from toolpace.planning.planned_run import AT_REST, EndState

PERCENT = 0.01
LOSS = 0.03
"""Share of z by which the search for the optimum starts below the plan."""
GIVE = 1e-4
"""Share by which limits are raised in a part of a run: between ends that are at their limits already there may be no
other motion within the same ones."""


class Multipliers(NamedTuple):
    """The multipliers at an optimum, and the bounds that they are of."""

    cap: Floats
    """(points,) of the caps on z."""
    rows: Floats
    """(points, 2 h) of the rows of acceleration, then of jerk, above and below."""
    z: Floats
    """(points,)"""
    speed: Floats | None = None
    """(points, k) ds/dt where the rows are held whose limits depend on the speed."""


def prices(trajectory: Trajectory) -> dict[str, float]:
    """The time that one percent more of each finite limit would gain [s], by the names of `limited_by`, largest first.

    For plans of the optimal planner. Raises UsageError for the motion of another one, and where no optimum was found.
    """
    laws = [law for law in trajectory.laws if isinstance(law, SplineLaw)]
    if len(laws) < len(trajectory.laws):
        raise UsageError(
            f"prices: a plan of the planner '{trajectory.planner}' has no multipliers; plan with planner='optimal'"
        )
    limits = trajectory.limits
    parts = [
        part for run, law in zip(trajectory.axis_path.runs, laws, strict=True) for part in parts_of(run, limits, law)
    ]
    total = PERCENT * np.sum(Workers().each(lambda part: part_prices(limits, part), parts), axis=0)
    of_joints = np.concatenate([limits.velocity, limits.acceleration, limits.jerk])
    finite = [True, *np.isfinite(of_joints), *(True for _ in limits.rows)]
    named = [each for each, told in zip(zip(limits.names, total.tolist()), finite) if told]
    return dict(sorted(named, key=lambda item: -item[1]))


class RunPart(NamedTuple):
    """A part of a run, all of a short one: the multipliers of its nodes `first` to `last` count, those of the nodes
    `low` to `high` are found with them."""

    run: AxisRun
    law: SplineLaw
    highest: float
    """The highest z of the run at steady speed."""
    low: int
    high: int
    first: int
    last: int


def parts_of(run: AxisRun, limits: Limits, law: SplineLaw) -> list[RunPart]:
    """The parts of a run, which overlap as those of its bound do."""
    border, over = borders(law, OVERLAP_RAMPS * min(ramp_time(limits), law.duration))
    highest = highest_speed(run, limits, law, law.nodes[:: max(len(law.nodes) // SAMPLES, 1)])
    ends = zip(border[:-1].tolist(), border[1:].tolist(), over[:-1].tolist(), over[1:].tolist())
    return [
        RunPart(run, law, highest, first - before, last + after, first, last) for first, last, before, after in ends
    ]


def part_prices(limits: Limits, part: RunPart) -> Floats:
    """(k,) how much less time the nodes of a part take per relative growth of each limit [s].

    The node at which one part ends and the next begins counts by half in each.
    """
    run, law = part.run, part.law
    problem = problem_of_part(limits, part)
    multipliers = multipliers_near(problem, coefficients_of(problem.nodes, law.cells[part.low : part.high]))
    node = problem.node + part.low
    counts = ((node >= part.first) & (node < part.last + ~problem.inside)).astype(np.float64)
    for border, end in ((part.first, 0), (part.last, len(law.nodes) - 1)):
        if border != end:
            counts[(node == border) & ~problem.inside] = 0.5
    of_caps = (multipliers.cap * problem.cap)[:, None] * cap_growth(run, limits, problem)
    gains: Floats = counts @ (row_gains(limits, multipliers, problem) + of_caps)
    return gains


def row_gains(limits: Limits, multipliers: Multipliers, problem: Problem) -> Floats:
    """(points, k) what the rows of a point gain per relative growth of each limit."""
    m, half, gains = len(limits), limits.half, multipliers.rows.copy()
    if problem.lines is not None and multipliers.speed is not None:
        gains[:, problem.lines.column] *= line_growth(limits, problem.lines, multipliers.speed)
    gains[:, half:] /= np.sqrt(multipliers.z)[:, None]
    columns = [np.zeros((len(gains), 1 + m)), gains[:, :m], gains[:, half : half + m]]
    at = {1: m, 2: half + m}
    for rows in limits.rows:
        columns.append(gains[:, at[rows.order] : at[rows.order] + rows.width].sum(axis=1, keepdims=True))
        at[rows.order] += rows.width
    return np.concatenate(columns, axis=1)


def line_growth(limits: Limits, lines: LineRows, speed: Floats) -> Floats:
    """(points, k) by what the bounds of scaled rows grow per relative growth of their limits at ds/dt (points, k)."""
    growth, first = lines.limits(speed), len(limits)
    height, fall = lines.chosen(speed)
    for rows in limits.rows:
        if isinstance(rows, JointTorque):
            # all of a torque grows, of which weight and friction leave but a part: both sides together leave all twice
            own = np.isin(lines.column, np.arange(first, first + rows.width))
            left = height[:, own] - fall[:, own] * speed[:, own]
            growth[:, own] = (left + np.roll(left, rows.pieces, axis=1)) / 2.0 / (np.abs(height[:, own]) + 1.0)
        first += rows.width if rows.order == 1 else 0
    return growth


def problem_of_part(limits: Limits, part: RunPart) -> Problem:
    """The problem of a part, with rows in the middles of the cells too."""
    law = part.law
    outer = ((part.low, 0, law.s0), (part.high, len(law.nodes) - 1, law.s1))
    rests = [node == end and law.rest[k] > 0.0 for k, (node, end, _) in enumerate(outer)]
    start, end = (AT_REST if rests[k] else state_at(law, node) for k, (node, _, _) in enumerate(outer))
    nodes = law.nodes[part.low : part.high + 1]
    around = np.concatenate([[law.s0] * rests[0], nodes, [law.s1] * rests[1]])
    problem = discretise(part.run, limits, around, start, end, part.highest)
    problem = with_rows_between(problem, part.run, limits, (nodes[1:] + nodes[:-1]) / 2.0)
    return problem.raised(0.0 if all(rests) else GIVE)


def state_at(law: SplineLaw, node: int) -> EndState:
    """The state in which a law passes a node."""
    cell = law.cells[min(node, len(law.cells) - 1)]
    if node < len(law.cells):
        return EndState(float(np.sqrt(cell[0])), float(cell[1]) / 2.0)
    s = law.nodes[-1] - law.nodes[-2]
    z, slope = np.polyval(cell[::-1], s), np.polyval(np.polyder(cell[::-1]), s)
    return EndState(float(np.sqrt(z)), float(slope) / 2.0)


def multipliers_near(problem: Problem, c: Floats) -> Multipliers:
    """The multipliers at the optimum of a problem, found from coefficients near it. Raises UsageError where none is."""
    problem, rests = problem.about(c), bool((problem.end == newton.REST).all())
    for begin, spread in starts_from(problem, slower(problem, c, LOSS), SPREAD, rests, once=False):
        relief = reliefs(problem, begin)
        if not np.isfinite(relief).all():
            continue
        found = solver.maximise_speed(
            problem.as_points(), problem.as_ends(), begin.copy(), relief, spread, 0.0, TOLERANCE, MOST_STEPS
        )
        if found.status == solver.OPTIMAL:
            count, both = len(problem.node), found.dual_rows.sum(axis=2)
            rows = both.transpose(0, 2, 1).reshape(-1, both.shape[1])[:count]
            near = problem.first[:, None] + np.arange(4)
            z = np.einsum("pj,pj->p", problem.basis[:, 0], found.c[near])
            speed = None if problem.lines is None else problem.lines.speeds(problem.basis, found.c[near])
            return Multipliers(found.dual_cap.reshape(-1)[:count], rows, z, speed)
    raise UsageError(
        f"prices: no optimum found from s = {problem.nodes[0]:.9g} to {problem.nodes[-1]:.9g}; plan on another mesh"
    )


def cap_growth(run: AxisRun, limits: Limits, problem: Problem) -> Floats:
    """(points, k) by what power of a limit the cap of a point grows: 0 but for the limit that makes it."""
    powers, count = REST_POWERS[limits.orders], len(problem.node)
    path, feed = run.with_cap(np.clip(problem.place, run.s0, run.s1))
    with np.errstate(divide="ignore"):
        most = np.concatenate([feed[:, None], limits.velocity / np.abs(path[1])], axis=1) ** 2.0
    growth = np.zeros((count, len(powers)))
    growth[np.arange(count), most.argmin(axis=1)] = 2.0
    share = (1.0 - np.cos(np.linspace(0.0, np.pi, REST_STATES))) / 2.0
    for point, end in ((0, 0), (-1, 1)):
        if problem.end[end] != newton.REST:
            continue
        node = float(problem.nodes[point])
        by_limit = rest_caps_by_limit(run, limits, node, problem.rest[end], end == 0, share).min(axis=0)
        if by_limit.min() < most[point].min():
            growth[point] = np.where(np.arange(len(powers)) == by_limit.argmin(), powers, 0.0)
    return growth
