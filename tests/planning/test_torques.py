"""Torques and forces of motors: held between the nodes by pinocchio's account, IPOPT's optimum, priced, judged."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.support.heavy_machines import BODIES, heavy_machine, motor_torques, random_dynamics
from tests.support.random_paths import harmonics, random_limits
from toolpace.common.errors import UsageError
from toolpace.judge import verify
from toolpace.judge.usage import UsageFigures
from toolpace.machine.dynamics import Dynamics, Link
from toolpace.machine.dynamics.torques import torque_rows
from toolpace.machine.limit_curves import LimitCurve
from toolpace.machine.limits import Limits
from toolpace.path.axis_path import AxisPath
from toolpace.path.path import Path
from toolpace.planning.bound.relaxation import coefficients_of
from toolpace.planning.optimal.friction_turns import turns
from toolpace.planning.optimal.planner import fastest_law
from toolpace.planning.planner import plan
from toolpace.results.write.plan_json import usage_record


def problem(seed, joints, friction=True, share=0.5):
    """A random path, limits of its joints, a chain of bodies, and torques between what it takes to hold it and what the
    motion takes that knows no torques."""
    path, limits = AxisPath.from_callable(harmonics(seed, joints)), random_limits(seed, joints)
    dynamics = random_dynamics(seed, joints, friction=friction)
    free = plan(path, limits, bound=False)
    moment = free.at(np.linspace(0.0, free.duration, 2000))
    constant = np.abs(dynamics.along(np.stack([moment.q, moment.qd, moment.qdd])).constant).max(axis=0)
    most = np.abs(dynamics(moment.q, moment.qd, moment.qdd)).max(axis=0)
    held = constant + share * np.maximum(most - constant, 0.1 * constant)
    return path, replace(limits, rows=torque_rows(dynamics, held, limits.joints)), dynamics, held


def assert_torques_hold(seed, joints):
    path, limits, dynamics, most = problem(seed, joints)
    trajectory = plan(path, limits)
    moment = trajectory.at(np.linspace(0.0, trajectory.duration, 20_001))
    used = (np.abs(motor_torques(dynamics, moment.q, moment.qd, moment.qdd)) / most).max()
    assert used <= 1.0 + 1e-4
    assert max(trajectory.usage().rows.values()) == pytest.approx(used, abs=1e-3)
    assert trajectory.usage().worst <= 1.0001 and trajectory.gap < 0.01
    assert verify(trajectory, limits).ok
    return trajectory, used


@pytest.mark.parametrize("seed, joints", [(1, 2), (8, 2), (2, 3), (1723, 2)])
def test_torques_with_weight_and_friction_hold_between_nodes(seed, joints):
    trajectory, used = assert_torques_hold(seed, joints)
    assert used > 0.99
    assert any(name.startswith(("torque", "force")) for name in trajectory.limited_by())


@pytest.mark.sweep
@pytest.mark.parametrize("seed", range(10, 16))
def test_torques_of_chains_hold_between_nodes(seed):
    assert_torques_hold(seed, 1 + seed % 7)


@pytest.mark.thorough
@pytest.mark.parametrize("seed", range(1000, 2000))
def test_torques_of_a_thousand_chains_hold_between_nodes(seed):
    assert_torques_hold(seed, 1 + seed % 7)


def test_places_where_joints_with_dry_friction_turn_back():
    """cos(s) turns back at pi, sin(s) at pi/2 and 3 pi/2; what stands but for rounding turns nowhere."""
    path = AxisPath.from_callable(
        lambda s, order: np.stack(
            [np.cos(s + order * np.pi / 2), np.sin(s + order * np.pi / 2), 1e-17 * np.sin(1e3 * s)], axis=1
        ),
        0.1, 6.0,
    )  # fmt: skip
    limits = Limits(1.0, 1.0, 1.0, joints=("A", "B", "C"))
    links = [Link("rotary", (0, 0, 1), rotor_inertia=1.0, dry_friction=friction) for friction in (0.0, 0.1, 0.1)]
    run = path.runs[0]
    held = replace(limits, rows=torque_rows(Dynamics(tuple(links)), 5.0, limits.joints))
    first, second = turns(run, held)
    assert (first, second) == pytest.approx((np.pi / 2, 3 * np.pi / 2), abs=1e-14)
    # of a place the sign behind it, and of the number before it the other
    around = run.evaluate(np.array([np.nextafter(first, 0.0), first]))[1, :, 1]
    assert around[0] >= 0.0 > around[1]
    assert len(turns(run, limits)) == 0
    every = replace(limits, rows=torque_rows(lambda q, qd, qdd: qdd + 0.1 * np.sign(qd), 5.0, limits.joints))
    assert len(turns(run, every)) == 3


def compared_with_ipopt(seed, joints):
    pytest.importorskip("casadi")
    from testbed import ipopt

    path, limits, _, _ = problem(seed, joints)
    law, _ = fastest_law(path.runs[0], limits, cells=100, guard=False)
    best = ipopt.optimum(path, limits, 100)
    assert best.note == ipopt.SUCCEEDED
    # where viscous friction helps to brake, the tangent of a limit lies outside: at the last law it must touch
    assert best.problem.exceeded_by(coefficients_of(law.nodes, law.cells)) < 1e-6
    return law.duration / best.law.duration


@pytest.mark.parametrize("seed, joints", [(3, 2), (58, 3)])
def test_motions_with_torques_are_ipopts_optimum(seed, joints):
    assert abs(compared_with_ipopt(seed, joints) - 1.0) < 1e-5


@pytest.mark.sweep
@pytest.mark.parametrize("seed", range(40, 44))
def test_motions_with_torques_are_ipopts_optimum_on_many(seed):
    assert abs(compared_with_ipopt(seed, 1 + seed % 7) - 1.0) < 1e-5


@pytest.mark.thorough
@pytest.mark.parametrize("seed", range(44, 104))
def test_motions_with_torques_are_ipopts_optimum_on_sixty(seed):
    assert abs(compared_with_ipopt(seed, 1 + seed % 7) - 1.0) < 1e-5


def test_the_price_of_a_torque_is_what_one_percent_more_gains():
    path, limits, dynamics, most = problem(8, 2)
    trajectory = plan(path, limits, bound=False)
    prices = trajectory.prices()
    dearest = max((row.name for row in limits.rows), key=lambda name: prices[name])
    k = [row.name for row in limits.rows].index(dearest)
    raised = most * np.where(np.arange(len(most)) == k, 1.01, 1.0)
    stronger = replace(limits, rows=torque_rows(dynamics, raised, limits.joints))
    gain = trajectory.duration - plan(path, stronger, bound=False).duration
    assert gain > 1e-4 * trajectory.duration
    assert abs(prices[dearest] - gain) <= max(0.1 * gain, 1e-4 * trajectory.duration)


@pytest.mark.parametrize("room", [(1.0, 0.9, 0.2), (1.0, 0.4, 0.2)], ids=["concave", "convex"])
def test_the_torque_of_a_motor_falls_with_its_speed(room):
    path, limits, dynamics, most = problem(8, 2)
    free = plan(path, limits, bound=False).at(np.linspace(0.0, 5.0, 1000))
    constant = np.abs(dynamics.along(np.stack([free.q, free.qd, free.qdd])).constant).max(axis=0)
    top = np.abs(free.qd).max(axis=0)
    corners = [
        [[share * v, c + r * (m - c)] for share, r in zip((0.0, 0.4, 1.0), room)]
        for v, c, m in zip(top, constant, most)
    ]
    curves = [LimitCurve(each) for each in corners]
    trajectory = plan(path, replace(limits, rows=torque_rows(dynamics, curves, limits.joints)))
    moment = trajectory.at(np.linspace(0.0, trajectory.duration, 20_001))
    torque = np.abs(motor_torques(dynamics, moment.q, moment.qd, moment.qdd))
    limit = np.stack([np.interp(abs(v), *np.transpose(each)) for v, each in zip(moment.qd.T, corners)], axis=1)
    assert 0.99 < (torque / limit).max() <= 1.0001 and (torque <= most).all()
    # held by the curve where it is below its value at rest
    assert ((torque > 0.99 * limit) & (limit < 0.9 * most)).any()
    assert trajectory.gap < 0.01 and trajectory.usage().worst <= 1.0001


def test_an_axis_with_weight_goes_down_faster_than_up():
    """A mass on one vertical joint: it falls as fast as its force and weight together make it."""
    mass, force = 10.0, 150.0
    weight = mass * 9.80665
    dynamics = Dynamics((Link("linear", (0, 0, 1), mass=mass),))
    path = AxisPath.from_callable(lambda s, order: [s, np.ones_like(s), 0 * s, 0 * s][order][:, None])
    rows = torque_rows(dynamics, force, ("Z",))
    trajectory = plan(path, Limits(10.0, 100.0, 1e5, ("Z",), rows), bound=False)
    up = trajectory.at(np.linspace(0.0, trajectory.duration, 5000)).qdd
    assert up.max() == pytest.approx((force - weight) / mass, rel=2e-3)
    assert up.min() == pytest.approx(-(force + weight) / mass, rel=2e-3)
    # up with (F - W) / m, down with (F + W) / m, over a metre
    least = np.sqrt(2.0 * (1.0 / (force - weight) + 1.0 / (force + weight)) * mass)
    assert least < trajectory.duration < 1.02 * least


def test_the_table_of_a_machine_keeps_the_torque_of_its_motor():
    machine = heavy_machine()
    path = Path.paper_arc(feed=0.05)
    held = plan(path, machine, bound=False)
    assert held.usage().rows["torque A"] > 0.99 and "torque A" in held.active().names
    found = verify(held, machine)
    assert found.ok and {"force of X", "torque of A"} <= {check.name for check in found.checks}
    said = usage_record(held).motor
    assert set(said) == set("XYZAC")
    for wrong, names in (({}, ""), ({"A": 0.98}, "A"), ({"X": 0.5}, "X"), ({"B": 0.1}, "")):
        figures = UsageFigures({"usage": {"motor": said | wrong}}, held.sample(1e-3), machine, None, None, 1e-3)
        found = figures.of_motors()
        assert [check.joint for check in found] == ([names] if wrong else []) and not any(each.ok for each in found)
    weaker = heavy_machine(A=BODIES["A"].replace("torque = 60", "torque = 59"))
    assert [check.name for check in verify(held, weaker).findings] == ["torque of A"]
    heavier = machine.with_workpiece(20.0, (0.04, 0.0, 0.11))
    assert not verify(held, heavier).ok and plan(path, heavier, bound=False).duration > held.duration


def test_the_motor_curve_of_a_machine_is_held_and_judged():
    falling = BODIES["A"].replace("torque = 60", "torque = [[0, 60], [10, 52], [60, 40]]")
    machine, path = heavy_machine(A=falling), Path.paper_arc(feed=0.05)
    constant = plan(path, heavy_machine(), bound=False)
    assert [check.name for check in verify(constant, machine).findings] == ["torque of A"]
    held = plan(path, machine, bound=False)
    assert held.duration > constant.duration and held.usage().rows["torque A"] > 0.99
    assert verify(held, machine).ok
    for each, wrong in ((held, []), (constant, ["A"])):
        said = {"usage": {"motor": usage_record(each).motor}}
        found = UsageFigures(said, each.sample(1e-3), machine, None, None, 1e-3).of_motors()
        assert [check.joint for check in found] == wrong


def test_an_overtaxed_motor_tells_by_how_much_it_must_be_slower():
    """Viscous friction falls with ds/dt, acceleration with its square, and weight not at all."""
    dynamics = Dynamics((Link("linear", (0, 0, 1), mass=2.0, viscous_friction=8.0),))
    weight = 2.0 * 9.80665
    (row,) = torque_rows(dynamics, weight + 16.0, ("Z",))
    q = np.array([[0.0], [1.0], [0.0], [0.0]])[:, :, None] * np.ones((1, 3, 1))
    # weight leaves 16 N: of 8 N s/m at 4 m/s half the speed, of 2 kg at 16 m/s^2 half its square; of both 8 + 8 N
    state = np.array([[0.0] * 3, [4.0, 0.0, 2.0], [0.0, 16.0, 16.0], [0.0] * 3])
    assert row.ratio(q, state) == pytest.approx([4.0, 2.0, 4.0])


def test_what_cannot_be_held_is_told():
    path, limits = AxisPath.from_callable(harmonics(1, 2)), random_limits(1, 2)
    dynamics = random_dynamics(1, 2)
    with pytest.raises(UsageError, match=r"(torque|force) q\d: weight and friction take .* of 0.001 N.*; give"):
        plan(path, limits, rows=torque_rows(dynamics, 1e-3, limits.joints))
    rows = torque_rows(dynamics, 1e4, limits.joints)
    with pytest.raises(UsageError, match="second-order holds no"):
        plan(path, limits, rows=rows, planner="second-order")
