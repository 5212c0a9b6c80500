"""Whatever a file holds, it is read or refused in one line, and soon."""

from __future__ import annotations

import random
import time
import warnings
from pathlib import Path

import pytest

from tests.support.linuxcnc_files import ini_text
from toolpace.common.errors import ToolpaceError, UnitWarning
from toolpace.machine.from_control import read_control
from toolpace.machine.from_control.control_file import ControlFileError

HAL = (
    "loadrt sum2 names=pivot\nsetp pivot.in0 [GEOMETRY]PIVOT\nnet tool motion.tooloffset.z => pivot.in1\n"
    "net pivot pivot.out => 5axiskins.pivot-length\nsource more.hal\nsetp xyzac-trt-kins.y-offset 20\n"
)
INI = ini_text("5axiskins", "XYZBCW", sections={"GEOMETRY": {"PIVOT": 200}}, lines=["HALFILE = mill.hal"])


def _files(folder: Path, ini: bytes, hal: bytes = HAL.encode()) -> Path:
    (folder / "mill.hal").write_bytes(hal)
    (folder / "mill.ini").write_bytes(ini)
    return folder / "mill.ini"


HOSTILE = {
    "nothing": (b"", "no file of a control"),
    "binary": (bytes(range(256)) * 50, "is not text"),
    "UTF-16 without its mark": (INI.encode("utf-16-le"), "is not text"),
    "an include of itself": (INI.encode() + b"#INCLUDE mill.ini\n", "goes round in a circle"),
    "an include of nothing": (INI.encode() + b"#INCLUDE  \n", "a file without a name is not there"),
    "a device": (INI.encode() + b"#INCLUDE /dev/zero\n", "/dev/zero is not there"),
    "lines without end": (b"\n" * 600_000, "has more than 500000 lines"),
    "a folder": (INI.encode() + b"#INCLUDE /tmp\n", "/tmp is not there"),
    "a name without end": (INI.encode() + b"#INCLUDE " + b"x" * 5000, "is not there"),
    "a number without end": (INI.replace("MAX_VELOCITY = 200.0", "MAX_VELOCITY = 1e999").encode(), "too large"),
    "more lines than an INI has": (INI.encode() + b"KEY = 1\n" * 100_001, "more than 100000 lines"),
}


@pytest.mark.parametrize("case", HOSTILE)
def test_a_hostile_file_is_refused_in_one_line(case, tmp_path):
    data, message = HOSTILE[case]
    with pytest.raises(ControlFileError, match=message) as error:
        read_control([_files(tmp_path, data)])
    assert "\n" not in str(error.value) and len(str(error.value)) < 500


def test_files_that_include_each_other_often_are_refused_soon(tmp_path):
    for k in range(10):
        (tmp_path / f"{k}.inc").write_text(f"#INCLUDE {k + 1}.inc\n" * 50 if k < 9 else "[X]\nY = 1\n")
    began = time.monotonic()
    with pytest.raises(ControlFileError, match="more than 200"):
        read_control([_files(tmp_path, INI.encode() + b"#INCLUDE 0.inc\n")])
    assert time.monotonic() - began < 5.0


def test_what_never_ends_is_read_no_further_than_a_file_can_go():
    with pytest.raises(ControlFileError, match="more than 32 MB"):
        read_control(["/dev/zero"])


def test_pins_that_feed_each_other_and_files_that_source_themselves_end(tmp_path):
    hal = "source mill.hal\nnet a p.out q.in0\nnet b q.out p.in0\nnet c q.out => 5axiskins.pivot-length\n"
    draft = read_control([_files(tmp_path, INI.encode(), hal.encode())])
    assert "5axiskins.pivot-length [mm]" in [question.what for question in draft.stand_ins]


@pytest.mark.parametrize("code", ["latin-1", "utf-8-sig", "utf-16"])
def test_files_in_another_code_page_are_no_fault(code, tmp_path):
    machine = read_control([_files(tmp_path, INI.replace("test mill", "Fräse").encode(code))]).machine
    assert machine.name == "Fräse"


@pytest.mark.parametrize("seed", [1, 2, pytest.param(3, marks=pytest.mark.sweep)])
def test_changed_files_are_read_or_refused_in_one_line(seed, tmp_path):
    """Bytes, words and lines are changed at random; nothing but an error of ours may come of it."""
    chance = random.Random(seed)
    words = [b"1e308", b"-0", b"nan", b"[", b"]", b"=", b"#INCLUDE mill.hal", b"\\"]
    words += [b"XYZXYZ", b"coordinates=", b"\xff", b"$::A(B)"]
    outcomes = {"read": 0, "refused": 0}
    for _ in range(250):
        ini, hal = bytearray(INI.encode()), bytearray(HAL.encode())
        for text in chance.choices((ini, hal), k=chance.randrange(1, 6)):
            start = chance.randrange(len(text) + 1)
            end = min(len(text), start + chance.choice((0, 1, 5, 40, 2000)))
            text[start:end] = chance.choice([*words, bytes(chance.randrange(1, 256) for _ in range(4)), b""])
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", UnitWarning)
                read_control([_files(tmp_path, bytes(ini), bytes(hal))])
            outcomes["read"] += 1
        except ToolpaceError as error:
            assert "\n" not in str(error)
            outcomes["refused"] += 1
    assert min(outcomes.values()) > 10
