"""The range of a control's time: against closed forms, and controls whose figures lie within their uncertainties."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.support.s_curves import duration
from tests.support.timed_programs import MACHINE, A, J, machine
from toolpace import TimeRange
from toolpace.common.errors import UsageError
from toolpace.controls.timing.figures import ControlFigures, figures_of
from toolpace.controls.timing.program_time import time_of_moves, with_range
from toolpace.programs.commanded import Commanded
from toolpace.programs.reading import Source, read_commanded

ON = machine()


def moves_of(body: str) -> Commanded:
    return read_commanded(Source.from_text(f"G21 G90 G17 G94\nG0 X0 Y0 Z0 A0 C0\n{body}M2\n", "part.ngc"), ON)


def range_of(moves: Commanded, figures: ControlFigures) -> TimeRange:
    found = with_range(time_of_moves(moves, ON, figures), moves, ON, figures).range
    assert found is not None
    return found


def test_the_ends_of_a_line_are_those_of_closed_forms():
    """L / v + v / a + a / j, and each figure at its slower or faster end."""
    way, v = 0.2, 0.2
    stated = figures_of({"uncertainty": {"acceleration": 1.25, "jerk": [0.5, 3.0]}}, "", "lookahead")
    found = range_of(moves_of("G1 X200 F12000\nG4 P2\n"), stated)
    assert found.least == pytest.approx(2.0 + way / v + v / (1.25 * A) + 1.25 * A / (3.0 * J))
    assert found.most == pytest.approx(2.0 + way / v + 1.25 * v / A + A / 1.25 / (0.5 * J))
    effects = {each.figure: each for each in found.effects}
    assert effects["jerk"].most == pytest.approx(2.0 + way / v + v / A + A / (0.5 * J))
    assert effects["jerk of X"] == effects["jerk"].__class__("jerk of X", effects["jerk"].least, effects["jerk"].most)
    assert found.mostly == "jerk of X"


def test_time_that_is_least_between_the_ends_is_told_where_it_is_most():
    """At v = a^2 / j more acceleration is of no use, and less costs: the range begins at the time itself."""
    moves = moves_of("G1 X200 F6000\n")
    found = range_of(moves, figures_of({"uncertainty": {"jerk": 1.0, "acceleration": 1.2}}, "", "lookahead"))
    assert found.least == pytest.approx(duration(0.2, 0.1, A, J)[1])
    assert found.most == pytest.approx(duration(0.2, 0.1, A / 1.2, J)[1])


WAYS = np.random.default_rng(5).uniform(-20.0, 20.0, (25, 3))
CORNERS = "".join(f"G1 X{x:.3f} Y{y:.3f} Z{z:.3f} F5000\n" for x, y, z in WAYS)


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("model", ["lookahead", "fanuc", "sinumerik", "heidenhain"])
def test_a_control_whose_figures_lie_within_their_uncertainties_takes_a_time_within_the_range(model: str, seed: int):
    """Some at an end, some between: the worst of them at once are in the range, too."""
    rng = np.random.default_rng(seed)
    moves = moves_of(CORNERS)

    def off(most: float) -> float:
        share = rng.choice([-1.0, 1.0, rng.uniform(-1.0, 1.0)])
        return float(most**share)

    real: dict[str, object] = {"acceleration": off(1.2), "jerk": off(2.0), "tolerance": 0.01 * off(1.5)}
    if model == "fanuc":
        spread = float(rng.choice([0.0, 0.01, 0.03]))
        real["fanuc"] = {"corner_difference": 500.0 * off(2.0), "after_interpolation": spread}
    if model == "sinumerik":
        real["sinumerik"] = {"transition_jerk": off(2.0), "overload": 1.2 * off(1.05)}
    if model == "heidenhain":
        real["heidenhain"] = {"path_jerk": 40.0 * off(1.5)}
    time = time_of_moves(moves, ON, figures_of(real, "", model)).total
    found = range_of(moves, figures_of({}, "", model))
    assert found.least <= time * (1.0 + 1e-9) and time <= found.most * (1.0 + 1e-9)
    assert found.most < 2.0 * found.least


def test_exact_figures_leave_no_range():
    exact = figures_of({"uncertainty": {"jerk": 1.0, "acceleration": 1.0, "tolerance": 1.0}}, "", "lookahead")
    moves = moves_of(CORNERS)
    assert range_of(moves, exact) == TimeRange(*[time_of_moves(moves, ON, exact).total] * 2)
    waits = moves_of("G4 P2\n")
    assert range_of(waits, figures_of({}, "", "fanuc")).mostly == ""


def test_a_figure_without_effect_is_not_named_for_the_rounding_of_a_sum():
    found = range_of(moves_of(CORNERS), figures_of({}, "", "sinumerik"))
    assert all(each.width > 1e-9 * found.most for each in found.effects)
    assert not {"jerk of A", "jerk of C"} & {each.figure for each in found.effects}


def test_figures_by_axis_are_uncertain_each_by_itself():
    table = {"jerk": {"X": 1e3 * J, "Y": 1e3 * J}, "uncertainty": {"jerk": {"Y": 3.0, "X": 1.01, "Z": 1.0}}}
    found = range_of(moves_of("G1 X50 F6000\nG1 Y50\n"), figures_of(table, "", "lookahead"))
    assert found.mostly == "jerk of Y"
    assert {each.figure for each in found.effects} >= {"jerk of X", "jerk of Y"}


def test_without_a_tolerance_of_the_program_linuxcnc_has_none_that_could_be_wrong():
    found = range_of(moves_of(CORNERS), figures_of({}, "", "linuxcnc"))
    assert {each.figure.partition(" of ")[0] for each in found.effects} == {"acceleration"}


@pytest.mark.parametrize(
    ("table", "told"),
    [
        ({"jerks": 2.0}, "jerks: there is no such figure; did you mean 'jerk'"),
        ({"model": 2.0}, "model: there is no such figure"),
        ({"jerk": {"Q": 2.0}}, "has no axis Q"),
        ({"jerk": [2.0, 3.0]}, "the figure, 1, is not between 2 and 3"),
        ({"jerk": 0.5}, "Expected `float` >= 1.0"),
        ({"tolerance": {"X": 2.0}}, "there is no such figure"),
        ({"jerk": [0.5]}, "length >= 2"),
    ],
)
def test_an_uncertainty_that_is_none_is_refused(table: dict[str, object], told: str):
    with pytest.raises(UsageError, match=told.replace("[", r"\[")):
        range_of(moves_of(CORNERS), figures_of({"uncertainty": table}, "my.toml", "lookahead"))


def test_bounds_of_a_figure_are_told():
    stated = figures_of({"uncertainty": {"sinumerik": {"overload": 1.5}}}, "", "sinumerik")
    with pytest.raises(UsageError, match=r"sinumerik\.overload: .*give both ends"):
        range_of(moves_of(CORNERS), stated)
    assert math.isfinite(range_of(moves_of(CORNERS), figures_of({"tolerance": 1e-4}, "", "lookahead")).most)
    assert MACHINE.joints == ON.joints
