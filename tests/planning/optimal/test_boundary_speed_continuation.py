"""A way between ends in motion where a solve finds none."""

from __future__ import annotations

import numpy as np
import pytest

from testbed.from_positions import used_by_positions
from testbed.random_plans import random_plan
from tests.support.mesh_problems import moving
from toolpace.kernels.optimal import limit_rows
from toolpace.planning.optimal import solve as solutions
from toolpace.planning.optimal.solve import (
    Stalled,
    from_lower_boundary_speeds,
    pinned,
    solve,
    solve_whole,
    with_ends_at,
)
from toolpace.planning.planner import plan

SEEDS = range(0, 12, 3)
"""Of problems that start and end in motion; the seeds between them have one end at rest."""


def mesh_time(problem, c):
    return float(problem.weight @ limit_rows.usage(problem.as_points(), c)[1] ** -0.5)


@pytest.mark.parametrize("seed", [*SEEDS, 1, 2])
@pytest.mark.parametrize("faster", [1.0, 1000.0])
def test_slower_ends_lead_to_the_motion_that_a_solve_finds(seed, faster):
    """The optimum of the same mesh, whatever the start."""
    problem, c = moving(seed)
    random = np.random.default_rng(seed)
    found = from_lower_boundary_speeds(problem, faster * c * random.uniform(0.2, 1.0, len(c)))
    assert limit_rows.usage(problem.as_points(), found)[0].max() <= 1.0 + 1e-6
    assert pinned(problem, found.copy()) == pytest.approx(found, rel=1e-12)
    assert mesh_time(problem, found) == pytest.approx(mesh_time(problem, c), rel=1e-5)


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("speed", [0.3, 0.9])
def test_ends_at_a_share_of_their_speed_are_those_of_a_slowed_motion(seed, speed):
    """The same motion in slow motion keeps its limits, and has the ends that are asked for."""
    problem, c = moving(seed)
    slow = with_ends_at(problem, speed)
    begin = speed**2 * c
    assert pinned(slow, begin.copy()) == pytest.approx(begin, rel=1e-12)
    assert problem.fixed[0] == pytest.approx(c[0], rel=1e-12)
    found = solve(slow, begin, 0.1)
    assert mesh_time(problem, c) < mesh_time(slow, found) <= mesh_time(slow, begin) * (1.0 + 1e-6)


# refused before: each is a piece of a motion along a longer path, at nine tenths of its speed; with that motion's time
@pytest.mark.parametrize(
    ("seed", "family", "longest"),
    [(5000294, "reversals", 0.9377), (5000609, "short_or_long", 0.1131), (5001596, "parameters", 1.749),
     (5000987, "slow_spots", 4.882)],
)  # fmt: skip
def test_pieces_of_a_motion_are_planned(seed, family, longest):
    made = random_plan(seed)
    assert made.family == family
    trajectory = plan(made.path, made.limits, **made.options, bound=False)
    assert trajectory.duration < longest
    assert used_by_positions(trajectory).max() < 1.0001 and trajectory.usage().worst < 1.0001
    for at, name in ((0.0, "start"), (trajectory.duration, "end")):
        _, speed, acceleration = trajectory.state(at)
        state = made.options.get(name)
        assert speed == pytest.approx(state.speed if state else 0.0, rel=1e-6, abs=1e-9)
        assert acceleration == pytest.approx(state.acceleration if state else 0.0, rel=1e-4, abs=1e-6)


def test_what_is_within_the_limits_is_taken_before_anything_is_tried(monkeypatch):
    problem, c = moving(0)

    def stalled(within):
        def solve(*_, **_options):
            raise Stalled(0.25, "a jerk limit", within)

        return solve

    monkeypatch.setattr(solutions, "from_lower_boundary_speeds", lambda *_: 2.0 * c)
    monkeypatch.setattr(solutions, "solve", stalled(0.9 * c))
    assert (solve_whole(problem, c, 1.0) == 0.9 * c).all()
    monkeypatch.setattr(solutions, "solve", stalled(None))
    assert (solve_whole(problem, c, 1.0) == 2.0 * c).all()
    monkeypatch.setattr(solutions, "from_lower_boundary_speeds", lambda *_: None)
    with pytest.raises(Stalled, match=r"a jerk limit is exceeded near s = 0\.25"):
        solve_whole(problem, c, 1.0)


@pytest.mark.parametrize(("missing", "found"), [(0, True), (-1, True), (1, False)])
def test_as_many_solves_may_be_in_vain_as_are_granted(monkeypatch, missing, found):
    """Before one finds the way; whatever more would cost, there is hardly one left."""
    problem, c = moving(3)
    vain = solutions.MOST_IN_VAIN - 1 + missing
    asked = []

    def found_at(problem, speed, start, first_gap):
        asked.append(speed)
        return None if 1 < len(asked) <= 1 + vain else start

    monkeypatch.setattr(solutions, "found_at", found_at)
    assert (from_lower_boundary_speeds(problem, c) is not None) == found
    assert asked[-1] == 1.0 or not found


def test_where_there_is_no_way_few_tries_are_made(monkeypatch):
    """Ends ten times as fast as a motion that is at its limits."""
    problem, c = moving(3)
    true, asked = solutions.found_at, []

    def found_at(problem, speed, *given):
        asked.append(speed)
        return true(problem, speed, *given)

    monkeypatch.setattr(solutions, "found_at", found_at)
    assert from_lower_boundary_speeds(with_ends_at(problem, 10.0), c) is None
    assert min(asked) > 0.0 and max(asked) < 1.0 + 1e-12 and len(asked) <= 1 + solutions.MOST_TRIES
