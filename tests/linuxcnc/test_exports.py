"""Plans played by the real LinuxCNC: a G93 stream of joints, one of the tip, and rows through HAL's streamer."""

from __future__ import annotations

import re
import shutil

import numpy as np
import pytest

from testbed.linuxcnc.configuration import Configuration
from testbed.linuxcnc.instance import execute, folder
from testbed.linuxcnc.play import play
from testbed.linuxcnc.run import run_program
from toolpace.cli import main
from toolpace.exporting import PlannedMotion, export
from toolpace.machine.limits import Limits

HEAD = "G21 G90 G17 G94\nG0 X10 Y-5 Z12 A0 C0\nG1 Z8 F900\n"
SHORT = HEAD + "X20 Y0 A3 C4 F500\nG4 P0.2\nY4 A0\nM2\n"
LONG = HEAD + "X40 Y5 A8 C14 F300\nY30 A2\nG4 P0.3\nX5 Y20 A0 C0\nX10 Y-5 A-4\nG0 Z12\nM2\n"
SWING = 1e-8
"""[m or rad] Above what the stream swings while it rests."""


def planned(program, place):
    """The folder of a plan, loaded."""
    file = place / "part.ngc"
    file.write_text(program)
    arguments = ["-m", "linuxcnc-xyzac-trt", "--no-report", "--out", str(place / "plan")]
    assert main(["plan", str(file), *arguments]) == 0
    return PlannedMotion.load(place / "plan")


def lifted(machine):
    """The machine without limits: the plan keeps them by itself."""
    none = np.full(len(machine.joints), np.inf)
    return machine.with_limits(Limits(none, none, none, machine.joints))


def usage(joints, limits, step):
    """Largest share of a limit, by differences of positions (n, m) `step` [s] apart."""
    kinds = (limits.velocity, limits.acceleration, limits.jerk)
    return max(
        float((np.abs(np.diff(joints, n=order, axis=0)).max(axis=0) / step**order / limit).max())
        for order, limit in enumerate(kinds, start=1)
    )


def shift_of(joints, points):
    """The one shift in cycles by which a log (n, m) lies behind set-points (k, m)."""
    least = [
        (float(np.abs(joints[first : first + len(points) : 5] - points[::5]).max()), first)
        for first in range(len(joints) - len(points) + 1)
    ]
    return min(least)[1]


def play_stream(motion, place, tip):
    """Play a G93 stream, and hold what LinuxCNC logs against the plan."""
    export(place / "plan", "linuxcnc-g93", place / "out", tip=tip)
    free = lifted(motion.machine)
    configuration = Configuration.tip(free) if tip else Configuration.joints(free)
    # In real time: run faster, the interpreter of a busy computer leaves the queue empty.
    log = run_program((place / "out" / "stream.ngc").read_text(), configuration, speed=1)
    joints, points = log.of(motion.joints), motion.setpoints.q
    # The rapid to the start and its settling come first: the stream begins when the start is reached.
    there = np.flatnonzero(np.abs(joints - points[0]).max(axis=1) < SWING)
    stream = joints[there[0] + 2 :]
    first = shift_of(stream, points)
    off = np.abs(stream[first : first + len(points)] - points)
    lengths = ~np.array(motion.rotary)
    assert off[:, lengths].max() < 1e-6 and np.degrees(off[:, ~lengths].max()) < 1e-4
    moving = np.flatnonzero((np.abs(stream - points[0]) > SWING).any(axis=1))
    still = np.flatnonzero((np.abs(stream - points[-1]) > SWING).any(axis=1))
    moves = np.flatnonzero((np.abs(points - points[0]) > SWING).any(axis=1))
    stops = np.flatnonzero((np.abs(points - points[-1]) > SWING).any(axis=1))
    duration, right = still[-1] - moving[0], stops[-1] - moves[0]
    assert abs(duration / right - 1.0) < 5e-3
    # A block is two cycles of even speed, so that differences are taken over two cycles, in both phases.
    assert max(usage(stream[phase::2], motion.machine.limits, 2e-3) for phase in (0, 1)) <= 1.01


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
def test_a_plan_is_played_by_the_tip_and_through_hal(tmp_path):
    motion = planned(SHORT, tmp_path)
    play_stream(motion, tmp_path, tip=True)
    play_rows(motion, tmp_path)
    run_hal_file(motion, tmp_path)


@pytest.mark.linuxcnc
@pytest.mark.thorough
@pytest.mark.parametrize("tip", [False, True])
def test_a_plan_of_twenty_seconds_is_played_as_a_stream(tmp_path, tip):
    motion = planned(LONG, tmp_path)
    assert motion.duration > 20.0
    play_stream(motion, tmp_path, tip)


@pytest.mark.linuxcnc
@pytest.mark.thorough
def test_a_plan_of_twenty_seconds_is_played_through_hal(tmp_path):
    motion = planned(LONG, tmp_path)
    assert motion.duration > 20.0
    play_rows(motion, tmp_path)
