"""Stations of a motion: close together, at the right time, in the right block and operation."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

import toolpace as tp
from toolpace.cutting.engagement.stations import motion_stations, program_stations
from toolpace.errors import UsageError

MACHINE = tp.Machine.load("xyzac-trunnion")
PROGRAM = """G90 G21 G94
T1 M6
G0 X0 Y0 Z50
G1 X10 Y2 F2000
X20 A10 C40
G0 Z60
T2 M6
G1 X30 Y5 A5 C50
C400
G2 X30 Y5 I5
M30
"""


@pytest.fixture(scope="module")
def planned():
    toolpath = tp.read_text(PROGRAM, MACHINE)
    return toolpath, tp.plan(tp.Path.fit(toolpath, machine=MACHINE), MACHINE, bound=False)


@pytest.fixture(scope="module")
def parts(planned):
    return motion_stations(planned[1], planned[0], 0.5e-3, [0.1, 0.1])


def test_neither_tip_nor_holder_moves_farther_than_the_spacing(parts):
    for part in parts:
        for point in (part.tip, part.tip + 0.1 * part.axis):
            assert np.linalg.norm(np.diff(point, axis=0), axis=1).max() < 0.5e-3 * (1.0 + 1e-9)


def test_a_whole_turn_of_the_table_is_not_taken_for_rest(parts):
    """Its both ends are one place: the point above the tip goes all the way round."""
    last = parts[-1]
    turning = last.block == 9
    way = np.linalg.norm(np.diff((last.tip + 0.1 * last.axis)[turning], axis=0), axis=1).sum()
    lean = 0.1 * np.sin(np.radians(5.0))
    assert way > 0.9 * 2.0 * np.pi * lean * 350.0 / 360.0


def test_they_are_where_the_motion_is_at_their_time(planned, parts):
    for part in parts:
        tip, axis = planned[1].tip(part.time)
        assert np.abs(tip - part.tip).max() < 2e-7
        assert np.abs(axis - part.axis).max() < 1e-5


def test_time_goes_from_start_to_end_without_a_gap(planned, parts):
    assert parts[0].time[0] == pytest.approx(0.0, abs=1e-9)
    assert parts[-1].time[-1] == pytest.approx(planned[1].duration, rel=1e-9)
    for before, behind in pairwise(parts):
        assert behind.time[0] == pytest.approx(before.time[-1], abs=1e-9)
        assert (np.diff(behind.time) >= 0.0).all()


@pytest.mark.parametrize("pose", ["", " Y3.7 Z2.1 A13.7 C37.1"])
def test_a_dwell_is_no_time_of_a_way(pose):
    toolpath = tp.read_text(f"G90 G21 G94\nG1 X0{pose} F1000\nX5.3\nG4 P2\nX10\nM30\n", MACHINE)
    motion = tp.plan(tp.Path.fit(toolpath, machine=MACHINE), MACHINE, bound=False)
    (part,) = motion_stations(motion, toolpath, 0.5e-3, [0.0])
    assert part.time[-1] - part.time[0] == pytest.approx(motion.duration)
    assert part.moving_time.sum() == pytest.approx(motion.duration - toolpath.dwell.sum(), rel=1e-9)
    assert toolpath.dwell.sum() > 1.0


def test_blocks_operations_and_rapids_are_those_of_the_program(planned, parts):
    toolpath = planned[0]
    assert [int(part.operation[-1]) for part in parts] == [0, 1]
    for part in parts:
        assert (part.operation == part.operation[-1]).all()
    seen = {int(block) for part in parts for block in part.block[1:]}
    assert seen == set(toolpath.block[1:].tolist())
    for part in parts:
        for block in np.unique(part.block[1:]):
            assert set(part.rapid[1:][part.block[1:] == block]) == set(toolpath.rapid[1:][toolpath.block[1:] == block])


def test_points_close_together_are_not_each_a_station():
    x = np.arange(2000) * 1e-5
    lines = [f"G1 X{1e3 * each:.3f} Y{(k % 2) * 1e-3:.4f} Z0\n" for k, each in enumerate(x)]
    toolpath = tp.read_text(f"G90 G21 G94 F1000\n{''.join(lines)}M30\n", MACHINE)
    motion = tp.plan(tp.Path.fit(toolpath, machine=MACHINE), MACHINE, bound=False)
    (part,) = motion_stations(motion, toolpath, 0.4e-3, [0.0])
    assert len(part) < 300


def test_motion_of_another_program_is_refused(planned):
    short = tp.read_text("G90 G21 G94\nG1 X1 F100\nX2\nM30\n", MACHINE)
    with pytest.raises(UsageError, match="does not follow the tool path"):
        motion_stations(planned[1], short, 1e-3, [0.0])


def test_more_stations_than_memory_holds_are_refused(planned):
    with pytest.raises(UsageError, match="give a coarser resolution"):
        motion_stations(planned[1], planned[0], 1e-9, [0.1, 0.1])


def test_stations_of_a_program_are_on_its_straight_ways_at_the_times_of_its_points(planned):
    toolpath = planned[0]
    times = np.cumsum(np.random.default_rng(1).uniform(0.1, 2.0, len(toolpath)))
    parts = program_stations(toolpath, times, 0.5e-3, [0.1, 0.1])
    assert [int(part.operation[-1]) for part in parts] == [0, 1]
    assert parts[0].time[0] == times[0] and parts[-1].time[-1] == times[-1]
    for part in parts:
        for point in (part.tip, part.tip + 0.1 * part.axis):
            assert np.linalg.norm(np.diff(point, axis=0), axis=1).max() < 0.5e-3 * (1.0 + 1e-6)
        assert (np.diff(part.time) >= 0.0).all()
        # points that are close together have one station; none is a quarter of the spacing and a bow off
        for name in ("tip", "axis"):
            way = getattr(toolpath, name)
            there = np.stack([np.interp(part.time, times, column) for column in way.T], axis=1)
            assert np.abs(there - getattr(part, name)).max() < (0.15e-3 if name == "tip" else 5e-3)
        assert set(part.block.tolist()) <= set(toolpath.block.tolist())
