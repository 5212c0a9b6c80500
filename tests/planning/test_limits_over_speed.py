"""Limits that fall with the speed of a joint: against IPOPT, between the nodes, bound, prices, and by constants."""

from __future__ import annotations

import pickle
from dataclasses import replace

import numpy as np
import pytest

from tests.support.random_paths import harmonics, random_limits
from toolpace.common.errors import UsageError
from toolpace.judge import verify
from toolpace.kernels.optimal.dual import lowest_with_root
from toolpace.machine.limit_curves import SIDES, CurvedLimit, LimitCurve
from toolpace.machine.limits import Limits
from toolpace.machine.rows import Rows
from toolpace.path.axis_path import AxisPath
from toolpace.planning.bound.branch_and_bound import Allowance
from toolpace.planning.bound.falling_limits import least_over_choices, lifted, limits_at, planes_above
from toolpace.planning.bound.prove import prove_run
from toolpace.planning.bound.relaxation import bound_run, coefficients, problem_of
from toolpace.planning.optimal.own_rows import LineRows
from toolpace.planning.optimal.planner import fastest_law
from toolpace.planning.optimal.solve import slower, solve
from toolpace.planning.planned_run import AT_REST
from toolpace.planning.planner import plan


def random_curve(rng, speed, limit, concave=True):
    """A curve with a knee below the speed that a joint reaches, and another where it falls more steeply or less."""
    knee = rng.uniform(0.2, 0.5)
    v = speed * np.array([0.0, knee, rng.uniform(knee + 0.1, 0.8), 1.0])
    first = rng.uniform(0.6, 0.95) if concave else rng.uniform(0.3, 0.6)
    fall = (1.0 - first) / (v[2] - v[1]) * (v[3] - v[2])
    last = max(first - fall * (rng.uniform(1.0, 3.0) if concave else rng.uniform(0.0, 1.0)), 0.05)
    return LimitCurve(np.stack([v, limit * np.array([1.0, 1.0, first, last])], axis=1))


def curved(seed, joints=3, jerk=False, concave=True):
    """A random path, and limits with curves of accelerations, and of jerks, that fall at speeds that it reaches."""
    rng = np.random.default_rng(seed)
    path, limits = AxisPath.from_callable(harmonics(seed, joints)), random_limits(seed, joints, seed % 2 == 1)
    free = plan(path, limits, bound=False)
    fastest = np.abs(free.at(np.linspace(0.0, free.duration, 2001)).qd).max(axis=0)
    curves = []
    for j, joint in enumerate(limits.joints):
        for kind in ("acceleration", "jerk")[: 1 + jerk]:
            sides = "at any" if kind == "jerk" else list(SIDES)[int(rng.integers(3))]
            limit = float(getattr(limits, kind)[j])
            mine = tuple(random_curve(rng, fastest[j], limit, concave) for _ in SIDES[sides])
            curves.append(CurvedLimit(joint, kind, mine, sides))
    return path, replace(limits, curves=curves), free


def largest_shares(trajectory, limits, count=10_000):
    """By curve the largest share that differences over the time show: they know no path, law or row. Third differences
    of more points than these are rounding."""
    t = np.linspace(0.0, trajectory.duration, count + 1)
    q = trajectory.at(t).q
    shares = {}
    for curve in limits.curves:
        j, order = limits.joints.index(curve.joint), 2 if curve.kind == "acceleration" else 3
        value, step = np.diff(q[:, j], order) / t[1] ** order, np.diff(q[:, j]) / t[1]
        speeds = (q[order:, j] - q[:-order, j]) / (order * t[1]), step[: len(value)], step[order - 1 :]

        def limit_at(speed, curve=curve, value=value):
            forth = value * speed >= 0.0 if curve.sides == "speeding up" else value >= 0.0
            sides = [np.interp(np.abs(speed), each.speed, each.limit) for each in (curve.curves[0], curve.curves[-1])]
            turns = (np.abs(speed) < 1e-3 * np.abs(speed).max()) & (curve.sides == "speeding up")
            return np.where(turns, np.maximum(*sides), np.where(forth, *sides))

        # a difference is a mean of what is within the mean of the limits
        mean, first, last = map(limit_at, speeds)
        limit = np.maximum(mean, (first + last) / 2.0)
        shares[curve.name] = float((np.abs(value) / limit).max())
    return shares


def compared_with_ipopt(seed, **options):
    pytest.importorskip("casadi")
    from testbed import ipopt

    path, limits, _ = curved(seed, 2 + seed % 3, **options)
    law, _ = fastest_law(path.runs[0], limits.over_speed(), cells=100, guard=False)
    best = ipopt.optimum(path, limits.over_speed(), 100)
    assert best.note == ipopt.SUCCEEDED
    return law.duration / best.law.duration


@pytest.mark.parametrize(("seed", "jerk"), [(1, False), (2, True)])
def test_motions_within_curves_are_ipopts_optimum(seed, jerk):
    assert abs(compared_with_ipopt(seed, jerk=jerk) - 1.0) < 1e-4


@pytest.mark.thorough
@pytest.mark.parametrize("seed", range(100, 160))
def test_motions_within_curves_are_ipopts_optimum_on_many(seed):
    assert abs(compared_with_ipopt(seed, jerk=seed % 2 == 0) - 1.0) < 1e-4


def assert_holds(seed, concave=True, **options):
    path, limits, free = curved(seed, concave=concave, **options)
    trajectory = plan(path, limits)
    shares = largest_shares(trajectory, limits)
    assert max(shares.values()) <= 1.0001
    assert trajectory.usage().worst <= 1.0001
    assert trajectory.gap < (0.005 if concave else 0.015)
    assert free.duration <= trajectory.duration * (1.0 + 1e-4)
    assert verify(trajectory, limits, dt=trajectory.duration / 4000).ok
    return trajectory, limits


@pytest.mark.sweep
def test_curves_hold_between_nodes_and_are_named_bounded_and_priced():
    trajectory, limits = assert_holds(4)
    assert max(trajectory.usage().rows.values()) > 0.99
    named = {curve.name for curve in limits.curves}
    assert named < set(trajectory.active().names) and named & set(trajectory.limited_by())
    prices = trajectory.prices()
    dearest = max(named, key=prices.get)
    raised = [curve.scaled(1.0, 1.01 if curve.name == dearest else 1.0) for curve in limits.curves]
    # its largest value, which has a price of its own, grows with it
    largest = prices[dearest.replace("curve ", "")]
    gain = trajectory.duration - plan(trajectory.axis_path, replace(limits, curves=raised), bound=False).duration
    assert abs(prices[dearest] + largest - gain) <= max(0.1 * gain, 1e-4 * trajectory.duration)


@pytest.mark.sweep
@pytest.mark.parametrize("seed", range(200, 206))
def test_curves_hold_between_nodes_on_some(seed):
    assert_holds(seed, jerk=seed % 2 == 0, concave=seed % 3 > 0)


@pytest.mark.thorough
@pytest.mark.parametrize("seed", range(206, 240))
def test_curves_hold_between_nodes_on_many(seed):
    assert_holds(seed, jerk=seed % 2 == 0, concave=seed % 3 > 0)


def test_the_lines_of_a_curve_give_the_curve():
    rng = np.random.default_rng(3)
    for _ in range(50):
        corners = int(rng.integers(1, 7))
        speed = np.append(0.0, np.sort(rng.uniform(0.05, 1.0, corners - 1)))
        curve = LimitCurve(np.stack([speed, np.sort(rng.uniform(0.1, 2.0, corners))[::-1]], axis=1))
        v = np.linspace(0.0, 1.2, 200)
        height, fall = np.moveaxis(curve.lines(np.inf, np.inf), 2, 0)
        found = (height - fall * v[:, None, None]).max(axis=2).min(axis=1)
        assert np.allclose(found, curve.at(v), rtol=1e-12)


def test_the_bound_is_below_every_motion_within_the_curves():
    path, limits, _ = curved(9, 2)
    run, held = path.runs[0], limits.over_speed()
    law, _ = fastest_law(run, held, cells=60, guard=False)
    bound = bound_run(run, held, law)
    assert bound.gap < 0.01
    # on the same mesh with the rows at the nodes themselves, slower motions and other ones
    problem = problem_of(run, held, law, AT_REST, AT_REST)
    assert problem.lines is not None and not problem.lines.ahead.any()
    for share in (1.0, 0.9):
        assert problem.time(share * coefficients(law)) >= bound.mesh_bound


def test_a_proof_of_a_plan_within_curves_is_a_bound_and_closes_most_of_its_gap():
    path, limits, _ = curved(5, concave=False)
    run, held = path.runs[0], limits.over_speed()
    law, _ = fastest_law(run, held, cells=50, guard=False)
    problem = problem_of(run, held, law, AT_REST, AT_REST)
    # the best with the rows at the nodes themselves, as the bound has them
    best = problem.time(solve(problem, slower(problem, coefficients(law), 0.1), 0.1))
    loose = bound_run(run, held, law)
    proved = prove_run(run, held, law, 1e-7, Allowance(knots=1500 * len(law.nodes)))
    assert loose.mesh_bound < proved.mesh_bound <= best
    assert best - proved.mesh_bound < 0.2 * (best - loose.mesh_bound)


def test_limits_without_the_curve_that_they_stay_below_give_the_same_motion():
    """A curve that falls only at speeds beyond those that are reached holds nothing."""
    path, limits = AxisPath.from_callable(harmonics(5, 2)), random_limits(5, 2)
    free = plan(path, limits, mesh=300, bound=False)
    fastest = float(np.abs(free.at(np.linspace(0.0, free.duration, 2001)).qd[:, 0]).max())
    a = float(limits.acceleration[0])
    curve = LimitCurve([[0.0, a], [1.2 * fastest, a], [2.0 * fastest, 0.2 * a]])
    held = replace(limits, curves=[CurvedLimit("q1", "acceleration", (curve,))])
    assert held.acceleration[0] == 0.2 * a
    same = plan(path, held, mesh=300, bound=False)
    assert same.duration == pytest.approx(free.duration, rel=1e-4)


def test_rows_of_ones_own_have_limits_that_depend_on_the_speed():
    """Lines above and below that a row tells by itself: those of a joint's curve give the same motion."""
    path, limits, _ = curved(7, 2)
    curve = next(each for each in limits.curves if each.joint == "q1")
    plain = replace(limits, curves=[each for each in limits.curves if each is not curve])
    plain = replace(plain, acceleration=[curve.largest, plain.acceleration[1]])
    own = replace(curve.rows(0, float(limits.velocity[0])), name="motor")
    options = {"mesh": 200, "bound": False}
    same = plan(path, plain, rows=[own], **options)
    assert same.duration == pytest.approx(plan(path, limits, **options).duration, rel=1e-6)
    assert same.usage().rows["motor"] <= 1.0001 and verify(same, plain, rows=[own]).ok
    wrong = replace(own, lines=lambda q: (np.ones((3, 1, 1, 2)), np.ones((3, 1, 1, 2))))
    with pytest.raises(UsageError, match="motor: lines of shape"):
        plan(path, plain, rows=[wrong])


def test_who_knows_constants_takes_the_least_value():
    path, limits, _ = curved(3, 2)
    assert (limits.acceleration == [curve.least for curve in limits.curves]).all()
    for planner in ("genetic", "second-order"):
        motion = plan(path, limits, planner=planner)
        acceleration = motion.at(np.linspace(0.0, motion.duration, 2000)).qdd
        assert (np.abs(acceleration).max(axis=0) <= limits.acceleration * 1.0001).all()


def test_limits_with_curves_are_values():
    _, limits, _ = curved(3, 2)
    again = pickle.loads(pickle.dumps(limits))
    assert again == limits and hash(again) == hash(limits) and again != limits.scaled(acceleration=1.1)
    held = limits.over_speed()
    assert held.constants is limits and limits.constants is limits
    assert held.scaled(acceleration=2.0).names == held.names
    assert (limits.scaled(velocity=2.0).curves[0].curves[0].speed == 2.0 * limits.curves[0].curves[0].speed).all()
    assert (limits.largest.acceleration >= limits.acceleration).all() and not limits.largest.curves


def test_the_judge_sees_a_curve_that_is_exceeded():
    path, limits, _ = curved(6, 2)
    trajectory = plan(path, limits, mesh=150, bound=False)
    dt = trajectory.duration / 4000
    assert verify(trajectory, limits, dt=dt).ok and verify(trajectory, trajectory.limits, dt=dt).ok
    # a curve that is lower, but for its ends
    lower = []
    for each in limits.curves:
        inner = [np.stack([c.speed, c.limit * np.where(c.limit < c.largest, 0.995, 1.0)], axis=1) for c in each.curves]
        lower.append(CurvedLimit(each.joint, each.kind, tuple(map(LimitCurve, inner)), each.sides))
    found = verify(trajectory, replace(limits, curves=lower), dt=dt)
    assert {check.name for check in found.findings} == {f"acceleration over speed of {j}" for j in limits.joints}
    # a difference is a mean: what it shows of a limit is not far from what is used
    used = trajectory.usage().rows
    for check in found.findings:
        assert check.value / check.limit == pytest.approx(used[f"acceleration curve {check.joint}"] / 0.995, abs=5e-4)


def flat(joint):
    return CurvedLimit(joint, "jerk", (LimitCurve([[0.0, 1.0]]),))


@pytest.mark.parametrize(("make", "message"), [
    (lambda: LimitCurve([[0.0, 1.0], [1.0, 2.0]]), "rises from 1 to 2 at speed 1"),
    (lambda: LimitCurve([[0.5, 1.0]]), "begins at speed 0.5"),
    (lambda: LimitCurve([[0.0, 1.0], [0.0, 0.5]]), "speed 0 comes after 0"),
    (lambda: LimitCurve([[0.0, 1.0], [1.0, 0.0]]), "is 0 at speed 1"),
    (lambda: LimitCurve(np.empty((0, 2))), "has 0 corners"),
    (lambda: LimitCurve([1.0, 2.0]), "give corners like"),
    (lambda: CurvedLimit("X", "velocity", (LimitCurve([[0.0, 1.0]]),)), "kind is 'velocity'"),
    (lambda: CurvedLimit("X", "acceleration", (), "braking"), "0 curves for 'braking'"),
    (lambda: CurvedLimit("X", "jerk", 2 * (LimitCurve([[0.0, 1.0]]),), "upwards"), "one curve for all motion"),
    (lambda: Limits(1, 1, 1, ["X"], curves=[flat("Y")]), "curve of joint Y"),
    (lambda: Limits(1, 1, 1, ["X"], curves=[flat("X"), flat("X")]), "two curves"),
    (lambda: Limits(1, 1, 1, ["X"], curves=[3]), "int in place of a curve"),
    (lambda: Rows("own", "", 1.0, np.ones_like, lines=np.ones_like, pieces=0), "pieces is 0"),
])  # fmt: skip
def test_mistakes_are_told(make, message):
    with pytest.raises(UsageError, match=message):
        make()


def random_lines(rng, points, rows, choices):
    """Limits of acceleration and of jerk, each the largest of some lines."""
    height, fall = rng.uniform(0.2, 2.0, (2, points, rows, choices)) * np.array([1.0, 1.5])[:, None, None, None]
    is_jerk = rng.uniform(size=rows) < 0.5
    return LineRows(np.arange(rows), is_jerk, np.zeros((points, rows, 3)), height, fall, np.zeros(points))


def test_the_least_over_choices_is_that_of_a_fine_grid():
    rng = np.random.default_rng(5)
    x = np.linspace(1e-5, 1.0, 100_001)
    for _ in range(40):
        lines = random_lines(rng, 2, int(rng.integers(1, 4)), int(rng.integers(2, 4)))
        price, theta, root = rng.uniform(0, 0.3, (2, len(lines.column))), rng.normal(0, 1, 1), np.ones(1)
        # of jerk they leave something of the price of the pace next to rest
        paid = np.where(lines.is_jerk, price * lines.height.max(axis=2), 0.0).sum()
        kappa = paid + rng.uniform(0, 1, 1)
        found = least_over_choices(lines, price, kappa, theta, root, np.array([0, 2]))
        limit = (lines.height[..., None] - lines.fall[..., None] * x).max(axis=2)
        limit = np.where(lines.is_jerk[:, None], limit / x, limit)
        grid = kappa / x + theta * x**2 - (price[..., None] * limit).sum(axis=(0, 1))
        assert grid.min() - 1e-3 <= found[0] <= grid.min() + 1e-12


def test_planes_touch_a_limit_and_lie_above_it():
    rng = np.random.default_rng(8)
    lines = random_lines(rng, 200, 4, 3)
    x, high = rng.uniform(0.1, 0.9, (200, 4)), np.ones((200, 4))
    planes = planes_above(lines, x, high)
    assert np.allclose(planes.at(x), limits_at(lines, x), rtol=1e-9, atol=1e-12)
    grid = [np.full((200, 4), v) for v in np.linspace(0.03, 1.0, 500)]
    above = np.min([(planes.at(v) - limits_at(lines, v)) / (1.0 + np.abs(limits_at(lines, v))) for v in grid], axis=0)
    # within NEAREST of where two lines meet they may pass below, by that share of a fall of 2 at most
    assert above.min() > -0.04 and np.mean(above < -1e-3) < 0.15
    exact = lifted(lines, planes, high[:, 0])
    assert min((exact.at(v) - limits_at(lines, v)).min() for v in grid) >= 0.0
    assert np.median(exact.at(x) - limits_at(lines, x)) < 1e-6


def test_the_least_with_a_root_is_that_of_a_fine_grid():
    rng = np.random.default_rng(6)
    x = np.linspace(1e-5, 1.3, 100_001)
    for _ in range(200):
        kappa, theta, root = rng.uniform(0.0, 1.0), rng.normal(0.0, 1.0), rng.normal(0.3, 1.0)
        grid = kappa / x + theta * x**2 + root * x
        found = lowest_with_root(kappa, theta, root, 0.0, 1.3**2)
        assert grid.min() - 1e-3 <= found <= grid.min() + 1e-12
