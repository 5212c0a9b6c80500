"""Parts of a problem that end where the run does, what is said of runs together, and of places that stay open."""

from __future__ import annotations

import time

import numpy as np
import pytest

from testbed.cases import flank
from testbed.jets import harmonics, path_of
from tests.support.mesh_problems import solved
from toolpace.machine.limits import Limits
from toolpace.path.axis_path import AxisPath
from toolpace.planning.bound import continuous
from toolpace.planning.bound.branch_and_bound import Allowance
from toolpace.planning.bound.gap_localisation import settled
from toolpace.planning.bound.problem import PADDING, Knots
from toolpace.planning.bound.prove import prove, prove_run
from toolpace.planning.bound.relaxation import relaxed
from toolpace.planning.optimal.planner import fastest_law
from toolpace.planning.planner import plan


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize(("begin", "end"), [(0.0, 0.5), (0.5, 1.0), (0.0, 1.0)])
def test_a_part_at_an_end_of_the_run_counts_as_much_in_the_whole(seed, begin, end):
    """The outermost coefficients of such a part are free where the run ends: fixed, they would bound too much."""
    problem, c = solved(300 + seed, cells=260, joints=3)
    knots = Knots(problem)
    last = len(knots.weight) - 1
    found = relaxed(knots, c, np.zeros_like(knots.cap), knots.cap, tolerance=0.02)
    dual = settled(knots, found.dual)
    low, high = round(begin * last), round(end * last)
    part = knots.part(low, high, found.c, dual)
    first, beyond = low + PADDING * (low > 0), high + 1 - PADDING * (high < last)
    assert (np.flatnonzero(part.has_rows()) + low).tolist() == list(range(first, beyond))
    before = part.value(knots.of_part(part, low, dual))
    better = relaxed(part, found.c[low : high + 3], np.zeros_like(part.cap), part.cap)
    joined = dual.copy()
    joined[knots.first[first] : knots.first[beyond]] = settled(part, better.dual)
    gain = knots.value(joined) - knots.value(dual)
    assert better.value - before == pytest.approx(gain, abs=1e-9 * knots.value(dual))
    assert gain > 0.0


def two_runs():
    """A path that stops half way, and limits of its joints."""
    first, second = (path_of(harmonics(np.random.default_rng(seed), 2)).runs[0] for seed in (1, 2))
    return AxisPath((first, second), ("X", "Y")), Limits([1.0] * 2, [4.0] * 2, [40.0] * 2, ("X", "Y"))


@pytest.mark.parametrize(("bounds", "told"), [((0.5, 0.25), 0.75), ((0.5, 0.0), 0.0), ((0.0, 0.0), 0.0)])
def test_the_continuous_bound_is_that_of_all_runs_or_there_is_none(monkeypatch, bounds, told):
    path, limits = two_runs()
    trajectory = plan(path, limits, mesh=40)
    given = dict(zip(path.runs, bounds, strict=True))
    monkeypatch.setattr(continuous, "continuous_bound", lambda run, *others: given[run])
    assert prove(trajectory, within=0.0).continuous_bound == told


def test_places_that_stay_open_are_named_with_what_they_may_be_worth():
    """Without time to close any; with time for all, less is left."""
    case = flank()
    law, _ = fastest_law(case.run, case.limits, cells=300, guard=False)
    open_, closed = (
        prove_run(case.run, case.limits, law, 1e-4, Allowance(time.monotonic() + within)).places
        for within in (0.0, 60.0)
    )
    assert len(open_) == len(closed) > 0
    assert (open_[:, 2] > 0.0).all() and (open_[:, 0] <= open_[:, 1]).all()
    assert closed[:, 2].sum() < 0.5 * open_[:, 2].sum()
