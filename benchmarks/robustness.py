"""Thousands of nasty paths: how many are answered, how many refused, and how good the answers are, by family.

    python -m benchmarks.robustness [cases a family] [first seed]

The families are those of testbed/nasty_paths.py, judged by testbed/verdict.py. Writes benchmarks/results/robustness.md.
"""

from __future__ import annotations

import sys
import time

import numpy as np

from benchmarks.machine import RESULTS, written_by
from benchmarks.tables import Table
from testbed import nasty_paths
from testbed.verdict import verdict

BAD_GAPS = (0.1, 1.0)
"""Gaps to the lower bound from which answers are counted as poor, and as very poor."""


def main(count: int = 300, seed: int = 100_000) -> None:
    """Plan, print, and write."""
    heads = ["family", "cases", "answers", "refusals", "wrong", "worst usage", "gap, median", "worst",
             *(f"gap over {gap:g}" for gap in BAD_GAPS), "CPU a case, mean [s]", "worst"]  # fmt: skip
    table = Table(f"{count} cases a family, seeds {seed} to {seed + count - 1}", heads)
    wrong: list[str] = []
    total = np.zeros(4, dtype=int)
    usage = 0.0
    for family in nasty_paths.FAMILIES:
        told, gaps, worst, seconds = [], [], 0.0, []
        for k in range(seed, seed + count):
            began = time.process_time()
            case = nasty_paths.case(family, k)
            found = verdict(case)
            told.append(found.words)
            seconds.append(time.process_time() - began)
            if found.words not in ("answer", "refusal"):
                wrong.append(f"{family}, seed {k}: {found.words}")
            if found.words == "answer":
                worst = max(worst, found.usage)
                gaps.append(found.gap)
        finite = np.array([gap for gap in gaps if np.isfinite(gap)])
        numbers = [len(told), told.count("answer"), told.count("refusal")]
        total += [*numbers, numbers[0] - numbers[1] - numbers[2]]
        usage = max(usage, worst)
        shares = [str(int((finite > gap).sum())) for gap in BAD_GAPS]
        figures = [f"{np.median(finite):.1e}", f"{finite.max():.1e}"] if len(finite) else ["-", "-"]
        table.lines.append([
            family, *map(str, numbers), str(numbers[0] - numbers[1] - numbers[2]), f"{worst:.6f}", *figures, *shares,
            f"{np.mean(seconds):.2f}", f"{max(seconds):.1f}",
        ])  # fmt: skip
        print(table.lines[-1], flush=True)
    table.lines.append(["all", *map(str, total), f"{usage:.6f}", "", "", "", "", "", ""])
    table.show()
    for line in wrong:
        print(line)
    head = (
        "# Random and nasty paths\n\n"
        f"{written_by(f'python -m benchmarks.robustness {count} {seed}')}\n\n"
        "What the families are is said in tests/nasty_paths.py, what is judged in tests/judge.py. Refusals are\n"
        "counted as such only where they are justified; all else is wrong. The gap is that to the lower bound.\n\n"
    )
    tail = "\n## Wrong\n\n" + "".join(f"* {line}\n" for line in wrong) if wrong else ""
    (RESULTS / "robustness.md").write_text(head + table.markdown() + tail)


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
