"""Breaks that are told within rounding of where the path changes are that place; others are left alone."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import BPoly, PPoly

from toolpace.machine.limits import Limits
from toolpace.path.axis_path import AxisPath
from toolpace.path.callable_run import ROUNDINGS, Sides
from toolpace.planning.planner import plan

LIMITS = Limits([1.0, 1.0], [4.0, 4.0], [40.0, 40.0])


def blend(half, change, middle=0.5, turn=0.5):
    """Two lines with a quintic blend as long as 2 `half` between them, whose ends are off by `change` (2,)."""
    way = np.array([[1.0, 0.0], [np.cos(turn), np.sin(turn)]])
    ends = [[-way[0], way[0], np.zeros(2)], [way[1], way[1], np.zeros(2)]]
    parts = [
        PPoly.from_bernstein_basis(BPoly.from_derivatives([-1, 1], [[v[j] for v in e] for e in ends])) for j in (0, 1)
    ]

    def f(s, order):
        low, high = middle - half + change[0], middle + half + change[1]
        inside = [p.derivative(order)(np.clip((s - middle) / half, -1, 1)) * half ** (1 - order) for p in parts]
        lines = [[(s - middle), np.ones(len(s)), 0 * s, 0 * s][order][:, None] * d for d in way]
        side = np.where(s < low, 0, np.where(s >= high, 2, 1))
        return np.choose(side[:, None], [lines[0], np.stack(inside, axis=1), lines[1]])

    return AxisPath.from_callable(f, breaks=[middle - half, middle + half])


@pytest.mark.parametrize("half", [1e-3, 1e-5, 1e-7])
def test_a_break_off_by_the_last_bits_is_that_break(half):
    random = np.random.default_rng(3)
    ulp = np.spacing(0.5)
    right = plan(blend(half, (0.0, 0.0)), LIMITS, bound=False)
    for _ in range(3):
        off = plan(blend(half, ulp * random.integers(-5, 6, 2)), LIMITS, bound=False)
        assert off.duration == pytest.approx(right.duration, rel=1e-6)
        assert off.mesh_points == right.mesh_points and off.usage().worst <= 1.0001


@pytest.mark.parametrize("seed", range(200))
def test_no_place_is_asked_for_but_beside_the_breaks(seed):
    random = np.random.default_rng(seed)
    scale = 10.0 ** random.uniform(-6, 6)
    s0 = scale * random.choice([0.0, -1.0, 1.0, 100.0])
    s1 = s0 + scale
    ulp = np.spacing(max(abs(s0), abs(s1)))
    places = random.uniform(s0, s1, 3)
    near = np.concatenate([places, places + ulp * random.integers(-9, 10, 3), [s0 + 3 * ulp, s1 - 2 * ulp]])
    sides = Sides(np.unique(near), s0, s1)
    ask = np.unique(np.concatenate([random.uniform(s0, s1, 300), *(near + ulp * k for k in range(-40, 41)), [s0, s1]]))
    ask = np.clip(ask, s0, s1)
    got = sides.aside(ask)
    assert (np.diff(got) >= 0.0).all()
    assert np.abs(got - ask).max() <= 4.0 * ROUNDINGS * ulp + ulp
    assert np.abs(got[:, None] - near).min() >= (ROUNDINGS - 1.0) * ulp
    # each break inside the run has its two sides, right next to one another
    before, after = sides.aside(np.nextafter(sides.breaks, -np.inf)), sides.aside(sides.breaks)
    assert (before < sides.breaks).all() and (after > sides.breaks).all()
    assert len(sides.breaks) <= 3
