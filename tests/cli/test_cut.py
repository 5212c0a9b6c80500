"""`toolpace cut`: what programs cut, as tables, JSON and a folder."""

from __future__ import annotations

import json

import numpy as np
import pytest

from toolpace.cli import main

MACHINE = "xyzac-trunnion"
SLOT = """G90 G21 G94
T1 M6
G0 X-10 Y10 Z5
G0 Z-2
G1 X30 F3000
G0 Z5
M30
"""
CRASH = """G90 G21 G94
T1 M6
G0 X-10 Y10 Z5
G0 Z-4
G0 X30
G0 Z5
G1 X40 F3000
M30
"""
SHEET = """[stock]
box = [[0, 0, -10], [20, 20, 0]]
uncertainty = 0
[tools.1]
kind = "flat"
diameter = 8
flute_length = 10
teeth = 3
stick_out = 30
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("cut")
    for name, text in (("slot.ngc", SLOT), ("crash.ngc", CRASH), ("sheet.toml", SHEET)):
        (place / name).write_text(text)
    (place / "tools.toml").write_text(SHEET[SHEET.index("[tools.1]") :])
    return place


def run(folder, *words, sheet="sheet.toml"):
    files = [str(folder / word) if word.endswith(".ngc") else word for word in words]
    given = ["-m", MACHINE, "--setup", str(folder / sheet), "--effort", "low", "--resolution", "0.4mm"]
    return main(["cut", *files, *given])


def test_json_has_what_the_contract_says(folder, capsys):
    assert run(folder, "slot.ngc", "--json") == 0
    (found,) = json.loads(capsys.readouterr().out)
    assert found["stock_mm3"] == pytest.approx(20 * 20 * 10, rel=1e-3)
    assert found["removed_mm3"] == pytest.approx(20 * 8 * 2, rel=0.01)
    assert found["removed_mm3"] + found["left_mm3"] == pytest.approx(found["stock_mm3"], rel=1e-3)
    assert 0.0 < found["resolution_mm"] <= 0.4 and not found["stock_guessed"]
    (operation,) = found["operations"]
    assert operation["tool"] == "1"
    assert operation["width_mm"] == pytest.approx(8.0, abs=0.4) and operation["depth_mm"] == pytest.approx(2.0, abs=0.4)
    # 4 mm of radius before and behind 20 mm, of 40 mm at 50 mm/s but for the ramps
    assert operation["cutting_s"] == pytest.approx(0.5, abs=0.08)
    assert operation["air_s"] > 0.1
    assert found["findings"] == []


def test_a_rapid_through_the_stock_ends_with_one(folder, capsys):
    assert run(folder, "crash.ngc", "--json") == 1
    (found,) = json.loads(capsys.readouterr().out)
    worst = found["findings"][0]
    assert (worst["kind"], worst["line"], worst["in"]) == ("rapid", 5, "stock")
    assert worst["depth_mm"] == pytest.approx(4.0, abs=0.4)
    assert 0.0 <= worst["place_mm"][0] <= 20.0
    assert [each["kind"] for each in found["findings"]] == ["rapid", "air"]


def test_the_page_says_the_collision_in_words(folder, capsys):
    assert run(folder, "crash.ngc") == 1
    out = capsys.readouterr().out
    assert "line 5: rapid through stock, " in out and "may not be seen" in out
    assert "in air" in out


def test_the_stock_left_by_one_program_is_that_of_the_next(folder, capsys):
    assert run(folder, "slot.ngc", "slot.ngc", "--json") == 0
    first, second = json.loads(capsys.readouterr().out)
    assert second["stock_mm3"] == pytest.approx(first["left_mm3"], rel=1e-9)
    assert second["removed_mm3"] < 0.01 * first["removed_mm3"]


def test_a_guessed_stock_is_marked_and_concludes_nothing(folder, capsys):
    assert run(folder, "crash.ngc", sheet="tools.toml") == 0
    assert "GUESSED" in capsys.readouterr().out
    assert run(folder, "crash.ngc", "--json", sheet="tools.toml") == 0
    (found,) = json.loads(capsys.readouterr().out)
    assert found["stock_guessed"] and found["findings"] == []


def test_the_folder_has_engagement_stock_figures_and_a_page(folder, tmp_path, capsys):
    parquet = pytest.importorskip("pyarrow.parquet")
    place = tmp_path / "out"
    for _ in range(2):
        # the second takes the place of the first
        assert run(folder, "slot.ngc", "--out", str(place)) == 0
    assert {each.name for each in place.iterdir()} == {
        "cut.json", "engagement.parquet", "stock-1-1.stl", "cut-1.html",
    }  # fmt: skip
    (record,) = json.loads((place / "cut.json").read_text())["programs"]
    table = parquet.read_table(place / "engagement.parquet")
    assert np.sum(table["removed_mm3"].to_numpy()) == pytest.approx(record["removed_mm3"])
    assert max(max(each, default=0.0) for each in table["exit"].to_pylist()) > 1.0
    raw = (place / "stock-1-1.stl").read_bytes()
    assert len(raw) == 84 + 50 * int.from_bytes(raw[80:84], "little")
    corners = np.frombuffer(raw[84:], dtype=np.dtype("(3,)<f4, (3, 3)<f4, <u2"))["f1"].astype(float)
    volume = np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6.0
    assert volume == pytest.approx(record["left_mm3"], rel=0.02)
    page = (place / "cut-1.html").read_text()
    assert "holder is not told" in page.split("<script")[0]
    assert "What the tool cuts" in page and "http://" not in page.split("<script")[0]


@pytest.mark.parametrize(
    ("sheet", "words"),
    [
        ("[stock]\nbox = [[0, 0, -10], [20, 20, 0]]\n", "[tools.1] with kind, diameter"),
        ("[tools.1]\nlength = 120\n", "tool 1 tells no shape"),
        (SHEET.replace("[20, 20, 0]", "[-500, 20, 0]").replace("[[0,", "[[-900,"), "away from all moves at feed"),
    ],
)
def test_what_the_sheet_lacks_is_one_line_with_the_cure(folder, capsys, sheet, words):
    (folder / "lacks.toml").write_text(sheet)
    assert run(folder, "slot.ngc", sheet="lacks.toml") == 2
    error = capsys.readouterr().err.strip()
    assert words in error and "\n" not in error


@pytest.mark.parametrize(
    ("option", "value"), [("--resolution", "0"), ("--resolution", "1m"), ("--memory", "5"), ("--memory", "-1GB")]
)
def test_sizes_that_make_no_sense_are_refused(folder, capsys, option, value):
    assert main(["cut", str(folder / "slot.ngc"), "-m", MACHINE, option, value]) == 2
    assert option in capsys.readouterr().err


def test_the_unit_that_was_assumed_is_said_beside_the_figures(folder, capsys):
    """A program of inches without G20 removes a fraction of what is meant: the reason has to be there."""
    (folder / "unit.ngc").write_text("O1234\nG90 G94\nT1 M6\nG0 X-10 Y10 Z5\nG1 Z-2 F3000\nX30\nG0 Z5\nM30\n")
    assert run(folder, "unit.ngc", "--json", "--controller", "fanuc") == 0
    (found,) = json.loads(capsys.readouterr().out)
    assert any("unit of lengths" in sentence for sentence in found["assumed"])


def test_files_of_the_stock_are_numbered_as_the_rows_of_the_table(folder, capsys):
    """Before its first tool a program has an operation that cuts nothing: it is no row."""
    (folder / "late.ngc").write_text(SLOT.replace("T1 M6\n", "G0 Z50\nT1 M6\n"))
    place = folder / "late"
    assert run(folder, "late.ngc", "--out", str(place)) == 0
    out = capsys.readouterr().out
    assert sorted(each.name for each in place.glob("stock-*")) == ["stock-1-1.stl"]
    assert "names no tool" not in out


def test_a_question_of_the_stock_s_unit_is_asked_once(folder, capsys):
    from toolpace.cutting.stock.dexels import _box_triangles
    from toolpace.results.cut.folder import write_stl

    inch = 1e-3 / 25.4
    low, high = np.array([-8.0, 0.0, -10.0]), np.array([28.0, 20.0, 0.0])
    write_stl(folder / "inch.stl", _box_triangles(low * inch, high * inch))
    (folder / "inch.toml").write_text('[stock]\nmesh = "inch.stl"\n' + SHEET[SHEET.index("[tools.1]") :])
    (folder / "near.ngc").write_text(SLOT.replace("Y10", "Y0.3"))
    run(folder, "near.ngc", "--json", sheet="inch.toml")
    assert capsys.readouterr().err.count("is it in inches?") == 1
