"""What the fit makes of rounded programs: durations beside those of the exact curves, and what tolerance buys.

    python -m benchmarks.rounding [count] [out]

Each curve is written as G-code (rotary joints) and as APT (tool axes), in blocks of 0.05 to 2 mm, rounded to three and
to four decimals, read, fitted and planned. Prints the tables and writes rounding.md and rounding.png.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Iterator
from pathlib import Path as File

import numpy as np

from benchmarks.machine import RESULTS, written_by
from benchmarks.tables import Table
from toolpace.common.arrays import Floats
from toolpace.machine.machine import Machine
from toolpace.path.axis_path import AxisPath
from toolpace.path.path import Path
from toolpace.planning.planner import plan
from toolpace.programs.reading import read_text
from toolpace.programs.toolpath import ToolPath

Curve = Callable[[Floats], tuple[Floats, Floats]]
"""u (n,) to tip (4, n, 3) [m] and rotary joints (4, n, 2) [rad], with derivatives."""

MACHINE = "xyzac-trunnion"
FEED = 0.05
COUNT = 12
BLOCKS = (0.05e-3, 0.2e-3, 0.7e-3, 2e-3)
DECIMALS = (3, 4)
MOST = 1.02
TIP, AXIS = 10e-6, math.radians(0.05)
TOLERANCES = (0.03e-6, 0.1e-6, 0.3e-6, 0.6e-6, 1e-6, 2e-6, 5e-6, 10e-6, 20e-6, 50e-6)
"""The first as good as interpolates the rounded points, which are half a micrometre off the curve themselves."""
FAIR = 2.0
"""Chords that leave the curve by more tolerances than this make a polygon of it, which the fit must follow."""


def curve(seed: int) -> Curve:
    """A random smooth five-axis curve, 0.05 to 0.3 m long, that stays away from the pole."""
    random = np.random.default_rng(seed)
    waves = 4
    size = random.uniform(0.02, 0.05)
    pitch = np.arange(1, waves + 1)[:, None] * 2.0 * np.pi * random.uniform(0.3, 0.6)
    swing = size * random.normal(size=(waves, 3)) / np.arange(1, waves + 1)[:, None] ** 2.2
    phase = random.uniform(0.0, 2.0 * np.pi, (waves, 3))
    turn = np.radians([random.uniform(20, 60), random.uniform(8, 25)])
    turn_phase = random.uniform(0.0, 2.0 * np.pi, 2)
    turn_pitch = 2.0 * np.pi * random.uniform(0.3, 0.8, 2)
    middle = np.radians([random.uniform(-60, 60), -random.uniform(28, 50)])
    length = random.uniform(0.05, 0.1)

    def jets(u: Floats) -> tuple[Floats, Floats]:
        angle = pitch * u[:, None, None] + phase
        tip = np.stack([(swing * pitch**k * np.sin(angle + 0.5 * np.pi * k)).sum(axis=1) for k in range(4)])
        tip[0] += np.stack([length * u, 0.0 * u, 0.0 * u + 0.02], axis=1)
        tip[1, :, 0] += length
        wave = turn_pitch * u[:, None] + turn_phase
        rotary = np.stack([turn * turn_pitch**k * np.sin(wave + 0.5 * np.pi * k) for k in range(4)])
        rotary[0] += middle
        return tip, rotary

    return jets


def exact_duration(jets: Curve, machine: Machine) -> float:
    """Duration of the plan on the curve itself."""

    def joints(u: Floats, order: int) -> Floats:
        tip, rotary = jets(u)
        return np.asarray(machine.linear_jets(tip, rotary)[order])

    def cap(u: Floats) -> Floats:
        return np.asarray(FEED / np.linalg.norm(jets(u)[0][1], axis=1))

    return plan(AxisPath.from_callable(joints, 0.0, 1.0, speed_cap=cap), machine.limits).duration


def places(jets: Curve, block: float) -> Floats:
    """Parameters of points `block` [m] apart along the curve."""
    u = np.linspace(0.0, 1.0, 20001)
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(jets(u)[0][0], axis=0), axis=1))])
    return np.interp(np.linspace(0.0, length[-1], int(np.ceil(length[-1] / block)) + 1), length, u)


def chord_error(jets: Curve, u: Floats) -> float:
    """Largest distance between the curve and its chords [m]: h^2 / 8 R."""
    first, second = jets(u)[0][1:3]
    bend = np.linalg.norm(np.cross(first, second), axis=1) / np.linalg.norm(first, axis=1) ** 3
    step = np.linalg.norm(np.diff(jets(u)[0][0], axis=0), axis=1)
    return float(np.max(step**2 / 8.0 * np.maximum(bend[1:], bend[:-1])))


def gcode(jets: Curve, u: Floats, decimals: int, machine: Machine) -> str:
    """The curve as G-code with tool centre point control."""
    tip, rotary = jets(u)
    words = ["X", "Y", "Z", *(machine.joints[joint] for joint in machine.rotary)]
    lines = ["G21 G90 G94", "G43.4"]
    for k, values in enumerate(np.concatenate([1e3 * tip[0], np.degrees(rotary[0])], axis=1)):
        place = " ".join(f"{word}{value:.{decimals}f}" for word, value in zip(words, values))
        lines.append(f"G0 {place}" if k == 0 else f"G1 {place} F{6e4 * FEED:g}")
    return "\n".join([*lines, "M30", ""])


def apt(jets: Curve, u: Floats, decimals: int, machine: Machine) -> str:
    """The curve as APT with tool axes, whose decimals are those of the coordinates."""
    tip, rotary = jets(u)
    lines = ["UNITS/MM", "MULTAX/ON", "RAPID"]
    for k, values in enumerate(np.concatenate([1e3 * tip[0], machine.axis_at(rotary[0])], axis=1)):
        if k == 1:
            lines.append(f"FEDRAT/MMPM,{6e4 * FEED:g}")
        lines.append("GOTO/" + ",".join(f"{value:.{decimals}f}" for value in values))
    return "\n".join([*lines, "FINI", ""])


WRITERS = {"gcode": gcode, "apt": apt}


def programs(jets: Curve, block: float, machine: Machine) -> Iterator[tuple[str, ToolPath]]:
    """Every dialect and rounding of a curve."""
    u = places(jets, block)
    for dialect, write in WRITERS.items():
        for decimals in DECIMALS:
            yield f"{dialect} {decimals}", read_text(write(jets, u, decimals, machine), machine, dialect)


def duration(program: ToolPath, machine: Machine, tip: float = TIP, axis: float = AXIS) -> float:
    """Duration of the plan on the fitted program."""
    return plan(Path.fit(program, tip, axis, machine=machine), machine).duration


def rounded_table(count: int, machine: Machine) -> tuple[Table, float, int]:
    """Durations from rounded programs over those on exact curves; the worst, and the number, of the fair ones."""
    kinds = [f"{dialect} {decimals}" for dialect in WRITERS for decimals in DECIMALS]
    heads = ["curve", "exact [s]", "block [mm]", "blocks", "chord error [µm]", *kinds]
    table = Table("Duration from the rounded program over that on the exact curve", heads)
    worst, fair = 0.0, 0
    for seed in range(count):
        jets = curve(seed)
        exact = exact_duration(jets, machine)
        for block in BLOCKS:
            ratios = [duration(program, machine) / exact for _, program in programs(jets, block, machine)]
            u = places(jets, block)
            error = chord_error(jets, u)
            mark = ""
            if error <= FAIR * TIP:
                worst, fair = max(worst, *ratios), fair + len(ratios)
            else:
                mark = " *"
            line = [str(seed), f"{exact:.4f}", f"{1e3 * block:g}", str(len(u)), f"{1e6 * error:.2f}{mark}"]
            table.lines.append(line + [f"{ratio:.4f}" for ratio in ratios])
            print(*table.lines[-1], flush=True)
    return table, worst, fair


def tolerance_figures(machine: Machine) -> tuple[float, list[tuple[float, float]]]:
    """Duration on an exact curve, and (tolerance, duration) on its program with blocks of 0.2 mm and three decimals."""
    jets = curve(0)
    program = dict(programs(jets, 0.2e-3, machine))["gcode 3"]
    figures = [(tip, duration(program, machine, tip, AXIS * tip / TIP)) for tip in TOLERANCES]
    return exact_duration(jets, machine), figures


def picture(exact: float, figures: list[tuple[float, float]], out: File) -> None:
    """Duration over tolerance."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(figsize=(6, 3.5), layout="constrained")
    axes.semilogx([1e6 * tip for tip, _ in figures], [seconds for _, seconds in figures], "o-", label="rounded program")
    axes.axhline(exact, color="0.5", linestyle="--", label="exact curve")
    axes.set(xlabel="tolerance of the tip [µm]", ylabel="duration [s]", ylim=(0.0, None))
    axes.legend(frameon=False)
    figure.savefig(out, dpi=130)


def main() -> None:
    """The command."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else COUNT
    out = File(sys.argv[2]) if len(sys.argv) > 2 else RESULTS
    machine = Machine.load(MACHINE)
    exact, figures = tolerance_figures(machine)
    buys = Table("What tolerance buys", ["tip tolerance [µm]", "axis tolerance [deg]", "duration [s]", "over exact"])
    for tip, seconds in figures:
        row = [f"{1e6 * tip:g}", f"{math.degrees(AXIS * tip / TIP):g}", f"{seconds:.4f}", f"{seconds / exact:.4f}"]
        buys.lines.append(row)
    buys.show()
    table, worst, fair = rounded_table(count, machine)
    table.show()
    print(f"worst of {fair} programs: {worst:.4f} (at most {MOST})")
    out.mkdir(parents=True, exist_ok=True)
    picture(exact, figures, out / "rounding.png")
    head = (
        "# Rounded programs beside exact curves\n\n"
        f"{written_by(f'python -m benchmarks.rounding {count}')}\n\n"
        f"Machine tool `{MACHINE}`, feed {1e3 * FEED:g} mm/s, tolerance {1e6 * TIP:g} µm and"
        f" {math.degrees(AXIS):g} degrees.\nDurations do not depend on the computer.\n"
        f"Worst of {fair} programs: **{worst:.4f}** times the duration on the exact curve (asked: at most {MOST}).\n"
        f"Programs marked * are not counted: their chords leave the curve by more than {FAIR * TIP * 1e6:g} µm. They"
        " are polygons\nrather than curves within the tolerance, and followed as such.\n\n"
    )
    note = (
        "\nBlocks of 0.2 mm, G-code with three decimals: its points are rounded by half a micrometre. The first row as"
        " good as\ninterpolates them; where the tolerance covers the rounding, nothing is left of it. The axis"
        " tolerance is in proportion,\n0.05 degrees at 10 µm.\n\n![duration over tolerance](rounding.png)\n\n"
    )
    (out / "rounding.md").write_text(head + buys.markdown() + note + table.markdown())


if __name__ == "__main__":
    main()
