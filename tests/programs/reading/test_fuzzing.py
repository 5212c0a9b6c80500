"""The fuzzer itself: what it must tell, that it finds what is hidden; and a few seconds of it on every dialect."""

from __future__ import annotations

import ast
import subprocess
import sys
import tempfile
import warnings

import numpy as np
import pytest

from testbed.fuzz import coverage, oracle
from testbed.fuzz.campaign import Campaign
from testbed.fuzz.oracle import Wrong, tried
from testbed.fuzz.targets import Target
from tests.support.tool_paths import toolpath_through
from toolpace.common.errors import ProgramError


def sound():
    return toolpath_through([[0, 0, 0], [1, 0, 0], [1, 1, 0]], [[0, 0, 1]] * 3)


def crash():
    raise KeyError("X")


def warn():
    warnings.warn("overflow", RuntimeWarning, stacklevel=1)


def long_message():
    raise ProgramError("x" * 5000)


def endless():
    while True:
        pass


def unbounded():
    return len(bytearray(200_000_000)) and None


def not_finite():
    path = sound()
    path.tip.flags.writeable = True
    path.tip[1, 1] = np.nan
    return path


@pytest.mark.parametrize(
    "read, kind",
    [
        (crash, "KeyError"),
        (warn, "RuntimeWarning"),
        (long_message, "long message"),
        (endless, "no end"),
        (unbounded, "memory"),
        (not_finite, "a path that is not sound: finite"),
    ],
)
def test_what_must_not_be_is_told(read, kind, monkeypatch):
    monkeypatch.setattr(oracle, "SECONDS", 0.1)
    with pytest.raises(Wrong) as caught:
        tried(read, weighed=100 if kind == "memory" else 0)
    assert caught.value.kind.startswith(kind)


def test_errors_of_the_library_and_sound_paths_are_none():
    error = ProgramError("no motion")

    def refuse():
        raise error

    assert tried(refuse) is error
    assert tried(sound, weighed=100) is None


def test_every_branch_is_counted():
    text = "def f(x):\n    'doc'\n    if x:\n        return 1\n    for _ in range(3):\n        pass\n    return 2\n"
    space: dict = {coverage.NAME: [0] * coverage.MOST}
    first = coverage.branches()
    tree = ast.fix_missing_locations(coverage._Counted().visit(ast.parse(text)))
    exec(compile(tree, "text", "exec"), space)
    assert coverage.branches() - first == 4
    taken = space[coverage.NAME]
    assert space["f"](0) == 2 and sorted(taken[first : first + 4]) == [0, 1, 1, 3]
    assert space["f"](1) == 1 and sum(taken) == 5 + 2


def test_what_is_hidden_behind_branches_is_found(monkeypatch):
    """Three letters one after the other, each found by the branch that it takes."""
    monkeypatch.setattr(coverage, "_known", 4)

    def read(data, asked, weighed):
        for depth in range(4):
            coverage.TAKEN[depth] += 1
            if data[:depth] != b"BUG"[:depth]:
                return
        raise Wrong("hidden")

    monkeypatch.setattr(Target, "seeds", lambda self: [b"G1 X1\n"])
    campaign = Campaign(
        Target("hidden", read, tuple(bytes([letter]) for letter in b"ABCDEFGHIJKLMNOPQRSTUVWXYZ")), seed=1
    )
    campaign.run(5.0, lambda text: None, enough=lambda: bool(campaign.found))
    assert list(campaign.found) == ["hidden"] and campaign.found["hidden"].data == b"BUG"
    coverage.features()


@pytest.mark.thorough
def test_a_few_seconds_of_every_dialect():
    with tempfile.TemporaryDirectory() as out:
        command = [sys.executable, "-m", "testbed.fuzz", "all", "--seconds", "1.5", "--seed", "1", "--out", out]
        done = subprocess.run(command, capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.count(", 0 wrong") == 12
