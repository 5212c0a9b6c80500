"""What users get: the default plan, its cost beside the core's and toppra's, its bound, and its limits by positions.

    python -m benchmarks.default [--quick]

The paths of the other benchmarks, as many of ten random harmonics a joint, and the part of the demo. Writes
benchmarks/results/default.md.
"""

from __future__ import annotations

import argparse
import statistics
from collections.abc import Callable
from dataclasses import dataclass

from rich.progress import Progress

from benchmarks.machine import RESULTS, written_by
from benchmarks.peers import Stopwatch, toppra
from benchmarks.tables import Table
from testbed.cases import Case, all_cases, random_case
from testbed.from_positions import used_by_positions
from toolpace.cli.demo_programs import MACHINE, impeller_program
from toolpace.machine.machine import Machine
from toolpace.path.axis_path import AxisPath
from toolpace.path.path import Path
from toolpace.planning.optimal.planner import fastest_law
from toolpace.planning.planner import plan
from toolpace.programs.reading import read_text

DEMO = "demo"
HARMONICS = 40
"""Paths of ten harmonics a joint."""
CELLS = 1000
"""Of the fixed mesh on which parts of the planner are compared."""
REPEATS = 5
MOST_OF_CORE, MOST_WITH_BOUND = 3.0, 4.0
"""How many times the core's CPU time a plan may take at most."""
HEADS = [
    "case", "points", "CPU [s]", "us/point", "/ core", "guard / core", "with bound", "/ toppra", "duration [s]",
    "gap [%]", "usage",
]  # fmt: skip


@dataclass(frozen=True)
class Figures:
    """What was measured on one case; times are the least of several rounds, in turn [s]."""

    points: int
    default: float
    core: float
    guarded_ratio: float
    bound_ratio: float
    toppra: float
    """CPU time a point [s]."""
    duration: float
    gap: float
    usage: float

    @property
    def ratio(self) -> float:
        """Of the default plan to the core on a default mesh."""
        return self.default / self.core

    def line(self, name: str) -> list[str]:
        """As text."""
        beside = self.default / self.points / self.toppra
        return [
            name,
            str(self.points),
            f"{self.default:.3f}",
            f"{1e6 * self.default / self.points:.1f}",
            f"{self.ratio:.1f}",
            marked(self.guarded_ratio, MOST_OF_CORE),
            marked(self.bound_ratio, MOST_WITH_BOUND),
            f"{beside:.1f}" if beside > 0.0 else "-",
            f"{self.duration:.4f}",
            f"{100.0 * self.gap:.3f}",
            f"{self.usage:.6f}",
        ]


def marked(value: float, most: float) -> str:
    """A ratio, with a mark where it misses its target."""
    return f"{value:.2f}" + (" !" if value > most else "")


def demo_case() -> Case:
    """The joints along the part of the demo."""
    machine = Machine.load(MACHINE)
    path = Path.fit(read_text(impeller_program(machine), machine), machine=machine)
    return Case("demo", AxisPath.follow(path, machine), machine.limits, DEMO)


def laws(case: Case, cells: int | None = None, guard: bool = True) -> None:
    """Plan all runs of a case, without a bound."""
    for run in case.axis_path.runs:
        fastest_law(run, case.limits, cells=cells, guard=guard)


def seconds(task: Callable[[], object]) -> float:
    """CPU time of a task."""
    watch = Stopwatch()
    task()
    return watch()


def measured(case: Case, repeats: int = REPEATS) -> Figures:
    """All figures of a case."""
    path, limits = case.axis_path, case.limits
    tasks: list[Callable[[], object]] = [
        lambda: plan(path, limits),
        lambda: laws(case, guard=False),
        lambda: laws(case, cells=CELLS, guard=False),
        lambda: laws(case, cells=CELLS),
        lambda: plan(path, limits, mesh=CELLS),
    ]
    rounds = [[seconds(task) for task in tasks] for _ in range(repeats)]
    default, core, core_on_mesh, guarded, with_bound = map(min, zip(*rounds))
    peer = float("nan")
    if case.source != DEMO:  # toppra wants a callable
        peer = min(toppra.solve(path, limits, CELLS, judge=False).seconds for _ in range(repeats)) / CELLS
    trajectory = plan(path, limits)
    usage = float(used_by_positions(trajectory).max())
    return Figures(
        trajectory.mesh_points, default, core, guarded / core_on_mesh, with_bound / core_on_mesh, peer,
        trajectory.duration, trajectory.gap, usage,
    )  # fmt: skip


def summary(families: dict[str, list[Figures]]) -> Table:
    """Worst and median of each family."""
    heads = ["family", "cases"]
    kinds: list[tuple[str, Callable[[Figures], float], str]] = [
        ("default us/point", lambda f: 1e6 * f.default / f.points, ".1f"),
        ("default / core", lambda f: f.ratio, ".2f"),
        ("guard / core at 1000", lambda f: f.guarded_ratio, ".2f"),
        ("with bound", lambda f: f.bound_ratio, ".2f"),
        ("gap [%]", lambda f: 100.0 * f.gap, ".3f"),
        ("usage by positions", lambda f: f.usage, ".6f"),
    ]
    table = Table("By family: worst, and median in brackets", heads + [name for name, _, _ in kinds])
    for family, found in families.items():
        line = [family, str(len(found))]
        for _, figure, form in kinds:
            values = [figure(one) for one in found]
            line.append(f"{max(values):{form}} ({statistics.median(values):{form}})")
        table.lines.append(line)
    return table


def main() -> None:
    """The command."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.default", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="five cases a family, one round; nothing is written")
    given = parser.parse_args()
    most, repeats = (5, 1) if given.quick else (10**6, REPEATS)
    families = {
        "demo": [demo_case()],
        "paths of the benchmarks": all_cases()[:most],
        "ten harmonics": [random_case(k, modes=10) for k in range(HARMONICS)][:most],
    }
    measured(families["paths of the benchmarks"][0], 1)  # compiles the kernels, loads the libraries
    found: dict[str, list[Figures]] = {}
    table = Table("The default plan, case by case; on 1000 cells guard, bound over core (!: misses target)", HEADS)
    with Progress(transient=True) as progress:
        task = progress.add_task("default plans", total=sum(map(len, families.values())))
        for family, cases in families.items():
            for case in cases:
                progress.update(task, description=case.name)
                figures = measured(case, repeats)
                found.setdefault(family, []).append(figures)
                table.lines.append(figures.line(case.name))
                progress.advance(task)
    tables = [summary(found), table]
    for each in tables:
        each.show()
    if given.quick:
        return
    head = (
        "# The default plan: what users get\n\n"
        f"{written_by('python -m benchmarks.default')} CPU times of one process with one thread, the least of\n"
        f"{REPEATS} rounds in turn. Core: the optimum with limits at the nodes only. Usage: the largest of feed,\n"
        "velocity, acceleration and jerk over its limit, from finite differences of positions alone.\n\n"
    )
    (RESULTS / "default.md").write_text(head + "\n".join(each.markdown() for each in tables))


if __name__ == "__main__":
    main()
