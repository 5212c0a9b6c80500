"""Where the tip was found: a position or a vector, each by its name; what is left out of the path on the way back."""

from __future__ import annotations

import warnings
from functools import cache

import numpy as np
import pytest

import toolpace as tp
from toolpace.common.errors import UsageError
from toolpace.deflection.detour import DetourRun

MACHINE = tp.Machine.load("paper-ab")
LIMITS = tp.Limits([1.0, 1.0], [4.0, 4.0], [40.0, 40.0])


@cache
def arc() -> tp.Trajectory:
    """The paper's quarter of a circle about the origin, of 0.1 m, at 30 mm/s."""
    return tp.plan(tp.Path.paper_arc(), MACHINE, bound=False)


def along(s: np.ndarray, order: int, start: float = 1.0) -> np.ndarray:
    """Two joints along a straight line of 0.2 from a start, (0.3, 0.4)."""
    way = np.array([[0.3 * start, 0.4 * start], [0.12, 0.16], [0.0, 0.0], [0.0, 0.0]])
    return way[order] + np.outer(s, way[1]) * (order == 0)


def test_a_vector_is_counted_from_the_tip_of_the_motion() -> None:
    vector = np.array([2e-4, -1e-4, 3e-4])
    for cause in ("displaced", "bending"):
        by_vector = tp.replan(arc(), 2.0, deflection=vector, cause=cause)
        by_place = tp.replan(arc(), 2.0, arc().tip(2.0)[0] + vector, cause=cause)
        assert by_vector.duration == by_place.duration
        np.testing.assert_array_equal(by_vector.at(0.1).q, by_place.at(0.1).q)


@pytest.mark.parametrize("cause", ["displaced", "bending"])
@pytest.mark.parametrize(
    ("given", "words"),
    [
        (lambda own: {"tip": [0.0, 0.0, 6e-6]}, "that is a vector: give it as deflection="),
        (lambda own: {"tip": 1e3 * own + [0.0, 0.0, 0.2]}, "that is in mm: give metres"),
        (lambda own: {"tip": own + np.array([0.0, 0.0, 5.1e-3])}, "tip is 5.1 mm from the motion at 2 s, more"),
        (lambda own: {"deflection": [0.0, 0.0, 0.2]}, "deflection is 200 mm from the motion .* in mm: give metres"),
        (lambda own: {"deflection": [0.0, 0.0, 6e-6], "most": 5e-6}, "of a deflection that is so large raise most="),
        (lambda own: {}, "neither tip nor deflection"),
        (lambda own: {"tip": own, "deflection": [0.0, 0.0, 0.0]}, "both tip and deflection"),
        (lambda own: {"tip": own, "most": 0.0}, "most is 0; give a number, above 0"),
    ],
)
def test_what_is_no_deflection_is_refused_by_name(given, words: str, cause: str) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(UsageError, match=words) as caught:
        tp.replan(arc(), 2.0, cause=cause, **given(arc().tip(2.0)[0]))
    assert "\n" not in str(caught.value)


def test_a_position_given_by_its_former_name_is_still_taken_and_said() -> None:
    place = arc().tip(2.0)[0] + [0.0, 0.0, 3e-4]
    with pytest.warns(DeprecationWarning, match="the position, as until now, is taken; give tip="):
        old = tp.replan(arc(), 2.0, deflection=place)
    assert old.duration == tp.replan(arc(), 2.0, tip=place).duration
    with pytest.warns(DeprecationWarning, match="tip= now"):
        assert tp.deflection.project(tp.Path.paper_arc(), deflection=place).distance < 3e-4 + 1e-9


def test_near_the_origin_the_name_decides_and_it_is_said() -> None:
    old = tp.plan(tp.AxisPath.from_callable(lambda s, order: along(s, order, 0.0)), LIMITS)
    time = 0.01 * old.duration
    with pytest.warns(DeprecationWarning, match="the vector is taken"):
        new = tp.replan(old, time, deflection=[1e-3, 1e-3])
    np.testing.assert_allclose(new.at(0.0).q, old.at(time).q + 1e-3, atol=1e-12)


def test_far_from_the_origin_a_vector_warns_of_nothing() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        tp.replan(arc(), 2.0, deflection=[0.0, 0.0, 3e-4], planner="direct")


def test_without_a_machine_the_bound_is_of_each_joint() -> None:
    old = tp.plan(tp.AxisPath.from_callable(along), LIMITS)
    time = 0.5 * old.duration
    new = tp.replan(old, time, deflection=[4e-3, -4e-3])
    np.testing.assert_allclose(new.at(0.0).q, old.at(time).q + np.array([4e-3, -4e-3]), atol=1e-12)
    with pytest.raises(UsageError, match=r"tip is 0.476 \(m or rad\) in one joint .* that is a vector"):
        tp.replan(old, time, [4e-3, 4e-3])


@pytest.mark.parametrize("axis", [(0.0, 0.0, 0.0), (0.0, 1e-4, 0.0), (0.0, 0.0, 57.0)])
def test_a_change_of_the_axis_is_no_axis(axis: tuple[float, ...]) -> None:
    with pytest.raises(UsageError, match="give the unit vector from tip to spindle"):
        tp.replan(arc(), 2.0, arc().tip(2.0)[0], axis=axis)


# -- what is left out --


def test_a_small_deflection_leaves_out_nothing() -> None:
    assert arc().skipped == ()
    assert tp.replan(arc(), 2.0, deflection=[0.0, 0.0, 0.0]).skipped == ()
    assert tp.replan(arc(), 2.0, deflection=[4e-6, -4e-6, 4e-6]).skipped == ()


@pytest.mark.parametrize("cause", ["displaced", "bending"])
@pytest.mark.parametrize("ahead", [0.1, pytest.param(1.0, marks=pytest.mark.sweep)])
def test_what_is_left_out_is_what_the_tip_does_not_pass(ahead: float, cause: str) -> None:
    """Each point of the circle by its angle: its distance from the samples of the tip, and the length by the angle."""
    vector = np.array([3e-4, -3e-4, 0.0])
    place = float(arc().parameter(2.0 + ahead))
    new = tp.replan(arc(), 2.0, deflection=vector, cause=cause, rejoin=place, planner="direct")
    run = new.axis_path.runs[0]
    assert isinstance(run, DetourRun)
    way = new.tip(np.linspace(0.0, run.detour.duration, 20001))[0] + vector * (cause == "bending")
    clock = np.linspace(2.0, 2.0 + ahead, 2001)
    points = arc().tip(clock)[0]
    off = np.array([np.linalg.norm(way - point, axis=1).min() for point in points])
    angle = np.arctan2(points[:, 2], np.hypot(points[:, 0], points[:, 1]))
    out = off > 1e-5
    wanted = 0.1 * float(np.abs(np.diff(angle))[out[1:]].sum())
    assert sum(each.length for each in new.skipped) == pytest.approx(wanted, rel=0.03)
    assert max(each.off for each in new.skipped) == pytest.approx(off.max(), rel=0.01)
    assert new.skipped[0].start == pytest.approx(float(arc().parameter(2.0)), abs=1e-6)
    assert new.skipped[-1].end <= place
    assert any("the path is left out from s = " in note for note in new.notes)
    assert "leaves out" in repr(new)


def test_on_the_way_back_what_is_still_to_come_is_told() -> None:
    first = tp.replan(arc(), 2.0, deflection=[0.0, 0.0, 3e-3], planner="direct")
    half = 0.25 * first.axis_path.runs[0].detour.duration
    second = tp.replan(first, half, first.tip(half)[0])
    assert 0.0 < second.skipped[0].length < first.skipped[0].length
    later = first.axis_path.runs[0].detour.duration + 0.1
    assert tp.replan(first, later, first.tip(later)[0]).skipped == ()
