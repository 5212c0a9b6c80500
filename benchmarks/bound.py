"""How far plans may be from the best possible, and what it costs to know: gap and CPU time over meshes.

python -m benchmarks.bound        writes benchmarks/results/bound.md
"""

from __future__ import annotations

import itertools
import time

import numpy as np
from rich.progress import track

from benchmarks.machine import RESULTS, written_by
from benchmarks.tables import Table
from testbed.cases import Case, all_cases
from toolpace.common.errors import ToolpaceError
from toolpace.planning.bound.branch_and_bound import Allowance
from toolpace.planning.bound.continuous import continuous_bound
from toolpace.planning.bound.prove import prove_run
from toolpace.planning.bound.relaxation import Bound, bound_run
from toolpace.planning.optimal.planner import fastest_law

MESHES = (200, 1000, 5000, None)
"""Cells; None is the mesh that the planner chooses."""
GAP = 1e-4
WITHIN = 60.0
"""What is to be proved, and in what time [s]."""
WORTH_IT = 3e-4
"""Gap from which a proof is asked for."""


def measure(case: Case, cells: int | None, guard: bool) -> tuple[Bound, int, float, float]:
    """The bound of a plan, its mesh points, and the CPU time of plan and bound in one thread [s]."""
    began = time.thread_time()
    law, points = fastest_law(case.run, case.limits, cells=cells, guard=guard)
    planned = time.thread_time()
    found = bound_run(case.run, case.limits, law)
    return found, points, planned - began, time.thread_time() - planned


def gaps(cases: list[Case]) -> list[Table]:
    """The gaps as they come with plans."""
    table = Table(
        "Lower bound of guarded plans, default mesh",
        ["case", "n", "duration [s]", "lower bound [s]", "gap [%]", "steps", "bound / plan, CPU time", "places"],
    )
    summary = Table(
        "Over all cases; without the guard between nodes the gap is that of the optimum alone",
        ["guard", "n", "gap, median [%]", "gap, worst [%]", "up to 0.1 %", "bound / plan, CPU time, median", "worst"],
    )
    for guard, cells in itertools.product((False, True), MESHES):
        found_gaps, costs = [], []
        for case in track(cases, f"gap, {cells or 'default'}", transient=True):
            try:
                found, points, plan_time, bound_time = measure(case, cells, guard)
            except ToolpaceError as error:
                print(case.name, cells, error)
                continue
            found_gaps.append(100.0 * found.gap)
            costs.append(bound_time / plan_time)
            if guard and cells is None:
                where = ", ".join(f"{low:.3f}" for low, _, _ in found.places[:4])
                table.lines.append([
                    case.name, str(points), f"{found.duration:.6f}", f"{found.seconds:.6f}", f"{found_gaps[-1]:.4f}",
                    str(found.steps), f"{costs[-1]:.2f}", where,
                ])  # fmt: skip
        summary.lines.append([
            "yes" if guard else "no", str(cells or "default"), f"{np.median(found_gaps):.4f}", f"{max(found_gaps):.4f}",
            f"{sum(gap <= 0.1 for gap in found_gaps)} of {len(found_gaps)}", f"{np.median(costs):.2f}",
            f"{max(costs):.2f}",
        ])  # fmt: skip
    return [summary, table]


def proofs(cases: list[Case]) -> Table:
    """What `--prove` makes of the gaps above WORTH_IT."""
    table = Table(
        f"Closing the gap to {100 * GAP:g} % within {WITHIN:g} s, where it was above {100 * WORTH_IT:g} %; all cores",
        ["case", "n", "guard", "gap before [%]", "gap after [%]", "wall time [s]", "CPU time [s]"],
    )
    worst = {}
    for cells, case in itertools.product(MESHES[1:], track(cases, "proofs", transient=True)):
        guard = cells is None
        law, points = fastest_law(case.run, case.limits, cells=cells, guard=guard)
        before = bound_run(case.run, case.limits, law)
        after = before
        if before.gap > WORTH_IT:
            began, spent = time.perf_counter(), time.process_time()
            after = prove_run(case.run, case.limits, law, GAP, Allowance(time.monotonic() + WITHIN))
            table.lines.append([
                case.name, str(points), "yes" if guard else "no", f"{100.0 * before.gap:.4f}",
                f"{100.0 * after.gap:.4f}", f"{time.perf_counter() - began:.1f}", f"{time.process_time() - spent:.1f}",
            ])  # fmt: skip
        worst.setdefault(cells, []).append(after.gap)
    for cells, left in worst.items():
        table.lines.append([
            "all, worst after", str(cells or "default"), "yes" if cells is None else "no", "",
            f"{100.0 * max(left):.4f}", f"{sum(gap <= 1e-3 for gap in left)} of {len(left)} up to 0.1 %", "",
        ])  # fmt: skip
    return table


def unmeshed(cases: list[Case]) -> Table:
    """The bound of the continuous problem, of guarded plans on the default mesh."""
    table = Table(
        "Bound of the continuous problem: no motion that keeps the limits all along the path is faster",
        ["case", "duration of the plan [s]", "bound [s]", "at most to gain [%]", "CPU time [s]"],
    )
    gaps = []
    for case in track(cases, "continuous", transient=True):
        law, _ = fastest_law(case.run, case.limits)
        spent = time.process_time()
        found = continuous_bound(case.run, case.limits, law)
        spent = time.process_time() - spent
        gaps.append(100.0 * (law.duration / found - 1.0))
        table.lines.append([
            case.name, f"{law.duration:.6f}", f"{found:.6f}", f"{gaps[-1]:.4f}", f"{spent:.2f}",
        ])  # fmt: skip
    table.lines.append(["median, worst", "", "", f"{np.median(gaps):.4f}, {max(gaps):.4f}", ""])
    return table


def main() -> None:
    """The tables, on the terminal and in benchmarks/results."""
    cases = all_cases()
    measure(cases[-1], 200, True)
    shown = [*gaps(cases), proofs(cases), unmeshed(cases)]
    for one in shown:
        one.show()
    head = f"# The lower bound\n\n{written_by('python -m benchmarks.bound')}\n\n"
    (RESULTS / "bound.md").write_text(head + "\n".join(one.markdown() for one in shown))


if __name__ == "__main__":
    main()
