"""`toolpace cut`: what programs cut, as tables, JSON and a folder."""

from __future__ import annotations

import json

import numpy as np
import pytest

from tests.support.report_pages import calculated, embedded
from tests.support.tampering import Tamper, put, times
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


@pytest.mark.sweep
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
    assert "slot.ngc cuts</title>" in page and "http://" not in page.split("<script")[0]


@pytest.mark.parametrize(
    ("sheet", "words"),
    [
        ("[stock]\nbox = [[0, 0, -10], [20, 20, 0]]\n", "[tools.1] with kind, diameter"),
        ("[tools.1]\nlength = 120\n", "tool 1 tells no shape"),
        (SHEET.replace("[20, 20, 0]", "[-500, 20, 0]").replace("[[0,", "[[-900,"), "away from all moves at feed"),
        (SHEET + '[fixtures.vice]\nmesh = "vice.stl"\n', "vice.stl: cannot be read"),
        (SHEET.replace("[20, 20, 0]", "[20000, 20000, 0]"), "cells of 0.4 mm take "),
    ],
)
def test_what_the_sheet_lacks_is_one_line_with_the_cure_before_the_plan(folder, capsys, sheet, words):
    (folder / "lacks.toml").write_text(sheet)
    assert run(folder, "slot.ngc", sheet="lacks.toml") == 2
    said = capsys.readouterr()
    assert words in said.err and "\n" not in said.err.strip() and "planning" not in said.out


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
    from toolpace.cutting.stock.mesh_topology import box_triangles
    from toolpace.results.cut.folder import write_stl

    inch = 1e-3 / 25.4
    low, high = np.array([-8.0, 0.0, -10.0]), np.array([28.0, 20.0, 0.0])
    write_stl(folder / "inch.stl", box_triangles(low * inch, high * inch))
    (folder / "inch.toml").write_text('[stock]\nmesh = "inch.stl"\n' + SHEET[SHEET.index("[tools.1]") :])
    (folder / "near.ngc").write_text(SLOT.replace("Y10", "Y0.3"))
    run(folder, "near.ngc", "--json", sheet="inch.toml")
    assert capsys.readouterr().err.count("is it in inches?") == 1
@pytest.mark.sweep
def test_the_page_of_a_crash_leads_to_it_and_a_second_program_begins_with_what_the_first_left(folder, tmp_path):
    pytest.importorskip("pyarrow")
    place = tmp_path / "out"
    assert run(folder, "slot.ngc", "crash.ngc", "--out", str(place)) == 1
    text = (place / "cut-2.html").read_text(encoding="utf-8")
    data = embedded(text)
    (crash,) = data["findings"]
    assert crash["text"].startswith("line 5: rapid through") and 0.0 < crash["t"] < data["duration"]
    assert f'data-seek="{crash["t"]:.6f}">5</button>' in text
    left = calculated(
        text,
        """const stock = new Stock(player.workpiece.stock, player.arrays);
        return [0, stock.stages].map((stage) => {
            const { corners: c, triangles } = stock.surface(stage);
            let sum = 0;
            for (let k = 0; k < triangles.length; k += 3) {
                const at = (i) => Array.from(c.slice(3 * triangles[k + i], 3 * triangles[k + i] + 3));
                const [[a, b, d], [e, f, g], [h, i, j]] = [0, 1, 2].map(at);
                sum += a * (f * j - g * i) + b * (g * h - e * j) + d * (e * i - f * h);
            }
            return sum / 6;
        });""",
    )
    # mm3: the slot of the first program is there before the second, which goes as wide and twice as deep
    assert left[0] == pytest.approx(20 * 20 * 10 - 20 * 8 * 2, rel=0.005)
    assert left[1] == pytest.approx(20 * 20 * 10 - 20 * 8 * 4, rel=0.005)


def test_what_is_left_above_the_finished_part_is_told_and_is_no_collision(folder, capsys):
    (folder / "part.toml").write_text(SHEET + "[finished_part]\nbox = [[0, 0, -10], [20, 20, -1.5]]\n")
    assert run(folder, "slot.ngc", "--json", sheet="part.toml") == 1
    (found,) = json.loads(capsys.readouterr().out)
    # beside the slot all of the stock stands; in the slot the tool is half a millimetre too deep
    assert found["left_above_part_mm"] == pytest.approx(1.5, abs=1e-6)
    assert found["left_above_part_mm3"] == pytest.approx(20 * 12 * 1.5, rel=0.02)
    kinds = [each["kind"] for each in found["findings"]]
    assert kinds == ["gouge", "left", "left"] or kinds == ["gouge", "left"]
    left = found["findings"][1]
    assert left["line"] == 5 and left["in"] == "finished part" and left["depth_mm"] == pytest.approx(1.5, abs=1e-6)
    run(folder, "slot.ngc", sheet="part.toml")
    said = capsys.readouterr().out
    assert "near line 5: left above finished part, 1.5 mm high" in said and "left      at most 1.5 mm high" in said


def plan(folder, *words, sheet="sheet.toml", command="plan"):
    files = [str(folder / word) if word.endswith(".ngc") else word for word in words]
    return main([command, *files, "-m", MACHINE, "--setup", str(folder / sheet)])


def test_a_plan_shows_air_and_material_apart_where_the_sheet_names_a_stock(folder, capsys):
    assert plan(folder, "slot.ngc", "--effort", "low", "--out", str(folder / "plan"), "--no-report") == 0
    assert "at feed     in material" in capsys.readouterr().out
    figures = json.loads((folder / "plan" / "plan.json").read_text())
    assert run(folder, "slot.ngc", "--json") == 0
    (cut,) = json.loads(capsys.readouterr().out)
    found = figures["cut"]
    # the cells of 0.4 mm that this is cut with are passed in 8 ms
    assert found["air_s"] == pytest.approx(cut["air_s"], abs=0.02) and found["stock_mm3"] == cut["stock_mm3"]
    assert found["air_s"] + found["cutting_s"] + found["uncertain_s"] == pytest.approx(figures["cutting_s"], abs=1e-6)
    assert found["removed_mm3"] == pytest.approx(20 * 8 * 2, rel=0.01) and found["collisions"] == 0
    assert [each["tool"] for each in found["operations"]] == ["1"]


def test_a_plan_whose_air_was_changed_is_not_verified(folder, tmp_path, capsys):
    out = tmp_path / "plan"
    assert plan(folder, "slot.ngc", "--effort", "low", "--out", str(out), "--no-report") == 0
    tamper = Tamper(out)
    tamper.figures(put("cut/air_s", times(1.1)))
    code, said = tamper.verdict(capsys)
    assert code == 1 and "plan.json cut" in said


@pytest.mark.parametrize("sheet", ["tools.toml", "no-tool.toml"])
def test_a_plan_without_a_known_stock_or_its_tool_tells_nothing_of_air(folder, tmp_path, capsys, sheet):
    (folder / "no-tool.toml").write_text(SHEET[: SHEET.index("[tools.1]")])
    out = tmp_path / "plan"
    assert plan(folder, "slot.ngc", "--effort", "low", "--out", str(out), "--no-report", sheet=sheet) == 0
    said = capsys.readouterr().out
    assert "at feed" not in said and json.loads((out / "plan.json").read_text())["cut"] is None
    assert ("air and material are not told apart: " in said) == (sheet == "no-tool.toml")


def test_a_plan_says_that_there_are_collisions(folder, tmp_path, capsys):
    assert plan(folder, "crash.ngc", "--effort", "low", "--out", str(tmp_path / "plan"), "--no-report") == 0
    assert "1 collision with the stock or what is around it: see toolpace cut" in capsys.readouterr().out


def test_the_time_on_a_control_is_parted_into_air_and_material_and_the_next_program_cuts_what_is_left(folder, capsys):
    assert plan(folder, "slot.ngc", "slot.ngc", "--no-optimum", "--json", command="time") == 0
    first, again = json.loads(capsys.readouterr().out)
    cut = first["cut"]
    assert cut["air_s"] + cut["cutting_s"] + cut["uncertain_s"] == pytest.approx(first["cutting_s"], abs=1e-9)
    # in material from 3.46 mm before the stock, where the edge comes in beside the middle, to its end, at 50 mm/s
    assert cut["cutting_s"] == pytest.approx((20 + np.sqrt(4**2 - 2**2)) / 50, abs=0.05)
    assert again["cut"]["air_s"] == pytest.approx(again["cutting_s"]) and again["cut"]["removed_mm3"] == 0.0
    assert again["cut"]["stock_mm3"] == pytest.approx(cut["left_mm3"])


def test_a_batch_has_a_column_of_the_time_in_air(folder, tmp_path, capsys):
    out = tmp_path / "batch"
    assert plan(folder, "slot.ngc", "--workers", "0", "--what", "time", "--no-optimum", "--out", str(out),
                command="batch") == 0  # fmt: skip
    assert "in air" in capsys.readouterr().out and "In air" in (out / "batch.html").read_text()
    (row,) = json.loads((out / "batch.json").read_text())["jobs"]
    assert row["air_s"] + row["material_s"] == pytest.approx(0.81, abs=0.02)
