"""Paths and limits that mean nothing are refused, and positions in another unit asked about, each with its cure."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import toolpace as tp

INF = np.inf
MACHINE = tp.Machine.load("xyzac-trunnion")
SIX = tp.AxisPath.from_waypoints(np.random.default_rng(1).uniform(-1.0, 1.0, (5, 6)))
IN_DEGREES = np.array([[0.0, 0.0, 0.0, 0.0, 0.0], [0.1, 0.1, 0.0, 30.0, 45.0], [0.2, 0.0, 0.0, 60.0, 90.0]])


def test_one_limit_beside_six_joints_has_a_cure_that_works() -> None:
    with pytest.raises(tp.ToolpaceError, match=r"limits for 1 joint, path of 6 joints; .* give ") as caught:
        tp.plan(SIX, tp.Limits(2.0, 8.0, 80.0))
    cure = str(caught.value).partition("of them give ")[2]
    assert cure == "Limits(2, 8, 80, path.joints)"
    limits = eval(cure, {"Limits": tp.Limits, "path": SIX})
    assert tp.plan(SIX, limits, mesh=60, bound=False).duration > 1.0
    with pytest.raises(tp.ToolpaceError, match="limits for 3 joints, path of 6 joints; give 6 figures of each kind"):
        tp.plan(SIX, tp.Limits([2.0] * 3, 8.0, 80.0))


@pytest.mark.parametrize("planner", ["optimal", "genetic", "second-order"])
def test_a_motion_that_nothing_holds_is_refused(planner: str) -> None:
    with pytest.raises(tp.ToolpaceError, match=r"run 0 moves only joints without any limit \(q1, .*; give these"):
        tp.plan(SIX, tp.Limits([INF] * 6, INF, INF), planner=planner)
    straight = tp.AxisPath.from_waypoints([[0.0, 0.0], [1.0, 0.0]])
    held = tp.Limits([INF, 1.0], [INF, 1.0], [INF, 1.0])
    with pytest.raises(tp.ToolpaceError, match=r"joints without any limit \(q1\)"):
        tp.plan(straight, held, planner=planner)


def test_one_limit_or_a_cap_holds_a_motion() -> None:
    line = [[0.0, 0.0], [1.0, 1.0]]
    one = tp.Limits([INF, 0.5], INF, INF)
    by_one = tp.plan(tp.AxisPath.from_waypoints(line), one, planner="second-order")
    assert by_one.duration == pytest.approx(2.0, rel=1e-3)
    capped, free = tp.AxisPath.from_waypoints(line, speed_cap=0.5), tp.Limits([INF, INF], INF, INF)
    length = capped.runs[0].s1 - capped.runs[0].s0
    assert tp.plan(capped, free, planner="second-order").duration == pytest.approx(2.0 * length, rel=1e-3)


def test_waypoints_in_degrees_are_asked_about() -> None:
    with pytest.warns(tp.UnitWarning, match=r"q\[1, 3\] is 30, and all are round; .* are these mm or degrees\? Then"):
        path = tp.AxisPath.from_waypoints(IN_DEGREES)
    with pytest.warns(tp.UnitWarning, match=r"joint A of xyzac-trunnion goes to 60 rad \(3438 deg\), beyond its"):
        tp.plan(path, MACHINE, mesh=60, bound=False)


def test_ordinary_waypoints_are_not() -> None:
    rng = np.random.default_rng(3)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        in_radians = IN_DEGREES * np.where(MACHINE.is_rotary, np.pi / 180.0, 1.0)
        tp.plan(tp.AxisPath.from_waypoints(in_radians), MACHINE, mesh=60, bound=False)
        tp.AxisPath.from_waypoints(np.arange(10.0)[:, None])
        tp.AxisPath.from_waypoints(rng.uniform(-100.0, 100.0, (20, 3)))
        turning = np.cumsum(rng.uniform(0.1, 2.0, (200, 1)), axis=0)
        tp.AxisPath.from_waypoints(turning)
        endless = in_radians + 50.0 * np.pi * (np.arange(5) == MACHINE.joints.index("C"))
        tp.plan(tp.AxisPath.from_waypoints(endless), MACHINE, mesh=60, bound=False)


def test_a_path_that_stands_is_refused() -> None:
    up = np.array([0.0, 0.0, 1.0])
    joints = tp.AxisPath.from_callable(lambda s, order: np.full((len(s), 2), 0.5 * (order == 0)))
    tool = tp.Path.from_callable(lambda s, order: (0.05 * up * (order == 0), up * (order == 0)))
    for path, limits in ((joints, tp.Limits([1.0, 1.0], 1.0, 1.0)), (tool, MACHINE)):
        for planner in ("optimal", "genetic", "second-order"):
            with pytest.raises(tp.ToolpaceError, match="no joint moves along run 0, from s = 0 to s = 1; leave it out"):
                tp.plan(path, limits, planner=planner)


@pytest.mark.parametrize("value", [-1e-6, 0.0, float("nan"), INF, "10um", None])
def test_a_tolerance_that_is_none_says_what_is_wanted(value: object) -> None:
    toolpath = tp.read_text("G90 G21 G94 G1 X0 Y0 Z50 A0 C0 F2000\nX10 Y2 A5 C20\nM30\n", MACHINE)
    with pytest.raises(tp.ToolpaceError, match=r"tip_tolerance is .*; give a number above zero, .* 10e-6 is 10 um"):
        tp.Path.fit(toolpath, value, machine=MACHINE)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("word", "meant"), [("climb", "down"), ("Conventional", "up"), ("slotting", "slot"), ("dwon", "down")]
)
def test_other_words_for_milling_are_understood_as_questions(word: str, meant: str) -> None:
    with pytest.raises(tp.ToolpaceError, match=f"milling '{word}' is not known; did you mean '{meant}'"):
        tp.Cut(
            tp.Cutter(0.01, 2), tp.Coefficients(1e9, 1e9), tp.Engagement(word, 0.001, 0.001), 100.0,  # type: ignore[arg-type]
        )  # fmt: skip
