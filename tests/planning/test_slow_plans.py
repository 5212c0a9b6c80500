"""Why a plan of the sweep is slow: no slow one is left without a cause."""

from __future__ import annotations

import pytest

from testbed.slow_plans import AS_GIVEN, Work, cause, cause_by_planning_again, watched, work_of
from tests.support.random_paths import harmonics, random_limits
from toolpace.kernels.optimal import solver
from toolpace.path.axis_path import AxisPath
from toolpace.planning.planner import plan

SLOW, FEW = 2e-4, 0.1
"""Cost a point from which a plan is slow, and that of a plan of few points in all [s]."""


def row(points, cpu, path=0.0, notes=(), **work):
    return {"points": points, "cpu": cpu, "path_cpu": path, "notes": list(notes), "work": work_of(Work(**work))}


@pytest.mark.parametrize(
    ("made", "head"),
    [
        (row(1000, 0.19), ""),
        (row(100, 0.09), "few points"),
        (row(1000, 1.0, path=0.6), "the path"),
        (row(1000, 0.21, path=0.02), "the path"),
        (row(1000, 1.0, solves=9, unended=8, in_vain=0.7, solving=0.8), "solves without an end"),
        (row(1000, 1.0, notes=["the lower bound was loose"], trying=0.7), "another try"),
        (row(1000, 1.0, notes=["the lower bound was loose"], trying=0.1), "all of it"),
        (row(1000, 1.0, notes=[f"gap of 4%; {AS_GIVEN}"]), "all of it"),
        (row(100, 1.0), "all of it"),
    ],
)
def test_each_slow_plan_has_its_cause(made, head):
    assert cause(made, SLOW, FEW).split(":")[0] == head


def test_a_row_that_does_not_tell_is_planned_again():
    unsaid = row(1000, 1.0, notes=[f"gap of 4%; {AS_GIVEN}"])
    del unsaid["work"]
    assert cause(unsaid, SLOW, FEW) == ""
    assert cause_by_planning_again(unsaid, row(1000, 1.0, solves=3), SLOW, FEW).startswith("all of it: 3 solves")
    assert cause_by_planning_again(unsaid, row(1000, 0.1), SLOW, FEW).startswith("the machine")


def test_what_the_planner_does_is_counted():
    before = solver.maximise_speed
    with watched() as work:
        plan(AxisPath.from_callable(harmonics(3, 2)), random_limits(3, 2), mesh=60)
    assert solver.maximise_speed is before
    assert work.solves > 0 and work.looks > 0 and work.steps >= 5 * work.solves
    assert 0.0 < work.solving < 10.0 and 0.0 < work.bounding < 10.0 and work.unended <= work.solves
