"""Times of operations as people write them down."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from toolpace import Machine
from toolpace.common.errors import UsageError
from toolpace.controls.fitting.motion_log import is_log, load_log
from toolpace.controls.fitting.written_times import load_written_times, written_time


@pytest.mark.parametrize(
    ("text", "seconds", "resolution"),
    [
        ("1:23", 83.0, 1.0),
        ("1:02:03", 3723.0, 1.0),
        ("0:59.5", 59.5, 0.1),
        ("83 s", 83.0, 1.0),
        ("83,45 sec", 83.45, 0.01),
        ("2 min", 120.0, 60.0),
        ("2.5min", 150.0, 6.0),
        ("2 min 5 s", 125.0, 1.0),
        ("1 h 2 min", 3720.0, 60.0),
    ],
)
def test_a_time_is_as_exact_as_its_last_digit(text: str, seconds: float, resolution: float):
    found = written_time(text)
    assert found is not None
    assert found.seconds == pytest.approx(seconds) and found.resolution == pytest.approx(resolution)
    assert found.deviation == pytest.approx(resolution / math.sqrt(12.0))


NONE = ["", "12", "1:2", "3:99", "-1:23", "nan s", "abc", "-5 s", "0:00", "1e9 s", "9" * 30 + " h", "log.csv", "3 m.nc"]


@pytest.mark.parametrize("text", NONE)
def test_what_is_no_time(text: str):
    assert written_time(text) is None


def test_a_list_as_a_shop_writes_it(tmp_path: Path):
    (tmp_path / "times.csv").write_text(
        "operation,time\nFace the top, 1:23\n\n\"Pocket, rough\"; 2 min 5 s\nDrill M8 x 20   83.4 s  # with chips\n"
        "T5,0:40\nBore - 0:12\nTotal  6:10\n",
        encoding="utf-8",
    )
    found = [(each.operation, each.seconds) for each in load_written_times(tmp_path / "times.csv")]
    drill = ("Drill M8 x 20", pytest.approx(83.4))
    assert found == [("Face the top", 83.0), ("Pocket, rough", 125.0), drill, ("T5", 40.0), ("Bore", 12.0), ("", 370.0)]


def test_operations_that_are_called_as_axes_are_no_log(tmp_path: Path):
    on = Machine.load("xyzac-trunnion")
    (tmp_path / "times.csv").write_text("A, 1:23\nC, 0:40\n", encoding="utf-8")
    (tmp_path / "log.csv").write_text("s,A,C\n0,0,0\n", encoding="utf-8")
    assert not is_log(tmp_path / "times.csv", on) and is_log(tmp_path / "log.csv", on)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("Face, 1:23\nPocket, 12\n", "times.txt:2: 'Pocket, 12' ends with no time"),
        ("", "there is no time in it"),
        ("Face, -1:15\n", "times.txt:1: 'Face, -1:15' is below zero"),
        ("Face, 3:75\n", "times.txt:1: 'Face, 3:75' ends with no time"),
        ("9" * 300_000 + "\n", "times.txt:1: '9999.*ends with no time"),
        ("Op;Zeit\n", "there is no time in it"),
        ("t,x\n0,1\n", "times.txt:2: .*A log of the axes begins"),
    ],
)
def test_what_has_no_times_is_refused(tmp_path: Path, text: str, told: str):
    (tmp_path / "times.txt").write_text(text, encoding="utf-8")
    with pytest.raises(UsageError, match=told):
        load_written_times(tmp_path / "times.txt")
    (tmp_path / "times.txt").write_bytes(b"PK\x03\x04\x14\x00\x06\x00 a spreadsheet, 1:23")
    with pytest.raises(UsageError, match="no text; save it as text or CSV"):
        load_written_times(tmp_path / "times.txt")


TABLES = {
    "semicolons and decimal commas": "Operation;Zeit\r\nPocket;24,5 s\r\nDrill;0:30,2\r\n",
    "the unit in the heading": "Nr;Operation;Zeit [s]\n1;Pocket;24,5\n2;Drill;30,2\n",
    "commas and quotes": '"Operation","Time"\n"Pocket","24,5 s"\n"Drill","30.2 s"\n',
    "commas and the unit in the heading": "Operation,Time (sec)\nPocket,24.5\nDrill,30.2\n",
    "tools and remarks": "Nr;Op;Tool;Time;Remark\n1;Pocket;T1;24,5 s;good\n2;Drill;T2;30,2 Sek.;\n",
    "empty rows and cells": "sep=;\nOp;Time;;\nPocket;24,5 s;;\n;;;\nDrill;30,2 s;;\n",
    "lines end as on an old Macintosh": "Pocket;24,5 s\rDrill;30,2 s\r",
    "tabs": "Op\tmachine time [s]\nPocket\t24.5\nDrill\t30.2\n",
}


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "latin-1"])
@pytest.mark.parametrize("text", TABLES.values(), ids=TABLES)
def test_a_table_as_spreadsheets_write_it(tmp_path: Path, text: str, encoding: str):
    (tmp_path / "times.csv").write_bytes(text.replace("Pocket", "Fräsen").encode(encoding))
    found = load_written_times(tmp_path / "times.csv")
    assert [each.operation for each in found] == ["Fräsen", "Drill"]
    assert [each.seconds for each in found] == pytest.approx([24.5, 30.2])
    assert [each.resolution for each in found] == pytest.approx([0.1, 0.1])


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("Op;main [s];idle [s]\nPocket;24,5;3,1\n", "times.csv:2: 'Pocket;24,5;3,1' has 2 times; leave one in each"),
        ("Op;from;time\nPocket;10:15;24 s\n", "times.csv:2: .* has 2 times"),
        # a decimal comma between commas: the 24 is not the whole of it
        ("Op,Time [s]\nPocket,24,5\n", "times.csv:2: 'Pocket,24,5' ends with no time"),
        ("Op;Time\nPocket;24,5\n", "times.csv:2: 'Pocket;24,5' ends with no time"),
        ("Op;Time [s]\nPocket;-24,5\n", "times.csv:2: 'Pocket;-24,5' ends with no time"),
        ("Op;Time [s]\nPocket;1.024,5\n", "times.csv:2: .* ends with no time"),
    ],
)
def test_a_table_whose_times_are_not_clear_is_refused(tmp_path: Path, text: str, told: str):
    (tmp_path / "times.csv").write_text(text, encoding="utf-8")
    with pytest.raises(UsageError, match=told):
        load_written_times(tmp_path / "times.csv")


def test_a_log_may_have_semicolons_and_decimal_commas(tmp_path: Path):
    on = Machine.load("xyzac-trunnion")
    rows = [f"{0.002 * k:.3f};{max(k - 3, 0) * 0.5}" for k in range(40)]
    (tmp_path / "log.csv").write_text("t;X\n" + "\n".join(rows).replace(".", ",") + "\n", encoding="utf-8")
    assert is_log(tmp_path / "log.csv", on)
    log = load_log(tmp_path / "log.csv", on)
    assert log.dt == pytest.approx(0.002) and log.q[-1, 0] == pytest.approx(0.018)
