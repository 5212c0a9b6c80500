"""The component plays what the follower gives, without a gap, from where the joints stand to where it is stopped."""

from __future__ import annotations

import os
import re
import signal
import sys

import numpy as np
import pytest

import toolpace as tp
from tests.support.hal import FakeHal
from toolpace.cli import main
from toolpace.common.errors import UsageError
from toolpace.common.units import DEGREE, MILLIMETRE
from toolpace.controls import hal_component
from toolpace.controls.hal import hal_module
from toolpace.controls.hal_component import Component, Settings
from toolpace.deflection.following import Follower, Status
from toolpace.kernels.follow import layout

PROGRAM = "G21 G90 G17 G94\nG0 X10 Y-5 Z12 A0 C0\nG1 Z11 F900\nX13 Y-3 A2 C3 F500\nM2\n"
UNITS = np.array([MILLIMETRE] * 3 + [DEGREE] * 2)
BACKLOG, DELAY = 10e-3, 13e-3
FAST = 4e-3
"""Motion in a period [mm]."""
ROUNDING = 1e-3
"""Of third differences of rows in mm, which have sixteen digits."""


@pytest.fixture(scope="module")
def machine():
    return tp.Machine.load("linuxcnc-xyzac-trt")


@pytest.fixture(scope="module")
def law(machine, tmp_path_factory):
    """A file of a law of about two seconds."""
    on = machine.reserved(0.1)
    toolpath = tp.read_text(PROGRAM, machine, name="short.ngc")
    follower = Follower(
        tp.plan(tp.Path.fit(toolpath, machine=on), on),
        machine,
        delay=DELAY,
        gain=0.1,
        max_correction=1e-4,
        patience=0.1,
    )
    file = tmp_path_factory.mktemp("law") / "short.law"
    follower.save(file)
    return file


def played(law, hal, monkeypatch, connect=lambda pins: None, **settings):
    """Run the component until it is asked to end, with its pins connected."""
    monkeypatch.setattr(hal_component, "time", hal.clock)
    made = Component(Follower.load(law), hal, Settings(backlog=BACKLOG, **settings))
    connect(hal.component_made)
    hal.component_made["enable"] = 1
    made.run()


def ended_at(status=Status.ENDED, beyond=300):
    """A script that ends the component some periods after a status was shown."""
    seen = []

    def script(period, pins):
        if pins["status"] & status:
            seen.append(period)
        if len(seen) == beyond:
            os.kill(os.getpid(), signal.SIGTERM)

    return script


def usage(rows, machine):
    """Largest share of a limit by differences of rows a period apart."""
    limits = machine.limits
    return max(
        float((np.abs(np.diff(rows * UNITS, order, axis=0)).max(axis=0) / 1e-3**order / limit).max())
        for order, limit in enumerate((limits.velocity, limits.acceleration, limits.jerk), 1)
    )


def test_rows_are_what_step_gave_from_where_the_joints_stand(law, machine, monkeypatch, tmp_path):
    hal = FakeHal(periods=3)
    ends = ended_at()

    def script(period, pins):
        pins["deflection-x"], pins["deflection-y"] = (0.06, -0.03) if period > 500 else (0.0, 0.0)
        ends(period, pins)

    def stand(pins):
        for j, value in enumerate((1.0, 2.0, -3.0, 4.0, 5.0)):
            pins[f"position-{j}"] = value

    hal.script = script
    record = tmp_path / "given.csv"
    played(law, hal, monkeypatch, stand, record=record)
    given = np.genfromtxt(record, delimiter=",", names=True)
    joints = np.column_stack([given[f"joint_{j}"] for j in range(5)])
    rows = np.array(hal.played)
    assert np.array_equal(rows[0], [1.0, 2.0, -3.0, 4.0, 5.0])
    assert np.array_equal(rows[given["row"].astype(int)], joints)
    assert usage(hal.rows, machine) <= 1.0 + ROUNDING
    # bent by 0.06 and -0.03 mm of the part, which is turned in the end: it aims off by their opposites
    correction = [given[f"correction_{j}"][-1] for j in range(5)]
    aimed, path = (machine.forward((each * UNITS)[None])[0][0] for each in (joints[-1], joints[-1] - correction))
    assert (aimed - path) / MILLIMETRE == pytest.approx([-0.06, 0.03, 0.0], abs=1e-4)
    shown = np.flatnonzero(np.isfinite(given["deflection_x"]))
    assert np.diff(shown).max() == 3
    assert hal.component_made.gone and not hal.component_made["playing"] and hal.component_made["late"] == 0


def test_a_signal_in_full_motion_stops_the_tool_within_its_limits(law, machine, monkeypatch):
    hal = FakeHal()
    asked = []

    def script(period, pins):
        pins["deflection-z"] = 0.05 * np.sin(0.02 * period)
        speed = np.abs(np.subtract(*hal.played[-2:])).max() if period > 1 else 0.0
        if pins["path-time"] > 0.3 and speed > FAST and not asked:
            asked.append(period)
            os.kill(os.getpid(), signal.SIGTERM)

    hal.script = script
    played(law, hal, monkeypatch)
    assert len(hal.played) > asked[0] + 50 and not hal.queue.rows
    assert usage(hal.rows, machine) <= 1.0 + ROUNDING


def test_it_holds_goes_on_and_stops_for_a_correction_at_its_limit_until_told_to_resume(law, machine, monkeypatch):
    hal = FakeHal()
    ends, stopped, stood = ended_at(beyond=1), [], []

    def script(period, pins):
        pins["hold"] = 500 < period < 900
        if 800 < period < 900:
            stood.append(pins["pace"])
        pins["deflection-x"] = 0.3 if period > 1000 and not stopped else 0.0
        if pins["status"] & Status.STOPPING and pins["pace"] == 0.0 and not stopped:
            stopped.append(period)
        pins["resume"] = bool(stopped) and period > stopped[0] + 400
        ends(period, pins)

    hal.script = script
    played(law, hal, monkeypatch)
    assert stopped and stood and max(stood) == 0.0
    assert usage(hal.rows, machine) <= 1.0 + ROUNDING


def test_a_row_that_comes_too_late_ends_it_with_the_cure(law, monkeypatch):
    hal = FakeHal(stalls=(700,))
    with pytest.raises(UsageError, match=r"came too late .* longer --backlog than 10 ms"):
        played(law, hal, monkeypatch)
    assert hal.component_made.gone and not hal.component_made["playing"] and hal.component_made["late"] > 0


@pytest.mark.parametrize(
    "hal, backlog, words",
    [
        (FakeHal(depth=0), BACKLOG, "no streamer number 0 .* loadrt streamer depth=1000 cfg=fffff"),
        (FakeHal(depth=10), BACKLOG, "holds 9 rows, the backlog is 10"),
        (FakeHal(), 14e-3, "delay of 13 ms, and a backlog of 14 ms"),
        (FakeHal(), 1e-3, "give two periods"),
        (FakeHal(taken="toolpace"), BACKLOG, "does not take a component 'toolpace'"),
    ],
)
def test_what_cannot_be_played_is_told_in_one_line(law, hal, backlog, words):
    with pytest.raises(UsageError, match=words):
        Component(Follower.load(law), hal, Settings(backlog=backlog))
    assert hal.component_made is None or hal.component_made.gone


def test_who_watches_sees_each_row_and_what_it_counted_on(law, monkeypatch):
    hal, seen = FakeHal(periods=3), []
    hal.script = ended_at(beyond=1)
    monkeypatch.setattr(hal_component, "time", hal.clock)
    made = Component(Follower.load(law), hal, Settings(backlog=BACKLOG), lambda *each: seen.append(each))
    hal.component_made["enable"] = 1
    made.run()
    rows = np.array([point.q for point, _ in seen]) / UNITS
    assert rows[-1] == pytest.approx(np.array(hal.played[-1]), abs=1e-12) and len(seen) > 500
    assert sum(deflection is not None for _, deflection in seen) == pytest.approx(len(seen) / 3, rel=0.02)


def test_the_command_tells_where_to_watch(law, monkeypatch, capsys):
    hal = FakeHal()
    hal.script = lambda period, pins: os.kill(os.getpid(), signal.SIGTERM)
    monkeypatch.setattr("toolpace.controls.hal.hal_module", lambda: hal)
    monkeypatch.setattr(hal_component, "time", hal.clock)
    assert main(["follow", str(law), "--backlog", "10ms", "--watch"]) == 0
    assert re.search(r"watch it +http://127\.0\.0\.1:\d+/[\w-]{32}/\n", capsys.readouterr().out)


def test_a_missing_linuxcnc_is_named_with_the_cure(law, monkeypatch, capsys, tmp_path):
    monkeypatch.setattr("toolpace.controls.hal.PLACES", ())
    monkeypatch.setitem(sys.modules, "hal", None)
    monkeypatch.delitem(sys.modules, "hal")
    with pytest.raises(UsageError, match=r"apt-get install linuxcnc-uspace.* PYTHONPATH"):
        hal_module(())
    (tmp_path / "hal.py").write_text("import _hal_of_another_python\n")
    with pytest.raises(UsageError, match=r"does not load in Python .* /usr/bin/python3"):
        hal_module((tmp_path,))
    assert str(tmp_path) not in sys.path
    assert main(["follow", str(tmp_path / "none.law")]) == 2
    assert "cannot read" in capsys.readouterr().err
    assert main(["follow", str(law), "--streamer", "9"]) == 2
    assert "--streamer 9: give 0 to 7" in capsys.readouterr().err


def test_the_dead_time_of_a_sensor_is_a_part_of_what_is_late(law, tmp_path, monkeypatch):
    """Each measurement is told when it comes: a law with both is played as one whose delay is their sum."""
    given = []
    for delay, dead_time in ((DELAY, 0.0), (DELAY - 2e-3, 2e-3)):
        follower = Follower.load(law)
        follower.piece[layout.DELAY], follower.piece[layout.DEAD_TIME] = delay, dead_time
        follower.save(tmp_path / "sensor.law")
        hal = FakeHal()
        ends = ended_at(beyond=1)

        def script(period, pins, ends=ends):
            pins["deflection-x"] = 0.05 * np.sin(0.01 * period)
            ends(period, pins)

        hal.script = script
        played(tmp_path / "sensor.law", hal, monkeypatch)
        given.append(np.array(hal.played))
    count = min(map(len, given))
    assert count > 1000 and np.abs(given[0][:count] - given[1][:count]).max() <= 1e-12


def test_a_law_of_limits_alone_is_not_played(tmp_path):
    limits = tp.Limits([0.3] * 5, 2.0, 40.0)
    path = tp.AxisPath.from_waypoints(np.vstack([np.zeros(5), 0.1 * np.ones(5)]))
    Follower(tp.plan(path, limits, bound=False), limits, delay=DELAY).save(tmp_path / "limits.law")
    with pytest.raises(UsageError, match="the law is of limits without a machine"):
        Component(Follower.load(tmp_path / "limits.law"), FakeHal(), Settings(backlog=BACKLOG))
