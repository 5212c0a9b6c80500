"""The ladder of guarantees, and that what users are promised is its top."""

from __future__ import annotations

import re
from itertools import pairwise
from pathlib import Path

import pytest

from toolpace.planning import limit_tolerances

README = Path(__file__).parents[2] / "README.md"


RUNGS = {name: value for name, value in vars(limit_tolerances).items() if name.isupper()}


def test_every_rung_is_below_the_one_above_it():
    """What a stage leaves is seen by the next one: each needs room for rounding between the two."""
    named = limit_tolerances
    ladder = [named.PROMISED, named.GUARANTEE, named.DETOUR, named.ALLOWED, named.BRED, 1.0]
    assert all(above - below > 5e-6 for above, below in pairwise(ladder))


def test_an_interval_of_a_detour_is_kept_up_to_what_a_detour_may_use():
    assert pytest.approx(limit_tolerances.DETOUR, abs=1e-12) == limit_tolerances.KEPT_INTERVAL


@pytest.mark.parametrize("name", RUNGS)
def test_no_rung_lies_above_the_promise_or_within_the_limit(name):
    assert 1.0 < RUNGS[name] <= limit_tolerances.PROMISED


def test_readme_promises_what_is_kept():
    words = re.sub(r"\s+", " ", README.read_text(encoding="utf-8"))
    promise = re.search(r"No axis exceeds its velocity, acceleration or jerk limit, .{,80} more than (\S+) of", words)
    assert promise is not None
    assert 1.0 + float(promise[1]) == limit_tolerances.PROMISED
