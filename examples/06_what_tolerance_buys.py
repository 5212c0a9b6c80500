"""Duration over tolerance: how much time a few micrometres of freedom save, where feeds do not decide."""

from __future__ import annotations

import toolpace as tp
from toolpace import demo

TOLERANCES = (2e-6, 10e-6, 50e-6)
"""[m]"""


def main() -> list[float]:
    machine = tp.Machine.load("xyzac-trunnion")
    toolpath = tp.read_text(demo.impeller_program(machine, 30), machine, feed="none")
    durations = []
    for tolerance in TOLERANCES:
        path = tp.Path.fit(toolpath, tip_tolerance=tolerance, axis_tolerance=100.0 * tolerance, machine=machine)
        trajectory = tp.plan(path, machine)
        durations.append(trajectory.duration)
        print(f"{tolerance * 1e6:5.0f} µm  {trajectory.duration:8.3f} s")
    return durations


if __name__ == "__main__":
    main()
