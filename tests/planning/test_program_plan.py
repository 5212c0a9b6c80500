"""Path and pace, each from the other: never slower than the smoothest path, within the same limits and tolerances."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest

import toolpace as tp
from testbed.programs import s_shape, tulsyan
from toolpace.common.errors import InfeasibleError, ReachError, UsageError
from toolpace.planning import program_plan
from toolpace.planning.limit_tolerances import PROMISED
from toolpace.planning.optimal import planner as optimal_planner
from toolpace.planning.optimal.planner import Optimal
from toolpace.planning.path_and_pace import alternating, candidate_evaluation
from toolpace.planning.path_and_pace.candidate_evaluation import USUAL_LOSS, crawls
from toolpace.planning.program_plan import fit_program, plan_fitted, plan_program
from toolpace.programs.tolerances import Tolerances

TIP, AXIS = 10e-6, math.radians(0.05)


@pytest.fixture(scope="module")
def plans(blade, machine):
    return {effort: plan_program(blade, machine, TIP, AXIS, effort=effort) for effort in ("low", "normal")}


def test_rounds_of_pace_and_fit_save_time(plans):
    low, normal = plans["low"], plans["normal"]
    assert normal.trajectory.duration < 0.985 * low.trajectory.duration
    assert low.rounds == () and low.effort == "low"
    assert len(normal.rounds) >= 2 and normal.rounds[0].power == 0.0


@pytest.mark.parametrize("program", [s_shape, tulsyan])
def test_rounds_save_time_where_blocks_are_long(program, machine):
    """With few points to a block the fit for a pace strays between its samples at first, and has to find back."""
    rounds = fit_program(program(machine), machine, TIP, AXIS, effort="normal").rounds
    assert min(each.duration for each in rounds) < 0.92 * rounds[0].duration


def test_limits_and_tolerances_hold_as_they_did(plans, blade, machine):
    for plan in plans.values():
        assert plan.trajectory.usage().worst <= PROMISED
        tp.verify(plan.trajectory, machine, blade, TIP, AXIS).raise_if_failed()


def test_a_round_is_kept_where_it_is_the_fastest_so_far(plans):
    least = np.inf
    for each in plans["normal"].rounds:
        assert each.kept == (each.duration < least)
        least = min(least, each.duration)
    assert plans["normal"].trajectory.duration == pytest.approx(least, rel=0.01)


def test_low_is_fit_and_plan(plans, blade, machine):
    path = tp.Path.fit(blade, TIP, AXIS, machine)
    assert plans["low"].trajectory.duration == tp.plan(path, machine).duration


def test_the_path_tells_where_it_uses_the_tolerance(plans):
    run = plans["normal"].path.runs[0]
    breaks, tip, axis = run.deviations()
    assert len(tip) == len(axis) == len(breaks) - 1
    assert tip.max() == pytest.approx(plans["normal"].path.tip_deviation) and tip.max() > 0.9 * TIP
    assert axis.max() == pytest.approx(plans["normal"].path.axis_deviation)


def test_a_path_that_turns_out_slow_gives_way_to_the_first(blade, machine, monkeypatch):
    """The cheap motions of rounds promised more than whole plans hold: all that may be better are planned."""
    fitted = fit_program(blade, machine, TIP, AXIS, effort="normal")

    def slow(planner, run, *given):
        planned = plan_run(Optimal(bound=False, guard=False), run, *given)
        return planned if run.run is fitted.first.runs[0] else replace(planned, law=planned.law.slowed(9.0))

    plan_run = Optimal.plan_run
    monkeypatch.setattr(Optimal, "plan_run", slow)
    assert plan_fitted(fitted, machine).path is fitted.first

    def none(planner, run, *given):
        if run.run is fitted.first.runs[0]:
            return slow(planner, run, *given)
        raise InfeasibleError("none")

    monkeypatch.setattr(Optimal, "plan_run", none)
    assert plan_fitted(fitted, machine).path is fitted.first

    def nowhere(planner, run, *given):
        raise InfeasibleError("the first" if run.run is fitted.first.runs[0] else "another")

    monkeypatch.setattr(Optimal, "plan_run", nowhere)
    with pytest.raises(InfeasibleError, match=r"^the first$"):
        plan_fitted(fitted, machine)


TWO_RUNS = "G21 G94\nG0 X0 Y0 Z0 A0 C0\nG1 X20 F20000\nY4\nX0\nY8\nG4 P1\nX20\nY12\nX0\n"


def test_each_run_takes_the_best_of_its_paths(machine, monkeypatch):
    """Where the plan of one run turns out slow another path takes its place there, and there only."""
    program = tp.read_text(TWO_RUNS, machine)
    fitted = fit_program(program, machine, TIP, AXIS)
    promised, first = fitted.candidates[0], fitted.first
    assert promised.path is not first and len(first.runs) == 2
    planned = []

    def slow(planner, run, *given):
        planned.append(run.run)
        found = plan_run(planner, run, *given)
        return replace(found, law=found.law.slowed(4.0)) if run.run is promised.path.runs[1] else found

    plan_run = Optimal.plan_run
    monkeypatch.setattr(Optimal, "plan_run", slow)
    found = plan_fitted(fitted, machine)
    assert planned.count(promised.path.runs[0]) == 1 and first.runs[0] not in planned
    assert found.path.runs[0] is promised.path.runs[0] and found.path.runs[1] is not promised.path.runs[1]
    runs = found.trajectory.axis_path.runs
    assert [run.run for run in runs] == list(found.path.runs)
    end, begin = runs[0].evaluate(np.array([runs[0].s1]))[0], runs[1].evaluate(np.array([runs[1].s0]))[0]
    np.testing.assert_allclose(end, begin, atol=1e-12)
    assert found.trajectory.usage().worst <= 1.0001
    assert found.path.tip_deviation == max(run.deviations()[1].max() for run in found.path.runs) <= TIP
    assert found.trajectory.lower_bound <= found.trajectory.duration < plan_fitted(
        replace(fitted, candidates=(promised,)), machine
    ).trajectory.duration


def test_a_run_whose_plan_is_as_long_as_it_may_be_is_planned_once(machine, monkeypatch):
    """Cheap motions of its paths are a little too fast, all by the same: a look at the others would tell nothing."""
    fitted = fit_program(tp.read_text(TWO_RUNS, machine), machine, TIP, AXIS)
    planned, plan_run = [], Optimal.plan_run
    monkeypatch.setattr(Optimal, "plan_run", lambda *given: planned.append(given[1]) or plan_run(*given))
    plan_fitted(fitted, machine)
    assert len(planned) == 2 and len(fitted.candidates) >= 3


def test_joints_beyond_travel_on_a_fast_path_leave_the_others(blade, machine):
    """A path within the tolerances may still be one that the travel does not allow: the next is taken."""
    fitted = fit_program(blade, machine, TIP, AXIS, effort="normal")

    def only_the_first(axis_path):
        if axis_path.runs[0].run is not fitted.first.runs[0]:
            raise ReachError("beyond travel")

    def none(axis_path):
        raise ReachError("the first" if axis_path.runs[0].run is fitted.first.runs[0] else "another")

    assert plan_fitted(fitted, machine, check=only_the_first).path is fitted.first
    with pytest.raises(ReachError, match=r"^the first$"):
        plan_fitted(fitted, machine, check=none)


def test_a_first_path_whose_motion_nobody_knows_is_planned_too(blade, machine, monkeypatch):
    """Where it crawls with its limits at the nodes, nothing is promised of it; it may be the best all the same."""
    planned = program_plan.plan
    seen = []

    def first_crawls(path, *given, **options):
        seen.append(path)
        if len(seen) == 1:
            raise InfeasibleError("none at the nodes")
        return planned(path, *given, **options)

    monkeypatch.setattr(alternating, "plan", first_crawls)
    fitted = fit_program(blade, machine, TIP, math.radians(0.2), effort="normal")
    assert [each.hoped for each in fitted.candidates].count(0.0) == 1 and len(fitted.candidates) >= 3
    assert fitted.candidates[-1].hoped == 0.0
    unknown = fitted.candidates[-1].path
    assert all(each.axis_tolerance > 1.5 * math.radians(0.05) for each in fitted.rounds)
    slowed = []

    def slow(planner, run, *given):
        slowed.append(run.run)
        return plan_run(Optimal(bound=False, guard=False), run, *given)

    plan_run = Optimal.plan_run
    monkeypatch.setattr(Optimal, "plan_run", slow)
    plan_fitted(fitted, machine)
    assert slowed[-1] is unknown.runs[0]


def test_another_planner_takes_the_path_as_it_is(blade, machine):
    plan = plan_program(blade, machine, TIP, AXIS, planner="second-order")
    assert plan.effort == "low" and plan.rounds == ()


def test_misspelt_effort(blade, machine):
    with pytest.raises(UsageError, match=r"effort is 'hihg'; did you mean 'high'"):
        plan_program(blade, machine, effort="hihg")


def test_a_wider_tolerance_of_the_axis_does_not_cost_time(plans, blade, machine):
    wide = plan_program(blade, machine, TIP, math.radians(1.0))
    assert wide.trajectory.duration <= 1.002 * plans["normal"].trajectory.duration


def test_narrower_tolerances_are_the_same_for_all_wider_ones():
    degrees = [np.degrees(program_plan.axis_tolerances(math.radians(wide))) for wide in (0.02, 0.05, 0.2, 0.7, 3.0)]
    assert [np.round(each, 9).tolist() for each in degrees] == [
        [0.02], [0.05], [0.05, 0.1, 0.2], [0.05, 0.1, 0.2, 0.5, 0.7], [0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 3.0],
    ]  # fmt: skip


@pytest.mark.sweep
def test_what_a_narrower_tolerance_gains_a_wider_one_has_too(blade, machine):
    """Of all that may be asked for in steps: the paths of the narrower are candidates of the wider."""
    hoped = [
        min(each.duration for each in fit_program(blade, machine, TIP, math.radians(wide)).rounds)
        for wide in (0.05, 0.1, 0.2, 0.5)
    ]
    assert all(wider <= narrower for narrower, wider in itertools.pairwise(hoped))


class ToldRounds:
    """Rounds whose quick changes take what is told for each tolerance of the axis."""

    best = "widest"

    def __init__(self, told):
        self.told, self.tried = told, []

    def within(self, tolerances, widest):
        self.tried.append((widest, None))

    def change(self, start):
        widest = self.tried[-1][0]
        self.tried[-1] = widest, start
        return self.told[widest]


def test_narrower_tolerances_are_changed_within_while_these_are_no_slower():
    for told, tried in (
        ({1.0: 5.0, 2.0: 6.0, 3.0: 5.5}, [3.0, 2.0]),
        ({1.0: 5.0, 2.0: 5.2, 3.0: 5.2}, [3.0, 2.0, 1.0]),
        ({1.0: 5.0, 2.0: math.inf, 3.0: math.inf}, [3.0, 2.0, 1.0]),
        ({1.0: math.inf, 2.0: 5.1, 3.0: 5.2}, [3.0, 2.0, 1.0]),
    ):
        rounds = ToldRounds(told)
        rounds.within(None, 3.0)
        program_plan.change_once(rounds, Tolerances.of(3.0, "axis_tolerance"), [1.0, 2.0], "narrow")
        assert rounds.tried == [(3.0, "widest"), *((axis, "narrow") for axis in tried[1:])]


@pytest.mark.parametrize("axis", [AXIS, math.radians(0.2)])
def test_high_chooses_from_what_normal_finds_too(blade, machine, axis):
    normal, high = (fit_program(blade, machine, TIP, axis, effort=effort) for effort in ("normal", "high"))
    hoped = [each.hoped for each in high.candidates]
    assert {each.hoped for each in normal.candidates} <= set(hoped) and hoped == sorted(set(hoped))
    assert high.rounds[: len(normal.rounds)] == normal.rounds and len(set(high.rounds)) == len(high.rounds)
    least = np.minimum.accumulate([np.inf, *(each.duration for each in high.rounds)])
    assert [each.kept for each in high.rounds] == [each.duration < before for each, before in zip(high.rounds, least)]
    # the thorough change goes on from a path that was fitted: one that was changed is rougher
    assert high.start in high.candidates and high.start not in normal.candidates[:1]


def test_where_nothing_turns_no_narrower_tolerances_of_the_axis_are_tried(blade, machine):
    """All would give the same path, twelve times."""
    straight = tp.read_text("G21 G94\nG0 X0 Y0 Z0 A0 C0\nG1 X20 F20000\nY4\nX0\n", machine)
    rounds = fit_program(straight, machine, TIP, math.radians(5.0)).rounds
    assert len(rounds) == 3 and {each.axis_tolerance for each in rounds} == {math.radians(5.0)}
    assert program_plan.turns(blade) and not program_plan.turns(straight)
    assert program_plan.turns(tp.read_text("G21 G94\nG0 X0 Y0 Z0 A0 C0\nG1 X20 C90 F20000\n", machine))


@pytest.mark.sweep
def test_a_drill_does_not_keep_the_rest_of_a_program_from_its_rounds(machine, monkeypatch):
    """Where it turns back on its own way the pace held at the nodes falls to next to nothing, and tells nothing, but
    for finer cells there."""
    cut = "G21 G94\nG0 X0 Y0 Z0\nG1 X20 F20000\nY4\nX0\nG0 Z20\nG98 G83 X0 Y0 Z-12 R1 Q2 F1000\nG80\nG0 Z50\n"
    program = tp.read_text(cut, machine)
    rounds = fit_program(program, machine, TIP, AXIS).rounds
    assert len(rounds) == 3 and min(each.duration for each in rounds) < rounds[0].duration < 20.0
    path = tp.Path.fit(program, TIP, AXIS, machine)
    at_nodes = tp.plan(path, machine, guard=False, bound=False)
    assert not crawls(at_nodes.laws[0])
    assert at_nodes.duration == pytest.approx(tp.plan(path, machine, bound=False).duration, rel=USUAL_LOSS)

    pecks = tp.read_text("G21 G94\nG0 X0 Y0 Z20\nG98 G83 X0 Y0 Z-40 R1 Q1.5 F1000\nG80\nG0 Z50\n", machine)
    path = tp.Path.fit(pecks, TIP, AXIS, machine)
    at_nodes = tp.plan(path, machine, guard=False, bound=False)
    assert not crawls(at_nodes.laws[0])
    monkeypatch.setattr(optimal_planner, "without_falls", as_it_was)
    crawling = tp.plan(path, machine, guard=False, bound=False)
    assert crawling.duration > 3.0 * at_nodes.duration and crawls(crawling.laws[0])


def as_it_was(meshed, law, workers):
    return law


@pytest.mark.sweep
def test_a_run_that_was_ranked_by_a_whole_plan_is_not_planned_again(machine, monkeypatch):
    """Of a drill whose motion at the nodes counts as one that crawls; what is taken is what planning its path gives."""
    monkeypatch.setattr(candidate_evaluation, "crawls", lambda law: True)
    cut = "G21 G94\nG0 X0 Y0 Z20\nG98 G83 X0 Y0 Z-12 R1 Q2 F1000\nG80\nG0 Z50\n"
    fitted = fit_program(tp.read_text(cut, machine), machine, TIP, AXIS)
    known = next(each for each in fitted.candidates if set(each.joints.runs) <= set(each.whole))
    fitted = replace(fitted, candidates=(known,))
    again = tp.plan(known.path, machine)
    planned = []
    plan_run = Optimal.plan_run
    monkeypatch.setattr(Optimal, "plan_run", lambda *given: planned.append(given[1]) or plan_run(*given))
    best = plan_fitted(fitted, machine).trajectory
    assert not planned
    assert best.duration == again.duration and best.lower_bound == again.lower_bound
    # other options ask for other plans
    plan_fitted(fitted, machine, planner=Optimal(bound=False))
    assert planned == list(known.joints.runs)
