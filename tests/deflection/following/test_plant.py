"""A tool that bends, in the loop: how near the tip comes to its path, and when the loop gets unstable."""

from __future__ import annotations

import numpy as np
import pytest

from testbed.followed.cases import case
from testbed.followed.plant import Plant, below, critical, followed, grows, largest_root
from toolpace.common.arrays import Floats
from toolpace.deflection.following import Follower
from toolpace.deflection.following.settings import Figures

PERIOD, TURN = 1e-3, 10


def error_of(rho_told: float, gain: float, measured: bool = True) -> tuple[Floats, Floats]:
    """(n, 3) error from the cut's beginning on, and its mean over a turn of the spindle [um]."""
    arc, plant = case("arc on paper-ab", 0.1), Plant()
    follower = Follower(arc.trajectory, arc.machine, delay=plant.lag, gain=gain, rho=rho_told)
    error = 1e6 * followed(follower, plant, 4500, measured)[0][int(plant.start / PERIOD) :]
    return error, np.stack([np.convolve(column, np.full(TURN, 1.0 / TURN), "same") for column in error.T], axis=1)


@pytest.mark.parametrize(
    "gain, told", [pytest.param(0.05, 0.3, marks=pytest.mark.sweep), (Figures.gain, 0.0), (0.1, 0.0)]
)
def test_a_bent_tool_is_back_on_its_path_after_a_tenth_of_a_second(gain: float, told: float):
    error, mean = error_of(told, gain)
    after = round(0.1 / PERIOD)
    assert np.linalg.norm(mean[after]) <= 10.0
    assert np.sqrt((below(error[after:], 20.0, PERIOD) ** 2).sum(axis=1).mean()) <= 5.0


def test_blind_it_stays_bent():
    _, mean = error_of(0.0, 0.1, measured=False)
    assert np.linalg.norm(mean[200]) == pytest.approx(100.0, rel=0.05)


@pytest.mark.parametrize(
    "late, known, rho, told", [(5, 0, 0.0, 0.0), (10, 6, 0.0, 0.0), (1, 1, 0.9, 0.0), (5, 5, 0.0, 0.6)]
)
def test_the_loop_gets_unstable_at_the_gain_of_its_polynomial(late: int, known: int, rho: float, told: float):
    arc = case("arc on paper-ab", 0.1)
    follower = Follower(arc.trajectory, arc.machine)
    predicted = critical(lambda gain: largest_root(gain, late, known, rho, told) > 1.0, 1e-3, 2.0, 30)
    assert not grows(follower, 0.95 * predicted, late, known, rho, told)
    assert grows(follower, 1.05 * predicted, late, known, rho, told)
    if (known, rho, told) == (0, 0.0, 0.0):
        assert predicted == pytest.approx(2.0 * np.sin(np.pi / (2.0 * (2.0 * late + 1.0))), rel=1e-6)
    if late == known == 1:
        assert predicted == pytest.approx(2.0 / (1.0 + rho), rel=1e-6)
