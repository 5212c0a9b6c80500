"""Memory of scheduler and caller over many trials of clampings on a local cluster.

python -m benchmarks.clamping_memory [TRIALS]
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

import numpy as np

import toolpace as tp
from benchmarks.machine import RESULTS, written_by
from toolpace.common.cluster import open_pool
from toolpace.setup_search.choices import Choices
from toolpace.setup_search.trial import Task, centre_of, tried

STEP = 1000
POINTS = 14


def small_pass() -> tp.ToolPath:
    """A short pass whose axis swings."""
    u = np.linspace(0.0, 1.0, POINTS)
    tip = np.column_stack([0.06 * u, 0.01 * np.sin(3.0 * u), 0.0 * u])
    axis = np.column_stack([np.sin(0.4 * np.cos(2.0 * u)), 0.3 * u, np.ones(POINTS)])
    stop = np.isin(np.arange(POINTS), [0, POINTS - 1])
    return tp.ToolPath(
        tip, axis / np.linalg.norm(axis, axis=1)[:, None], np.full(POINTS, 0.2), np.zeros(POINTS),
        np.arange(1, POINTS + 1), stop, np.zeros(POINTS),
    )  # fmt: skip


def resident() -> float:
    """Memory of this process [MB]: of the caller, and of the scheduler, which a local cluster has in it."""
    words = Path("/proc/self/statm").read_text().split()
    return int(words[1]) * 4096 / 1e6


def page(rows: list[tuple[int, int, float, float]]) -> str:
    """What was seen, as a table; rows of trials, those that fit, memory [MB], and time [s]."""
    heads = "| trials | of which fit | scheduler and caller [MB] | wall time [s] |\n|--:|--:|--:|--:|\n"
    lines = "".join(f"| {done} | {fits} | {memory:.1f} | {time:.0f} |\n" for done, fits, memory, time in rows)
    return (
        f"# Many trials of clampings\n\n{written_by('python -m benchmarks.clamping_memory')}\n\nOf a pass of {POINTS} "
        "points with a swinging axis, each placed, fitted and planned on two workers. Scheduler and caller are one "
        f"process.\n\n{heads}{lines}"
    )


def main(count: int) -> None:
    """Make so many trials, and write and print the memory after each STEP."""
    machine, toolpath, choices = tp.Machine.load("xyzac-trunnion"), small_pass(), Choices()
    task = Task(toolpath, machine, centre_of(toolpath), choices.box(), 10e-6, 1e-3)
    names, rng = (*choices.direction, *choices.position), np.random.default_rng(0)
    asked = (choices.clamping(choices.from_shares(names, rng.random(len(names)))) for _ in range(count))
    began, fits = time.perf_counter(), 0
    rows: list[tuple[int, int, float, float]] = []
    with open_pool(2) as pool:
        for done, outcome in enumerate(pool.each(tried, task, asked), start=1):
            fits += outcome.value is not None and outcome.value.fits
            if done % STEP == 0:
                rows.append((done, fits, resident(), time.perf_counter() - began))
                print(*rows[-1], flush=True)
    (RESULTS / "clamping_memory.md").write_text(page(rows))


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 10_000)
