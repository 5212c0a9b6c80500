"""The exit code is 0 for nothing but a motion that keeps every limit, at the set-points and between them."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from toolpace.jobs import plan_steps
from toolpace.results.write.plan_json import UsageRecord


def record(kind, value):
    usage = {"feed": 0.5, "velocity": {"X": 0.5}, "acceleration": {"X": 0.5}, "jerk": {"X": 0.5}}
    usage[kind] = value if kind == "feed" else {"X": 0.4, "C": value}
    return SimpleNamespace(usage=UsageRecord(**usage))


@pytest.mark.parametrize("kind", ["feed", "velocity", "acceleration", "jerk"])
@pytest.mark.parametrize(("value", "code"), [(0.5, 0), (1.0, 0), (1.0001, 0), (1.00011, 1), (1.001, 1), (2.0, 1)])
def test_a_limit_that_is_passed_between_the_set_points_ends_with_1(kind, value, code):
    assert plan_steps.exit_code(record(kind, value), SimpleNamespace(ok=True)) == code
    assert plan_steps.exit_code(record(kind, value), SimpleNamespace(ok=False)) == 1


def test_jerk_that_nothing_bounds_ends_with_1():
    assert plan_steps.exit_code(record("jerk", None), SimpleNamespace(ok=True)) == 1
