"""The second-order planner: minimum time within velocity, feed and acceleration limits, without jerk.

Source: Pham and Pham 2018 (TOPP-RA); see `kernels/planners/reachability.py`. Acceleration jumps where the motion
switches from one limit to another, and at rest: real axes cannot follow that exactly. It tells how much of a cycle time
jerk limits cost.
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
from toolpace.planning.endstate import AT_REST, EndState, check_state
from toolpace.planning.limit_tolerances import ALLOWED, GUARANTEE
from toolpace.planning.mesh.nodes import cut_cells, with_breaks
from toolpace.planning.mesh.path_detail import detail
from toolpace.planning.options import Options, check_flag, check_mesh
from toolpace.planning.peaks import CHUNK, peaks_of
from toolpace.planning.planned_run import PlannedRun
from toolpace.planning.second_order.problem import BOTH_ENDS, FIVE, Cells
from toolpace.planning.second_order.refusal import refusal

PILOT = 400
"""Even cells of the first solve, which tells where the time goes."""
DEFAULT_CELLS = 4000
CELLS_A_HINT = 4
"""Fewest cells of a run, and between two hints, such as the knots of a fitted path."""
REFINE_ABOVE = 1.0003
"""Usage from which a cell is halved rather than its limits lowered."""
REFINE_ROUNDS, MOST_ROUNDS = 6, 20
OVERSHOOT = 1.2
"""How far a limit is lowered, as a multiple of how far it was passed."""


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
