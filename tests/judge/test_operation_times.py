"""Times of operations between the least and the most that they can be: worked out by hand, waits at each point."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.support.tool_paths import toolpath_through
from toolpace.judge.passage_times import OperationFigures, Passages

WAYS = (1.0, 2.0, 4.0)
"""How long the three ways take [s]: at feed, at rapid, at feed."""
POINTS = 4
DT = 1e-3


def operation(dwells, cutting_s, rapid_s):
    """What plan.json says of the one operation, and the judge's figures of it: points passed when they are by hand."""
    straight = np.zeros((POINTS, 3))
    straight[:, 0] = np.arange(POINTS) * 0.01
    path = toolpath_through(straight, np.tile([0.0, 0.0, 1.0], (POINTS, 1)), stops=[1, 2], dwells=dwells)
    path = replace(path, feed=np.array([0.05, 0.05, np.inf, 0.05]), rapid=np.arange(POINTS) == 2)
    wait = np.array([dwells.get(point, 0.0) for point in range(POINTS)])
    arrival = np.concatenate([[0.0], np.cumsum(np.array(WAYS) + wait[:-1])])
    one = {
        "name": "", "tool": "", "stops": 2, "dwell_s": wait.sum(), "cutting_s": cutting_s, "rapid_s": rapid_s,
        "time_s": wait.sum() + cutting_s + rapid_s,
    }  # fmt: skip
    said = {"operations": [one], "duration_s": one["time_s"]} | {
        kind: one[kind] for kind in ("cutting_s", "rapid_s", "dwell_s")
    }
    return OperationFigures(said, path, Passages(arrival, arrival + wait), DT)


@pytest.mark.parametrize("dwells", [{}, *({point: 0.5} for point in range(POINTS)), dict.fromkeys(range(POINTS), 0.7)])
def test_a_right_plan_with_a_wait_anywhere_is_right(dwells):
    checks = operation(dwells, WAYS[0] + WAYS[2], WAYS[1]).checks()
    assert len(checks) == 2 and all(check.ok for check in checks), checks


@pytest.mark.parametrize("point", range(POINTS))
@pytest.mark.parametrize("moved", [-0.3, 0.3])
def test_time_at_feed_that_was_time_at_rapid_is_found(point, moved):
    checks = operation({point: 0.5}, WAYS[0] + WAYS[2] + moved, WAYS[1] - moved).checks()
    assert [check.ok for check in checks] == [True, False]


def test_a_part_of_less_than_no_time_is_found_although_the_sums_are_right():
    checks = operation({1: 0.5}, WAYS[0] + WAYS[1] + WAYS[2] + 1.0, -1.0).checks()
    assert not checks[0].ok
