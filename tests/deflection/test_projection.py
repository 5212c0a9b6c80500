"""Projection, section II.D of Wu, Li, Liu, Perez, ACC 2009: the nearest point, by bounds and by the potential field."""

from __future__ import annotations

import itertools
from collections.abc import Callable

import numpy as np
import pytest

from testbed import published
from tests.support.growth import order_of_growth
from tests.support.tool_paths import random_toolpath, toolpath_through
from toolpace import deflection
from toolpace.common.errors import PathError, UsageError
from toolpace.deflection import nearest_point
from toolpace.deflection.nearest_point import chords_of
from toolpace.deflection.projection import TOLERANCE, descend
from toolpace.machine.machine import Machine
from toolpace.path.axis_quintic import quintic_path, quintic_through
from toolpace.path.exact import callable_run
from toolpace.path.path import Path
from toolpace.path.run import PathRun

MACHINE = Machine.load("paper-ab")
ARC = Path.paper_arc()
LENGTH = ARC.runs[0].s1
DEFLECTION = (0.059, 0.0568, 0.0589)
TWENTIETH = (19 * LENGTH / 31, 20 * LENGTH / 31)
UPRIGHT = np.array([0.0, 0.0, 1.0])


def closest_on_arc(point: np.ndarray, low: float = 0.0, high: float = LENGTH) -> np.ndarray:
    """Closed form: the angle of the point's projection in the plane of the circle, clipped."""
    angle = np.arctan2((point[0] + point[1]) / np.sqrt(2.0), point[2])
    angle = np.clip(angle, low / 0.1, high / 0.1)
    flat = np.sin(angle) / np.sqrt(2.0)
    return 0.1 * np.array([flat, flat, np.cos(angle)])


def test_eq8_to_10_force_is_the_negative_gradient() -> None:
    target, point, step = np.array([0.1, 0.2, -0.1]), np.array([0.3, -0.1, 0.2]), 1e-6
    for alpha, m in ((1.0, 2.0), (0.7, 3.0), (2.0, 1.5)):
        height = [
            [deflection.potential(target + sign * d, point, alpha=alpha, m=m) for sign in (1, -1)]
            for d in step * np.eye(3)
        ]
        slope = [(above - below) / (2 * step) for above, below in height]
        np.testing.assert_allclose(deflection.force(target, point, alpha=alpha, m=m), -np.array(slope), atol=1e-8)
    assert deflection.potential(target, point) == pytest.approx(float((target - point) @ (target - point)))


def test_eq8_with_velocities_and_eq10_where_they_are_the_same() -> None:
    apart = deflection.potential([1, 0, 0], [0, 0, 0], velocity=([0, 2, 0], [0, 0, 0]), alpha_velocity=3.0, n=2.0)
    assert apart == pytest.approx(1.0 + 3.0 * 4.0)
    same = deflection.potential([1, 0, 0], [0, 0, 0], velocity=([0, 2, 0], [0, 2, 0]), alpha_velocity=3.0)
    assert same == pytest.approx(1.0)
    assert not deflection.force([1, 0, 0], [1, 0, 0]).any()


def test_printed_projection_is_that_on_the_20th_interval() -> None:
    found = deflection.project(ARC, DEFLECTION, interval=TWENTIETH)
    np.testing.assert_allclose(found.tip, (0.05804, 0.05804, 0.05713), atol=5e-6)
    assert [round(v, 3) for v in found.tip[:2]] == [0.058, 0.058] and round(found.tip[2], 4) == 0.0571
    assert found.s == pytest.approx(TWENTIETH[0], abs=1e-12)
    assert found.distance == pytest.approx(2.367e-3, abs=5e-7)


def test_errata_projection_on_the_whole_arc_is_closer() -> None:
    found = deflection.project(ARC, DEFLECTION)
    np.testing.assert_allclose(found.tip, closest_on_arc(np.array(DEFLECTION)), atol=1e-12)
    np.testing.assert_allclose(found.tip, (0.0574027, 0.0574027, 0.0583941), atol=5e-8)
    assert found.distance == pytest.approx(1.781e-3, abs=5e-7)
    assert 18 < 31 * found.s / LENGTH < 19


def test_errata_circle_about_the_printed_centre_misses_the_printed_projection() -> None:
    printed = np.array([0.058, 0.058, 0.0571])
    assert np.linalg.norm(printed) == pytest.approx(0.09994, abs=1e-5)
    assert np.linalg.norm(printed - [0.0707, 0.0707, 0.0]) == pytest.approx(0.0599, abs=1e-4)


def test_errata_no_other_direction_or_count_gives_the_printed_projection() -> None:
    for count in (30, 31, 32):
        for first in (19, count - 20):
            on = (first * LENGTH / count, (first + 1) * LENGTH / count)
            tip = deflection.project(ARC, DEFLECTION, interval=on).tip
            met = [round(v, 3) for v in tip[:2]] == [0.058, 0.058] and round(tip[2], 4) == 0.0571
            assert met == (count == 31 and first == 19)


def test_projection_is_the_closest_point_of_the_arc_wherever_the_deflection_is() -> None:
    random = np.random.default_rng(3)
    for _ in range(50):
        angle, distance = random.uniform(0, np.pi / 2), 10 ** random.uniform(-6, -2)
        point = closest_on_arc(np.array([np.sin(angle), np.sin(angle), np.sqrt(2) * np.cos(angle)]))
        point = point + distance * random.normal(size=3)
        found = deflection.project(ARC, point)
        np.testing.assert_allclose(found.tip, closest_on_arc(point), atol=1e-12)


@pytest.mark.parametrize("name", ["flank", "fan"])
def test_projection_agrees_with_dense_search_and_newton(name: str) -> None:
    path = {"flank": published.flank, "fan": published.fan}[name]()[0]
    run = path.runs[0]
    random = np.random.default_rng(4)
    grid = np.linspace(run.s0, run.s1, 40001)
    tips = run.evaluate(grid).tip[0]
    for _ in range(20):
        point = tips[random.integers(len(tips))] + 10 ** random.uniform(-5, -2.3) * random.normal(size=3)
        k = int(np.argmin(np.linalg.norm(tips - point, axis=1)))
        s = grid[k]
        for _ in range(20):
            jet = run.evaluate(np.array([s])).tip[:, 0]
            slope = (jet[0] - point) @ jet[1]
            s = np.clip(
                s - slope / (jet[1] @ jet[1] + (jet[0] - point) @ jet[2]), grid[max(k - 1, 0)], grid[min(k + 1, 40000)]
            )
        wanted = float(np.linalg.norm(run.evaluate(np.array([s])).tip[0, 0] - point))
        assert deflection.project(path, point).distance == pytest.approx(wanted, rel=1e-12, abs=1e-15)


def test_projection_error_falls_with_every_step() -> None:
    """The descent converges linearly: the further off the path, the more slowly."""
    point, wanted = np.array(DEFLECTION), closest_on_arc(np.array(DEFLECTION))
    run = ARC.runs[0]

    def curve(s: float) -> tuple[np.ndarray, np.ndarray]:
        jet = run.evaluate(np.array([s])).tip
        return jet[0, 0], jet[1, 0]

    errors = []
    s = 0.09
    for _ in range(5):
        errors.append(float(np.linalg.norm(curve(s)[0] - wanted)))
        tip, along = curve(s)
        s += float(deflection.force(tip, point) @ along) / (2.0 * float(along @ along))
    assert all(after < 0.05 * before for before, after in itertools.pairwise(errors) if before > 1e-12)
    found, steps = descend(curve, point, 0.0, LENGTH, 0.09)
    assert steps < 20 and np.linalg.norm(curve(found)[0] - wanted) < 1e-12


def test_projection_refuses_what_is_no_point_or_no_interval() -> None:
    with pytest.raises(UsageError, match=r"tip\[1\] is nan; give finite"):
        deflection.project(ARC, (0.0, np.nan, 0.0))
    with pytest.raises(UsageError, match="no interval"):
        deflection.project(ARC, DEFLECTION, interval=(1.0, 2.0))
    with pytest.raises(UsageError, match=r"unknown method 'potentail'; .*potential"):
        deflection.project(ARC, DEFLECTION, method="potentail")
    with pytest.raises(UsageError, match="tolerance is 0; give a number, above 0"):
        deflection.project(ARC, DEFLECTION, tolerance=0.0)
    with pytest.raises(UsageError, match=r"2 runs of the path have an interval .* project on the one"):
        deflection.project(Path(2 * ARC.runs), DEFLECTION, interval=TWENTIETH)


def waves(count: int, random: np.random.Generator) -> tuple[Path, Callable[[np.ndarray], np.ndarray]]:
    """A path of a metre with that many waves of random height and phase, as a function; and its tip alone."""
    height, depth = 10 ** random.uniform(-4, -2, size=2)
    phase, other = random.uniform(0, 2 * np.pi, size=2)
    k, k2 = 2 * np.pi * count, 2 * np.pi * count * random.uniform(0.3, 1.0)

    def tip(s: np.ndarray, order: int = 0) -> np.ndarray:
        along = s if order == 0 else np.full_like(s, float(order == 1))
        turn = order * np.pi / 2
        return np.stack(
            [
                along,
                height * k**order * np.sin(k * s + phase + turn),
                depth * k2**order * np.sin(k2 * s + other + turn),
            ],
            axis=1,
        )

    return Path.from_callable(lambda s, order: (tip(s, order), UPRIGHT * (order == 0))), tip


def least_distance(
    tip: Callable[[np.ndarray], np.ndarray], ends: tuple[float, float], point: np.ndarray, count: int
) -> float:
    """Oracle: the lowest of the ten deepest valleys of a dense sampling, each refined four times by another."""
    s = np.linspace(*ends, count)
    d = np.linalg.norm(tip(s) - point, axis=1)
    padded = np.concatenate([[np.inf], d, [np.inf]])
    valleys = np.flatnonzero((d <= padded[:-2]) & (d <= padded[2:]))
    least = np.inf
    for k in valleys[np.argsort(d[valleys])][:10]:
        low, high = s[max(k - 1, 0)], s[min(k + 1, count - 1)]
        for _ in range(4):
            finer = np.linspace(low, high, 101)
            near = np.linalg.norm(tip(finer) - point, axis=1)
            j = int(np.argmin(near))
            low, high = finer[max(j - 1, 0)], finer[min(j + 1, 100)]
        least = min(least, float(near[j]))
    return least


def off_path(run: PathRun, random: np.random.Generator, farthest: float) -> np.ndarray:
    """A point up to about that far off a random place of a run, on any scale [m]."""
    place = run.evaluate(np.array([random.uniform(run.s0, run.s1)])).tip[0, 0]
    return place + 10 ** random.uniform(-6, np.log10(farthest)) * random.normal(size=3)


@pytest.mark.sweep
def test_no_point_of_300_waves_is_missed() -> None:
    """200 of 200; of 400 samples and what the field makes of the nearest of them 159 were right."""
    random = np.random.default_rng(300)
    for _ in range(200):
        path, tip = waves(300, random)
        point = off_path(path.runs[0], random, 0.1)
        found = deflection.project(path, point)
        assert found.distance <= least_distance(tip, (0.0, 1.0), point, 15001) + TOLERANCE
        assert found.within <= TOLERANCE and not found.proven
        assert found.distance == pytest.approx(np.linalg.norm(tip(np.array([found.s]))[0] - point), rel=1e-12)


def random_bspline(random: np.random.Generator) -> Path:
    """Wild curves of degree 3 to 5, of some spans or many, with knots in heaps."""
    degree, spans = int(random.integers(3, 6)), int(random.integers(1, 300))
    inner = np.sort(random.uniform(0, 1, spans - 1) ** random.choice([1, 3]))
    knots = np.concatenate([np.zeros(degree + 1), inner, np.ones(degree + 1)])
    count = len(knots) - degree - 1
    control = np.cumsum(random.normal(0, 3e-3, (count, 3)), axis=0)
    return Path.from_bspline(knots, control, control + UPRIGHT, degree)


def random_quintics(random: np.random.Generator) -> Path:
    """Quintic intervals between random states."""
    n = int(random.integers(2, 200))
    s = np.cumsum(random.uniform(1e-3, 2e-2, n))
    tip = np.stack(
        [np.cumsum(random.normal(0, 5e-3, (n, 3)), axis=0), *random.normal(0, [[[1.0]], [[50.0]]], (2, n, 3))]
    )
    return quintic_path(s, tip, np.zeros((3, n, 2)))


@pytest.mark.parametrize("kind", [random_bspline, random_quintics])
def test_no_point_of_a_random_path_is_missed(kind: Callable[[np.random.Generator], Path]) -> None:
    random = np.random.default_rng(7)
    for _ in range(50):
        path = kind(random)
        run = path.runs[0]
        point = off_path(run, random, 0.1)
        found = deflection.project(path, point)
        oracle = least_distance(lambda s, run=run: run.evaluate(s).tip[0], (run.s0, run.s1), point, 6001)
        assert found.distance <= oracle + TOLERANCE
        assert found.proven and found.within <= TOLERANCE


def test_no_point_of_a_random_arc_is_missed() -> None:
    """Against the closed form, where the angle of the point is on the arc; of many turns any is as near."""
    random = np.random.default_rng(8)
    for _ in range(60):
        start, sweep = random.normal(size=3) * [1, 1, 0], 10 ** random.uniform(-3, 1)
        radius = float(np.linalg.norm(start))
        point = random.normal(size=3)
        turn = (np.arctan2(point[1], point[0]) - np.arctan2(start[1], start[0])) % (2 * np.pi)
        ends = np.array([0.0, sweep, min(turn, sweep)]) + np.arctan2(start[1], start[0])
        there = radius * np.stack([np.cos(ends), np.sin(ends), 0 * ends], axis=1)
        found = deflection.project(Path.arc(np.zeros(3), start, UPRIGHT, sweep), point)
        assert found.distance == pytest.approx(np.linalg.norm(there - point, axis=1).min(), abs=TOLERANCE)
        assert found.proven


def test_no_point_of_a_fitted_program_is_missed() -> None:
    """Of many runs, with stops; the nearest may be on any of them."""
    random = np.random.default_rng(9)
    for seed in (1, 2, 3):
        path = Path.fit(random_toolpath(seed)[0])
        for _ in range(10):
            point = off_path(path.runs[int(random.integers(len(path.runs)))], random, 0.02)
            found = deflection.project(path, point)
            oracle = min(
                least_distance(lambda s, run=run: run.evaluate(s).tip[0], (run.s0, run.s1), point, 4001)
                for run in path.runs
            )
            assert found.distance <= oracle + TOLERANCE
            run = path.runs[found.run]
            assert run.s0 <= found.s <= run.s1 and found.proven
            np.testing.assert_array_equal(found.tip, run.evaluate(np.array([found.s])).tip[0, 0])


def test_bound_holds_between_the_marks_of_every_kind_of_path() -> None:
    """The path never strays further from a chord than its sag says: proven for all, and seen of functions."""
    random = np.random.default_rng(10)
    u = np.linspace(0, 1, 200)
    wavy = toolpath_through(np.stack([0.1 * u, 2e-3 * np.sin(40 * u), 0 * u], axis=1), np.tile(UPRIGHT, (200, 1)))
    known = [random_bspline(random), random_quintics(random), ARC, Path.fit(wavy), quintic_through(ARC, MACHINE)]
    known.append(published.flank()[0])
    functions = [waves(300, random)[0], published.fan()[0]]
    for path in [*known, *functions]:
        run = path.runs[0]
        cut = chords_of(run)
        assert cut.s[0] == run.s0 and cut.s[-1] == run.s1 and np.isin(run.breaks, cut.s).all()
        for share in np.linspace(0.05, 0.95, 19):
            s = cut.s[:-1] + share * np.diff(cut.s)
            on_chord = cut.tip[:-1] + share * np.diff(cut.tip, axis=0)
            off = np.linalg.norm(run.evaluate(s).tip[0] - on_chord, axis=1)
            assert (off <= cut.sag + 1e-15).all()
        assert cut.proven == (path in known)


def test_path_about_the_deflection_is_searched_whole_and_what_is_left_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every point of the arc is as near: there is nothing to close until the tolerance is reached."""
    found = deflection.project(ARC, np.zeros(3))
    assert found.distance == pytest.approx(0.1, abs=1e-15) and found.within <= TOLERANCE
    monkeypatch.setattr(nearest_point, "MOST_CELLS", 100)
    found = deflection.project(ARC, np.zeros(3))
    assert TOLERANCE < found.within < 1e-4


def test_tolerance_is_what_may_be_missed() -> None:
    path, _ = waves(300, np.random.default_rng(1))
    point = path.runs[0].evaluate(np.array([0.4])).tip[0, 0] + [0.0, 0.03, 0.0]
    fine, coarse = (deflection.project(path, point, tolerance=tolerance) for tolerance in (1e-12, 1e-4))
    assert coarse.steps < fine.steps and fine.within <= 1e-12 and coarse.within <= 1e-4
    assert coarse.distance <= fine.distance + coarse.within


def test_potential_field_finds_the_same_where_its_samples_see_the_valley() -> None:
    random = np.random.default_rng(11)
    for _ in range(20):
        point = off_path(ARC.runs[0], random, 0.02)
        field, bounds = (deflection.project(ARC, point, method=method) for method in ("potential", "bounds"))
        assert field.distance == pytest.approx(bounds.distance, rel=1e-12)
        assert field.within == np.inf and not field.proven


def test_potential_field_misses_valleys_of_waves() -> None:
    """Why it is not the default: where it comes to rest, it may be in another valley."""
    random = np.random.default_rng(300)
    missed = 0
    for _ in range(10):
        path, _ = waves(300, random)
        point = off_path(path.runs[0], random, 1e-3)
        try:
            field = deflection.project(path, point, method="potential")
        except UsageError:
            continue
        missed += field.distance > deflection.project(path, point).distance + 1e-6
    assert missed > 0


def test_potential_field_says_where_it_does_not_come_to_rest() -> None:
    """The path bends about the deflection: each step shrinks the error by next to nothing."""
    point = [1e-12, 0.0, 0.0]
    with pytest.raises(UsageError, match=r"not come to rest after 500 steps.*take the method 'bounds'"):
        deflection.project(ARC, point, method="potential")
    assert deflection.project(ARC, point).within <= TOLERANCE


def test_projection_takes_time_in_proportion_to_the_path() -> None:
    random = np.random.default_rng(12)

    def long(count: int) -> tuple[Path, np.ndarray]:
        s = np.linspace(0.0, count * 1e-3, count + 1)
        tip = np.zeros((3, count + 1, 3))
        tip[0] = np.stack([s, 1e-3 * random.normal(size=count + 1), 0 * s], axis=1)
        tip[1, :, 0] = 1.0
        path = quintic_path(s, tip, np.zeros((3, count + 1, 2)))
        return path, tip[0, count // 2] + [0, 0.02, 0.01]

    order = order_of_growth(lambda given: deflection.project(*given), long(20_000), long(200_000), 10.0)
    assert order < 1.3


def test_path_with_a_derivative_that_is_not_finite_is_refused() -> None:
    def root(s: np.ndarray, order: int) -> tuple[np.ndarray, np.ndarray]:
        with np.errstate(divide="ignore"):
            y = [np.sqrt(s), 0.5 / np.sqrt(s), -0.25 * s**-1.5, 0.375 * s**-2.5][order]
        return np.stack([y, 0 * s, 0 * s], axis=1), UPRIGHT * (order == 0)

    with pytest.raises(PathError, match="not finite at s = 0"):
        deflection.project(Path.from_callable(root), DEFLECTION)


def test_noise_in_the_derivatives_of_a_function_ends(monkeypatch: pytest.MonkeyPatch) -> None:
    """No halving resolves the rounding of derivatives by differences; a caller's are refused before they get so far."""
    monkeypatch.setattr(nearest_point, "MOST_UNRESOLVED", 1 << 11)
    random = np.random.default_rng(13)

    def noisy(s: np.ndarray, order: int) -> tuple[np.ndarray, np.ndarray]:
        along = s if order == 0 else np.full_like(s, order == 1)
        across = random.normal(0, 1e3**order, (2, len(s))) if order > 1 else np.zeros((2, len(s)))
        return np.stack([along, *across], axis=1), UPRIGHT * (order == 0)

    with pytest.raises(PathError, match=r"f\(s, 2\) is not the derivative of f\(s, 1\)"):
        Path.from_callable(noisy)
    found = deflection.project(Path((callable_run(noisy, 0.0, 1.0, np.inf),)), [0.3, 0.2, 0.0])
    assert found.distance == pytest.approx(0.2, abs=1e-9) and not found.proven
