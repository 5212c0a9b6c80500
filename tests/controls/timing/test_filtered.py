"""The model `fir`: against the filters themselves, run sample by sample."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest

from tests.support.timed_programs import machine, timed
from toolpace.controls.timing.figures import figures_of

RAMP, SMOOTHING = 0.06, 0.02


def figures(tolerance: float = 0.02):
    return figures_of({"ramp_time": RAMP, "smoothing_time": SMOOTHING, "tolerance": tolerance}, "", "fir")


def filtered(way: np.ndarray, dt: float) -> np.ndarray:
    """Positions (n, 2) through both moving averages, with room for them to empty at the end."""
    late = round((RAMP + SMOOTHING) / dt) + 2
    way = np.vstack([np.repeat(way[:1], late, axis=0), way, np.repeat(way[-1:], late, axis=0)])
    for time in (RAMP, SMOOTHING):
        window = np.ones(round(time / dt)) / round(time / dt)
        way = np.stack([np.convolve(column, window, mode="valid") for column in way.T], axis=1)
    return way


def test_a_line_takes_its_feed_and_the_filters():
    dt, feed = 1e-4, 0.05
    time = timed("G1 X20 F3000\n", figures(), machine(1e3, 1e6)).total
    assert time == pytest.approx(0.02 / feed + RAMP + SMOOTHING)
    way = np.minimum(np.arange(0.0, 0.5, dt) * feed, 0.02)
    moving = np.flatnonzero(np.abs(np.diff(filtered(np.stack([way, 0 * way], axis=1), dt)[:, 0])) > 1e-12)
    assert (moving[-1] - moving[0]) * dt == pytest.approx(time, abs=5 * dt)


@pytest.mark.parametrize("turn", [20.0, 60.0, 90.0, 135.0])
def test_a_corner_is_as_fast_as_its_tolerance_allows_and_no_faster(turn: float):
    """The speed at the corner, put through the filters, leaves the corner by the tolerance."""
    room, feed, dt = 20e-6, 0.1, 1e-5
    angle = math.radians(turn)
    d0, d1 = np.array([1.0, 0.0]), np.array([math.cos(angle), math.sin(angle)])
    speed = room / ((RAMP / 8.0 + SMOOTHING**2 / (24.0 * RAMP)) * np.linalg.norm(d1 - d0))
    ends = 20.0 * (d0 + d1)
    body = f"G1 X20 F{feed * 6e4:g}\nG1 X{ends[0]:.9f} Y{ends[1]:.9f}\n"
    lost = (RAMP + SMOOTHING) * (1.0 - min(speed / feed, 1.0))
    expected = 0.04 / feed + RAMP + SMOOTHING + lost
    assert timed(body, figures(), machine(1e3, 1e6)).total == pytest.approx(expected, rel=1e-3)
    t = np.arange(-0.1, 0.1, dt)[:, None]
    off = np.linalg.norm(filtered(np.where(t < 0.0, t * speed * d0, t * speed * d1), dt), axis=1)
    assert off.min() == pytest.approx(room, rel=0.01)


def test_a_looser_tolerance_is_never_slower():
    turn = np.linspace(0.0, 2.0 * math.pi, 90)[1:]
    body = "G1 X5 F9000\n" + "".join(f"G1 X{5 * math.cos(a):.4f} Y{5 * math.sin(a):.4f}\n" for a in turn)
    totals = [timed(body, figures(tolerance), machine(10.0, 1e3)).total for tolerance in (0.001, 0.005, 0.02, 0.1, 1.0)]
    assert all(b <= a * (1.0 + 1e-9) for a, b in pairwise(totals))
    assert totals[0] > 1.2 * totals[-1]


def test_chords_of_a_circle_are_no_corners():
    turn = np.linspace(0.0, 2.0 * math.pi, 721)[1:]
    fine = "G1 X5 F3000\n" + "".join(f"G1 X{5 * math.cos(a):.6f} Y{5 * math.sin(a):.6f}\n" for a in turn)
    coarse = "G1 X5 F3000\n" + "".join(f"G1 X{5 * math.cos(a):.6f} Y{5 * math.sin(a):.6f}\n" for a in turn[3::4])
    assert timed(fine, figures(), machine(10.0, 1e3)).total == pytest.approx(
        timed(coarse, figures(), machine(10.0, 1e3)).total, rel=0.1
    )
