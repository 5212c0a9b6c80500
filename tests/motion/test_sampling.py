"""Motion at many times takes little more memory than what is handed back, and its values are those of a few times."""

from __future__ import annotations

import tracemalloc

import numpy as np
import pytest

import toolpace as tp
from toolpace.motion import sampling, trajectory


@pytest.fixture(scope="module")
def motion() -> tp.Trajectory:
    return tp.plan(tp.Path.paper_arc(), tp.Machine.load("paper-ab"), bound=False)


def test_derivatives_of_the_path_are_held_of_some_times_only(monkeypatch: pytest.MonkeyPatch, motion: tp.Trajectory):
    """Of all times at once they take four times as much memory as what is asked for."""
    monkeypatch.setattr(trajectory, "ROWS", 1000)
    t = np.linspace(0.0, motion.duration, 50_000)
    motion.at(t[:10])
    tracemalloc.start()
    found = motion.at(t)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 1.5 * (found.q.nbytes + found.qd.nbytes + found.qdd.nbytes + found.qddd.nbytes)


def test_in_pieces_the_values_are_the_same(monkeypatch: pytest.MonkeyPatch, motion: tp.Trajectory):
    whole = motion.sample(1e-3)
    monkeypatch.setattr(sampling, "ROWS", 77)
    assert motion.sample(1e-3) == whole


def test_a_sampling_that_is_taken_in_blocks_is_that_of_all_at_once(motion: tp.Trajectory):
    whole, blocks = motion.sample(1e-3), sampling.Sampling(motion, 1e-3, on_grid=False)
    assert len(blocks) == len(whole) and blocks.joints == whole.joints and (blocks.t == whole.t).all()
    for begin, end in ((0, 100), (77, 412), (len(whole) - 3, len(whole))):
        assert blocks.rows(begin, end) == whole.rows(begin, end)
    some = np.array([3, 3, 500, len(whole) - 1])
    assert blocks.at(some) == whole.at(some)
