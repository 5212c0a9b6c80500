"""Laws whose z falls to nothing inside a cell: what comes back has none, and is the same elsewhere."""

from __future__ import annotations

import numpy as np
import pytest

from toolpace.motion.laws import SplineLaw
from toolpace.planning.optimal.meshed_run import FLOOR, lowest_z, on_finer_mesh, too_short, without_undershoot
from toolpace.planning.optimal.problem import OnMesh
from toolpace.planning.optimal.solve import pinned
from toolpace.planning.planned_run import AT_REST

NODES = np.linspace(0.2, 0.8, 31)
REST = (0.02, 0.02)


def law_with(changed, left, rest=REST):
    """A law of even speed, but for coefficients that are changed to `left`."""
    c = np.ones(len(NODES) + 2)
    c[changed] = left
    ends = (AT_REST, AT_REST)
    return SplineLaw(NODES, pinned(OnMesh(NODES, rest, ends), c) if rest[0] else c, rest)


def z_of(law, s):
    cell = np.clip(np.searchsorted(law.nodes, s, side="right") - 1, 0, len(law.nodes) - 2)
    x, a = s - law.nodes[cell], law.cells[cell].T
    return a[0] + x * (a[1] + x * (a[2] + x * a[3]))


@pytest.mark.parametrize("left", [0.03, 1e-3, -0.05, -0.086, -0.0869565])
@pytest.mark.parametrize("changed", [[16, 17], [2, 3], [30, 29], [10, 11, 20, 21]])
def test_what_is_handed_back_has_no_dips_and_is_the_same_elsewhere(changed, left):
    """In the middle of the cell z is (2 + 46 left) / 48 of what is around it, at its nodes (1 + 5 left) / 6."""
    law = law_with(changed, left)
    assert law.dips().any()
    found = without_undershoot(law)
    assert not found.dips().any() and np.isfinite(found.duration)
    s = np.linspace(found.nodes[0], found.nodes[-1], 5001)
    assert z_of(found, s).min() > 0.0
    assert (found.s0, found.s1, *found.rest) == pytest.approx((law.s0, law.s1, *law.rest))
    assert set(law.nodes) <= set(found.nodes)
    # a coefficient reaches over four cells
    dip = np.concatenate([NODES[np.clip([k - 3, k + 1], 0, 30)] for k in changed]).reshape(-1, 2)
    apart = np.all([(s < low) | (s > high) for low, high in dip], axis=0)
    assert apart.any() or len(changed) > 2
    np.testing.assert_allclose(z_of(found, s)[apart], z_of(law, s)[apart], rtol=1e-9)


@pytest.mark.parametrize("changed", [[16, 17], [2, 3], [30, 29]])
def test_z_that_falls_to_nothing_is_raised_to_a_share_of_what_is_around_it(changed):
    s = np.linspace(NODES[0], NODES[-1], 20001)
    low, high = -0.2, 0.2
    while high - low > 1e-7:
        left = (low + high) / 2.0
        low, high = (left, high) if z_of(law_with(changed, left), s).min() < 0.0 else (low, left)
    law = law_with(changed, high)
    assert 0.0 <= z_of(law, s).min() < 1e-5
    found = without_undershoot(law)
    assert z_of(found, s).min() > 0.1 * FLOOR * min(law.z_at_nodes())
    # and the motion does not jump out of rest, or into it
    for at, step in ((found.times[0], 1e-7 * found.times[0]), (found.times[-1], 1e-7 * found.times[0])):
        before, after = found.at(np.array([at - step, at + step]))[2]
        assert before == pytest.approx(after, rel=1e-3, abs=1e-5)


def test_a_law_without_dips_is_handed_back_as_it_is():
    law = law_with([16], 0.9)
    assert without_undershoot(law) is law


def test_the_same_z_over_a_finer_mesh_and_its_floor():
    law = law_with([16, 17], 0.2)
    finer = np.unique(np.concatenate([NODES, np.linspace(0.5, 0.6, 24)]))
    c, least = on_finer_mesh(law, finer)
    again, s = SplineLaw(finer, c, REST), np.linspace(NODES[0], NODES[-1], 3001)
    np.testing.assert_allclose(z_of(again, s), z_of(law, s), rtol=1e-9)
    assert len(least) == len(c) == len(finer) + 2
    # it comes from the nodes: never above their highest, never below their lowest
    z = FLOOR * law.z_at_nodes()
    assert z.min() - 1e-12 <= least.min() <= least.max() <= z.max() + 1e-12


def test_lowest_z_of_a_cell_is_the_least_at_its_probes():
    random = np.random.default_rng(7)
    nodes = np.cumsum(random.uniform(0.5, 2.0, 9))
    law = SplineLaw(nodes, random.uniform(0.5, 2.0, 11), (0.0, 0.0))
    for cell, told in enumerate(lowest_z(law)):
        s = nodes[cell] + law.inside * (nodes[cell + 1] - nodes[cell])
        s[-1] = np.nextafter(nodes[cell + 1], 0.0)
        assert told == pytest.approx(z_of(law, s).min(), rel=1e-9)


@pytest.mark.parametrize("at", [1.0, 1e3, -1e3])
def test_a_cell_is_too_short_to_be_cut_where_a_thousand_numbers_do_not_lie_in_it(at):
    unit = float(np.spacing(abs(at)))
    nodes = at + np.cumsum([0.0, 900.0 * unit, 1200.0 * unit, 0.0625])
    assert too_short(nodes).tolist() == [True, False, False]


@pytest.mark.parametrize("left", [1e-3, -0.05, -0.0869565])
@pytest.mark.parametrize("rest", [REST, (0.0, 0.0)])
def test_what_is_lost_in_dips_is_what_the_law_takes_longer_than_without_them(left, rest):
    """A search for a set-up ranks cheap plans by what is left."""
    even, law = law_with([16, 17], 1.0, rest), law_with([16, 17], left, rest)
    assert even.lost_in_dips() == 0.0 and law.lost_in_dips() > 0.0
    assert law.duration - law.lost_in_dips() == pytest.approx(even.duration, rel=0.2)
