"""The closer look: nothing between states escapes it, wherever on the parameter and in whatever units."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.special import erf

from toolpace.machine.limits import Limits
from toolpace.motion.laws import ClockLaw, Probe
from toolpace.motion.usage import closer_look, gained_in_a_ramp, stretches_unseen
from toolpace.path.axis_run import AxisRun

LIMITS = Limits([1.0, 1.0], [10.0, 10.0], [1e3, 1e3])
AT, WIDTH, HIGH = 0.437, 2e-4, 3.0


class Swerve(AxisRun):
    """Two joints at an even speed, one of which swerves aside within a thousandth of the run; the parameter is time."""

    def __init__(self, begin: float) -> None:
        self.s0, self.s1 = begin, begin + 1.0
        self.breaks = self.hints = np.empty(0)

    def evaluate(self, s):
        u = (s - self.s0 - AT) / WIDTH
        bell = np.exp(-0.5 * u * u)
        step = np.sqrt(np.pi / 2.0) * (1.0 + erf(u / np.sqrt(2.0)))
        size = HIGH * WIDTH**2 * np.exp(0.5)  # the second derivative is HIGH at u = -1, and least at u = 1
        swerve = size * np.stack([step, bell / WIDTH, -u * bell / WIDTH**2, (u * u - 1.0) * bell / WIDTH**3])
        even = np.stack([s - self.s0, np.ones_like(s), 0.0 * s, 0.0 * s])
        return np.stack([0.5 * even, 0.3 * even + swerve], axis=2)

    def speed_cap(self, s):
        return np.full(len(s), np.inf)


@pytest.mark.parametrize("begin", [0.0, 1.0, 30.0])
def test_a_swerve_between_states_is_looked_into_wherever_the_parameter_begins(begin: float):
    """Its peak by closed form; the states know nothing of it but that the joint is elsewhere behind it."""
    run = Swerve(begin)
    s = begin + np.linspace(0.0, 1.0, 21)
    law = ClockLaw(np.array([begin, begin + 1.0]))
    ratio, places, between = closer_look(run, LIMITS, law, Probe(law.at(s - begin), np.ones(21), np.full(21, 1.0 / 21)))
    assert ratio[:, 3:5].max() < 1e-9
    assert np.abs(places - begin - AT).min() < WIDTH
    assert between[:, 4].max() == pytest.approx(HIGH / 10.0, rel=0.01)


def test_what_a_joint_gains_in_a_ramp_is_the_same_motion_in_millimetres_and_milliseconds():
    limits = Limits([1.0, 2.0], [3.0, 0.2], [40.0, 7.0])
    gained = gained_in_a_ramp(limits)
    in_mm = gained_in_a_ramp(Limits(limits.velocity * 1e3, limits.acceleration * 1e3, limits.jerk * 1e3))
    assert in_mm == pytest.approx(gained * 1e3)
    in_ms = gained_in_a_ramp(Limits(limits.velocity / 1e3, limits.acceleration / 1e6, limits.jerk / 1e9))
    assert in_ms == pytest.approx(gained / np.array([[1.0], [1e3], [1e6]]))


@pytest.mark.parametrize("seed", range(20))
def test_every_stretch_between_hints_has_places_and_none_lies_elsewhere(seed: int):
    """Judged by counting: eight places in each, of what is there already and what is added."""
    random = np.random.default_rng(seed)
    s = np.sort(random.uniform(2.0, 3.0, 40))
    hints = np.sort(random.uniform(s[0], s[-1], 5))
    run = SimpleNamespace(hints=hints, breaks=np.empty(0))
    added = stretches_unseen(run, s)
    ends = np.concatenate([[s[0]], hints, [s[-1]]])
    before = np.histogram(s[:-1], ends)[0]
    after = np.histogram(added, ends)[0]
    assert ((after == 8) == (before < 8)).all() and ((after == 0) == (before >= 8)).all()
    assert len(added) == after.sum()
    # evenly: no part of a stretch is left out
    for low, high, count in zip(ends, ends[1:], after):
        inside = added[(added > low) & (added < high)]
        assert count == 0 or np.diff([low, *inside, high]).max() < 0.13 * (high - low)
