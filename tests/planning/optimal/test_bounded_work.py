"""Runs that took long for a known reason: their work is bounded, in nodes and rounds."""

from __future__ import annotations

import numpy as np
import pytest

import toolpace as tp
from testbed.slow_plans import watched
from tests.support.random_paths import harmonics, random_limits
from toolpace.motion.laws import SplineLaw
from toolpace.path.axis_path import AxisPath
from toolpace.planning.mesh.nodes import cut_cells, first_mesh, needed_hints
from toolpace.planning.optimal import inter_sample_limits
from toolpace.planning.optimal.meshed_run import on_finer_mesh
from toolpace.planning.optimal.planner import fastest_law
from toolpace.planning.path_at_probes import PathAtProbes
from toolpace.planning.peaks import LimitCheck

HINTS = np.linspace(0.0, 1.0, 20_001)[1:-1]


def path_with(hints, seed=7):
    return AxisPath.from_callable(harmonics(seed, 3), hints=hints)


@pytest.mark.sweep
def test_hints_that_a_motion_does_not_feel_make_no_nodes():
    """Knots every few tolerances along a smooth way: 40 000 nodes where some hundred do."""
    limits = random_limits(7, 3)
    with watched() as work:
        found = tp.plan(path_with(HINTS), limits)
    assert found.mesh_points < 2_500 and work.looks <= 8
    assert found.usage().worst <= 1.0001 and found.gap < 0.02
    fine = tp.plan(path_with(HINTS), limits, mesh=8_000)
    assert found.duration == pytest.approx(fine.duration, rel=1e-3)


def test_hints_about_what_is_felt_stay():
    """A bend of a hundredth of the way: between its hints the path does more than both tell, elsewhere it does not."""

    def bend(s, order):
        x, wide = s - 0.5, 0.01
        f = np.exp(-((x / wide) ** 2) / 2.0)
        by_order = (f, -x / wide**2 * f, (x**2 / wide**4 - 1.0 / wide**2) * f, (3.0 * x / wide**4 - x**3 / wide**6) * f)
        straight = (s, np.ones_like(s), np.zeros_like(s), np.zeros_like(s))
        return np.stack([straight[order], 0.01 * by_order[order]], axis=1)

    run = AxisPath.from_callable(bend, hints=HINTS).runs[0]
    limits = tp.Limits([1.0, 1.0], [5.0, 5.0], [50.0, 50.0], run_joints(2))
    _, rough = first_mesh(run, limits, (0.0, 0.0), None)
    left = needed_hints(run, limits, rough)
    inside = np.abs(left - 0.5) < 0.04
    assert len(left) < len(HINTS) / 20 and np.count_nonzero(inside) > np.count_nonzero(~inside)
    assert set(left) <= set(HINTS)
    assert tp.plan(AxisPath.from_callable(bend, hints=HINTS), limits).usage().worst <= 1.0001


def run_joints(count):
    return tuple(f"J{k}" for k in range(count))


def test_cells_that_are_not_cut_are_not_checked_again(monkeypatch):
    """The check of a finer mesh finds what one from scratch finds, and asks for the path in the cut cells only."""
    run, limits = path_with(()).runs[0], random_limits(7, 3)
    law, _ = fastest_law(run, limits, 200, guard=False)
    check = LimitCheck(run, limits, law.nodes)
    check.peaks(law)
    parts = np.ones(len(law.nodes) - 1, dtype=np.int64)
    parts[[20, 90, 91]] = 2, 4, 2
    finer = cut_cells(law.nodes, parts)
    same = SplineLaw(finer, on_finer_mesh(law, finer)[0], law.rest)
    same.inside = law.inside  # a finer mesh has fewer probes a cell
    cells, interpolated = [], PathAtProbes.interpolated

    def counted(path, which, inside, law):
        cells.extend(which)
        return interpolated(path, which, inside, law)

    monkeypatch.setattr(PathAtProbes, "interpolated", counted)
    later = LimitCheck(run, limits, finer, before=(check, parts))
    found = later.peaks(same)
    assert 8 <= len(cells) < 40
    fresh = LimitCheck(run, limits, finer)
    expected = fresh.peaks(same)
    np.testing.assert_array_equal(found.used, expected.used)
    np.testing.assert_array_equal(found.place, expected.place)
    np.testing.assert_array_equal(later.path.unlike, fresh.path.unlike)
    assert np.array_equal(later.confirmed(same, found).used, fresh.confirmed(same, expected).used)


def test_falls_in_cells_too_short_to_be_cut_do_not_hold_up_a_run(monkeypatch):
    """A drill that turns back on its own way: where nothing can be cut any more, further solves find the same law."""
    machine = tp.Machine.load("xyzac-trunnion")
    cut = "G21 G94\nG0 X0 Y0 Z20\nG98 G83 X0 Y0 Z-20 R1 Q2 F1000\nG80\nG0 Z50\n"
    run = tp.AxisPath.follow(tp.Path.fit(tp.read_text(cut, machine), machine=machine), machine).runs[0]
    monkeypatch.setattr(inter_sample_limits, "LEAST_CELL", np.inf)
    falls = SplineLaw.dips
    monkeypatch.setattr(SplineLaw, "dips", lambda law: falls(law) | (np.arange(len(law.nodes) - 1) == 40))
    with watched() as work:
        law, _ = fastest_law(run, machine.limits)
    assert work.looks < inter_sample_limits.MOST_ROUNDS
    assert LimitCheck(run, machine.limits, law.nodes).peaks(law).used.max() <= 1.0001
