"""Controllers, set-up sheets and columns of one's own: they are printed, and a plan keeps those that it was read by."""

from __future__ import annotations

import json

import pytest

import toolpace as tp
from toolpace.cli import main
from toolpace.machine.machine import Machine
from toolpace.programs.reading.setup_file import load_setup

MINE = """\
name = "mine"
language = "word-address"
note = "a control of one's own"
"""


def test_controllers_are_listed_and_printed(tmp_path, capsys):
    path = tmp_path / "mine.toml"
    path.write_text("# why\n" + MINE)
    assert main(["controllers", str(path)]) == 0
    assert "a control of one's own" in capsys.readouterr().out
    assert main(["controllers", str(path), "--toml"]) == 0
    assert capsys.readouterr().out == "# why\n" + MINE
    assert main(["controllers"]) == 0
    assert main(["controllers", "--toml"]) == 2
    assert "needs the name of one controller" in capsys.readouterr().err


SHEET = """\
[part]
origin = [5, 0, 60]
[tools.1]
length = 120
[offsets.G54]
X = 0
"""


def test_a_table_without_a_header_is_planned_and_judged_by_the_columns_that_are_given(tmp_path, capsys):
    table, out = tmp_path / "points.txt", tmp_path / "out"
    table.write_text("0,0,50,0,0,1\n20,0,50,0,0,1\n20,30,50,0,0,1\n")
    asked = ["plan", str(table), "-m", "xyzac-trunnion", "--feed", "6000mm/min", "--out", str(out), "--no-report"]
    assert main(asked) == 2
    capsys.readouterr()
    assert main([*asked, "--columns", "x,y,z,i,j,k", "--units", "mm"]) == 0
    assert json.loads((out / "plan.json").read_text())["reading"]["columns"] == "x,y,z,i,j,k"
    table.unlink()
    capsys.readouterr()
    assert main(["verify", str(out)]) == 0
    assert "columns x,y,z,i,j,k, table in mm" in " ".join(capsys.readouterr().out.split())
    assert tp.Trajectory.load(out).tip(0.0)[0] == pytest.approx([0.0, 0.0, 0.05])
    assert main(["verify", str(out), "--units", "in"]) == 1


def test_a_plan_keeps_how_it_was_read_and_is_judged_by_it(tmp_path, capsys):
    sheet, mine, out = tmp_path / "setup.toml", tmp_path / "mine.toml", tmp_path / "out"
    sheet.write_text(SHEET)
    mine.write_text(MINE + '[meanings]\nG0 = "rapid"\nG1 = "feed"\nM30 = "end"\n')
    how = ["--setup", str(sheet), "--controller", str(mine), "--max-blocks", "100"]
    program = tmp_path / "short.ngc"
    program.write_text("G0 X0 Y0 Z50\nG1 X20 F6000\nG0 Z60\nM30\n")
    code = main(["plan", str(program), "-m", "xyzac-trunnion", "--out", str(out), "--no-report", *how])
    assert code == 0
    said = json.loads((out / "plan.json").read_text())
    assert said["reading"] == {
        "controller_file": "controller.toml", "setup_file": "setup.toml", "skip_unknown": False, "compensation": "",
        "max_blocks": 100, "lenient": False, "others": [], "columns": "", "units": "",
    }  # fmt: skip
    assert load_setup(out / "setup.toml").tools == load_setup(sheet).tools
    assert Machine.load(out / "machine.toml").file.chain.workpiece_origin == pytest.approx((0.005, 0, 0.06))
    for file in (sheet, mine, program):
        file.unlink()
    capsys.readouterr()
    assert main(["verify", str(out)]) == 0
    assert "by its set-up sheet, at most 100 blocks" in capsys.readouterr().out
    assert main(["verify", str(out), "--max-blocks", "2"]) == 2
    assert "more than 2 blocks" in capsys.readouterr().err
    for name in ("setup.toml", "controller.toml"):
        before = (out / name).read_text()
        (out / name).write_text(before + "# changed\n")
        assert main(["verify", str(out)]) == 1
        assert f"{name} was changed" in capsys.readouterr().out
        (out / name).unlink()
        assert main(["verify", str(out)]) == 2
        assert f"{name} is not there" in capsys.readouterr().err
        (out / name).write_text(before)
    assert main(["verify", str(out)]) == 0
