"""Plans played by the real LinuxCNC: rows through HAL's streamer, and long G93 streams of joints and of the tip."""

from __future__ import annotations

import re
import shutil

import numpy as np
import pytest

from testbed.linuxcnc.instance import execute, folder
from testbed.linuxcnc.play import play
from testbed.linuxcnc.streamed import PAD, against, play_stream, usage
from toolpace.cli import main
from toolpace.controls.export import PlannedMotion, export
from toolpace.machine.limits import Limits

HEAD = "G21 G90 G17 G94\nG0 X10 Y-5 Z12 A0 C0\nG1 Z8 F900\n"
SHORT = HEAD + "X20 Y0 A3 C4 F500\nG4 P0.2\nY4 A0\nM2\n"
LONG = HEAD + "X40 Y5 A8 C14 F300\nY30 A2\nG4 P0.3\nX5 Y20 A0 C0\nX10 Y-5 A-4\nG0 Z12\nM2\n"


def planned(program, place):
    """The folder of a plan, loaded."""
    file = place / "part.ngc"
    file.write_text(program)
    arguments = ["-m", "linuxcnc-xyzac-trt", "--no-report", "--out", str(place / "plan")]
    assert main(["plan", str(file), *arguments]) == 0
    return PlannedMotion.load(place / "plan")


def play_as_stream(motion, place, tip):
    """Play a G93 stream, and hold what LinuxCNC logs against the plan."""
    export(place / "plan", "linuxcnc-g93", place / "out", tip=tip, pad=PAD)
    found = against(play_stream(place / "out", motion.machine, 1e-3, tip=tip), motion)
    assert abs(found.cycles) <= 1
    assert found.slides < 1e-6 and np.degrees(found.turns) < 5e-4 and found.usage <= 1.01


def play_rows(motion, place):
    """Play streamer rows, and hold what comes out of limit3, set as play.hal sets it, against the plan."""
    export(place / "plan", "linuxcnc-hal", place / "out")
    rows = np.loadtxt(place / "out" / "rows.txt")
    text = (place / "out" / "play.hal").read_text()
    velocity, acceleration = (
        np.array([float(value) for value in re.findall(rf"limit3\.\d\.{pin} (\S+)", text)]) for pin in ("maxv", "maxa")
    )
    played = play(rows, Limits(velocity, acceleration, np.full(len(velocity), np.inf)))
    assert np.array_equal(played.commanded, rows) and np.array_equal(played.limited, rows)
    scale = motion.shop_units[1]
    lead = int(re.search(r"row ([0-9]+) is the first of the plan", (place / "out" / "rows.txt").read_text())[1]) - 1
    found = played.limited[lead : lead + len(motion.setpoints)] / scale
    assert np.allclose(found, motion.setpoints.q, rtol=1e-15, atol=1e-18)
    assert usage(played.limited / scale, motion.machine.limits, 1e-3) <= 1.01


def run_hal_file(motion, place):
    """Run play.hal as it is, and see where limit3 ends."""
    with folder() as away:
        for name in ("play.hal", "rows.txt"):
            shutil.copy(place / "out" / name, away / name)
        seconds = len((away / "rows.txt").read_text().splitlines()) * 1e-3 + 2.0
        with (away / "play.hal").open("a") as stream:
            stream.write(f"loadusr -w sleep {seconds:.0f}\nshow pin limit3\n")
        printed = execute(["halrun", "-f", "play.hal"], away, 300.0)
    out = {int(pin): float(value) for value, pin in re.findall(r"OUT\s+(\S+)\s+limit3\.(\d)\.out", printed)}
    end = motion.setpoints.q[-1] * motion.shop_units[1]
    assert len(out) == len(end), printed
    assert np.allclose([out[k] for k in range(len(end))], end, rtol=1e-5, atol=1e-5)


@pytest.mark.linuxcnc
@pytest.mark.sweep
def test_a_plan_is_played_through_hal(tmp_path):
    motion = planned(SHORT, tmp_path)
    play_rows(motion, tmp_path)
    run_hal_file(motion, tmp_path)


@pytest.mark.linuxcnc
@pytest.mark.thorough
@pytest.mark.parametrize("tip", [False, True])
def test_a_plan_of_twenty_seconds_is_played_as_a_stream(tmp_path, tip):
    motion = planned(LONG, tmp_path)
    assert motion.duration > 20.0
    play_as_stream(motion, tmp_path, tip)


@pytest.mark.linuxcnc
@pytest.mark.thorough
def test_a_plan_of_twenty_seconds_is_played_through_hal(tmp_path):
    motion = planned(LONG, tmp_path)
    assert motion.duration > 20.0
    play_rows(motion, tmp_path)
