"""Programs as LinuxCNC runs them itself, beside our plan of them and that plan played by LinuxCNC.

    python -m testbed.linuxcnc.compared [--out FILE] [NAME...]

Its own examples of five axes (Debian's package has them), on its own machines, and our demo. Under LinuxCNC's own
planner joints are not held to their limits where the tip is; the plan is held to all of them, and to jerk. It is played
through HAL's streamer and limit3, set just above the limits of the machine.
"""

from __future__ import annotations

import argparse
import datetime
import re
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import toolpace as tp
from testbed.linuxcnc.configuration import Configuration
from testbed.linuxcnc.play import play
from testbed.linuxcnc.run import run_program
from toolpace.cli import demo_programs
from toolpace.common.arrays import Floats
from toolpace.common.files import write_text
from toolpace.common.units import DEGREE, MILLIMETRE, format_time

EXAMPLES = Path("/usr/share/doc/linuxcnc/examples/sample-configs/sim/axis/vismach/5axis/table-rotary-tilting/demos")
SPEED = 6
"""Times real time: faster, rows of a dense stream are lost."""
FREE = 1e6
"""In place of a limit of the path [mm/s]."""


@dataclass(frozen=True)
class Case:
    """A program and the machine that it runs on."""

    text: Callable[[], str]
    machine: Callable[[], tp.Machine]


def _example(name: str) -> Callable[[], str]:
    def text() -> str:
        # the path mode of the startup code is lost now and then: it stands in the program
        return re.sub(r"\A%?\s*", "%\nG21 G64 P0.001\n", (EXAMPLES / name).read_text(encoding="utf-8"))

    return text


def _demo() -> str:
    """Our demo in LinuxCNC's words."""
    return demo_programs.impeller_program(_xyzac()).replace("G43.4 H1", "M428\nG64 P0.01").replace("G49", "M429")


def _xyzac() -> tp.Machine:
    return tp.Machine.load("linuxcnc-xyzac-trt")


def _xyzbc() -> tp.Machine:
    """LinuxCNC's simulated machine xyzbc-trt: B in place of A, its axis aside along X."""
    text = _xyzac().to_toml()
    for old, new in (("joints.A", "joints.B"), ('"A", "C"', '"B", "C"'), ("linuxcnc-xyzac-trt", "linuxcnc-xyzbc-trt")):
        text = text.replace(old, new)
    text = re.sub(r"(\[joints\.B\][^\[]*direction = )\[1, 0, 0\]", r"\1[0, 1, 0]", text)
    text = re.sub(r"point = \[0, 20, 10\]", "point = [20, 0, 10]", text)
    return tp.Machine.from_toml(
        re.sub(r"travel = \[-100, 50\]", "travel = [-100, 100]", text), "linuxcnc-xyzbc-trt.toml"
    )


CASES = {
    "impeller-7bl-xyzac": Case(_example("impeller-7bl-xyzac.ngc"), _xyzac),
    "boat-xyzac": Case(_example("boat-xyzac.ngc"), _xyzac),
    "boat-xyzbc": Case(_example("boat-xyzbc.ngc"), _xyzbc),
    "demo": Case(_demo, _xyzac),
}


@dataclass(frozen=True)
class Row:
    """What came of one program: times [s], ratios of limits, and how far the played plan is off [m, rad]."""

    name: str
    own: float
    own_velocity: float
    own_acceleration: float
    modelled: float
    plan: float
    played: float
    played_velocity: float
    played_acceleration: float
    off: tuple[float, float]


def used(q: Floats, machine: tp.Machine, cycle: float, span: int) -> tuple[float, float]:
    """Largest velocity and acceleration of any joint over its limit, by differences over `span` rows."""
    at = span * cycle
    velocity = np.abs(q[span:] - q[:-span]).max(axis=0) / at
    acceleration = np.abs(q[2 * span :] - 2.0 * q[span:-span] + q[: -2 * span]).max(axis=0) / at**2
    return float((velocity / machine.limits.velocity).max()), float((acceleration / machine.limits.acceleration).max())


def compare(name: str, case: Case, folder: Path) -> Row:
    """Run, plan, export and play one program."""
    from toolpace.cli import main

    machine, text = case.machine(), case.text()
    sheet = folder / f"{name}-setup.toml"
    zeros = "\n".join(f"{joint} = 0" for joint in machine.joints)
    # LinuxCNC begins at its zero, and so does the path
    sheet.write_text(f"[machine_zero]\n{zeros}\n\n[start]\n{zeros}\n", encoding="utf-8")
    program, file, plan = folder / f"{name}.ngc", folder / f"{name}.toml", folder / f"{name}-plan"
    program.write_text(text, encoding="utf-8")
    file.write_text(machine.to_toml(), encoding="utf-8")
    own = run_program(text, Configuration.tip(machine, path_velocity=FREE), seconds=1200.0, speed=SPEED)
    modelled = tp.program_time(program, machine, controller="linuxcnc", setup=sheet).total
    options = ["-m", str(file), "--controller", "linuxcnc", "--setup", str(sheet), "--no-report", "-o", str(plan)]
    if main(["plan", str(program), *options]):
        raise SystemExit(f"{name}: the plan was not verified")
    with np.load(plan / "setpoints.npz") as saved:
        q, t = saved["q"], saved["t"]
    units, limits = np.where(machine.is_rotary, DEGREE, MILLIMETRE), machine.limits
    # just above the plan's own limits: what passes them would be changed
    held = tp.Limits(1.0005 * limits.velocity / units, 1.003 * limits.acceleration / units, np.inf, machine.joints)
    played = play(q / units, held, seconds=1200.0, speed=SPEED)
    off = np.abs(played.limited * units - q).max(axis=0)
    return Row(
        name, own.duration, *used(own.of(machine.joints), machine, 1e-3, 1), modelled, float(t[-1]),
        1e-3 * (len(played.limited) - 1), *used(played.limited * units, machine, 1e-3, 1),
        (float(off[~machine.is_rotary].max()), float(off[machine.is_rotary].max())),
    )  # fmt: skip


def table(rows: list[Row]) -> str:
    """A table (Markdown)."""
    lines = [
        "| program | LinuxCNC itself | of a joint's velocity, acceleration | `toolpace time` | plan "
        "| played by LinuxCNC | of velocity, acceleration | off the plan |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for row in rows:
        lines.append(
            f"| {row.name} | {format_time(row.own)} | {row.own_velocity:.2f}, {row.own_acceleration:.2f} "
            f"| {format_time(row.modelled)} ({row.modelled / row.own - 1.0:+.2%}) | {format_time(row.plan)} "
            f"| {format_time(row.played)} ({row.played / row.plan:.5f}) "
            f"| {row.played_velocity:.4f}, {row.played_acceleration:.4f} "
            f"| {row.off[0] * 1e6:.2g} µm, {np.degrees(row.off[1]):.1g} deg |"
        )
    return "\n".join(lines) + "\n"


def page(rows: list[Row]) -> str:
    """The page of the results (Markdown)."""
    return f"""# LinuxCNC's own runs, and our plans of the same programs

`python -m testbed.linuxcnc.compared` on {datetime.date.today().isoformat()}: LinuxCNC 2.9 runs each program
headless, its joints are logged each servo cycle of 1 ms;
the same program is planned by `toolpace plan` for the same machine, and the plan is played through
HAL's streamer and limit3, which is set 0.05 percent above the machine's velocities and 0.3 above its
accelerations: what passes them it would change. Usage is the largest velocity and acceleration of a joint over its
limit, by differences of one cycle. LinuxCNC holds neither the joints' limits where it holds the tip, nor jerk; the
plan holds both, with jerk ten times the acceleration. Where the computer is busy, LinuxCNC waits longer for its
interpreter than the model says.

{table(rows)}"""


def main() -> None:
    """Compare the cases that are named, all without."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("names", nargs="*", default=list(CASES), choices=[*CASES, []])
    parser.add_argument("--out", type=Path)
    asked = parser.parse_args()
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for name in asked.names:
            rows.append(compare(name, CASES[name], Path(folder)))
            print(table(rows[-1:]), flush=True)
    if asked.out is not None:
        write_text(asked.out, page(rows))


if __name__ == "__main__":
    main()
