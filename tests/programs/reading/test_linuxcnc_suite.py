"""The table of a folder of LinuxCNC's programs, each read by us and by its own interpreter."""

from __future__ import annotations

import pytest

from testbed.linuxcnc.rs274 import available
from testbed.linuxcnc.suite import main, reason, tools

HEAD = "G21 G90 G94 F600\n"
PROGRAMS = {
    "plain.ngc": HEAD + "G0 X1 Y1 Z1\nG1 X5\nM2\n",
    "below/calls.ngc": HEAD + "o<part> call [3]\nT1 M6 G43\nG1 Z5\nM2\n",
    "below/contour.ngc": HEAD + "G41 D1\nG1 X9 Y3\nX30\nG40 X40\nM2\n",
    "below/part.ngc": "o<part> sub\nG1 X#1 Y1 Z1\no<part> endsub\n",
    "endless.ngc": HEAD + "G0 X1 Y1 Z1\nG1 X5\n",
    "probing.ngc": HEAD + "G0 X1\nG38.2 Z-5\nM2\n",
    "lathe.ngc": HEAD + "G7 G0 X1\nM2\n",
}


@pytest.fixture
def folder(tmp_path):
    for name, text in PROGRAMS.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text)
    (tmp_path / "below" / "mill.tbl").write_text("T1 P1 Z2.5 D0.25 ; D7, a cutter\nT2 P2 D1\n")
    return tmp_path


@pytest.mark.linuxcnc
@pytest.mark.skipif(available() is None, reason="LinuxCNC's interpreter rs274 is not installed")
def test_each_kind_is_counted(folder, capsys):
    assert main([str(folder), "--list", "refused by us only"]) == 0
    said = capsys.readouterr().out
    assert "lathe.ngc: refused by us only: " in said
    for row in (
        "| same |  | 3 | calls.ngc |", "| refused by us only | lathes (G7, G70 to G72) | 1 | lathe.ngc |",
        "| refused by both, the same up to an end that is missing |  | 2 | part.ngc |",
        "| not told by rs274 |  | 1 | probing.ngc |",
    ):  # fmt: skip
        assert row in said


@pytest.mark.linuxcnc
@pytest.mark.skipif(available() is None, reason="LinuxCNC's interpreter rs274 is not installed")
def test_a_program_that_moves_elsewhere_is_told(folder, capsys, monkeypatch):
    wrong = "testbed.against_rs274.judged"
    from testbed.linuxcnc.rs274 import judged

    monkeypatch.setattr(wrong, lambda text, *tables, **more: judged(text.replace("X5", "X6"), *tables, **more))
    assert main([str(folder)]) == 1
    assert "plain.ngc: different: motion 1" in capsys.readouterr().out


def test_the_one_tool_table_is_in_inches(folder):
    assert tools(folder / "below") == {1: pytest.approx({"Z": 63.5, "D": 6.35}), 2: {"D": 25.4}}
    assert tools(folder)[7] == {}


def test_a_refusal_of_another_kind_is_told_as_such():
    assert reason("part.ngc:1: the sky is blue") == "another error"
