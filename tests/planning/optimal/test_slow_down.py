"""A law slowed down about the places that exceed a limit by little."""

from __future__ import annotations

import numpy as np
import pytest

from testbed.jets import harmonics, path_of
from toolpace.common.workers import Workers
from toolpace.kernels.optimal.slow_down import CURVATURE, SLOPE, WIDEST, slow_down
from toolpace.machine.limits import Limits
from toolpace.motion.laws import SplineLaw
from toolpace.planning.limit_tolerances import GUARANTEE
from toolpace.planning.mesh.initial_guess import ramp_time
from toolpace.planning.optimal.planner import fastest_law
from toolpace.planning.optimal.slow_down import SlowDown, in_place, slowed_in_place
from toolpace.planning.peaks import LimitCheck, largest

TIMES = np.linspace(0.0, 100.0, 1001)
RAMP = 1.0
PLACE = 500


def about_a_place(motion, strained=(), loss=1e-4):
    """Shares that are left and their cost where one cell of a long motion of one joint is slowed down."""
    losses, marks = np.zeros(1000), np.zeros(1000, dtype=bool)
    losses[PLACE], marks[list(strained)] = loss, True
    used = np.ones((3, 1001, 1)) * np.reshape(motion, (3, 1, 1))
    return slow_down(TIMES, losses, used, np.ones(1), np.ones(1), RAMP, marks)


def test_a_flank_is_as_short_as_what_is_left_of_the_limits_allows():
    """Half used: the shortest; at the limit: the widest; and its polynomial is as steep and as bent as is told."""
    short, cheap = about_a_place([0.5, 0.5, 0.5])
    assert np.flatnonzero(short < 1.0).tolist() == list(range(PLACE - 19, PLACE + 23)), "two ramp times"
    assert short[PLACE : PLACE + 4] == pytest.approx(1.0 - 1e-4, abs=1e-12)
    wide, dear = about_a_place([0.5, 0.5, 1.0])
    reach = TIMES[np.flatnonzero(wide < 1.0)[-1] - 2] - TIMES[PLACE]
    assert reach == pytest.approx(WIDEST * RAMP, abs=0.3) and dear.sum() > 5.0 * cheap.sum()
    flank = short[PLACE + 3 : PLACE + 24] - 1.0
    first, second = np.diff(flank) / 0.1, np.diff(flank, 2) / 0.01
    assert np.abs(first).max() == pytest.approx(2.0 * SLOPE * 1e-4 / 2.0, rel=0.02)
    assert np.abs(second).max() == pytest.approx(2.0 * CURVATURE * 1e-4 / 4.0, rel=0.1)


def test_no_short_flank_lies_on_a_strained_cell():
    short, _ = about_a_place([0.5, 0.5, 0.5])
    left, _ = about_a_place([0.5, 0.5, 0.5], strained=[PLACE + 15])
    assert np.array_equal(left[:PLACE], short[:PLACE]) and (left < 1.0).sum() > (short < 1.0).sum() + 150


def test_the_cheapest_places_are_slowed_down_and_the_dear_ones_left():
    above = np.array([1, 1, 0, 1, 0, 1, 0, 0], dtype=bool)
    cost = np.array([3.0, 0.0, 0.0, 1.0, 0.0, 2.0, 0.0, 0.0])
    slow = SlowDown(np.ones(11), cost, above)
    for allowance, dear in ((0.5, [0, 1, 3, 5]), (1.0, [0, 1, 5]), (3.5, [0, 1]), (6.0, [])):
        assert np.flatnonzero(slow.dear(allowance)).tolist() == dear, allowance


@pytest.mark.parametrize("seed", range(6))
def test_a_law_that_is_too_fast_at_some_places_is_slowed_down_there_at_the_cost_that_is_told(seed):
    """Three places by up to 5e-4 of z; far from them it stays as it is to the last digit."""
    random = np.random.default_rng(seed)
    run, limits = path_of(harmonics(random, 3)).runs[0], Limits([1.0] * 3, [5.0] * 3, [200.0] * 3)
    held, _ = fastest_law(run, limits, 400)
    c, k = held.c.copy(), np.arange(len(held.c))
    for place in random.choice(np.arange(40, 360), 3, replace=False):
        c *= 1.0 + 10.0 ** random.uniform(-4.0, -3.3) * np.exp(-(((k - place) / 10.0) ** 2))
    fast, look = SplineLaw(held.nodes, c, held.rest), LimitCheck(run, limits, held.nodes)
    peak, ramp = look.peaks(fast).used, ramp_time(limits)
    assert (largest(peak) > GUARANTEE).any()
    slow = in_place(look, fast, peak, ramp)
    found = slowed_in_place(look, fast, peak, ramp, Workers())
    assert found is not None
    assert LimitCheck(run, limits, held.nodes).peaks(found).used.max() <= GUARANTEE
    assert found.duration - fast.duration == pytest.approx(slow.cost.sum(), rel=1e-2)
    assert (found.c == fast.c).sum() > 250
