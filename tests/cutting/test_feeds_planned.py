"""Feeds by what is cut: nowhere faster where something may be cut than air, teachers or limits allow."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

import toolpace as tp
from tests.support.feed_programs import SHEET, TWO_SLOTS
from tests.support.program_with_feeds import with_feeds
from toolpace.common.errors import UsageError
from toolpace.cutting.engagement.table import EngagementTable
from toolpace.cutting.feeds.feed_moves import check_tools
from toolpace.cutting.feeds.feed_plan import KeptFeed, plan_feeds
from toolpace.cutting.feeds.learned import best_of, held_loads, learned_speeds
from toolpace.cutting.feeds.limits import CLOSE, CutLimits, root_below, speeds_within
from toolpace.cutting.feeds.rules import FeedRules
from toolpace.cutting.feeds.schedule import Places, Steps, over_window, stepped
from toolpace.cutting.feeds.teaching import load_teachers, save_teachers
from toolpace.cutting.forces.engaged import EngagedForces
from toolpace.machine.cutting_tool import Coefficients
from toolpace.programs.reading.setup_file import setup_of_text
from toolpace.programs.tool_figures import ToolFigures

TOOL = ToolFigures("flat", 10e-3, flute_length=20e-3, teeth=3, helix=math.radians(30.0), stick_out=40e-3,
                   material="carbide", spindle_speed=100.0)  # fmt: skip
def shoulder(width, depth, n=40, slices=8):
    """A milled shoulder of a width (n,) and a depth as engagement: up milling, chips from nothing."""
    width = np.broadcast_to(width, n)
    height = depth / slices
    entry, leave = np.zeros(n), np.arccos(1.0 - 2.0 * width / TOOL.diameter)
    none = np.zeros(n)
    return EngagementTable(
        slice_height=height, feed_direction=np.tile([1.0, 0.0, 0.0], (n, 1)), across=np.ones(n), along=none,
        first_arc=np.arange(n + 1) * slices, slice=np.tile(np.arange(slices), n), entry=np.repeat(entry, slices),
        exit=np.repeat(leave, slices), bottom=none, removed=np.full(n, 1e-12), width=width.copy(),
        depth=np.full(n, depth),
    )  # fmt: skip


def places(n, step=0.2e-3):
    return Places(np.linspace(0.0, 1.0, n), np.arange(n) * step)


@pytest.mark.parametrize("seed", range(20))
def test_the_root_is_found_from_below(seed):
    rng = np.random.default_rng(seed)
    n = 50
    slope, at_zero = rng.uniform(0.1, 5.0, (4, n)), rng.uniform(-0.5, 1.1, (4, n))
    quadratic = rng.uniform(0.0, 3.0, n)

    def share(speed):
        return np.maximum((slope * speed + at_zero).max(axis=0), quadratic * speed**2)

    low, high = np.full(n, 1e-3), np.full(n, rng.uniform(0.2, 3.0))
    found, least = root_below(share, low, high)
    exceeded = share(low) >= 1.0
    assert (found[exceeded] == 1e-3).all() and (least[exceeded] >= 1.0).all()
    assert (share(found)[~exceeded] <= 1.0 + 1e-12).all()
    closer = np.minimum(found * (1.0 + 2.0 * CLOSE), high)
    assert ((share(closer) >= 1.0) | (closer == high))[~exceeded].all()


def test_windows_are_those_of_the_ways_that_reach_in():
    rng = np.random.default_rng(3)
    way = np.cumsum(rng.uniform(0.0, 1.0, 60))
    values = rng.normal(size=60)
    found = over_window(way, values, 1.5, np.minimum)
    begin = np.concatenate([way[:1], way[:-1]])
    for i in range(60):
        near = (way >= begin[i] - 1.5) & (begin <= way[i] + 1.5)
        near[i] = True
        assert found[i] == values[near].min()


def test_steps_are_below_the_speed_and_few():
    rng = np.random.default_rng(4)
    speed = np.exp(rng.normal(size=400).cumsum() * 0.1)
    found = stepped(places(400), speed, Steps(margin=1e-3, ratio=1.05, shortest=2e-3))
    least = over_window(places(400).way, speed, 1e-3, np.minimum)
    assert (found <= least + 1e-12).all()
    assert (np.diff(found) != 0.0).sum() < 80
    same = stepped(places(400), np.full(400, 0.02), Steps())
    assert (same == 0.02).all()


@pytest.mark.parametrize("name, share", [("chip", "chip"), ("force", "resultant"), ("torque", "torque")])
def test_a_load_is_within_its_limit_and_close_to_it(name, share):
    engagement = shoulder(np.linspace(1e-3, 9e-3, 40), 5e-3)
    forces = EngagedForces(engagement, TOOL, Coefficients(800e6, 250e6, 100e6, 15e3, 20e3, 3e3))
    usual = float(np.median(getattr(forces.loads(np.full(40, 0.03)), share)))
    found = speeds_within(forces, places(40), CutLimits(**{name: usual}), 0.2)
    at = getattr(forces.loads(found.speed), share)
    assert (at <= usual * (1.0 + 1e-9)).all()
    held = found.holds == 0
    assert held.any() and (at[held] >= usual * (1.0 - 1e-3)).all()
    assert (found.speed[~held] == 0.2).all()


def test_an_absurd_feed_in_the_program_hides_no_limit():
    forces = EngagedForces(shoulder(5e-3, 5e-3), TOOL, Coefficients(1e9, 1e9))
    usual, absurd = (speeds_within(forces, places(40), CutLimits(chip=0.05e-3), most) for most in (0.2, 75.0))
    assert (absurd.exceeded == 0.0).all() and (absurd.holds == 0).all()
    np.testing.assert_allclose(absurd.speed, usual.speed, rtol=2e-4)


def test_a_limit_that_the_edges_alone_exceed_is_told():
    forces = EngagedForces(shoulder(5e-3, 5e-3), TOOL, Coefficients(800e6, 250e6, 0.0, 15e3, 20e3))
    found = speeds_within(forces, places(40), CutLimits(force=1.0), 0.2)
    assert (found.exceeded > 1.0).all()


def test_limits_that_make_no_sense():
    with pytest.raises(UsageError, match="limit of the cut: chip"):
        CutLimits(chip=-1.0)
    with pytest.raises(UsageError, match="stick_out"):
        bare = ToolFigures("flat", 10e-3, teeth=2, spindle_speed=100.0)
        forces = EngagedForces(shoulder(5e-3, 5e-3), bare, Coefficients(1e9, 1e9))
        speeds_within(forces, places(40), CutLimits(stress=1e9), 0.1)


def check_learned_torque(seed):
    """Torque is F = Kc A + Ke L times the radius on a cylinder: its peak at the learned speeds, for random Kc, Ke."""
    rng = np.random.default_rng(seed)
    n = 60
    cuts = [shoulder(rng.uniform(least, 10e-3, n), rng.uniform(1e-3, 6e-3), n) for least in (1e-3, 0.2e-3)]
    teacher, learner = (EngagedForces(each, TOOL, Coefficients(1e9, 1e9)) for each in cuts)
    speed = np.full(n, 0.03)
    best = best_of(held_loads(teacher, speed, places(n).way, np.ones(n, dtype=bool)))
    assert len(best) > 0
    allowed, which = learned_speeds(learner.loads(speed), best, speed)
    for _ in range(4):
        material = Coefficients(rng.uniform(0.0, 2e9), 0.0, 0.0, rng.uniform(0.0, 5e4), 0.0)
        most = EngagedForces(teacher.engagement, TOOL, material).loads(speed).torque.max()
        taken = EngagedForces(learner.engagement, TOOL, material).loads(np.maximum(allowed, 1e-9)).torque
        assert (taken[allowed > 0.0] <= most * (1.0 + 1e-6)).all()
        chip = learner.loads(np.maximum(allowed, 1e-9)).chip
        assert (chip[allowed > 0.0] <= teacher.loads(speed).chip.max() * (1.0 + 1e-9)).all()
    assert ((which >= 0) == (allowed > 0.0)).all()


@pytest.mark.parametrize("seed", range(10))
def test_no_force_is_above_the_teachers_whatever_the_material(seed):
    check_learned_torque(seed)


@pytest.mark.thorough
@pytest.mark.parametrize("seed", range(10, 500))
def test_no_force_is_above_the_teachers_in_many_engagements(seed):
    check_learned_torque(seed)


def allowed_by(teacher, learner, speed, **without):
    """Most speed of a learner by one place of a teacher, with some of its loads out of the condition."""
    n = len(speed)
    best = best_of(held_loads(teacher, speed, places(n).way, np.ones(n, dtype=bool)))
    endless = {name: np.full(len(best), np.inf) for name in without}
    return learned_speeds(learner.loads(speed), replace(best, **endless), speed)[0]


def largest_torque(forces, speed, material):
    return EngagedForces(forces.engagement, TOOL, material).loads(speed).torque.max()


def test_each_of_the_three_conditions_is_needed():
    """Left out, a material is found that is loaded more than at the teacher; or an edge whose chip is thicker."""
    speed, cutting, edges = np.full(20, 0.03), Coefficients(1e9, 0.0), Coefficients(0.0, 0.0, 0.0, 1e4)
    shallow, slot, thin, half = (
        EngagedForces(shoulder(width, depth, 20), TOOL, Coefficients(1e9, 1e9))
        for width, depth in ((9.9e-3, 1e-3), (9.9e-3, 2e-3), (0.3e-3, 8e-3), (5e-3, 2.5e-3))
    )
    for teacher, learner, load, material in ((shallow, thin, "edge", edges), (thin, half, "area", cutting)):
        most = largest_torque(teacher, speed, material)
        held, free = (allowed_by(teacher, learner, speed, **without) for without in ({}, {load: None}))
        assert largest_torque(learner, np.maximum(held, 1e-9), material) <= most * (1.0 + 1e-6) or not held.any()
        assert largest_torque(learner, free, material) > 1.2 * most
    free = allowed_by(slot, thin, speed, chip=None)
    assert thin.loads(free).chip.max() > 1.2 * slot.loads(speed).chip.max()


@pytest.fixture(scope="module")
def cut():
    machine = tp.Machine.load("xyzac-trunnion")
    setup = setup_of_text(SHEET)
    toolpath = tp.read_text(TWO_SLOTS, machine, setup=setup)
    plan = tp.plan_program(toolpath, machine, effort="low")
    simulation = tp.simulate_cut(plan.trajectory, toolpath, setup, resolution=1e-3)
    return machine, setup, toolpath, simulation


def test_in_air_it_is_faster_and_the_program_s_feed_holds_wherever_it_may_cut(cut):
    machine, setup, toolpath, simulation = cut
    tools = [setup.figures_of(each.tool) for each in toolpath.operations]
    plan = plan_feeds(simulation, toolpath, tools, FeedRules(air_feed=0.1))
    new = with_feeds(toolpath, machine, list(plan.places), list(plan.feeds))
    own = new.most_speed
    begin, end = new.way_start[:, 0], new.tip[:, 0]
    feeding = ~new.rapid & (np.abs(end - begin) > 0.0)
    # the tool is 10 mm wide, the stock may begin half a millimetre early, and the margin is 1 mm
    touching = feeding & (np.maximum(begin, end) > -5e-3 - 0.5e-3 - 0.9e-3) & (np.minimum(begin, end) < 60.5e-3)
    assert (own[touching] == 0.01).all()
    assert (own[feeding] > 0.09).sum() == 4
    assert np.isclose(new.tip[feeding][-1, 0], 0.09)
    before, after = plan.operations[0].before, plan.operations[0].after
    assert after < 0.75 * before


def test_on_a_guess_no_feed_is_raised(cut):
    machine, _, toolpath, _ = cut
    sheet = setup_of_text(SHEET[SHEET.index("[tools.1]") :])
    plan = tp.plan_program(toolpath, machine, effort="low")
    simulation = tp.simulate_cut(plan.trajectory, toolpath, sheet, resolution=1e-3)
    tools = [sheet.figures_of(each.tool) for each in toolpath.operations]
    feeds = plan_feeds(simulation, toolpath, tools, FeedRules(air_feed=0.1))
    assert all((each[1:] == 0.01).all() for each in feeds.feeds)
    assert any("[stock]" in note for note in feeds.notes)


def fed(program, rules, controller=None):
    """A program, cut as it is planned, and its new feeds: ends (k, 3) and feeds (k,) of its ways at feed [m], [m/s]."""
    machine, setup = tp.Machine.load("xyzac-trunnion"), setup_of_text(SHEET)
    toolpath = tp.read_text(program, machine, setup=setup, controller=controller)
    plan = tp.plan_program(toolpath, machine, effort="low")
    simulation = tp.simulate_cut(plan.trajectory, toolpath, setup, resolution=1e-3)
    feeds = plan_feeds(simulation, toolpath, [setup.figures_of(each.tool) for each in toolpath.operations], rules)
    new = with_feeds(toolpath, machine, list(feeds.places), list(feeds.feeds))
    at_feed = ~new.rapid & (new.way_length > 0.0)
    return new.tip[at_feed], new.most_speed[at_feed]


SHALLOW = (
    "G21 G90 G54 G17\nT1 M6\nG43 H1\nS6000 M3\n(OPERATION: deep)\nG0 X-30 Y0 Z20\nG0 Z-6\nG1 X90 F600\nG0 Z20\n"
    "G0 X-30 Y14\nG0 Z-2\nG1 X90\nG0 Z20\nM30\n"
)
FINISHING = FeedRules("learned", air_feed=0.05, finishing=True)


def learned(text, rules):
    machine, setup = tp.Machine.load("xyzac-trunnion"), setup_of_text(SHEET)
    toolpath = tp.read_text(text, machine, setup=setup)
    simulation = tp.simulate_cut(
        tp.plan_program(toolpath, machine, effort="low").trajectory, toolpath, setup, resolution=1e-3
    )
    return plan_feeds(simulation, toolpath, [setup.figures_of(each.tool) for each in toolpath.operations], rules)


@pytest.mark.sweep
def test_teachers_are_listed_left_out_and_taken_from_another_program(tmp_path):
    plan = learned(SHALLOW, FINISHING)
    assert {each.line for each in plan.teachers} == {8} and plan.teachers[0].seconds > 1.0
    save_teachers(plan.teachers, "deep.ngc", tmp_path)
    others = load_teachers(tmp_path)
    assert {each.program for each in others} == {"deep.ngc"} and others[0].figures == plan.teachers[0].figures
    without = learned(SHALLOW, replace(FINISHING, not_teaching=frozenset(["8"])))
    assert {each.line for each in without.teachers} == {12}
    # at half of the feed the other program allows what that program has
    slow = SHALLOW.replace("F600", "F300")
    faster, alone = (learned(slow, replace(FINISHING, teachers=each)) for each in (others, ()))
    time = [sum(each.after for each in plan.operations) for plan in (faster, alone)]
    assert time[0] < 0.8 * time[1]
    assert {each.program for each in faster.teachers} == {"", "deep.ngc"}
    # a tool with other figures learns nothing from it
    other = tuple(replace(each, figures=each.figures | {"teeth": "4"}) for each in others)
    assert sum(each.after for each in learned(slow, replace(FINISHING, teachers=other)).operations) == time[1]


@pytest.mark.parametrize("text", ["{}", "[1]", '{"teachers": [{"line": 3}]}', "no", '{"teachers": [7]}'])
def test_a_file_of_teachers_that_is_damaged_is_refused(tmp_path, text):
    with pytest.raises(UsageError, match="--save-teachers"):
        load_teachers(tmp_path)
    (tmp_path / "teachers.json").write_text(text)
    with pytest.raises(UsageError, match="is no file of teachers"):
        load_teachers(tmp_path)


def test_what_stays_is_told_with_its_reason_and_a_guess_tells_what_might_be(cut):
    _, setup, toolpath, simulation = cut
    tools = [setup.figures_of(each.tool) for each in toolpath.operations]
    plan = plan_feeds(simulation, toolpath, tools, FeedRules(air_feed=0.1))
    stays = sum(each.seconds for each in plan.kept)
    assert any("something may be cut" in each.reason for each in plan.kept)
    # 240 mm at 10 mm/s, of which 2 * 60 mm and the margins are in material
    assert 12.0 < stays < 18.0
    named = replace(toolpath, operations=tuple(replace(each, name="pocket") for each in toolpath.operations))
    left = plan_feeds(simulation, named, tools, FeedRules(left_alone=frozenset(["pocket"])))
    assert [each.reason for each in left.kept] == ["the operation is left as it is (--leave)"]
    guess = replace(simulation, left=replace(simulation.left, guessed=True))
    note = plan_feeds(guess, toolpath, tools, FeedRules(air_feed=0.1)).notes[-1]
    assert "[[-35.0, -5.0, -2.0], [95.0, 19.0, " in note and "its 24.00 s at feed would be 15." in note


def test_an_answer_that_hangs_on_a_moment_says_so():
    """A short way straight into the side has thicker chips than the shoulders, which learn from it."""
    shoulders = "".join(f"G0 X-6 Y{y}\nG0 Z-6\nG1 X65\nG0 Z20\n" for y in (-23.5, -22.0, -20.5, -19.0, -17.5))
    into = "G0 X66.5 Y10\nG0 Z-9\nG1 X62.5\nG0 Z20\n"
    plan = learned("G21 G90 G54 G17 F600\nT1 M6\nG43 H1\nS6000 M3\nG0 Z20\n" + shoulders + into + "M30\n", FINISHING)
    assert any("hangs on few teachers" in each for each in plan.notes)
    assert not any("hangs on few teachers" in each for each in learned(SHALLOW, FINISHING).notes)


BEGIN = "G21 G90 G54 G17\nT1 M6\nG43 H1\nS6000 M3\nG0 X-30 Y0 Z20\nG0 Z-2\n"


def test_a_limit_holds_at_the_spindle_speed_of_each_way():
    """In a full slot the chip is the feed per tooth: of 0.02 mm and three teeth, 6 mm/s at 100 turns per second."""
    rules = FeedRules("limits", limits={"": CutLimits(chip=0.02e-3)}, air_feed=0.1, finishing=True)
    tip, feed = fed(BEGIN + "G1 X30 F300\nS12000\nG1 X90\nG0 Z20\nM30\n", rules)
    slot = (tip[:, 0] > 0.0) & (tip[:, 0] < 0.06)
    slow = slot & (tip[:, 0] < 0.0301)
    assert 5.5e-3 < feed[slow].max() <= 6e-3 * 1.001
    assert 11e-3 < feed[slot].max() <= 12e-3 * 1.001


def test_a_pass_over_a_finished_surface_keeps_its_feed_though_nothing_is_left_to_cut():
    again = BEGIN + "G1 X90 F600\nG0 Z20\nG0 X-30\nG0 Z-2\nG1 X89\nG0 Z20\nM30\n"
    for finishing, most in ((False, 0.01), (True, 0.1)):
        tip, feed = fed(again, FeedRules(air_feed=0.1, finishing=finishing))
        second = np.cumsum(np.diff(tip[:, 0], prepend=-0.03) < 0.0) > 0
        middle = np.flatnonzero(second & (tip[:, 0] >= 0.03))[0]
        assert np.isclose(feed[middle], most)


def test_a_turn_in_place_slows_nothing_beside_it():
    rules = FeedRules("limits", limits={"": CutLimits(chip=1e-3)}, air_feed=0.01)
    feed = fed(BEGIN.replace("G43 ", "G43.4 ") + "G1 X10 F600\nG1 A8\nG1 X30\nG0 Z20\nM30\n", rules, "fanuc")[1]
    assert np.allclose(feed, 0.01)


def test_lowering_leaves_the_feed_of_what_is_beside_a_slower_block():
    rules = FeedRules("learned", lower=True, air_feed=0.02)
    tip, feed = fed(BEGIN + "G1 X-20 F1200\nG1 X90 F600\nG0 Z20\nM30\n", rules)
    assert np.allclose(feed[tip[:, 0] < -0.0199], 0.02)


def test_a_tool_without_limits_keeps_its_feeds_where_it_may_cut(cut):
    _, setup, toolpath, simulation = cut
    tools = [setup.figures_of(each.tool) for each in toolpath.operations]
    plan = plan_feeds(simulation, toolpath, tools, FeedRules("limits", air_feed=0.1))
    stretches = [each for each in simulation.stretches if not each.rapid]
    assert any(not each.air.all() for each in stretches)
    for stretch, feed in zip(stretches, plan.feeds):
        assert (feed[1:][~stretch.air[1:]] == 0.01).all()
    wide = FeedRules("limits", limits={"": CutLimits(chip=1e-3)}, air_feed=1e-3)
    slow = plan_feeds(simulation, toolpath, tools, wide)
    assert all((feed[1:] >= 0.01).all() for feed in slow.feeds) and not slow.overloads


@pytest.mark.parametrize("rules", [
    FeedRules("limits", limits={"": CutLimits(force=1.0)}, materials={"": Coefficients(8e8, 2e8, 0.0, 15e3, 20e3)}),
    FeedRules("learned", lower=True),
])  # fmt: skip
def test_what_no_feed_can_help_keeps_its_feed_and_is_told(cut, rules):
    """Edges alone are above the limit; or the edge is longer than any teacher's, here since teachers are short."""
    _, setup, toolpath, simulation = cut
    tools = [setup.figures_of(each.tool) for each in toolpath.operations]
    plan = plan_feeds(simulation, toolpath, tools, rules)
    loaded = np.concatenate([each.cutting[1:] for each in simulation.stretches if not each.rapid])
    feed = np.concatenate([each[1:] for each in plan.feeds])
    assert (feed > 0.001).all()
    assert rules.way == "learned" or (feed[loaded] == 0.01).all()
    assert [each.always for each in plan.overloads] == [True] * (rules.way == "limits")


def test_rules_that_speak_of_what_is_not_there_are_refused(cut):
    _, setup, toolpath, simulation = cut
    tools = [setup.figures_of(each.tool) for each in toolpath.operations]
    wrong = (
        (FeedRules("limits", limits={"7": CutLimits(chip=1e-4)}), "no tool '7'"),
        (FeedRules(left_alone=frozenset(["finish"])), "no operation 'finish'"),
        (FeedRules("limits", limits={"": CutLimits(force=100.0)}), "--material"),
    )
    for rules, message in wrong:
        with pytest.raises(UsageError, match=message):
            plan_feeds(simulation, toolpath, tools, rules)
    for figure in (math.nan, 0.0, -1.0):
        with pytest.raises(UsageError, match="air_feed"):
            FeedRules(air_feed=figure)
    with pytest.raises(UsageError, match="margin"):
        Steps(margin=math.nan)
    rules = FeedRules(limits={"": CutLimits(chip=1e-4, removal_rate=1e-6), "3": CutLimits(chip=2e-4)})
    assert rules.limits_of("3") == CutLimits(chip=2e-4, removal_rate=1e-6)


@pytest.mark.parametrize("missing, message", [("teeth", "number of teeth"), ("spindle_speed", "spindle speed")])
def test_figures_that_feeds_need_are_asked_for_before_the_plan(missing, message):
    sheet = "\n".join(line for line in SHEET.splitlines() if not line.startswith(missing))
    machine, setup = tp.Machine.load("xyzac-trunnion"), setup_of_text(sheet)
    toolpath = tp.read_text(TWO_SLOTS.replace("S6000 M3", ""), machine, controller="linuxcnc", setup=setup)
    tools = [setup.figures_of(each.tool) for each in toolpath.operations]
    with pytest.raises(UsageError, match=message):
        check_tools(toolpath, tools, FeedRules("learned"))
    check_tools(toolpath, tools, FeedRules("air"))


def test_a_feed_that_stays_is_told_with_its_first_lines():
    kept = KeptFeed("at a limit", 2.5, ((3, 3), (5, 9), (11, 12)))
    assert kept.told(2) == "as it was for 2.50 s: at a limit; lines 3, 5 to 9, ..."
