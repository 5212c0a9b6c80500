"""A lower bound of the continuous problem of a run or of a whole plan, by a dual function of multipliers over s.

Multipliers of a fine mesh, even in time, are smoothed to functions; any functions give a bound. So it does not depend
on the mesh of the plan. The derivation is in docs/design/bound.md.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.common.workers import Workers
from toolpace.kernels.motion import cubic_spline
from toolpace.kernels.optimal import continuous_dual, first_guess
from toolpace.machine.limits import Limits
from toolpace.motion.laws import SplineLaw
from toolpace.motion.trajectory import Trajectory
from toolpace.path.axis_run import AxisRun
from toolpace.planning.bound.gap_localisation import settled
from toolpace.planning.bound.problem import Knots
from toolpace.planning.bound.relaxation import relaxed
from toolpace.planning.mesh.initial_guess import ramp_time
from toolpace.planning.mesh.nodes import STEPS_A_RAMP
from toolpace.planning.optimal.problem import discretise
from toolpace.planning.optimal.solve import pinned
from toolpace.planning.planned_run import AT_REST

FEWEST, MOST = 4_000, 50_000
"""Cells of the mesh; a run whose plan needs more has no such bound."""
POINTS = (6, 12)
"""Of Gauss' rule in a cell; what the two differ by is taken off the bound."""
COUNTS = np.array([1, 2, 3, 4, 6, 8, 12, 16])
"""Over how many cells theta may be evened."""
TOLERANCE = 1e-7
"""Of the relaxation on that mesh: noise of multipliers is differentiated twice."""
FROM_REST = 3
"""Nodes next to rest, where multipliers of the mesh are no good: they are continued from the next ones."""
LEAST_KAPPA = 1e-3
"""Kappa below which a knot's pace is taken at this one, in the guess of theta only: any theta gives a bound."""
CHEAP = 40_000
"""Cells of all runs together up to which this bound is cheap: a second or two of the machine's time."""


def continuous_bound(run: AxisRun, limits: Limits, law: SplineLaw) -> float:
    """A lower bound of the duration of any motion along a run from rest to rest within the limits [s].

    `law` is a plan, which the bound is close to where the plan is good. 0 where none can be given: for a run that
    starts or ends in motion, or is too long.
    """
    if not (law.rest[0] > 0.0 and law.rest[1] > 0.0) or len(law.nodes) > MOST:
        return 0.0
    # rows of one's own have no multipliers here: without them from the start, those of the joints make up for it
    limits = replace(limits, rows=())
    # cells of the plan may be long where the feed holds it; multipliers need even ones that tell a ramp
    ramps = law.duration / ramp_time(limits)
    cells = int(max(FEWEST, len(law.nodes), min(STEPS_A_RAMP * ramps, MOST)))
    step = law.duration / cells
    t = step * np.arange(1.0, cells, dtype=np.float64)
    s, speed = law.at(t)[:2]
    nodes = np.concatenate([[law.s0], s, [law.s1]])
    if (np.diff(nodes) <= 0.0).any():
        return 0.0
    problem = discretise(run, limits, nodes, AT_REST, AT_REST)
    knots = Knots(problem)
    c = pinned(problem, np.interp(cubic_spline.control_points(problem.nodes), s, speed**1.5) ** (4.0 / 3.0))
    found = relaxed(knots, c, np.zeros_like(knots.cap), knots.cap, TOLERANCE)
    multipliers, highest = densities(knots, settled(knots, found.dual), len(limits)), float(knots.cap.max())
    coarse, fine = (dual_integral(run, limits, law, step, *multipliers, highest, points) for points in POINTS)
    value = min(coarse, fine) - abs(fine - coarse)
    return max(value, 0.0) if np.isfinite(value) else 0.0


def densities(knots: Knots, dual: Floats, joints: int) -> tuple[Floats, Floats]:
    """(n, joints) multipliers of jerk and of acceleration by length of path, as coefficients of splines over time.

    Next to rest, stationarity makes the multipliers of jerk linear in time.
    """
    half = knots.rows.shape[1] // 2
    signed = knots.by_knot(dual[:, :, 0] - dual[:, :, 1]) / knots.weight[:, None]
    acceleration, jerk = signed[:, :joints].copy(), signed[:, half : half + joints].copy()
    k = np.arange(FROM_REST)[:, None] - FROM_REST
    for of in (jerk, jerk[::-1]):
        of[:FROM_REST] = of[FROM_REST] + k * (of[FROM_REST + 1] - of[FROM_REST])
    acceleration[:FROM_REST] = acceleration[-FROM_REST:] = 0.0
    # what is left of the price of a pace must not fall below zero
    jerk /= np.maximum(np.abs(jerk).sum(axis=1), 1.0)[:, None]
    return jerk, acceleration


def spline(coefficients: Floats, step: float, place: Floats) -> Callable[[int], Floats]:
    """The quadratic spline over even knots whose k-th coefficient belongs to the time (k + 1) step; f(order).

    f gives (cells * points, joints): a derivative in time at the places (points,) in [0, 1] of each cell between two
    knots, the first and the last of which are half as long. Over even knots all cells have the same basis functions.
    """
    first, last = coefficients[0] - coefficients[1], coefficients[-1] - coefficients[-2]
    before = [coefficients[0] + 2.0 * first, coefficients[0] + first]
    after = [coefficients[-1] + last, coefficients[-1] + 2.0 * last]
    extended = np.concatenate([before, coefficients, after])
    near = np.stack([extended[:-2], extended[1:-1], extended[2:]], axis=1)
    u = np.tile(place, (len(near), 1))
    u[0], u[-1] = 0.5 + 0.5 * place, 0.5 * place
    one = np.ones_like(u)
    basis = (
        (0.5 * (1.0 - u) ** 2, 0.5 + u * (1.0 - u), 0.5 * u**2), (u - 1.0, 1.0 - 2.0 * u, u), (one, -2.0 * one, one),
    )  # fmt: skip

    def derivative(order: int) -> Floats:
        value: Floats = np.stack(basis[order], axis=2) @ near / step**order
        return value.reshape(-1, extended.shape[1])

    return derivative


def dual_integral(
    run: AxisRun,
    limits: Limits,
    law: SplineLaw,
    step: float,
    jerk: Floats,
    acceleration: Floats,
    highest: float,
    points: int,
) -> float:
    """The bound by multipliers (n, joints) as coefficients; `highest` is a cap on z where nothing else is one."""
    count = len(jerk) + 1
    edges = np.concatenate([[0.0], step * (np.arange(count) + 0.5), [law.duration]])
    length = np.diff(edges)
    place, rule, integral = gauss(points)
    t = (edges[:-1, None] + length[:, None] * place).ravel()
    s, v, a, _ = law.at(t)
    s = np.clip(s, run.s0, run.s1)
    q = np.ascontiguousarray(run.evaluate(s))
    q1, q2 = q[1], q[2]
    nu, nu_t, nu_tt = map(spline(jerk, step, place), range(3))
    ahead, ahead_t, ahead_tt = map(spline(acceleration, step, place), range(3))
    # the rows of the mesh are stated half a cell ahead; so are the multipliers
    lam, lam_t = ahead - 0.5 * step * ahead_t, ahead_t - 0.5 * step * ahead_tt
    speed, change = v[:, None], a[:, None]
    nu_s, nu_ss = nu_t / speed, nu_tt / speed**2 - nu_t * change / speed**3
    of_jerk = (q1 * nu_ss - q2 * nu_s) / limits.jerk
    of_acceleration = (q2 * lam - q1 * lam_t / speed) / limits.acceleration
    theta = 0.5 * (of_jerk + of_acceleration).sum(axis=1)
    kappa = np.maximum(1.0 - np.abs(nu).sum(axis=1), 0.0)
    cap, _, _ = first_guess.pointwise(q, limits.velocity, limits.acceleration, limits.jerk, run.speed_cap(s))
    shape = (len(length), points)
    cap = widest_at_breaks(run, law, edges, np.minimum(cap, highest).reshape(shape))
    ideal = 0.5 * np.maximum(kappa, LEAST_KAPPA) / v**3
    measure = v.reshape(shape) * rule * length[:, None]
    wide = (*shape, len(limits))
    cells = continuous_dual.Cells(
        theta.reshape(shape), kappa.reshape(shape), ideal.reshape(shape), cap,
        np.abs(lam).sum(axis=1).reshape(shape), measure, v.reshape(shape), q1.reshape(wide), lam.reshape(wide), length,
    )  # fmt: skip
    return continuous_dual.best_value(COUNTS, cells, limits.acceleration, continuous_dual.Rule(rule, integral))


def widest_at_breaks(run: AxisRun, law: SplineLaw, edges: Floats, cap: Floats) -> Floats:
    """Caps (cells, points), in a cell with a break of the run the largest of the cell and its neighbours."""
    times = np.interp(run.breaks, law.nodes, law.times)
    for k in np.unique(np.clip(np.searchsorted(edges, times) - 1, 0, len(cap) - 1)):
        near = slice(max(int(k) - 1, 0), int(k) + 2)
        cap[near] = cap[near].max()
    return cap


def gauss(points: int) -> tuple[Floats, Floats, Floats]:
    """Gauss' rule on [0, 1]: places, weights, and (points, points) weights of the integrals up to each place."""
    from numpy.polynomial import legendre

    x, weight = legendre.leggauss(points)
    fit = np.linalg.inv(legendre.legvander(x, points - 1))
    up_to: Floats = np.stack(
        [legendre.legval(x, legendre.legint(column, lbnd=-1.0)) for column in np.eye(points)], axis=1
    )
    return (x + 1.0) / 2.0, weight / 2.0, 0.5 * up_to @ fit


def is_cheap(trajectory: Trajectory) -> bool:
    """Whether the bound takes little beside reading, fitting and judging a program."""
    laws = trajectory.laws
    return all(isinstance(law, SplineLaw) for law in laws) and cells(trajectory) <= CHEAP


def cells(trajectory: Trajectory) -> int:
    """Cells of the meshes on which the bound is worked out."""
    return sum(max(FEWEST, len(law.nodes)) for law in trajectory.laws if isinstance(law, SplineLaw))


def with_continuous_bound(trajectory: Trajectory, workers: Workers | None = None) -> Trajectory:
    """The same plan with its bound of the continuous problem; 0 where one of its runs has none."""
    axis_path, limits = trajectory.axis_path, trajectory.limits
    pairs = [(run, law) for run, law in zip(axis_path.runs, trajectory.laws) if isinstance(law, SplineLaw)]
    found = (workers or Workers()).each(lambda k: continuous_bound(pairs[k][0], limits, pairs[k][1]), range(len(pairs)))
    complete = len(pairs) == len(trajectory.laws) and all(seconds > 0.0 for seconds in found)
    dwells = axis_path.first_dwell + sum(run.dwell for run in axis_path.runs)
    return replace(trajectory, continuous_bound=sum(found) + dwells if complete else 0.0)
