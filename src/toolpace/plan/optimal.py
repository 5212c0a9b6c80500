"""The optimal planner: the fastest motion along a path within velocity, acceleration, jerk and feed."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from toolpace.axispath import AxisPath, AxisRun
from toolpace.errors import InfeasibleError
from toolpace.kernels import cubic, envelope, speed, usage
from toolpace.kernels.speedlaw import INSIDE, REST_INSIDE
from toolpace.limits import KINDS, Limits
from toolpace.plan.mesh import first_mesh, split
from toolpace.timelaw import SplineLaw
from toolpace.trajectory import Trajectory, limit_ratios

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

TOLERANCE = 1e-6
"""Gap and gradient at which a solve ends, relative to the duration."""
MOST_STEPS = 250
START_SHARE = 0.4
"""Share of the guess at which a solve starts."""
START_LOSS = 0.03
"""Share of z by which a solve that starts from a solution is slowed down first."""
WARM_SPREAD = 0.03
"""First gap of such a solve, relative to the duration."""
ALLOWED = 1.0 + 5e-5
"""Usage between nodes that is left alone; the guarantee is 1 + 1e-4."""
REFINE_ROUNDS = 2
REFINE_ABOVE = 1.003
"""Usage between nodes from which a cell is halved rather than its limits lowered, in the first rounds."""
QUARTER_ABOVE = 1.05
MOST_ROUNDS = 16
OVERSHOOT = 0.15
"""How much more than it was passed a limit is lowered, times the rounds so far."""
CHUNK = 20_000
"""Cells whose usage is worked out at a time, to keep memory low."""


@dataclass(frozen=True)
class EndState:
    """State of s at an end of a run: ds/dt and d2s/dt2; both zero at rest."""

    speed: float = 0.0
    acceleration: float = 0.0

    @property
    def at_rest(self) -> bool:
        """Whether the run starts or ends without motion."""
        return self.speed == 0.0


AT_REST = EndState()


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
    law = solve(problem, run, rough.s, rough.z, START_SHARE, spread=1.0)
    for round_ in range(MOST_ROUNDS if guard else 0):
        peak, rest = peaks(run, limits, law)
        worst = max(float(peak.max()), rest)
        parts = np.where(law.dips(), 4, 1)
        if worst <= ALLOWED and parts.max() == 1:
            break
        if cells is None and round_ < REFINE_ROUNDS:
            of_cell = peak.max(axis=1)
            parts = np.maximum(parts, np.where(of_cell > QUARTER_ABOVE, 4, np.where(of_cell > REFINE_ABOVE, 2, 1)))
        if parts.max() > 1:
            nodes = split(nodes, with_rest_cells(parts, problem.rest))
            problem = discretise(run, limits, nodes, start, end)
        else:
            problem.tighten(peak, 1.0 + OVERSHOOT * (1 + round_))
        probe = law.probe()
        share = (1.0 - START_LOSS) / min(worst, 1.5)
        law = solve(problem, run, probe.state[0], probe.state[1] ** 2, share, spread=WARM_SPREAD)
    return law, len(nodes)


def check_state(run: AxisRun, limits: Limits, state: EndState, s: float) -> None:
    """Raise InfeasibleError where the state itself breaks a limit, whatever comes next."""
    if state.at_rest:
        return
    if not (np.isfinite(state.speed) and np.isfinite(state.acceleration) and state.speed > 0.0):
        raise InfeasibleError(
            f"end state: ds/dt = {state.speed:g} and d2s/dt2 = {state.acceleration:g}; ds/dt must be positive"
        )
    side = np.array([1.0 if s == run.s0 else 0.0])
    moment = np.array([[s], [state.speed], [state.acceleration], [0.0]])
    m = len(limits)
    ratios = limit_ratios(run, limits, moment, side)[0, : 1 + 2 * m]
    if ratios.max() > 1.0 + 1e-4:
        names = ["the feed cap"] + [f"the {kind} limit of {joint}" for kind in KINDS[:2] for joint in limits.joints]
        raise InfeasibleError(
            f"end state at s = {s:.6g}: takes {ratios.max():.4g} of {names[int(ratios.argmax())]}; start or end slower"
        )


class Problem:
    """A run on a mesh, as the core takes it: rows at the nodes, on both sides where the run has a break.

    The core's spline has no node at an end at rest: ds/dt has a constant third derivative in that outermost cell,
    which gives z' = 4 z / (3 h) at its inner end and so ties two coefficients.
    """

    def __init__(self, nodes: Floats, rest: tuple[float, float], node: Ints, ends: tuple[EndState, EndState]) -> None:
        self.nodes, self.rest, self.node = nodes, rest, node
        self.basis = cubic.basis_at_knots(nodes)[node]
        self.end = np.array([speed.REST if state.at_rest else speed.MOVING for state in ends])
        first, last = (nodes[1] - nodes[0]) / 3.0, (nodes[-1] - nodes[-2]) / 3.0
        self.ratio = np.array(
            [
                1.0 + 4.0 * first / (3.0 * rest[0]) if rest[0] else 1.0,
                1.0 + 4.0 * last / (3.0 * rest[1]) if rest[1] else 1.0,
            ]
        )
        z0, z1 = ends[0].speed ** 2, ends[1].speed ** 2
        self.fixed = np.array([z0, z0 + 2.0 * ends[0].acceleration * first, z1 - 2.0 * ends[1].acceleration * last, z1])
        cell = np.diff(nodes)
        weight = (np.concatenate([[0.0], cell]) + np.concatenate([cell, [0.0]])) / 2.0
        weight[0] += 3.0 * rest[0]
        weight[-1] += 3.0 * rest[1]
        self.weight = (weight / np.bincount(node))[node]
        self.cap = np.empty(0)
        self.rows = np.empty((0, 0, 3))

    def tighten(self, peak: Floats, overshoot: float) -> None:
        """Lower the limits at both ends of the cells whose peaks (cells, 3) by kind pass what is allowed.

        They are lowered `overshoot` times as far as they were passed, since the solution moves on.
        """
        excess = np.ones((len(self.nodes), 3))
        over = np.where(peak > ALLOWED, 1.0 + overshoot * (peak - 1.0), 1.0)
        excess[:-1] = over
        excess[1:] = np.maximum(excess[1:], over)
        half = self.rows.shape[1] // 2
        at_point = excess[self.node]
        self.cap /= at_point[:, 0] ** 2
        self.rows[:, :half] *= at_point[:, 1, None, None]
        self.rows[:, half:] *= at_point[:, 2, None, None]


def discretise(run: AxisRun, limits: Limits, nodes: Floats, start: EndState, end: EndState) -> Problem:
    """The rows of a run at the nodes (n,) from s0 to s1."""
    inner = nodes[1 if start.at_rest else 0 : -1 if end.at_rest else len(nodes)]
    rest = (float(inner[0] - nodes[0]), float(nodes[-1] - inner[-1]))
    both = np.isin(inner, run.breaks)
    node = np.repeat(np.arange(len(inner)), 1 + both)
    point = inner[node]
    left = np.concatenate([node[1:] == node[:-1], [False]])
    point[left] = np.nextafter(point[left], -np.inf)
    point[-1] = min(point[-1], run.s1)
    q = run.evaluate(point)
    problem = Problem(inner, rest, node, (start, end))
    cap, steady, _ = envelope.pointwise(q, limits.velocity, limits.acceleration, limits.jerk, run.speed_cap(point))
    problem.rows = np.concatenate(
        [
            np.stack([q[2], q[1] / 2.0, np.zeros_like(q[1])], axis=-1) / limits.acceleration[:, None],
            np.stack([q[3], 1.5 * q[2], q[1] / 2.0], axis=-1) / limits.jerk[:, None],
        ],
        axis=1,
    )
    half = len(limits)
    for k, (state, place) in enumerate(((start, 0), (end, -1))):
        if state.at_rest:
            cap[place] = min(cap[place], rest_cap(run, limits, inner[place], rest[k], forth=k == 0))
        else:
            # what the state fixes has been checked and is no row
            cap[place] = np.inf
            problem.rows[place, :half] = 0.0
    finite = np.isfinite(steady)
    highest = steady[finite].max() if finite.any() else ((run.s1 - run.s0) / 1e-6) ** 2
    problem.cap = np.minimum(cap, 1e3 * max(highest, start.speed**2, end.speed**2))
    return problem


def rest_cap(run: AxisRun, limits: Limits, node: float, length: float, forth: bool) -> float:
    """Most z at the inner end of a rest cell, such that nothing inside the cell breaks a limit.

    All states of the cell scale with that z: speeds with its root, accelerations with it, jerks with its power 3/2.
    """
    share = np.linspace(0.0, 1.0, 13)
    third = 2.0 / (9.0 * length**2)
    t = 3.0 * length * share
    sign = 1.0 if forth else -1.0
    rest = node - sign * length
    state = np.stack([rest + sign * third * t**3 / 6.0, third * t**2 / 2.0, sign * third * t, np.full(len(t), third)])
    side = np.where((share == 1.0) == forth, 0.0, 1.0)
    ratios = limit_ratios(run, limits, state, side)
    m = len(limits)
    return float(
        min(
            ratios[:, : 1 + m].max() ** -2.0,
            1.0 / ratios[:, 1 + m : 1 + 2 * m].max(),
            ratios[:, 1 + 2 * m :].max() ** (-2.0 / 3.0),
        )
    )


def solve(problem: Problem, run: AxisRun, s: Floats, z: Floats, share: float, spread: float) -> SplineLaw:
    """The law that solves the problem, started from `share` of the speeds z (k,) at s (k,)."""
    c = share * np.interp(cubic.control_points(problem.nodes), s, z**0.75) ** (4.0 / 3.0)
    for k, (one, two) in enumerate(((0, 1), (-1, -2))):
        if problem.end[k] == speed.REST:
            c[two] = c[one] * problem.ratio[k]
        else:
            c[one], c[two] = problem.fixed[0 if k == 0 else 3], problem.fixed[1 if k == 0 else 2]
    relief = reliefs(problem, c)
    c, status, steps, gap, tau = speed.maximise_speed(
        problem.basis, problem.node, problem.weight, problem.cap, problem.rows, c, relief,
        problem.end, problem.ratio, spread, TOLERANCE, MOST_STEPS,
    )  # fmt: skip
    if not (status == speed.OPTIMAL or (tau < 1e-9 and gap < 1e-2)):
        where = problem.nodes[problem.node[int(np.argmax(reliefs(problem, c).max(axis=1)))]]
        block = int(run.block_at(np.array([where]))[0])
        raise InfeasibleError(
            f"no motion within the limits found: stuck near s = {where:.9g}"
            + (f" (block {block})" if block else "")
            + f" after {steps} steps; if the run starts or ends in motion, let it do so more slowly"
        )
    return SplineLaw(problem.nodes, c, problem.rest)


def reliefs(problem: Problem, c: Floats) -> Floats:
    """(points, 3) by how much cap, acceleration and jerk rows must be relaxed for c to lie well inside."""
    u = np.einsum("pij,pj->pi", problem.basis, c[problem.node[:, None] + np.arange(3)])
    half = problem.rows.shape[1] // 2
    value = np.abs(np.einsum("pri,pi->pr", problem.rows, u))
    pace = 1.0 / np.sqrt(u[:, 0])
    natural = np.stack([problem.cap, np.ones_like(pace), pace], axis=1)
    worst = np.stack([u[:, 0], value[:, :half].max(axis=1), value[:, half:].max(axis=1)], axis=1) / natural
    relief: Floats = np.where(worst < 1.0, 0.0, 1.5 * (worst - 1.0) + 0.1) * natural
    return relief


def peaks(run: AxisRun, limits: Limits, law: SplineLaw) -> tuple[Floats, float]:
    """Largest usage in each cell of the spline (cells, 3), by speed, acceleration and jerk; and in the rest cells."""
    m, k = len(limits), len(INSIDE)
    kinds = np.split(np.arange(1 + 3 * m), [1 + m, 1 + 2 * m])
    probe = law.probe()
    first = len(REST_INSIDE) if law.rest[0] > 0.0 else 0
    cells = len(law.nodes) - 1
    out = np.empty((cells, 3))
    for low in range(0, cells, CHUNK):
        high = min(low + CHUNK, cells)
        part = slice(first + low * k, first + high * k)
        ratio = limit_ratios(run, limits, probe.state[:, part], probe.right[part])
        of_cell = usage.peaks(INSIDE, ratio)
        out[low:high] = np.stack([of_cell[:, kind].max(axis=1) for kind in kinds], axis=1)
    rest = np.ones(len(probe.share), dtype=bool)
    rest[first : first + cells * k] = False
    outside = limit_ratios(run, limits, probe.state[:, rest], probe.right[rest]).max() if rest.any() else 0.0
    return out, float(outside)


def with_rest_cells(parts: Ints, rest: tuple[float, float]) -> Ints:
    """Parts of the spline's cells, with those of the rest cells at the ends, which stay whole."""
    whole = np.ones(1, dtype=np.int64)
    return np.concatenate([whole[: rest[0] > 0.0], parts, whole[: rest[1] > 0.0]])


def plan_optimal(
    axis_path: AxisPath,
    limits: Limits,
    *,
    cells: int | None = None,
    start: EndState = AT_REST,
    end: EndState = AT_REST,
    guard: bool = True,
    progress: Callable[[float], None] | None = None,
) -> Trajectory:
    """The fastest trajectory along all runs; `start` is the state at the start of the first, `end` of the last."""
    began = time.perf_counter()
    runs = axis_path.runs
    last = len(runs) - 1
    whole = runs[-1].s1 - runs[0].s0

    def one(k: int) -> tuple[SplineLaw, int]:
        states = start if k == 0 else AT_REST, end if k == last else AT_REST
        return plan_run(runs[k], limits, cells=cells, start=states[0], end=states[1], guard=guard)

    laws, points, done = [], 0, 0.0
    with ThreadPoolExecutor(max_workers=os.cpu_count() or 1) as pool:
        for run, (law, count) in zip(runs, pool.map(one, range(len(runs)))):
            laws.append(law)
            points += count
            done += (run.s1 - run.s0) / whole
            if progress is not None:
                progress(min(done, 1.0))
    return Trajectory(axis_path, limits, tuple(laws), mesh_points=points, solve_seconds=time.perf_counter() - began)
