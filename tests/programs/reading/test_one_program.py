"""One program, written in every dialect by a generator with a model of its own, is one motion to each reader."""

from __future__ import annotations

import numpy as np
import pytest

from testbed.one_program.compare import difference
from testbed.one_program.generate import generate
from testbed.one_program.run import WRITERS, read, tried


def faults(dialect: str, seeds: range) -> list[str]:
    """Seeds whose motion differs, and how."""
    outcomes = [(seed, tried(dialect, seed)) for seed in seeds]
    assert sum(bool(outcome.text) for _, outcome in outcomes) > len(seeds) // 3
    return [f"{seed}: {outcome.fault}" for seed, outcome in outcomes if outcome.fault]


@pytest.mark.parametrize("dialect", WRITERS)
def test_what_is_written_is_read(dialect):
    assert faults(dialect, range(4)) == []


@pytest.mark.sweep
@pytest.mark.parametrize("dialect", WRITERS)
def test_what_is_written_is_read_of_many(dialect):
    assert faults(dialect, range(1000, 1020)) == []


@pytest.mark.thorough
@pytest.mark.parametrize("dialect", WRITERS)
def test_what_is_written_is_read_of_a_thousand(dialect):
    assert faults(dialect, range(1000)) == []


def shifted(move):
    move.end = move.end + np.array([0.0, 1e-5, 0.0])


def hurried(move):
    move.seconds *= 1.000001


def turned(move):
    move.rotary = move.rotary[0], move.rotary[1] + 1e-5


def halted(move):
    move.stop = not move.stop


def waited(move):
    move.dwell += 1e-6


def rushed(move):
    move.rapid = not move.rapid


@pytest.mark.parametrize("change", [shifted, hurried, turned, halted, waited, rushed])
def test_the_comparison_notices(change):
    """Each kind of difference, in the last motion at feed of a program that is right."""
    writer = WRITERS["linuxcnc"](generate(1))
    path = read(writer, writer.write())
    assert difference(path, writer.world) == ""
    change([move for move in writer.world.moves[1:-1] if not move.rapid and move.circle is None][-1])
    assert difference(path, writer.world) != ""
