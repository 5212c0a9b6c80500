"""Is the lower bound ever above the best that anybody finds on the same mesh? A thousand random problems.

    python -m benchmarks.bound_checks [count] [seed]

What is compared: see `testbed.bound_check`. Writes benchmarks/results/bound-checks.md.
"""

from __future__ import annotations

import sys
import time

import numpy as np

from benchmarks.machine import RESULTS, written_by
from benchmarks.tables import Table
from testbed.bound_check import ROUNDING, check


def main(count: int = 1000, seed: int = 0) -> None:
    """Check, print the tables, and write them."""
    began = time.process_time()
    done = [check(k) for k in range(seed, seed + count)]
    seconds = time.process_time() - began
    margin = np.array([one.margin for one in done])
    answered = [one for one in done if np.isfinite(one.ipopt)]
    both = [one for one in answered if np.isfinite(one.ours[0])]
    behind = np.array([one.behind for one in both])
    spread = np.array([one.ours[0] / min(one.ours) - 1.0 for one in done])
    table = Table(f"{count} random problems, seeds {seed} to {seed + count - 1}", ["what", "figure"])
    table.lines = [
        ["bound above the best found", f"{(margin < -ROUNDING).sum()}"],
        ["best found / bound - 1: smallest", f"{margin.min():.2e}"],
        ["median", f"{np.median(margin):.2e}"],
        ["share up to 1e-4", f"{(margin <= 1e-4).mean():.3f}"],
        ["largest", f"{margin.max():.2e}"],
        ["planner's start stalled", f"{sum(not np.isfinite(one.ours[0]) for one in done)}"],
        ["IPOPT failed from each of three starts", f"{count - len(answered)}"],
        ["IPOPT better than the planner by more than 1e-6", f"{(behind > 1e-6).sum()} of {len(both)}"],
        ["by more than 1e-4", f"{(behind > 1e-4).sum()}"],
        ["at most by", f"{behind.max():.2e}"],
        ["planner better than IPOPT by more than 1e-6", f"{(behind < -1e-6).sum()}"],
        ["at most by", f"{-behind.min():.2e}"],
        ["another start of ours better than the planner's by more than 1e-6", f"{(spread > 1e-6).sum()}"],
        ["at most by", f"{spread.max():.2e}"],
    ]
    heads = ["seed", "joints", "cells", "bound [s]", "ours / bound - 1", "IPOPT / bound - 1", "ours / IPOPT - 1"]
    worst = Table("Where IPOPT was ahead most, and where it was behind most", heads, words=3)
    ranked = sorted(both, key=lambda one: -one.behind)
    for one in ranked[:8] + ranked[-8:]:
        worst.lines.append([
            str(one.seed), str(one.joints), str(one.cells), f"{one.bound:.6f}", f"{one.ours[0] / one.bound - 1.0:.2e}",
            f"{one.ipopt / one.bound - 1.0:.2e}", f"{one.behind:.2e}",
        ])  # fmt: skip
    for shown in (table, worst):
        shown.show()
    head = (
        "# The lower bound against everybody's best\n\n"
        f"{written_by(f'python -m benchmarks.bound_checks {count} {seed}', f'{seconds:.0f} s of CPU time')}\n\n"
        "Random smooth paths of 1 to 7 joints on 20 to 100 cells, jerk limits over two and a half orders of\n"
        "magnitude, a third with jumps of the feed. Unguarded: what is compared is the sum over the nodes of the\n"
        "same mesh problem. Ours: the planner's core from 0.4 of its guess, its own start, and from 0.1 and 0.8.\n\n"
    )
    (RESULTS / "bound-checks.md").write_text(head + table.markdown() + "\n" + worst.markdown())
    if (margin < -ROUNDING).any():
        sys.exit("the bound is above a time that was found")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
