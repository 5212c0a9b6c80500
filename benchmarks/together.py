"""How far motions are from the fastest in the tube: stretches between fixed states, beside IPOPT on path and pace.

    python -m benchmarks.together [efforts ...]        writes benchmarks/results/together.md

Programs without feeds. IPOPT starts from the motion of each effort (see testbed/fastest_in_tube.py); its answer is
looked at between its places and slowed down until it holds. What it takes off is what an effort left.
"""

from __future__ import annotations

import itertools
import math
import sys

from benchmarks.machine import RESULTS, written_by
from benchmarks.tables import Table
from benchmarks.tolerances import CASES, MACHINE, unhurried
from testbed.fastest_in_tube import Stretch, fastest
from toolpace.machine.machine import Machine
from toolpace.planning.program_plan import plan_program

TIP, AXIS = 10e-6, math.radians(0.05)
STARTS = {"demo": (0.3, 4.0, 7.0, 9.5, 16.0), "S-shape": (0.6, 1.9, 3.0), "contour": (2.0, 5.5)}
"""Of the stretches of each program [s]."""
LENGTH = 0.4
"""[s]"""


def main() -> None:
    """The table, on the terminal and in benchmarks/results."""
    efforts = sys.argv[1:] or ["normal", "high"]
    machine = Machine.load(MACHINE)
    heads = [
        "program",
        "effort",
        "from [s]",
        "to [s]",
        "IPOPT [s]",
        "less [%]",
        "usage before slowing",
        "tolerance used",
    ]
    table = Table("Stretches of programs without feeds, and IPOPT on path and pace", heads)
    for name, effort in itertools.product(STARTS, efforts):
        program = unhurried(CASES[name](machine))
        trajectory = plan_program(program, machine, TIP, AXIS, effort=effort).trajectory
        for start in STARTS[name]:
            stretch = Stretch(name, trajectory, program, machine, TIP, AXIS, start, start + LENGTH)
            found = fastest(stretch)
            less = 100.0 * (1.0 - found.duration / LENGTH)
            cells = [f"{start:g}", f"{start + LENGTH:g}", f"{found.duration:.4f}", f"{less:.2f}"]
            table.lines.append([name, effort, *cells, f"{found.usage:.4f}", f"{found.used:.4f}"])
            print(*table.lines[-1], flush=True)
            head = f"# Path and pace together, beside IPOPT\n\n{written_by('python -m benchmarks.together')}\n\n"
            (RESULTS / "together.md").write_text(head + table.markdown())


if __name__ == "__main__":
    main()
