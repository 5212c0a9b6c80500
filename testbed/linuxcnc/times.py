"""How long programs take on the real LinuxCNC, and by our model of it; what they ask of the joints there.

    python -m testbed.linuxcnc.times [--only NAME...] [--out FILE]
    python -m testbed.linuxcnc.times --program FILE... [--machine NAME]

All programs take about twenty minutes. Those of LinuxCNC's own examples are where its Debian package puts them. Files
of one's own are run once, and their rows printed.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from testbed.linuxcnc.configuration import Configuration
from testbed.linuxcnc.machines import xyzbc_trt
from testbed.linuxcnc.run import Log, run_program
from testbed.linuxcnc.timed import TUNED
from testbed.linuxcnc.written_after import AFTER
from toolpace.controls.timing.linuxcnc import linuxcnc_times
from toolpace.machine.machine import Machine
from toolpace.programs.commanded import Commanded
from toolpace.programs.reading import Source, read_commanded
from toolpace.programs.reading.options import ReadOptions

RESULTS = Path("benchmarks/results/linuxcnc_times.md")
EXAMPLES = Path("/usr/share/doc/linuxcnc/examples/sample-configs/sim/axis/vismach/5axis/table-rotary-tilting/demos")
FILES = Path("/usr/share/linuxcnc/ncfiles")
LINUXCNC = "LinuxCNC's"
"""Whose its own examples are; they take long."""
OWN = "own"
"""Whose a file is that was named."""
FAST, SLOW = 8, 2
"""Times real time."""
NEEDS_TIME = ("switching", "noise", "surface", "dense")
"""Blocks of a cycle or two, and words that wait: LinuxCNC's interpreter has to keep up."""
MENDED = ("bores", "holes")
"""Written after the model, and showed a mistake that was then mended."""
HEAD = """# How long programs take on LinuxCNC, and by our model of it

`python -m testbed.linuxcnc.times`: LinuxCNC 2.9 runs each program headless, its joints are logged each servo cycle of
1 ms, and the time from the first cycle that moves a joint to the last is compared with `toolpace time` and its model
`linuxcnc`. Usage is the largest velocity and acceleration of a joint in that log over its limit (differences of one
cycle): LinuxCNC holds the limits of the words, not of the joints, while it holds the tip. "Tuned" programs were
looked at while the model was written; "mended" ones were written after it and each showed a mistake; all others were
not used. Ours are run twice, and the quicker run counts: where the computer is busy, LinuxCNC waits longer, never less;
LinuxCNC's own examples once. Measured on {day}, rows that `--only` left out before; LinuxCNC 2.9 of Debian 12, eight
times real time (dense programs two). A program that names no path mode runs with the tolerance that LinuxCNC begins
with, 0.001 inch.

| program | whose | blocks | LinuxCNC [s] | ours [s] | off by [%] | model [ms] | velocity | acceleration |
|---|---|---|---|---|---|---|---|---|
"""


@dataclass(frozen=True)
class Case:
    """A program, where it runs and how fast."""

    name: str
    whose: str
    text: Callable[[], str]
    machine: Machine

    @property
    def runs(self) -> int:
        """The quickest counts: where this machine is busy, LinuxCNC waits longer, never less."""
        return 1 if self.whose in (LINUXCNC, OWN) else 2

    @property
    def speed(self) -> int:
        """Times real time."""
        return SLOW if self.name in NEEDS_TIME else FAST


def head() -> str:
    """What stands above the rows."""
    return HEAD.replace("{day}", time.strftime("%d %B %Y"))


def cases() -> list[Case]:
    """All programs, the tuned ones first."""
    trt = Machine.load("linuxcnc-xyzac-trt")
    found = [Case(name, "tuned", text, trt) for name, text in TUNED.items()]
    found += [Case(name, "mended" if name in MENDED else "after", text, trt) for name, text in AFTER.items()]
    for name, machine in (("impeller-7bl-xyzac", trt), ("boat-xyzac", trt), ("boat-xyzbc", xyzbc_trt())):
        found.append(Case(name, LINUXCNC, (EXAMPLES / f"{name}.ngc").read_text, machine))
    for name in ("3D_Chips", "arcspiral"):
        found.append(Case(name, LINUXCNC, (FILES / f"{name}.ngc").read_text, trt))
    return found


def row(case: Case) -> str:
    """A row of the table."""
    configuration = Configuration.tip(case.machine)
    text = case.text()
    return row_of(case, [run_program(text, configuration, seconds=3000.0, speed=case.speed) for _ in range(case.runs)])


def row_of(case: Case, logs: Sequence[Log]) -> str:
    """The row of a program that was run."""
    options = ReadOptions.of(case.machine, "linuxcnc")
    moves = read_commanded(Source.from_text(case.text(), f"{case.name}.ngc"), case.machine, options=options)
    linuxcnc_times(moves, case.machine)
    began = time.process_time()
    times = linuxcnc_times(moves, case.machine)
    spent = time.process_time() - began
    ours = float(times.sum() + moves.dwell[:-1].sum())
    theirs, log = min(((since_start(each, moves), each) for each in logs), key=lambda found: found[0])
    velocity, acceleration = usage(log, case.machine)
    figures = [f"{theirs:.3f}", f"{ours:.3f}", f"{100 * (ours / theirs - 1):+.3f}", f"{1e3 * spent:.0f}"]
    figures += [f"{velocity:.2f}", f"{acceleration:.2f}"]
    return f"| {' | '.join([case.name, case.whose, str(moves.blocks), *figures])} |"


def since_start(log: Log, moves: Commanded) -> float:
    """From where the path of the program starts to the last motion [s]."""
    moved = np.flatnonzero(np.any(np.diff(log.joints, axis=0) != 0.0, axis=1))
    begun = moved[log.line[moved + 1] >= moves.line[1]]
    return float(log.t[moved[-1] + 1] - log.t[begun[0]])


def usage(log: Log, machine: Machine) -> tuple[float, float]:
    """Largest velocity and acceleration of a joint over its limit."""
    joints, cycle = log.of(machine.joints), float(log.t[1] - log.t[0])
    velocity = np.abs(np.diff(joints, axis=0)).max(axis=0) / cycle / machine.limits.velocity
    acceleration = np.abs(np.diff(joints, 2, axis=0)).max(axis=0) / cycle**2 / machine.limits.acceleration
    return float(velocity.max()), float(acceleration.max())


def main(arguments: Iterable[str]) -> int:
    """Run, print each row, write the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", nargs="*", help="names of the programs to run; the rows of the others stay")
    parser.add_argument("--out", type=Path, default=RESULTS)
    parser.add_argument("--program", nargs="*", type=Path, help="files to run in place of these")
    parser.add_argument("--machine", default="linuxcnc-xyzac-trt", help="on which these are run")
    given = parser.parse_args(list(arguments))
    if given.program:
        machine = Machine.load(given.machine)
        for file in given.program:
            print(row(Case(file.name, OWN, file.read_text, machine)), flush=True)
        return 0
    rows = kept(given.out) if given.only else {}
    for case in cases():
        if given.only and case.name not in given.only:
            continue
        rows[case.name] = row(case)
        print(rows[case.name], flush=True)
        in_order = [rows[each.name] for each in cases() if each.name in rows]
        given.out.write_text(head() + "\n".join(in_order) + "\n", encoding="utf-8")
    return 0


def kept(page: Path) -> dict[str, str]:
    """Rows of a page by program."""
    lines = page.read_text(encoding="utf-8").splitlines() if page.exists() else []
    return {line.split("|")[1].strip(): line for line in lines if line.startswith("| ")}


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
