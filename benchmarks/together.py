"""How far motions are from the fastest in the tube: stretches between fixed states, beside IPOPT on path and pace.

    python -m benchmarks.together [efforts ...]        writes benchmarks/results/together.md

The demo without feeds. IPOPT starts from the motion of each effort (see testbed/fastest_in_tube.py); its answer is
looked at between its places and slowed down until it holds. What it takes off is what an effort left.
"""

from __future__ import annotations

import math
import sys
from dataclasses import replace

import numpy as np

from benchmarks.machine import RESULTS, written_by
from benchmarks.tables import Table
from testbed.fastest_in_tube import Stretch, fastest
from toolpace import demo
from toolpace.machine.machine import Machine
from toolpace.planning.program_plan import plan_program
from toolpace.reading import read_text

TIP, AXIS = 10e-6, math.radians(0.05)
STARTS = 0.3, 4.0, 7.0, 9.5, 16.0
"""Of the stretches [s]."""
LENGTH = 0.4
"""[s]"""


def main() -> None:
    """The table, on the terminal and in benchmarks/results."""
    efforts = sys.argv[1:] or ["normal", "high"]
    machine = Machine.load(demo.MACHINE)
    program = read_text(demo.impeller_program(), machine, "gcode")
    program = replace(program, feed=np.full(len(program), np.inf))
    heads = ["effort", "from [s]", "to [s]", "IPOPT [s]", "less [%]", "usage before slowing", "tolerance used"]
    table = Table("Stretches of the demo without feeds, and IPOPT on path and pace", heads)
    for effort in efforts:
        trajectory = plan_program(program, machine, TIP, AXIS, effort=effort).trajectory
        for start in STARTS:
            stretch = Stretch("demo", trajectory, program, machine, TIP, AXIS, start, start + LENGTH)
            found = fastest(stretch)
            less = 100.0 * (1.0 - found.duration / LENGTH)
            cells = [f"{start:g}", f"{start + LENGTH:g}", f"{found.duration:.4f}", f"{less:.2f}"]
            table.lines.append([effort, *cells, f"{found.usage:.4f}", f"{found.used:.4f}"])
            print(*table.lines[-1], flush=True)
            head = f"# Path and pace together, beside IPOPT\n\n{written_by('python -m benchmarks.together')}\n\n"
            (RESULTS / "together.md").write_text(head + table.markdown())


if __name__ == "__main__":
    main()
