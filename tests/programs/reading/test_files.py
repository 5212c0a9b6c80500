"""Files, dialects and the feed option."""

from __future__ import annotations

import numpy as np
import pytest

from tests.support.growth import python_calls
from tests.support.table_table import MACHINE
from toolpace.common.errors import ProgramError, UsageError
from toolpace.programs.reading import apply_feed, read, read_text

GCODE = "G0 X0 Y0 Z0\nG1 X1 F100\nM30\n"
APT = "FEDRAT/100\nGOTO/0,0,0\nGOTO/1,0,0\n"
TABLE = "x [mm],y [mm],z [mm],feed [mm/min]\n0,0,0,100\n1,0,0,100\n"


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("a.ngc", GCODE), ("a.NC", GCODE), ("a.tap", GCODE), ("a.txt", GCODE), ("a", "N1 " + GCODE),
        ("a.ptp", "%\n" + GCODE),
        ("a.apt", APT), ("a.cls", APT), ("a.txt", APT), ("a.csv", TABLE), ("a.dat", TABLE),
    ],
)  # fmt: skip
def test_tells_the_dialect_by_name_or_content(tmp_path, name, text):
    (tmp_path / name).write_text(text)
    p = read(tmp_path / name)
    assert len(p) == 2 and p.feed[1] * 6e4 == pytest.approx(100) and p.source == str(tmp_path / name)


def test_line_ends_of_every_kind_and_accents(tmp_path):
    for data in (
        GCODE.replace("\n", "\r\n").encode(),
        GCODE.replace("\n", "\r").encode(),
        b"\xef\xbb\xbf" + GCODE.encode(),
        b"(Fr\xe4ser)\n" + GCODE.encode(),
        GCODE.encode() + b"\x1a",
    ):
        (tmp_path / "a.nc").write_bytes(data)
        assert len(read(tmp_path / "a.nc")) == 2


@pytest.mark.parametrize(
    ("data", "says"),
    [
        (b"", "empty"),
        (b" \n\n", "empty"),
        (b"G0 X0\x00\x01", "binary"),
        (bytes(range(256)) * 4, "binary"),
        (GCODE.encode("utf-16"), "binary"),
        (b"hello world\n", "--dialect gcode, apt or csv"),
    ],
)
def test_files_that_are_no_programs(tmp_path, data, says):
    (tmp_path / "a.dat").write_bytes(data)
    with pytest.raises(ProgramError, match=says) as caught:
        read(tmp_path / "a.dat")
    assert str(tmp_path) in str(caught.value) and "\n" not in str(caught.value)


def test_missing_files_and_folders(tmp_path):
    (tmp_path / "impeller.ngc").write_text(GCODE)
    with pytest.raises(ProgramError, match=r"no such file; did you mean impeller\.ngc"):
        read(tmp_path / "impeler.ngc")
    with pytest.raises(ProgramError, match="no such file; check the path"):
        read(tmp_path / "nowhere" / "a.ngc")
    with pytest.raises(ProgramError, match="folder"):
        read(tmp_path)
    with pytest.raises(ProgramError, match="cannot be opened"):
        read("a\0b.ngc")


def test_unknown_dialect():
    with pytest.raises(UsageError, match="use gcode, apt or csv"):
        read_text(GCODE, dialect="stl")


PROGRAM = "M428\nG0 X0 Y0 Z0 A0\nG1 X10 F600\nA30 F60\nG93 X20 F10\nX21 A40 F10\nM2\n"


def test_feed_none_takes_every_cap_away():
    p = read_text(PROGRAM, MACHINE, "gcode", feed="none")
    assert np.isinf(p.feed).all() and not p.least_time.any()


def test_feed_factor_scales_caps_and_times():
    p, q = (read_text(PROGRAM, MACHINE, "gcode", feed=f) for f in (None, "120%"))
    assert q.feed == pytest.approx(p.feed * 1.2) and q.least_time == pytest.approx(p.least_time / 1.2)


def test_feed_value_rules_where_the_tip_moves():
    p = read_text(PROGRAM, MACHINE, "gcode", feed="3000mm/min")
    assert p.least_time.sum() == pytest.approx(30.0)
    assert p.feed[p.block != 4][1:] == pytest.approx(0.05) and np.isinf(p.feed[p.block == 4]).all()
    assert apply_feed(p, "none").least_time.sum() == 0


def test_feed_option_stands_in_for_missing_words():
    body = "G0 X0 Y0 Z0\nG1 X1\nG93 X2\nG0 X3\n"
    assert read_text(body, None, "gcode", feed="3000mm/min").feed[1:] == pytest.approx([0.05, 0.05, np.inf])
    assert np.isinf(read_text(body, None, "gcode", feed="none").feed).all()
    with pytest.raises(ProgramError, match=":2: feed missing"):
        read_text(body, None, "gcode", feed="120%")


@pytest.mark.parametrize("spec", ["fast", "0%", "-5%", "0mm/min", "100", ""])
def test_feed_option_says_what_it_takes(spec):
    with pytest.raises(UsageError, match=r"120%"):
        read_text(GCODE, dialect="gcode", feed=spec)


def winding(n):
    """A program of n blocks of five axes."""
    u = np.linspace(0, 6e-4 * np.pi * n, n)
    columns = np.column_stack([50 * np.cos(u), 50 * np.sin(u), u / 10, 20 * np.sin(u / 3) - 30, np.degrees(u)])
    body = "\n".join(
        "N{} G1 X{:.4f} Y{:.4f} Z{:.4f} A{:.4f} C{:.4f} F3000".format(i, *row) for i, row in enumerate(columns)
    )
    return f"G43.4 H1\n{body}\nM30\n"


def test_every_block_costs_the_same_however_many_there_are():
    few, many = winding(300), winding(3_000)
    p = read_text(many, MACHINE, "gcode")
    assert len(p) == 3_000 and not p.tip.flags.writeable
    calls = [python_calls(lambda text=text: read_text(text, MACHINE, "gcode")) for text in (few, many)]
    assert (calls[1] - calls[0]) / 2_700 < 150 and calls[1] < 10.1 * calls[0]


def test_a_file_of_exactly_the_largest_size_is_read(tmp_path, monkeypatch):
    """And one of a byte more is refused."""
    monkeypatch.setattr("toolpace.programs.reading.source.LARGEST", len(GCODE))
    (tmp_path / "a.nc").write_text(GCODE)
    assert len(read(tmp_path / "a.nc")) == 2
    (tmp_path / "a.nc").write_text(GCODE + "\n")
    with pytest.raises(ProgramError, match="the file has more than"):
        read(tmp_path / "a.nc")
