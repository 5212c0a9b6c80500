"""The commanded motion on another clock is one motion, and rests before its start and behind its end."""

from __future__ import annotations

import numpy as np
import pytest

from testbed import replans
from toolpace.deflection.rejoin_motion import CommandedMotion


def clock_of(t: np.ndarray, duration: float) -> np.ndarray:
    """(4, n) a clock that goes slower and faster, and its rates."""
    w = 2.0 * np.pi
    turned = np.stack([np.sin(w * t), w * np.cos(w * t), -(w**2) * np.sin(w * t), -(w**3) * np.cos(w * t)])
    even = np.stack([t + 0.1, np.ones_like(t), 0.0 * t, 0.0 * t])
    return duration * (0.8 * even + 0.05 * turned)


@pytest.mark.parametrize("order", [1, 2, 3])
@pytest.mark.parametrize("kind", ["five 1", "arc"])
def test_each_row_is_the_derivative_of_the_one_before_on_any_clock(order: int, kind: str):
    """By central differences, but where the law's own jerk jumps."""
    old = replans.planned(kind, 600.0)
    motion = CommandedMotion.of(old, 0)
    h, t = 1e-6, np.linspace(0.05, 0.95, 300)
    here, later, sooner = (motion.paced(clock_of(t + d, old.laws[0].duration)) for d in (0.0, h, -h))
    found = (later[order - 1] - sooner[order - 1]) / (2.0 * h)
    off = np.abs(found - here[order]).max(axis=1) / np.abs(here[order]).max()
    assert np.median(off) < 1e-7 and np.mean(off > 1e-5) < 0.05


@pytest.mark.parametrize("clock", [-0.3, -1e-9, 1.0, 1.2])
def test_outside_its_times_it_stands_whatever_the_clock_does(clock: float):
    old = replans.planned("five 1", 600.0)
    motion, whole = CommandedMotion.of(old, 0), old.laws[0].duration
    q, *rates = motion.paced(np.array([[clock * whole], [0.7], [-2.0], [9.0]]))[:, 0]
    assert not np.any(rates)
    assert q == pytest.approx(old.at(whole if clock > 0.0 else 0.0).q, abs=1e-12)
