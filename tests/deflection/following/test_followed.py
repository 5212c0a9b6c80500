"""Whatever is measured and asked for: limits, feed and travel hold, and a run ends or says why it stands."""

from __future__ import annotations

import numpy as np
import pytest

import toolpace as tp
from testbed.followed.campaign import campaign
from testbed.followed.cases import case
from testbed.followed.disturbed import disturbed
from testbed.followed.drive import driven
from testbed.followed.judge import judged
from tests.support.tool_paths import toolpath_through
from toolpace.deflection.following import Follower, Measurement
from toolpace.deflection.following.samples import followed_joints_of, samples_of
from toolpace.kernels.follow import layout

QUICK = ("arc on paper-ab", "fan")


@pytest.mark.sweep
def test_no_measurement_and_no_override_breaks_a_limit():
    for name, group, number, _, verdict in campaign(24, 5, QUICK, each=6, longest=4.0):
        assert verdict.fine, f"{name}, figures {group}, run {number}: {verdict}"


@pytest.mark.sweep
def test_nor_do_many():
    for name, group, number, _, verdict in campaign(60, 6, QUICK, each=12, longest=8.0):
        assert verdict.fine, f"{name}, figures {group}, run {number}: {verdict}"


@pytest.mark.parametrize("table, figure", [(layout.SHARE, 30.0), (layout.ROOM, 30.0)])
def test_the_judge_sees_a_correction_or_a_pace_that_goes_too_far(table: int, figure: float):
    followed = case("arc on paper-ab", 0.1)
    follower = Follower(followed.trajectory, followed.machine, gain=1.0, max_correction=1e-3)
    follower.piece[table : table + 15] *= figure
    random = np.random.default_rng(3)
    runs = [disturbed(random, 4000, 1e-3, 1e-3) for _ in range(6)]
    verdicts = [judged(follower, followed, run.override, driven(follower, run, 20.0)) for run in runs]
    assert not all(verdict.fine for verdict in verdicts)


def test_a_step_from_python_is_that_of_the_compiled_loop():
    followed = case("arc on paper-ab", 0.1)
    follower = Follower(followed.trajectory, followed.machine)
    happens = disturbed(np.random.default_rng(1), 50, 1e-3, 1e-4)
    happens.what[:] = 0
    out = driven(follower, happens, 0.0)
    follower.reset()
    for row, override in zip(out, happens.override):
        setpoint = follower.step(Measurement(np.nan), feed=override)
        assert np.array_equal(setpoint.q, row[layout.Q : layout.Q + 5])


def test_the_parameter_that_a_follower_tells_runs_on_over_stops():
    """That of each run of the path begins at 0."""
    toolpath = toolpath_through([[0, 0, 0], [0.01, 0, 0], [0.01, 0.01, 0]], 3 * [[0, 0, 1]], stops=(1,))
    machine = tp.Machine.load("xyzac-trunnion")
    trajectory = tp.plan(tp.Path.fit(toolpath, machine=machine), machine, bound=False)
    samples = samples_of(trajectory, followed_joints_of(machine, machine.joints), 4e-3, 1.0)
    lengths = [run.s1 for run in trajectory.axis_path.runs]
    assert len(lengths) == 2 and samples.s[-1] == pytest.approx(sum(lengths))
    assert np.diff(samples.s).min() >= 0.0 and np.diff(samples.s).max() < 0.01 * sum(lengths)


def test_a_correction_at_a_slow_feed_is_as_slow_as_is_promised():
    """By the speed of the tip along its two directions: the machine turns no axis here."""
    toolpath = toolpath_through([[0.0, 0.0, 0.0], [0.02, 0.0, 0.0]], 2 * [[0, 0, 1]], feed=5e-3)
    machine = tp.Machine.load("xyzbc-head")
    path = tp.Path.fit(toolpath, machine=machine.reserved(0.1))
    trajectory = tp.plan(path, machine.reserved(0.1), bound=False)
    follower = Follower(trajectory, machine, gain=1.0)
    linear, q, seen = list(machine.linear), [trajectory.at(0.0).q], []
    for k in range(3000):
        off = (0.0, 2.5e-4 * (-1) ** (k // 500), 0.0) if k > 500 else (0.0, 0.0, 0.0)
        q.append(follower.step(Measurement(k * 1e-3, deflection=off)).q)
        seen.append(np.linalg.norm(q[-1][linear] - q[-2][linear]) / 1e-3)
    assert max(seen) <= 5e-3 * (1.0 + follower.feed_excess) * (1.0 + 1e-6) < 6e-3
    # it does move, as much as it may
    assert max(abs(each[linear][1]) for each in q) == pytest.approx(2.5e-4, rel=0.1)
