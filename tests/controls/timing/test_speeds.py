"""The speeds that a control reaches: the highest of a way, from its mean and from those beside it."""

from __future__ import annotations

import numpy as np
import pytest

import toolpace as tp
from toolpace.controls.timing.figures import figures_of
from toolpace.controls.timing.speeds import ControlSpeeds, highest_speeds


def rest_to_rest(length, most, acceleration, jerk):
    """Time and highest speed of a way from rest to rest (Biagiotti and Melchiorri 2008, section 3.4)."""
    if most * jerk < acceleration**2:
        ramp = 2.0 * np.sqrt(most / jerk)
    else:
        ramp = most / acceleration + acceleration / jerk
    assert length > most * ramp
    return length / most + ramp


@pytest.mark.parametrize("jerk", [np.inf, 50.0, 0.5])
def test_a_long_way_from_rest_to_rest_reaches_its_feed(jerk):
    time = rest_to_rest(0.5, 0.05, 2.0, jerk)
    found = highest_speeds(
        np.array([0.5 / time]), np.array([time]), np.array([0.05]), np.array([True]), np.array([2.0]), np.array([jerk])
    )
    assert found[0] == pytest.approx(0.05, rel=1e-3)


def test_a_short_way_from_rest_to_rest_reaches_what_its_acceleration_lets_it():
    length, acceleration = 1e-3, 2.0
    time = 2.0 * np.sqrt(length / acceleration)
    each = (np.array([value]) for value in (length / time, time, 0.5))
    found = highest_speeds(*each, np.array([True]), np.array([acceleration]), np.array([np.inf]))
    assert found[0] == pytest.approx(np.sqrt(length * acceleration), rel=1e-6)


def test_short_ways_at_one_speed_have_that_speed():
    count = 20
    mean, times = np.full(count, 0.02), np.full(count, 0.01)
    rests = np.zeros(count, dtype=bool)
    found = highest_speeds(mean, times, np.full(count, 0.5), rests, np.full(count, 2.0), np.full(count, 50.0))
    np.testing.assert_allclose(found[1:-1], 0.02, rtol=1e-9)


@pytest.mark.parametrize("model", ["linuxcnc", "lookahead"])
def test_the_feed_is_reached_on_a_long_block_and_missed_on_short_ones(model):
    steps = "".join(f"X{0.5 * k:g} Y{0.5 * (k % 2):g}\n" for k in range(1, 40))
    machine = tp.Machine.load("xyzac-trunnion")
    toolpath = tp.read_text(f"G21 G90\nG0 X0 Y0 Z0\nG1 X-80 F600\nX0\nF30000\n{steps}M30\n", machine, controller="iso")
    found = ControlSpeeds.of(toolpath, machine, figures_of({}, "", model))
    long, short = toolpath.block == 3, toolpath.block > 6
    assert found.highest[long].max() == pytest.approx(0.01, rel=2e-3)
    assert found.highest[short].max() < 0.5 * 0.5
    assert (found.mean <= found.highest * (1.0 + 1e-12)).all()
    assert (found.highest[1:] <= toolpath.most_speed[1:] * (1.0 + 1e-12)).all()
