# ruff: noqa: RUF001 - dashes, as tables are set
"""How much of what the genetic planner finds is luck: ten seeds on three paths, as a table of `docs/design/paper.md`.

python -m benchmarks.seeds
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from benchmarks.deflections import cases
from toolpace.path.axis_path import AxisPath
from toolpace.planning.genetic import Genetic
from toolpace.planning.planner import plan

GENERATIONS = (1, 10, 100)
SEEDS = range(Genetic().seed, Genetic().seed + 10)


def main() -> None:
    """Print the table."""
    heads = [f"{count} generation{'s' if count > 1 else ''}" for count in GENERATIONS]
    print(f"| path | optimal | {' | '.join(heads)} |\n|{'---|' * (2 + len(GENERATIONS))}")
    for name, (path, machine) in cases().items():
        axis_path = AxisPath.follow(path, machine)
        best = plan(axis_path, machine).duration
        cells = []
        for count in GENERATIONS:
            options = Genetic(generations=count)
            found = np.array([plan(axis_path, machine, planner=replace(options, seed=seed)).duration for seed in SEEDS])
            spread = f"{found.min():.3f} – {found.mean():.3f} – {found.max():.3f}"
            cells.append(f"{found[0]:.3f} s ({100 * (found[0] / best - 1):+.1f} %); {spread}")
        print(f"| {name} | {best:.3f} s | {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    main()
