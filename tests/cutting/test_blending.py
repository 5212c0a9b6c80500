"""What jumps is made smooth: bounds, sums, symmetry; the judge's own against it."""

from __future__ import annotations

import numpy as np
import pytest

from toolpace.cutting.prediction import CHUNK, blended, needed
from toolpace.judge.bent_tip import blended as judged

LENGTH = 4e-3


def ways(seed=0, count=3000, step=6e-5):
    rng = np.random.default_rng(seed)
    way = np.concatenate([[0.0], np.cumsum(rng.uniform(0.2 * step, step, count))])
    way[700:705] = way[700]  # places that stand twice
    return way


def test_a_step_is_built_up_over_the_length_and_half_in_the_middle():
    way = np.linspace(0.0, 0.02, 4001)
    value = np.where(way[1:] > 0.01, 1.0, 0.0)[:, None]
    found = blended(way, value, LENGTH)[:, 0]
    assert not found[way < 0.01 - 0.5 * LENGTH - 2e-5].any()
    inside = (way > 0.01 + 0.5 * LENGTH) & (way < 0.02 - 0.5 * LENGTH)
    np.testing.assert_allclose(found[inside], 1.0, atol=1e-12)
    assert found[2000] == pytest.approx(0.5, abs=2e-3) and found[-1] == pytest.approx(0.5, abs=2e-3)
    assert (np.diff(found[:3000]) >= -1e-13).all()
    # a quadratic B-spline, three times a third of the length: its share up to a sixth of it is known
    x = 0.01 + LENGTH / 6.0
    assert np.interp(x, way, found) == pytest.approx(0.5 + 0.75 * 0.5 - 0.5**3 / 3.0, abs=1e-4)


@pytest.mark.parametrize("seed", range(5))
def test_whatever_jumps_slopes_and_bends_are_bounded(seed):
    rng = np.random.default_rng(seed)
    way = np.linspace(0.0, 0.05, 10_001)
    value = np.repeat(rng.choice([-1.0, 0.0, 1.0], 200), 50)[:, None]
    found, h = blended(way, value, LENGTH)[:, 0], way[1]
    assert np.abs(found).max() <= 1.0 + 1e-12
    assert np.abs(np.diff(found)).max() / h <= 4.5 / LENGTH * (1.0 + 1e-6)
    assert np.abs(np.diff(found, 2)).max() / h**2 <= 36.0 / LENGTH**2 * (1.0 + 1e-3)


def test_nothing_is_lost_on_the_way():
    """The mean over all of the way is kept where the ends are far."""
    way = ways()
    value = np.zeros((3000, 3))
    value[1200:2000] = np.random.default_rng(1).normal(size=(800, 3))
    found = blended(way, value, LENGTH)
    whole = (value * np.diff(way)[:, None]).sum(axis=0)
    kept = (0.5 * (found[1:] + found[:-1]) * np.diff(way)[:, None]).sum(axis=0)
    np.testing.assert_allclose(kept, whole, atol=2e-3 * np.abs(value).max() * LENGTH)


def test_the_judge_blends_alike_in_another_way():
    way = ways(3)
    value = np.zeros((3000, 3))
    value[100:900], value[2400:], value[950:1000] = [1.0, 2.0, -3.0], [2.0, -1.0, 0.5], [-1.0, 0.0, 1.0]
    np.testing.assert_allclose(judged(way, value, LENGTH), blended(way, value, LENGTH), atol=3e-3)
    assert not judged(way, np.zeros((3000, 3)), LENGTH).any()


def test_few_places_are_kept_and_between_them_it_is_straight():
    rng = np.random.default_rng(2)
    way = np.cumsum(rng.uniform(1e-5, 1e-4, 5000))
    value = np.zeros((5000, 3))
    value[1000:4000, 0] = 5e-5 * np.sin(2.0 * np.pi * way[1000:4000] / 0.03)
    value[:, 1] = 1e-3 * way
    fixed = np.zeros(5000, dtype=bool)
    fixed[[7, 8, 2500]] = True
    kept = needed(way, value, fixed, 1e-7)
    straight = np.stack([np.interp(way, way[kept], column) for column in value[kept].T], axis=1)
    assert np.linalg.norm(straight - value, axis=1).max() <= 1e-7
    assert {0, 7, 8, 2500, 4999} <= set(kept.tolist()) and 5000 / CHUNK < len(kept) < 1500
    assert (np.diff(kept) > 0).all()
