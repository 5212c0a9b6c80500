"""Run the benchmarks, print the tables, keep the results."""

from __future__ import annotations

import argparse
import datetime
import json
from pathlib import Path

from rich.progress import Progress

from benchmarks import tables
from benchmarks.machine import RESULTS, machine, written_by
from benchmarks.measure import MESHES, VERY_FINE, Row, measure, row
from benchmarks.memory import peaks
from benchmarks.pictures import draw
from testbed.cases import RANDOM_CASES, all_cases


def main() -> None:
    """The command."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="three published and two random paths, n = 200 and 1000")
    parser.add_argument("--random", type=int, default=None, help=f"number of random paths (default {RANDOM_CASES})")
    parser.add_argument("--mesh", type=int, nargs="*", default=None, help=f"mesh cells (default {MESHES})")
    parser.add_argument("--out", type=Path, default=None, help="folder of the results (default benchmarks/results)")
    given = parser.parse_args()
    random = given.random if given.random is not None else 2 if given.quick else RANDOM_CASES
    meshes = given.mesh or (MESHES[:2] if given.quick else MESHES)
    cases = all_cases(random)
    for _, outcome in measure(cases[0], 50, quick=True):
        assert outcome is not None  # compiles the kernels, loads the libraries
    asked = [(case, n) for case in cases for n in meshes]
    asked += [(cases[0], VERY_FINE)] if given.mesh is None and not given.quick else []
    rows: list[Row] = []
    with Progress(transient=True) as progress:
        task = progress.add_task("benchmarks", total=sum(n for _, n in asked))
        for case, n in asked:
            progress.update(task, description=f"{case.name}, n = {n}")
            for planner, outcome in measure(case, n, given.quick):
                rows.append(row(case, n, planner, outcome))
            progress.advance(task, n)
    results = tables.Results(rows)
    shown = [
        tables.targets(results),
        tables.summary(results),
        tables.peers(results),
        tables.published(results, [case.name for case in cases[:3]]),
        tables.memory(peaks(cases[-1].name, meshes), cases[-1].name),
        tables.failures(rows),
    ]
    for table in shown:
        table.show()
    if given.quick and given.out is None:
        return
    out = given.out or RESULTS
    out.mkdir(parents=True, exist_ok=True)
    about = {"date": datetime.date.today().isoformat(), "machine": machine()}
    (out / "planner.json").write_text(json.dumps({**about, "rows": rows}, indent=1) + "\n")
    head = (
        "# The planner beside its peers\n\n"
        f"{written_by('make bench')} One thread each; times are CPU times of the\n"
        "process, from the bare callable to the law of motion; medians of seven runs for toolpace and toppra in turn,\n"
        "single runs for the others. Compare ratios, not microseconds: the machine was not idle.\n\n"
        "`time / IPOPT's` compares what both minimise, the time of the discretised problem; IPOPT has the same nodes,\n"
        "spline, rows, caps and weights. Usage: the largest value over limit of feed, velocity, acceleration, jerk.\n\n"
    )
    draw(results, out / "planner.png")
    picture = "![time a point and duration over the number of mesh cells, by planner](planner.png)\n\n"
    (out / "planner.md").write_text(head + picture + "\n".join(table.markdown() for table in shown))


if __name__ == "__main__":
    main()
