"""Motions near the program place by place that are yet not its, and motions that have nothing to do with it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.support import motions
from tests.support.walks import AXIS, MACHINE, TIP, least_seconds, random_walk, set_points
from toolpace.judge import alignment, verify
from toolpace.judge.alignment import sections
from toolpace.programs.toolpath import no_rapids

POINTS = motions.set_points()
PROGRAM = motions.program()


def straight(poses, blocks):
    """A program of single blocks along the poses (n, 5), at 50 mm/s."""
    program, _, _ = random_walk(0)
    n = len(poses)
    return replace(
        program, tip=poses[:, :3].copy(), rotary=poses[:, 3:].copy(), axis=MACHINE.axis_at(poses[:, 3:].copy()),
        rapid=no_rapids(),
        feed=np.concatenate(([np.inf], np.full(n - 1, 0.05))), block=blocks, stop=np.arange(n) % (n - 1) == 0,
        least_time=np.zeros(n), dwell=np.zeros(n),
    )  # fmt: skip


def poses(x):
    out = np.tile([0.0, 0.0, 0.0, 0.3, 0.5], (len(x), 1))
    out[:, 0] = x
    return out


def test_catches_a_motion_that_goes_back_on_its_own_line():
    """It is on the line at every time, and every place of the line is reached: but not in this order."""
    line = straight(poses([0.0, 5e-3]), np.array([1, 2]))
    way = poses([0.0, 3e-3, 1e-3, 5e-3])
    _, walk, _ = random_walk(0)
    walk = replace(
        walk, poses=way, seconds=2.0 * least_seconds(way, np.full(4, 0.05)), dwell=np.zeros(4),
        block=np.array([1, 2, 2, 2]),
    )  # fmt: skip
    points, machine = set_points(walk)
    found = [check for check in verify(points, machine, line, TIP, AXIS).findings if check.what.startswith("tip")]
    assert found, "it was passed"
    # the best that two walkers can do on it: half of the way back apart
    assert 0.99e-3 < max(check.value for check in found) < 2e-3


def test_what_is_not_found_in_order_fails_however_near_each_place_is(monkeypatch):
    """An alignment that had to be widened, if only by what is granted: no place of it shows more than that."""
    model = motions.with_limits(motions.machine(), **{k: 1.01 * v for k, v in motions.peaks(POINTS).items()})
    assert verify(POINTS, model, PROGRAM).ok
    found = []

    def widened(*given):
        found.append(replace(alignment.align(*given), deviations=((3, 1.001), (300, 1.002))))
        return found[-1]

    monkeypatch.setattr(sections.Sections, "follows", False)
    monkeypatch.setattr(sections, "align", widened)
    (wrong,) = verify(POINTS, model, PROGRAM).findings
    assert wrong.what == "tip, in order" and wrong.value == pytest.approx(1.002 * 10e-6)
    assert 0.0 < wrong.time <= POINTS.t[300]


def test_a_motion_of_another_program_fails_in_one_line_with_its_place(monkeypatch):
    """Without work to be done in search of the program, the first place off it is where the search ends."""
    monkeypatch.setattr(alignment, "LEAST_WORK", 0)
    monkeypatch.setattr(alignment, "WORK", 0)
    away = replace(PROGRAM, tip=PROGRAM.tip + np.where(np.arange(len(PROGRAM)) > 40, 0.01, 0.0)[:, None])
    model = motions.with_limits(motions.machine(), **{k: 1.01 * v for k, v in motions.peaks(POINTS).items()})
    found = verify(POINTS, model, away)
    (lost,) = found.findings
    assert lost.what == "tip or axis, set-points to program" and "not that of this program" in lost.note
    here = int(np.searchsorted(POINTS.t, lost.time))
    assert lost.block == POINTS.block[here] and abs(lost.block - 50) <= 2
    assert lost.value == found.tip_deviation and found.axis_deviation >= 0.0 and lost.limit == 10e-6


def test_the_larger_deviation_of_both_ways_is_reported():
    """A block that is skipped leaves the motion on the program, but not the program on the motion."""

    def insert(values):
        return np.insert(values, 30, values[30], axis=0)

    names = ("feed", "least_time", "block", "stop", "dwell")
    aside = PROGRAM.axis[30] + [0.3, 0.0, 0.0]
    for tip, axis in (([0.0, 0.01, 0.0], PROGRAM.axis[30]), ([0.0, 0.0, 0.0], aside / np.linalg.norm(aside))):
        program = replace(
            PROGRAM, tip=np.insert(PROGRAM.tip, 30, PROGRAM.tip[30] + tip, axis=0),
            axis=np.insert(PROGRAM.axis, 30, axis, axis=0), rotary=None, rotary_joints=(),
            **{name: insert(getattr(PROGRAM, name)) for name in names},
        )  # fmt: skip
        found = verify(POINTS, motions.machine(), program)
        for part, told in (("tip", found.tip_deviation), ("axis", found.axis_deviation)):
            shown = [check.value for check in found.checks if check.what.startswith(f"{part}, ")]
            assert told == pytest.approx(max(shown), rel=1e-6)
        assert max(found.tip_deviation / 0.01, found.axis_deviation / 0.3) > 0.8


def test_a_large_deviation_of_the_axis_is_its_angle():
    angle = 1.0
    turned = PROGRAM.axis.copy()
    # about the normal of each axis: all of them by the same angle
    normal = np.cross(turned, [0.0, 1.0, 0.0])
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    turned = np.cos(angle) * turned + np.sin(angle) * np.cross(normal, turned)
    program = replace(PROGRAM, axis=turned, rotary=None, rotary_joints=())
    found = verify(POINTS, motions.machine(), program, axis_tolerance=0.8)
    worst = next(check for check in found.findings if check.what == "axis, set-points to program")
    assert worst.value == pytest.approx(angle, rel=0.02) == found.axis_deviation
