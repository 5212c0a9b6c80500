"""The model `linuxcnc` against what LinuxCNC 2.9 itself took: recorded runs, and one that is run here."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from testbed.linuxcnc.configuration import Configuration
from testbed.linuxcnc.instance import missing
from testbed.linuxcnc.run import run_program
from testbed.linuxcnc.timed import corners
from toolpace.common.errors import UsageError
from toolpace.controls.timing.linuxcnc import Canon, LinuxCNC, Waits, linuxcnc_times
from toolpace.machine.limits import Limits
from toolpace.machine.machine import Machine
from toolpace.programs.commanded import BLENDED, EXACT_PATH
from toolpace.programs.reading import Source, read_commanded

MACHINE = Machine.load("linuxcnc-xyzac-trt")
HEAD = "G21 G90 G94 G17 {mode}\nG0 X0 Y0 Z0 A0 C0\n"
SMOOTHED = 3.1e-3
"""A log is two cycles longer than the motion: LinuxCNC takes means of joints over three; and one for the start [s]."""

TURNS = (
    "X10 Y5\nA-5 C20\nX20 Z2\nG1 X30 F1500\nA-10 C30 F2000\nX40 Y10 F1500\nA0\nZ5\nX30\nG0 A-4\nC10\nY0"
)
"""Turns in place between ways."""

RECORDED = [
    ("", TURNS, 6.443),
    ("G64", TURNS, 5.711),
    ("G64", "G1 X20 F600", 2.069),
    ("G61", "G1 X20 F600", 2.036),
    ("G64", "G1 X20 F1000\nG1 Y20\nG1 X0\nG1 Y0", 4.795),
    ("G64 P0.1", "G1 X20 F1000\nG1 Y20\nG1 X0\nG1 Y0", 4.997),
    ("G61", "G1 X20 F1000\nG1 Y20\nG1 X0\nG1 Y0\nG0 X10\nG0 Y10", 6.200),
    ("G64", "G1 X20 A10 F1000\nG1 Y20 A5\nG1 X0 C20\nG1 Y0\nG1 X5\nG1 A0", 5.455),
    ("G64", "G1 X0 Y12 F800\nG1 X0 Y0", 1.936),
    ("G64", "G1 X0 Y12 F800\nG1 X12 Y12 F360\nG1 X12 Y21", 4.354),
    ("G64 P0.01", "G2 X3 Y3 I3 J0 F900", 0.517),
    ("G61", "G2 X3 Y3 I3 J0 F900", 0.417),
    ("G64 P0.01", "G3 X0 Y0 I-3 J0 Z-2 F900", 1.465),
    ("G64 P0.01", "G1 X10 F900\nG3 X10 Y10 J5\nG1 X0", 2.459),
    ("G64 P0.2", "G1 X10 F900\nG3 X17 Y7 I7 J0\nG1 X0", 4.084),
    ("G64 P0.2", "G1 X10 F900\nG2 X17 Y-7 I7 J0\nG1 X30", 3.893),
    ("G64 P0.2", "G2 X10 Y0 I5 J0 F900\nG1 X0 Y-10", 2.058),
    ("G64 P0.2", "G2 X10 Y0 I5 J0 F900\nG2 X20 I5\nG3 X30 I5 J0", 3.323),
    ("G64 P0.05", "G3 X0 Y0 Z-1.5 I-3 J0 F600\nG1 X10 F900", 2.703),
    ("G64 P0.05", "G1 X10 F600\nG3 X10 Y0 I-3 J0", 3.013),
    ("G64", "G93\nG1 X12 F30\nY9 F70\nX8 Y12.5 F110\nX7.9 Y12.6 F150\nX0 Y12 F190\nX0 Y0 F230", 4.437),
    ("G64", "G0 X12\nY9\nX8 Y12.5\nX7.9 Y12.6\nX0 Y12\nX0 Y0", 2.354),
]
"""Path mode, blocks, and the time from the first moving cycle to the last in LinuxCNC's log [s]; without a mode it
blends within a tolerance of its own."""


def moves_of(blocks: str, mode: str = "G64", machine: Machine = MACHINE):
    return read_commanded(Source.from_text(f"{HEAD.format(mode=mode)}{blocks}\nM2\n", "part.ngc"), machine)


@pytest.mark.parametrize(("mode", "blocks", "seconds"), RECORDED)
def test_a_recorded_run_took_as_long(mode, blocks, seconds):
    moves = moves_of(blocks, mode)
    assert 0.0 <= seconds - linuxcnc_times(moves, MACHINE).sum() <= SMOOTHED


@pytest.mark.linuxcnc
@pytest.mark.sweep
@pytest.mark.skipif(bool(missing()), reason=missing() or "LinuxCNC is there")
def test_linuxcnc_takes_as_long_through_120_corners():
    text = corners()
    moves = read_commanded(Source.from_text(text, "part.ngc"), MACHINE)
    theirs = run_program(text, Configuration.tip(MACHINE)).duration
    assert linuxcnc_times(moves, MACHINE).sum() == pytest.approx(theirs, rel=2e-3)


def test_waits_are_added_between_motions_and_are_no_time_of_a_move():
    """A dwell waits for its time and three cycles; without it the corner would be rounded."""
    moves = moves_of("G1 X10 F600\nG4 P1\nG1 Y10", "G64")
    alone = linuxcnc_times(moves_of("G1 X10 F600"), MACHINE).sum()
    times = linuxcnc_times(moves, MACHINE)
    assert times[1] == pytest.approx(alone, abs=1e-9)
    assert times[2] == pytest.approx(alone + 3e-3, abs=1.1e-3)
    assert moves.dwell[1] == 1.0


def test_canned_cycles_are_on_the_exact_path():
    """As logged: three holes of LinuxCNC's, whose rapids do not overlap though G64 is in force."""
    moves = moves_of("G0 Z2\nG98 G81 X5 Y5 Z-4 R1 F300\nX9\nX15 Y9\nG80\nG1 X0 F900")
    assert moves.joining[2:-1].tolist() == [EXACT_PATH] * (len(moves) - 3)
    assert moves.joining[[1, -1]].tolist() == [BLENDED] * 2


def test_a_rotary_word_ends_tangential_chains():
    """A straight way in ten blocks is passed at its feed; turned by a thousandth of a degree it slows down at each."""
    ways = [f"X{k}" for k in range(1, 11)]
    straight = linuxcnc_times(moves_of("G1 F1200 " + "\n".join(ways)), MACHINE).sum()
    turned = linuxcnc_times(moves_of("G1 F1200 " + "\n".join(f"{w} A{1e-3 * k}" for k, w in enumerate(ways))), MACHINE)
    assert straight == pytest.approx(0.5 + 0.1, abs=0.06)
    # ten triangles at half the acceleration, each overlapping the next by half
    assert turned.sum() == pytest.approx(11 * np.sqrt(1.0 / 150.0), rel=1e-2)


def test_looking_less_far_ahead_takes_longer():
    moves = moves_of("G1 F1200 " + "\n".join(f"X{0.02 * k:.2f}" for k in range(1, 301)))
    far, near = (linuxcnc_times(moves, MACHINE, LinuxCNC(depth=depth)).sum() for depth in (50, 5))
    assert near > 1.2 * far


def test_a_tolerance_for_chains_makes_one_block_of_straight_ones():
    blocks = "G1 F900 " + "\n".join(f"X{k} Y{0.001 * (k % 2)}" for k in range(1, 31))
    apart, chained = moves_of(blocks, "G64 P0.01 Q0"), moves_of(blocks, "G64 P0.01 Q0.002")
    assert len(Canon(apart, MACHINE, Waits()).ends) == 30
    assert len(Canon(chained, MACHINE, Waits()).ends) == 1
    times = linuxcnc_times(chained, MACHINE)
    # its moves share the time by their lengths
    np.testing.assert_allclose(times[1:], times[1:].mean(), rtol=2e-3)


def test_flat_arcs_are_lines_and_arcs_of_several_turns_are_not():
    flat = moves_of("G3 X10 Y0 R5000 F600\nG2 X10 Y8 R900", "G64 P0.05 Q0.01")
    canon = Canon(flat, MACHINE, Waits())
    assert list(canon.blocks.figures[:, 0]) == [0.0, 0.0]
    # by way of the middle of the arc
    assert canon.rows.place[1, 1] == pytest.approx(-(5000.0 - np.sqrt(5000.0**2 - 25.0)), rel=1e-6)
    turns = moves_of("G3 X0 Y0 Z-4 I-6 J0 P4 F900", "G64 P0.05")
    assert list(Canon(turns, MACHINE, Waits()).blocks.figures[:, 0]) == [1.0]
    assert linuxcnc_times(turns, MACHINE).sum() > turns.length.sum() / 0.015


def test_time_follows_the_limits_of_the_words():
    """Twice the acceleration: the ramps of a move take half as long, whatever the joints do under it."""
    own = MACHINE.limits
    quick = MACHINE.with_limits(Limits(own.velocity, 2 * own.acceleration, own.jerk, own.joints))
    moves = moves_of("M428\nG1 X10 A20 C30 F600", "G61")
    ramp, short = (linuxcnc_times(moves, machine).sum() for machine in (MACHINE, quick))
    assert ramp - short == pytest.approx(0.5 * (ramp - moves.length.sum() / 0.01), abs=2e-3)


def test_a_program_without_motion_takes_none():
    moves = moves_of("G1 X0 F600\nG1 X1")
    assert linuxcnc_times(moves, MACHINE)[0] == 0.0
    assert len(linuxcnc_times(moves, MACHINE)) == len(moves)


def test_a_block_that_never_ends_is_named():
    moves = moves_of("G1 X1 F600\nG1 Y1")
    without_feed = dataclasses.replace(moves, speed=np.where(moves.line == 4, 0.0, moves.speed))
    with pytest.raises(UsageError, match=r"part\.ngc, line 4: LinuxCNC would not get to the end of this block"):
        linuxcnc_times(without_feed, MACHINE)


def test_a_dwell_before_the_first_motion_takes_nothing_off_it():
    text = HEAD.format(mode="G64") + "G4 P1\nG1 X10 F600\nM2\n"
    times = linuxcnc_times(read_commanded(Source.from_text(text, "part.ngc"), MACHINE), MACHINE)
    assert 1.0 < times.sum() < 1.2


@pytest.mark.parametrize(
    "mode", ["G64", *(pytest.param(mode, marks=pytest.mark.sweep) for mode in ("G64 P0.1", "G61", "G61.1"))]
)
def test_tiny_accelerations_take_longer_cycles_and_the_same_time(mode, monkeypatch):
    """A millionth of the acceleration takes a thousand times as long, and no more work."""
    rng = np.random.default_rng(0)
    place = np.cumsum(rng.normal(size=(20, 2)) * 3.0, axis=0)
    body = "".join(f"G1 X{x:.3f} Y{y:.3f} F90000\n" for x, y in place)
    moves = read_commanded(Source.from_text(f"G21 G90 G94 {mode}\nG0 X0 Y0 Z0 A0 C0\n{body}M2\n"), MACHINE)
    own = MACHINE.limits

    def total(share: float) -> float:
        on = MACHINE.with_limits(Limits(1e3 * own.velocity, share * own.acceleration, own.jerk, own.joints))
        return float(linuxcnc_times(moves, on).sum())

    exact = [total(share) for share in (1e-4, 1e-6)]
    monkeypatch.setattr("toolpace.controls.timing.linuxcnc.MOST_CYCLES", 2e5)
    coarse = [total(share) for share in (1e-4, 1e-6, 1e-12)]
    assert coarse[0] == pytest.approx(exact[0], rel=1e-3) and coarse[1] == pytest.approx(exact[1], rel=1e-3)
    assert coarse[2] == pytest.approx(1e3 * exact[1], rel=2e-3)


def test_ordinary_accelerations_keep_the_cycle(monkeypatch):
    from toolpace.controls.timing import linuxcnc

    asked = []
    real = linuxcnc._ramped
    monkeypatch.setattr(linuxcnc, "_ramped", lambda blocks: asked.append(real(blocks)) or asked[-1])
    text = "G21 G90 G94\nG0 X0 Y0 Z0 A0 C0\nG1 X100 F6000\nY100\nX0\nM2\n"
    linuxcnc_times(read_commanded(Source.from_text(text), MACHINE), MACHINE)
    assert len(asked) == 1 and asked[0] / 1e-3 < 1e-3 * linuxcnc.MOST_CYCLES
