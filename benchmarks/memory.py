"""Most memory of a process in which one planner plans one path.

python -m benchmarks.memory PLANNER CASE N        prints the most memory before and after [MB], as JSON
"""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Sequence

from benchmarks.machine import most_memory
from benchmarks.measure import PEERS
from benchmarks.peers import ipopt, ours, toppra
from testbed.cases import all_cases

PLANNERS = {
    "toolpace": ours.solve,
    "toolpace, guarded": ours.guarded,
    "toppra": toppra.solve,
    "IPOPT": ipopt.solve,
    **{peer.name: peer.solve for peer in PEERS if peer.name != "ruckig"},
}
SMALL = 50
"""Cells of a first plan, which loads libraries and code."""


def peaks(case: str, meshes: Sequence[int]) -> dict[tuple[str, int], tuple[float, float]]:
    """(after, before) by planner and mesh, each from a process of its own; without those that failed."""
    found = {}
    for planner in PLANNERS:
        for n in meshes:
            words = [sys.executable, "-m", "benchmarks.memory", planner, case, str(n)]
            answer = subprocess.run(words, capture_output=True, text=True, check=False)
            if answer.returncode == 0:
                after, before = json.loads(answer.stdout.splitlines()[-1])
                found[planner, n] = after, before
    return found


def main() -> None:
    """The command."""
    planner, name, n = sys.argv[1], sys.argv[2], int(sys.argv[3])
    case = next(case for case in all_cases() if case.name == name)
    PLANNERS[planner](case.axis_path, case.limits, SMALL)
    before = most_memory()
    outcome = PLANNERS[planner](case.axis_path, case.limits, n)
    if not outcome.ok:
        sys.exit(1)
    print(json.dumps([most_memory(), before]))


if __name__ == "__main__":
    main()
