"""Rows of one's own: against limits of joints that say the same, IPOPT, differences over time, and the judge."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest

from tests.support.random_paths import harmonics, random_limits
from toolpace.common.errors import InfeasibleError, UsageError
from toolpace.judge import verify
from toolpace.machine.limits import Limits
from toolpace.machine.machine import Machine
from toolpace.machine.rows import Rows, derivatives_along
from toolpace.path.axis_path import AxisPath
from toolpace.path.path import Path
from toolpace.planning.optimal.planner import fastest_law
from toolpace.planning.planned_run import EndState
from toolpace.planning.planner import plan


def part(q):
    """Where a part is that an arm of three joints carries: (n, 2)."""
    return np.stack([0.3 * np.sin(q[:, 0]) + q[:, 1], 0.3 * np.cos(q[:, 0]) + 0.5 * q[:, 2] * q[:, 1]], axis=1)


def peaks_over_time(trajectory, quantity, order, count=10_000):
    """(k,) largest difference of a quantity over the time, by so many even steps: it knows no path and no law."""
    t = np.linspace(0.0, trajectory.duration, count + 1)
    return np.abs(np.diff(quantity(trajectory.at(t).q), order, axis=0)).max(axis=0) / t[1] ** order


def problem_with_rows(seed, share=0.4):
    """A random path, limits of its joints, and rows of a carried part at a share of what it does without them."""
    joints = 3 + seed % 3
    path, limits = AxisPath.from_callable(harmonics(seed, joints)), random_limits(seed, joints, seed % 2 == 1)
    free = plan(path, limits, bound=False)
    acceleration, jerk = (share * float(peaks_over_time(free, part, order).max()) for order in (2, 3))
    return path, limits, [
        Rows.acceleration_of("part", "m/s^2", acceleration, part, 2), Rows.jerk_of("jolt", "m/s^3", jerk, part, 2),
    ]  # fmt: skip


def compared_with_ipopt(seed):
    pytest.importorskip("casadi")
    from testbed import ipopt

    path, limits, rows = problem_with_rows(seed)
    held = replace(limits, rows=tuple(rows))
    law, _ = fastest_law(path.runs[0], held, cells=100, guard=False)
    best = ipopt.optimum(path, held, 100)
    assert best.note == ipopt.SUCCEEDED
    return law.duration / best.law.duration


@pytest.mark.parametrize("seed", range(2))
def test_motions_with_rows_are_ipopts_optimum(seed):
    assert abs(compared_with_ipopt(seed) - 1.0) < 1e-4


@pytest.mark.parametrize(
    "seed",
    [pytest.param(seed, marks=pytest.mark.sweep if seed < 110 else pytest.mark.thorough) for seed in range(100, 160)],
)
def test_motions_with_rows_are_ipopts_optimum_on_many(seed):
    assert abs(compared_with_ipopt(seed) - 1.0) < 1e-4


def assert_holds(seed):
    path, limits, rows = problem_with_rows(seed)
    trajectory = plan(path, limits, rows=rows)
    for each, order in zip(rows, (2, 3)):
        # third differences of more points than these are rounding
        assert peaks_over_time(trajectory, part, order).max() <= each.limit * (1.0 + 1e-4)
    assert 0.99 < max(trajectory.usage().rows.values()) <= trajectory.usage().worst <= 1.0001
    assert trajectory.gap < 0.01
    return trajectory, rows


def test_rows_hold_between_nodes_and_are_named_bounded_and_priced():
    trajectory, rows = assert_holds(4)
    assert trajectory.limited_by()["part"] > 0.1 and "jolt" in trajectory.active().names
    prices = trajectory.prices()
    powers = dict(zip(trajectory.limits.names, trajectory.limits.orders + 1))
    total = sum(powers[name] * price for name, price in prices.items())
    assert total == pytest.approx(0.01 * trajectory.duration, rel=1e-3)
    raised = [replace(rows[0], limit=1.01 * rows[0].limit), rows[1]]
    limits = replace(trajectory.limits, rows=())
    gain = trajectory.duration - plan(trajectory.axis_path, limits, rows=raised, bound=False).duration
    assert abs(prices["part"] - gain) <= max(0.1 * gain, 1e-4 * trajectory.duration)


@pytest.mark.sweep
@pytest.mark.parametrize("seed", range(200, 210))
def test_rows_hold_between_nodes_on_many(seed):
    assert_holds(seed)


def test_rows_that_say_what_limits_of_joints_say_give_the_same_motion():
    f, limits = harmonics(5, 3), random_limits(5, 3)
    path, free = AxisPath.from_callable(f), np.full(3, np.inf)
    by_rows = [
        kind(f"{name} {k}", "", float(figure[k]), lambda q, k=k: q[:, k])
        for kind, name, figure in (
            (Rows.acceleration_of, "a", limits.acceleration), (Rows.jerk_of, "j", limits.jerk)
        )
        for k in range(3)
    ]  # fmt: skip
    options = {"mesh": 400, "bound": False}
    same = plan(path, Limits(limits.velocity, free, free), rows=by_rows, **options)
    assert same.duration == pytest.approx(plan(path, limits, **options).duration, rel=1e-4)


def test_derivatives_along_a_path_are_exact():
    """A cubic path and a quantity that is a polynomial of it, of degree 6: exact but for rounding."""
    s = np.array([0.0, 0.4, 1.3])
    first, second = np.polynomial.Polynomial([0.1, 0.3, -0.2, 0.05]), np.polynomial.Polynomial([0.7, -0.2, 0.1, 0.3])
    q = np.stack([[p.deriv(k)(s) if k else p(s) for p in (first, second)] for k in range(4)]).transpose(0, 2, 1)
    found = derivatives_along(lambda x: x[:, :1] * x[:, 1:], q, 1, "product")
    wanted = [(first * second).deriv(k)(s) for k in (1, 2, 3)]
    assert np.allclose(found[:2, :, 0], wanted[:2], rtol=1e-9)
    assert np.allclose(found[2, :, 0], wanted[2], rtol=1e-6)


class Chain(NamedTuple):
    """Links in a row that move level: lengths and centres [m], masses [kg], inertias [kg m^2], each (n,)."""

    length: np.ndarray
    centre: np.ndarray
    mass: np.ndarray
    spin: np.ndarray

    @classmethod
    def random(cls, seed, count):
        rng = np.random.default_rng(seed)
        length = rng.uniform(0.2, 0.6, count)
        return cls(length, length * rng.uniform(0.3, 0.7, count), *rng.uniform(0.1, 5.0, (2, count)))

    def reach(self, k):
        """(n,) from joint to joint up to link k, and to its centre."""
        return np.append(self.length[:k], self.centre[k])

    def torques(self, q):
        """Coefficients (n, joints, 2) of z' and z by virtual work, from the joints q (4, n, joints)."""
        angle, first, second = (np.cumsum(q[order], axis=1) for order in range(3))
        across = np.stack([-np.sin(angle), np.cos(angle)], axis=2)
        along = np.stack([np.cos(angle), np.sin(angle)], axis=2)
        out = np.zeros((*angle.shape, 2))
        for k in range(len(self.mass)):
            arms = self.reach(k)[:, None] * across[:, : k + 1]
            turn = self.reach(k)[:, None] * along[:, : k + 1]
            slope = (arms * first[:, : k + 1, None]).sum(axis=1)
            bend = (arms * second[:, : k + 1, None] - turn * first[:, : k + 1, None] ** 2).sum(axis=1)
            for j in range(k + 1):
                by = arms[:, j:].sum(axis=1)
                for column, place, spun in ((0, slope / 2.0, first[:, k] / 2.0), (1, bend, second[:, k])):
                    out[:, j, column] += self.mass[k] * (by * place).sum(axis=1) + self.spin[k] * spun
        return out

    def torques_over_time(self, trajectory, count=20_000):
        """(n, joints) by Newton: forces are masses times second differences of the centres, and each joint bears what
        the links behind it do about it."""
        t = np.linspace(0.0, trajectory.duration, count + 1)
        angle = np.cumsum(trajectory.at(t).q, axis=1)
        along = np.stack([np.cos(angle), np.sin(angle)], axis=2)
        tips = np.cumsum(self.length[:, None] * along, axis=1)
        joints = np.concatenate([np.zeros_like(tips[:, :1]), tips[:, :-1]], axis=1)
        centres = joints + self.centre[:, None] * along
        force = self.mass[:, None] * np.diff(centres, 2, axis=0) / t[1] ** 2
        moment = self.spin * np.diff(angle, 2, axis=0) / t[1] ** 2
        found = np.zeros_like(moment)
        for j in range(len(self.mass)):
            lever = (centres[:, j:] - joints[:, j : j + 1])[1:-1]
            turning = lever[:, :, 0] * force[:, j:, 1] - lever[:, :, 1] * force[:, j:, 0]
            found[:, j] = (turning + moment[:, j:]).sum(axis=1)
        return found


def assert_torques_hold(seed, count):
    path, limits = AxisPath.from_callable(harmonics(seed, count)), random_limits(seed, count)
    chain = Chain.random(seed, count)
    most = 0.5 * np.abs(chain.torques_over_time(plan(path, limits, bound=False))).max(axis=0)
    rows = [Rows(f"torque {k}", "N m", float(most[k]), lambda q, k=k: chain.torques(q)[:, k]) for k in range(count)]
    trajectory = plan(path, limits, rows=rows)
    used = np.abs(chain.torques_over_time(trajectory)).max(axis=0) / most
    assert (used <= 1.0 + 1e-4).all() and used.max() > 0.99
    assert trajectory.gap < 0.01
    assert verify(trajectory, replace(limits, rows=tuple(rows))).ok


def test_torques_of_an_arm_hold_by_newtons_laws():
    assert_torques_hold(7, 2)


@pytest.mark.sweep
@pytest.mark.parametrize("seed", range(300, 307))
def test_torques_of_chains_hold_by_newtons_laws(seed):
    assert_torques_hold(seed, 1 + seed % 7)


def test_the_judge_sees_a_row_that_is_exceeded():
    path, limits, rows = problem_with_rows(1)
    trajectory = plan(path, limits, rows=rows, bound=False)
    assert verify(trajectory, limits, rows=rows).ok
    coefficients = [Rows(each.name, each.unit, each.limit, each.function, each.kind, 2) for each in rows]
    assert verify(trajectory, limits, rows=coefficients).ok
    for own in (rows, coefficients):
        tighter = [replace(each, limit=0.998 * each.limit) for each in own]
        assert {check.name for check in verify(trajectory, limits, rows=tighter).findings} == {"part", "jolt"}
    assert verify(trajectory, trajectory.limits).ok


def test_the_tip_of_a_program_keeps_its_acceleration():
    machine = Machine.load("xyzac-trunnion")
    path = Path.paper_arc(feed=0.05)
    free = plan(path, machine, bound=False)
    peaks = peaks_over_time(free, lambda q: machine.forward(q)[0], 2, 2000)
    rows = Rows.acceleration_of("tip", "m/s^2", 0.5 * float(peaks.max()), lambda q: machine.forward(q)[0], 3)
    held = plan(path, machine, rows=[rows], bound=False)
    assert held.duration > free.duration
    assert peaks_over_time(held, lambda q: machine.forward(q)[0], 2, 2000).max() <= rows.limit * (1.0 + 1e-4)
    assert verify(held, machine, rows=[rows]).ok


def test_mistakes_are_told():
    path, limits = AxisPath.from_callable(harmonics(1, 2)), random_limits(1, 2)

    def rows(function=lambda q: np.ones((q.shape[1], 2)), name="own", **more):
        return [Rows(name, "m", 1.0, function, **more)]

    for wrong, message in (
        (lambda q: np.ones((q.shape[1], 3)), r"own: the function gives shape \(\d+, 3\)"),
        (lambda q: np.full((q.shape[1], 2), np.nan), "own: the function gives nan"),
        (lambda q: [[1.0, 2.0], [3.0]], "own: the function gives list of no real numbers"),
        (lambda q: np.ones((q.shape[1], 2), dtype=complex), "own: the function gives ndarray of no real numbers"),
    ):
        with pytest.raises(UsageError, match=message):
            plan(path, limits, rows=rows(wrong))
    # below zero at rest no motion begins
    lines = [lambda q, height=height: np.tile([height, 1.0], (q.shape[1], 1, 1, 1)) for height in (2.0, -0.1)]
    with pytest.raises(UsageError, match=r"own: lines of -0.1 m at rest with the joints at .* give lines above zero"):
        plan(path, limits, rows=rows(lines=lambda q: [side(q) for side in lines]))
    with pytest.raises(UsageError, match="quantity has shape"):
        plan(path, limits, rows=[Rows.acceleration_of("own", "", 1.0, lambda q: q)])
    with pytest.raises(UsageError, match="rows named 'feed'"):
        plan(path, limits, rows=rows(name="feed"))
    with pytest.raises(UsageError, match="genetic holds no rows"):
        plan(path, limits, rows=rows(), planner="genetic")
    with pytest.raises(UsageError, match="str in place of rows"):
        plan(path, limits, rows=["slosh"])
    with pytest.raises(UsageError, match="give 'acceleration' or 'jerk'"):
        rows(kind="snap")
    with pytest.raises(InfeasibleError, match="the limit own"):
        plan(path, limits, rows=rows(lambda q: 1e4 * np.ones((q.shape[1], 2))), start=EndState(0.1))
