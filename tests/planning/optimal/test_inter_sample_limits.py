"""The guard by itself: what it looks for between the nodes, and what it hands back."""

from __future__ import annotations

import numpy as np
import pytest

from testbed.jets import path_of, straight
from testbed.programs import tulsyan
from tests.support.mesh_problems import small
from toolpace.common.workers import UNTOLD, Progress, Workers
from toolpace.machine.limits import Limits
from toolpace.machine.machine import Machine
from toolpace.motion.laws import SplineLaw
from toolpace.path.axis_path import AxisPath
from toolpace.path.path import Path
from toolpace.planning.limit_tolerances import GUARANTEE
from toolpace.planning.mesh.nodes import first_mesh
from toolpace.planning.optimal import inter_sample_limits
from toolpace.planning.optimal.inter_sample_limits import held_between_nodes, within_guarantee
from toolpace.planning.optimal.meshed_run import MeshedRun
from toolpace.planning.optimal.planner import fastest_law
from toolpace.planning.optimal.slow_down import closer, slowing
from toolpace.planning.optimal.solve import LIMITS, Stalled, start_from
from toolpace.planning.optimal.windows import solve_run
from toolpace.planning.peaks import LimitCheck, Peaks
from toolpace.planning.planned_run import AT_REST

WORKERS = Workers()
LOOSE = Limits([1.0], [1e6], [1e12])
"""A line that is run at full speed from end to end: no law that is slower somewhere uses more of these."""


def meshed_and_solved(run, limits, cells):
    """A run on a mesh, and its law with the limits held at the nodes."""
    nodes, rough = first_mesh(run, limits, (0.0, 0.0), cells)
    meshed = MeshedRun.after_guess(run, limits, nodes, (AT_REST, AT_REST), rough)
    c = solve_run(meshed, start_from(meshed, rough.s, rough.z, 0.4), 1.0, WORKERS, UNTOLD)
    return meshed, SplineLaw(meshed.nodes, c, meshed.rest)


def with_a_dip(law, cell, left=0.02):
    """The law with z fallen, within a cell, to a third of what is left of it at both its nodes."""
    c = law.c.copy()
    c[cell + 1 : cell + 3] *= left
    return SplineLaw(law.nodes, c, law.rest)


@pytest.mark.parametrize("fixed", [False, True])
def test_a_cell_in_which_z_falls_far_is_solved_again(fixed):
    """It passes no limit: nothing but the look at dips sees that the motion crawls there."""
    meshed, law = meshed_and_solved(path_of(straight([1.0])).runs[0], LOOSE, 60)
    law = held_between_nodes(meshed, law, True, WORKERS)
    assert not law.dips().any() and len(law.nodes) == len(meshed.nodes)
    crawling = with_a_dip(law, 30)
    assert crawling.dips()[30] and meshed.look.peaks(crawling).used.max() <= GUARANTEE
    assert crawling.duration > 1.05 * law.duration
    found = held_between_nodes(meshed, crawling, fixed, WORKERS)
    assert not found.dips().any() and found.duration < 1.001 * law.duration
    assert LimitCheck(meshed.run, LOOSE, found.nodes).peaks(found).used.max() <= GUARANTEE


def test_many_joints_at_their_limits_at_once_are_all_held():
    """Of the smoothest path of a pass with little room: with two rows of a kind a point, the joints that were left out
    passed their limits six-fold, and 1.60 s were left of a law of 1.22 s."""
    machine = Machine.load("xyzac-trunnion")
    path = Path.fit(tulsyan(machine), 10e-6, np.radians(0.05), machine)
    run = AxisPath.follow(path, machine).runs[0]
    at_nodes, _ = fastest_law(run, machine.limits, guard=False)
    law, _ = fastest_law(run, machine.limits)
    assert law.duration < 1.01 * at_nodes.duration
    assert LimitCheck(run, machine.limits, law.nodes).peaks(law).used.max() <= GUARANTEE


@pytest.mark.parametrize("most", [0, 1, 3])
def test_after_the_rounds_that_are_given_what_is_left_is_slowed_down(monkeypatch, most):
    """A coarse mesh, on which limits are passed between the nodes by far."""
    looks, true = [], inter_sample_limits.checked_between_nodes

    def checked_between_nodes(*given):
        looks.append(given)
        return true(*given)

    monkeypatch.setattr(inter_sample_limits, "checked_between_nodes", checked_between_nodes)
    run, limits, _, _ = small(1)
    meshed, law = meshed_and_solved(run, limits, 12)
    assert meshed.look.peaks(law).used.max() > 1.01
    found = held_between_nodes(meshed, law, True, WORKERS, most_rounds=most)
    assert len(looks) <= most + 1
    assert most > 0 or found.duration > law.duration
    assert LimitCheck(run, limits, found.nodes).peaks(found).used.max() <= GUARANTEE


def test_progress_runs_forward_from_round_to_round_and_not_to_the_end_of_all(monkeypatch):
    """How many rounds there will be nobody knows; each tells of a part of what is left."""
    true = inter_sample_limits.resolve

    def resolve(meshed, c, wrong, used, workers, progress):
        for share in (0.0, 0.5, 1.0):
            progress(share)
        return true(meshed, c, wrong, used, workers)

    monkeypatch.setattr(inter_sample_limits, "resolve", resolve)
    run, limits, _, _ = small(1)
    meshed, law = meshed_and_solved(run, limits, 12)
    told: list[float] = []
    held_between_nodes(meshed, law, True, WORKERS, Progress(told.append))
    assert len(told) >= 3 and told == sorted(told) and told[0] >= 0.0 and told[-1] < 1.0


def test_a_law_that_dips_is_never_handed_back():
    """Within every limit as it is, and too slow, or of no duration at all: z falls to nothing between two nodes."""
    meshed, law = meshed_and_solved(path_of(straight([1.0])).runs[0], LOOSE, 60)
    law = held_between_nodes(meshed, law, True, WORKERS)
    for left in (0.02, -0.08):
        crawling = with_a_dip(law, 30, left)
        assert crawling.dips().any()
        found = within_guarantee(meshed, crawling, meshed.look.peaks(crawling).used, WORKERS)
        assert not found.dips().any() and np.isfinite(found.duration)
        assert LimitCheck(meshed.run, LOOSE, found.nodes).peaks(found).used.max() <= GUARANTEE


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("faster", [1.0001, 1.01, 1.5])
def test_what_passes_the_guarantee_is_slowed_down_to_it(seed, faster):
    """The law that holds its limits at the nodes, run faster: as a whole, or at one place."""
    run, limits, _, _ = small(900 + seed, cells=60, breaks=False)
    meshed, law = meshed_and_solved(run, limits, 60)
    held = held_between_nodes(meshed, law, True, WORKERS)
    place = np.full(len(held.c), 1.0)
    place[30:33] = faster
    for c in (held.c * faster, held.c * place):
        fast = SplineLaw(held.nodes, c, held.rest)
        peak = LimitCheck(run, limits, held.nodes).peaks(fast).used
        found = within_guarantee(meshed, fast, peak, WORKERS)
        assert LimitCheck(run, limits, found.nodes).peaks(found).used.max() <= GUARANTEE
        assert found.duration <= fast.duration * np.sqrt(slowing(peak)) * (1.0 + 1e-3)


def test_where_nothing_can_be_slowed_down_the_worst_place_is_named():
    """A usage that is no number, or infinite, in one cell: by its place and the limit."""
    meshed, law = meshed_and_solved(path_of(straight([1.0])).runs[0], LOOSE, 60)
    for kind, name in enumerate(LIMITS):
        for bad in (np.nan, np.inf):
            peak = np.full((len(law.nodes) - 1, 3), 0.5)
            peak[23, kind] = bad
            with pytest.raises(Stalled) as caught:
                within_guarantee(meshed, law, peak, WORKERS)
            assert (caught.value.place, caught.value.limit) == (law.nodes[23], name)


@pytest.mark.parametrize("kind", range(3))
def test_the_cells_that_ask_for_most_slowing_are_looked_at_closely(monkeypatch, kind):
    """By speed, acceleration and jerk alike: what hides between probes there is what all is slowed down for."""
    meshed, law = meshed_and_solved(path_of(straight([1.0])).runs[0], LOOSE, 60)
    peak = np.random.default_rng(kind).uniform(0.5, 0.9, (len(law.nodes) - 1, 3))
    peak[41, kind] = 1.2
    looked = []

    def peaks_in(fine, cells, workers):
        looked.append((cells, len(fine.inside)))
        return Peaks(np.full((len(cells), 3), 1.3), np.zeros((len(cells), 3)))

    monkeypatch.setattr(meshed.look, "peaks_in", peaks_in)
    assert closer(meshed.look, law, peak, WORKERS) == pytest.approx(1.3**2)
    ((cells, probes),) = looked
    assert cells[0] == 41 and len(cells) == 20 and probes == 1000
