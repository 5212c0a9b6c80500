"""What the summary says of an effort is what the plan came to."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from toolpace.cli.summary import rounds_in_words


@pytest.mark.parametrize(
    ("durations", "plan", "words"),
    [
        ([10.0, 9.0, 8.0], 8.5, "high: 2 iterations of path and speed, 15.0 % less time than the first path"),
        ([10.0, 9.0], 10.1, "high: 1 iteration of path and speed, no less time than the first path"),
        ([10.0], 10.0, "high: no iterations of path and speed, no less time than the first path"),
    ],
)
def test_the_effort_in_words(durations, plan, words):
    rounds = [SimpleNamespace(duration_s=each) for each in durations]
    assert rounds_in_words(SimpleNamespace(effort="high", duration_s=plan, rounds=rounds)) == words
