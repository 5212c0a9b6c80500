"""Memory of scheduler and caller over many trials on a local cluster: `python -m benchmarks.clamping_memory`."""

from __future__ import annotations

import sys
import time
from pathlib import Path

import numpy as np

import toolpace as tp
from toolpace.clamping.choices import Choices
from toolpace.clamping.trial import Task, centre_of, tried
from toolpace.cluster import open_pool

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


def main(count: int) -> None:
    """Make so many trials and print the memory after each STEP."""
    machine, toolpath, choices = tp.Machine.load("xyzac-trunnion"), small_pass(), Choices()
    task = Task(toolpath, machine, centre_of(toolpath), choices.box(), 10e-6, 1e-3)
    names, rng = (*choices.direction, *choices.position), np.random.default_rng(0)
    asked = (choices.clamping(choices.from_shares(names, rng.random(len(names)))) for _ in range(count))
    began, fits = time.perf_counter(), 0
    with open_pool(2) as pool:
        for done, outcome in enumerate(pool.each(tried, task, asked), start=1):
            fits += outcome.value is not None and outcome.value.fits
            if done % STEP == 0:
                print(
                    f"{done:6} trials, {fits} fit, {resident():7.1f} MB, {time.perf_counter() - began:6.0f} s",
                    flush=True,
                )


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 10_000)
