"""`toolpace tolerance`: what a micrometre costs."""

from __future__ import annotations

import re

import pytest

from toolpace import demo
from toolpace.cli import main
from toolpace.cli.tolerance.picture import drawn, round_values


@pytest.fixture(scope="module")
def program(tmp_path_factory):
    file = tmp_path_factory.mktemp("tolerance") / "zigzag.ngc"
    ways = [f"G1 X{2 * k} Y{2 * (k % 2)} Z50 F6000" for k in range(12)]
    file.write_text("\n".join(["G21 G90 G94", *ways, "M30", ""]))
    return file


def test_a_row_a_tolerance_and_a_picture(program, tmp_path, capsys):
    picture = tmp_path / "costs.svg"
    given = ["tolerance", str(program), "-m", demo.MACHINE, "--feed", "none", "--effort", "low"]
    assert main([*given, "--tips", "20um,5um", "--out", str(picture)]) == 0
    out = capsys.readouterr().out
    rows = re.findall(r"^ *([\d.]+ [µm]+) +\d:\d\d:\d\d\.\d +([\d.]+ m?s) +([+-][\d.]+%)", out, re.MULTILINE)
    assert [row[0] for row in rows] == ["5 µm", "0.01 mm", "0.02 mm"]
    seconds = [float(row[1].split()[0]) * (1e-3 if row[1].endswith("ms") else 1.0) for row in rows]
    assert seconds == sorted(seconds, reverse=True) and seconds[0] > seconds[-1]
    assert rows[1][2] == "+0.00%"
    assert picture.read_text().startswith("<svg") and "zigzag.ngc" in picture.read_text()


def test_what_is_no_tolerance_is_told_in_a_line(program, capsys):
    assert main(["tolerance", str(program), "-m", demo.MACHINE, "--tips", "5um,soft"]) == 2
    assert capsys.readouterr().err.startswith("error: --tips: ")
    assert main(["tolerance", str(program), "-m", demo.MACHINE, "--tips", "0um"]) == 2
    assert "--tips 0um: give a value from" in capsys.readouterr().err


def test_lines_of_the_picture_are_round_and_hold_all():
    for low, high in ((19.26, 22.9), (1.0, 1.0), (0.031, 0.047), (900.0, 1310.0)):
        values = round_values(low, high)
        assert values[0] <= low and values[-1] >= high and 2 <= len(values) <= 9
    assert "<polyline" in drawn([(1e-6, 2.0), (1e-5, 1.0)], "a<b") and "a&lt;b" in drawn(
        [(1e-6, 2.0), (1e-5, 1.0)], "a<b"
    )
