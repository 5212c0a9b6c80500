"""The look between the nodes: feeds told by five places of a cell, and what is looked at again."""

from __future__ import annotations

import numpy as np
import pytest

from testbed.jets import harmonics, path_of
from tests.support.bends import bend, limits_of
from toolpace.machine.limits import Limits
from toolpace.motion.laws import SplineLaw
from toolpace.planning.path_at_probes import BENT, caps_between
from toolpace.planning.peaks import CLOSELY, VAGUE_ABOVE, LimitCheck, between

INSIDE = np.linspace(0.0, 1.0, 17)


@pytest.mark.parametrize("seed", range(5))
def test_caps_between_are_those_of_a_polynomial_of_the_fourth_degree(seed):
    """The square of the inverse of the cap; how far it is from the third degree is its fourth difference."""
    of_cell = np.random.default_rng(seed).uniform(-0.2, 0.2, (7, 5))
    of_cell[:, 4] = 2.0
    of_cell[0, 0] = 0.0

    def cap(x):
        return np.stack([1.0 / np.sqrt(np.polyval(each, x)) for each in of_cell])

    told, bend = caps_between(cap(np.linspace(0.0, 1.0, 5)).T, INSIDE)
    np.testing.assert_allclose(told, cap(INSIDE), rtol=1e-9)
    least = (1.0 / cap(np.linspace(0.0, 1.0, 5)) ** 2).min(axis=1)
    np.testing.assert_allclose(bend, np.abs(of_cell[:, 0]) * 24.0 / 4.0**4 / least, atol=1e-12)
    assert bend[0] <= BENT < bend[1:].max()


def test_a_feed_of_a_smooth_cap_is_used_as_it_is():
    """Told by five places of each cell or asked at every probe: the usage of the feed is the same."""

    def speed_cap(s):
        return 1.0 / np.sqrt(2.0 + np.sin(7.0 * s))

    run = path_of(harmonics(np.random.default_rng(3), 2), speed_cap=speed_cap).runs[0]
    limits = Limits([1e3] * 2, [1e6] * 2, [1e9] * 2)
    nodes = np.linspace(0.01, 0.99, 99)
    law = SplineLaw(nodes, np.full(101, 0.5), (0.0, 0.0))
    asked = LimitCheck(run, limits, nodes).peaks_in(law, np.arange(98))
    run.smooth_cap = True
    told = LimitCheck(run, limits, nodes).peaks(law)
    np.testing.assert_allclose(told.used[:, 0], asked.used[:, 0], rtol=1e-6)
    middle = (nodes[:-1] + nodes[1:]) / 2.0
    np.testing.assert_allclose(told.used[:, 0], np.sqrt(0.5) / speed_cap(middle), rtol=0.05)


@pytest.mark.parametrize("seed", range(8))
def test_what_is_confirmed_is_nowhere_less_than_many_probes_show(seed):
    """In cells in which the path bends unseen and a limit is nearly used, or passed: the look that the guard trusts."""
    random = np.random.default_rng(seed)
    run, limits = bend(random, 10.0 ** random.uniform(-4.0, -2.0), 2)[0].runs[0], limits_of(random, 2)
    nodes = np.linspace(0.01, 0.99, 30)
    law = SplineLaw(nodes, np.full(32, 0.05), (0.0, 0.0))
    look = LimitCheck(run, limits, nodes)
    peaks = look.peaks(law)
    used = look.confirmed(law, peaks).used
    near = np.flatnonzero(look.path.unlike & (peaks.used.max(axis=1) > VAGUE_ABOVE))
    assert len(near)
    probed = SplineLaw(law.nodes, law.c, law.rest)
    probed.inside = between(CLOSELY)
    assert (used[near] >= look.peaks_in(probed, near).used * (1.0 - 1e-9)).all()
    assert (used >= peaks.used).all()
