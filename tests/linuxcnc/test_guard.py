"""The guard of G93 streams on the real LinuxCNC: right streams pass, wrong ones are stopped, none runs without it."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from testbed.linuxcnc.configuration import Configuration
from testbed.linuxcnc.machines import xyzbc_trt
from testbed.linuxcnc.run import run_program
from testbed.linuxcnc.streamed import PAD, STOPPED, against, configuration, play_stream
from toolpace.common.errors import UsageError
from toolpace.controls.export import PlannedMotion
from toolpace.controls.export.linuxcnc.inverse_time import InverseTime
from toolpace.machine.machine import Machine
from toolpace.motion.setpoints import SetPoints

MACHINE = Machine.load("linuxcnc-xyzac-trt")
DT = 1e-3
START, END = np.array([0.01, -0.005, 0.012, 0.0, 0.0]), np.array([0.018, 0.001, 0.012, 0.0, 0.0])
TURNED = np.array([0.018, 0.001, 0.014, 0.02, 0.03])
SECONDS = 0.8
"""Of a motion of X and Y: 10 mm with at most 23.4 mm/s and 90.2 mm/s^2."""
PEAKS = (1.875, 10.0 / np.sqrt(3.0), 60.0)
"""Of 10 u^3 - 15 u^4 + 6 u^5: slope, second and third derivative."""


def by_law(u):
    return u**3 * (10.0 - 15.0 * u + 6.0 * u**2)


def motion(machine=MACHINE, end=END, longer=0.0, seconds=SECONDS):
    """From rest to rest, straight in joints, by a polynomial: no planner, no program; with a tool that is longer than
    the machine's own [m]."""
    t = np.arange(round(seconds / DT) + 1) * DT
    u, way = (t / seconds)[:, None], end - START
    rates = [30 * u**2 * (1 - u) ** 2, 60 * u * (1 - u) * (1 - 2 * u), 60 * (1 - 6 * u + 6 * u**2)]
    q = START + by_law(u) * way
    qd, qdd, qddd = (rate * way / seconds**order for order, rate in enumerate(rates, start=1))
    lengths = np.full(len(t), machine.tool_length + longer)
    tip, axis = machine.forward(q, lengths)
    block = np.ones(len(t), dtype=np.int64)
    points = SetPoints(t, q, qd, qdd, qddd, tip, axis, block, machine.joints, lengths)
    return PlannedMotion(points, machine, "line", "line.ngc", seconds, sha256={"machine": "none"})


def written(folder):
    """The lines of a stream of it, and the numbers of its blocks."""
    InverseTime(pad=PAD).write(motion(), folder)
    lines = (folder / "stream.ngc").read_text().splitlines()
    return lines, [k for k, line in enumerate(lines) if line.startswith("G1")]


def limits_of(folder):
    """Velocity and acceleration of X at which the guard stops [m/s, m/s^2]."""
    text = (folder / "limits.hal").read_text()
    return [float(re.search(rf"{kind}-window-0\.max (\S+)", text)[1]) * 1e-3 for kind in ("velocity", "acceleration")]


def in_exact_path(lines, blocks):
    return [line.replace("G61.1", "G61") for line in lines]


def every_second_block(lines, blocks):
    """From the motion on: the same way in half the time."""
    dropped = set(blocks[1001::2])
    return [line for k, line in enumerate(lines) if k not in dropped]


def one_block_aside(lines, blocks):
    """By half a millimetre."""
    at = blocks[1200]
    aside = re.sub(r"Z([-\d.]+)", lambda found: f"Z{float(found[1]) + 0.5:.9f}", lines[at])
    return [*lines[:at], aside, *lines[at + 1 :]]


@pytest.mark.linuxcnc
@pytest.mark.sweep
def test_a_right_stream_passes_and_one_in_exact_path_is_stopped(tmp_path):
    """In exact path its straight blocks, which turn no axis, take one cycle in place of two."""
    lines, blocks = written(tmp_path)
    right = play_stream(tmp_path, MACHINE, DT)
    found = against(right, motion())
    assert right.ended and not right.messages
    assert abs(found.cycles) <= 1 and found.slides < 2e-6
    wrong = play_stream(tmp_path, MACHINE, DT, stream="\n".join(in_exact_path(lines, blocks)) + "\n", to_the_end=False)
    assert not wrong.ended and wrong.messages == (STOPPED,)
    # it is stopped while it speeds up: it has come less than a millimetre of ten
    assert np.abs(wrong.of(("X", "Y"))[-1] - START[:2]).max() < 1e-3


@pytest.mark.linuxcnc
@pytest.mark.sweep
@pytest.mark.parametrize(
    "machine, longer, coordinates",
    [(xyzbc_trt(), 0.03, ""), (Machine.load("linuxcnc-xyzbc-bridgemill"), 0.0, "XYZBCW")],
    ids=lambda value: getattr(value, "name", None),
)
def test_streams_of_the_tip_pass_on_other_kinematics(machine, longer, coordinates, tmp_path):
    planned = motion(machine, TURNED, longer)
    InverseTime(tip=True, pad=PAD, coordinates=coordinates).write(planned, tmp_path)
    log = play_stream(tmp_path, machine, DT, tip=True)
    found = against(log, planned)
    assert log.ended and not log.messages
    assert abs(found.cycles) <= 1 and found.slides < 2e-6 and found.turns < 2e-5


@pytest.mark.linuxcnc
@pytest.mark.sweep
def test_kinematics_that_are_not_told_of_the_tool_are_noticed(tmp_path):
    """Upright, every joint stands where it should, and only when the axis tilts they would not."""
    machine = xyzbc_trt()
    InverseTime(tip=True).write(motion(machine, TURNED, 0.03), tmp_path)
    untold = replace(Configuration.tip(machine).pattern, tool_pin="")
    guard = tuple((tmp_path / name).read_text() for name in ("guard.hal", "limits.hal"))
    text = (tmp_path / "stream.ngc").read_text()
    log = run_program(text, Configuration(machine, untold), hal=guard, to_the_end=False)
    assert log.messages == ("toolpace: its kinematics are not told of the tool, 30.000 mm longer",)


@pytest.mark.linuxcnc
@pytest.mark.sweep
@pytest.mark.parametrize("wrong", [every_second_block, one_block_aside])
def test_a_wrong_stream_is_stopped(wrong, tmp_path):
    lines, blocks = written(tmp_path)
    text = "\n".join(wrong(lines, blocks)) + "\n"
    log = play_stream(tmp_path, MACHINE, DT, stream=text, to_the_end=False)
    assert not log.ended and log.messages == (STOPPED,)
    assert np.abs(log.of(("X", "Y", "Z"))[-1] - END[:3]).max() > 1e-3


@pytest.mark.linuxcnc
@pytest.mark.sweep
def test_no_stream_runs_along_the_path_without_what_it_wants(tmp_path):
    """Each time it stays at the start, or where the offset takes it, and says why."""
    lines, _ = written(tmp_path)
    text = "\n".join(lines) + "\n"
    guard, limits = ((tmp_path / name).read_text() for name in ("guard.hal", "limits.hal"))
    stamp = re.search(r"plan\.value (\d{2,})", limits)[1]
    own = configuration(MACHINE, DT)
    # 2.9 has no such pin: a signal of its name stands for that of 2.10
    planner = "newsig ini.traj_planner_type s32\nsets ini.traj_planner_type 1\n"
    for hal, machine, stream, message in (
        ((), own, text, "guard.hal is not loaded"),
        ((guard,), own, text, "limits.hal is not that of this stream"),
        ((guard, limits.replace(stamp, "7")), own, text, "limits.hal is not that of this stream"),
        ((guard, limits, planner), own, text, "PLANNER_TYPE is not 0"),
        ((guard, limits), replace(own, cycle=2e-3), text, "SERVO_PERIOD is not 1000000 ns"),
        ((guard, limits), own, text.replace("G94\n", "G94\nG92 Y1\n", 1), "joint 1 Y stands beside -5.0000"),
    ):
        log = run_program(stream, machine, hal=hal, to_the_end=False)
        assert not log.ended and len(log.messages) == 1 and message in log.messages[0]
        assert np.ptp(log.joints[-50:], axis=0).max() == 0.0
        assert np.abs(log.of(("X", "Z"))[-1] - START[[0, 2]]).max() < 1e-8


@pytest.mark.linuxcnc
@pytest.mark.sweep
def test_limits_are_those_of_the_machine_before_and_behind_a_stream(tmp_path):
    """20 mm at more than the machine can, before and behind: its own velocity and acceleration, 20 mm/s and 300."""
    lines, _ = written(tmp_path)
    end = len(lines) - 1
    assert lines[end] == "M2"
    text = "\n".join(["G21 G90", "G0 X25 Y15", "G0 X5", *lines[:end], "G0 X-15", "M2"]) + "\n"
    log = play_stream(tmp_path, MACHINE, DT, stream=text)
    assert log.ended
    x = log.of(("X",))[:, 0]
    rates = [np.abs(np.diff(x, n)) / DT**n for n in (1, 2)]
    own = MACHINE.limits
    assert rates[0].max() <= own.velocity[0] * 1.0001 and rates[0][-300:].max() > 0.9 * own.velocity[0]
    assert rates[1][:2000].max() <= own.acceleration[0] * 1.0001
    assert rates[1][-1000:].max() <= own.acceleration[0] * 1.0001


class TestText:
    def test_limits_stand_a_few_per_cent_above_the_law(self, tmp_path):
        written(tmp_path)
        velocity, acceleration = limits_of(tmp_path)
        assert velocity == pytest.approx(1.03 * PEAKS[0] * 0.008 / SECONDS, rel=1e-4)
        assert acceleration == pytest.approx(1.05 * PEAKS[1] * 0.008 / SECONDS**2, rel=1e-4)

    def test_a_joint_that_rests_may_use_a_thousandth_of_its_limits(self, tmp_path):
        written(tmp_path)
        found = dict(re.findall(r"setp toolpace-(\S+)\.max (\S+)", (tmp_path / "limits.hal").read_text()))
        limit = np.degrees(MACHINE.limits.velocity[3]), np.degrees(MACHINE.limits.acceleration[3])
        assert float(found["velocity-window-3"]) == pytest.approx(1e-3 * limit[0])
        assert float(found["acceleration-window-3"]) == pytest.approx(1e-3 * limit[1])

    def test_joints_are_numbered_by_the_coordinates_that_are_given(self, tmp_path):
        InverseTime(coordinates="XYYZACW").write(motion(), tmp_path)
        text = (tmp_path / "limits.hal").read_text()
        most = [float(re.search(rf"velocity-window-{n}\.max (\S+)", text)[1]) for n in range(7)]
        assert most[1] == most[2] == pytest.approx(0.75 * most[0], rel=1e-6) and most[6] == 1e-2
        assert "[AXIS_W]MAX_VELOCITY" in (tmp_path / "guard.hal").read_text()
        assert "joint.3.pos-cmd]> - [12.000000]" in (tmp_path / "stream.ngc").read_text()

    @pytest.mark.parametrize(
        "options, message",
        [
            ({"coordinates": "XYZ"}, r"--coordinates XYZ: lacks A, C"),
            ({"coordinates": "XYZQ"}, r"LinuxCNC has no axis Q"),
            ({"coordinates": "XYZAC" * 3}, r"15 joints, and the guard watches 14"),
            ({"guard_output": 64}, r"--guard-output 64: LinuxCNC's digital outputs are 0 to 63"),
        ],
    )
    def test_what_it_cannot_watch_is_refused(self, options, message, tmp_path):
        with pytest.raises(UsageError, match=message):
            InverseTime(**options).write(motion(), tmp_path)
