"""A way back from any state: always found, within all limits by positions alone, joined, and soon computed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import toolpace as tp
from testbed import replans
from testbed.true_tip.cases import BUILTIN
from testbed.true_tip.chain import Chain
from toolpace.common.arrays import Floats
from toolpace.common.errors import InfeasibleError
from toolpace.deflection.detour import DetourRun
from toolpace.deflection.feed import fastest_braking
from toolpace.deflection.rejoin.guaranteed import (
    FeedFallback,
    Standby,
    best_aside,
    guessed,
    price,
    waits,
    with_pace,
)
from toolpace.deflection.rejoin.joint_splines import Problem
from toolpace.deflection.rejoin.superposed import SuperposedRejoin
from toolpace.deflection.rejoin_motion import CommandedMotion
from toolpace.machine.limits import Limits


def clean(case: replans.Case) -> None:
    assert not case.faults, case.told()


@pytest.mark.parametrize("cause", replans.CAUSES)
def test_a_slow_line_is_found_back_to(cause):
    """60 mm at 60 mm/min, 0.2 mm aside: at the feed that is 0.2 s, and no more than a second is lost."""
    case = replans.Case("line", 60.0, cause, "direct", 2e-4, 30.0)
    replans.tried(case, np.array([0.0, 1.0, 0.0]))
    clean(case)
    assert 0.0 < case.lost < 0.25


@pytest.mark.parametrize("way", [[0, 0, 1], [0.6, -0.8, 0.0]])
def test_the_papers_arc_is_found_back_to_from_the_papers_deflection(way):
    case = replans.Case("arc", 600.0, "displaced", "direct", 2.4e-3, 9.0)
    replans.tried(case, np.asarray(way, dtype=float))
    clean(case)


@pytest.mark.parametrize("share", [0.0, 1e-3, 0.9999, 1.0])
def test_the_ends_of_a_slow_path_are_found_back_to(share):
    case = replans.Case("line", 180.0, "displaced", "direct", 2e-3, share * replans.planned("line", 180.0).duration)
    replans.tried(case, np.array([0.3, 0.9, -0.3]) / np.sqrt(0.99))
    clean(case)


@pytest.mark.parametrize("rejoin", ["projection", 0.2, 0.9, 0.0, 1.0])
def test_a_place_to_rejoin_is_come_to_at_a_slow_feed(rejoin):
    """Before it and behind it: there the tool comes to rest, and starts again."""
    old = replans.planned("line", 60.0)
    time = 0.5 * old.duration
    new = tp.replan(old, time, old.tip([time])[0][0] + [0.0, 3e-4, 1e-4], rejoin=rejoin, planner="direct")
    run = new.axis_path.runs[0]
    assert isinstance(run, DetourRun)
    wanted = 0.5 if rejoin == "projection" else rejoin
    assert run.join == pytest.approx(wanted, abs=1e-6)
    assert new.usage().worst <= 1.0001


def test_a_replan_of_a_replan_beside_the_path():
    """From the midst of a way aside another: the joints go on without a jump."""
    old = replans.planned("line", 60.0)
    one = tp.replan(old, 30.0, old.tip([30.0])[0][0] + [0.0, 2e-4, 0.0], planner="direct")
    for time in (0.01, 0.1, 0.2):
        two = tp.replan(one, time, one.tip([time])[0][0] + [0.0, 0.0, 3e-4], planner="direct")
        np.testing.assert_allclose(two.at([0.0]).qd, one.at([time]).qd, atol=1e-12)
        np.testing.assert_allclose(two.at([0.0]).qdd, one.at([time]).qdd, atol=1e-9)
        assert two.usage().worst <= 1.0001
        assert abs(two.tip([two.duration])[0][0] - old.tip([old.duration])[0][0]).max() < 1e-9


def test_a_state_outside_travel_is_refused():
    old = replans.planned("line", 60.0)
    with pytest.raises(InfeasibleError, match="travel"):
        tp.replan(old, 30.0, [9.0, 0.1, 0.1], most=10.0)


@pytest.mark.parametrize("accelerating", [-1.5, 0.0, 1.5])
def test_the_fastest_braking_is_that_of_a_jerk_then_an_acceleration(accelerating):
    """One joint along the tip, stepped through by hand: jerk until the acceleration's limit, then that."""
    jerk, most, speed = 50.0, 2.0, 3.0
    limits = Limits(velocity=np.array([9.0]), acceleration=np.array([most]), jerk=np.array([jerk]))
    times = np.array([0.0, 0.01, 0.05, 0.2, 0.6, 1.0])
    steps = 200_000
    grid = np.linspace(0.0, 1.0, steps + 1)
    a = np.maximum(accelerating - jerk * grid, -most)
    v = speed + np.concatenate([[0.0], np.cumsum((a[1:] + a[:-1]) / 2.0 / steps)])
    rates = np.tile(np.array([[[1.0], [0.0], [0.0]]]), (len(times), 1, 1))
    start = np.array([[0.0], [speed], [accelerating]])
    found = fastest_braking(rates, start, times, limits, 1.0)
    np.testing.assert_allclose(found, np.interp(times, grid, v), atol=1e-6)
    backwards = fastest_braking(-rates, start, times, limits, 1.0)
    np.testing.assert_allclose(backwards, np.interp(times, grid, v), atol=1e-6)


def problem_at(kind: str, feed: float, share: float, offset: Floats) -> Problem:
    """The joints off by an offset (m,) at a share of a plan."""
    old = replans.planned(kind, feed)
    motion, left = CommandedMotion.of(old, 0), share * old.laws[0].duration
    start = motion.motion(np.array([left]))[:3, 0]
    start[0] += offset
    return Problem(motion, left, start, old.limits, replans.machine_of(kind))


@pytest.mark.parametrize("seed", [5, 7, 20, 27, 28])
def test_no_other_pace_is_much_sooner_than_those_that_are_tried(seed: int):
    """Where joints and feed leave least choice: a gap among the paces costs up to five times as much there."""
    random = np.random.default_rng(seed)
    offset = 10.0 ** random.uniform(-5.0, -2.3) * random.normal(size=5) * [1.0, 1.0, 1.0, 0.0, 0.0]
    problem = problem_at("five 2", 1800.0, random.uniform(0.05, 0.9), offset)
    given = problem, problem.start, problem.left
    best = min(with_pace(*given, pace, None, None, np.inf, FeedFallback())[1] for pace in np.linspace(0.0, 1.0, 11))
    assert price(best_aside(problem, None, None, np.inf, FeedFallback())) <= 1.25 * best


@pytest.mark.parametrize("pace", [0.0, 0.5, 0.95])
def test_the_first_guess_of_an_even_part_uses_all_of_the_velocity(pace: float):
    """Of a joint that is 5 mm behind on a line at 10 mm/s, with no other limit; by differences of positions."""
    ample, most = np.full(5, 1e9), np.full(5, 0.02)
    whole = problem_at("line", 600.0, 0.4, np.array([-5e-3, 1e-4, 0.0, 0.0, 0.0]))
    problem = replace(whole, machine=None, limits=Limits(velocity=most, acceleration=ample, jerk=ample))
    paces = (1.0, pace, 1.0)
    shape = guessed(problem, problem.start, problem.left, paces)
    assert shape is not None
    way = SuperposedRejoin(problem.commanded, problem.left, problem.start, problem.left, paces, shape)
    q = way.motion(shape.ramp + shape.even * np.array([0.3, 0.7]))[0]
    assert np.abs(q[1] - q[0]).max() / (0.4 * shape.even) == pytest.approx(0.02, rel=1e-3)


@pytest.mark.parametrize("kind", ["arc", "spline", "five 1"])
def test_a_motion_that_goes_on_is_left_where_the_limits_leave_room_or_at_its_end(kind: str):
    """By differences of positions about each instant: no more than 0.9 of any limit."""
    old, asked = replans.planned(kind, 6000.0), 0
    motion, whole = CommandedMotion.of(old, 0), old.laws[0].duration
    step = 1e-5 * whole
    for share in (0.0, 0.2, 0.5, 0.8):
        problem = problem_at(kind, 6000.0, share, np.zeros(5))
        standby = Standby(motion, problem.left, np.zeros(5), lambda wait, left=problem.left: left + wait)
        *some, last = waits(problem, standby)
        assert last == pytest.approx(whole - problem.left)
        asked += len(some)
        for wait in some:
            q = old.at(np.clip(problem.left + wait + step * np.arange(-1.5, 2.0), 0.0, whole)).q
            for order, limit in enumerate((old.limits.velocity, old.limits.acceleration, old.limits.jerk), start=1):
                used = np.abs(np.diff(q, order, axis=0)) - 2.0**order * 1e-15
                assert (used / step**order <= 0.905 * limit).all()
    assert asked > 0


def of_two_tools(lengths: tuple[float, float]) -> tuple[tp.Trajectory, Chain]:
    """A program of two tools by a sheet, on a head machine with its axes turning."""
    from testbed.true_tip.cases import Maker
    from toolpace.programs.reading.setup_file import setup_of_text

    case = Maker(3, "xyzbc-head", "g43.4", list(lengths), points=25).make()
    machine = tp.Machine.load("xyzbc-head")
    program = tp.read_text(case.text, machine, setup=setup_of_text(case.sheet))
    path = tp.Path.fit(program, machine=machine)
    return tp.plan(path, machine, bound=False), Chain((BUILTIN / "xyzbc-head.toml").read_text())


@pytest.mark.parametrize("cause", replans.CAUSES)
def test_the_tool_in_the_spindle_is_the_one_that_is_brought_back(cause):
    old, chain = of_two_tools((0.06, 0.21))
    machine = tp.Machine.load("xyzbc-head")
    lengths = old.axis_path.tool_lengths
    assert {0.06, 0.21} <= set(lengths.tolist())
    for length in (0.06, 0.21):
        run = int(np.flatnonzero(lengths == length)[-1])
        time = float(old.starts[run] + 0.5 * old.laws[run].duration)
        q = old.at([time]).q
        found = chain.forward(q, length)[0][0] + [0.0, 1e-4, 5e-5]
        new = tp.replan(old, time, found, machine, cause=cause, planner="direct")
        start = chain.forward(new.at([0.0]).q, length)[0][0]
        np.testing.assert_allclose(start, found if cause == "displaced" else found - [0.0, 1e-4, 5e-5], atol=1e-10)
        np.testing.assert_allclose(new.tip([0.0])[0][0], start, atol=1e-10)
        assert new.axis_path.tool_lengths[0] == length
        rejoin = new.axis_path.runs[0].detour
        after = rejoin.duration
        there = chain.forward(new.at([after]).q, length)[0][0]
        wanted = rejoin.commanded.run
        wanted = getattr(wanted, "base", wanted)
        on_path = wanted.run.evaluate(rejoin.abreast(np.array([after]))).tip[0, 0]
        bending = np.array([0.0, 1e-4, 5e-5]) if cause == "bending" else 0.0
        np.testing.assert_allclose(there + bending, on_path, atol=1e-9)
        # the feed of the tip, by its own tool's length
        t = np.linspace(new.axis_path.runs[0].above[1], after, 400)[:-1]
        ends = [chain.forward(new.at(t + d).q, length)[0] for d in (0.0, 1e-6)]
        speed = np.linalg.norm(ends[1] - ends[0], axis=1) / 1e-6
        feed = wanted.run.feed[wanted.run.block_index(rejoin.abreast(t))]
        assert (speed <= 1.0002 * feed + 1e-8).all()


@pytest.mark.thorough
def test_a_hundred_replans_at_random_are_found_and_clean():
    """Of each kind, feed, cause and planner, as testbed/replans.py draws and judges them."""
    for case in replans.sweep(100, 11):
        clean(case)


@pytest.mark.thorough
def test_ten_thousand_replans_at_random_are_found_and_clean():
    for case in replans.sweep(10_000, 12):
        clean(case)
        assert case.seconds < 10.0, case.told()
