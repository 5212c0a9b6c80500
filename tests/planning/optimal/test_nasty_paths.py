"""The optimal planner on random and nasty paths, family by family: always a valid answer or a justified refusal."""

from __future__ import annotations

import numpy as np
import pytest

from testbed.nasty_paths import FAMILIES, case
from testbed.verdict import verdict
from tests.support.tool_paths import random_toolpath
from toolpace.common.errors import ToolpaceError
from toolpace.machine.limits import Limits
from toolpace.machine.machine import Machine
from toolpace.motion import limit_ratios
from toolpace.path.axis_path import AxisPath
from toolpace.path.path import Path
from toolpace.path.run import unit_jets
from toolpace.planning.limit_tolerances import PROMISED
from toolpace.planning.mesh.nodes import with_breaks
from toolpace.planning.mesh.path_detail import detail
from toolpace.planning.optimal.problem import sides
from toolpace.planning.planner import plan
from toolpace.programs.reading import read_text

MACHINE = "xyzac-trunnion"
SEEDS, OF_SLOW = 7, 2
"""Cases of each family that everybody waits for."""
BLOCK, BLOCKS, BLOCKS_OF_SLOW = 12, 10, 3
"""Cases of a family that one test of the sweep takes, and how many such tests there are."""
SLOW = ("pole", "slow_spots", "standing_tip", "caps_that_jump", "standing_joints", "limits_apart")
SWEEP = [
    pytest.param(family, k, marks=pytest.mark.thorough if k or family in SLOW else pytest.mark.sweep)
    for family in FAMILIES
    for k in range(BLOCKS_OF_SLOW if family in SLOW else BLOCKS)
]


def check(family, seeds):
    told = [(seed, verdict(case(family, seed)).words) for seed in seeds]
    assert not {(family, seed): words for seed, words in told if words not in ("answer", "refusal")}


@pytest.mark.parametrize("family", FAMILIES)
def test_valid_answer_or_justified_refusal(family):
    check(family, range(10, 10 + (OF_SLOW if family in SLOW else SEEDS)))


@pytest.mark.sweep
@pytest.mark.parametrize("family", SLOW)
def test_valid_answer_or_justified_refusal_of_slow_ones(family):
    check(family, range(10 + OF_SLOW, 10 + SEEDS))


@pytest.mark.parametrize(("family", "block"), SWEEP)
def test_valid_answer_or_justified_refusal_on_thousands(family, block):
    check(family, range(1000 + block * BLOCK, 1000 + (block + 1) * BLOCK))


@pytest.mark.parametrize("past", [1e-3, 1e-5, 1e-7])
def test_a_tool_axis_that_passes_its_pole_closely_keeps_its_solution(past):
    """C makes half a turn there, B keeps its sign; the other solution lies nearer on a coarse grid."""

    def f(s, order):
        lean = np.zeros((4, len(s), 3))
        lean[0] = np.stack([0.3 * (s - 0.5037), np.full(len(s), past), np.ones(len(s))], axis=1)
        lean[1, :, 0] = 0.3
        return np.zeros((len(s), 3)), unit_jets(lean)[order]

    run = AxisPath.follow(Path.from_callable(f), Machine.load(MACHINE)).runs[0]
    away = np.logspace(-9, -2, 3000)
    s = np.unique(np.concatenate([np.linspace(0.0, 1.0, 5001), 0.5037 - away, 0.5037 + away]))
    q = run.evaluate(s)
    turn = np.diff(q[0], axis=0)[:, 3:]
    assert np.abs(turn - (q[1, 1:, 3:] + q[1, :-1, 3:]) / 2.0 * np.diff(s)[:, None]).max() < 0.05
    assert abs(q[0, -1, 4] - q[0, 0, 4]) == pytest.approx(np.pi, abs=0.02)


@pytest.mark.parametrize("curved", [0.0, 0.2, -3.0])
def test_a_tool_axis_that_passes_right_through_its_pole_keeps_the_limits(curved):
    """The first joint goes on smoothly there; its derivatives next to the pole are rounding, which is no motion."""

    def f(s, order):
        x = s - 0.5037
        lean, tip = np.zeros((4, len(s), 3)), np.zeros((len(s), 3))
        lean[0] = np.stack([0.3 * x, curved * x * x, np.ones(len(s))], axis=1)
        lean[1, :, 0], lean[1, :, 1], lean[2, :, 1] = 0.3, 2.0 * curved * x, 2.0 * curved
        tip[:, 0] = [0.05 * s, 0.05 + 0.0 * s, 0.0 * s, 0.0 * s][order]
        return tip, unit_jets(lean)[order]

    trajectory = plan(Path.from_callable(f), Machine.load(MACHINE))
    law = trajectory.laws[0]
    t = np.linspace(0.0, law.duration, 200_001)
    near = np.logspace(-14, -3, 5000)
    every = np.concatenate([t, np.interp(0.5037 + np.concatenate([-near, near]), law.at(t)[0], t)])
    used = limit_ratios(trajectory.axis_path.runs[0], trajectory.limits, law.at(every), np.ones(len(every)))
    assert used.max() <= PROMISED


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
    assert trajectory.usage().worst <= PROMISED and 0.0 < trajectory.lower_bound <= trajectory.duration


@pytest.mark.parametrize(
    "seeds",
    [
        pytest.param(range(6), marks=pytest.mark.sweep, id="some"),
        pytest.param(range(6, 60), marks=pytest.mark.thorough, id="many"),
    ],
)
def test_random_tool_paths_are_planned_or_refused(seeds):
    machine = Machine.load(MACHINE)
    answers = 0
    for seed in seeds:
        toolpath, _ = random_toolpath(seed)
        try:
            trajectory = plan(Path.fit(toolpath, machine=machine), machine)
        except ToolpaceError as error:
            assert "\n" not in str(error)
            continue
        assert trajectory.usage().worst <= PROMISED and trajectory.lower_bound <= trajectory.duration
        answers += 1
    assert answers >= 0.66 * len(seeds)
