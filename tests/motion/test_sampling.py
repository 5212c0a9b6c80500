"""Motion at many times takes little more memory than what is handed back, and its values are those of a few times."""

from __future__ import annotations

import threading
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
    assert len(blocks) == len(whole) and blocks.joints == whole.joints
    assert (blocks.times(np.arange(len(whole))) == whole.t).all()
    for begin, end in ((0, 100), (77, 412), (len(whole) - 3, len(whole))):
        assert blocks.rows(begin, end) == whole.rows(begin, end)
    some = np.array([3, 3, 500, len(whole) - 1])
    assert blocks.at(some) == whole.at(some)


def test_ctrl_c_ends_the_work_after_the_blocks_under_way(monkeypatch: pytest.MonkeyPatch, motion: tp.Trajectory):
    """Whoever presses it is heard in the main thread alone."""
    monkeypatch.setattr(sampling, "ROWS", 10)
    blocks, taken = sampling.Sampling(motion, 1e-4, on_grid=False), []

    def take(block: object) -> None:
        taken.append(block)
        if threading.current_thread() is threading.main_thread():
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        sampling.each_block(blocks, (take,), beside=(lambda: None,))
    assert len(taken) < len(blocks) / 20


def test_an_error_of_the_work_beside_blocks_is_raised(motion: tp.Trajectory):
    def work() -> None:
        raise ValueError("beside")

    with pytest.raises(ValueError, match="beside"):
        sampling.each_block(sampling.Sampling(motion, 1e-3, on_grid=False), (), beside=(work,))
