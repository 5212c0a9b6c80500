"""python -m testbed.linuxcnc.streams: G93 streams of all kinds, played by LinuxCNC; what came of each, as a table."""

from __future__ import annotations

import tempfile
from contextlib import redirect_stdout
from dataclasses import dataclass
from io import StringIO
from pathlib import Path

import numpy as np

from testbed.linuxcnc.streamed import PAD, Streamed, against, play_stream
from toolpace.cli import main as command
from toolpace.controls.export import PlannedMotion, export

HEAD = "G21 G90 G17 G94\n"
SHEET = 'units = { length = "mm", angle = "deg" }\ntools.1.length = 20\ntools.2.length = 35\n'


@dataclass(frozen=True)
class Case:
    program: str
    ms: float = 1.0
    tip: bool = False
    sheet: str = ""


THREE = HEAD + "G0 X10 Y-5 Z12\nG1 Z8 F900\nG1 X14 F1200\nX22\nX30 Y-2\nG3 X26 Y2 I-4 J0\nG1 X12 Y2 Z7\nM2\n"
TILTED = HEAD + "M428\nG0 X10 Y-5 Z12 A20 C30\nG1 Z8 F900\nX20 F1200\nY4\nG3 X14 Y10 I-6 J0\nG0 Z12\nM429\nM2\n"
FIVE = HEAD + "M428\nG0 X10 Y-5 Z12 A0 C0\nG1 Z8 F900\nX16 Y-2 A3 C6 F1200\nX20 Y2 A6 C10\nY6 A2 C4\nM429\nM2\n"
DWELLS = HEAD + "G0 X10 Y-5 Z12\nG4 P0.2\nG1 X16 F1200\nG4 P0.25\nY0\nG4 P0.1\nX12 Z10\nM2\n"
RETRACTS = HEAD + "G0 X10 Y-5 Z12\nG99 G81 Z6 R10 F600\nX16\nX20 Y0\nG80\nG0 Z12\nX12\nG1 Z9 F900\nX16 A5\nG0 Z12\nM2\n"
TOOLS = (
    HEAD + "T1 M6\nG43 H1\nM428\nG0 X10 Y-5 Z12 A0 C0\nG1 Z8 F900\nX16 Y-2 A3 C4 F1200\nM429\n"
    "T2 M6\nG43 H2\nM428\nY2 A12 C16\nX10 Z12\nM429\nM2\n"
)
STREAMS = {
    "three axes": Case(THREE), "three axes, 2 ms": Case(THREE, 2.0),
    "3+2, 2 ms": Case(TILTED, 2.0), "3+2 by the tip": Case(TILTED, tip=True),
    "five axes": Case(FIVE), "five axes by the tip, 2 ms": Case(FIVE, 2.0, True),
    "dwells": Case(DWELLS), "retracts, 2 ms": Case(RETRACTS, 2.0),
    "two tools": Case(TOOLS, sheet=SHEET), "two tools by the tip": Case(TOOLS, tip=True, sheet=SHEET),
}  # fmt: skip


def planned(case: Case, place: Path) -> PlannedMotion:
    """The plan; its stream is in the folder `out` of the place."""
    (place / "part.ngc").write_text(case.program)
    arguments = ["-m", "linuxcnc-xyzac-trt", "--effort", "low", "--no-report", "--dt", f"{case.ms:g}ms"]
    if case.sheet:
        (place / "sheet.toml").write_text(case.sheet)
        arguments += ["--setup", str(place / "sheet.toml")]
    assert command(["plan", str(place / "part.ngc"), *arguments, "--out", str(place / "plan")]) == 0
    export(place / "plan", "linuxcnc-g93", place / "out", tip=case.tip, pad=PAD)
    return PlannedMotion.load(place / "plan")


def played(case: Case, place: Path) -> tuple[PlannedMotion, tuple[str, ...], list[Streamed]]:
    """The plan, what LinuxCNC said, and how the stretches between changes of tools compare with the plan."""
    motion = planned(case, place)
    log = play_stream(place / "out", motion.machine, case.ms * 1e-3, tip=case.tip)
    assert log.ended
    rows = [slice(None)]
    if case.sheet:
        change = int(np.flatnonzero(np.diff(motion.setpoints.tool_length))[0])
        rows = [slice(0, change), slice(change + 1, None)]
    return motion, log.messages, [against(log, motion, each) for each in rows]


def main() -> None:
    print("| stream | set-points | cycle, ms | longer by, cycles | linear, µm | rotary, 1e-6 rad | use of limits |")
    print("|---|---|---|---|---|---|---|")
    for name, case in STREAMS.items():
        with tempfile.TemporaryDirectory() as folder, redirect_stdout(StringIO()):
            motion, _, found = played(case, Path(folder))
        worst = [max(getattr(each, kind) for each in found) for kind in ("cycles", "slides", "turns", "usage")]
        print(
            f"| {name} | {len(motion.setpoints.q)} | {case.ms:g} | {worst[0]} | {1e6 * worst[1]:.2f} |"
            f" {1e6 * worst[2]:.2f} | {worst[3]:.4f} |", flush=True,
        )  # fmt: skip


if __name__ == "__main__":
    main()
