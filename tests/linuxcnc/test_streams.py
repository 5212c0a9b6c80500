"""G93 streams played by the real LinuxCNC, under their guard and the machine's own limits."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from testbed.linuxcnc.streamed import PAD, Streamed, against, play_stream
from toolpace.cli import main
from toolpace.exporting import PlannedMotion, export

HEAD = "G21 G90 G17 G94\n"
SHEET = 'units = { length = "mm", angle = "deg" }\ntools.1.length = 20\ntools.2.length = 35\n'
MICROMETRE = 1e-6
REACH = 0.1
"""Distance from an axis at which two micrometres are asked of what turns [m]."""


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
}  # fmt: skip


def planned(case, place):
    """The folder of an export, and the plan."""
    (place / "part.ngc").write_text(case.program)
    arguments = ["-m", "linuxcnc-xyzac-trt", "--effort", "low", "--no-report", "--dt", f"{case.ms:g}ms"]
    if case.sheet:
        (place / "sheet.toml").write_text(case.sheet)
        arguments += ["--setup", str(place / "sheet.toml")]
    assert main(["plan", str(place / "part.ngc"), *arguments, "--out", str(place / "plan")]) == 0
    export(place / "plan", "linuxcnc-g93", place / "out", tip=case.tip, pad=PAD)
    return PlannedMotion.load(place / "plan")


def near(found: Streamed):
    assert abs(found.cycles) <= 1
    assert found.slides < 2.0 * MICROMETRE and found.turns < 2.0 * MICROMETRE / REACH
    assert found.usage <= 1.01


@pytest.mark.linuxcnc
@pytest.mark.sweep
@pytest.mark.parametrize("name", STREAMS)
def test_a_stream_takes_the_time_of_the_plan_and_every_joint_is_where_it_says(name, tmp_path):
    case = STREAMS[name]
    motion = planned(case, tmp_path)
    log = play_stream(tmp_path / "out", motion.machine, case.ms * 1e-3, tip=case.tip)
    assert log.ended and not log.messages
    near(against(log, motion))


@pytest.mark.linuxcnc
@pytest.mark.sweep
@pytest.mark.parametrize("tip", [False, True])
def test_a_stream_of_two_tools_waits_between_them(tip, tmp_path):
    """The sheet's tools are 20 and 35 mm, the machine's own has none; by the tip, LinuxCNC's kinematics do the rest."""
    motion = planned(Case(TOOLS, tip=tip, sheet=SHEET), tmp_path)
    log = play_stream(tmp_path / "out", motion.machine, 1e-3, tip=tip)
    assert log.ended and log.messages == ("toolpace: put in tool 2, then go on",)
    change = int(np.flatnonzero(np.diff(motion.setpoints.tool_length))[0])
    for rows in (slice(0, change), slice(change + 1, None)):
        near(against(log, motion, rows))
