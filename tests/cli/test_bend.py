"""`toolpace plan --bend`: compensated, archived, verified again from the files alone; what was changed is found."""

from __future__ import annotations

import hashlib
import json
import shutil

import numpy as np
import pytest

from tests.support.bending import PROGRAM, TOOL_FILE, TOOL_OF_STOCK
from tests.support.set_up_sheets import milling_sheet
from tests.support.tampering import Tamper, fails, put, times
from toolpace.cli import main


@pytest.fixture(scope="module")
def plan(tmp_path_factory):
    folder = tmp_path_factory.mktemp("bend")
    (folder / "slot.nc").write_text(PROGRAM)
    (folder / "my-tool.toml").write_text("# mine\n" + TOOL_FILE)
    out = folder / "out"
    asked = ["plan", str(folder / "slot.nc"), "-m", "xyzac-trunnion", "--out", str(out)]
    assert main([*asked, "--bend", str(folder / "my-tool.toml")]) == 0
    return out


@pytest.fixture
def again(plan, tmp_path):
    folder = tmp_path / "copy"
    shutil.copytree(plan, folder)
    return Tamper(folder)


def test_the_plan_says_that_and_how_much_bending_is_compensated(plan):
    said = json.loads((plan / "plan.json").read_text())
    kept = (plan / "tool.toml").read_bytes()
    assert kept.startswith(b"# mine\n")
    bending = said["bending"]
    assert bending["tool_file"] == "tool.toml" and bending["sha256"] == hashlib.sha256(kept).hexdigest()
    assert 0.05 < bending["largest_mm"] < 0.15 and 0.0 <= bending["change_um"] <= 1.0 and bending["rounds"] >= 1
    assert said["verified"] is True and said["tip_deviation_mm"] <= 0.01
    assert "Bending compensated" in (plan / "report.html").read_text()


def test_it_is_verified_from_the_files_alone(again, capsys):
    code, said = again.verdict(capsys)
    assert code == 0 and "VERIFIED" in said and "the tool bent as tool.toml says" in said
    assert "bending of the tool" in said and "plan.json bending largest_mm" in said


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (put("bending", None), "nothing of a tool that bends, and tool.toml is there"),
        (put("bending/largest_mm", times(1.05)), "bending largest_mm"),
        (put("bending/change_um", 3.0), "bending change_um"),
        (put("bending/rounds", -1), "bending change_um, rounds"),
        (put("bending/sha256", "0" * 64), "not the tool file that the plan was made with"),
        (put("bending/tool_file", "../my-tool.toml"), "tool_file"),
    ],
)
def test_a_changed_figure_fails(again, capsys, change, words):
    again.figures(change)
    fails(again, capsys, words)


def test_another_tool_is_found_out_even_with_its_own_checksum(again, capsys):
    softer = TOOL_FILE.replace("580GPa", "400GPa").encode()
    (again.folder / "tool.toml").write_bytes(softer)
    fails(again, capsys, "not the tool file")
    again.figures(put("bending/sha256", hashlib.sha256(softer).hexdigest()))
    fails(again, capsys, "tip, ")


def test_a_tool_file_taken_away_is_missed(again, capsys):
    (again.folder / "tool.toml").unlink()
    fails(again, capsys, "tool.toml is not there")


def test_set_points_are_exported_and_the_text_of_the_program_is_not(plan, tmp_path, capsys):
    assert main(["export", str(plan), "--to", "table", "--out", str(tmp_path / "table")]) == 0
    assert main(["export", str(plan), "--to", "program", "--out", str(tmp_path / "program")]) == 2
    assert "compensated for the bending of the tool" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("tool", "options", "says"),
    [
        (TOOL_FILE.replace("teeth", "teth"), [], "tool.toml: [tool] has the unknown key 'teth'; did you mean 'teeth'?"),
        (TOOL_FILE, ["--feed", "none"], "have no feed"),
        (TOOL_FILE, ["--dt", "50ms"], "--dt: at 1500 mm/min set-points are 1.25 mm apart"),
        (None, [], "tool.toml: cannot be read"),
    ],
)
def test_what_is_wrong_is_one_line_and_leaves_nothing(tmp_path, capsys, tool, options, says):
    (tmp_path / "slot.nc").write_text(PROGRAM)
    if tool is not None:
        (tmp_path / "tool.toml").write_text(tool)
    asked = ["plan", str(tmp_path / "slot.nc"), "-m", "xyzac-trunnion", "--out", str(tmp_path / "out")]
    assert main([*asked, "--bend", str(tmp_path / "tool.toml"), *options]) == 2
    error = capsys.readouterr().err.strip()
    assert says in error and "\n" not in error and not (tmp_path / "out").exists()


WALL = """G21 G90 G94
T1 M6
S18000 M3
G0 X-5 Y1.4 Z20 A0 C0
G0 Z-3
G1 X15 F1500
G0 Z20
M30
"""
SHEET = milling_sheet([(0, -8, -6), (10, 0, 0)], 4, 12, 40, teeth=2, helix=30)


@pytest.fixture(scope="module")
def wall(tmp_path_factory):
    folder = tmp_path_factory.mktemp("wall")
    (folder / "wall.nc").write_text(WALL)
    (folder / "sheet.toml").write_text(SHEET)
    (folder / "tools.toml").write_text(SHEET[SHEET.index("[tools.1]") :])
    (folder / "tool.toml").write_text(TOOL_OF_STOCK)
    assert planned(folder, "sheet.toml", "--out", str(folder / "out"), "--no-report") == 0
    return folder


def planned(folder, sheet, *words):
    asked = ["plan", str(folder / "wall.nc"), "-m", "xyzac-trunnion", "--setup", str(folder / sheet), *words]
    return main([*asked, "--bend", str(folder / "tool.toml")])


@pytest.mark.sweep
def test_a_tool_bends_by_what_it_cuts_of_the_stock_and_the_judge_agrees(wall, tmp_path, capsys):
    folder = tmp_path / "out"
    shutil.copytree(wall / "out", folder)
    bending = json.loads((folder / "plan.json").read_text())["bending"]
    assert bending["engaged_file"] == "engaged.npz" and 0.05 < bending["largest_mm"] < 0.15
    code, said = Tamper(folder).verdict(capsys)
    assert code == 0 and "VERIFIED" in said and "plan.json bending largest_mm" in said
    # beside the wall the command is shifted towards it by what the judge works out from the file, and the tip is stiff
    with np.load(folder / "setpoints.npz") as points:
        assert points["tip"][:, 1].min() == pytest.approx(1.4e-3 - 1e-3 * bending["largest_mm"], abs=12e-6)


@pytest.mark.parametrize("name", ["slope", "constant"])
def test_a_changed_deflection_along_the_program_is_found(wall, tmp_path, capsys, name):
    folder = tmp_path / "out"
    shutil.copytree(wall / "out", folder)
    with np.load(folder / "engaged.npz") as arrays:
        figures = dict(arrays)
    figures[name] = 2.0 * figures[name]
    np.savez_compressed(folder / "engaged.npz", **figures)
    tamper = Tamper(folder)
    tamper.seal()
    code, said = tamper.verdict(capsys)
    assert code == 1 and "FAILED" in said


def test_a_stock_that_no_sheet_names_is_asked_for(wall, tmp_path, capsys):
    assert planned(wall, "tools.toml", "--out", str(tmp_path / "out")) == 2
    assert 'milling = "stock", and no set-up sheet names one' in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_a_folder_without_the_deflection_along_the_program_is_refused(wall, tmp_path, capsys):
    folder = tmp_path / "out"
    shutil.copytree(wall / "out", folder)
    (folder / "engaged.npz").write_bytes(b"no archive")
    tamper = Tamper(folder)
    tamper.seal()
    assert main(["verify", str(folder)]) == 2
    assert "engaged.npz: cannot be read" in capsys.readouterr().err
