"""Loops without end are refused in seconds, in every dialect; long programs, and files called often, are not loops."""

from __future__ import annotations

import time

import pytest

from toolpace.cli import main
from toolpace.common.errors import ProgramError
from toolpace.machine.machine import Machine
from toolpace.programs.reading import Controller, Source, read_commanded, read_source
from toolpace.programs.reading.control import state
from toolpace.programs.reading.control.state import EndlessError
from toolpace.programs.reading.inspection import inspect_source
from toolpace.programs.reading.options import ReadOptions

START = "G90 G94\nG0 X0 Y0 Z0\n"
KLARTEXT = "0 BEGIN PGM A MM\n1 L X+0 Y+0 Z+0 FMAX\n2 LBL 1\n{}\n9 FN 9: IF +1 EQU +1 GOTO LBL 1\n10 END PGM A MM\n"
LOOPS = {
    "linuxcnc, counting": ("linuxcnc", "G21 " + START + "o1 while [1]\n#1=[#1+1]\nG1 X[#1] F500\no1 endwhile\nM2\n"),
    "linuxcnc, nothing": ("linuxcnc", "G21 " + START + "o1 while [1]\no1 endwhile\nM2\n"),
    "linuxcnc, splines": (
        "linuxcnc",
        "G21 " + START + "o1 while [1]\nG5 X10 Y0 I3 J10 P-3 Q10 F2000\nG1 X0 Y0\no1 endwhile\nM2\n",
    ),
    "fanuc, a jump": ("fanuc", "%\nO1\n" + START + "N10 G1 X1 F500\nX0\nGOTO 10\nM30\n%\n"),
    "fanuc, planes": (
        "fanuc",
        "%\nO1\n" + START + "WHILE [1 EQ 1] DO1\nG68.2 X0 Y0 Z0 I10 J20 K30\nG53.1\nX1\nG69\nEND1\nM30\n%\n",
    ),
    "fanuc, calls": ("fanuc", "%\nO1\n" + START + "M98 P2 L999999\nM30\nO2\nG1 X1 F100\nX0\nM99\n%\n"),
    "haas, holes": ("haas", "%\nO1\n" + START + "N1 G81 X1 Z-2 R1 F100\nX2\nG80\nGOTO 1\nM30\n%\n"),
    "mazak, a jump": ("mazak", "%\nO1\n" + START + "N10 G1 X1 F500\nX0\nGOTO 10\nM30\n%\n"),
    "iso, a loop": ("iso", "%\nO1\n" + START + "WHILE [1 EQ 1] DO1\nG1 X1 F100\nX0\nEND1\nM30\n%\n"),
    "sinumerik, counting": ("sinumerik", START + "LOOP\nR1=R1+1\nG1 X=R1 F500\nENDLOOP\nM30\n"),
    "sinumerik, frames": ("sinumerik", START + "LOOP\nTRANS X1\nROT X10\nG1 X1 F100\nENDLOOP\nM30\n"),
    "sinumerik, planes": (
        "sinumerik",
        START + 'LOOP\nCYCLE800(1,"",0,57,0,0,0,10,20,30,0,0,0,1)\nG1 X1 F100\nENDLOOP\nM30\n',
    ),
    "sinumerik, waiting": ("sinumerik", START + "AA: G4 F1\nGOTOB AA\nM30\n"),
    "heidenhain, a jump": ("heidenhain", KLARTEXT.format("3 L X+1 F500\n4 L X+0\n5 Q1 = Q1 + 1")),
    "heidenhain, planes": (
        "heidenhain",
        KLARTEXT.format("3 PLANE SPATIAL SPA+10 SPB+20 SPC+0 TURN FMAX\n4 L X+0 FMAX\n5 PLANE RESET TURN FMAX"),
    ),
    "heidenhain, repeats": (
        "heidenhain",
        KLARTEXT.format("3 L X+1 F500\n4 LBL 2\n5 L X+0\n6 CALL LBL 2 REP 65534\n7 CALL LBL 2 REP 65534"),
    ),
}
SECONDS = 20.0
"""Processor time; some 5 s on a core of its own."""


def read(dialect: str, text: str, most_blocks: int | None = None):
    options = ReadOptions(Controller.load(dialect), most_blocks=most_blocks)
    return read_commanded(Source.from_text(text, "part.nc"), Machine.load("xyzac-trunnion"), None, options)


@pytest.mark.parametrize(("dialect", "text"), LOOPS.values(), ids=LOOPS)
def test_a_loop_without_end_is_refused_with_the_cure(dialect, text, monkeypatch):
    monkeypatch.setattr(state, "REPEATED", 1000)
    with pytest.raises(
        EndlessError, match=r"^part\.nc:[0-9]+: [0-9]+ blocks have been executed of [0-9]+ lines: is th"
    ):
        read(dialect, text)
    with pytest.raises(EndlessError, match=r"more than 700 blocks .* --max-blocks N allows more"):
        read(dialect, text, most_blocks=700)


@pytest.mark.parametrize(
    "name",
    [
        pytest.param("linuxcnc, splines", marks=pytest.mark.sweep),
        pytest.param("sinumerik, planes", marks=pytest.mark.thorough),
    ],
)
def test_it_takes_seconds(name):
    began = time.process_time()
    with pytest.raises(EndlessError):
        read(*LOOPS[name])
    assert time.process_time() - began < SECONDS


def test_no_other_machine_is_tried(monkeypatch):
    monkeypatch.setattr(state, "REPEATED", 4000)
    machines = [Machine.load(name) for name in ("xyzac-trunnion", "xyzbc-head", "xyzbc-nutating")]
    dialect, text = LOOPS["sinumerik, counting"]
    tried = []
    monkeypatch.setattr(
        "toolpace.programs.reading.inspection.read_source",
        lambda source, machine, *rest, **more: tried.append(machine) or read_source(source, machine, *rest, **more),
    )
    found = inspect_source(Source.from_text(text), ReadOptions(Controller.load(dialect)), machines)
    assert len(tried) == 1 and len(found.not_on) == 3 and "blocks have been executed" in str(found.refused)


@pytest.mark.sweep
def test_a_long_program_is_no_loop_and_what_it_calls_counts_with_its_lines(tmp_path, monkeypatch):
    """A file beside the program of a thousand blocks, called thirty times, is a program for thirty parts."""
    monkeypatch.setattr(state, "REPEATED", 4000)
    body = "".join(f"G1 X{k % 7} F100\n" for k in range(1000))
    assert len(read("fanuc", "%\nO1\n" + START + 8 * body + "M30\n%\n")) > 6000
    part = tmp_path / "O0001.nc"
    (tmp_path / "O0002.nc").write_text("%\nO0002\n" + body + "M99\n%\n")
    calls = "M98 P2 L30\n"
    part.write_text("%\nO0001\n" + START + calls + "M30\n%\n")
    options = ReadOptions(Controller.load("fanuc"))
    assert len(read_source(Source.load(part), Machine.load("xyzac-trunnion"), None, options)) > 20_000
    part.write_text("%\nO0001\n" + START + "N1\n" + calls + "GOTO 1\nM30\n%\n")
    with pytest.raises(ProgramError, match="is there a loop without end"):
        read_source(Source.load(part), Machine.load("xyzac-trunnion"), None, options)


def test_the_command_says_it_in_one_line(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(state, "REPEATED", 4000)
    (tmp_path / "part.nc").write_text(LOOPS["fanuc, a jump"][1])
    assert main(["time", str(tmp_path / "part.nc"), "-m", "xyzac-trunnion"]) == 2
    error = capsys.readouterr().err
    assert "part.nc:6: " in error and "--max-blocks N allows more" in error and error.count("\n") == 1
