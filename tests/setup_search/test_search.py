"""The search: never slower than what is given, never beyond travel or in a forbidden zone, as good as a grid."""

from __future__ import annotations

import math

import numpy as np
import pytest

import toolpace as tp
from testbed.curved_pass import curved_pass
from toolpace.common.errors import ReachError, UsageError
from toolpace.setup_search.choices import Choice, Choices
from toolpace.setup_search.trial import Task, as_tips_and_axes, centre_of, tried_there

TILTS = Choice(tuple(np.radians([0.0, 30.0, 45.0])))
DIRECTIONS = Choices(tilt=TILTS, x=Choice((0.0,)), y=Choice((0.0,)), z=Choice((0.0,)), side=Choice((0.0,)))


@pytest.fixture(scope="module")
def machine() -> tp.Machine:
    return tp.Machine.load("xyzac-trunnion")


@pytest.fixture(scope="module")
def found(machine) -> tp.FoundSetUp:
    return tp.search_setup(curved_pass(), machine, trials=60, shown=4, mapped=3)


def moved_origin(machine: tp.Machine, way: tuple[float, float, float]) -> tuple[float, ...]:
    return tuple(a + b for a, b in zip(machine.file.chain.workpiece_origin, way))


def held_by_positions(each: tp.PlannedSetUp, toolpath: tp.ToolPath) -> None:
    """The program planned anew on the machine that is returned: all set-points within travel."""
    path = tp.Path.fit(as_tips_and_axes(toolpath), machine=each.machine)
    trajectory = tp.plan(path, each.machine, bound=False)
    q = trajectory.sample(5e-3).q
    travel = each.machine.travel
    assert (q >= travel[:, 0] - 1e-9).all() and (q <= travel[:, 1] + 1e-9).all()
    assert trajectory.duration == pytest.approx(each.duration, rel=1e-3)


def test_the_best_are_faster_and_within_travel(found, machine):
    assert found.given is not None and found.given.machine == machine
    assert found.gain > 0.1 and found.best[0].duration < found.given.duration
    times = [each.duration for each in found.best]
    assert times[1:] == sorted(times[1:]) and times[0] <= 1.001 * min(times)
    for each in found.best[:2]:
        held_by_positions(each, curved_pass())
        assert (each.used[:, 0] >= each.machine.travel[:, 0]).all()
        assert (each.used[:, 1] <= each.machine.travel[:, 1]).all()
        assert 0.0 < each.lower_bound <= each.duration and each.gap < 0.01


def test_of_what_is_as_fast_the_simplest_comes_first(found):
    """Nothing is turned or moved for a thousandth of the time."""
    least = min(each.duration for each in found.best)
    as_fast = [each.clamping.effort for each in found.best if each.duration <= 1.001 * least]
    assert found.best[0].clamping.effort == min(as_fast)


def test_what_limits_before_and_after_are_the_shares_of_both(found):
    before, after = (sum(each[k] for each in found.changes().values()) for k in (0, 1))
    assert before == pytest.approx(1.0) and after == pytest.approx(1.0)


def test_the_map_holds_the_best_at_its_place(found):
    places = found.places
    assert places is not None and places.seconds.shape == (3, 3)
    assert places.best == found.best[0].clamping.shift[:2]
    i, j = (int(np.abs(along - at).argmin()) for along, at in zip((places.y, places.x), reversed(places.best)))
    assert places.seconds[i, j] == pytest.approx(found.best[0].duration, rel=0.05)
    assert places.seconds[i, j] <= np.nanmin(places.seconds) * 1.01


def test_the_machine_that_is_found_is_one_to_load_and_read_for(found, tmp_path):
    (tmp_path / "best.toml").write_text(found.machine.to_toml())
    (tmp_path / "setup.toml").write_text("")
    loaded = tp.Machine.load(tmp_path / "best.toml")
    assert loaded == found.machine
    assert tp.read_text("G21 G90 G94\nG0 X0 Y0 Z0\nG1 X1 F100\nM2\n", loaded) is not None


def test_a_program_that_is_beyond_travel_as_given_is_brought_within(machine):
    """Half a metre too far along X."""
    away = machine.mounted(origin=moved_origin(machine, (0.5, 0.0, 0.0)))
    choices = Choices(tilt=Choice((0.0,)), turn=Choice((0.0,)), x=Choice.between(-0.5, 0.0), side=Choice((0.0,)))
    found = tp.search_setup(curved_pass(), away, choices, trials=20, shown=2, mapped=0)
    assert found.given is None and "above its limit" in found.why and math.isnan(found.gain)
    for each in found.best:
        held_by_positions(each, curved_pass())
        assert each.clamping.shift[0] < -0.05


def test_where_nothing_fits_the_error_says_how_far_the_nearest_is(machine):
    away = machine.mounted(origin=moved_origin(machine, (0.0, 0.6, 0.0)))
    choices = Choices(tilt=Choice((0.0,)), turn=Choice((0.0,)), side=Choice((0.0,)))
    with pytest.raises(
        ReachError, match=r"none of \d+ clampings that were tried fits; the nearest .* mm beyond travel"
    ):
        tp.search_setup(curved_pass(), away, choices, trials=20, mapped=0)


def test_a_tilt_that_no_joint_reaches_is_an_error(machine):
    flat = machine.mounted(x=(1.0, 0.0, 0.0), z=(0.0, 0.0, -1.0))
    choices = Choices(tilt=Choice((0.0,)), side=Choice((0.0,)))
    with pytest.raises(ReachError, match="the rotary joints do not reach the tool axes with any of them"):
        tp.search_setup(curved_pass(), flat, choices, trials=20, mapped=0)


@pytest.mark.sweep
def test_a_forbidden_zone_is_kept_out_of(machine):
    given = tp.search_setup(curved_pass(), machine, DIRECTIONS, trials=20, shown=1, mapped=0).given
    assert given is not None
    z = machine.joints.index("Z")
    least = given.used[z, 0] + 0.02
    zone = tp.Zone("changer", {"Z": (-1.0, least)})
    choices = Choices(tilt=Choice((0.0,)), turn=Choice((0.0,)), side=Choice((0.0,)), forbidden=(zone,))
    found = tp.search_setup(curved_pass(), machine, choices, trials=24, shown=2, mapped=3)
    assert found.given is None and "forbidden zone changer" in found.why
    for each in found.best:
        assert each.used[z, 0] > least
    assert found.places is not None and np.isnan(found.places.seconds).any() and found.places.fits


@pytest.mark.sweep
def test_a_program_in_joint_words_keeps_its_joints_as_given_only(machine):
    """It names A above zero all along, though the other solution turns as little: that is what `given` is."""
    text = "G21 G90 G94 G43.4 H1\nG0 X0 Y0 Z20 A-10 C0\nG1 X30 A-40 C60 F20000\nG1 Y20 A-15 C90\nM30\n"
    toolpath = tp.read_text(text, machine)
    found = tp.search_setup(toolpath, machine, DIRECTIONS, trials=20, shown=2, mapped=0)
    assert found.given is not None and found.best[0].duration <= found.given.duration


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ({"trials": 3}, "3 trials find nothing; give at least 20"),
        ({"mapped": 1}, "a map of 1 places"),
        ({"shown": 0}, "0 set-ups"),
    ],
)
def test_arguments_that_make_no_sense_are_told(machine, arguments, said):
    with pytest.raises(UsageError, match=said):
        tp.search_setup(curved_pass(), machine, **arguments)
    with pytest.raises(UsageError, match="str in place of a tool path"):
        tp.search_setup("part.ngc", machine)


@pytest.mark.thorough
def test_three_seeds_find_the_same_within_one_percent_and_no_grid_finds_better(machine):
    """Turn and tilt: 36 turns at each tilt beside what three searches find."""
    toolpath = curved_pass()
    times = [
        tp.search_setup(toolpath, machine, seed=seed, trials=100, shown=1, mapped=0).best[0].duration
        for seed in (1, 2, 3)
    ]
    assert max(times) <= 1.01 * min(times)
    choices = Choices()
    task = Task(toolpath, machine, centre_of(toolpath), choices.box(), 10e-6, 1e-3)
    grid = [
        (tried_there(task, tp.Clamping(turn, tilt)).cost, turn, tilt)
        for turn in np.radians(np.arange(-180.0, 180.0, 10.0))
        for tilt in choices.tilt.values
    ]
    _, turn, tilt = min(grid)
    best = tp.plan(tp.Path.fit(toolpath, machine=(on := tp.Clamping(turn, tilt).on(machine, task.centre))), on)
    # measured: 1.0042; cheap plans rank to 0.3 percent, and of what is as fast to 0.1 the simplest is taken
    assert max(times) <= 1.005 * best.duration


@pytest.mark.sweep
def test_processes_find_what_this_one_does(machine, found):
    pytest.importorskip("distributed")
    again = tp.search_setup(curved_pass(), machine, trials=60, shown=2, mapped=0, client=2)
    assert again.best[0].duration == pytest.approx(found.best[0].duration, rel=0.01)
    assert again.given is not None and again.given.duration == pytest.approx(found.given.duration, rel=1e-6)
