"""The optimal planner on random and nasty paths, family by family: always a valid answer or a justified refusal."""

from __future__ import annotations

import numpy as np
import pytest

from judge import GUARANTEE, verdict
from nasty import random_toolpath
from nasty_paths import FAMILIES, case
from toolpace.axispath import AxisPath
from toolpace.errors import ToolpaceError
from toolpace.limits import Limits
from toolpace.machine import Machine
from toolpace.path import Path
from toolpace.plan import plan
from toolpace.plan.detail import detail
from toolpace.plan.mesh import with_breaks
from toolpace.plan.problem import sides
from toolpace.read import read_text

SEEDS = 7
"""Cases of each family that everybody waits for."""
MANY, BLOCK = 180, 30
"""Cases of each family in the sweep, and how many of them one test takes."""


def check(family, seeds):
    told = [(seed, verdict(case(family, seed))[0]) for seed in seeds]
    assert not [(family, *one) for one in told if one[1] not in ("answer", "refusal")]


@pytest.mark.parametrize("family", FAMILIES)
def test_valid_answer_or_justified_refusal(family):
    check(family, range(10, 10 + SEEDS))


@pytest.mark.sweep
@pytest.mark.parametrize("first", range(1000, 1000 + MANY, BLOCK))
@pytest.mark.parametrize("family", FAMILIES)
def test_valid_answer_or_justified_refusal_on_thousands(family, first):
    check(family, range(first, first + BLOCK))


def cusp(width, place=0.5123):
    """Two joints: one goes on, the other turns back within `width`."""

    def f(s, order):
        x = s - place
        r = np.sqrt(x * x + width * width)
        along = [s, np.ones(len(s)), np.zeros(len(s)), np.zeros(len(s))][order]
        back = [r, x / r, width**2 / r**3, -3.0 * width**2 * x / r**5][order]
        return np.stack([along, back], axis=1)

    return AxisPath.from_callable(f)


@pytest.mark.parametrize("width", [1e-3, 1e-6, 1e-9])
def test_detail_between_grid_points_is_found(width):
    run, limits = cusp(width).runs[0], Limits([1.0, 1.0], 3.0, 20.0)
    found = detail(run, limits, np.linspace(0.0, 1.0, 101))
    assert np.abs(found - 0.5123).min() < width and len(found) < 400


def test_a_smooth_path_has_no_detail():
    run = AxisPath.from_callable(lambda s, order: np.sin(3.0 * s + order * np.pi / 2)[:, None] * 3.0**order).runs[0]
    assert len(detail(run, Limits([1.0], 3.0, 20.0), np.linspace(0.0, 1.0, 101))) == 0


def test_breaks_at_one_place_are_one_node_with_the_rows_of_all_sides():
    breaks = np.array([0.3, 0.3 + 1e-15, 0.3 + 1e-9, 0.6])
    nodes = with_breaks(np.linspace(0.0, 1.0, 11), breaks)
    assert np.diff(nodes).min() > 0.01 and {0.3, 0.6} <= set(nodes)
    node, point, more = sides(nodes, breaks)
    here = node == np.searchsorted(nodes, 0.3)
    assert here.sum() == 6 and more[here].sum() == 5
    assert (point[here].reshape(3, 2)[:, 0] < breaks[:3]).all() and (
        point[here].reshape(3, 2)[:, 1] == breaks[:3]
    ).all()


HEADER = "x [mm],y [mm],z [mm],i,j,k,feed [mm/min]\n"
MACHINE = "xyzac-trunnion"


def planned(text):
    """The trajectory of a table."""
    machine = Machine.load(MACHINE)
    return plan(Path.fit(read_text(text, dialect="csv"), machine=machine), machine)


@pytest.mark.parametrize("rows", ["", "1,2,3,0,0,1,500\n", "1,2,3,0,0,1,500\n1,2,3,0,0,1,500\n"])
def test_a_table_without_motion_is_refused_in_one_line(rows):
    with pytest.raises(ToolpaceError) as caught:
        planned(HEADER + rows)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "way", ["50,0,0,0,0,1", "0.001,0,0,0,0,1", "0,0,0,0,0.6,0.8", "0,0,0,0,1e-6,1", "100,0,0,0,0.6,0.8"]
)
def test_two_points_are_a_motion(way):
    trajectory = planned(f"{HEADER}0,0,0,0,0.1,1,500\n{way},500\n")
    assert trajectory.usage().worst <= GUARANTEE and 0.0 < trajectory.lower_bound <= trajectory.duration


@pytest.mark.sweep
@pytest.mark.parametrize("first", range(0, 60, 15))
def test_random_tool_paths_are_planned_or_refused(first):
    machine = Machine.load(MACHINE)
    answers = 0
    for seed in range(first, first + 15):
        toolpath, _ = random_toolpath(seed)
        try:
            trajectory = plan(Path.fit(toolpath, machine=machine), machine)
        except ToolpaceError as error:
            assert "\n" not in str(error)
            continue
        assert trajectory.usage().worst <= GUARANTEE and trajectory.lower_bound <= trajectory.duration
        answers += 1
    assert answers >= 10
