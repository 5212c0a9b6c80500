"""Bad input: exit code 2, one line with place and cure, nothing left behind, no traceback."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

from toolpace.cli import demo_programs, main
from toolpace.machine.machine import Machine

START = "G21 G90 G94 G43.4 H1\nG0 X0 Y0 Z0 A0 C0\n"
CL = "UNITS/MM\nFEDRAT/100,MMPM\nGOTO/0,0,0,0,0,1\n"

PROGRAMS = {
    "truncated": ("part.ngc", None, r"part\.ngc:\d+: .*cut off.*export it again"),
    "binary": ("part.ngc", bytes(range(256)) * 16, r"part\.ngc: .*binary file.*export"),
    "empty": ("part.ngc", b"", r"part\.ngc: the file is empty"),
    "no number": ("part.ngc", START + "G1 Xnan F100\n", r"part\.ngc:3: .*in 'G1 Xnan F100'"),
    "feed of zero": ("part.ngc", START + "G1 X10 F0\n", r"part\.ngc:3: feed missing: no F above zero"),
    "feed missing": ("part.ngc", START + "G1 X10\n", r"part\.ngc:3: feed missing.*write one, or give --feed"),
    "zero tool axis": ("part.cls", CL + "GOTO/9,0,0,0,0,0\n", r"part\.cls:4: the tool axis i, j, k is zero: give"),
    "tilt out of travel": (
        "part.cls",
        CL + "GOTO/9,0,0,0,0.5,-0.8660254\nGOTO/19,0,0,0,0.5,-0.8660254\n",
        r"part\.cls:4: the tool axis needs .*A -130 \.\. 130 deg.*mount the part otherwise",
    ),
    "travel exceeded": (
        "part.ngc",
        START + "G1 X10 F500\nG1 X600\nG1 X10\nM2\n",
        r"part\.ngc:4: joint X would have to go to 600\.000 mm, above its limit of 500 mm.*move the part",
    ),
    "no motion": ("part.ngc", START + "M2\n", r"part\.ngc: there is no motion"),
}


def fails(capsys, tmp_path, arguments, pattern):
    """The command fails as it should; its one line is returned."""
    before = sorted(tmp_path.rglob("*"))
    assert main(arguments) == 2
    output = capsys.readouterr()
    assert output.err.count("\n") == 1 and output.err.startswith("error: ")
    assert "Traceback" not in output.err + output.out and "fault in toolpace" not in output.err
    assert re.search(pattern, output.err), output.err
    assert sorted(tmp_path.rglob("*")) == before
    return output.err


@pytest.mark.parametrize("case", PROGRAMS)
def test_bad_program(case, tmp_path, monkeypatch, capsys):
    name, content, pattern = PROGRAMS[case]
    if case == "truncated":
        content = demo_programs.spiral_program(300)[:9000]
    if isinstance(content, str):
        content = content.encode()
    monkeypatch.chdir(tmp_path)
    (tmp_path / name).write_bytes(content)
    fails(capsys, tmp_path, ["plan", name, "--machine", "xyzac-trunnion", "--out", "out"], pattern)


def test_unreachable_tilt(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "part.cls").write_text(CL + "GOTO/9,0,0,0,1,0\nGOTO/19,0,0,0,0.6,-0.8\n")
    fails(
        capsys,
        tmp_path,
        ["plan", "part.cls", "-m", "xyzbc-nutating"],
        r"part\.cls:5: .*(unreachable tilt|needs).*take another machine",
    )


MACHINES = {
    "limit of zero": ("velocity = 500", "velocity = 0", r"X.*velocity"),
    "limit missing": ("jerk = 50000\n", "", r"X.*jerk"),
    "misspelt key": ("acceleration = 5000", "accelleration = 5000", r"accelleration.*did you mean 'acceleration'"),
    "misspelt table": ("[units]", "[unit]", r"unit.*did you mean 'units'"),
    "not TOML": ("[chain]", "[chain", r"not a TOML file"),
    "not a number": ("jerk = 50000", 'jerk = "50000"', r"X.*jerk"),
}


@pytest.mark.parametrize("case", MACHINES)
def test_bad_machine_file(case, tmp_path, monkeypatch, capsys):
    old, new, pattern = MACHINES[case]
    folder = Path(sys.modules["toolpace.machine"].__file__).parent / "builtin"
    text = (folder / "xyzac-trunnion.toml").read_text()
    assert old in text
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mill.toml").write_text(text.replace(old, new, 1))
    (tmp_path / "part.ngc").write_text(START + "G1 X10 F500\n")
    line = fails(capsys, tmp_path, ["plan", "part.ngc", "--machine", "mill.toml"], pattern)
    assert "mill.toml" in line


def test_unknown_machine_lists_the_known(tmp_path, capsys):
    line = fails(capsys, tmp_path, ["plan", "part.ngc", "-m", "xyzac-trunion"], "did you mean 'xyzac-trunnion'")
    assert all(name in line for name in Machine.names())


ARGUMENTS = {
    "machine missing": (["plan", "part.ngc"], r"--machine is missing.*xyzac-trunnion.*machine file"),
    "program missing": (["plan"], r"PROGRAM is missing.*toolpace plan --help"),
    "no such program": (["plan", "prat.ngc", "-m", "paper-ab"], r"prat\.ngc: no such file; did you mean part\.ngc"),
    "misspelt command": (["paln"], r'Did you mean "plan"'),
    "misspelt option": (["plan", "part.ngc", "--machin", "paper-ab"], r"Did you mean --machine"),
    "misspelt planner": (
        ["plan", "part.ngc", "-m", "paper-ab", "--planner", "optimum"],
        r"unknown planner 'optimum'; did you mean 'optimal'\? known are optimal, genetic",
    ),
    "no unit": (["plan", "part.ngc", "-m", "paper-ab", "--tip-tolerance", "0.01"], r"no unit.*0\.01mm"),
    "no tolerance": (["plan", "part.ngc", "-m", "paper-ab", "--tip-tolerance", "0mm"], r"give more than zero"),
    "no such side": (["plan", "part.ngc", "-m", "paper-ab", "--side", "otside"], r"did you mean 'outside'"),
    "a side for many": (["tolerance", "part.ngc", "-m", "paper-ab", "--side", "above"], r"on one side, it goes with"),
    "no feed": (["plan", "part.ngc", "-m", "paper-ab", "--feed", "fast"], r"'fast'.*3000mm/min.*120%.*none"),
    "time step": (["plan", "part.ngc", "-m", "paper-ab", "--dt", "0ms"], r"above zero"),
    "too much": (["plan", "part.ngc", "more", "-m", "paper-ab"], r"too many arguments: more"),
    "value missing": (["plan", "part.ngc", "--machine"], r"--machine needs a value"),
    "out is a file": (["plan", "part.ngc", "-m", "paper-ab", "--out", "part.ngc"], r"is a file; give a folder"),
    "no plan there": (["verify", "nowhere"], r"nowhere: no such folder.*toolpace plan"),
    "not a plan": (["verify", "."], r"plan\.json: no such file"),
    "whose file": (["machines", "--toml"], r"--toml needs the name"),
    "whose poses": (["machines", "--poses"], r"--poses needs the name .* toolpace machines xyzac-trunnion --poses"),
    "file and poses": (["machines", "paper-ab", "--toml", "--poses"], r"--toml and --poses: one at a time"),
}


@pytest.mark.parametrize("case", ARGUMENTS)
def test_bad_arguments(case, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "part.ngc").write_text(START + "G1 X10 F500\n")
    fails(capsys, tmp_path, *ARGUMENTS[case])


@pytest.mark.sweep
def test_process_ends_with_the_code_and_one_line(tmp_path):
    done = subprocess.run(
        [sys.executable, "-m", "toolpace", "plan", "nope.ngc", "-m", "paper-ab"],
        capture_output=True,
        text=True,
        cwd=tmp_path,
        timeout=600,
    )
    assert done.returncode == 2
    assert done.stderr == "error: nope.ngc: no such file; check the path\n"


def test_fault_of_our_own_is_one_line(monkeypatch, capsys):
    monkeypatch.delenv("TOOLPACE_DEBUG", raising=False)
    monkeypatch.setattr(Machine, "names", lambda: 1 / 0)
    assert main(["machines"]) == 2
    assert capsys.readouterr().err == (
        "error: a fault in toolpace itself, ZeroDivisionError: division by zero; TOOLPACE_DEBUG=1 shows where\n"
    )


@pytest.mark.parametrize("wrapped", [False, True], ids=["plain", "met by compiled code"])
def test_interrupt_ends_with_130(wrapped, monkeypatch, capsys):
    def interrupted() -> tuple[str, ...]:
        if wrapped:
            raise SystemError from KeyboardInterrupt()
        raise KeyboardInterrupt

    monkeypatch.setattr(Machine, "names", interrupted)
    assert main(["machines"]) == 130
    assert capsys.readouterr().err == "error: interrupted; nothing was written\n"
