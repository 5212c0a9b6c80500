"""Formats and units of a Fanuc's punched parameters, and what contradicts itself in them."""

from __future__ import annotations

import math
import random
import warnings
from pathlib import Path

import pytest

from tests.support.fanuc_files import parameters_text, without_lines
from toolpace.common.errors import ToolpaceError, UnitWarning
from toolpace.machine.from_control import read_control
from toolpace.machine.from_control.control_file import ControlFileError
from toolpace.machine.from_control.stand_ins import Answers
from toolpace.machine.machine import Machine
from toolpace.programs.reading.controllers.controller import Controller

TRUNNION = Machine.load("xyzac-trunnion")
MIXED = Machine.load("xyzbc-millturn")


def _read(tmp_path: Path, text: str, answers: Answers | None = None):
    place = tmp_path / "para.txt"
    place.write_text(text)
    return read_control([place], answers)


def _joint(tmp_path: Path, name: str, form: str = "30i", **changes: str | None):
    lines = {int(key[1:]): line for key, line in changes.items()}
    return _read(tmp_path, parameters_text(TRUNNION, form, changes=lines)).machine.file.joints[name]


@pytest.mark.parametrize(
    ("form", "line"),
    [
        ("30i", "N01320Q1A1P250.0A2P500.0A3P450.0A4P130.0A5P-1.0"),
        ("30i", "N01320 Q1 A1 P250.0 A2 P500.0 A3 P450.0 A4 P130.0 A5 P-1.0 ;"),
        ("30i", "N01320Q1A1P250.\nN01320Q1A2P500.0A3P450.0\nA4P130.0A5P-1.0"),
        ("30i", "N1320Q1A1M250.0A2M500.0A3M450.0A4P130.0A5P-1.0 (TRAVEL)"),
        ("30i", "N01320Q1A1I9.84251968503937A2P500.0A3P450.0A4P130.0A5P-1.0"),
        ("30i", "N01320Q1A1P250.0A2P500.0A3P450.0A4P130.0A5P-1.0\nN01320Q0A1P9999"),
        ("16i", "N01320A1P2500000A2P5000000A3P4500000A4P1300000A5P-1"),
        ("16i", "N01320 A1 P 2500000 A2 P 5000000 A3 P 4500000 A4 P 1300000 A5 P-1 "),
        ("16i", "N1320 P2500000 P5000000 P4500000 P1300000 P-1"),
    ],
)
def test_a_travel_is_read_in_each_format(form, line, tmp_path):
    assert _joint(tmp_path, "X", form, n1320=line).travel == pytest.approx((-0.5, 0.25))
    assert _joint(tmp_path, "A", form, n1320=line).travel == pytest.approx((-math.radians(130), math.radians(130)))


def _with_parity(text: str) -> bytes:
    return bytes(letter | 0x80 if letter.bit_count() % 2 else letter for letter in text.encode())


OLD = parameters_text(TRUNNION, "16i")
TAPES = {
    "ends of lines of an old Macintosh": OLD.replace("\n", "\r").encode(),
    "small letters": OLD.lower().encode(),
    "empty rows at both ends": b"\0" * 40 + OLD.encode() + b"\0" * 40,
    "ISO code with even parity": _with_parity(OLD),
    "marks of the reader": b"\x12" + OLD.replace("%", "%\n:0001", 1).encode() + b"\x14",
}


@pytest.mark.parametrize("data", TAPES.values(), ids=TAPES)
def test_a_file_from_a_tape_is_the_same_machine(data, tmp_path):
    (tmp_path / "para.txt").write_bytes(data)
    draft, expected = read_control([tmp_path / "para.txt"]), _read(tmp_path, OLD)
    assert draft.machine.file.joints == expected.machine.file.joints
    assert draft.record.remarks == expected.record.remarks


def test_lines_that_are_no_parameters_are_told_and_values_without_axis_refused(tmp_path):
    draft = _read(tmp_path, OLD.replace("N01660", "N09999").replace("N01420A1", "1420 = 15000\nX 99\nN01420A1"))
    (told,) = (each for each in draft.record.remarks if "no parameter" in each)
    assert told.startswith("2 lines that are no parameter") and told.endswith("para.txt:9 '1420 = 15000'.")
    with pytest.raises(ControlFileError, match="N01420 = 15000 names no axis; write A1 before it"):
        _joint(tmp_path, "X", "16i", n1420="N01420P15000")


def test_blocks_end_as_a_control_ends_them_and_its_number_may_follow_the_first_mark(tmp_path):
    """LF CR CR counts as one end of a line; axes of which the letter is 0 are not there."""
    text = parameters_text(TRUNNION, changes={1020: "N01020Q1A1P88A2P89A3P90A4P65A5P67A6P0 "}).replace("\n", "\n\r\r")
    draft = _read(tmp_path, text.replace("%", "%(CNCID=3C7B5D01,F6914B1A)", 1))
    assert "para.txt:9 N01420 A1" in draft.text and not draft.record.remarks and not draft.stand_ins


@pytest.mark.parametrize(
    ("bits", "least"), [("00000000", 0.001), ("00000001", 0.01), ("00000010", 0.0001), ("00000100", 0.00001)]
)
def test_whole_numbers_are_in_the_increment_of_their_axis(bits, least, tmp_path):
    """1013 bit 0 is IS-A, bit 1 IS-C, bit 2 IS-D, none IS-B."""
    increments = f"N01013A1P{bits}A2P00000010A3P00000010A4P00000010A5P00000010"
    line = "N01321A1P-20000A2P-5000000A3P-4500000A4P-1300000A5P1"
    low = _joint(tmp_path, "X", "16i", n1013=increments, n1321=line).travel[0]
    assert low == pytest.approx(-20.0 * least)


def test_the_increment_of_all_axes_is_in_1004(tmp_path):
    """16i: 1004 bit 1 is IS-C."""
    line = "N01320A1P2500000A2P5000000A3P4500000A4P1300000A5P-1"
    assert _joint(tmp_path, "X", "16i", n1013=None, n1004="N01004P00000010", n1320=line).travel[1] == 0.25


def test_an_acceleration_that_is_not_set_is_that_of_rapid_traverse(tmp_path):
    """1660 is 100 000 mm/s^2 where it is 0, which no axis has."""
    lines = {"n1660": "N01660Q1A1P100000.0A2P0.0", "n1671": "N01671Q1A1P3000.0A2P2000.0"}
    assert _joint(tmp_path, "X", **lines).acceleration == pytest.approx(3.0)
    assert _joint(tmp_path, "Y", **lines).acceleration == pytest.approx(2.0)


def test_figures_of_the_model_are_in_millimetres_on_inch_machines(tmp_path):
    lines = {1783: "N01783Q1A1P10.0A2P20.0A3P20.0A4P30.0A5P30.0"}
    text = parameters_text(TRUNNION, inch=True, changes=lines)
    assert _read(tmp_path, text).record.timing["fanuc.corner_difference"].number == pytest.approx(254.0)


def test_the_direction_of_the_tool_is_an_assumption_where_it_is_not_set(tmp_path):
    draft = _read(tmp_path, parameters_text(TRUNNION, changes={19697: None}))
    assert "tool_axis = [0, 0, 1]               # assumption: N19697 is not set" in draft.text


def test_whole_numbers_of_inch_machines_are_ten_times_finer_and_feeds_tenths(tmp_path):
    """IS-B: 0.0001 inch and 0.1 inch/min, but 0.001 deg and 1 deg/min."""
    lines = {1001: "N01001P00000001", 1013: None, 1420: "N01420A1P9600A2P9600A3P9600A4P5400A5P5400",
             1320: "N01320A1P100000A2P100000A3P100000A4P90000A5P-1"}  # fmt: skip
    text = parameters_text(TRUNNION, "16i", changes=lines)
    joints = _read(tmp_path, text).machine.file.joints
    assert joints["X"].travel[1] == pytest.approx(10.0 * 0.0254)
    assert joints["X"].velocity == pytest.approx(960.0 * 0.0254 / 60.0)
    assert joints["A"].travel[1] == pytest.approx(math.pi / 2.0)
    assert joints["A"].velocity == pytest.approx(math.radians(90.0))


def test_acceleration_of_old_controls_is_that_of_a_ramp(tmp_path):
    """With look-ahead 1770 over 1771, here 12 m/min in 40 ms; it builds up in 1772, here 50 ms."""
    lines = {1770: "N01770P12000", 1771: "N01771P40", 1772: "N01772P50"}
    joints = _read(tmp_path, parameters_text(TRUNNION, "16i", changes=lines)).machine.file.joints
    assert joints["Y"].acceleration == pytest.approx(5.0) and joints["Y"].jerk == pytest.approx(100.0)
    assert joints["A"].acceleration == pytest.approx(math.radians(600.0)), "of the ramp of rapid traverse"


def test_jerk_is_the_acceleration_over_the_longer_of_two_times(tmp_path):
    assert _joint(tmp_path, "X", n1772="N01772Q1L1P200").jerk == pytest.approx(25.0)
    assert _joint(tmp_path, "X", n1772="N01772Q1L1P20").jerk == pytest.approx(50.0), "1769 is 100 ms"
    assert _joint(tmp_path, "X", n1772="N01772Q1L1P20", n1769=None).jerk == pytest.approx(250.0)


def test_each_figure_names_its_line_and_a_controller_file_has_those_of_the_model(tmp_path):
    lines = {1772: "N01772Q1L1P60", 1783: "N01783Q1A1P400.0A2P300.0A3P500.0A4P600.0A5P700.0",
             1735: "N01735Q1A1P5000.0A2P5000.0A3P2000.0", 1789: "N01789Q1A1P90.0A2P80.0A3P70.0"}  # fmt: skip
    draft = _read(tmp_path, parameters_text(TRUNNION, changes=lines))
    assert 'velocity = "30000 mm/min"           # para.txt:9 N01420 A1' in draft.text
    assert "travel = [-500, 500]                # mm; para.txt:8 N01321 A1 and para.txt:7 N01320 A1" in draft.text
    place = tmp_path / "my-fanuc.toml"
    place.write_text(draft.controller)
    figures = Controller.load(place).time
    assert figures["model"] == "fanuc"
    assert figures["fanuc"] == {
        "corner_difference": 300.0, "corner_difference_rotary": 600.0, "acceleration_change_lines": 70.0,
        "arc_acceleration": 0.5, "bell_time": 0.06, "after_interpolation": 0.1,
    }  # fmt: skip


def test_a_machine_without_five_axis_parameters_is_asked_about(tmp_path):
    text = parameters_text(TRUNNION, changes=dict.fromkeys([19680, *range(19681, 19706)]))
    answers = {"axes A, C": "AC/", "a point on": "0, 0, -220", "positive": "yes"}

    def ask(question):
        return next((answer for start, answer in answers.items() if question.what.startswith(start)), "")

    q = [[0.1, 0.2, 0.3, 0.4, 0.5]]
    tip, axis = _read(tmp_path, text, Answers(ask)).machine.forward(q)
    expected = _read(tmp_path, parameters_text(TRUNNION)).machine.forward(q)
    assert tip == pytest.approx(expected[0], abs=1e-12) and axis == pytest.approx(expected[1], abs=1e-12)


def test_an_axis_that_is_only_counted_with_is_held_at_its_angle(tmp_path):
    """19696#1: the second axis does not exist, and the table is taken at 30 degrees."""
    lines = {19686: "N19686Q1L1P0", 19690: "N19690Q1L1P30.0", 19696: "N19696Q1L1P00000010"}
    draft = _read(tmp_path, parameters_text(TRUNNION, changes=lines))
    assert draft.record.held == ["B"]
    low, high = draft.machine.file.joints["B"].travel
    assert (low + high) / 2.0 == pytest.approx(math.radians(30.0))


REFUSED = {
    "a table with offsets of a head": (TRUNNION, {19711: "N19711Q1L1P20.0"},
        r"N19711 L1 = 20 is of another kind .*para.txt:\d+ N19680 L1 = 12 \(table\)"),
    "a mixed machine with a second axis of the table": (MIXED, {19703: "N19703Q1L1P5.0"}, "N19703 .* = 21 .mixed"),
    "a letter twice": (TRUNNION, {1020: "N01020Q1A1P88A2P89A3P90A4P65A5P65"}, "A5 = 65: .* that of .* N01020 A4 too"),
    "a letter at another's place": (TRUNNION, {1022: "N01022Q1A1P2A2P1A3P3A4P0A5P0"}, "N01022 A1 = 2, Y .* calls it X"),
    "a rotary X": (TRUNNION, {1006: "N01006Q1A1P00000001A2P00000000"}, "N01006 A1 #0 = 1, a rotary .* N01020 A1"),
    "an axis number twice": (TRUNNION, {19686: "N19686Q1L1P4"}, "N19686 L1 names the axis A, as .*N19681 L1 does"),
    "an axis that does not exist": (TRUNNION, {19696: "N19696Q1L1P00000001"}, "#0 = 1: .* N19681 L1 = 4 names one"),
    "a linear axis that turns": (TRUNNION, {19686: "N19686Q1L1P2"}, "N19686 L1 = 2, and .* says that Y is linear"),
    "no such axis": (TRUNNION, {19686: "N19686Q1L1P7"}, "N19686 L1 = 7: there is no such axis among X, Y, Z, A, C"),
    "a straight axis with an inclination": (TRUNNION, {19683: "N19683Q1L1P45.0"}, "45 deg inclines .* N19682 L1 = 1"),
    "no direction": (TRUNNION, {19687: "N19687Q1L1P9"}, "N19687 L1 = 9; give 1 to 6"),
    "no sense": (TRUNNION, {19684: "N19684Q1L1P-1"}, "N19684 L1 = -1; give 0"),
    "a direction that is missing": (TRUNNION, {19687: None}, "para.txt: N19687 is missing, and N19680 needs it"),
    "another kind": (TRUNNION, {19680: "N19680Q1L1P17"}, "N19680 L1 = 17; 2 .tool., 12 .table. and 21"),
    "a tilted tool": (TRUNNION, {19698: "N19698Q1L1P10.0"}, "N19698 L1 = 10 deg: a tool that is tilted"),
    "a shift of one's own": (MIXED, {19665: "N19665Q1L1P00110000"}, "N19665 L1 #4 = 1: a shift .* 19667"),
    "two values": (TRUNNION, {1772: "N01772Q1L1P20\nN01772Q1L1P30"}, r"N01772 L1 = 30 contradicts .*:\d+ N01772"),
    "travel without length": (TRUNNION, {1321: "N01321Q1A1P500.0"}, "N01320 A1 = 500 is not above .*N01321 A1 = 500"),
    "no decimal point": (TRUNNION, {1321: "N01321Q1A1P-500"}, "N01321 A1 = -500 has no decimal point, and .* Q1"),
    "a limit below zero": (TRUNNION, {1420: "N01420Q1A1P-30.0"}, "N01420 A1 = -30; give a number above zero"),
    "bits that are none": (TRUNNION, {1006: "N01006Q1A1P2"}, "N01006 A1 = 2; give eight digits 0 or 1"),
    "no axis Z": (TRUNNION, {1020: "N01020Q1A1P88A2P89A3P87A4P65A5P67", 1022: None}, "XYWAC, without Z"),
    "no letters": (TRUNNION, {1020: None}, "N01020 .letters of the axes. is missing"),
    "no letter": (TRUNNION, {1020: "N01020Q1A1P8"}, "N01020 A1 = 8 is the code of no letter"),
    "a word that is none": (TRUNNION, {1420: "N01420Q1A1P30.0X5"}, "'N01420Q1A1P30.0X5' is no line of a parameter"),
    "a number that is none": (TRUNNION, {1420: "N01420Q1A1P3.0.0"}, "'3.0.0' is not a number"),
    "words without end": (TRUNNION, {1420: "N01420" + "P  " * 400 + "X"}, "is no line of a parameter"),
    "a program": (TRUNNION, {1420: "G10 L52\nN1420 P1 R30000\nG11"}, "'G10 L52' is a program that sets parameters"),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSED)
def test_what_contradicts_itself_is_refused_at_its_line(case, tmp_path):
    machine, changes, message = REFUSED[case]
    with pytest.raises(ControlFileError, match=message) as error:
        _read(tmp_path, parameters_text(machine, changes=changes))
    assert "\n" not in str(error.value)


def test_what_is_unusual_is_told(tmp_path):
    text = parameters_text(TRUNNION, changes={19684: "N19684Q1L1P0", 1006: "N01006Q1A1P00001000A4P00000001A5P00000001"})
    draft = _read(tmp_path, text.removesuffix("%\n"))
    remarks = " ".join(draft.record.remarks)
    assert "N19684 L1 = 0: A turns against the usual sense of a table axis (1)" in remarks
    assert "does not end with %" in remarks and "X counts diameters" in remarks
    assert draft.machine.file.joints["X"].travel == pytest.approx((-0.25, 0.25))
    assert draft.machine.file.joints["A"].direction == (1.0, 0.0, 0.0)


def test_axes_of_a_second_path_and_axes_beside_x_y_z_rest(tmp_path):
    """The slave of a second path may have the same letter; U is parallel to X."""
    lines = {981: "N00981Q1A1P1A2P1A3P1A4P1A5P1A6P2A7P1", 1020: "N01020Q1A1P88A2P89A3P90A4P65A5P67A6P88A7P85",
             1022: "N01022Q1A1P1A2P2A3P3A4P0A5P0A6P1A7P5"}  # fmt: skip
    draft = _read(tmp_path, parameters_text(TRUNNION, changes=lines))
    assert sorted(draft.machine.joints) == sorted("XYZAC")
    assert any("axis U" in remark and "rests" in remark for remark in draft.record.remarks)


def test_what_is_missing_is_a_named_stand_in(tmp_path):
    draft = _read(tmp_path, without_lines(parameters_text(TRUNNION), 1420))
    assert [each.what for each in draft.stand_ins if "velocity" in each.what][:2] == [
        "velocity of X [mm/s]", "velocity of Y [mm/s]"]  # fmt: skip
    assert "# NOT in these files: velocity of X" in draft.text


@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.sweep)])
def test_changed_files_are_read_or_refused_in_one_line(seed, tmp_path):
    chance = random.Random(seed)
    texts = [parameters_text(MIXED).encode(), parameters_text(TRUNNION, "16i").encode()]
    words = [b"P", b"N", b"A9", b"L2", b"Q2", b".", b"-", b"9" * 30, b"I1.0", b"M", b"%", b"(", b"\xff", b"\r"]
    outcomes = {"read": 0, "refused": 0}
    place = tmp_path / "para.txt"
    for _ in range(120):
        text = bytearray(chance.choice(texts))
        for _ in range(chance.randrange(1, 5)):
            start = chance.randrange(len(text) + 1)
            end = min(len(text), start + chance.choice((0, 1, 3, 20, 800)))
            text[start:end] = chance.choice([*words, b""])
        place.write_bytes(text)
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", UnitWarning)
                read_control([place])
            outcomes["read"] += 1
        except ToolpaceError as error:
            assert "\n" not in str(error) and len(str(error)) < 500
            outcomes["refused"] += 1
    assert min(outcomes.values()) > 10


def test_a_vector_that_is_not_punched_is_asked_for_and_half_of_one_is_refused(tmp_path):
    text = without_lines(parameters_text(TRUNNION), 19700, 19701, 19702)
    asked = [each.what for each in _read(tmp_path, text).stand_ins]
    assert asked == ["N19700 to N19702, from machine zero to the table's first axis [mm]"]
    draft = _read(tmp_path, text, Answers(lambda question: "1, 2, 3"))
    assert draft.record.joints["A"]["point"].value == (1.0, 2.0, 3.0)
    with pytest.raises(ControlFileError, match=r"N19700 L1 is there without all of N19700 to N19702"):
        _read(tmp_path, without_lines(parameters_text(TRUNNION), 19701))


def test_axes_that_are_changed_over_are_told(tmp_path):
    changes = {19681: "N19681Q1L1P5", 19686: "N19686Q1L1P4"}
    remarks = _read(tmp_path, parameters_text(TRUNNION, changes=changes)).record.remarks
    found = [remark.partition(" of its letter")[0] for remark in remarks]
    assert found == ["C turns across the direction", "A turns across the direction"]
    assert not _read(tmp_path, parameters_text(TRUNNION)).record.remarks
