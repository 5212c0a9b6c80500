"""What is made of starts from which the core does not come to its end."""

from __future__ import annotations

import numpy as np
import pytest

from tests.support.mesh_problems import moving, solved
from toolpace.kernels.optimal import solver
from toolpace.planning.optimal import solve as solving
from toolpace.planning.optimal.solve import ACCEPTABLE, AGREE, LIMITS, Stalled, pinned, slower, solve, well_inside

WITHOUT_AN_END = solver.OPTIMAL + 1
IN_MOTION = 3
"""Seed of a problem that starts and ends in motion."""


@pytest.fixture
def core(monkeypatch):
    """The core replaced by one that gives (coefficients, gap) from a list, none of them for the optimum; the starts
    that it is given."""

    def replaced(*answers):
        starts, left = [], list(answers)

        def maximise_speed(points, ends, c, *_):
            starts.append(c)
            found, gap = left.pop(0)
            none = np.empty(0)
            return solver.Solution(found.copy(), WITHOUT_AN_END, 250, gap, 0.0, none, none)

        monkeypatch.setattr(solver, "maximise_speed", maximise_speed)
        return starts

    return replaced


def used(problem, c):
    """(points, 3) largest share of cap, acceleration and jerk at the points of a problem, by its rows."""
    near = problem.first[:, None] + np.arange(problem.basis.shape[2])
    z, z1, z2 = (np.einsum("pj,pj->p", problem.basis[:, order], c[near]) for order in range(3))
    rows = np.einsum("pri,ip->pr", problem.rows, np.stack([z, z1, z2]))
    half = rows.shape[1] // 2
    kinds = z / problem.cap, np.abs(rows[:, :half]).max(axis=1), np.abs(rows[:, half:]).max(axis=1) * np.sqrt(z)
    return np.stack(kinds, axis=1)


def test_a_point_that_is_all_but_optimal_is_the_answer_at_once(core):
    problem, c = solved(1)
    starts = core((c, 1e-5))
    assert (solve(problem, 0.5 * c, 1.0) == c).all()
    assert len(starts) == 1


def test_two_starts_that_end_at_the_same_time_are_enough(core):
    problem, c = solved(1)
    near = c * (1.0 - 0.5 * AGREE)
    starts = core((near, 2e-3), (c, 2.5e-3))
    assert (solve(problem, 0.5 * c, 1.0) == near).all()
    assert len(starts) == 2


def test_of_starts_that_disagree_the_one_nearest_to_the_optimum_is_taken(core):
    problem, c = solved(1)
    starts = core((0.97 * c, 2e-3), (0.99 * c, 1e-3), (0.95 * c, 5e-3), (0.98 * c, 2e-3))
    assert (solve(problem, 0.5 * c, 1.0) == 0.99 * c).all()
    assert len(starts) == 4


def test_what_passes_a_limit_is_no_answer(core):
    problem, c = solved(1)
    core((1.05 * c, 1e-9), (0.9 * c, 2e-3), (1.05 * c, 1e-9), (1.05 * c, 1e-9))
    assert (solve(problem, 0.5 * c, 1.0) == 0.9 * c).all()


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("start", [1e-3, 1.0, 30.0])
def test_between_rests_there_is_a_motion_whatever_the_core_does(core, seed, start):
    problem, c = solved(seed)
    core(*[(2.0 * c, 1.0)] * 4)
    found = solve(problem, start * c, 1.0)
    assert used(problem, found).max() <= 0.5 * (1.0 + 1e-9)
    assert (found == well_inside(problem, start * c)).all() and (found > 0.0).all()
    # it is half of a limit, or z was as slow before
    assert used(problem, found).max() == pytest.approx(0.5, rel=1e-9) or (found == start * c).all()


def test_in_motion_a_point_far_from_the_optimum_is_none(core):
    problem, c = moving(IN_MOTION)
    core(*[(c, 2.0 * ACCEPTABLE)] * 3)
    with pytest.raises(Stalled):
        solve(problem, c, 1.0)
    core(*[(c, 0.9 * ACCEPTABLE)] * 3)
    assert (solve(problem, c, 1.0) == c).all()


def test_in_motion_what_is_passed_most_at_last_is_named(core):
    problem, c = moving(IN_MOTION)
    fast = 1.5 * c
    core(*[(fast, 1.0)] * 3)
    with pytest.raises(Stalled) as stall:
        solve(problem, c, 1.0)
    point, kind = np.unravel_index(int(np.argmax(used(problem, fast))), (len(problem.cap), 3))
    assert stall.value.limit == LIMITS[kind]
    assert stall.value.place == problem.nodes[problem.node[point]]


def test_once_is_one_start(core):
    problem, c = moving(IN_MOTION)
    starts = core((1.5 * c, 1.0))
    with pytest.raises(Stalled):
        solve(problem, c, 1.0, once=True)
    assert len(starts) == 1


def test_a_start_without_speed_is_none(core):
    problem, c = solved(1)
    starts = core()
    with pytest.raises(Stalled, match="some limit"):
        solve(problem, np.zeros_like(c), 1.0)
    assert starts == []


@pytest.mark.parametrize("taper", [None, (3, 5)])
def test_slowing_a_start_leaves_ends_in_motion_as_they_are(taper):
    problem, c = moving(IN_MOTION)
    share = slower(problem, c, 0.6, taper) / c
    assert (share[:2] == 1.0).all() and (share[-2:] == 1.0).all()
    assert share.min() >= 0.4 - 1e-12 and share.max() <= 1.0
    if taper:
        middle = share[taper[0] + 1 : -taper[1] - 1]
        assert middle == pytest.approx(0.4)
    at_rest, c = solved(1)
    assert slower(at_rest, c, 0.6) == pytest.approx(0.4 * c, rel=1e-12)


@pytest.mark.parametrize(("make", "seed", "given"), [(solved, 1, [1, -2]), (moving, IN_MOTION, [0, 1, -2, -1])])
def test_ends_are_as_rest_or_a_given_state_asks_for(make, seed, given):
    problem, c = make(seed)
    off = c.copy()
    off[given] *= 1.3
    assert pinned(problem, off) == pytest.approx(c, rel=1e-12)


def test_limits_that_a_start_breaks_are_relaxed_by_more():
    problem, c = solved(2)
    fast = 1.4 * c
    passed = used(problem, fast)
    relief = solving.relief_of(passed)
    assert (relief[passed > 1.0 - solving.MARGIN] > (passed - 1.0)[passed > 1.0 - solving.MARGIN]).all()
    assert (relief[passed < 1.0 - solving.MARGIN] == 0.0).all()
