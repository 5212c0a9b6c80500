"""Planners as objects, their short form, and what is said where either is given wrongly."""

from __future__ import annotations

import inspect
from dataclasses import dataclass, fields

import numpy as np
import pytest

import toolpace as tp
from toolpace.common.errors import UsageError
from toolpace.motion.laws import LinearLaw
from toolpace.planning.planned_run import PlannedRun


def line() -> tp.AxisPath:
    """One joint, one metre."""
    return tp.AxisPath.from_callable(lambda s, order: ([s, np.ones_like(s)] + [np.zeros_like(s)] * 2)[order][:, None])


LIMITS = tp.Limits(velocity=1.0, acceleration=3.0, jerk=20.0)


@pytest.mark.parametrize(
    "short, planner",
    [
        ({"planner": "optimal", "mesh": 100}, tp.Optimal(mesh=100)),
        ({"planner": "optimal", "mesh": 100, "guard": False, "bound": False}, tp.Optimal(100, False, False)),
        ({"planner": "genetic", "generations": 2}, tp.Genetic(generations=2)),
        ({"planner": "second-order", "mesh": 100}, tp.SecondOrder(mesh=100)),
    ],
)
def test_the_short_form_is_the_object(short, planner):
    by_name, by_object = tp.plan(line(), LIMITS, **short), tp.plan(line(), LIMITS, planner=planner)
    assert by_name.duration == by_object.duration and by_name.lower_bound == by_object.lower_bound
    assert by_name.planner == by_object.planner == planner.name


@pytest.mark.parametrize("planner", [tp.Optimal, tp.Genetic, tp.SecondOrder])
def test_help_and_completion_see_the_options(planner):
    assert list(inspect.signature(planner).parameters) == [field.name for field in fields(planner)]


def test_planners_are_values():
    assert tp.Optimal(mesh=9) == tp.Optimal(mesh=9) != tp.Optimal(mesh=10)
    assert len({tp.Genetic(), tp.Genetic(), tp.Genetic(intervals=np.array([0.2, 0.5]))}) == 2
    with pytest.raises(AttributeError):
        tp.Optimal().mesh = 3


@pytest.mark.parametrize(
    "make, words",
    [
        (lambda: tp.Optimal(mehs=3), "Optimal: no option 'mehs'; did you mean 'mesh'"),
        (lambda: tp.Genetic(generation=3), "did you mean 'generations'"),
        (lambda: tp.SecondOrder(bound=True), "SecondOrder: no option 'bound'; known: mesh, guard"),
        (lambda: tp.Optimal(1000, True, True, 4), "Optimal: more options than there are"),
        (lambda: tp.Optimal(1000, mesh=10), "give them by name: mesh, guard, bound"),
        (lambda: tp.Optimal(mesh=3), "a mesh of 3 cells is too coarse; give at least 8"),
        (lambda: tp.Optimal(mesh=10.5), "give a whole number of cells"),
        (lambda: tp.Optimal(mesh="fine"), "mesh is 'fine'; give a whole number of cells"),
        (lambda: tp.Genetic(intervals="many"), "intervals is 'many'"),
        (lambda: tp.plan(line(), LIMITS, planner="optimum"), "unknown planner 'optimum'; did you mean 'optimal'"),
        (lambda: tp.plan(line(), LIMITS, mehs=100), "the planner optimal has no option 'mehs'; did you mean 'mesh'"),
        (lambda: tp.plan(line(), LIMITS, planner="genetic", mesh=100), "the planner genetic has no option 'mesh'"),
        (lambda: tp.plan(line(), LIMITS, planner=tp.Optimal(), mesh=100), "given as an object; .* mesh="),
        (lambda: tp.plan(line(), LIMITS, planner=tp.Optimal), "is no planner; give one of optimal, genetic"),
        (lambda: tp.plan(line(), LIMITS, planner=None), "None is no planner"),
        (lambda: tp.Genetic(bits="x"), "genetic: bits is 'x'; it must be a whole number"),
        (lambda: tp.Genetic(generations=1.5), "generations is 1.5; it must be a whole number"),
        (lambda: tp.Genetic(crossover=None), "crossover is None; it must be a number"),
        (lambda: tp.Genetic(intervals=np.nan), "intervals is nan; give a whole number"),
        (lambda: tp.Optimal(guard="no"), "guard is 'no'; give True or False"),
        (lambda: tp.plan(line(), LIMITS, start=(1.0, 0.0)), "start is .*; give an EndState"),
        (lambda: tp.EndState("fast"), "speed is 'fast'; give ds/dt"),
        (lambda: tp.Path.fit(None, machine="paper-ab"), r"fit: .* name of a machine; give Machine.load\('paper-ab'\)"),
        (lambda: tp.AxisPath.follow(tp.Path.paper_arc(), "paper-ab"), "path: 'paper-ab' is the name of a machine"),
        (lambda: tp.verify(tp.plan(line(), LIMITS), "paper-ab"), "verify: 'paper-ab' is the name of a machine"),
        (lambda: tp.AxisPath.from_callable(lambda s, order: s[:, None], joints=[1]), "give a different name"),
        (lambda: tp.plan(line(), "xyzac-trunnion"), r"the name of a machine; give Machine.load\('xyzac-trunnion'\)"),
        (lambda: tp.plan(line(), [1.0, 2.0, 3.0]), "list in place of a machine; give a Machine, or Limits"),
        (lambda: tp.plan("part.ngc", LIMITS), "str in place of a path"),
        (lambda: tp.plan(tp.Path.paper_arc(), LIMITS), "needs a machine; bare limits go with an AxisPath"),
    ],
)
def test_what_makes_no_sense_is_one_line(make, words):
    with pytest.raises(UsageError, match=words) as caught:
        make()
    assert "\n" not in str(caught.value)


def test_a_tool_path_is_to_be_made_smooth_first():
    machine = tp.Machine.load("xyzac-trunnion")
    toolpath = tp.read_text("G21 G90 G94 F1000\nG1 X0 Y0 Z10 A0 C0\nX10\nY10\n", machine)
    with pytest.raises(UsageError, match=r"make it smooth first: Path.fit\(toolpath, machine=machine\)"):
        tp.plan(toolpath, machine)


@dataclass(frozen=True)
class Crawl:
    """A planner of somebody else's: constant speed."""

    speed: float
    name: str = "crawl"

    def plan_run(self, run, limits, start, end, workers, progress):
        """So fast all the way."""
        nodes = np.linspace(run.s0, run.s1, 10)
        return PlannedRun(LinearLaw(nodes, np.full(10, self.speed**2)), len(nodes))


def test_a_planner_of_ones_own():
    trajectory = tp.plan(line(), LIMITS, planner=Crawl(0.25))
    assert trajectory.duration == pytest.approx(4.0) and trajectory.planner == "crawl" and trajectory.lower_bound == 0.0
