"""The second-order planner: minimum time within velocity, feed and acceleration limits, without jerk.

Source: Pham and Pham 2018 (TOPP-RA); see `kernels/planners/reachability.py`. Acceleration jumps where the motion
switches from one limit to another, and at rest: real axes cannot follow that exactly. It tells how much of a cycle time
jerk limits cost. Where no motion joins two end states, the error names limit, joint and place.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.common.errors import InfeasibleError
from toolpace.common.workers import Progress, Workers
from toolpace.kernels.planners import reachability
from toolpace.machine.limits import Limits
from toolpace.motion.laws import LinearLaw
from toolpace.path.axis_run import AxisRun
from toolpace.planning.limit_tolerances import ALLOWED, GUARANTEE
from toolpace.planning.mesh.nodes import cut_cells, with_breaks
from toolpace.planning.mesh.path_detail import detail
from toolpace.planning.options import Options, check_flag, check_mesh
from toolpace.planning.peaks import CHUNK, peaks_of
from toolpace.planning.planned_run import AT_REST, EndState, PlannedRun, check_state

PILOT = 400
"""Even cells of the first solve, which tells where the time goes."""
DEFAULT_CELLS = 4000
CELLS_A_HINT = 4
"""Fewest cells of a run, and between two hints, such as the knots of a fitted path."""
REFINE_ABOVE = 1.0003
"""Usage from which a cell is halved rather than its limits lowered."""
REFINE_ROUNDS, MOST_ROUNDS = 6, 20
"""Solves after which cells are halved no more, and most solves: one on each of the 27 paths of the benchmark."""
OVERSHOOT = 1.2
"""How far a limit is lowered, as a multiple of how far it was passed."""
BOTH_ENDS = np.array([0.0, 1.0])
"""Limits held at both ends of each cell: TOPP-RA's second scheme, and the rows of COPP's second-order planner."""
FIVE = np.linspace(0.0, 1.0, 5)
"""Limits held inside the cells too."""
MOST_OVER_STEADY = 1e12
"""Where nothing limits, z is held below this multiple of what limits allow elsewhere at steady speed."""
COLLAPSED = 1e-3
"""Share of z at the start of a cell below which it must not fall at its end, inside a run."""
MOST_CALMED = 20
"""Most solves in which cells with zero inertia are found: one on each of these paths."""
SHORTEST = 1e-9
"""Time in which nothing crosses a run [s]: what is faster has no limit."""
CURES = {
    reachability.UNREACHABLE: "arriving in motion, no state reaches the end; arrive more slowly",
    reachability.TOO_FAST: "starting in motion, it cannot slow down in time; start more slowly",
    reachability.TOO_SLOW: "the end asks for more speed than can be gathered; arrive more slowly",
}


@dataclass(frozen=True)
class SecondOrder(Options):
    """The fastest motion within velocity, feed and acceleration; jerk is not limited, and no lower bound is proved.

    Of the states in which a path starts and ends only the speeds are held: acceleration may jump, there as anywhere.
    """

    mesh: int | None = None
    """Number of mesh cells of each run, at least 8; None: as many as the motion asks for."""
    guard: bool = True
    """Whether limits hold inside the cells too; without it they hold at both ends of each."""

    def __post_init__(self) -> None:
        check_mesh(self.name, self.mesh)
        check_flag(self.name, "guard", self.guard)

    @property
    def name(self) -> str:
        """Its short name."""
        return "second-order"

    def plan_run(
        self, run: AxisRun, limits: Limits, start: EndState, end: EndState, workers: Workers, progress: Progress
    ) -> PlannedRun:
        """The fastest law of one run. Raises InfeasibleError where no motion within the limits joins both speeds."""
        law = second_order_law(run, limits, cells=self.mesh, start=start, end=end, guard=self.guard)
        return PlannedRun(law, len(law.nodes))


class Cells:
    """The rows of a run: at `place` (p,) of each cell, both sides of a break of the path apart."""

    def __init__(self, run: AxisRun, limits: Limits, nodes: Floats, place: Floats = BOTH_ENDS) -> None:
        self.nodes, self.place = nodes, place
        n = len(nodes) - 1
        broken = np.flatnonzero(np.isin(nodes, run.breaks))
        inner = nodes[:-1, None] + np.diff(nodes)[:, None] * place[1:-1]
        self.s = np.concatenate([nodes, np.nextafter(nodes[broken], -np.inf), inner.ravel()])
        """(points,) where limits are rows: the nodes, the left sides of breaks, the places inside."""
        self.at = np.empty((n, len(place)), dtype=np.int64)
        """(n, p) which of the points each place is."""
        self.at[:, 0], self.at[:, -1] = np.arange(n), np.arange(1, n + 1)
        self.at[broken - 1, -1] = n + 1 + np.arange(len(broken))
        self.at[:, 1:-1] = n + 1 + len(broken) + np.arange(inner.size).reshape(inner.shape)
        self.q1, self.q2 = np.empty((2, len(self.s), len(limits)))
        self.cap = np.empty(len(self.s))
        for first in range(0, len(self.s), CHUNK):
            part = slice(first, first + CHUNK)
            q = run.evaluate(self.s[part])
            self.q1[part], self.q2[part] = q[1] / limits.acceleration, q[2] / limits.acceleration
            with np.errstate(divide="ignore"):
                by_velocity = (limits.velocity / np.abs(q[1])).min(axis=1)
            self.cap[part] = np.minimum(by_velocity, run.speed_cap(self.s[part])) ** 2
        self.steady = np.minimum(self.cap, 1.0 / np.maximum(np.abs(self.q2).max(axis=1), 1e-300))
        """(points,) most z at steady speed."""
        limited = self.steady[self.steady < 1e300]
        self.ceiling = min(((run.s1 - run.s0) / SHORTEST) ** 2, MOST_OVER_STEADY * float(limited.max(initial=np.inf)))
        """z that is enough where no limit holds the motion, since no joint moves that has one."""
        self.tight = np.ones((n, 2))
        """(n, 2) factors by which the speed and acceleration limits of the cells are lowered."""
        self.calm = np.zeros(n, dtype=np.bool_)
        """(n,) cells with zero inertia inside, which are passed no faster than at steady speed."""

    @property
    def unlimited(self) -> bool:
        """Whether nothing at all limits the motion."""
        return not (np.isfinite(self.cap).any() or self.q1.any() or self.q2.any())

    def top(self, z0: float, z1: float) -> Floats:
        """(n + 1,) most z at the nodes; what is given at the ends is allowed there."""
        at_ends = self.cap[self.at[:, [0, -1]]] / self.tight[:, :1] ** 2
        top = np.full(len(self.nodes), self.ceiling)
        top[:-1] = np.minimum(top[:-1], at_ends[:, 0])
        top[1:] = np.minimum(top[1:], at_ends[:, 1])
        calm = np.flatnonzero(self.calm)
        steady = self.steady[self.at[calm]].min(axis=1) / self.tight[calm].max(axis=1) ** 2
        np.minimum.at(top, calm, steady)
        np.minimum.at(top, calm + 1, steady)
        top[[0, -1]] = np.maximum(top[[0, -1]], [z0, z1])
        return top

    def arrays(self, top: Floats) -> reachability.Rows:
        """The rows as the kernel takes them, with caps `top` (n + 1,) of the nodes."""
        return reachability.Rows(np.diff(self.nodes), self.at, self.place, self.tight, self.q1, self.q2, self.cap, top)

    def solve(self, z0: float, z1: float) -> tuple[Floats, int, int]:
        """The highest z (n + 1,) from z0 to z1, how it went, and at which node it failed (see the kernel).

        Where a joint's q' changes sign in a cell (zero inertia), a fast start of the cell may leave no speed at its
        end. Such cells are passed at steady speed then: with x and y below 1 / |q''| its rows hold whatever they are.
        """
        for _ in range(MOST_CALMED):
            top = self.top(z0, z1)
            z, status, node = reachability.solve(self.arrays(top), z0, z1)
            fallen = (z[1:-1] <= COLLAPSED * np.minimum(z[:-2], top[1:-1])) & ~self.calm[:-1]
            if status != reachability.FEASIBLE or not fallen.any():
                break
            self.calm[:-1] |= fallen
        return z, status, node

    def rows(self, k: int) -> Floats:
        """(p, joints, 2) coefficients of z at both ends of the cell k: its acceleration rows, |row . (x, y)| <= 1."""
        f = self.place[:, None]
        q1, q2 = (value[self.at[k]] * self.tight[k, 1] for value in (self.q1, self.q2))
        slope = q1 / (2.0 * (self.nodes[k + 1] - self.nodes[k]))
        return np.stack([q2 * (1.0 - f) - slope, q2 * f + slope], axis=-1)


def mesh_even_in_time(run: AxisRun, limits: Limits, ends: tuple[float, float], cells: int | None) -> Floats:
    """Nodes (n,) from s0 to s1, half even in s, half in the time of a first solve; breaks and detail come on top."""
    knots = run.breaks if cells is not None else np.union1d(run.breaks, run.hints)
    wanted = cells or max(DEFAULT_CELLS, CELLS_A_HINT * len(run.hints))
    pilot = with_breaks(np.linspace(run.s0, run.s1, max(PILOT, len(knots)) + 1), knots)
    closer = detail(run, limits, pilot)
    pilot = np.union1d(pilot, closer)
    rows = Cells(run, limits, pilot)
    z, status, _ = rows.solve(*ends)
    nodes = np.linspace(run.s0, run.s1, wanted + 1)
    if status == reachability.FEASIBLE and (z[1:-1] > 0.0).all():
        law = LinearLaw(pilot, z)
        measure = law.times / law.duration + (pilot - run.s0) / (run.s1 - run.s0)
        nodes[1:-1] = np.interp(np.linspace(0.0, 2.0, wanted + 1)[1:-1], measure, pilot)
    return with_breaks(with_breaks(nodes, closer, 0.0), knots)


def second_order_law(
    run: AxisRun,
    limits: Limits,
    *,
    cells: int | None = None,
    nodes: Floats | None = None,
    start: EndState = AT_REST,
    end: EndState = AT_REST,
    guard: bool = True,
) -> LinearLaw:
    """The fastest law of one run.

    `cells` fixes the number of mesh cells, `nodes` (n,) the mesh itself; without them it is refined where a limit is
    passed between nodes. `guard` holds the limits there too: without it they hold at both ends of each cell. Of
    `start` and `end` only the speeds are taken. Raises InfeasibleError where no motion within the limits joins both.
    """
    check_state(run, limits, start, run.s0, orders=1)
    check_state(run, limits, end, run.s1, orders=1)
    ends = start.speed**2, end.speed**2
    fixed = cells is not None or nodes is not None
    if nodes is None:
        nodes = mesh_even_in_time(run, limits, ends, cells)
    rows = Cells(run, limits, nodes, FIVE if guard else BOTH_ENDS)
    law = solved(run, limits, rows, ends)
    return held_everywhere(run, limits, rows, law, ends, fixed) if guard else law


def solved(run: AxisRun, limits: Limits, rows: Cells, ends: tuple[float, float]) -> LinearLaw:
    """The law of these rows. Raises InfeasibleError with limit and place where there is none."""
    z, status, node = rows.solve(*ends)
    if status != reachability.FEASIBLE:
        raise refusal(run, limits, rows, ends, status, node)
    if rows.unlimited:
        raise InfeasibleError("no limit holds the motion; give a feed, or limits of velocity or acceleration")
    still = z[1:-1] <= 0.0
    if still.any():
        place = run.place(float(rows.nodes[1 + int(still.argmax())]))
        raise InfeasibleError(f"the limits leave no motion at {place}; give a finer mesh, or a higher feed")
    return LinearLaw(rows.nodes, z)


def held_everywhere(
    run: AxisRun, limits: Limits, rows: Cells, law: LinearLaw, ends: tuple[float, float], fixed: bool
) -> LinearLaw:
    """The law with its limits held between all places too.

    Cells that pass a limit are halved (unless the mesh is fixed) or their limits lowered, and all is solved again:
    that costs two passes. What is left in the end, slowing the whole motion down takes away.
    """
    for round_ in range(MOST_ROUNDS):
        peak = peaks_in_cells(run, limits, law)
        worst = peak.max(axis=1)
        if worst.max() <= ALLOWED:
            return law
        cut = worst > (np.inf if fixed or round_ >= REFINE_ROUNDS else REFINE_ABOVE)
        tight = rows.tight * np.where((peak > ALLOWED) & ~cut[:, None], 1.0 + OVERSHOOT * (peak - 1.0), 1.0)
        if cut.any():
            parts = 1 + cut.astype(np.int64)
            rows = Cells(run, limits, cut_cells(rows.nodes, parts), FIVE)
            tight = np.repeat(tight, parts, axis=0)
        rows.tight = tight
        law = solved(run, limits, rows, ends)
    speed, acceleration = peaks_in_cells(run, limits, law).max(axis=0)
    if max(speed, acceleration) <= GUARANTEE:
        return law
    if ends != (0.0, 0.0):
        raise InfeasibleError(
            f"between two nodes a limit is exceeded by {max(speed, acceleration) - 1.0:.2g} of itself; "
            "give more mesh cells, or start and end more slowly"
        )
    return law.slowed(max(speed**2, acceleration))


def peaks_in_cells(run: AxisRun, limits: Limits, law: LinearLaw) -> Floats:
    """(n, 2) largest usage in each cell: of velocity limits and feed, and of acceleration limits."""
    every = np.arange(len(law.acceleration))
    parts = [every[first : first + CHUNK] for first in range(0, len(every), CHUNK)]
    return np.concatenate([peaks_of(run, limits, law, part)[:, :2] for part in parts])


def refusal(
    run: AxisRun, limits: Limits, cells: Cells, ends: tuple[float, float], status: int, node: int
) -> InfeasibleError:
    """The error of a solve that went wrong at a node; `ends` are the given z."""
    top = cells.top(*ends)
    if status == reachability.UNREACHABLE:
        low, high, k = reachability.backward(cells.arrays(top), ends[1])
        before, after = (0.0, float(top[k])), (float(low[k + 1]), float(high[k + 1]))
    else:
        k, x = march(cells, top, ends[0], slow=status == reachability.TOO_FAST)
        before, after = (x, x), (ends[1], ends[1]) if k == len(cells.at) - 1 else (0.0, float(top[k + 1]))
    ratio, joint = least_violation(cells, k, before, after)
    place = float(cells.nodes[k])
    block = int(run.block_at(np.array([place]))[0])
    where = f"s = {place:.9g}" + (f" (block {block})" if block else "")
    takes = f"takes {ratio:.4g} of the acceleration limit of {limits.joints[joint]}" if ratio > 1.0 else "is stuck"
    return InfeasibleError(f"no motion within velocity, feed, acceleration: it {takes} near {where}: {CURES[status]}")


def march(cells: Cells, top: Floats, x: float, slow: bool) -> tuple[int, float]:
    """As slowly (or fast) as the rows allow from z = x at the start: the cell where that ends, and z before it."""
    last = len(cells.at) - 1
    for k in range(last):
        rows = cells.rows(k).reshape(-1, 2)
        a, b = (rows * np.where(rows[:, 1:] < 0.0, -1.0, 1.0)).T
        if (np.abs(a * x)[b == 0.0] > 1.0).any():
            return k, x
        a, b = a[b > 0.0], b[b > 0.0]
        least = float(((-1.0 - a * x) / b).max(initial=0.0))
        most = min(float(top[k + 1]), float(((1.0 - a * x) / b).min(initial=np.inf)))
        if least > most:
            return k, x
        x = least if slow else most
    return last, x


def least_violation(cells: Cells, k: int, before: tuple[float, float], after: tuple[float, float]) -> tuple[float, int]:
    """The least peak acceleration over limit that a cell needs, z at its ends within the ranges; and its joint."""
    from scipy.optimize import linprog

    squared_speeds = [value for low, high in (before, after) for value in (low, high if low == high else 0.0)]
    unit = max(squared_speeds) or min(before[1], after[1])
    rows = cells.rows(k).reshape(-1, 2) * unit
    limit = np.concatenate([np.concatenate([rows, -rows]), np.full((2 * len(rows), 1), -1.0)], axis=1)
    bounds = [(low / unit, high / unit) for low, high in (before, after)]
    found = linprog([0.0, 0.0, 1.0], A_ub=limit, b_ub=np.zeros(len(limit)), bounds=[*bounds, (0.0, None)])
    if found.status != 0 or found.x is None:
        return 0.0, 0
    row = int(np.argmax(np.abs(found.ineqlin.marginals)))
    return float(found.x[2]), row % cells.q1.shape[1]
