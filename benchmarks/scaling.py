"""How planning scales with the length of a path: time a point and memory, from a thousand points to a million.

    python -m benchmarks.scaling [out]

The path is that of `testbed/long_path.py`: random, smooth, five joints, with a feature for every 50 mesh cells, in one
run from rest to rest. Every figure is taken in a process of its own, after a short plan has loaded all code; the least
of a few repetitions is kept. Prints the table and writes scaling.md and scaling.png.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from contextlib import ExitStack
from pathlib import Path as File
from typing import Any
from unittest.mock import patch

from benchmarks.machine import RESULTS, most_memory, written_by
from benchmarks.tables import Table
from testbed.long_path import long_path
from toolpace.planning.bound import relaxation
from toolpace.planning.optimal import meshed_run
from toolpace.planning.planner import plan

SIZES = (10**3, 10**4, 10**5, 10**6)
REFERENCE = 10**4
COMPARED = 10**5
KINDS: dict[str, dict[str, bool]] = {
    "unguarded": {"guard": False, "bound": False},
    "guarded": {"bound": False},
    "guarded, with bound": {},
}
"""What is asked of the planner; the last is its default."""
REPEATED_FOR, REPETITIONS = 45.0, 5
"""Plans of one kind are repeated so often, or for so long [s]: others use the machine too."""
MOST_RATIO, MOST_MEMORY, MOST_LOSS = 1.3, 2000.0, 1e-5
Figures = dict[str, Any]


def measured(cells: int, kind: str) -> Figures:
    """Figures of one plan in this process."""
    path, limits = long_path(1000)
    plan(path, limits, mesh=1000).usage()
    loaded = most_memory()
    path, limits = long_path(cells)
    runs: list[tuple[float, float]] = []
    while not runs or (sum(run[0] for run in runs) < REPEATED_FOR and len(runs) < REPETITIONS):
        wall, cpu = time.perf_counter(), time.process_time()
        trajectory = plan(path, limits, mesh=cells, **KINDS[kind])
        runs.append((time.perf_counter() - wall, time.process_time() - cpu))
    memory = most_memory()
    points = trajectory.mesh_points
    return {
        "points": points,
        "wall": 1e6 * min(run[0] for run in runs) / points,
        "cpu": 1e6 * min(run[1] for run in runs) / points,
        "seconds": min(run[0] for run in runs),
        "memory": memory,
        "loaded": loaded,
        "duration": trajectory.duration,
        "gap": trajectory.gap if trajectory.lower_bound else None,
        "usage": trajectory.usage().worst,
    }


def in_own_process(cells: int, kind: str, one_piece: bool = False) -> Figures:
    """The same, measured in a fresh process."""
    command = [sys.executable, "-m", "benchmarks.scaling", "--one", str(cells), kind, str(int(one_piece))]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    figures: Figures = json.loads(done.stdout.splitlines()[-1])
    print(cells, kind, "one piece" if one_piece else "", done.stdout.splitlines()[-1], flush=True)
    return figures


def scaling_table(figures: dict[tuple[int, str], Figures]) -> Table:
    """Time a point and memory by size, with ratios to the size of reference."""
    heads = ["", "points", "total [s]", "wall [us/point]", "CPU [us/point]", f"wall / that at {REFERENCE}",
             f"CPU / that at {REFERENCE}", "peak memory [MB]", "gap", "usage between nodes"]  # fmt: skip
    table = Table("Time a point and memory", heads)
    for kind in KINDS:
        for size in SIZES:
            row, reference = figures[size, kind], figures[REFERENCE, kind]
            ratios = [row[key] / reference[key] for key in ("wall", "cpu")]
            table.lines.append(
                [
                    kind,
                    str(row["points"]),
                    f"{row['seconds']:.2f}",
                    f"{row['wall']:.1f}",
                    f"{row['cpu']:.1f}",
                    *(f"{ratio:.2f}" + " !" * (size == SIZES[-1] and ratio > MOST_RATIO) for ratio in ratios),
                    f"{row['memory']:.0f}" + " !" * (row["memory"] > MOST_MEMORY),
                    "-" if row["gap"] is None else f"{row['gap']:.2e}",
                    f"{row['usage']:.5f}",
                ]
            )
    return table


def loss_table(figures: dict[tuple[int, str], Figures], whole: dict[str, Figures]) -> Table:
    """Windows against one piece."""
    heads = ["", "windows [s]", "one piece [s]", "windows / one piece - 1", "one piece: total [s]", "peak memory [MB]"]
    table = Table(f"Durations at {COMPARED} points: windows against one piece", heads)
    for kind, one in whole.items():
        duration = figures[COMPARED, kind]["duration"]
        loss = duration / one["duration"] - 1.0
        table.lines.append(
            [kind, f"{duration:.6f}", f"{one['duration']:.6f}", f"{loss:.1e}" + " !" * (loss > MOST_LOSS),
             f"{one['seconds']:.1f}", f"{one['memory']:.0f}"]
        )  # fmt: skip
    return table


def picture(figures: dict[tuple[int, str], Figures], out: File) -> None:
    """Time a point and memory over the number of points."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, (left, right) = pyplot.subplots(1, 2, figsize=(9, 3.6), layout="constrained")
    for kind, colour in zip(KINDS, ("C0", "C1", "C2")):
        rows = [figures[size, kind] for size in SIZES]
        points = [row["points"] for row in rows]
        left.semilogx(points, [row["cpu"] for row in rows], "o-", color=colour, label=f"{kind}, CPU")
        left.semilogx(points, [row["wall"] for row in rows], "o:", color=colour, label=f"{kind}, wall")
        right.loglog(points, [row["memory"] for row in rows], "o-", color=colour, label=kind)
    right.loglog(SIZES, [rows[0]["loaded"]] * len(SIZES), "--", color="0.6", label="code alone")
    right.axhline(MOST_MEMORY, color="0.3", linewidth=1.0)
    right.text(SIZES[0], MOST_MEMORY * 1.05, "target: below 2 GB", va="bottom", color="0.3", fontsize="small")
    # room for the legend above the lines
    left.set(xlabel="mesh points", ylabel="microseconds a point", ylim=(0.0, 1.5 * left.get_ylim()[1]))
    right.set(xlabel="mesh points", ylabel="peak memory of the process [MB]", ylim=(100.0, 4000.0))
    left.legend(frameon=False, fontsize="small", loc="upper left", ncols=2)
    right.legend(frameon=False, fontsize="small", loc="center left")
    figure.savefig(out, dpi=130)


def main() -> None:
    """The command."""
    if sys.argv[1:2] == ["--one"]:
        cells, kind, one_piece = int(sys.argv[2]), sys.argv[3], sys.argv[4] == "1"
        # windows begin where the problem of a whole run is no longer kept
        with ExitStack() as patched:
            if one_piece:
                patched.enter_context(patch.object(meshed_run, "KEPT", 10**9))
                patched.enter_context(patch.object(relaxation, "WHOLE", 10**9))
            print(json.dumps(measured(cells, kind)))
        return
    out = File(sys.argv[1]) if len(sys.argv) > 1 else RESULTS
    figures = {(size, kind): in_own_process(size, kind) for size in SIZES for kind in KINDS}
    whole = {kind: in_own_process(COMPARED, kind, one_piece=True) for kind in ("unguarded", "guarded")}
    written(figures, whole, out)


def written(figures: dict[tuple[int, str], Figures], whole: dict[str, Figures], out: File) -> None:
    """Print the tables and write scaling.md and scaling.png."""
    table, loss = scaling_table(figures), loss_table(figures, whole)
    table.show()
    loss.show()
    out.mkdir(parents=True, exist_ok=True)
    picture(figures, out / "scaling.png")
    head = (
        "# Long paths: time a point and memory\n\n"
        f"{written_by('python -m benchmarks.scaling')}\n\nOne random smooth run of"
        " five joints from rest to rest, a feature for every 50 mesh cells (`testbed/long_path.py`), planned in one"
        " call with `mesh` fixed. Each time is the least of up to five. The machine was shared (mean load of the last"
        f" quarter of an hour: {os.getloadavg()[2]:.1f}): where CPU time is less than wall time, others had the"
        " cores.\n"
        f"Targets (! misses): at {SIZES[-1]} points at"
        f" most {MOST_RATIO} times the time a point at {REFERENCE}, and less than {MOST_MEMORY:.0f} MB; windows lose"
        f" at most {MOST_LOSS:g} against one piece.\nRuns of up to 12 000 points are solved in one piece, by one core;"
        " longer ones in windows, on all cores.\n\n"
    )
    shown = "\n![time a point and memory over the number of points](scaling.png)\n\n"
    (out / "scaling.md").write_text(head + table.markdown() + shown + loss.markdown())


if __name__ == "__main__":
    main()
