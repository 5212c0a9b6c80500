"""Closing the gap: ranges, parts and borders against other solvers, and plans proved to be the best."""

from __future__ import annotations

import time

import numpy as np
import pytest

import toolpace as tp
from testbed.cases import all_cases, flank
from tests.support.conic import conic_optimum
from tests.support.mesh_problems import mesh_time, small, solved
from tests.support.straight_line import line
from toolpace.common.errors import UsageError
from toolpace.common.workers import UNTOLD, Progress, Workers
from toolpace.machine.limits import Limits
from toolpace.motion.laws import SplineLaw
from toolpace.planning.bound.branch_and_bound import Allowance, Box, Neighbourhood, Part, close
from toolpace.planning.bound.gap_localisation import Place, losses_by_knot, settled
from toolpace.planning.bound.problem import PADDING, Knots
from toolpace.planning.bound.prove import end_states, prove_run, to_gain
from toolpace.planning.bound.relaxation import bound_run, highest_speed, relaxed
from toolpace.planning.optimal.planner import fastest_law
from toolpace.planning.optimal.solve import solve

FAR = 1e9
"""[s]"""


def random_ranges(knots, c, seed, width=3.0):
    """Ranges around the z of c at a third of the knots; elsewhere none."""
    rng = np.random.default_rng(seed)
    z = knots.state(c)[:, 0]
    some = rng.random(len(z)) < 0.3
    low = np.where(some, z / rng.uniform(1.02, width, len(z)), 0.0)
    high = np.where(some, np.minimum(z * rng.uniform(1.02, width, len(z)), knots.cap), knots.cap)
    return low, high


def whole(knots, c):
    """All of a problem as one part, with the multipliers of its relaxation, and as one piece."""
    found = relaxed(knots, c, np.zeros_like(knots.cap), knots.cap)
    part = Part(knots, np.arange(len(knots.cap), dtype=float), found._replace(dual=settled(knots, found.dual)))
    return part, Box(found.value, np.zeros_like(knots.cap), knots.cap, part.found)


@pytest.mark.parametrize("seed", [1, 2, 4, 5, 7, 8])
def test_relaxation_in_ranges_is_that_of_a_conic_solver(seed):
    problem, c = solved(seed, cells=24)
    knots = Knots(problem)
    low, high = random_ranges(knots, c, seed)
    assert relaxed(knots, c, low, high).value == pytest.approx(conic_optimum(knots, c, low, high), rel=3e-5)


@pytest.mark.parametrize("seed", range(40))
def test_ranges_around_the_best_leave_it_above_the_bound(seed):
    problem, c = solved(seed)
    knots = Knots(problem)
    best, before = mesh_time(knots, c), relaxed(knots, c, np.zeros_like(knots.cap), knots.cap).value
    low, high = random_ranges(knots, c, seed)
    narrow = relaxed(knots, c, low, high).value
    assert narrow <= best * (1.0 + 1e-7) and narrow >= before - 3e-5 * best
    tight = np.where(low > 0.0, 1.0, 0.0)
    z = knots.state(c)[:, 0]
    narrower = relaxed(knots, c, tight * z / 1.001, np.minimum(np.where(low > 0.0, z * 1.001, high), knots.cap)).value
    assert narrow - 3e-5 * best <= narrower <= best * (1.0 + 1e-7)


@pytest.mark.parametrize("seed", range(10))
def test_multipliers_of_a_part_count_as_much_in_the_whole(seed):
    """What is gained in a part, the rest priced by its multipliers, is gained in the whole: sums add up."""
    problem, c = solved(300 + seed, cells=260, joints=3)
    knots = Knots(problem)
    n = len(knots.weight)
    # far from the optimum, so that there is something to be gained
    found = relaxed(knots, c, np.zeros_like(knots.cap), knots.cap, tolerance=0.02)
    dual = settled(knots, found.dual)
    low, high = n // 3 - PADDING, 2 * n // 3 + PADDING
    part = knots.part(low, high, found.c, dual)
    assert (np.flatnonzero(part.has_rows()) + low).tolist() == list(range(low + PADDING, high - PADDING + 1))
    before = part.value(knots.of_part(part, low, dual))
    better = relaxed(part, found.c[low : high + 3], np.zeros_like(part.cap), part.cap)
    joined = dual.copy()
    joined[knots.first[low + PADDING] : knots.first[high - PADDING + 1]] = settled(part, better.dual)
    gain = knots.value(joined) - knots.value(dual)
    assert better.value - before == pytest.approx(gain, abs=1e-9 * knots.value(dual))
    assert gain > 0.0


@pytest.mark.parametrize("seed", range(12))
def test_losses_sum_to_the_gap(seed):
    problem, c = solved(seed)
    knots = Knots(problem)
    found = relaxed(knots, c, np.zeros_like(knots.cap), knots.cap)
    value, losses = losses_by_knot(knots, c, settled(knots, found.dual))
    time_ = mesh_time(knots, c)
    assert (losses >= 0.0).all() and losses.sum() == pytest.approx(time_ - value, abs=1e-8 * time_)


@pytest.mark.parametrize("seed", range(6))
def test_no_knot_pays_more_for_jerk_than_its_time(seed):
    """Else standing still would pay, and multipliers would bound nothing; where z has a range it cannot."""
    problem, c = solved(seed)
    knots = Knots(problem)
    dear = np.random.default_rng(seed).exponential(1.0, (*knots.rows.shape[:2], 2))
    assert (knots.jerk_price(dear) > knots.weight).all()
    low = np.where(np.arange(len(knots.cap)) % 2, 0.5 * knots.state(c)[:, 0], 0.0)
    for ranges, free in ((None, np.ones_like(low)), (low, low == 0.0)):
        price = knots.jerk_price(settled(knots, dear, ranges))
        assert (price[free > 0] <= knots.weight[free > 0]).all()
        assert (price[free == 0] == knots.jerk_price(dear)[free == 0]).all()
        assert np.isfinite(knots.value(settled(knots, dear, ranges), low if ranges is not None else None))


@pytest.mark.parametrize("seed", range(6))
def test_beyond_a_border_ipopt_finds_nothing_below_what_was_asked(seed):
    pytest.importorskip("casadi")
    from testbed import ipopt

    problem, c = solved(400 + seed, cells=40, joints=3)
    knots = Knots(problem)
    part, piece = whole(knots, c)
    enough = 1.01 * mesh_time(knots, c)
    rng = np.random.default_rng(seed)
    borders = confirmed = 0
    for k in rng.choice(np.arange(3, len(knots.weight) - 3), 4, replace=False).tolist():
        near = Neighbourhood(part, piece, k, ramp=1e6)
        upper, lower = near.border(True, enough), near.border(False, enough)
        if np.isfinite(upper):
            assert upper > knots.state(c)[k, 0]
        if np.isfinite(lower):
            borders += 1
            assert lower < knots.state(c)[k, 0]
            held = problem.cap.copy()
            problem.cap = np.where(problem.node == k, np.minimum(lower, held), held)
            best, note = ipopt.minimise(problem, 0.5 * c)
            problem.cap = held
            if note == ipopt.SUCCEEDED:
                confirmed += 1
                assert mesh_time(knots, best) >= enough * (1.0 - 1e-6)
    assert borders > 0 and confirmed == borders


def test_jcde2022_flank_is_the_best_there_is():
    """The gap of 1.6 percent on the flank is the relaxation's: the plan is the global optimum of its mesh."""
    case = flank()
    law, _ = fastest_law(case.run, case.limits, cells=400, guard=False)
    before = bound_run(case.run, case.limits, law)
    after = prove_run(case.run, case.limits, law, 1e-4, Allowance(time.monotonic() + FAR))
    assert before.gap > 0.015 and 0.0 <= after.gap < 1e-4
    assert after.mesh_bound <= after.mesh_duration


@pytest.mark.parametrize("number", [11, 17])
def test_random_cases_with_a_gap_are_the_best_there_is(number):
    case = next(case for case in all_cases() if case.name.startswith(f"random {number}"))
    law, _ = fastest_law(case.run, case.limits, cells=400, guard=False)
    shares: list[float] = []
    after = prove_run(
        case.run, case.limits, law, 1e-4, Allowance(time.monotonic() + FAR), progress=Progress(shares.append)
    )
    assert after.gap < 1e-4 and shares == sorted(shares)


@pytest.mark.parametrize("seed", range(40))
def test_what_is_proved_is_never_above_the_best_found(seed):
    run, limits, problem, _ = small(600 + seed, cells=60)
    _, c = solved(600 + seed, cells=60)
    law = SplineLaw(problem.nodes, c, problem.rest)
    before = bound_run(run, limits, law)
    after = prove_run(run, limits, law, 1e-5, Allowance(time.monotonic() + 3.0))
    assert before.mesh_bound <= after.mesh_bound <= after.mesh_duration * (1.0 + 1e-9)


def test_a_worse_plan_is_not_proved_to_be_the_best():
    """The bound belongs to the problem: it must stay below the optimum when a plan 3 percent slower asks for it."""
    run, limits, problem, _ = small(604, cells=60)
    _, c = solved(604, cells=60)
    best = mesh_time(Knots(problem), c)
    slow = SplineLaw(problem.nodes, c / 1.06, problem.rest)
    assert prove_run(run, limits, slow, 1e-6, Allowance(time.monotonic() + 10.0)).mesh_bound <= best * (1.0 + 1e-7)


def test_a_trajectory_with_its_proof():
    case = flank()
    trajectory = tp.plan(case.axis_path, case.limits, mesh=300)
    shares: list[float] = []
    proved = tp.prove(trajectory, progress=shares.append)
    assert trajectory.gap > 0.01 and proved.gap < 4e-3
    assert proved.duration == trajectory.duration and proved.lower_bound <= proved.duration
    assert shares == sorted(shares) and shares[-1] == 1.0
    assert trajectory.open_places and all(0.0 <= place.start <= place.end <= 9.0 for place in trajectory.open_places)
    assert sum(place.seconds for place in proved.open_places) < sum(place.seconds for place in trajectory.open_places)


@pytest.mark.parametrize("spent", [Allowance(until=time.monotonic() - FAR), Allowance(knots=0)])
def test_nothing_is_solved_for_a_proof_once_its_allowance_is_spent(monkeypatch, spent):
    """Not even what a place would be worth: that is a solve for each of them."""
    case = flank()
    law, _ = fastest_law(case.run, case.limits, cells=200, guard=False)
    asked: list[tuple[object, ...]] = []
    monkeypatch.setattr("toolpace.planning.bound.prove.solve", lambda *given: asked.append(given) or solve(*given))
    found = prove_run(case.run, case.limits, law, 1e-4, spent)
    assert not asked and found.gap > 0.01 and len(found.places)
    prove_run(case.run, case.limits, law, 1e-4, Allowance(knots=1))
    assert asked


def test_nothing_is_solved_for_a_proof_of_what_is_proved_already(monkeypatch):
    case = flank()
    law, _ = fastest_law(case.run, case.limits, cells=200, guard=False)
    monkeypatch.delattr("toolpace.planning.bound.prove.solve")
    assert prove_run(case.run, case.limits, law, 0.5, Allowance(time.monotonic() + FAR)).gap < 0.5


def test_what_a_slower_plan_loses_to_the_best_is_what_it_takes_longer():
    """A proof aims at that much less at each place; a plan that is the best already loses nothing."""
    problem, c = solved(1, cells=40)
    nodes = len(problem.nodes)
    place = Place(0, nodes - 1, nodes // 3, nodes // 2, 0.0)
    best = mesh_time(Knots(problem), c)
    assert to_gain(problem, c, place) == pytest.approx(0.0, abs=1e-5 * best)
    assert to_gain(problem, c / 1.1, place) == pytest.approx(best * (1.1**0.5 - 1.0), rel=1e-3)


@pytest.mark.parametrize("rest", [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)])
def test_a_plan_is_proved_between_the_states_that_it_has(rest):
    """A law that speeds up: at rest where it is at rest, in motion where it begins or ends in motion."""
    law = SplineLaw(np.linspace(0.2, 0.8, 21), np.linspace(0.5, 1.5, 23), rest)
    times = np.array([0.0, law.duration])
    _, speed, acceleration, _ = law.at(times)
    for k, state in enumerate(end_states(law)):
        assert state.at_rest == (rest[k] > 0.0)
        if not state.at_rest:
            assert (state.speed, state.acceleration) == (speed[k], acceleration[k]) and state.acceleration > 0.0


def test_no_cap_is_below_the_speed_of_an_end_in_motion():
    """A motion may be given that is above its limit there by what is promised, and slows down."""
    run, limits = line().runs[0], Limits([1.0], [1e3], [1e6])
    law = SplineLaw(np.linspace(0.0, 1.0, 21), np.linspace(1.0004, 0.5, 23) ** 2, (0.0, 0.0))
    z = law.z_at_nodes()
    assert z[0] > 1.0 and highest_speed(run, limits, law, law.nodes) == z[0]
    back = SplineLaw(law.nodes, law.c[::-1].copy(), (0.0, 0.0))
    assert highest_speed(run, limits, back, back.nodes) == pytest.approx(z[0])


def test_no_time_no_proof():
    case = flank()
    trajectory = tp.plan(case.axis_path, case.limits, mesh=200)
    assert tp.prove(trajectory, within=0.0).lower_bound == pytest.approx(trajectory.lower_bound, rel=1e-12)


def test_only_plans_with_a_mesh_can_be_proved():
    case = flank()
    slow = tp.plan(case.axis_path, case.limits, planner="genetic", generations=1)
    with pytest.raises(UsageError, match="genetic"):
        tp.prove(slow)


@pytest.mark.parametrize("seed", [1, 5])
def test_a_place_where_nothing_is_gained_is_left_with_most_of_the_allowance(seed):
    """A plan that is the best, taken for one that loses a tenth: other places need what is not spent here."""
    problem, c = solved(seed, cells=40)
    knots = Knots(problem)
    part, _ = whole(knots, c)
    best, allowance = mesh_time(knots, c), Allowance(knots=60_000)
    gain = close(part, 0.1 * best, FAR, allowance, 1.0, Workers(), UNTOLD)
    assert 0.0 <= gain <= best - part.found.value + 1e-7 * best
    assert allowance.knots > 40_000


def test_nothing_to_close_ends_at_once():
    problem, c = solved(1, cells=40)
    part, _ = whole(Knots(problem), c)
    assert close(part, 0.0, 0.0, Allowance(time.monotonic() + FAR), 1.0, Workers(), UNTOLD) == 0.0
