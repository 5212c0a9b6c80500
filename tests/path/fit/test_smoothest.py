"""The fit is the smoothest curve in the tube: against an independent conic solver, and against exact curves."""

from __future__ import annotations

import numpy as np
import pytest

from testbed.positioned import positioned
from tests.support.growth import NEARLY_LINEAR, order_of_growth
from tests.support.tool_paths import tilted, toolpath_through
from toolpace.common.workers import UNTOLD, Workers
from toolpace.kernels.fit import smoothest
from toolpace.machine.machine import Machine
from toolpace.path.fit import smoothest_spline
from toolpace.path.fit.polyline import PlaceTolerances, polylines
from toolpace.path.fit.smoothest_spline import inside_spline
from toolpace.path.fit.spline import Comparison, knots_of
from toolpace.path.path import Path
from toolpace.programs.reading import read_text

TIP, AXIS = 10e-6, 1e-3


def wave(n, span=1.0, decimals=6):
    u = np.linspace(0.0, span, n)
    tip = np.stack([0.04 * np.cos(2 * u), 0.035 * np.sin(2 * u), 0.005 * np.sin(5 * u)], axis=1)
    return toolpath_through(np.round(tip, decimals), tilted(0.6 + 0.2 * np.sin(2 * u), u))


def line_of(toolpath):
    return polylines(toolpath, PlaceTolerances.of(toolpath, TIP, AXIS), None)[0]


def conic_optimum(breaks, data):
    """Least roughness of the tip, by Clarabel."""
    clarabel = pytest.importorskip("clarabel")
    from scipy import sparse
    from scipy.interpolate import BSpline

    knots = knots_of(breaks)
    n = len(knots) - 6
    place, weight = np.polynomial.legendre.leggauss(3)
    middle, half = 0.5 * (breaks[1:] + breaks[:-1]), 0.5 * np.diff(breaks)
    s = (middle[:, None] + half[:, None] * place).ravel()
    w = np.sqrt((half[:, None] * weight).ravel())
    third = np.stack([BSpline(knots, np.eye(n)[i], 5).derivative(3)(s) for i in range(n)], axis=1) * w[:, None]
    rows = np.stack([BSpline(knots, np.eye(n)[i], 5)(data.s) for i in range(n)], axis=1)
    # unknowns: deviations from the first spline scaled, three coordinates and the third derivatives as slacks
    scale = 1.0 / np.sqrt(np.mean(np.sum(third**2, axis=0)))
    third = third * scale
    k = len(third)
    total = 3 * n + 3 * k
    quadratic = sparse.diags(np.concatenate([np.zeros(3 * n), np.ones(3 * k)])).tocsc()
    blocks, right, cones = [], [], []
    link = sparse.hstack([sparse.kron(sparse.eye(3), sparse.csr_matrix(third)), -sparse.eye(3 * k)])
    ends = np.zeros((6, total))
    values = []
    for c in range(3):
        for row, (coefficient, sample) in enumerate(((0, 0), (n - 1, -1))):
            ends[2 * c + row, c * n + coefficient] = 1.0
            values.append(data.tip[sample, c])
    blocks.append(sparse.vstack([link, sparse.csr_matrix(ends)]))
    right.append(np.concatenate([np.zeros(3 * k), values]))
    cones.append(clarabel.ZeroConeT(3 * k + 6))
    for j in range(1, len(data.s) - 1):
        ball = np.zeros((4, total))
        for c in range(3):
            ball[1 + c, c * n : (c + 1) * n] = -rows[j]
        blocks.append(sparse.csr_matrix(ball))
        right.append(np.concatenate([[smoothest_spline.USED], -data.tip[j]]))
        cones.append(clarabel.SecondOrderConeT(4))
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.max_iter = 400
    solution = clarabel.DefaultSolver(
        quadratic, np.zeros(total), sparse.vstack(blocks).tocsc(), np.concatenate(right), cones, settings
    ).solve()
    assert str(solution.status) in ("Solved", "AlmostSolved")
    return solution.obj_val / scale**2


@pytest.mark.parametrize("n, span", [(20, 0.25), (50, 0.5), (40, 1.0)])
def test_roughness_is_the_optimum_of_a_conic_solver(n, span):
    from toolpace.kernels.fit.quintic_spline import jets, pieces

    line = line_of(wave(n, span, 5))
    weight = np.ones(3)
    look = Comparison(line, AXIS, None, False).between
    spline, data = inside_spline(line, smoothest_spline.first_breaks(line), weight, AXIS, None, look, Workers())
    breaks, tip = spline.breaks, spline.tip
    best = conic_optimum(breaks, data)
    smoothest_spline.tighten(spline, data, weight, 3e-11, np.ones(len(data.s)), None, Workers(), UNTOLD)
    place, share = np.polynomial.legendre.leggauss(3)
    half = 0.5 * np.diff(breaks)
    s = (0.5 * (breaks[1:] + breaks[:-1])[:, None] + half[:, None] * place).ravel()
    third = jets(breaks, pieces(knots_of(breaks), tip), s)[3]
    value = 0.5 * np.sum((half[:, None] * share).ravel()[:, None] * third**2)
    assert value == pytest.approx(best, rel=0.01)


@pytest.mark.parametrize("decimals", [6, 7])
@pytest.mark.parametrize("n", [60, 400, 3000])
def test_third_derivative_of_a_rounded_program_is_that_of_the_curve(n, decimals):
    """The tip of the wave has |d3| of about 1 / R^2 along its length; rounding must not show, nor the ends."""
    u = np.linspace(0, 1, 4001)
    exact = 0.04 * np.stack([2 * -np.sin(2 * u), 2 * 0.875 * np.cos(2 * u), 0.625 * np.cos(5 * u)], axis=1)
    speed = np.linalg.norm(exact, axis=1)
    third = np.stack([0.04 * 8 * np.sin(2 * u), -0.035 * 8 * np.cos(2 * u), -0.005 * 125 * np.cos(5 * u)], axis=1)
    bound = np.max(np.linalg.norm(third, axis=1) / speed**3)
    run = Path.fit(wave(n, 1.0, decimals)).runs[0]
    jet = run.evaluate(np.linspace(run.s0, run.s1, 4001))
    assert np.max(np.linalg.norm(jet.tip[3], axis=1)) < 2.0 * bound


def test_the_curve_converges_with_the_tolerance():
    errors = []
    for tolerance in (10e-6, 1e-6, 0.1e-6):
        run = Path.fit(wave(1500, 1.0, 12), tolerance, tolerance / TIP * AXIS).runs[0]
        tip = run.evaluate(np.linspace(run.s0, run.s1, 300)).tip[0]
        u = np.linspace(0, 1, 200001)
        true = np.stack([0.04 * np.cos(2 * u), 0.035 * np.sin(2 * u), 0.005 * np.sin(5 * u)], axis=1)
        index = np.clip(np.searchsorted(-true[:, 0], -tip[:, 0]), 200, len(u) - 201)
        near = index[:, None] + np.arange(-200, 201)
        errors.append(np.max(np.min(np.linalg.norm(true[near] - tip[:, None], axis=2), axis=1)))
    assert errors[0] > 5 * errors[1] > 20 * errors[2]


@pytest.mark.sweep
def test_cost_grows_in_proportion_to_the_blocks():
    """Windows keep it from growing faster, but for their seams."""
    small, large = (wave(n, 3.0 * n / 4000) for n in (8000, 32000))
    assert order_of_growth(Path.fit, small, large, 4.0) < NEARLY_LINEAR


def test_no_solve_goes_on_while_only_rounding_is_left(monkeypatch):
    """Operations on tilted planes: the third derivatives of a large arc on which the table turns and of the corners lie
    decades apart, and a joint that turns only there has nothing left to smooth; such solves took 80 steps."""
    machine = Machine.load("xyzbc-trunnion")
    toolpath = read_text(positioned(2), machine, controller="fanuc")
    steps = []
    whole = smoothest.smoothest

    def counted(*arguments):
        out = whole(*arguments)
        steps.append(out[0])
        return out

    monkeypatch.setattr(smoothest, "smoothest", counted)
    path = Path.fit(toolpath, TIP, AXIS, machine)
    assert path.tip_deviation <= TIP and len(steps) >= 2
    assert min(steps) >= 0 and max(steps) < 40
