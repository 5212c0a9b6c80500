"""Limits of the machine that a control exceeds: against closed forms of each rule."""

from __future__ import annotations

import pytest

from tests.support.timed_programs import A, J, machine, timed
from toolpace import ExceededLimit
from toolpace.controls.timing.exceeded import raised_limits
from toolpace.controls.timing.figures import figures_of


def exceeded(body: str, model: str, limit: float = J, **table: object) -> dict[tuple[str, str], ExceededLimit]:
    found = timed(body, figures_of(table, "", model), machine(jerk=limit)).exceeded
    return {(each.kind, each.axis): each for each in found}


def test_linuxcnc_keeps_no_jerk_in_ramps():
    """The acceleration begins within a cycle of 1 ms."""
    found = exceeded("G1 X50 F6000\nG4 P1\nG1 Z5\n", "linuxcnc")
    assert set(found) == {("jerk", "X"), ("jerk", "Z")}
    worst = found["jerk", "X"]
    assert worst.ratio == pytest.approx(A / 1e-3 / J) and worst.where == "ramp" and worst.count == 1
    assert str(worst) == "jerk of X up to 50 times its limit in the ramps of at most 1 block, worst at line 3"


def test_the_cycle_of_linuxcnc_is_that_of_its_figures():
    found = exceeded("G1 X50 F6000\n", "linuxcnc", linuxcnc={"cycle": 0.002})
    assert found["jerk", "X"].ratio == pytest.approx(A / 2e-3 / J)


def test_a_block_that_keeps_one_speed_below_its_feed_has_no_ramp():
    """Eight quarters of a circle of 10 mm, as fast as acceleration allows: the first and the last are ramps."""
    places = [(10, 10, 0, 10), (0, 20, -10, 0), (-10, 10, 0, -10), (0, 0, 10, 0)] * 2
    arcs = "".join(f"G3 X{x} Y{y} I{i} J{j} F60000\n" for x, y, i, j in places)
    found = exceeded(f"G64\n{arcs}", "sinumerik", sinumerik={"brisk": 1.0})
    assert found["jerk", "X"].count == found["jerk", "Y"].count == 2


@pytest.mark.parametrize("model", ["linuxcnc", "lookahead"])
@pytest.mark.parametrize("feed", ["G94", "G93"])
def test_blocks_that_the_program_keeps_steady_have_no_ramps(model: str, feed: str):
    """Ten blocks of 100.037 ms on one line: the first and the last change their speed."""
    word = "F6000" if feed == "G94" else "F599.778"
    body = f"{feed}\n" + "".join(f"G1 X{k * 10.0037:.4f} {word}\n" for k in range(1, 11))
    assert exceeded(body, model, acceleration=1.3)["acceleration", "X"].count == 2


def test_brisk_of_a_sinumerik_keeps_none_and_soft_does():
    body, at = "G1 X50 F6000\n", {"brisk": 1.0, "cycle": 0.002}
    assert exceeded(body, "sinumerik") == {}
    assert exceeded(body, "sinumerik", sinumerik=at)["jerk", "X"].ratio == pytest.approx(A / 0.002 / J)


def test_rapids_of_a_heidenhain_take_more_jerk():
    """Five times that of the axis, and 40 m/s^3 along the path at most."""
    assert exceeded("G0 X50\n", "heidenhain", limit=5.0)["jerk", "X"].ratio == pytest.approx(5.0)
    assert exceeded("G0 X50\n", "heidenhain", limit=10.0)["jerk", "X"].ratio == pytest.approx(4.0)
    assert exceeded("G1 X50 F3000\n", "heidenhain", limit=10.0) == {}


def test_figures_above_the_machines_limits_are_told():
    found = exceeded("G1 X50 Y50 F6000\n", "lookahead", acceleration=1.3, jerk={"X": 2e3 * J, "Y": 2e3 * J})
    assert found["acceleration", "X"].ratio == pytest.approx(1.3)
    assert found["jerk", "Y"].ratio == pytest.approx(2.0)
    assert exceeded("G1 X50 Y50 F6000\n", "lookahead", acceleration=0.7) == {}


@pytest.mark.parametrize("model", ["sinumerik", "heidenhain", "lookahead"])
def test_short_blocks_on_one_line_exceed_nothing(model: str):
    """What goes along a line together is not judged by the ways of its blocks."""
    blocks = "".join(f"G1 X{k * 0.1:.3f} Y{0.004 * (k % 2):.3f} F8000\n" for k in range(1, 80))
    assert exceeded(blocks, model) == {}


def test_limits_of_joints_are_exceeded_where_a_control_keeps_those_of_words():
    """In tool-centre-point mode C turns by 170 degrees, 250 mm from its centre, while the tip goes 2 mm."""
    body = "G43.4\nG1 X250 A-5 C0 F6000\nG1 X250 Y2 C170\n"
    by_words, by_joints = (exceeded(body, "lookahead", limits=limits) for limits in ("words", "joints"))
    assert by_joints == {}
    assert {each.where for each in by_words.values()} >= {"block"} and {axis for _, axis in by_words} <= {"X", "Y"}


def test_raised_limits_are_as_high_as_the_control_went():
    on = machine()
    found = [ExceededLimit("jerk", "X", 3.0, "ramp", 1, 3), ExceededLimit("jerk", "X", 2.0, "corner", 1, 3)]
    raised = raised_limits(on, [*found, ExceededLimit("acceleration", "Z", 1.5, "corner", 4, 9)])
    assert raised.jerk[0] == pytest.approx(3.0 * J) and raised.acceleration[2] == pytest.approx(1.5 * A)
    assert raised.jerk[1] == J and raised.acceleration[0] == A and (raised.velocity == on.limits.velocity).all()
