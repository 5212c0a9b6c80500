"""Set-points at another period: their own where they can be, interpolated within a stated error where asked for."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from tests.support.thinned import every
from toolpace.common.errors import UsageError
from toolpace.controls.export.rows import QUINTIC_ERROR, rows_every


def test_whole_periods_are_the_plans_own_set_points(motion):
    rows = rows_every(motion, 4e-3)
    n = len(rows.points) - 1
    assert np.array_equal(rows.points.q[:n], motion.setpoints.q[::4][:n]) and not rows.error.any()
    assert np.array_equal(rows.points.qdd[:n], motion.setpoints.qdd[::4][:n])
    assert np.allclose(np.diff(rows.points.t), 4e-3, rtol=0, atol=1e-12)
    assert rows.points.t[-1] >= motion.duration > rows.points.t[-2] - 4e-3
    assert np.array_equal(rows.points.q[-1], motion.setpoints.q[-1])


def test_the_last_row_is_the_plans_where_the_period_meets_its_end(brief):
    """All of it: a plan that is cut off in motion still moves in its last set-point."""
    rows, last = rows_every(brief, 4e-3).points, brief.setpoints
    assert len(last) % 4 == 1 and last.qddd[-1].any()
    for name in ("t", "q", "qd", "qdd", "qddd", "tip", "axis", "block"):
        np.testing.assert_allclose(getattr(rows, name), getattr(last, name)[::4], rtol=0.0, atol=1e-12)


def test_behind_the_end_it_rests(motion):
    rows = rows_every(motion, 7e-3).points
    assert rows.t[-1] > motion.setpoints.t[-1]
    assert not rows.qd[-1].any() and not rows.qdd[-1].any() and not rows.qddd[-1].any()


@pytest.mark.parametrize("period", [2.5e-3, 0.7e-3])
def test_other_periods_are_refused_unless_asked_for(motion, period):
    with pytest.raises(
        UsageError, match=rf"is {period / 1e-3:g} time steps .* give --resample .* --dt {period * 1e3:g}ms"
    ):
        rows_every(motion, period)
    assert rows_every(motion, period, resample=True).error.all()


@pytest.mark.parametrize("period", [0.0, -1.0, np.nan, np.inf, 1e-9, 1e4])
def test_periods_that_make_no_table_are_refused(motion, period):
    with pytest.raises(UsageError, match="--period"):
        rows_every(motion, period, resample=True)


def test_between_set_points_the_motion_is_within_the_error_that_is_told(motion):
    """The plan at 3 ms, interpolated to 1 ms, against what lies between."""
    coarse = replace(motion, setpoints=every(motion.setpoints, 3))
    rows = rows_every(coarse, 1e-3, resample=True)
    n = len(coarse.setpoints) * 3 - 3
    off = np.abs(rows.points.q[:n] - motion.setpoints.q[:n]).max(axis=0)
    assert (off <= rows.error + 1e-15).all() and (off > 0.01 * rows.error).any()
    speed = np.abs(rows.points.qd[:n] - motion.setpoints.qd[:n]).max(axis=0)
    jerk = motion.machine.limits.jerk
    assert (speed <= 0.0221 * jerk * 9e-6).all()
    assert np.abs(rows.points.tip[:n] - motion.setpoints.tip[:n]).max() < 1e-6


def test_the_error_of_a_quintic_is_peanos():
    """Its kernel, integrated: for a third derivative within 1 of some value, on a step of 1."""
    s = (np.arange(4000) + 0.5) / 4000
    worst = 0.0
    for u in np.linspace(0.0, 1.0, 201):
        at_one = 10 * u**3 - 15 * u**4 + 6 * u**5, -4 * u**3 + 7 * u**4 - 3 * u**5, (u**3 - 2 * u**4 + u**5) / 2
        kernel = np.maximum(u - s, 0) ** 2 / 2 - (at_one[0] * (1 - s) ** 2 / 2 + at_one[1] * (1 - s) + at_one[2])
        worst = max(worst, float(np.abs(kernel).mean()))
    assert worst == pytest.approx(QUINTIC_ERROR, rel=1e-4)


def test_without_a_limit_of_jerk_nothing_lies_between(motion):
    limits = motion.machine.limits
    free = motion.machine.with_limits(type(limits)(limits.velocity, limits.acceleration, np.inf, limits.joints))
    with pytest.raises(UsageError, match="without a limit of jerk"):
        rows_every(replace(motion, machine=free), 2.5e-3, resample=True)


def test_the_sag_of_straight_lines_is_what_they_leave(motion):
    rows = rows_every(motion, 8e-3)
    points = motion.setpoints.q
    n = (len(points) - 1) // 8 * 8
    middle, ends = points[4:n:8], points[: n + 1 : 8]
    left = np.abs(middle - 0.5 * (ends[1:] + ends[:-1])).max(axis=0)
    assert (left <= rows.sag * 1.05).all() and (left > 0.2 * rows.sag).all()
    assert re.fullmatch(r"\(5,\)", str(rows.sag.shape))
