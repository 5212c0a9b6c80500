"""The rows that the judge matches: chords of the program and of the motion are as near to their curves as is said."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.support import motions
from tests.support.walks import AXIS, KINDS, MACHINE, TIP, random_walk
from toolpace.judge.rows import motion_row, program_line

CLOSE = 1e-3
"""What the judge grants for chords [tolerances]."""


def off(poses, others):
    d = poses - others
    return np.maximum(np.linalg.norm(d[:, :3], axis=1), np.linalg.norm(d[:, 3:], axis=1))


@pytest.mark.parametrize("dt, most", [(5e-4, 1e-3), (1e-3, 2e-3), (4e-3, 0.1)])
def test_motion_between_set_points(dt, most):
    """Within a thousandth of a tolerance and what is granted of the motion itself; and little is granted."""
    points, fine = motions.set_points(dt=dt), motions.set_points(dt=dt / 20)
    poses, true = (np.hstack((each.tip / TIP, each.axis / AXIS)) for each in (points, fine))
    limits = motions.with_limits(MACHINE, **{k: 1.01 * v for k, v in motions.peaks(fine).items()}).limits
    row = motion_row(points, poses, limits, dt)
    k = np.clip(np.searchsorted(row.late, fine.t, side="left"), 1, len(row.poses) - 1)
    share = np.clip((fine.t - row.late[k - 1]) / (row.early[k] - row.late[k - 1]), 0.0, 1.0)
    found = row.poses[k - 1] + share[:, None] * (row.poses[k] - row.poses[k - 1])
    granted = np.maximum(row.allowance[k - 1], row.allowance[k])
    inside = (fine.t > 3 * dt) & (fine.t < points.t[-4])
    assert (off(found, true) <= CLOSE + granted)[inside].all()
    assert row.allowance.max() <= most
    np.testing.assert_array_equal(row.poses[row.row], poses)
    assert (row.allowance[row.row] == 0.0).all()


@pytest.mark.parametrize("seed", range(3 * len(KINDS)))
def test_chords_of_the_program(seed):
    """In the middle of each chord, the tool axis of the joints half way is within what is granted."""
    program, _, _ = random_walk(seed)
    line, owner = program_line(program, MACHINE, TIP, AXIS)
    assert (owner[np.diff(owner, append=len(program)) > 0] == np.arange(len(program))).all()
    for k in range(1, len(program)):
        chords = np.flatnonzero(owner == k)
        share = (np.arange(len(chords)) + 0.5)[:, None] / len(chords)
        rotary = program.rotary[k - 1] + share * (program.rotary[k] - program.rotary[k - 1])
        tip = program.tip[k - 1] + share * (program.tip[k] - program.tip[k - 1])
        true = np.hstack((tip / TIP, MACHINE.axis_at(np.ascontiguousarray(rotary)) / AXIS))
        assert off(0.5 * (line[chords - 1] + line[chords]), true).max() <= CLOSE


@pytest.mark.parametrize("column", [1, 4])
@pytest.mark.parametrize("size", [0.05, 0.1, 0.3])
def test_a_tenth_of_the_fourth_difference_is_granted_between_set_points(column, size):
    """One set-point that is off by `size` tolerances: the differences around it are 1, 4, 6, 4 and 1 times that."""
    n = 40
    points = motions.set_points()
    names = ("t", "q", "qd", "qdd", "qddd", "tip", "axis", "block")
    still = replace(points, **{name: getattr(points, name)[:n] * (name == "t") for name in names})
    poses = np.zeros((n, 6))
    poses[:, 0], poses[20, column] = np.arange(n), size
    row = motion_row(still, poses, MACHINE.limits, 1e-3)
    assert row.allowance.max() == pytest.approx(0.1 * 6.0 * size)
    # the set-points 18 to 22 have it in a difference of theirs
    away = np.abs(row.first - 20) > 4
    assert row.allowance[away].max() == pytest.approx(0.0, abs=1e-12)
