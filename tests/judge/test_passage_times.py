"""Least times, stops and dwells: each has time of its own, to a hundredth of a step or two steps, and no more."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.support import motions
from tests.support.walks import AXIS, DT, MACHINE, TIP, least_seconds, random_walk, set_points
from toolpace.judge import motion_judge, verify
from toolpace.motion.setpoints import Block
from toolpace.programs.toolpath import no_rapids

POINTS = motions.set_points()
PROGRAM = motions.program()
FREE = motions.with_limits(motions.machine(), **{k: 1.01 * v for k, v in motions.peaks(POINTS).items()})


def along_x(x, dwell):
    """A program along x (n,) [m], and a motion along it, slower than its feed."""
    program, walk, _ = random_walk(0)
    n = len(x)
    poses = np.tile([0.0, 0.0, 0.0, 0.3, 0.5], (n, 1))
    poses[:, 0] = x
    dwell, block = np.asarray(dwell, dtype=float), np.arange(1, n + 1)
    feed = np.concatenate(([np.inf], np.full(n - 1, 0.05)))
    program = replace(
        program, tip=poses[:, :3].copy(), rotary=poses[:, 3:].copy(), axis=MACHINE.axis_at(poses[:, 3:].copy()),
        rapid=no_rapids(),
        feed=feed, block=block, stop=(np.arange(n) % (n - 1) == 0) | (dwell > 0.0), least_time=np.zeros(n), dwell=dwell,
    )  # fmt: skip
    return program, replace(walk, poses=poses, seconds=2.0 * least_seconds(poses, feed), dwell=dwell, block=block)


def judged(program, walk):
    """What is said of dwells and stops."""
    points, machine = set_points(walk)
    return [check for check in verify(points, machine, program, TIP, AXIS).checks
            if check.what in ("dwell", "stillness at stops")]  # fmt: skip


@pytest.mark.parametrize(("more", "wrong"), [(0.015, True), (0.005, False)])
def test_a_least_time_is_known_to_a_hundredth_of_a_step(more, wrong):
    least = np.zeros(len(PROGRAM))
    least[40] = 5e-3
    free = replace(PROGRAM, feed=np.full(len(PROGRAM), np.inf), least_time=least)
    (told,) = (check for check in verify(POINTS, FREE, free).checks if check.what == "least time")
    assert told.ok and told.noise == pytest.approx(0.01 * DT)
    asked = np.where(np.arange(len(PROGRAM)) == 40, (told.value + more * DT) / (1.0 - 1e-4), 0.0)
    found = verify(POINTS, FREE, replace(free, least_time=asked)).findings
    assert [check.what for check in found] == (["least time"] if wrong else [])


@pytest.mark.parametrize(("steps", "wrong"), [(2.5, True), (2.0, False), (1.5, False)])
def test_sampling_may_hide_two_steps_of_a_dwell(steps, wrong):
    """Where the motion waits from set-point to set-point."""
    program, walk = along_x([0.0, 4e-3, 8e-3], [0.0, 0.1, 0.0])
    (stretch,) = (check for check in judged(program, walk) if check.what == "dwell")
    asked = replace(program, dwell=np.array([0.0, stretch.value + steps * DT, 0.0]))
    assert [check.ok for check in judged(asked, walk)] == [not wrong]


def test_two_dwells_a_micrometre_apart_need_time_for_both():
    """A single wait, long enough for each, and the slow way there, do not make two of them."""
    program, both = along_x([0.0, 4e-3, 4.001e-3, 8e-3], [0.0, 0.02, 0.02, 0.0])
    assert all(check.ok for check in judged(program, both))
    for waits in ([0.0, 0.022, 0.0, 0.0], [0.0, 0.0, 0.022, 0.0]):
        one = replace(both, dwell=np.array(waits))
        assert [check.what for check in judged(program, one) if not check.ok] == ["dwell"]


def test_a_wait_counts_that_comes_after_a_shorter_one():
    """The motion halts two micrometres early, within the tolerance, and then waits where it shall."""
    program, _ = along_x([0.0, 4e-3, 8e-3], [0.0, 0.3, 0.0])
    _, walk = along_x([0.0, 4e-3 - 2e-6, 4e-3, 8e-3], [0.0, 0.05, 0.3, 0.0])
    walk = replace(walk, block=np.array([1, 2, 2, 3]))
    assert [check.ok for check in judged(program, walk) if check.what == "dwell"] == [True]
    short = replace(walk, dwell=np.array([0.0, 0.05, 0.27, 0.0]))
    assert [check.ok for check in judged(program, short) if check.what == "dwell"] == [False]


def test_the_use_of_the_feed_is_bounded_from_both_sides():
    """At a tenth of the feed; where the motion waits, it uses none of it."""
    program = replace(PROGRAM, feed=10.0 * PROGRAM.feed)
    judge = motion_judge(POINTS, FREE, program, TIP, AXIS)
    judge.take(Block.of(POINTS, 0, len(POINTS)))
    use = judge.judged(figures=True)[1].feed_use
    assert 0.0999 < use.least <= 0.1000001 <= use.most < 0.11
    waits = np.abs(np.diff(POINTS.q, axis=0)).max(axis=1) == 0.0
    assert waits.any() and (use.ratio[waits] == 0.0).all()


def test_a_stop_has_its_row_and_one_that_is_missed_its_place():
    stop = PROGRAM.stop.copy()
    stop[50] = True
    program, walk = along_x([0.0, 4e-3, 8e-3], [0.0, 0.0, 0.0])
    program = replace(program, stop=np.ones(3, dtype=bool))
    assert [(check.what, check.ok) for check in judged(program, walk)] == [("stillness at stops", True)]
    (missed,) = verify(POINTS, FREE, replace(PROGRAM, stop=stop)).findings
    assert missed.what == "stillness at stops" and missed.block == PROGRAM.block[50]
    here = POINTS.tip[np.searchsorted(POINTS.t, missed.time)]
    assert np.linalg.norm(here - PROGRAM.tip[50]) < 1e-4


@pytest.mark.parametrize(("share", "wrong"), [(3e-3, True), (0.5e-3, False)])
@pytest.mark.parametrize("joint", ["X", "C"])
def test_a_joint_may_creep_in_a_dwell_by_a_thousandth_of_its_first_step_from_rest(joint, share, wrong):
    """Where it waits it goes on, and all that is behind lies as much further: a nanometre or two."""
    program, walk = along_x([0.0, 4e-3, 8e-3], [0.0, 0.1, 0.0])
    points, machine = set_points(walk)
    j, waits = MACHINE.joints.index(joint), (np.diff(points.q, axis=0) == 0.0).all(axis=1)
    each = np.ones(len(MACHINE.joints))
    machine = motions.with_limits(machine, velocity=each, acceleration=10.0 * each, jerk=20.0 * each)
    q = points.q.copy()
    q[1:, j] += share * 20.0 * DT**3 / 6.0 * np.cumsum(waits)
    tip, axis = MACHINE.forward(q)
    checks = verify(replace(points, q=q, tip=tip, axis=axis), machine, program, TIP, AXIS).checks
    found = [check.ok for check in checks if check.what in ("dwell", "stillness at stops")]
    assert waits.sum() >= 98 and found and all(found) == (not wrong)
