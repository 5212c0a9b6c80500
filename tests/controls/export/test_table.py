"""Target `table`: every number is the plan's, in the unit that its heading says."""

from __future__ import annotations

import hashlib
import re
import sys

import numpy as np
import pytest

from toolpace.common.errors import UsageError, VerificationError
from toolpace.controls.export import export
from toolpace.controls.export.table import COLUMNS, Table

COUNTS = {"X": "10000/mm", "Y": "-1e4/mm", "Z": "1000000/m", "A": "1000/deg", "C": "1e6/rad"}


def read(folder):
    """Header, names and numbers of table.csv."""
    lines = (folder / "table.csv").read_text().splitlines()
    head = [line for line in lines if line.startswith("# ")]
    names = lines[len(head)].split(",")
    return head, names, np.loadtxt(lines[len(head) + 1 :], delimiter=",")


def test_numbers_are_the_plans_in_mm_and_degrees(plan, motion, tmp_path):
    export(plan, "table", tmp_path / "out", period=4e-3, columns=COLUMNS)
    head, names, table = read(tmp_path / "out")
    points = motion.setpoints
    n = len(table) - 1
    factors = [1e3, 1e3, 1e3, np.degrees(1.0), np.degrees(1.0)]
    assert names[:2] == ["t [s]", "X [mm]"] and names[4] == "A [deg]" and names[-1] == "block"
    assert "C velocity [deg/s]" in names and "Z acceleration [mm/s2]" in names and "tip x [mm]" in names
    for first, value in ((1, points.q), (6, points.qd), (11, points.qdd), (16, points.qddd)):
        right = value[::4][:n] * factors
        assert np.allclose(table[:n, first : first + 5], right, rtol=2e-14, atol=0)
    assert np.allclose(table[:n, 21:24], points.tip[::4][:n] * 1e3, rtol=2e-14, atol=0)
    assert np.array_equal(table[:n, -1], points.block[::4][:n])
    text = "\n".join(head)
    for file in ("machine.toml", "program.ngc"):
        assert hashlib.sha256((plan / file).read_bytes()).hexdigest() in text
    assert "bring the machine to the first row before: X 0 mm" in text and "straight from row to row" in text


def test_increments_are_whole_and_half_of_one_off_at_most(plan, motion, tmp_path):
    said = export(plan, "table", tmp_path / "out", period=4e-3, columns=("q", "qd"), counts=COUNTS)
    _, names, table = read(tmp_path / "out")
    assert names[0] == "X [counts]" and names[5] == "X velocity [counts/s]"
    assert np.array_equal(table[:, :5], np.rint(table[:, :5]))
    size = np.array([1e-7, -1e-7, 1e-6, np.radians(1e-3), 1e-6])
    n = len(table) - 1
    assert (np.abs(table[:n, :5] * size - motion.setpoints.q[::4][:n]) <= 0.5000001 * np.abs(size)).all()
    assert any("whole increments, by at most X 0.05 µm" in note for note in said.notes)


def test_parquet_holds_units_and_checksums(plan, motion, tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet")
    export(plan, "table", tmp_path / "out", format="parquet", counts=COUNTS, columns=("t", "q", "axis", "block"))
    table = parquet.read_table(tmp_path / "out" / "table.parquet")
    assert table.schema.field("A").metadata == {b"unit": b"counts"} and str(table.schema.field("A").type) == "int64"
    assert table.schema.field("t").metadata == {b"unit": b"s"} and table.num_rows == len(motion.setpoints)
    program = hashlib.sha256((plan / "program.ngc").read_bytes()).hexdigest()
    assert table.schema.metadata[b"sha256 of program"].decode() == program
    assert b"one row every 1 ms" in table.schema.metadata[b"toolpace"]
    assert np.array_equal(table["axis k"].to_numpy(), motion.setpoints.axis[:, 2])


def test_without_pyarrow_the_extra_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(UsageError, match=r"pip install 'toolpace\[parquet\]', or give --format csv"):
        Table(format="parquet")


def another_number(text):
    return re.sub(r"\n([^#\n]*?,)([0-9])", lambda m: f"\n{m[1]}{(int(m[2]) + 1) % 10}", text, count=3)


TAMPERS = {
    "another number": (another_number, r"largest relative difference of a number: \S+, allowed 2e-14"),
    "a row less": (lambda text: text[: text.rstrip().rindex("\n") + 1], "largest relative difference of a number: inf"),
    "a row more": (lambda text: text + text.splitlines()[-1] + "\n", "largest relative difference of a number: inf"),
    "another unit": (lambda text: text.replace("[mm]", "[m]", 1), "other columns"),
    "no number": (lambda text: text.rstrip()[:-1] + "x\n", "no number"),
}


@pytest.mark.parametrize("change, message", TAMPERS.values(), ids=TAMPERS)
def test_what_reads_differently_is_told_with_the_figure(motion, tmp_path, change, message):
    target = Table(period=40e-3)
    written = target.write(motion, tmp_path)
    target.check(motion, tmp_path, written)
    file = tmp_path / "table.csv"
    file.write_text(change(file.read_text()))
    with pytest.raises(VerificationError, match=message):
        target.check(motion, tmp_path, written)


WRONG = {
    "a column that is none": ({"columns": ("t", "qq")}, "--columns qq: there is no such column; did you mean 'q'"),
    "no column": ({"columns": ()}, "--columns: name each column once"),
    "a column twice": ({"columns": ("q", "q")}, "--columns: name each column once"),
    "no such format": ({"format": "xls"}, "--format xls: give one of csv, parquet"),
    "one unit": ({"scale": "mm"}, "--scale mm: give a unit of length"),
    "two lengths": ({"scale": "mm,in"}, "--scale mm,in: give a unit of length"),
    "a joint that is none": ({"counts": {"B": "1/deg"}}, "--counts B: the machine has no such joint"),
    "a joint that is missing": ({"counts": {"X": "1/mm"}}, "nothing is said of joint Y, Z, A, C"),
    "a length of a turn": ({"counts": COUNTS | {"A": "1000/mm"}}, "joint A turns; write increments for each of deg"),
    "no increments": ({"counts": COUNTS | {"A": "0/deg"}}, "'0' is no number of increments"),
    "no number": ({"counts": COUNTS | {"A": "many/deg"}}, "'many' is no number of increments"),
    "too many": ({"counts": COUNTS | {"X": "1e30/mm"}}, "increments are more than a whole number can hold"),
}


@pytest.mark.parametrize("options, message", WRONG.values(), ids=WRONG)
def test_wrong_options_get_one_clear_error(motion, tmp_path, options, message):
    with pytest.raises(UsageError, match=re.escape(message)):
        Table(**options).write(motion, tmp_path)
