"""Torques, limits over the speed and rows of one's own on the way back, and behind it."""

from __future__ import annotations

import numpy as np
import pytest

from tests.support.heavy_machines import BODIES, heavy_machine
from tests.support.random_paths import harmonics, random_limits
from toolpace.common.errors import UsageError
from toolpace.deflection.new_trajectory import replan
from toolpace.machine.dynamics import Dynamics, Link
from toolpace.machine.dynamics.torques import torque_rows
from toolpace.machine.limit_curves import CurvedLimit, LimitCurve
from toolpace.machine.limits import Limits
from toolpace.machine.rows import Rows
from toolpace.path.axis_path import AxisPath
from toolpace.path.path import Path
from toolpace.planning.planner import plan

LIFT = Dynamics((Link("linear", (0, 0, 1), mass=10.0, viscous_friction=20.0, dry_friction=5.0),))
METRE = AxisPath.from_callable(lambda s, order: [s, np.ones_like(s), 0 * s, 0 * s][order][:, None])


def lift():
    """A mass on a vertical axis, by Newton: its motor's force over its limit at the speed."""
    corners = [[0.0, 150.0], [1.0, 150.0], [2.0, 115.0]]
    rows = torque_rows(LIFT, [LimitCurve(corners)], ("Z",))

    def used(moment):
        force = 10.0 * (moment.qdd + 9.80665) + 20.0 * moment.qd + 5.0 * np.sign(moment.qd)
        return abs(force) / np.interp(abs(moment.qd), *np.transpose(corners))

    return METRE, Limits(10.0, 100.0, 1e5, ("Z",), rows), used


def curves():
    limits = random_limits(4, 3)
    v, a = limits.velocity, limits.acceleration
    falling = [
        CurvedLimit(name, "acceleration", (LimitCurve([[0.0, most], [0.3 * top, most], [top, 0.2 * most]]),))
        for name, most, top in zip(limits.joints, a, v)
    ]

    def used(moment):
        share = np.interp((abs(moment.qd) / v).ravel(), [0.0, 0.3, 1.0], [1.0, 1.0, 0.2]).reshape(moment.qd.shape)
        return abs(moment.qdd) / (share * a)

    path = AxisPath.from_callable(harmonics(4, 3))
    return path, Limits(v, a, limits.jerk, limits.joints, curves=falling), used


def summed():
    """The sum of all joints, as a carried part may have it."""
    limits = random_limits(4, 3)
    most, jerk = 0.3 * float(limits.acceleration.min()), 0.3 * float(limits.jerk.min())

    def of(q):
        return q.sum(axis=1)[:, None]

    rows = Rows.acceleration_of("sum", "m/s^2", most, of), Rows.jerk_of("sum jerk", "m/s^3", jerk, of)

    def used(moment):
        return np.stack([abs(moment.qdd.sum(axis=1)) / most, abs(moment.qddd.sum(axis=1)) / jerk], axis=1)

    path = AxisPath.from_callable(harmonics(4, 3))
    return path, Limits(limits.velocity, limits.acceleration, limits.jerk, limits.joints, rows), used


@pytest.mark.parametrize("made", [lift, curves, summed])
def test_the_way_back_holds_what_the_plan_held(made):
    path, limits, used = made()
    old = plan(path, limits, bound=False)
    active, rng = old.active(), np.random.default_rng(3)
    own = [active.names.index(rows.name) for rows in old.limits.rows]
    binding = active.t[active.used[:, own].max(axis=1) > 0.99]
    for time in (*rng.choice(binding, 2), 0.6 * old.duration):
        found = old.at(float(time)).q + 1e-3 * rng.normal(size=len(limits))
        new = replan(old, float(time), found, most=1.0)
        seen = used(new.at(np.linspace(0.0, new.duration, 4001))).max(axis=1)
        assert seen.max() <= 1.0001
        assert new.usage().worst <= 1.0001
        assert new.duration < 1.5 * (old.duration - time) + 0.5


@pytest.mark.parametrize("cause", ["displaced", "bending"])
def test_the_motor_of_a_table_is_held_on_the_way_back(cause):
    machine = heavy_machine(A=BODIES["A"].replace("torque = 60", "torque = [[0, 58], [40, 50]]"))
    old = plan(Path.paper_arc(feed=0.05), machine, bound=False)
    curve = machine.file.joints["A"].motor
    for time in (0.15, 1.5):
        new = replan(old, time, deflection=np.array([1e-4, -1e-4, 5e-5]), cause=cause)
        moment = new.at(np.linspace(0.0, new.duration, 2001))
        torque = machine.dynamics(moment.q, moment.qd, moment.qdd)[:, 3]
        assert (abs(torque) / curve.at(moment.qd[:, 3])).max() <= 1.0001


def test_a_start_above_a_torque_is_told():
    """Where the table was found, its weight takes more of the motor than on the path."""
    machine = heavy_machine(A=BODIES["A"].replace("torque = 60", "torque = 58"))
    old = plan(Path.paper_arc(feed=0.05), machine, bound=False)
    t = np.linspace(0.0, old.duration, 2000)
    moment = old.at(t)
    binds = float(t[abs(machine.dynamics(moment.q, moment.qd, moment.qdd)[:, 3]).argmax()])
    q = old.at(binds).q + np.array([0.0, 0.0, 0.0, -3e-3, 0.0])
    tip, axis = machine.forward(q[None])
    new = replan(old, binds, tip[0], axis=axis[0], axis_tolerance=1e-6)
    times = np.linspace(0.0, new.duration, 4001)
    moment = new.at(times)
    share = abs(machine.dynamics(moment.q, moment.qd, moment.qdd)[:, 3]) / 58.0
    assert share.max() == share[0] == pytest.approx(1.00183, abs=1e-4)
    assert times[share > 1.0001].max() < 1e-3 and new.notes[-1].startswith("start above torque A by 0.32")


def test_the_genetic_planner_holds_no_rows():
    path, limits, _ = lift()
    old = plan(path, limits, bound=False)
    with pytest.raises(UsageError, match="replan: the planner 'genetic' does not hold force Z; give 'optimal'"):
        replan(old, 0.4, old.at(0.4).q + 1e-4, planner="genetic")
