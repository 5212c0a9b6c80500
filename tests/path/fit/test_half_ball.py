"""One side of the tube: an ellipsoid in the half ball, and curves that never leave it."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.support.tool_paths import random_toolpath, spiral
from toolpace.common.errors import PathError, UsageError
from toolpace.path.fit.polyline import ACROSS, ALONG, HalfBall, PlaceTolerances, polylines, unit
from toolpace.path.path import Path
from toolpace.programs.tolerances import Tolerances

TIP, AXIS = 10e-6, 1e-3
ABOVE = Tolerances(TIP, side="above")


def offs(path, toolpath):
    """Deviations (n, 3) [tolerances] of a fitted path and ways out (n, 3), at many parameters of all runs."""
    found = []
    for run, line in zip(path.runs, polylines(toolpath, PlaceTolerances.of(toolpath, ABOVE, AXIS), None)):
        s = np.linspace(0.0, line.s[-1], 20_001)
        tip = run.evaluate(np.clip(run.s0 + TIP * s, run.s0, run.s1)).tip[0] / TIP
        wanted = np.stack([np.interp(s, line.s, each) for each in line.tip.T], axis=1)
        out = unit(np.stack([np.interp(s, line.s, each) for each in line.half.out.T], axis=1))
        found.append((tip - wanted, out))
    return [np.concatenate(each) for each in zip(*found)]


@pytest.mark.parametrize("seed", range(4))
def test_the_ellipsoid_is_in_the_half_ball_and_as_large_as_one_can_be(seed):
    r = np.random.default_rng(seed)
    out = unit(r.standard_normal((2, 3)))
    half = HalfBall(np.array([0.0, 1000.0]), out)
    at = r.uniform(10.0, 990.0, 5000)
    normal = half.outward(at)
    way = unit(r.standard_normal((5000, 3)))
    length = np.sqrt(np.einsum("na,nab,nb->n", way, half.metric(at), way))
    off = half.centre(at) + way / length[:, None]
    assert np.allclose(half.distance(off, at), 1.0)
    assert np.linalg.norm(off, axis=1).max() <= 1.0 + 1e-12
    assert np.einsum("na,na->n", off, normal).min() >= -1e-12
    # of all b the one with the most volume, where a^2 = b^2 - b^4 is what the ball leaves
    b = np.linspace(0.75, 0.95, 2001)
    best = b[np.argmax(b**2 * np.sqrt(b**2 - b**4))]
    assert best == pytest.approx(ACROSS, abs=2e-4) and pytest.approx(ACROSS * np.sqrt(1.0 - ACROSS**2)) == ALONG


def test_where_a_run_ends_the_curve_is_at_the_program():
    half = HalfBall(np.array([0.0, 400.0]), np.array([[0.0, 0.0, 1.0]] * 2))
    ends = np.array([0.0, 400.0])
    assert np.all(half.centre(ends) == 0.0) and np.all(half.distance(np.zeros((2, 3)), ends) == 0.0)
    assert np.isfinite(half.metric(ends)).all()


@pytest.mark.parametrize("seed", range(40))
def test_no_fit_goes_below_its_program(seed):
    toolpath, _ = random_toolpath(seed)
    try:
        path = Path.fit(toolpath, ABOVE, AXIS)
    except PathError:
        # what no curve follows in half of the tube asks for a corner that the ball alone may leave room for
        return
    off, out = offs(path, toolpath)
    assert np.einsum("na,na->n", off, out).min() >= -1e-3
    assert np.linalg.norm(off, axis=1).max() <= 1.0
    assert np.linalg.norm(off, axis=1).max() * TIP <= path.tip_deviation * (1.0 + 1e-6) + 0.01 * TIP


@pytest.mark.sweep
def test_hardly_any_fit_is_refused_for_its_side():
    refused = 0
    for seed in range(40):
        toolpath, _ = random_toolpath(seed)
        try:
            Path.fit(toolpath, TIP, AXIS)
            Path.fit(toolpath, ABOVE, AXIS)
        except PathError:
            refused += 1
    assert refused == 0


def test_the_ends_stay_and_a_path_on_one_side_is_nearly_as_smooth():
    toolpath = spiral(600)
    both, above = Path.fit(toolpath, TIP, AXIS), Path.fit(toolpath, ABOVE, AXIS)
    for end in (0, -1):
        at = np.array([above.runs[end].s0 if end == 0 else above.runs[end].s1])
        assert np.allclose(above.runs[end].evaluate(at).tip[0], toolpath.tip[end], atol=1e-12)
    s = np.linspace(0.0, 1.0, 5001)
    rough = [
        np.mean(np.sum(run.evaluate(run.s0 + s * (run.s1 - run.s0)).tip[3] ** 2, axis=1))
        for run in (both.runs[0], above.runs[0])
    ]
    assert rough[1] < 20.0 * rough[0]


def test_one_side_goes_with_one_tolerance_of_the_tip():
    with pytest.raises(UsageError, match="one tolerance of the tip for all"):
        Tolerances(TIP, {"N10": 5e-6}, side="above")
    with pytest.raises(UsageError, match="did you mean 'outside'"):
        Tolerances(TIP, side="outsid")
    with pytest.raises(UsageError, match="the tool axis has none"):
        Path.fit(spiral(50), TIP, Tolerances(AXIS, side="above"))
    with pytest.raises(UsageError, match=r"tells no normals .* 'above'"):
        Path.fit(spiral(50), Tolerances(TIP, side="outside"), AXIS)


def test_the_text_of_a_side_is_read_back():
    text = Tolerances(TIP, side="outside").text(lambda value: f"{value * 1e6:g}um")
    assert text == "10um,outside"
    assert Tolerances.parse(text, lambda part: float(part[:-2]) * 1e-6, math.nan).side == "outside"
    assert not Tolerances(TIP, side="above").everywhere and (0.5 * Tolerances(TIP, side="above")).side == "above"
