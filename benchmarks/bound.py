"""How far plans may be from the best possible, and what it costs to know: gap and CPU time over meshes.

python -m benchmarks.bound        writes benchmarks/results/bound.md
"""

from __future__ import annotations

import itertools
import time

import numpy as np

from benchmarks.__main__ import RESULTS
from benchmarks.paths import Case, all_cases
from benchmarks.tables import Table
from toolpace.errors import ToolpaceError
from toolpace.plan.bound import Bound, bound_run
from toolpace.plan.optimal import plan_run

MESHES = (200, 1000, 5000, None)
"""Cells; None is the mesh that the planner chooses."""


def measure(case: Case, cells: int | None, guard: bool) -> tuple[Bound, int, float, float]:
    """The bound of a plan, its mesh points, and the CPU time of plan and bound in one thread [s]."""
    began = time.thread_time()
    law, points = plan_run(case.run, case.limits, cells=cells, guard=guard)
    planned = time.thread_time()
    found = bound_run(case.run, case.limits, law)
    return found, points, planned - began, time.thread_time() - planned


def main() -> None:
    """The tables, on the terminal and in benchmarks/results."""
    cases = all_cases()
    measure(cases[-1], 200, True)
    heads = ["case", "n", "duration [s]", "lower bound [s]", "gap [%]", "steps", "bound / plan, time", "places"]
    table = Table("Lower bound of guarded plans, default mesh", heads)
    summary = Table(
        "Over all cases; without the guard between nodes the gap is that of the optimum alone",
        ["guard", "n", "gap, median [%]", "gap, worst [%]", "up to 0.1 %", "bound / plan, time, median", "worst"],
    )
    for guard, cells in itertools.product((False, True), MESHES):
        gaps, costs = [], []
        for case in cases:
            try:
                found, points, plan_time, bound_time = measure(case, cells, guard)
            except ToolpaceError as error:
                print(case.name, cells, error)
                continue
            gaps.append(100.0 * found.gap)
            costs.append(bound_time / plan_time)
            if guard and cells is None:
                where = ", ".join(f"{low:.3f}" for low, _, _ in found.places[:4])
                table.lines.append([
                    case.name, str(points), f"{found.duration:.6f}", f"{found.seconds:.6f}", f"{gaps[-1]:.4f}",
                    str(found.steps), f"{costs[-1]:.2f}", where,
                ])  # fmt: skip
        summary.lines.append([
            "yes" if guard else "no", str(cells or "default"), f"{np.median(gaps):.4f}", f"{max(gaps):.4f}",
            f"{sum(gap <= 0.1 for gap in gaps)} of {len(cases)}", f"{np.median(costs):.2f}", f"{max(costs):.2f}",
        ])  # fmt: skip
    for one in (summary, table):
        one.show()
    (RESULTS / "bound.md").write_text(summary.markdown() + "\n" + table.markdown())


if __name__ == "__main__":
    main()
