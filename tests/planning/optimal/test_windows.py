"""Stretches of a run, and what solving them again leaves as it was."""

from __future__ import annotations

from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest

from tests.support.mesh_problems import ingredients
from toolpace.common.workers import Workers
from toolpace.path.axis_path import AxisPath
from toolpace.planning.mesh.nodes import first_mesh
from toolpace.planning.optimal import windows
from toolpace.planning.optimal.meshed_run import MeshedRun
from toolpace.planning.optimal.solve import Stalled, start_from
from toolpace.planning.optimal.windows import SEAM_LOSS, WINDOW, Stretch, mend, solve_run, stretches
from toolpace.planning.planned_run import AT_REST

CELLS = 200


@cache
def best():
    """A run on a mesh, and its optimum."""
    f, limits, _ = ingredients(5, breaks=False)
    run = AxisPath.from_callable(f).runs[0]
    nodes, rough = first_mesh(run, limits, (0.0, 0.0), CELLS)
    meshed = MeshedRun.after_guess(run, limits, nodes, (AT_REST, AT_REST), rough)
    return meshed, solve_run(meshed, start_from(meshed, rough.s, rough.z, 0.4), 1.0, Workers())


def spoiled(c, part):
    """The coefficients slowed down inside a stretch."""
    out = c.copy()
    out[part.low + 4 : part.high - 2] *= 0.8
    return out


@pytest.mark.parametrize("part", [Stretch(60, 120, 85, 95), Stretch(0, 70, 20, 40), Stretch(140, 198, 160, 198)])
def test_a_stretch_comes_to_the_optimum_and_nothing_else_moves(part):
    """Between ends at the optimum, the optimum of a stretch is that of the whole."""
    meshed, c = best()
    assert len(meshed.nodes) == CELLS - 1
    begin = spoiled(c, part)
    found, stuck = mend(meshed, begin, [part], SEAM_LOSS, 0.1, Workers(), least=0.0)
    assert stuck == []
    assert found == pytest.approx(c, rel=2e-4)
    outside = np.ones(len(c), dtype=bool)
    outside[0 if part.low == 0 else part.low + 2 : None if part.high == CELLS - 2 else part.high + 1] = False
    assert (found[outside] == begin[outside]).all()


def placed(spans, count=100):
    """A run whose surroundings of each place are given: place k reaches from spans[k][0] to spans[k][1]."""
    low, high = np.array(spans).T
    return SimpleNamespace(
        nodes=np.arange(float(count)), is_long=True, around=lambda first, last, ramps: (low[first], high[first])
    )


@pytest.mark.parametrize(
    ("spans", "parts"),
    [
        ([(0, 5), (10, 20), (30, 40)], [(0, 5, 0, 1), (10, 20, 1, 2), (30, 40, 2, 3)]),
        ([(0, 9), (10, 20), (30, 40)], [(0, 20, 0, 2), (30, 40, 2, 3)]),
        ([(0, 30), (10, 20), (31, 40)], [(0, 40, 0, 3)]),
    ],
)
def test_stretches_that_meet_are_one(spans, parts):
    marked = np.ones(3, dtype=bool)
    assert [tuple(part) for part in stretches(placed(spans), marked)] == parts


@pytest.mark.parametrize(("wide", "pieces"), [(100, 4), (WINDOW // 2 + 1, 2)])
def test_windows_whose_seams_would_overlap_are_wider(monkeypatch, wide, pieces):
    """Two stretches that share nodes must not be solved at once."""
    solved = []

    def mend(meshed, c, parts, *given, **named):
        solved.append([(part.low, part.high) for part in parts])
        return c, []

    last = 4 * WINDOW
    run = SimpleNamespace(
        nodes=np.arange(last + 1.0), is_long=True,
        around=lambda first, last, ramps: (np.maximum(first - wide, 0), np.minimum(last + wide, 4 * WINDOW)),
        problem=lambda low, high: (low, high),
    )  # fmt: skip
    monkeypatch.setattr(windows, "mend", mend)
    monkeypatch.setattr(windows, "solve_whole", lambda problem, c, spread, idle: solved.append([problem]) or c)
    solve_run(run, np.ones(last + 3), 1.0, Workers())
    assert len(solved[0]) == pieces
    assert [low for low, _ in solved[0]] + [last] == [0] + [high for _, high in solved[0]]
    assert len(solved[1]) == pieces - 1
    assert all(one[1] < next_[0] for one, next_ in zip(solved[1], solved[1][1:]))


@pytest.mark.parametrize("fails", [0, 1, 2])
def test_a_stretch_without_a_way_is_made_wider_and_at_last_left_alone(monkeypatch, fails):
    meshed, c = best()
    part = Stretch(80, 120, 95, 105)
    true, asked = windows.solve, []

    def solve(problem, begin, spread, once=False, idle=0.0):
        asked.append((len(problem.nodes), once))
        if len(asked) <= fails:
            raise Stalled(0.0, "some limit")
        return true(problem, begin, spread, once, idle)

    monkeypatch.setattr(windows, "solve", solve)
    begin = spoiled(c, part)
    found, stuck = mend(meshed, begin, [part], SEAM_LOSS, 0.1, Workers())
    assert asked[0] == (41, True) and len(asked) == min(fails + 1, 2)
    if fails:
        assert asked[1][0] > 41 and not asked[1][1]
    if fails < 2:
        assert stuck == [] and found[95:105] == pytest.approx(c[95:105], rel=2e-4)
    else:
        assert [(one.first, one.last) for one in stuck] == [(95, 105)]
        assert (found == begin).all()


def test_a_stretch_that_loses_most_of_its_speed_is_no_way(monkeypatch):
    meshed, c = best()
    part = Stretch(80, 120, 95, 105)
    monkeypatch.setattr(windows, "solve", lambda problem, begin, spread, once=False, idle=0.0: 0.5 * begin)
    found, stuck = mend(meshed, c, [part], 0.0, 0.1, Workers())
    assert (found == c).all() and len(stuck) == 1
    found, stuck = mend(meshed, c, [part], 0.0, 0.1, Workers(), least=0.0)
    assert stuck == [] and (found[82:120] == 0.5 * c[82:120]).all()


@pytest.mark.parametrize(("low", "high", "ways"), [(96, 106, 0), (84, 88, 1), (118, 122, 1)])
def test_what_falls_in_a_wide_stretch_is_no_way_beside_its_ends_only(monkeypatch, low, high, ways):
    meshed, c = best()
    narrow, wide = Stretch(90, 112, 100, 102), Stretch(80, 124, 100, 102)

    def solve(problem, begin, spread, once=False, idle=0.0):
        first = int(np.searchsorted(meshed.nodes, problem.nodes[0]))
        found = begin.copy()
        found[max(low - first, 0) : high - first] *= 0.5
        return found

    monkeypatch.setattr(windows, "solve", solve)
    monkeypatch.setattr(windows, "around", lambda meshed, first, last, ramps: [wide])
    found, stuck = mend(meshed, c, [narrow if ways == 0 else wide], 0.0, 0.1, Workers())
    assert len(stuck) == ways
    assert (found == c).all() if ways else (found[low:high] < 0.6 * c[low:high]).all()
