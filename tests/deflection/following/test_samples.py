"""The feed of samples is that of the tip, whatever the parameter of the path is counted in."""

from __future__ import annotations

import numpy as np
import pytest

import toolpace as tp
from toolpace.deflection.following.samples import followed_joints_of, samples_of

FEED = 0.01
KNOTS = np.r_[np.zeros(4), 0.5, np.ones(4)]
LEAN = np.array([[0.0, 0.1, 1.0], [0.1, 0.1, 1.0], [0.1, 0.3, 1.0], [0.2, 0.3, 1.0], [0.3, 0.2, 1.0]])


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
@pytest.mark.parametrize("moves", [True, False])
def test_a_tip_that_moves_has_its_feed_and_one_that_stands_has_none(scale: float, moves: bool):
    way = np.arange(5.0)[:, None] * [0.02, 0.01, 0.0]
    tip = 0.1 + (way if moves else 0.0 * way)
    machine = tp.Machine.load("xyzbc-head")
    path = tp.Path.from_bspline(KNOTS * scale, tip, tip + 0.1 * LEAN, 3, FEED)
    trajectory = tp.plan(path, machine, bound=False, mesh=60)
    samples = samples_of(trajectory, followed_joints_of(machine, machine.joints), 8e-3, 1.0)
    assert np.abs(np.diff(samples.q, axis=0)).max() > 1e-5
    if not moves:
        assert (samples.feed == np.inf).all()
        return
    assert samples.feed == pytest.approx(FEED, rel=1e-6)
