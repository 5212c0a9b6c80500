"""What each effort gives: durations, their cost, and the tolerance that is used, program by program.

    python -m benchmarks.efforts [--only NAME...] [--program FILE MACHINE]... [--out FILE]

The demo with and without its feeds, passes known from papers and twelve rounded curves, and program files that are
given, each within 10 micrometres and 0.05 degree; then programs of up to 100 000 blocks. Writes efforts.md.
"""

from __future__ import annotations

import argparse
import math
import multiprocessing
import resource
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path as File

from benchmarks.machine import RESULTS, written_by
from benchmarks.tables import Table
from benchmarks.tolerances import AXIS, CASES, MACHINE, TIP, rounded, unhurried
from testbed.from_positions import used_by_positions
from testbed.programs import waves
from toolpace.machine.machine import Machine
from toolpace.planning.optimal.planner import Optimal
from toolpace.planning.program_plan import EFFORTS, plan_program
from toolpace.programs.reading import read, read_text
from toolpace.programs.toolpath import ToolPath

CURVES = range(12)
BLOCKS = 25_000, 50_000, 100_000
"""Of the long programs."""
HEADS = [
    "program", "low [s]", "normal [s]", "high [s]", "normal / low", "high / normal", "usage", "CPU [s]: low", "normal",
    "high",
]  # fmt: skip

Program = tuple[Callable[[Machine], ToolPath], str]
"""What makes a tool path for a machine, and that machine's name."""


def programs(files: list[list[str]]) -> dict[str, Program]:
    """All of them by name; of `files`, each a file and the name of a machine."""
    found: dict[str, Program] = {"demo with its feeds": (CASES["demo"], MACHINE)}
    names = {**CASES, **{f"curve {seed}": rounded(seed) for seed in CURVES}}
    for name, make in names.items():
        found[name] = (lambda machine, make=make: unhurried(make(machine))), MACHINE
    for file, machine in files:
        found[File(file).name] = (lambda on, file=file: read(file, on)), machine
    return found


def of_waves(blocks: int, effort: str) -> tuple[float, float, float]:
    """CPU time [s], duration [s] and the most memory [MB] of a long program, in a process of its own."""
    machine = Machine.load(MACHINE)
    toolpath = read_text(waves(blocks), machine)
    began = time.process_time()
    planned = plan_program(toolpath, machine, TIP, math.radians(AXIS), effort=effort)
    spent = time.process_time() - began
    return spent, planned.trajectory.duration, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0


def long_programs() -> Table:
    """What the rounds cost where blocks are many, and that memory grows with them only."""
    heads = ["blocks", "low [s]", "normal [s]", "CPU [s]: low", "normal", "normal / low", "memory [MB]: low", "normal"]
    table = Table("Long programs with their feeds: waves, with the bound", heads)
    for blocks in BLOCKS:
        with ProcessPoolExecutor(1, multiprocessing.get_context("spawn"), max_tasks_per_child=1) as pool:
            low, normal = pool.map(of_waves, (blocks, blocks), ("low", "normal"))
        spent, durations, memory = zip(low, normal)
        table.lines.append(
            [str(blocks), *(f"{each:.3f}" for each in durations), *(f"{each:.1f}" for each in spent),
             f"{spent[1] / spent[0]:.2f}", *(f"{each:.0f}" for each in memory)]
        )  # fmt: skip
        print(*table.lines[-1], flush=True)
    return table


def main() -> None:
    """The command."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", nargs="*", help="names of the programs")
    parser.add_argument("--program", nargs=2, action="append", default=[], metavar=("FILE", "MACHINE"))
    parser.add_argument("--out", type=File, default=RESULTS / "efforts.md")
    given = parser.parse_args()
    table = Table("Durations by effort", HEADS)
    worst = 0.0
    for name, (make, machine_name) in programs(given.program).items():
        if given.only and name not in given.only:
            continue
        machine = Machine.load(machine_name)
        toolpath = make(machine)
        durations, spent, usage = [], [], 0.0
        for effort in EFFORTS:
            began = time.process_time()
            planned = plan_program(
                toolpath, machine, TIP, math.radians(AXIS), effort=effort, planner=Optimal(bound=False)
            )
            spent.append(time.process_time() - began)
            durations.append(planned.trajectory.duration)
            usage = max(usage, float(used_by_positions(planned.trajectory).max()))
        low, normal, high = durations
        worst = max(worst, normal / low, high / normal)
        table.lines.append(
            [name, *(f"{each:.4f}" for each in durations), f"{normal / low:.4f}", f"{high / normal:.4f}",
             f"{usage:.6f}", *(f"{each:.1f}" for each in spent)]
        )  # fmt: skip
        print(*table.lines[-1], flush=True)
        head = (
            f"# What each effort gives\n\n{written_by('python -m benchmarks.efforts')}\nWithin {1e6 * TIP:g} µm and"
            f" {AXIS:g} degree; without feeds, but for what says so and the files. Usage by positions,\nthe most of"
            f" the three. The most that a greater effort costs: a factor of {worst:.5f}.\n\n"
        )
        given.out.write_text(head + table.markdown())
    if not given.only:
        given.out.write_text(head + table.markdown() + "\n" + long_programs().markdown())


if __name__ == "__main__":
    main()
