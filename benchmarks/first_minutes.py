"""What a new user waits for, and what lies on the disk after it: the first run, short commands, long programs.

    python -m benchmarks.first_minutes [--repeats 3] [--program FILE MACHINE]... [--out FILE]

Each command is a process of its own. Times of the clock and of the processors are medians of the repeats; what the
first run compiles is measured once, from an empty cache. Programs: four blocks, the demo, 25 operations in tilted
planes with retracts to the machine's end, a long one at a low feed, and files that are named. Writes first_minutes.md.
"""

from __future__ import annotations

import argparse
import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np

from benchmarks.machine import RESULTS, written_by
from benchmarks.tables import Table
from testbed.positioned import positioned
from testbed.programs import waves
from toolpace.machine.limits import Limits
from toolpace.path.axis_path import AxisPath
from toolpace.planning.optimal.planner import fastest_law
from toolpace.planning.planner import plan

COMMAND = [sys.executable, "-m", "toolpace"]
FOUR = "G21 G90 G54\nG43.4 H1\nG1 X10 Y0 Z10 A0 C0 F1000\nX20 Y5\nX30 Y5 A5\nX40 Y0\nM30\n"
LONG_BLOCKS, LONG_FEED = 60_000, 400
"""Blocks of 0.3 mm and feed [mm/min] of the long program: about 47 minutes."""
STEPS = ("reading", "fitting", "planning", "bounding", "sampling", "verifying", "writing")
PATHS, HARMONICS, CELLS = 12, 10, 1000
"""Random paths on which what the limits between nodes cost is measured."""


class Spent(NamedTuple):
    """Of a process: time of the clock and of the processors [s], most memory [MB]."""

    wall: float
    processor: float
    memory: float


def run(command: list[str], **environment: str) -> Spent:
    """A process, to its end; raises CalledProcessError where it fails."""
    began = time.perf_counter()
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, env={**os.environ, **environment})
    _, status, used = os.wait4(process.pid, 0)
    wall = time.perf_counter() - began
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        raise subprocess.CalledProcessError(process.returncode, command)
    return Spent(wall, used.ru_utime + used.ru_stime, used.ru_maxrss / 1024.0)


def median(repeats: int, task: Callable[[], Spent]) -> Spent:
    """Median of each figure."""
    return Spent(*(statistics.median(each) for each in zip(*(task() for _ in range(repeats)))))


def commands(place: Path, repeats: int) -> Table:
    """The first run and short commands."""
    table = Table("Commands", ["command", "clock [s]", "processors [s]"])
    cache = place / "cache"
    compiled = run([sys.executable, "-m", "toolpace.kernels.ahead_of_time"], TOOLPACE_CACHE=str(cache))
    table.lines.append(["compiling of a first run", f"{compiled.wall:.1f}", f"{compiled.processor:.1f}"])
    (place / "four.ngc").write_text(FOUR)
    four = ["plan", str(place / "four.ngc"), "-m", "xyzac-trunnion", "-o", str(place / "four")]
    demo = ["demo", "-o", str(place / "demo")]
    for name, words in (("--help", ["--help"]), ("plan, four blocks", four), ("demo", demo)):
        run([*COMMAND, *words])  # kernels outside those of a first run are compiled
        spent = median(repeats, lambda words=words: run([*COMMAND, *words]))
        table.lines.append([f"toolpace {name}", f"{spent.wall:.2f}", f"{spent.processor:.2f}"])
    return table


def programs(place: Path, repeats: int, named: list[list[str]]) -> Table:
    """Seconds by step and sizes of each program; the median run is that of the median clock."""
    (place / "positioned.nc").write_text(positioned())
    (place / "long.ngc").write_text(waves(LONG_BLOCKS).replace("F3000", f"F{LONG_FEED}"))
    cases: list[tuple[str, list[str]]] = [
        ("25 operations", [str(place / "positioned.nc"), "-m", "xyzbc-trunnion", "--controller", "fanuc"]),
        ("25 operations, effort low", [
            str(place / "positioned.nc"), "-m", "xyzbc-trunnion", "--controller", "fanuc", "--effort", "low",
        ]),
        ("long, at its feed", [str(place / "long.ngc"), "-m", "xyzac-trunnion"]),
    ]  # fmt: skip
    cases += [(Path(file).name, [file, "-m", machine]) for file, machine in named]
    heads = ["program", "motion [s]", "gap [%]", "clock [s]", "processors [s]", "memory [MB]", *STEPS]
    table = Table("Programs", [*heads, "folder [MB]", "largest file", "[MB]"])
    for name, words in cases:
        out = place / "plan"
        runs = []
        for _ in range(repeats):
            spent = run([*COMMAND, "plan", *words, "-o", str(out)])
            runs.append((spent, json.loads((out / "plan.json").read_text())))
        spent, record = sorted(runs, key=lambda each: each[0].wall)[len(runs) // 2]
        sizes = {file.name: file.stat().st_size / 1e6 for file in out.iterdir()}
        largest = max(sizes, key=sizes.__getitem__)
        table.lines.append([
            name, f"{record['duration_s']:.2f}", f"{100.0 * (record['gap'] or 0.0):.2f}", f"{spent.wall:.1f}",
            f"{spent.processor:.1f}", f"{spent.memory:.0f}",
            *(f"{record['step_s'].get(step, 0.0):.1f}" for step in STEPS), f"{sum(sizes.values()):.1f}",
            largest, f"{sizes[largest]:.1f}",
        ])  # fmt: skip
        print(*table.lines[-1], flush=True)
    return table


def random_path(seed: int) -> tuple[AxisPath, Limits]:
    """Five joints as sums of ten harmonics with random amplitudes and phases, and limits of random size."""
    rng = np.random.default_rng(seed)
    order = np.arange(1, HARMONICS + 1)
    amplitude = rng.normal(size=(HARMONICS, 5)) / order[:, None]
    phase = rng.uniform(0.0, 2.0 * np.pi, (HARMONICS, 5))

    def joints(s: np.ndarray, derivative: int) -> np.ndarray:
        angle = order[None, :, None] * s[:, None, None] + phase + 0.5 * np.pi * derivative
        return np.einsum("skj,kj->sj", np.sin(angle) * (order**derivative)[None, :, None], amplitude)

    sizes = [size * 10.0 ** rng.uniform(-0.5, 0.5, 5) for size in (1.0, 5.0, 50.0)]
    return AxisPath.from_callable(joints, 0.0, 2.0 * np.pi), Limits(*sizes)


def between_nodes(repeats: int) -> Table:
    """What limits between the nodes cost over those at the nodes alone, on the same mesh, in processor time."""
    over_core, bounded = [], []
    for seed in range(PATHS):
        path, limits = random_path(seed)
        tasks: list[Callable[[], object]] = [
            lambda path=path, limits=limits: [fastest_law(r, limits, cells=CELLS, guard=False) for r in path.runs],
            lambda path=path, limits=limits: [fastest_law(r, limits, cells=CELLS) for r in path.runs],
            lambda path=path, limits=limits: plan(path, limits, mesh=CELLS),
        ]
        seconds = []
        for task in tasks:
            task()
            rounds = []
            for _ in range(repeats):
                began = time.process_time()
                task()
                rounds.append(time.process_time() - began)
            seconds.append(min(rounds))
        over_core.append(seconds[1] / seconds[0])
        bounded.append(seconds[2] / seconds[0])
    title = f"Limits between nodes, {PATHS} paths of {HARMONICS} harmonics, {CELLS} cells"
    table = Table(title, ["times the processor time of nodes alone", "median", "worst"])
    for name, ratios in (("guarded", over_core), ("guarded, with bound", bounded)):
        table.lines.append([name, f"{statistics.median(ratios):.2f}", f"{max(ratios):.2f}"])
    return table


def main() -> None:
    """Measure all, and write the page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--program", nargs=2, action="append", default=[], metavar=("FILE", "MACHINE"))
    parser.add_argument("--out", type=Path, default=RESULTS / "first_minutes.md")
    options = parser.parse_args()
    tables = [between_nodes(options.repeats)]
    with tempfile.TemporaryDirectory() as folder:
        tables += [commands(Path(folder), options.repeats), programs(Path(folder), options.repeats, options.program)]
    for table in tables:
        table.show()
    written = written_by(f"python -m benchmarks.first_minutes --repeats {options.repeats}")
    head = f"# The first minutes\n\n{written} Load of the machine at the end: {os.getloadavg()[0]:.1f}.\n\n"
    options.out.write_text(head + "\n".join(table.markdown() for table in tables))


if __name__ == "__main__":
    main()
