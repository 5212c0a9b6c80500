"""Work on all cores: nothing lost, errors first, and word of how far it is."""

from __future__ import annotations

import os
import threading

import pytest

from toolpace.common.workers import CallersProgress, Progress, Workers, side_by_side


@pytest.fixture
def two_cores(monkeypatch):
    """Who asks for work, and one helper."""
    monkeypatch.setattr(os, "cpu_count", lambda: 2)


def test_results_come_in_the_order_of_the_runs():
    assert side_by_side(lambda k, workers, progress: k * k, [1.0] * 20) == [k * k for k in range(20)]


def test_progress_of_many_runs_never_falls_and_ends_at_one():
    seen = []
    side_by_side(lambda k, workers, progress: progress(1.0), [0.25] * 4, seen.append)
    assert seen[-1] == 1.0 and seen == sorted(set(seen))


def test_progress_of_parts_adds_up_by_their_weights():
    seen = []
    first, second = Progress(seen.append).split([3.0, 1.0])
    first(0.5)
    second(1.0)
    second(0.2)
    first.part(0.5, 1.0)(1.0)
    assert seen == [0.375, 0.625, 0.625, 1.0]


def test_word_of_the_last_piece_is_passed_on_when_a_helper_has_it(two_cores):
    seen, owner = [], threading.get_ident()
    told = CallersProgress(seen.append)
    parts = told.split([0.5, 0.5])
    together, owner_is_done = threading.Barrier(2), threading.Event()

    def work(k):
        # one piece for each of the two, and the helper ends last
        together.wait()
        if threading.get_ident() != owner:
            owner_is_done.wait()
        parts[k](1.0)
        if threading.get_ident() == owner:
            owner_is_done.set()

    Workers(told).each(work, range(2))
    assert seen == [0.5, 1.0]


def test_an_error_in_a_piece_stops_the_others(two_cores):
    """The helper is in the midst of a piece when the error comes: it ends that piece, and takes no other."""
    done, owner = [], threading.get_ident()
    together, waited_for = threading.Barrier(2), threading.Event()

    class Waiting(CallersProgress):
        """Its owner looks at it while he waits for the helper."""

        def pulse(self):
            waited_for.set()

    def work(k):
        together.wait()
        if threading.get_ident() == owner:
            raise ValueError("the owner's")
        waited_for.wait()
        done.append(k)

    with pytest.raises(ValueError, match="the owner's"):
        Workers(Waiting(None)).each(work, range(1000))
    assert len(done) == 1


def test_work_within_work_comes_to_an_end():
    workers = Workers()
    sums = workers.each(lambda k: sum(workers.each(lambda i: i * k, range(20))), range(20))
    assert sums == [190 * k for k in range(20)]
