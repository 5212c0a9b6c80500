"""Durations over tolerances: a looser one may cost nothing, and what the freedom of the tool axis buys.

    python -m benchmarks.tolerances [--only NAME...] [--out FILE]

Each program is planned without feeds on one machine, within tip tolerances of 1 to 100 micrometres (axis 0.05 degree)
and axis tolerances of 0.02 to 5 degrees (tip 10 micrometres). Writes tolerances.md.
"""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path as File

import numpy as np

from benchmarks.machine import RESULTS, written_by
from benchmarks.rounding import curve, gcode, places
from benchmarks.tables import Table
from testbed.programs import contour, s_shape, tulsyan
from toolpace.cli.demo_programs import impeller_program
from toolpace.machine.machine import Machine
from toolpace.planning.optimal.planner import Optimal
from toolpace.planning.program_plan import plan_program
from toolpace.programs.reading import read_text
from toolpace.programs.toolpath import ToolPath

MACHINE = "xyzac-trunnion"
TIPS = (1e-6, 2e-6, 5e-6, 10e-6, 20e-6, 50e-6, 100e-6)
AXES = (0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 3.0, 5.0)
"""[deg]"""
TIP, AXIS = 10e-6, 0.05
FEW_TIPS, FEW_AXES = (10e-6, 50e-6), (0.05, 0.2, 1.0)
"""Of the demo, which takes long."""
CURVES = (0, 1, 2)
FREE = 1.002
"""Most that a looser tolerance may cost."""


def rounded(seed: int) -> Callable[[Machine], ToolPath]:
    """A random smooth curve in blocks of 0.2 mm, with three decimals."""

    def program(machine: Machine) -> ToolPath:
        jets = curve(seed)
        return read_text(gcode(jets, places(jets, 0.2e-3), 3, machine), machine, "gcode")

    return program


def demo(machine: Machine) -> ToolPath:
    """The impeller."""
    return read_text(impeller_program(machine), machine)


CASES: dict[str, Callable[[Machine], ToolPath]] = {
    "S-shape": s_shape,
    "Tulsyan": tulsyan,
    "contour": contour,
    **{f"curve {seed}": rounded(seed) for seed in CURVES},
    "demo": demo,
}


def unhurried(toolpath: ToolPath) -> ToolPath:
    """The program without its feeds: where they rule, no tolerance buys anything."""
    return replace(toolpath, feed=np.full(len(toolpath), np.inf), least_time=np.zeros(len(toolpath)))


class Sweep:
    """Durations of one program."""

    def __init__(self, name: str, machine: Machine) -> None:
        self.name, self.machine = name, machine
        self.toolpath = unhurried(CASES[name](machine))
        self.found: dict[tuple[float, float], tuple[float, float]] = {}

    def duration(self, tip: float, axis: float) -> float:
        """Of the plan within a tolerance of the tip [m] and of the axis [deg]."""
        if (tip, axis) not in self.found:
            began = time.process_time()
            plan = plan_program(
                self.toolpath, self.machine, tip, math.radians(axis), planner=Optimal(bound=False)
            )  # fmt: skip
            spent = time.process_time() - began
            self.found[tip, axis] = plan.trajectory.duration, spent
            hoped = min((each.duration for each in plan.rounds), default=math.nan)
            print(f"{self.name:8} {1e6 * tip:4g} um {axis:5g} deg {plan.trajectory.duration:9.5f} s, hoped {hoped:9.5f}"
                  f" s, {len(plan.rounds)} rounds, {spent:6.1f} s CPU", flush=True)  # fmt: skip
        return self.found[tip, axis][0]

    def tips(self) -> list[float]:
        """Tolerances of the tip [m]."""
        return list(FEW_TIPS if self.name == "demo" else TIPS)

    def axes(self) -> list[float]:
        """Tolerances of the axis [deg]."""
        return list(FEW_AXES if self.name == "demo" else AXES)


def costliest(durations: list[float]) -> float:
    """The most that one costs over the fastest within a tighter tolerance, as a factor."""
    best = np.minimum.accumulate(durations)
    return float(np.max(np.array(durations[1:]) / best[:-1]))


def main() -> None:
    """The command."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", nargs="*", help="names of the programs; the tables are printed, not written")
    parser.add_argument("--out", type=File, default=RESULTS / "tolerances.md")
    given = parser.parse_args()
    machine = Machine.load(MACHINE)
    sweeps = [Sweep(name, machine) for name in given.only or CASES]
    by_tip = Table("Duration [s] over the tolerance of the tip", ["program", *(f"{1e6 * tip:g} µm" for tip in TIPS)])
    by_axis = Table("Duration [s] over the tolerance of the axis", ["program", *(f"{axis:g}°" for axis in AXES)])
    worst: list[tuple[float, str]] = []
    for sweep in sweeps:
        tips = {tip: sweep.duration(tip, AXIS) for tip in sweep.tips()}
        axes = {axis: sweep.duration(TIP, axis) for axis in sweep.axes()}
        for table, durations, asked, part in ((by_tip, tips, TIPS, "tip"), (by_axis, axes, AXES, "axis")):
            most = costliest(list(durations.values()))
            worst.append((most, f"{sweep.name}, {part}"))
            cells = [f"{durations[each]:.3f}" if each in durations else "" for each in asked]
            table.lines.append([sweep.name, *cells])
    worst.sort(reverse=True)
    buys = Table(
        "What the freedom of the tool axis buys, beside 0.05 degree [%]", ["program", "0.2°", "1°", "3°", "CPU [s]"]
    )
    for sweep in sweeps:
        first = sweep.duration(TIP, AXIS)
        gains = [
            f"{100.0 * (1.0 - sweep.duration(TIP, axis) / first):.1f}" if axis in sweep.axes() else ""
            for axis in (0.2, 1.0, 3.0)
        ]
        buys.lines.append([sweep.name, *gains, f"{sum(spent for _, spent in sweep.found.values()):.0f}"])
    costs = Table("What a looser tolerance costs at most: over the fastest within a tighter one", ["program", "factor"])
    costs.lines += [[name, f"{most:.5f}"] for most, name in worst]
    for table in (by_tip, by_axis, buys, costs):
        table.show()
    if given.only:
        return
    head = (
        "# What tolerance buys, and that none costs\n\n"
        f"{written_by('python -m benchmarks.tolerances')}\n\n`plan_program` with its"
        f" default effort, machine `{MACHINE}`,\nprograms without feeds. The tip at an axis tolerance of {AXIS:g}"
        f" degree, the axis at {1e6 * TIP:g} µm.\nDurations do not depend on the computer, CPU times do.\n\n"
        f"Worst: a looser tolerance costs **{100.0 * (worst[0][0] - 1.0):.2f} percent** ({worst[0][1]}; at most"
        f" {100.0 * (FREE - 1.0):.1f} asked for).\n\n"
    )
    given.out.write_text(head + "\n".join(table.markdown() for table in (buys, costs, by_tip, by_axis)))


if __name__ == "__main__":
    main()
