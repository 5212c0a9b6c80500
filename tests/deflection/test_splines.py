"""Splines of a way back: control points as scipy has them, ends met to rounding, and the use that positions show."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.interpolate import BSpline

from testbed import replans
from toolpace.deflection.rejoin.joint_splines import (
    FINER,
    PIECES,
    Mesh,
    Problem,
    Spline,
    detour_of,
    knots_of,
    rows_of,
    scales,
    solved,
)
from toolpace.deflection.rejoin.search import joints_used, meeting
from toolpace.deflection.rejoin_motion import CommandedMotion, Detour
from toolpace.kernels.planners.joint_spline_barrier import most_used
from toolpace.machine.limits import KINDS, Limits


def problem_at(share: float, offset: np.ndarray, kind: str = "line", feed: float = 600.0) -> Problem:
    """The joints off by an offset (m,) at a share of a plan."""
    old, machine = replans.planned(kind, feed), replans.machine_of(kind)
    motion = CommandedMotion.of(old, 0)
    left = share * old.laws[0].duration
    start = motion.motion(np.array([left]))[:3, 0]
    start[0] += offset
    return Problem(motion, left, start, old.limits, machine)


OFF = np.array([2e-4, -3e-4, 1e-4, 1e-3, -2e-3])


def scipys(mesh: Mesh, c: np.ndarray) -> BSpline:
    """With knots that go on at the start by the first step, at the end by the last, as the coefficients have them."""
    first, last = mesh.times[1], mesh.times[-1] - mesh.times[-2]
    before, behind = first * np.arange(-3.0, 0.0), mesh.times[-1] + last * np.arange(1.0, 4.0)
    return BSpline(np.concatenate([before, mesh.times, behind]), c, 3)


@pytest.mark.parametrize("pieces", [PIECES, FINER])
@pytest.mark.parametrize("period", [0.03, 2.0])
def test_control_points_are_those_of_scipys_splines(pieces: int, period: float):
    mesh = Mesh.of(period, pieces)
    c = np.random.default_rng(pieces).normal(size=(pieces + 3, 2))
    spline = scipys(mesh, c)
    for order in range(1, 4):
        points = spline.derivative(order).c[:pieces]
        own = np.einsum("kd,kdm->km", mesh.stencil[order], np.stack([c[d : pieces + d] for d in range(4)], axis=1))
        assert own == pytest.approx(points, rel=1e-9, abs=1e-9 * np.abs(points).max())
    middles = (mesh.times[1:] + mesh.times[:-1]) / 2.0
    jerks = spline(middles, 3)
    assert mesh.jerks(c) == pytest.approx(jerks, rel=1e-8, abs=1e-9 * np.abs(jerks).max())
    # coefficients of t and of t^2 are these functions
    assert scipys(mesh, mesh.places)(middles) == pytest.approx(middles)
    assert scipys(mesh, mesh.squares)(middles) == pytest.approx(middles**2)


@pytest.mark.parametrize("order", range(4))
def test_rows_are_control_points_over_limits_and_travel(order: int):
    """Of a spline that is off from nothing by any coefficients; one kind of limit counts at a time."""
    random, tight = np.random.default_rng(order), 0.7
    whole = problem_at(0.4, OFF, "five 1", 6000.0)
    ample = {kind: np.full(5, 1e9) for kind in KINDS}
    if order:
        ample[KINDS[order - 1]] = tight * getattr(whole.limits, KINDS[order - 1])
    problem, period, n = replace(whole, limits=Limits(**ample)), 0.1, PIECES
    rows, y = rows_of(problem, period, 0.0, (0.0, 0.0))
    y[3:] += 0.02 * random.normal(size=y[3:].shape)
    mesh, (q, v, a) = Mesh.of(period, n), problem.start
    c = q + mesh.places[:, None] * v + mesh.squares[:, None] * a / 2.0 + y * scales(problem, period)
    # the first three are the start's own
    points = scipys(mesh, c).derivative(order).c[3 - order : n] if order else c[3:n]
    if order:
        wanted = np.abs(points / ample[KINDS[order - 1]])
    else:
        low, high = problem.travel.T
        bounded = np.isfinite(high - low)
        wanted = (np.abs(2.0 * points - low - high) / (high - low))[:, bounded]
    assert most_used(rows, y, False) == pytest.approx(wanted.max(), rel=1e-6)


def test_the_motion_that_is_rejoined_is_met_to_rounding():
    """From jerks that are off by a millionth: with the least change, they are again."""
    problem = problem_at(0.4, OFF)
    period = 0.2
    rows, y = rows_of(problem, period, 0.0, (0.0, 0.0))
    detour = detour_of(solved(rows, Spline.begun(problem, period, 0.0, y), with_tip=False))
    jerks = detour.jerks * (1.0 + 1e-6 * np.random.default_rng(1).normal(size=detour.jerks.shape))
    off = replace(detour, jerks=jerks, knots=knots_of(problem.start, jerks, detour.times))
    end = problem.commanded.motion(np.array([detour.rejoin]))[:3, 0]
    sizes = np.array([[1.0], [1.0], [10.0]])
    assert np.abs((off.knots[:, -1] - end) / sizes).max() > 1e-9
    met = meeting(off)
    assert np.abs((met.knots[:, -1] - end) / sizes).max() < 1e-14
    assert np.abs(met.jerks - off.jerks).max() < 1e-5 * np.abs(off.jerks).max()
    # the knots are those of the jerks, step by step
    assert met.motion(met.times[1:] - 1e-12)[0] == pytest.approx(met.knots[0, 1:], abs=1e-10)


@pytest.mark.parametrize("kind", range(3))
def test_the_use_of_a_limit_is_that_of_the_positions(kind: int):
    """By differences of close positions, for motions that turn within their steps and for those that go on."""
    problem = problem_at(0.4, np.zeros(5))
    for seed in range(30):
        random = np.random.default_rng(seed)
        times = np.concatenate([[0.0], np.cumsum(random.uniform(0.05, 0.2, 4))])
        start = problem.start + random.uniform(-1.0, 1.0, (3, 5)) * [[0.0], [1e-2], [0.1]]
        jerks = random.uniform(-1.0, 1.0, (4, 5)) * (3.0 if seed % 2 else 0.03)
        detour = Detour(problem.commanded, problem.left, problem.left, times, knots_of(start, jerks, times), jerks)
        limits = [np.full(5, 1e9) for _ in KINDS]
        limits[kind] = random.uniform(0.5, 2.0, 5)
        t = np.concatenate([np.linspace(low, high, 2001) for low, high in pairwise(times)]).reshape(4, -1)
        q = np.stack([detour.motion(each - 1e-15)[0] for each in t])
        q = q - q.mean(axis=1, keepdims=True)
        step = np.diff(times)[:, None, None] / 2000.0
        far = [1, 40, 200][kind]
        rate = np.diff(q[:, ::far], kind + 1, axis=1) / (far * step) ** (kind + 1)
        most = (np.abs(rate).max(axis=(0, 1)) / limits[kind]).max()
        wide = replace(problem, limits=Limits(*limits), machine=None)
        assert joints_used(wide, detour) == pytest.approx(most, rel=[2e-3, 5e-2, 1e-2][kind], abs=1e-4)
