"""Work on all cores: nothing lost, errors first, and word of how far it is."""

from __future__ import annotations

import os
import threading

import numpy as np
import pytest

from toolpace.workers import Crew, Tally


def test_progress_of_many_runs_ends_at_one():
    seen = []
    tally = Tally(seen.append, [0.25] * 4)
    crew = Crew(tally)
    crew.aside(lambda: crew.each(lambda k: tally.of(k)(1.0), range(4)))
    assert seen[-1] == 1.0 and (np.diff(seen) > 0.0).all()


def test_word_of_the_last_piece_is_passed_on_when_a_helper_has_it(monkeypatch):
    monkeypatch.setattr(os, "cpu_count", lambda: 2)
    seen, owner = [], threading.get_ident()
    tally = Tally(seen.append, [0.5, 0.5])
    together, owner_is_done = threading.Barrier(2), threading.Event()

    def work(k):
        # one piece for each of the two, and the helper ends last
        together.wait()
        if threading.get_ident() != owner:
            owner_is_done.wait()
        tally.of(k)(1.0)
        if threading.get_ident() == owner:
            owner_is_done.set()

    Crew(tally).each(work, range(2))
    assert seen == [0.5, 1.0]


def test_an_error_in_a_piece_stops_the_others(monkeypatch):
    """The helper is in the midst of a piece when the error comes: it ends that piece, and takes no other."""
    monkeypatch.setattr(os, "cpu_count", lambda: 2)
    done, owner = [], threading.get_ident()
    together, waited_for = threading.Barrier(2), threading.Event()

    class Waiting(Tally):
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
        Crew(Waiting(None, [1.0])).each(work, range(1000))
    assert len(done) == 1


def test_work_within_work_comes_to_an_end():
    crew = Crew()
    sums = crew.each(lambda k: sum(crew.each(lambda i: i * k, range(20))), range(20))
    assert sums == [190 * k for k in range(20)]
