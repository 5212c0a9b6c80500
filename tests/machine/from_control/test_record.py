"""What a record lacks, units of its figures, and files of two controls."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from tests.support import fanuc_files, heidenhain_files
from tests.support.linuxcnc_files import ini_text, written
from toolpace.machine.from_control import read_control, readers
from toolpace.machine.from_control.control_file import ControlFile, ControlFileError
from toolpace.machine.from_control.machine_file import machine_text
from toolpace.machine.from_control.record import Figure, MachineRecord, Origin
from toolpace.machine.from_control.stand_ins import Answers, complete
from toolpace.machine.machine import Machine

HERE = (Origin("N32300", "axes.txt", 3),)


def _joint(kind: str, direction: tuple[float, float, float], **figures: Figure) -> dict[str, Figure]:
    shown = {"kind": Figure(kind, HERE), "direction": Figure(direction, HERE), "travel": Figure((-90.0, 90.0), HERE)}
    return shown | ({"point": Figure((0.0, 0.0, 0.0), HERE)} if kind == "rotary" else {}) | figures


def _record() -> MachineRecord:
    record = MachineRecord("test", "mill", ("axes.txt",), Figure("mm", HERE), Figure("deg", HERE))
    limits = {"velocity": Figure(30.0, HERE, "m/min"), "acceleration": Figure(4.0, HERE, "m/s2")}
    turns = {"velocity": Figure(20.0, HERE, "rpm"), "acceleration": Figure(0.5, HERE, "rev/s2")}
    for name, direction in zip("XYZ", ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))):
        record.joints[name] = _joint("linear", direction, **limits)
    record.joints["A"] = _joint("rotary", (-1.0, 0.0, 0.0), **turns)
    record.joints["C"] = _joint("rotary", (0.0, 0.0, -1.0), velocity=Figure(90.0, HERE))
    for key, value in (("workpiece", ("A", "C")), ("tool", ("X", "Y", "Z")), ("spindle_nose", (0.0, 0.0, 0.0))):
        record.chain[key] = Figure(value, HERE)
    record.chain["tool_length"] = Figure(0.0, HERE)
    return record


def test_a_jerk_stands_in_in_the_unit_of_its_acceleration():
    record, answers = _record(), Answers()
    complete(record, answers)
    machine = Machine.from_toml(machine_text(record, answers.taken, {}))
    assert machine.limits.jerk[0] == pytest.approx(40.0)
    assert machine.limits.jerk[machine.joints.index("A")] == pytest.approx(5.0 * 2.0 * 3.141592653589793)
    assert 'acceleration = "4 m/s2"' in machine_text(record, (), {})
    assert [each.what for each in answers.taken][-2:] == ["acceleration of C [deg/s^2]", "jerk of C [deg/s^3]"]


@pytest.mark.parametrize(
    ("control", "text"),
    [
        ("LinuxCNC", ini_text("xyzac-trt-kins", "XYZAC")),
        ("Sinumerik", "N32300 $MA_MAX_AX_ACCEL[AX1]=4\nN32000 $MA_MAX_AX_VELO[AX1]=30000\n"),
        ("Fanuc", fanuc_files.parameters_text(Machine.load("xyzac-trunnion"))),
        ("Fanuc", fanuc_files.parameters_text(Machine.load("xyzac-trunnion"), "16i")),
        ("Heidenhain", heidenhain_files.parameters_text(Machine.load("xyzac-trunnion"))),
        ("Heidenhain", heidenhain_files.table_text(Machine.load("xyzac-trunnion"))),
        ("Heidenhain", heidenhain_files.objects_text(Machine.load("xyzac-trunnion"))),
        ("", "%\nO1000\nN10 G21 G90\nN1320 G1 X5. Y1. F100\nN1420 M98 P1000\nN1430 G4 P500\nM30\n%\n"),
        ("", "0 BEGIN PGM A MM\n1 TOOL CALL 1 Z S1000\n2 L X+5 R0 FMAX\n3 END PGM A MM\n"),
    ],
)
def test_a_text_is_of_one_control_or_of_none(control, text):
    file = ControlFile("text", text)
    assert [reader.CONTROL for reader in readers.READERS if reader.recognises(file)] == ([control] if control else [])


def test_files_of_two_controls_are_refused(tmp_path, monkeypatch):
    other = SimpleNamespace(CONTROL="Other", TOLD_BY="its name", recognises=lambda file: "OTHER" in file.text)
    monkeypatch.setattr(readers, "READERS", (*readers.READERS, other))
    mill = written(tmp_path, mill_ini=ini_text("xyzac-trt-kins", "XYZAC"), other_txt="OTHER\n")
    with pytest.raises(ControlFileError, match=r"other.txt: is of Other, and .*mill.ini of LinuxCNC"):
        read_control([mill, tmp_path / "other.txt"])
