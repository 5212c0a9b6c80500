"""The second-order planner beside COPP's and toppra, on the same even mesh and rows; and what jerk limits cost.

python -m benchmarks.second_order        writes benchmarks/results/second-order.md
"""

from __future__ import annotations

import statistics
from collections.abc import Callable

from benchmarks.machine import RESULTS, written_by
from benchmarks.peers import copp_second_order, second_order, toppra
from benchmarks.tables import Table, text
from testbed.cases import Case, all_cases
from toolpace.planning.optimal import planner as optimal
from toolpace.planning.second_order import second_order_law

MESHES = (200, 1000, 5000)
REPEATS = 7
FINEST = 32_000
COARSER = (250, 1000, 4000)
SAME = 1e-6
MOST_OF_COPP = 3.0
MOST_USAGE = 1.0001
Figures = dict[str, float]


def measure(case: Case, n: int) -> Figures:
    """Durations [s], usage between nodes and CPU times a cell [us]; times are medians, taken in turn."""
    path, limits = case.axis_path, case.limits
    ours, guarded = (second_order.solve(path, limits, n, guard=guard) for guard in (False, True))
    copp, _ = copp_second_order.solve(path, limits, n)
    theirs = toppra.solve(path, limits, n, judge=False)
    for outcome in (ours, guarded, copp, theirs):
        assert outcome.ok, outcome.note
    names = ("ours", "copp", "copp passes", "toppra", "passes", "guarded")
    takes: dict[str, list[float]] = {name: [] for name in names}
    forget = case.run.f.forget
    for _ in range(REPEATS):
        forget()
        takes["ours"].append(second_order.solve(path, limits, n, judge=False).seconds)
        forget()
        outcome, alone = copp_second_order.solve(path, limits, n)
        takes["copp"].append(outcome.seconds)
        takes["copp passes"].append(alone)
        forget()
        takes["toppra"].append(toppra.solve(path, limits, n, judge=False).seconds)
        takes["passes"].append(second_order.passes(path, limits, n))
        takes["guarded"].append(second_order.solve(path, limits, n, guard=True, judge=False).seconds)
    us = {f"{name} us": 1e6 * statistics.median(values) / n for name, values in takes.items()}
    return us | {
        "duration": ours.duration,
        "off copp": abs(ours.duration / copp.duration - 1.0),
        "off toppra": abs(ours.duration / theirs.duration - 1.0),
        "/ copp": us["ours us"] / us["copp us"],
        "passes / copp's": us["passes us"] / us["copp passes us"],
        "/ toppra": us["ours us"] / us["toppra us"],
        "usage": ours.between,
        "guarded usage": guarded.between,
        "guard loss": guarded.duration / ours.duration,
    }


COLUMNS: dict[str, tuple[str, float]] = {
    "off copp": (".1e", SAME),
    "off toppra": (".1e", float("inf")),
    "ours us": (".2f", float("inf")),
    "copp us": (".2f", float("inf")),
    "toppra us": (".1f", float("inf")),
    "/ copp": (".2f", MOST_OF_COPP),
    "/ toppra": (".2f", float("inf")),
    "passes us": (".2f", float("inf")),
    "copp passes us": (".2f", float("inf")),
    "passes / copp's": (".2f", float("inf")),
    "usage": (".5f", float("inf")),
    "guarded usage": (".5f", MOST_USAGE),
    "guard loss": (".5f", float("inf")),
    "guarded us": (".1f", float("inf")),
}


def summary(rows: dict[tuple[str, int], Figures]) -> Table:
    """Median and worst over all cases."""
    heads = ["over all cases", *(f"n = {n}, {what}" for n in MESHES for what in ("median", "worst"))]
    table = Table("Summary (! misses its target)", heads)
    for name, (form, most) in COLUMNS.items():
        line = [name]
        for n in MESHES:
            values = [figures[name] for (_, mesh), figures in rows.items() if mesh == n]
            line += [text(statistics.median(values), form), text(max(values), form, most)]
        table.lines.append(line)
    return table


def by_case(rows: dict[tuple[str, int], Figures]) -> Table:
    """Every case."""
    table = Table("Case by case", ["case", "n", "duration [s]", *COLUMNS])
    for (case, n), figures in rows.items():
        shown = [text(figures[name], form, most) for name, (form, most) in COLUMNS.items()]
        table.lines.append([case, str(n), f"{figures['duration']:.5f}", *shown])
    return table


def loss_of_mesh(cases: list[Case]) -> Table:
    """How much longer a coarser mesh makes the motion; half of the nodes even in time, limits held between them."""
    table = Table(
        f"Loss of the mesh: duration over that with {FINEST} cells, less 1",
        ["over all cases", *(f"{n} cells" for n in COARSER)],
    )
    best = [second_order_law(case.run, case.limits, cells=FINEST).duration for case in cases]
    durations = {
        n: [second_order_law(case.run, case.limits, cells=n).duration for case in cases] for n in COARSER
    }
    losses = {n: [longer / least - 1.0 for longer, least in zip(durations[n], best)] for n in COARSER}
    for name, what in (("median", statistics.median), ("worst", max)):
        table.lines.append([name, *(f"{what(losses[n]):.1e}" for n in COARSER)])
    return table


def price_of_jerk(cases: list[Case]) -> Table:
    """What jerk limits cost: both planners on their default meshes, limits held between nodes."""
    table = Table("With and without jerk limits, default meshes", ["case", "second order [s]", "optimal [s]", "ratio"])
    solvers: tuple[Callable[[Case], float], ...] = (
        lambda case: second_order_law(case.run, case.limits).duration,
        lambda case: optimal.fastest_law(case.run, case.limits)[0].duration,
    )
    for case in cases:
        durations = [solve(case) for solve in solvers]
        table.lines.append([case.name, *(f"{value:.4f}" for value in durations), f"{durations[1] / durations[0]:.4f}"])
    return table


def main() -> None:
    """The tables, on the terminal and in benchmarks/results."""
    cases = all_cases()
    measure(cases[0], 50)  # compiles the kernels, loads the libraries
    rows = {(case.name, n): measure(case, n) for case in cases for n in MESHES}
    tables = [summary(rows), loss_of_mesh(cases), price_of_jerk(cases), by_case(rows)]
    for table in tables:
        table.show()
    head = (
        "# The second-order planner beside its peers\n\n"
        f"{written_by('python -m benchmarks.second_order')}\n"
        "One thread each; CPU times a cell, medians of seven runs taken in turn. `ours`, `copp`, `toppra`: from the\n"
        "bare callable to the speeds at the nodes; `passes`: the two passes alone, everything else being known.\n"
        f"`off`: difference of the durations, relative (target, COPP: {SAME:g}); `/ copp`: target {MOST_OF_COPP:g}.\n"
        "Mesh and rows are the same: n even cells, limits at both ends of each. `usage`: the largest value over limit\n"
        "of feed, velocity and acceleration between the nodes; `guarded` holds them there too, at the price\n"
        "`guard loss` of duration. Compare ratios, not microseconds: the machine was not idle.\n\n"
    )
    (RESULTS / "second-order.md").write_text(head + "\n".join(table.markdown() for table in tables))


if __name__ == "__main__":
    main()
