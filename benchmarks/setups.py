"""Where to clamp the part: what three searches of other seeds find, beside a grid over two of the dimensions.

    python -m benchmarks.setups [PROGRAM:MACHINE ...] [--trials 80] [--turns 8] [--shown 3]

Without a program: a curved pass of 120 mm, and the demo. Every set-up that a search returns is planned anew, and its
set-points are held against all travels. Writes benchmarks/results/setups.json and .md, which keep the other programs.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.machine import RESULTS, written_by
from benchmarks.tables import Table
from testbed.curved_pass import curved_pass
from toolpace.cli.demo_programs import MACHINE, impeller_program
from toolpace.common.errors import ToolpaceError
from toolpace.machine.machine import Machine
from toolpace.path.path import Path as Curve
from toolpace.planning.planner import plan
from toolpace.programs.reading import read, read_text
from toolpace.programs.toolpath import ToolPath
from toolpace.setup_search.choices import Choices
from toolpace.setup_search.clamping import Clamping
from toolpace.setup_search.found_set_up import PlannedSetUp, confirmed
from toolpace.setup_search.search import search_setup
from toolpace.setup_search.trial import Task, Trial, as_tips_and_axes, centre_of, tried

Row = dict[str, Any]
SEEDS = (1, 2, 3)
CONFIRMED = 2
"""Best of the grid that are planned in full."""
APART = 1e-2
"""Share by which the seeds may differ."""
STEP = 2e-3
"""Between the set-points that are held against travel [s]."""
SLACK = 1e-9
"""Rounding of a position at the end of its travel [m or rad]."""


@dataclass(frozen=True)
class Case:
    """A program, and the machine with the part as it is given."""

    name: str
    toolpath: ToolPath
    machine: Machine


HEADS = [
    "program", "machine", "trials", "given [s]", *(f"seed {seed} [s]" for seed in SEEDS), "gain [%]",
    "seeds apart [%]", "best of the grid [s]", "worst seed beside it [%]", "set-points beyond travel",
    "processor [s]",
]  # fmt: skip


def cases(named: Sequence[str]) -> list[Case]:
    """Programs by file and machine; without any those that need no file."""
    machine = Machine.load(MACHINE)
    if not named:
        demo = read_text(impeller_program(machine), machine)
        return [Case("curved pass of 120 mm", curved_pass(), machine), Case("demo", demo, machine)]
    chosen = []
    for each in named:
        file, _, name = each.rpartition(":")
        other = Machine.load(name)
        chosen.append(Case(Path(file).name, read(file, other), other))
    return chosen


def measured(case: Case, trials: int, turns: int, shown: int) -> Row:
    """Search by each seed, look at a grid, and hold what was returned against travel."""
    began = time.process_time()
    found = [
        search_setup(case.toolpath, case.machine, seed=seed, trials=trials, shown=shown, mapped=0) for seed in SEEDS
    ]
    nodes, best = of_grid(case, turns)
    returned = [set_up for each in found for set_up in each.best if set_up is not each.given]
    looked = [beyond_travel(case, set_up) for set_up in returned]
    given = found[0].given
    return {
        "machine": case.machine.name,
        "trials": trials,
        "given_s": given.duration if given else None,
        "seeds_s": [each.best[0].duration for each in found],
        "grid_s": best.duration,
        "grid": f"{nodes} of {4 * turns} fit; best with {best.clamping.words(best.machine)}",
        "beyond": sum(beyond for beyond, _ in looked),
        "points": sum(count for _, count in looked),
        "processor_s": time.process_time() - began,
    }


def apart(row: Row) -> float:
    """Share by which the worst seed is slower than the best."""
    return max(row["seeds_s"]) / min(row["seeds_s"]) - 1.0


def line(name: str, row: Row) -> list[str]:
    """A row as text."""
    times, given = row["seeds_s"], row["given_s"]
    gains = [100.0 * (1.0 - each / given) for each in (max(times), min(times))] if given else []
    return [
        name,
        row["machine"],
        str(row["trials"]),
        f"{given:.3f}" if given else "cannot be run",
        *(f"{each:.3f}" for each in times),
        " to ".join(f"{gain:.2f}" for gain in gains),
        f"{100.0 * apart(row):.2f}" + (" !" if apart(row) > APART else ""),
        f"{row['grid_s']:.3f}",
        f"{100.0 * (max(times) / row['grid_s'] - 1.0):+.2f}",
        f"{row['beyond']} of {row['points']}",
        f"{row['processor_s']:.0f}",
    ]


def of_grid(case: Case, turns: int) -> tuple[int, PlannedSetUp]:
    """Turn and tilt, each at the place nearest to the given one that fits: how many fit, and the best in full."""
    choices, free = Choices(), as_tips_and_axes(case.toolpath)
    task = Task(free, case.machine, centre_of(free), choices.box(), 10e-6, 1e-3)
    fit: list[Trial] = []
    for tilt in choices.tilt.values:
        for turn in np.linspace(-np.pi, np.pi, turns, endpoint=False):
            trial = tried(task, Clamping(float(turn), tilt))
            fit += [trial] if trial.fits else []
    best: list[PlannedSetUp] = []
    for trial in sorted(fit, key=lambda trial: trial.cost):
        if len(best) == CONFIRMED:
            break
        try:
            best.append(confirmed(task, trial.clamping))
        except ToolpaceError:
            continue
    return len(fit), min(best, key=lambda each: each.duration)


def beyond_travel(case: Case, found: PlannedSetUp) -> tuple[int, int]:
    """Set-points of a plan made anew that are beyond travel, and of all."""
    machine = found.machine
    path = Curve.fit(as_tips_and_axes(case.toolpath), machine=machine)
    q = plan(path, machine, bound=False).sample(max(STEP, found.duration / 200_000)).q
    low, high = machine.travel.T
    return int(((q < low - SLACK) | (q > high + SLACK)).any(axis=1).sum()), len(q)


def page(found: dict[str, Any]) -> str:
    """The results in words."""
    rows = sorted(found["programs"].items(), key=lambda each: -apart(each[1]))
    table = Table("Three seeds, worst first", HEADS, [line(*each) for each in rows], words=2).markdown()
    grids = "\n".join(f"* {name}: {row['grid']}, {row['grid_s']:.3f} s in full" for name, row in rows)
    return f"""# Where to clamp the part

{found["written by"]}

`tp.search_setup` with the usual choices. "Given" is the set-up of the machine file, with the program as it is written.
What a search finds is the simplest of what is as fast to 0.1 percent, so a grid may be that far ahead. Seconds are
of motion, but for those of the processor: those are of all three searches, the grid, and plans made anew from what
was returned, whose set-points are held against travel.

{table}
## The grid

Turns of the whole circle by tilts of 0, 15, 30 and 45 degrees, each at the nearest place that fits, planned cheaply;
the best {CONFIRMED} in full.

{grids}
"""


def main() -> None:
    """The command."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.setups", description=__doc__)
    parser.add_argument("programs", nargs="*", metavar="PROGRAM:MACHINE")
    parser.add_argument("--trials", type=int, default=80)
    parser.add_argument("--turns", type=int, default=8)
    parser.add_argument("--shown", type=int, default=3)
    asked = parser.parse_args()
    file = RESULTS / "setups.json"
    for case in cases(asked.programs):
        row = measured(case, asked.trials, asked.turns, asked.shown)
        found: dict[str, Any] = json.loads(file.read_text()) if file.exists() else {"programs": {}}
        found["programs"][case.name] = row
        print(*line(case.name, row), sep=" | ", flush=True)
        found["written by"] = written_by("python -m benchmarks.setups")
        file.write_text(json.dumps(found, indent=1) + "\n")
        file.with_suffix(".md").write_text(page(found))


if __name__ == "__main__":
    main()
