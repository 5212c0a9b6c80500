"""The lower bound against the best of several starts, and of IPOPT, on the same mesh: a thousand random problems."""

from __future__ import annotations

import pytest

pytest.importorskip("casadi")
from testbed.bound_check import ROUNDING, check


@pytest.mark.parametrize("seed", range(7000, 7006))
def test_bound_is_never_above_the_best(seed):
    assert check(seed).margin >= -ROUNDING


@pytest.mark.parametrize(
    "first",
    [
        pytest.param(first, marks=pytest.mark.sweep if first < 20_100 else pytest.mark.thorough)
        for first in range(20_000, 21_000, 50)
    ],
)
def test_bound_is_never_above_the_best_on_a_thousand(first):
    done = [check(seed) for seed in range(first, first + 50)]
    assert min(one.margin for one in done) >= -ROUNDING
    assert max(one.behind for one in done) <= 1e-4, "IPOPT found a better motion"
