"""Paths: exact ones, and what every run promises of its derivatives."""

from __future__ import annotations

import numpy as np
import pytest

from tests.support.tool_paths import random_toolpath, tilted, toolpath_through
from toolpace.common.errors import PathError, UsageError
from toolpace.path.path import Path
from toolpace.path.run import unit_jets

FLANK_KNOTS = np.array([0, 0, 0, 0, 0.2, 0.4, 0.6, 0.8, 1, 1, 1, 1])
# H.-Y. Ma et al., JCDE 2022, appendix 1 [mm]
FLANK_TIP = np.array(
    [[5, 0, 0], [-10, 20, 0], [10, 20, 0], [20, 30, 0], [30, 30, 0], [40, 30, 0], [50, 20, 0], [55, 0, 0]]
)
FLANK_POINT = np.array(
    [[0, 0, 15], [-15, 20, 15], [5, 25, 15], [15, 35, 15], [30, 35, 15], [45, 35, 15], [55, 25, 15], [60, 0, 15]]
)


def differences(run, s, h):
    """Largest relative difference of each derivative from the central difference of the one below."""
    here, after, before = run.evaluate(s), run.evaluate(s + h), run.evaluate(s - h)
    worst = 0.0
    for part in range(3):
        if here[part] is None:
            continue
        for order in range(3):
            slope = (after[part][order] - before[part][order]) / (2.0 * h)
            scale = np.max(np.abs(here[part][order + 1])) + 1e-12
            worst = max(worst, float(np.max(np.abs(slope - here[part][order + 1])) / scale))
    return worst


def fitted():
    """A smooth program of 200 blocks."""
    u = np.linspace(0.0, 2.0, 201)
    tip = 0.03 * np.stack([np.cos(u), np.sin(u), 0.2 * np.sin(2 * u)], axis=1)
    return Path.fit(toolpath_through(tip, tilted(0.4 + 0.2 * np.sin(u), u)))


def test_paper_arc_ends_and_lean():
    run = Path.paper_arc().runs[0]
    jet = run.evaluate(np.array([run.s0, run.s1]))
    assert run.s1 == pytest.approx(0.05 * np.pi)
    assert jet.tip[0] == pytest.approx(np.array([[0, 0, 0.1], [0.1 / 2**0.5, 0.1 / 2**0.5, 0]]), abs=1e-15)
    assert jet.axis[0] == pytest.approx(np.array([[-0.5, -0.5, 0.5**0.5], [0.5, 0.5, 0.5**0.5]]))
    assert np.linalg.norm(jet.tip[1], axis=1) == pytest.approx(1.0)
    assert run.feed == 0.03


@pytest.mark.parametrize(
    "path",
    [
        Path.paper_arc(),
        Path.from_bspline(FLANK_KNOTS, FLANK_TIP / 1e3, FLANK_POINT / 1e3),
        fitted(),
    ],
    ids=["arc", "flank", "fit"],
)
def test_derivatives_by_differences(path):
    run = path.runs[0]
    low, high = run.breaks[:-1], run.breaks[1:]
    s = 0.5 * (low + high)
    assert differences(run, s, 1e-3 * np.min(high - low)) < 1e-4
    np.testing.assert_allclose(run.tip_slope(s), run.evaluate(s).tip[1], rtol=1e-12, atol=1e-12)


def test_flank_axis_is_of_unit_length():
    run = Path.from_bspline(FLANK_KNOTS, FLANK_TIP / 1e3, FLANK_POINT / 1e3).runs[0]
    jet = run.evaluate(np.linspace(0, 1, 101))
    assert np.linalg.norm(jet.axis[0], axis=1) == pytest.approx(1.0)
    assert np.abs(np.sum(jet.axis[0] * jet.axis[1], axis=1)).max() < 1e-12
    assert jet.tip[0][0] == pytest.approx(FLANK_TIP[0] / 1e3)


def test_unit_jets_of_a_cubic():
    rng = np.random.default_rng(1)
    c = rng.normal(size=(4, 3))
    c[0] += 3.0

    def jet(u):
        return np.stack(
            [
                c[0] + u * (c[1] + u * (c[2] + u * c[3])),
                c[1] + u * (2 * c[2] + 3 * u * c[3]),
                2 * c[2] + 6 * u * c[3],
                6 * c[3] + 0 * u,
            ]
        )

    u = np.array([[0.1], [0.3]])
    h = 1e-4
    here, after, before = (unit_jets(jet(x)) for x in (u, u + h, u - h))
    for order in range(3):
        assert (after[order] - before[order]) / (2 * h) == pytest.approx(here[order + 1], abs=1e-5)


def test_fit_is_four_times_continuous():
    for seed in (3, 4):
        run = Path.fit(random_toolpath(seed)[0]).runs[0]
        u = np.diff(run.breaks)[:-1, None, None]
        powers = u ** np.arange(6)[None, :, None]
        c = run.coefficients
        for order in range(5):
            factor = np.array([np.prod(np.arange(k, k - order, -1)) for k in range(6)], dtype=float)[None, :, None]
            left = np.sum((c[:-1] * factor)[:, order:] * powers[:, : 6 - order], axis=1)
            right = factor[0, order] * c[1:, order]
            scale = np.sum(np.abs(c[:-1] * factor)[:, order:] * powers[:, : 6 - order], axis=1)
            noise = 1e-13 * np.abs(c[1:, 0]) / u[:, 0] ** order
            assert np.all(np.abs(left - right) <= 1e-8 * scale + 100 * noise + 1e-12)


def test_from_callable():
    def line(s, order):
        tip = np.zeros((len(s), 3))
        if order == 0:
            tip[:, 0] = s
        elif order == 1:
            tip[:, 0] = 1.0
        axis = np.zeros((len(s), 3))
        axis[:, 2] = float(order == 0)
        return tip, axis

    path = Path.from_callable(line, 0.0, 0.1, feed=0.02)
    jet = path.runs[0].evaluate(np.array([0.05]))
    assert jet.tip[0] == pytest.approx(np.array([[0.05, 0, 0]]))
    assert jet.tip[1] == pytest.approx(np.array([[1.0, 0, 0]]))
    assert path.runs[0].feed[0] == 0.02
    with pytest.raises(PathError, match="no length"):
        Path.from_callable(line, 1.0, 1.0)


@pytest.mark.parametrize("value", [0.0, -1.0, np.nan, np.inf])
def test_a_tolerance_must_be_positive(value):
    with pytest.raises(UsageError, match="tip_tolerance"):
        Path.fit(random_toolpath(1)[0], tip_tolerance=value)


def test_wrong_counts_of_a_spline_are_named():
    with pytest.raises(PathError, match="12 knots, 7 and 7"):
        Path.from_bspline(FLANK_KNOTS, FLANK_TIP[:7], FLANK_POINT[:7])
