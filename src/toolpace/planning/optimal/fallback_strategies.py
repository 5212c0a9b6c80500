"""Fallback strategies for a plan far above its lower bound.

gap of a run above one percent:
  where most of it lies at places at which the relaxation stands still, the bound is loose there:
      ranges of speed, proved knot by knot                                                  (planning/bound/prove.py)
  where most of it lies elsewhere, the mesh is coarse there, for the motion or for the bound, which knows nodes only:
      its cells cut, planned and bounded again
  the other of both, if that did not do;  and on a finer mesh the proof once more
  at last a mesh of fewer nodes that stays as it is: cutting cells may lead astray, where all joints stand or the path
      is rough; where the guard took much longer than the limits at the nodes do, that comes first
the better plan stays, and a note says what it was
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from toolpace.common.arrays import Bools, Floats
from toolpace.common.errors import InfeasibleError
from toolpace.common.workers import Workers
from toolpace.machine.limits import Limits
from toolpace.motion.laws import SplineLaw
from toolpace.path.axis_run import AxisRun
from toolpace.planning.bound.branch_and_bound import Allowance
from toolpace.planning.bound.gap_localisation import GapInterval, gap_interval_of
from toolpace.planning.bound.prove import prove_run
from toolpace.planning.bound.relaxation import Bound, bound_run, highest_speed
from toolpace.planning.mesh.initial_guess import ramp_time
from toolpace.planning.mesh.nodes import cut_cells
from toolpace.planning.optimal.inter_sample_limits import held_between_nodes
from toolpace.planning.optimal.meshed_run import KEPT, MeshedRun, on_finer_mesh, too_short
from toolpace.planning.optimal.solve import Stalled, pinned, slower
from toolpace.planning.optimal.windows import solve_run
from toolpace.planning.planned_run import EndState

FAR = 0.01
"""Gap above which a plan is worth another try."""
KNOTS_A_NODE = 120
"""How many knots the relaxations of a proof may have together, for each node of the plan: a few times its own work.

One round over bends next to each other, a whole program long, takes 80 to 100, a finer mesh several times as long.
"""
KNOTS_OVER_SPEED = 600
"""The same where limits depend on the speed: the planes for them are loose over long stretches."""
PARTS = 4
"""Into how many the cells are cut about which the gap lies."""
START_LOSS, START_SPREAD = 0.1, 0.1
"""How the search on the finer mesh starts: the plan, so much slower, and its first gap relative to the duration."""
ROUNDS = 8
"""Of the guard on the finer mesh: where as many leave a limit passed, it is no better than the mesh before."""
FEWEST = 8
"""Cells of a mesh."""
AS_FAST = 1e-4
"""How much slower a plan on a finer mesh may be and still be taken, if its bound is nearer."""
CLOSED = 0.9
"""Share of the gap that a proof leaves at most where the bound is called loose."""
WORTH_SAYING = 1e-3
"""Least share of the duration by which a mesh is called coarse."""
UNCUT = 1000
"""Cells at most where none is cut: so many do where all joints stand, and more may be led astray as well."""


class Plan(NamedTuple):
    """A law of a run, and its bound."""

    law: SplineLaw
    bound: Bound


def fallback_plan(
    run: AxisRun,
    limits: Limits,
    first: Plan,
    start: EndState,
    end: EndState,
    fixed: bool,
    guard: bool,
    workers: Workers,
    with_cells: Callable[[int], SplineLaw],
    at_nodes: float,
) -> tuple[Plan, tuple[str, ...]]:
    """The plan, or a better one, with its bound, and notes on why they were far apart; without any where they were not.

    A mesh that is `fixed` stays as it is, and only where the gap lies is said. `with_cells` plans the run on a mesh of
    so many cells that stays as it is; it may raise InfeasibleError. `at_nodes` is the duration of the first plan before
    its limits were held between the nodes [s].
    """
    gap = first.bound.gap
    if gap <= FAR:
        return first, ()
    if len(first.law.nodes) > KEPT:
        return first, (f"run at {run.place(run.s0)}: gap of {100.0 * gap:.1f} %; too long for another try",)
    opening = gap_interval_of(run, limits, first.law, start, end)
    where = f"{run.place(opening.low)} and {run.place(opening.high)}"
    notes = [f"run at {run.place(run.s0)}: gap of {100.0 * gap:.1f} %, mostly between {where}"]
    if fixed:
        return first, (f"{notes[0]}; the mesh is kept as it was given",)
    best, proved = first, None
    ways: tuple[str, ...] = ("proof", "mesh", "proof") if opening.stands > 0.5 else ("mesh", "proof")
    if limits.depend_on_speed:
        # a proof below planes is long: not twice
        ways = "proof", "mesh"
    astray = first.law.duration > (1.0 + FAR) * at_nodes
    for way in ("fewer cells", *ways) if astray else (*ways, "fewer cells"):
        if way == "mesh":
            if best.law is not first.law:
                opening = gap_interval_of(run, limits, best.law, start, end)
            best, words = on_a_finer_mesh(run, limits, best, opening, start, end, guard, workers)
        elif way == "fewer cells":
            best, words = on_fewer_cells(run, limits, best, start, end, with_cells)
        elif proved is not best.law:
            proved = best.law
            best, words = with_proof(run, limits, best, start, end, workers)
        else:
            continue
        notes += [words] if words else []
        if best.bound.gap <= FAR:
            break
    if best.bound.gap > FAR:
        left = f"{100.0 * best.bound.gap:.2f} %"
        notes.append(f"the remaining gap of {left} is that of a loose lower bound, as far as was tried")
    return best, ("; ".join(notes),)


def on_fewer_cells(
    run: AxisRun, limits: Limits, plan: Plan, start: EndState, end: EndState, with_cells: Callable[[int], SplineLaw]
) -> tuple[Plan, str]:
    """The plan, or that on half as many nodes, `UNCUT` at most, or twice that, if it is faster, and what that says; ""
    if not."""
    cells = min(max(len(plan.law.nodes) // 2, FEWEST), UNCUT)
    laws = {}
    for count in (cells, 2 * cells):
        with contextlib.suppress(InfeasibleError):
            laws[count] = with_cells(count)
    if not laws:
        return plan, ""
    cells = min(laws, key=lambda count: laws[count].duration)
    law = laws[cells]
    gain = 1.0 - law.duration / plan.law.duration
    if gain <= WORTH_SAYING:
        return plan, ""
    note = f"with {cells} cells the motion is {100.0 * gain:.2f} % faster"
    return Plan(law, bound_run(run, limits, law, start, end)), note


def with_proof(
    run: AxisRun, limits: Limits, plan: Plan, start: EndState, end: EndState, workers: Workers
) -> tuple[Plan, str]:
    """The plan with its bound proved as far as is worth it, and what that says of the bound."""
    knots = KNOTS_OVER_SPEED if limits.depend_on_speed else KNOTS_A_NODE
    allowance = Allowance(knots=knots * len(plan.law.nodes))
    bound = prove_run(run, limits, plan.law, FAR, allowance, start, end, workers)
    proved = Plan(plan.law, bound if bound.gap < plan.bound.gap else plan.bound)
    if bound.gap < CLOSED * plan.bound.gap:
        return proved, f"the lower bound was loose: branch and bound leaves {100.0 * bound.gap:.2f} %"
    if allowance.is_spent:
        return proved, "branch and bound takes too long to be tried, or finished"
    return proved, "branch and bound closes next to nothing of it"


def on_a_finer_mesh(
    run: AxisRun,
    limits: Limits,
    plan: Plan,
    opening: GapInterval,
    start: EndState,
    end: EndState,
    guard: bool,
    workers: Workers,
) -> tuple[Plan, str]:
    """The plan, or that on a mesh with the open cells cut, whichever is better, and what that says of the mesh."""
    law = refined(run, limits, plan.law, opening.cells, start, end, guard, workers)
    if law is None:
        return plan, "no motion was found on a finer mesh"
    gain = 1.0 - law.duration / plan.law.duration
    bound = bound_run(run, limits, law, start, end)
    if gain > WORTH_SAYING:
        note = f"the mesh was too coarse there: {PARTS} times finer, the motion is {100.0 * gain:.2f} % faster"
        return Plan(law, bound), note
    if gain < -AS_FAST or bound.gap >= plan.bound.gap:
        return plan, f"with a mesh {PARTS} times finer there the motion is no faster"
    left = f"{100.0 * bound.gap:.2f} %"
    return Plan(law, bound), f"the lower bound had too few nodes there: {PARTS} times finer, it leaves {left}"


def refined(
    run: AxisRun,
    limits: Limits,
    law: SplineLaw,
    cells: Bools,
    start: EndState,
    end: EndState,
    guard: bool,
    workers: Workers,
) -> SplineLaw | None:
    """The fastest law on the mesh of another one with the marked cells (cells,) cut; None where no way was found."""
    nodes = cut_cells(law.nodes, np.where(cells & ~too_short(law.nodes), PARTS, 1))
    ramp = min(ramp_time(limits), law.duration)
    meshed = MeshedRun(
        run, limits, with_rests(law, nodes), (start, end), highest_speed(run, limits, law, nodes),
        (law.nodes, law.times), ramp,
    )  # fmt: skip
    c, least = on_finer_mesh(law, nodes)
    begin = slower(meshed, pinned(meshed, np.maximum(c, least)), START_LOSS)
    try:
        found = SplineLaw(meshed.nodes, solve_run(meshed, begin, START_SPREAD, workers), meshed.rest)
        return held_between_nodes(meshed, found, False, workers, most_rounds=ROUNDS) if guard else found
    except Stalled:
        return None


def with_rests(law: SplineLaw, nodes: Floats) -> Floats:
    """The nodes with the ends of the run that are at rest."""
    before, after = [law.s0] if law.rest[0] > 0.0 else [], [law.s1] if law.rest[1] > 0.0 else []
    return np.concatenate([before, nodes, after])
