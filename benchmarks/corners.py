"""Corners: a square of 20 mm within a tolerance, beside LinuxCNC's G64 P of the same and stop-and-go.

    python -m benchmarks.corners [--model] [--out FILE]

The same program goes to toolpace and to the real LinuxCNC (with --model, to our model of it, which is within a
thousandth of it). Ruckig goes from corner to corner, and stops at each. Writes corners.md.
"""

from __future__ import annotations

import argparse
import itertools
import math
from dataclasses import dataclass
from pathlib import Path as File

import numpy as np

from benchmarks.machine import RESULTS, written_by
from benchmarks.tables import Table
from testbed.linuxcnc.configuration import Configuration
from testbed.linuxcnc.run import run_program
from testbed.linuxcnc.times import usage
from toolpace.common.arrays import Floats
from toolpace.controls.timing.linuxcnc import linuxcnc_times
from toolpace.machine.machine import Machine
from toolpace.planning.optimal.planner import Optimal
from toolpace.planning.program_plan import plan_program
from toolpace.planning.second_order import SecondOrder
from toolpace.programs.reading import Source, read_commanded, read_text
from toolpace.programs.reading.options import ReadOptions
from toolpace.programs.toolpath import ToolPath

MACHINE = "linuxcnc-xyzac-trt"
SIDE, FEED = 20.0, 1200.0
"""[mm], [mm/min]: as fast as X and Y of the machine."""
TOLERANCES = (10e-6, 50e-6, 200e-6)
AXES = (0.05, 1.0)
"""Tolerances of the tool axis [deg]."""
SPEED = 4
"""Times real time, of LinuxCNC."""


@dataclass(frozen=True)
class Square:
    """Once round from the middle of a side; with five axes the tilt turns to and fro by 10 degrees."""

    name: str
    tilts: tuple[float, ...]
    """A at the start and at each of the four corners, and at the end [deg]; none with three axes."""

    def program(self, tolerance: float) -> str:
        """As LinuxCNC reads it."""
        half = 0.5 * SIDE
        places = [(half, 0.0), (half, half), (-half, half), (-half, -half), (half, -half), (half, 0.0)]
        lines = ["G21 G90 G17 G94 G40 G49", f"G64 P{1e3 * tolerance:g}", "G0 X0 Y0 Z0 A0 C0"]
        lines += ["M428"] if self.tilts else []
        for k, (x, y) in enumerate(places):
            turned = f" A{self.tilts[k]:g}" if self.tilts else ""
            lines.append(f"{'G0' if k == 0 else 'G1'} X{x:g} Y{y:g} Z0{turned}" + (f" F{FEED:g}" if k == 1 else ""))
        return "\n".join([*lines, *(["M429"] if self.tilts else []), "M2", ""])

    def path(self, tolerance: float, machine: Machine) -> ToolPath:
        """From where the square begins."""
        whole = read_text(self.program(tolerance), machine, "gcode", controller="linuxcnc")
        first = int(np.flatnonzero(np.isfinite(whole.feed))[0]) - 1
        part = slice(first, None)
        stop = whole.stop[part].copy()
        stop[0] = True
        return ToolPath(
            whole.tip[part], whole.axis[part], whole.feed[part], whole.least_time[part], whole.block[part], stop,
            whole.dwell[part], None if whole.rotary is None else whole.rotary[part], whole.rotary_joints,
        )  # fmt: skip


SQUARES = (Square("three axes", ()), Square("five axes", (-20.0, -15.0, -25.0, -15.0, -25.0, -20.0)))


def ours(square: Square, tolerance: float, axis: float, machine: Machine, effort: str) -> float:
    """Duration of the plan [s]."""
    path = square.path(tolerance, machine)
    found = plan_program(path, machine, tolerance, math.radians(axis), effort=effort, planner=Optimal(bound=False))
    return found.trajectory.duration


def without_jerk(square: Square, tolerance: float, machine: Machine) -> float:
    """Duration without limits of jerk, which LinuxCNC has none of [s]."""
    path = square.path(tolerance, machine)
    return plan_program(path, machine, tolerance, math.radians(AXES[0]), planner=SecondOrder()).trajectory.duration


def linuxcnc(square: Square, tolerance: float, machine: Machine, *, model: bool) -> tuple[float, float, float]:
    """Duration on LinuxCNC [s], how far it strays [m], and the largest share of a limit of joints that it takes."""
    text = square.program(tolerance)
    moves = read_commanded(Source.from_text(text, "square.ngc"), machine, options=ReadOptions.of(machine, "linuxcnc"))
    if model:
        fed = ~moves.rapid
        return float(linuxcnc_times(moves, machine)[fed].sum()), math.nan, math.nan
    log = run_program(text, Configuration.tip(machine), seconds=600.0, speed=SPEED)
    begun = np.flatnonzero(log.line >= int(moves.line[~moves.rapid][0]))[0] - 1
    joints = log.of(machine.joints)
    moved = np.flatnonzero(np.any(np.diff(joints[begun:], axis=0) != 0.0, axis=1))
    tips = machine.forward(joints[begun:])[0] if square.tilts else joints[begun:, :3]
    return (
        float(log.t[begun + moved[-1] + 1] - log.t[begun + moved[0]]),
        largest_distance(tips, square.path(tolerance, machine).tip),
        max(usage(log, machine)),
    )


def largest_distance(points: Floats, line: Floats) -> float:
    """Largest distance of points (n, 3) from a polyline (m, 3)."""
    step = np.diff(line, axis=0)
    square = (step**2).sum(axis=1)
    share = np.clip(np.einsum("nmc,mc->nm", points[:, None] - line[None, :-1], step) / square, 0.0, 1.0)
    away = points[:, None] - (line[None, :-1] + share[..., None] * step)
    return float(np.sqrt((away**2).sum(axis=2).min(axis=1).max()))


def stop_and_go(square: Square, machine: Machine) -> float:
    """Duration of straight joint moves from corner to corner, each from rest to rest in least time [s]."""
    import ruckig

    path = square.path(TOLERANCES[0], machine)
    corners = np.flatnonzero(np.diff(path.block, append=path.block[-1] + 1))
    joints = machine.joints_at(path.tip, machine.choose_rotary(path))
    m = len(machine.joints)
    otg, given, answer = ruckig.Ruckig(m), ruckig.InputParameter(m), ruckig.Trajectory(m)
    given.synchronization = ruckig.Synchronization.Phase
    given.max_acceleration = machine.limits.acceleration.tolist()
    given.max_jerk = machine.limits.jerk.tolist()
    duration = 0.0
    for a, b in itertools.pairwise(corners.tolist()):
        start, end = joints[a], joints[b]
        rate = FEED / 6e4 / float(np.linalg.norm(path.tip[b] - path.tip[a]))
        share = np.maximum(np.abs(end - start), 1e-12)
        given.max_velocity = np.minimum(machine.limits.velocity, rate * share).tolist()
        given.current_position, given.target_position = start.tolist(), end.tolist()
        if otg.calculate(given, answer) not in (ruckig.Result.Working, ruckig.Result.Finished):
            raise RuntimeError("ruckig finds no motion")
        duration += answer.duration
    return duration


def main() -> None:
    """The command."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--model", action="store_true", help="our model of LinuxCNC in place of the real one")
    parser.add_argument("--out", type=File, default=RESULTS / "corners.md")
    given = parser.parse_args()
    machine = Machine.load(MACHINE)
    table = Table(
        "Once round the square [s]",
        [
            "axes", "tolerance [µm]", "low", "normal", "high", "normal, 1°", "no jerk limits", "LinuxCNC",
            "strays [µm]", "of limits", "ruckig",
        ],
    )  # fmt: skip
    for square in SQUARES:
        stopping = stop_and_go(square, machine)
        for tolerance in TOLERANCES:
            theirs, strays, share = linuxcnc(square, tolerance, machine, model=given.model)
            efforts = [ours(square, tolerance, AXES[0], machine, effort) for effort in ("low", "normal", "high")]
            wide = f"{ours(square, tolerance, AXES[1], machine, 'normal'):.3f}" if square.tilts else ""
            table.lines.append(
                [square.name, f"{1e6 * tolerance:g}", *(f"{each:.3f}" for each in efforts), wide,
                 f"{without_jerk(square, tolerance, machine):.3f}", f"{theirs:.3f}", f"{1e6 * strays:.1f}",
                 f"{share:.2f}", f"{stopping:.3f}"]
            )  # fmt: skip
            print(*table.lines[-1], flush=True)
    table.show()
    whose = "our model of it (within a thousandth)" if given.model else "the real one, LinuxCNC 2.9, headless"
    head = (
        "# Corners\n\n"
        f"{written_by('python -m benchmarks.corners')}\n\nOnce round a square of"
        f" {SIDE:g} mm from the middle of a side,\nat {FEED:g} mm/min on `{MACHINE}`"
        " (20 mm/s, 300 mm/s², 3000 mm/s³; 30, 300 and 3000 degrees), so at 4 s by the feed\nalone. With five axes the"
        " tilt goes from -15 to -25 degrees and back from corner to corner while the tip is held, and\nturns round at"
        " each.\n\n"
        f"`low`, `normal`, `high`: ours by effort, the axis within {AXES[0]:g} degree; then within {AXES[1]:g} degree;"
        " and on the path of `low` without\nlimits of jerk (`second-order`), which LinuxCNC does not have either."
        f" LinuxCNC: {whose},\n`G64 P` of the same tolerance: its time from the first motion to the last, how far its"
        " tip strays from the program,\nand the most it takes of a joint's velocity or acceleration (while it holds"
        " the tip, it holds the limits of the words, not of\nthe joints). ruckig: straight in the joints from corner"
        " to corner, at rest in each, with our limits of jerk.\n\n"
    )
    given.out.write_text(head + table.markdown())


if __name__ == "__main__":
    main()
