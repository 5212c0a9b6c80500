"""The harness: what LinuxCNC did not do is told, in one line."""

from __future__ import annotations

import numpy as np
import pytest

from testbed.linuxcnc import instance
from testbed.linuxcnc.configuration import Configuration
from testbed.linuxcnc.patterns import holding_tip
from testbed.linuxcnc.play import play
from testbed.linuxcnc.run import LinuxCNCError, _marked, run_program
from toolpace.common.errors import UsageError
from toolpace.machine.limits import Limits
from toolpace.machine.machine import Machine

MACHINE = Machine.load("linuxcnc-xyzac-trt")
HEAD = "G21 G90 G94 G61\n"


@pytest.mark.linuxcnc
@pytest.mark.sweep
def test_a_line_takes_what_its_trapezoid_takes():
    """20 mm at 10 mm/s under 300 mm/s^2: 2 s and a ramp, whole cycles, one more at each end by its smoothing."""
    log = run_program(HEAD + "G1 X20 F600\nM2\n", Configuration.joints(MACHINE))
    assert log.ended and log.letters == ("X", "Y", "Z", "A", "C")
    assert abs(log.duration - (2.0 + 10 / 300)) <= 3.1e-3
    assert np.isclose(log.of(("X",))[-1, 0], 0.020, atol=1e-12)
    assert np.isclose(log.speed.max(), 0.010)


@pytest.mark.linuxcnc
@pytest.mark.sweep
def test_an_early_stop_is_told_with_its_message():
    with pytest.raises(LinuxCNCError, match=r"stopped .*Bad character"):
        run_program(HEAD + "G1 X2 F600\nbad word\nM2\n", Configuration.joints(MACHINE))


@pytest.mark.linuxcnc
@pytest.mark.sweep
def test_a_run_that_takes_too_long_is_ended():
    with pytest.raises(LinuxCNCError, match="did not end within 3 s"):
        run_program(HEAD + "G4 P1000\nG1 X1 F600\nM2\n", Configuration.joints(MACHINE), seconds=3.0)


@pytest.mark.linuxcnc
@pytest.mark.sweep
def test_rows_are_played_as_they_are_and_limit3_changes_those_beyond_its_limits():
    s = np.linspace(0.0, 1.0, 1001)
    law = s**3 * (10 - 15 * s + 6 * s**2)
    rows = np.column_stack([5.0 + 10.0 * law, 7.0 - 3.0 * law])
    velocity = np.abs(np.diff(rows, axis=0)).max(axis=0) / 1e-3
    acceleration = np.abs(np.diff(rows, 2, axis=0)).max(axis=0) / 1e-6
    jerk = np.full(2, np.inf)
    kept = play(rows, Limits(1.0005 * velocity, 1.003 * acceleration, jerk))
    assert np.array_equal(kept.commanded, rows) and np.all(kept.deviation == 0.0)
    held = play(rows, Limits(0.98 * velocity, 1.003 * acceleration, jerk))
    assert np.all(held.deviation > 1e-3)


def test_the_mark_of_the_end_stands_in_the_last_block():
    """Lines keep their numbers, and subroutines that end with M2 theirs."""
    assert _marked("G1 X1\nN20 M30\n%\n") == "G1 X1\nN20 M64 P0 M30\n%\n"
    assert _marked("o1 sub\nM2\no1 endsub\nm02\n").endswith("M2\no1 endsub\nM64 P0 m02\n")
    with pytest.raises(LinuxCNCError, match="no M2 or M30"):
        _marked("G1 X1 M200\nM20\n")


def test_a_missing_linuxcnc_is_named_with_the_cure(monkeypatch):
    monkeypatch.setattr(instance.shutil, "which", lambda name: None)
    with pytest.raises(LinuxCNCError, match="apt-get install"):
        run_program("M2\n", Configuration.joints(MACHINE))


@pytest.mark.parametrize("name", ["xyzac-head", "xyzbc-nutating"])
def test_machines_that_linuxcnc_has_no_kinematics_for_are_refused(name):
    with pytest.raises(UsageError, match="run it as joints"):
        holding_tip(Machine.load(name))


def test_a_part_that_is_not_in_the_zero_of_the_machine_is_refused():
    with pytest.raises(UsageError, match="mount the part there"):
        holding_tip(MACHINE.mounted(origin=(0.0, 0.0, 0.01)))
