"""Thousands of random plans, judged from positions alone: largest use of limits, refusals, CPU time a point.

    python -m benchmarks.sweep --count 10000 --seed 1 --workers 2     go on where the same command was stopped
    python -m benchmarks.sweep --seed 1 --summary                     the table of what is there

Families are those of testbed/random_plans.py, the judge is testbed/from_positions.py. Each plan is a line of
out/sweep/SEED.jsonl; the tables are written to benchmarks/results/sweep.md and sweep.json. Slow plans whose line does
not tell why are planned once more, for their causes: out/sweep/SEED.again.jsonl.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import os
import signal
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from toolpace.common.arrays import Floats
    from toolpace.path.axis_run import AxisRun

LONGEST = 120
"""Time after which a plan is given up [s]."""
SLOW = 3.0
"""CPU time a point, as a multiple of the median, from which a plan is named."""
HOME = Path("out") / "sweep"


def one(seed: int) -> dict[str, Any]:
    """What came of the plan of a seed."""
    from testbed.from_positions import used_by_positions
    from testbed.random_plans import FAMILIES, WAYS, random_plan
    from testbed.slow_plans import watched, work_of
    from toolpace.common.errors import InfeasibleError, ToolpaceError
    from toolpace.planning.planner import plan

    row: dict[str, Any] = {"seed": seed, "family": FAMILIES[(seed // 3) % len(FAMILIES)], "way": WAYS[seed % 3]}
    try:
        made = random_plan(seed)
    except InfeasibleError as error:
        return row | {"refused": f"whole path: {error}"}
    row |= {"joints": len(made.limits), "mesh": made.options.get("mesh")}
    asked = timed(made.path.runs)
    began = time.process_time()
    try:
        with watched() as work:
            trajectory = plan(made.path, made.limits, **made.options)
    except ToolpaceError as error:
        return row | {"refused": str(error), "cpu": time.process_time() - began}
    row |= {"cpu": time.process_time() - began, "points": trajectory.mesh_points, "duration": trajectory.duration}
    row |= {"path_cpu": sum(asked), "notes": list(trajectory.notes), "work": work_of(work)}
    positions = used_by_positions(trajectory)
    gap = trajectory.gap if trajectory.gap < 1e300 else None
    return row | {"usage": [float(x) for x in positions], "told": trajectory.usage().worst, "gap": gap}


def timed(runs: Sequence[AxisRun]) -> list[float]:
    """CPU times [s] of what is asked of some runs from now on: a path's own cost."""
    asked: list[float] = []

    def watched(question: Callable[[Floats], Any]) -> Callable[[Floats], Any]:
        def answer(s: Floats) -> Any:
            began, before = time.thread_time(), len(asked)
            try:
                return question(s)
            finally:
                # one question may ask another
                asked[before:] = [time.thread_time() - began]

        return answer

    for run in runs:
        for name in ("evaluate", "with_cap"):
            setattr(run, name, watched(getattr(run, name)))
    return asked


def guarded(seed: int) -> dict[str, Any]:
    """The same; what takes too long or raises what it should not is told as wrong."""

    def over(*_: object) -> None:
        raise TimeoutError

    signal.signal(signal.SIGALRM, over)
    signal.alarm(LONGEST)
    try:
        return one(seed)
    except TimeoutError:
        return {"seed": seed, "wrong": f"not done in {LONGEST} s"} | named(seed)
    except Exception as error:
        return {"seed": seed, "wrong": f"{type(error).__name__}: {error}"} | named(seed)
    finally:
        signal.alarm(0)


def named(seed: int) -> dict[str, str]:
    """Family and way of a seed."""
    from testbed.random_plans import FAMILIES, WAYS

    return {"family": FAMILIES[(seed // 3) % len(FAMILIES)], "way": WAYS[seed % 3]}


def read(file: Path) -> list[dict[str, Any]]:
    """The rows that are there; one that was cut by a kill is left out."""
    rows = []
    for line in file.read_text("utf-8").splitlines() if file.exists() else []:
        try:
            rows.append(json.loads(line))
        except json.JSONDecodeError:
            continue
    return rows


def run(count: int, seed: int, workers: int) -> None:
    """Plan what is not there yet."""
    HOME.mkdir(parents=True, exist_ok=True)
    file = HOME / f"{seed}.jsonl"
    first = seed * 1_000_000
    done = {row["seed"] for row in read(file)}
    left = [k for k in range(first, first + count) if k not in done]
    guarded(first)  # compiled once, before many do it; each of these is warm, too, before it is timed
    context = multiprocessing.get_context("spawn")
    with (
        file.open("a", encoding="utf-8") as out,
        context.Pool(workers, guarded, (first,), maxtasksperchild=400) as pool,
    ):
        for k, row in enumerate(pool.imap_unordered(guarded, left, chunksize=4), start=1):
            out.write(json.dumps(row) + "\n")
            out.flush()
            if "wrong" in row or "refused" in row or max(row.get("usage", [0.0])) > 1.0001:
                print(json.dumps(row), flush=True)
            if k % 500 == 0:
                print(f"{len(done) + k} of {count}", flush=True)


def main() -> None:
    """Run, and write the tables."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--count", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--summary", action="store_true")
    given = parser.parse_args()
    if not given.summary:
        run(given.count, given.seed, given.workers)
    from benchmarks.sweep_tables import write_tables

    command = f"python -m benchmarks.sweep {' '.join(sys.argv[1:])}"
    write_tables(read(HOME / f"{given.seed}.jsonl"), command, SLOW, lambda seeds: once_more(seeds, given.seed))


def once_more(seeds: Sequence[int], seed: int) -> dict[int, dict[str, Any]]:
    """The rows of plans that are made again, one at a time; those that were are read."""
    file = HOME / f"{seed}.again.jsonl"
    rows = {row["seed"]: row for row in read(file)}
    left = [k for k in seeds if k not in rows]
    if left:
        guarded(left[0])  # kernels are loaded
    with file.open("a", encoding="utf-8") as out:
        for k in left:
            rows[k] = guarded(k)
            out.write(json.dumps(rows[k]) + "\n")
            out.flush()
    return {k: rows[k] for k in seeds if "usage" in rows[k]}


if __name__ == "__main__":
    for variable in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):
        os.environ.setdefault(variable, "1")
    main()
