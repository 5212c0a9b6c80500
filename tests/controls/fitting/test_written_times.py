"""Times of operations as people write them down."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from toolpace import Machine
from toolpace.common.errors import UsageError
from toolpace.controls.fitting.measured import is_log, load_written_times, written_time


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
    (tmp_path / "times.txt").write_bytes(b"\xff\xfe\x00\x81")
    with pytest.raises(UsageError, match="no text"):
        load_written_times(tmp_path / "times.txt")
