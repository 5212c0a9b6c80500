"""`toolpace tolerance`: what a micrometre costs."""

from __future__ import annotations

import re

import msgspec
import pytest

from toolpace.cli import demo_programs, main
from toolpace.cli.commands.tolerance import Cost, apart, drawn, round_values, tolerance_page
from toolpace.results.write import read_plan


@pytest.fixture(scope="module")
def program(tmp_path_factory):
    file = tmp_path_factory.mktemp("tolerance") / "zigzag.ngc"
    ways = [f"G1 X{2 * k} Y{2 * (k % 2)} Z50 F6000" for k in range(12)]
    file.write_text("\n".join(["G21 G90 G94", *ways, "M30", ""]))
    return file


def test_a_row_a_tolerance_and_a_picture(program, tmp_path, capsys):
    picture = tmp_path / "costs.svg"
    given = ["tolerance", str(program), "-m", demo_programs.MACHINE, "--feed", "none", "--effort", "low"]
    assert main([*given, "--tips", "20um,5um", "--out", str(picture)]) == 0
    out = capsys.readouterr().out
    rows = re.findall(r"^ *([\d.]+ [µm]+) +([\d.]+ m?s) +([+-][\d.]+ %)", out, re.MULTILINE)
    assert [row[0] for row in rows] == ["5 µm", "0.01 mm", "0.02 mm"]
    seconds = [float(row[1].split()[0]) * (1e-3 if row[1].endswith("ms") else 1.0) for row in rows]
    assert seconds == sorted(seconds, reverse=True) and seconds[0] > seconds[-1]
    assert rows[1][2] == "+0.00 %"
    assert picture.read_text().startswith("<svg") and "zigzag.ngc" in picture.read_text()


def test_a_length_in_two_units_is_one_row(program, capsys):
    """10um and the usual 0.01mm differ by a rounding, which is no length to divide by."""
    given = ["tolerance", str(program), "-m", demo_programs.MACHINE, "--feed", "none", "--effort", "low"]
    assert main([*given, "--tips", "10um,0.02mm,20um,0.00001m"]) == 0
    out = capsys.readouterr().out
    rows = re.findall(r"^ *([\d.]+ [µm]+) +[\d.]+ m?s +", out, re.MULTILINE)
    assert rows == ["0.01 mm", "0.02 mm"] and " h " not in out
    assert [apart(tips, 1e-5) for tips in ([], [0.01 * 1e-3, 10 * 1e-6], [2e-5, 1.00005e-5, 5e-6])] == [
        [1e-5], [1e-5], [5e-6, 1e-5, 2e-5],
    ]  # fmt: skip


def test_what_is_no_tolerance_is_told_in_a_line(program, capsys):
    assert main(["tolerance", str(program), "-m", demo_programs.MACHINE, "--tips", "5um,soft"]) == 2
    assert capsys.readouterr().err.startswith("error: --tips: ")
    assert main(["tolerance", str(program), "-m", demo_programs.MACHINE, "--tips", "0um"]) == 2
    assert "--tips 0um: give a value from" in capsys.readouterr().err


def test_lines_of_the_picture_are_round_and_hold_all():
    for low, high in ((19.26, 22.9), (1.0, 1.0), (0.031, 0.047), (900.0, 1310.0)):
        values = round_values(low, high)
        assert values[0] <= low and values[-1] >= high and 2 <= len(values) <= 9
    found = drawn([Cost(1e-6, 2.0), Cost(1e-5, 1.0)], "a<b")
    assert "<polyline" in found and "a&lt;b" in found


@pytest.mark.sweep
def test_rows_lead_to_the_plans_that_are_there(program, tmp_path, capsys):
    folder = tmp_path / "plans"
    given = ["tolerance", str(program), "-m", demo_programs.MACHINE, "--feed", "none", "--effort", "low"]
    assert main([*given, "--tips", "30um", "--plans", str(folder)]) == 0
    assert {each.name for each in folder.iterdir()} == {"10um", "30um", "tolerance.html", "compared.html"}
    page, record = (folder / "tolerance.html").read_text(encoding="utf-8"), read_plan(folder / "30um")
    assert record.verified and record.tip_tolerance_mm == pytest.approx(0.03)
    links = re.findall(r'<a href="([^"]+)">', page)
    assert sorted(links) == ["10um/report.html", "30um/report.html", "compared.html"]
    assert all((folder / link).is_file() for link in links)
    assert f"{record.duration_s:.4g}"[:4] in capsys.readouterr().out
    (folder / "30um" / "report.html").unlink()
    found = [Cost(1e-5, 2.0, "10um"), Cost(3e-5, 1.0, "30um")]
    again = tolerance_page(folder, "<b>part</b>", "mill", found, found[0])
    assert "30um/report.html" not in again and "<b>part" not in again
    # what is there is not written over
    assert main([*given, "--plans", str(folder)]) == 2
    assert "--plans" in capsys.readouterr().err


OPERATIONS = """N10 G21 G90 G94 G64 P0.03
N20 T1 M6
N30 G0 X0 Y0 Z50
N40 G1 X4 Y4 F6000
N50 X8 Y0
N60 X12 Y4
N70 X16 Y0
N80 T2 M6
N90 X20 Y4
N100 X24 Y0
N110 X28 Y4
N120 X32 Y0
N130 M2
"""


@pytest.mark.parametrize(
    "asked, places, widest",
    [
        ("20um,T2:5um", "20um,T2:5um", 0.02),
        ("5um,N40-N60:15um", "5um,N40-N60:15um", 0.015),
        ("program,T2:5um", "10um,program,T2:5um", 0.03),
    ],
)
def test_tolerances_by_place_are_planned_told_and_judged(tmp_path, capsys, asked, places, widest):
    file, out = tmp_path / "two.ngc", tmp_path / "plan"
    file.write_text(OPERATIONS)
    given = [
        "plan",
        str(file),
        "-m",
        demo_programs.MACHINE,
        "--tip-tolerance",
        asked,
        "--effort",
        "low",
        "--controller",
        "linuxcnc",
    ]
    assert main([*given, "--out", str(out), "--no-report"]) == 0
    record = read_plan(out)
    assert record.tip_tolerances == places and record.axis_tolerances is None
    assert record.tip_tolerance_mm == pytest.approx(widest)
    assert 0.5 * widest < record.tip_deviation_mm <= widest * 1.001
    capsys.readouterr()
    assert main(["verify", str(out)]) == 0
    assert f"tip {places}" in " ".join(capsys.readouterr().out.split())
    wrong = msgspec.structs.replace(record, tip_tolerances="5um", tip_tolerance_mm=0.005)
    (out / "plan.json").write_bytes(msgspec.json.encode(wrong))
    assert main(["verify", str(out)]) == 1


def test_a_place_that_is_not_in_the_program_is_told_in_a_line(tmp_path, capsys):
    file = tmp_path / "two.ngc"
    file.write_text(OPERATIONS)
    out = str(tmp_path / "plan")
    given = ["plan", str(file), "-m", demo_programs.MACHINE, "--out", out, "--controller", "linuxcnc"]
    assert main([*given, "--tip-tolerance", "20um,T22:5um"]) == 2
    assert "tolerance of 'T22'" in (told := capsys.readouterr().err) and "did you mean 'T2'?" in told
    assert main([*given, "--tip-tolerance", "20um,T2:5"]) == 2
    assert "has no unit" in capsys.readouterr().err
    assert main(["tolerance", str(file), "-m", demo_programs.MACHINE, "--tip-tolerance", "20um,T2:5um"]) == 2
    assert "one for all here" in capsys.readouterr().err


@pytest.mark.parametrize(("asks", "places", "widest"), [(0.002, "10um,tighter", 0.002), (0.03, None, 0.01)])
def test_a_program_that_asks_for_less_is_planned_within_it_by_default(tmp_path, capsys, asks, places, widest):
    file, out = tmp_path / "two.ngc", tmp_path / "plan"
    file.write_text(OPERATIONS.replace("P0.03", f"P{asks}"))
    plan = ["plan", str(file), "-m", demo_programs.MACHINE, "--effort", "low", "--controller", "linuxcnc"]
    assert main([*plan, "--out", str(out), "--no-report"]) == 0
    record, told = read_plan(out), " ".join(capsys.readouterr().out.split())
    assert record.tip_tolerances == places and record.tip_tolerance_mm == pytest.approx(widest)
    assert 0.5 * widest < record.tip_deviation_mm <= widest * 1.001
    assert ("less where the program asks for less" in told) == (places is not None)
    assert main(["verify", str(out)]) == 0
