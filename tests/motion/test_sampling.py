"""Motion at many times takes little more memory than what is handed back, and its values are those of a few times."""

from __future__ import annotations

import tracemalloc

import numpy as np
import pytest

import toolpace as tp
from toolpace.motion import trajectory as module


@pytest.fixture(scope="module")
def motion() -> tp.Trajectory:
    return tp.plan(tp.Path.paper_arc(), tp.Machine.load("paper-ab"), bound=False)


def test_derivatives_of_the_path_are_held_of_some_times_only(monkeypatch: pytest.MonkeyPatch, motion: tp.Trajectory):
    """Of all times at once they take four times as much memory as what is asked for."""
    monkeypatch.setattr(module, "CHUNK", 1000)
    t = np.linspace(0.0, motion.duration, 50_000)
    motion.at(t[:10])
    tracemalloc.start()
    found = motion.at(t)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 1.5 * (found.q.nbytes + found.qd.nbytes + found.qdd.nbytes + found.qddd.nbytes)


def test_in_pieces_the_values_are_the_same(monkeypatch: pytest.MonkeyPatch, motion: tp.Trajectory):
    whole = motion.sample(1e-3)
    monkeypatch.setattr(module, "CHUNK", 77)
    assert motion.sample(1e-3) == whole
