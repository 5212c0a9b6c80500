"""Replans of replans, what they leave as it was, feeds of blocks, and axes that are the same."""

from __future__ import annotations

import time as clock
from functools import cache

import numpy as np
import pytest

from testbed.from_positions import used_by_positions
from toolpace import deflection
from toolpace.deflection.detour import DetourRun
from toolpace.deflection.feed import fastest_braking, tip_rates, tip_velocity
from toolpace.deflection.measured_pose import rotary_near
from toolpace.machine.machine import Machine
from toolpace.motion.laws import ChainLaw
from toolpace.motion.trajectory import Trajectory
from toolpace.path.path import Path
from toolpace.planning.limit_tolerances import DETOUR, PROMISED
from toolpace.planning.planner import plan
from toolpace.programs.reading import read_text

MACHINE = Machine.load("paper-ab")
FEEDS = (0.03, 0.003, 0.03)
"""Of three blocks [m/s]: the second at a tenth."""


@cache
def arc() -> Trajectory:
    return plan(Path.paper_arc(), MACHINE, mesh=200, bound=False)


@cache
def of_three_feeds() -> Trajectory:
    path = Path.paper_arc()
    run = path.runs[0]
    from dataclasses import replace

    places = run.s0 + (run.s1 - run.s0) * np.array([0.0, 0.4, 0.5, 1.0])
    cut = replace(run, block_start=places, block=np.arange(1, 4), feed=np.array(FEEDS), least_time=np.zeros(3))
    return plan(replace(path, runs=(cut,)), MACHINE, mesh=300, bound=False)


def off_by(trajectory: Trajectory, time: float, random: np.random.Generator, size: float) -> np.ndarray:
    way = random.normal(size=3)
    return trajectory.tip([time])[0][0] + size * way / np.linalg.norm(way)


def test_replans_in_a_row_take_bounded_time_and_lose_no_more_than_the_deflections():
    """Nothing off: two hundred repeats, each from the one before, give the same motion."""
    old = current = arc()
    time, step = 1.0, 2e-3
    current = deflection.replan(old, time, old.tip([time])[0][0] + [0.0, 2e-4, 1e-4])
    first = current
    for _ in range(200):
        current = deflection.replan(current, step, current.tip([step])[0][0])
    t = np.linspace(0.0, current.duration, 200)
    np.testing.assert_allclose(current.at(t).q, first.at(t + 200 * step).q, atol=1e-12)
    assert current.duration == pytest.approx(first.duration - 200 * step, abs=1e-9)


@pytest.mark.sweep
def test_a_detour_from_a_detour_costs_what_the_first_did_and_goes_back_to_what_was_planned():
    old = current = arc()
    random, time, step, spent = np.random.default_rng(8), 0.8, 3e-3, []
    for _ in range(40):
        began = clock.process_time()
        current = deflection.replan(
            current, step if spent else time, off_by(current, step if spent else time, random, 5e-6)
        )
        spent.append(clock.process_time() - began)
        run = current.axis_path.runs[0]
        assert isinstance(run, DetourRun) and run.rest_of is old.axis_path.runs[0]
    assert np.median(spent[20:]) < 3.0 * np.median(spent[:20])
    lost = current.duration - (old.duration - time - 39 * step)
    assert lost < 40 * 5e-6 / 0.03, "no more than the way that the tool was set back"
    assert current.usage().worst <= PROMISED


@pytest.mark.parametrize("planner", ["optimal", "direct"])
def test_behind_the_rejoining_the_motion_is_what_it_was(planner):
    """Also where the planner times the detour anew, as it does near the end, where a detour must cost time."""
    old = arc()
    for time in (0.7, 2.6, old.duration - 0.02, 4.9):
        new = deflection.replan(old, time, old.tip([time])[0][0] + [3e-4, -2e-4, 1e-4], planner=planner)
        run, law = new.axis_path.runs[0], new.laws[0]
        end = new.at(new.duration).q
        np.testing.assert_allclose(end, old.at(old.duration).q, atol=1e-12)
        if isinstance(law, ChainLaw):
            t = np.linspace(float(law.times[-2]), law.duration, 300)
            shift = old.duration - new.duration
            for value in ("q", "qd", "qdd"):
                now, then = getattr(new.at(t), value), getattr(old.at(t + shift), value)
                np.testing.assert_allclose(now, then, atol=1e-7 * max(np.abs(then).max(), 1e-3))
            assert law.times[-2] <= 2.0 * run.detour.duration + 1e-9


def feed_abreast(run: DetourRun, t):
    """Feed of the block that the tool is abreast of, from the place alone."""
    blocks = run.block_at(run.parameter(t)[0])
    return np.array([FEEDS[block - 1] for block in blocks])


@pytest.mark.parametrize("ahead", [0.02, 0.08, 0.2, 0.5])
def test_the_feed_of_the_block_holds_on_a_detour(ahead):
    """Deflected before, at and in a block of a tenth of the feed."""
    old = of_three_feeds()
    border = old.laws[0].passing_time(float(old.axis_path.runs[0].run.block_start[1]))
    random = np.random.default_rng(int(1000 * ahead))
    for size in (2e-5, 5e-4):
        time = border - ahead
        new = deflection.replan(old, time, off_by(old, time, random, size))
        run = new.axis_path.runs[0]
        t = np.linspace(0.0, run.detour.duration, 4000)[:-1]
        motion = new.at(t)
        speed = np.linalg.norm(tip_velocity(MACHINE, motion.q, motion.qd), axis=1)
        share, until = run.above
        feed = feed_abreast(run, t)
        assert (speed[t > until] <= feed[t > until] * PROMISED).all()
        assert (speed <= feed * (1.0 + share) * PROMISED).all()
        assert new.usage().worst <= PROMISED
        if share > 0.0:
            assert f"start above feed by {100 * share:.3g} %" in new.notes[0]


def test_a_start_above_the_feed_is_braked_nearly_as_fast_as_jerk_allows():
    old, random, seen = arc(), np.random.default_rng(2), 0
    for _ in range(12):
        time = random.uniform(1.0, 4.0)
        new = deflection.replan(old, time, off_by(old, time, random, 2e-3))
        share, until = new.axis_path.runs[0].above
        if share < 1e-3:
            continue
        seen += 1
        detour = new.axis_path.runs[0].detour
        t = np.linspace(0.0, detour.duration, 4000)
        rates = tip_rates(MACHINE, detour.motion(t)[0])
        braked = fastest_braking(rates, detour.motion(np.zeros(1))[:3, 0], t, old.limits, 1.0)
        least = t[int(np.argmax(braked <= 0.03 * DETOUR))]
        assert until <= 1.5 * least + 0.02 * detour.duration
    assert seen >= 3


@pytest.mark.sweep
def test_no_limit_is_passed_by_positions_alone():
    old, random = arc(), np.random.default_rng(31)
    for time in (0.05, 1.7, 4.2):
        new = deflection.replan(old, time, off_by(old, time, random, 4e-4))
        assert used_by_positions(new).max() <= PROMISED


@pytest.mark.parametrize("angle", [0.0, 1e-7, 1e-6, 8e-6])
def test_beside_the_pole_an_axis_off_by_next_to_nothing_turns_no_joint(angle):
    machine = Machine.load("xyzac-trunnion")
    rotary = np.array([[0.3, 2e-6]])
    if machine.joints[machine.rotary[0]] != "C":
        rotary = rotary[:, ::-1]
    axis = machine.axis_at(rotary)[0]
    for turn in np.linspace(0.0, 6.0, 7):
        off = axis + angle * np.array([np.cos(turn), np.sin(turn), 0.0])
        found = rotary_near(machine, rotary, off, 1.0, 1e-5)
        assert abs(found[0, 0] - rotary[0, 0]) < 1e-9
        assert np.linalg.norm(np.cross(machine.axis_at(found)[0], off)) <= 1.01e-5
    if angle == 1e-6:
        exact = [
            rotary_near(machine, rotary, axis + 1e-6 * np.array([np.cos(a), np.sin(a), 0.0]), 1.0, 0.0)
            for a in (1.0, 2.0, 4.0)
        ]
        assert max(abs(found[0, 0] - rotary[0, 0]) for found in exact) > 0.3, "to the last digit C turns far"


def test_far_from_the_pole_an_axis_is_met_beyond_the_tolerance():
    old = arc()
    tip, axis = (value[0] for value in old.tip([2.0]))
    turn = np.cross(axis, [0.3, 0.2, 0.9])
    for angle, met in ((5e-6, False), (1e-3, True)):
        wanted = np.cos(angle) * axis + np.sin(angle) * turn / np.linalg.norm(turn)
        pose = deflection.deflected_pose(old, 2.0, tip, axis=wanted)
        error = np.linalg.norm(MACHINE.forward(pose[None])[1][0] - wanted)
        assert (error < 1e-9) == met and error < 1e-5


@pytest.mark.parametrize("joint", [0, 1, 4])
def test_a_way_back_keeps_within_travel(joint):
    """Where it would swing out of a travel that ends just beyond the path, it takes another way."""
    old, time = arc(), 1.4
    found = old.tip([time])[0][0] + [1.5e-3, -1e-3, 5e-4]
    free = deflection.replan(old, time, found).axis_path.runs[0].detour
    path = old.at(np.linspace(time, old.duration, 3000)).q[:, joint]
    start = free.motion(np.zeros(1))[0, 0, joint]
    low, high = min(path.min(), start), max(path.max(), start)
    narrow = Machine.from_toml(MACHINE.to_toml(), "narrow")
    travel = narrow.travel.copy()
    travel[joint] = low - 2e-5, high + 2e-5
    object.__setattr__(narrow, "travel", travel)
    kept = deflection.replan(old, time, found, narrow).axis_path.runs[0].detour
    q = kept.motion(np.linspace(0.0, kept.duration, 4000))[0][:, joint]
    assert low - 2.1e-5 <= q.min() and q.max() <= high + 2.1e-5


@pytest.mark.parametrize("later", ["displaced", "bending", "in place"])
@pytest.mark.parametrize("offset", [0.0, 1e-3])
def test_a_detour_from_a_detour_to_the_start_goes_along_the_path_once(later: str, offset: float):
    """Found off its path before it has begun, the tool goes to the start first; the path is still to come, once."""
    old = arc()
    random = np.random.default_rng(12)
    first = deflection.replan(old, 0.0, off_by(old, 0.0, random, 2e-4), rejoin=float(old.axis_path.runs[0].s0))
    run = first.axis_path.runs[0]
    assert isinstance(run, DetourRun) and run.leads_to_start and len(first.laws) == 2
    at = run.detour.duration * 0.5 + offset
    size, cause = (0.0, "displaced") if later == "in place" else (5e-5, later)
    again = deflection.replan(first, at, off_by(first, at, random, size), cause=cause)
    third = deflection.replan(again, 1e-3, off_by(again, 1e-3, random, 1e-5), cause="bending")
    for motion, before, passed in ((again, first, at), (third, again, 1e-3)):
        t = np.linspace(0.0, motion.duration, 20001)
        speed = np.abs(np.diff(motion.at(t).q, axis=0)) / t[1]
        assert (speed <= PROMISED * MACHINE.limits.velocity).all(), "no jump"
        assert motion.duration == pytest.approx(before.duration - passed, abs=0.3)
        tip = motion.at(motion.duration).q - old.at(old.duration).q
        assert np.abs(tip).max() < 3e-4


@pytest.mark.sweep
@pytest.mark.parametrize("cause", ["displaced", "bending"])
def test_detours_of_microseconds_are_told_as_they_are(cause: str):
    """A nanometre off, the detour takes some tenths of a millisecond: its jerk is not reckoned from places that differ
    by less than what they are rounded to."""
    machine = MACHINE.with_limits(MACHINE.limits.scaled(1.0, 0.02, 50.0))
    old = plan(Path.paper_arc(), machine, mesh=200, bound=False)
    random = np.random.default_rng(21)
    for size in (3e-11, 1e-10, 1e-9, 1e-8, 1e-7):
        for time in (0.3, 0.5, 0.7) * np.array(old.duration):
            found = deflection.replan(old, time, off_by(old, time, random, size), cause=cause, planner="direct")
            run, law = found.axis_path.runs[0], found.laws[0]
            assert isinstance(run, DetourRun)
            t = run.detour.duration * np.linspace(0.0, 0.999, 50)
            for told, known in zip(law.at(t)[1:], run.parameter(t)[1:]):
                assert np.abs(told - known).max() <= 1e-9 * (1.0 + np.abs(known).max())
            assert found.usage().worst <= max(PROMISED, old.usage().worst)


@pytest.mark.parametrize("size", [1e-4, *(pytest.param(size, marks=pytest.mark.sweep) for size in (3e-4, 1e-3, 3e-3))])
def test_a_tool_off_the_start_of_a_slow_feed_finds_back(size: float):
    """The axes alone are no measure of the way to a path that is begun at a millimetre a second; and on a detour of
    seconds the feed abreast falls by half within a step."""
    machine = Machine.load("xyzac-trunnion")
    program = "G21 G90 G94\nG0 X0 Y0 Z5 A0 C0\nG1 Z4 F60\nX1 F30\nY1 A1\nM2\n"
    old = plan(Path.fit(read_text(program, machine), machine=machine), machine, bound=False)
    random = np.random.default_rng(31)
    for cause in ("displaced", "bending"):
        for _ in range(3):
            found = deflection.replan(old, 0.0, off_by(old, 0.0, random, size), machine, cause=cause, planner="direct")
            assert found.usage().worst <= PROMISED
