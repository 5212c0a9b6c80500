"""`toolpace machines --from`: what it shows, writes and asks."""

from __future__ import annotations

import io

import pytest

from tests.support.linuxcnc_files import ini_text, written
from toolpace.cli import main
from toolpace.machine.file_writer import pose_table
from toolpace.machine.machine import Machine
from toolpace.programs.reading.setup_file import setup_in

TABLE = ini_text("xyzac-trt-kins", "XYZAC")


@pytest.fixture
def mill(tmp_path):
    return written(tmp_path, mill_ini=TABLE)


class _Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def test_a_machine_is_written_and_loads(mill, tmp_path, capsys):
    place = tmp_path / "my-mill.toml"
    assert main(["machines", "--from", str(mill), "--write", str(place)]) == 0
    shown = capsys.readouterr().out
    assert "stand-in   jerk of C [deg/s^3]: not in these files; 9000 is taken, ten times the acceleration" in shown
    assert f"toolpace machines {place} --poses" in shown
    machine = Machine.load(place)
    assert machine.kind == "table-table" and machine.name == "test mill"
    assert setup_in(machine).machine_zero == {"X": 0.0, "Y": 0.0, "Z": 0.0}


def test_a_machine_is_shown_printed_and_posed_without_a_file(mill, tmp_path, capsys):
    assert main(["machines", "--from", str(mill)]) == 0
    assert "-300 .. 250 mm" in capsys.readouterr().out
    assert main(["machines", "--toml", "--from", str(mill)]) == 0
    machine = Machine.from_toml(capsys.readouterr().out)
    assert main(["machines", "--poses", "--from", str(mill)]) == 0
    assert pose_table(machine.geometry) in capsys.readouterr().out
    assert [path.name for path in tmp_path.iterdir()] == ["mill.ini"]


def test_a_person_at_a_terminal_is_asked(mill, tmp_path, capsys, monkeypatch):
    """A slip is asked about again; an empty answer, and the end of what is typed, are the stand-in."""
    monkeypatch.setattr("sys.stdin", _Terminal("fast\n12345\n\n"))
    monkeypatch.setattr("sys.stdout.isatty", lambda: True, raising=False)
    place = tmp_path / "my-mill.toml"
    assert main(["machines", "--from", str(mill), "--write", str(place)]) == 0
    shown = capsys.readouterr().out
    assert "jerk of X [mm/s^3]\n  [9000: ten times the acceleration, per second]" in shown
    assert "'fast'; give a number" in shown
    assert "jerk of X [mm/s^3]: not in" not in shown and "jerk of Y [mm/s^3]: not in" in shown
    joints = Machine.load(place).file.joints
    assert joints["X"].jerk == pytest.approx(12.345) and joints["Y"].jerk == pytest.approx(9.0)
    assert "# mm/s^3; answered to the question for it" in place.read_text()


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["xyzac-trunnion", "--from", "MILL"], "machine xyzac-trunnion and --from: give one of both"),
        (["--write", "my.toml"], "--write goes with --from"),
        (["--write-controller", "my.toml"], "--write-controller goes with --from"),
        (["--from", "MILL", "--write-controller", "my.toml"], "files of LinuxCNC have no figures"),
        (["--from", "MILL", "--toml", "--poses"], "--toml and --poses: one at a time"),
        (["--from", "MILL", "--write", "MILL"], "is there already"),
        (["--from", "no.ini"], "no.ini: cannot be read"),
    ],
)
def test_words_that_make_no_sense_end_with_one_line(words, message, mill, capsys):
    assert main(["machines", *(str(mill) if word == "MILL" else word for word in words)]) == 2
    error = capsys.readouterr().err
    assert message in error and error.count("\n") == 1


def test_a_program_is_inspected_on_a_machine_of_three_axes(tmp_path, capsys):
    place, sheet = tmp_path / "mill.toml", tmp_path / "sheet.toml"
    written(tmp_path, mill_ini=ini_text("trivkins coordinates=XYZ", "XYZ"))
    (tmp_path / "part.ngc").write_text("G21 G90 G94 G54\nT1 M6\nG43 H1\nG0 X0 Y0 Z20\nG1 X50 F900\nG53 G0 Z0\nM2\n")
    assert main(["machines", "--from", str(tmp_path / "mill.ini"), "--write", str(place)]) == 0
    capsys.readouterr()
    inspected = ["inspect", str(tmp_path / "part.ngc"), "-m", str(place), "--write-setup", str(sheet)]
    assert main(inspected) == 0
    assert "test mill" in capsys.readouterr().out
    assert "[machine_zero]" in sheet.read_text()
