"""The paper's planner: quintic laws between reference points, their periods by a genetic algorithm."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from testbed import published
from tests.support.usage import dense_usage
from toolpace.common.errors import InfeasibleError, UsageError
from toolpace.kernels.planners import quintic_interval
from toolpace.machine.limits import Limits
from toolpace.machine.machine import Machine
from toolpace.motion.trajectory import Trajectory
from toolpace.path.axis_path import AxisPath
from toolpace.path.path import Path
from toolpace.planning.limit_tolerances import PROMISED
from toolpace.planning.planned_run import EndState
from toolpace.planning.planner import plan


@pytest.fixture(scope="module")
def arc() -> tuple[AxisPath, Limits]:
    machine = Machine.load("paper-ab")
    return AxisPath.follow(Path.paper_arc(), machine), machine.limits


def genetic(path: AxisPath, limits: Limits, **options: object) -> Trajectory:
    return plan(path, limits, planner="genetic", **options)


def test_law_of_an_interval_meets_its_ends() -> None:
    c = np.polynomial.Polynomial([0.0, *quintic_interval.law(0.3, 1.0, -2.0, 1.4, 3.0, 0.25)])
    at = [c.deriv(k)(x) / 0.25**k if k else c(x) for x in (0.0, 1.0) for k in range(3)]
    assert at == pytest.approx([0.0, 1.0, -2.0, 0.3, 1.4, 3.0])


def test_paper_arc_within_all_limits_and_slower_than_optimal(arc: tuple[AxisPath, Limits]) -> None:
    trajectory = genetic(*arc)
    assert trajectory.usage().worst <= PROMISED
    assert dense_usage(trajectory, 200_000) <= PROMISED
    assert 5.3112 < trajectory.duration < 5.65
    assert trajectory.planner == "genetic" and len(trajectory.laws[0].periods) == 31
    assert trajectory.duration == pytest.approx(trajectory.laws[0].periods.sum())


def test_duration_falls_with_generations(arc: tuple[AxisPath, Limits]) -> None:
    """Every run continues the shorter one with the same seed, and the best individual lives on."""
    durations = [genetic(*arc, generations=n).duration for n in (0, 1, 3, 10, 30, 100)]
    assert all(a >= b for a, b in itertools.pairwise(durations))
    assert durations[-1] < durations[1] - 0.02


def test_evolving_the_preset_speeds_shortens_further(arc: tuple[AxisPath, Limits]) -> None:
    durations = [genetic(*arc, generations=10, evolve=n) for n in (0, 2, 6)]
    assert all(a.duration > b.duration for a, b in itertools.pairwise(durations))
    assert durations[-1].usage().worst <= PROMISED


def test_same_seed_same_plan_other_seed_other_plan(arc: tuple[AxisPath, Limits]) -> None:
    one, same, other = (genetic(*arc, seed=seed) for seed in (1, 1, 2))
    assert one.duration == same.duration != other.duration


def test_roulette_selects_too(arc: tuple[AxisPath, Limits]) -> None:
    trajectory = genetic(*arc, selection="roulette", generations=20)
    assert trajectory.usage().worst <= PROMISED
    assert trajectory.duration < genetic(*arc, generations=0).duration


def test_continuous_to_the_acceleration_and_at_rest_at_the_ends(arc: tuple[AxisPath, Limits]) -> None:
    trajectory = genetic(*arc)
    law = trajectory.laws[0]
    before, after = (trajectory.at(law.times[1:-1] + d) for d in (-1e-9, 1e-9))
    for kind, scale in (("q", 1e-8), ("qd", 1e-7), ("qdd", 1e-6)):
        np.testing.assert_allclose(getattr(before, kind), getattr(after, kind), atol=scale)
    ends = trajectory.at([0.0, trajectory.duration])
    assert np.abs(ends.qd).max() < 1e-12 and np.abs(ends.qdd).max() < 1e-9


def test_law_is_its_own_derivative(arc: tuple[AxisPath, Limits]) -> None:
    law = genetic(*arc).laws[0]
    t = np.linspace(0.0, law.duration, 500)[1:-1]
    t = t[np.abs(t[:, None] - law.times).min(axis=1) > 1e-4]
    for order in range(3):
        low, high = (law.at(t + d)[order] for d in (-1e-6, 1e-6))
        np.testing.assert_allclose((high - low) / 2e-6, law.at(t)[order + 1], atol=1e-4)


@pytest.mark.parametrize("name, most", [("flank", 1.2), ("fan", 1.1)])
def test_published_paths_are_planned(name: str, most: float) -> None:
    path, machine = getattr(published, name)()
    axis_path = AxisPath.follow(path, machine)
    ours, best = genetic(axis_path, machine.limits), plan(axis_path, machine)
    assert ours.usage().worst <= PROMISED and dense_usage(ours, 200_000) <= PROMISED
    assert best.duration < ours.duration < most * best.duration


@pytest.mark.parametrize("seed", range(6))
def test_random_paths_and_limits(seed: int) -> None:
    random = np.random.default_rng(seed)
    joints = int(random.integers(1, 7))
    phase, rate = random.uniform(0, 6, joints), random.uniform(0.5, 9, joints)
    limits = Limits(*(random.uniform(0.3, 3, joints) * 10**k for k in range(3)))

    def wave(s: np.ndarray, order: int) -> np.ndarray:
        return rate**order * np.sin(s[:, None] * rate + phase + order * np.pi / 2)

    trajectory = genetic(AxisPath.from_callable(wave), limits)
    assert trajectory.usage().worst <= PROMISED and dense_usage(trajectory, 200_000) <= PROMISED


def test_moving_ends(arc: tuple[AxisPath, Limits]) -> None:
    run = arc[0].runs[0]
    state = EndState(0.9 * float(run.speed_cap(np.array([run.s0]))[0]))
    trajectory = genetic(*arc, start=state, end=state)
    assert trajectory.usage().worst <= PROMISED
    assert trajectory.state(0.0)[1] == pytest.approx(state.speed)
    assert trajectory.state(trajectory.duration)[1] == pytest.approx(state.speed)


def test_breaks_are_reference_points() -> None:
    limits = Limits([1.0, 1.0], [10.0, 10.0], [100.0, 100.0])
    path = AxisPath.from_callable(
        lambda s, order: np.stack([s, s**2] if order == 0 else [1 + 0 * s, 2 * s] if order == 1
                                  else [0 * s, 2 + 0 * s] if order == 2 else [0 * s, 0 * s], axis=-1),
        speed_cap=lambda s: np.where(s < 0.37, 0.2, 0.5), breaks=[0.37],
    )  # fmt: skip
    trajectory = genetic(path, limits, intervals=8)
    assert 0.37 in trajectory.laws[0].s
    assert trajectory.usage().worst <= PROMISED


def test_no_individual_names_interval_and_limit(arc: tuple[AxisPath, Limits]) -> None:
    """Arriving at full feed with an acceleration that cannot be had so close to the end."""
    run = arc[0].runs[0]
    cap = float(run.speed_cap(np.array([run.s0]))[0])
    end = EndState(cap, 30.0 * cap)
    with pytest.raises(InfeasibleError, match=r"interval 31 of 31, s = .* of the .* give more intervals"):
        genetic(*arc, end=end)


@pytest.mark.parametrize(
    "options, words",
    [
        ({"population": 1}, "population is 1"),
        ({"bits": 16}, "bits is 16"),
        ({"selection": "luck"}, "known are tournament, roulette"),
        ({"mutations": 1}, "no option 'mutations'; did you mean 'mutation'"),
        ({"intervals": 1}, "1 intervals"),
        ({"reserve": 0.0}, "reserve is 0"),
    ],
)
def test_bad_options(arc: tuple[AxisPath, Limits], options: dict[str, object], words: str) -> None:
    with pytest.raises(UsageError, match=words):
        genetic(*arc, **options)
