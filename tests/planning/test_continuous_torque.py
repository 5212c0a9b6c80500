"""Continuous ratings of motors: the root mean square of a torque kept, named and judged; mistakes told."""

from __future__ import annotations

import numpy as np
import pytest

from tests.support.heavy_machines import BODIES, heavy_machine
from toolpace.common.errors import InfeasibleError, MachineError, UsageError
from toolpace.judge import verify
from toolpace.judge.usage import UsageFigures
from toolpace.machine.dynamics import Dynamics, Link
from toolpace.machine.dynamics.torques import torque_rows
from toolpace.machine.limits import Limits
from toolpace.machine.machine import Machine
from toolpace.path.axis_path import AxisPath
from toolpace.path.path import Path
from toolpace.planning.planner import plan
from toolpace.planning.program_plan import plan_program
from toolpace.programs.reading import read_text
from toolpace.results.write.plan_json import usage_record


def straight(s, order):
    return [s, np.ones_like(s), 0 * s, 0 * s][order][:, None]


METRE = AxisPath.from_callable(straight, joints=("X",))
MASS = Dynamics((Link("linear", (1, 0, 0), mass=10.0),))
LIFT = Dynamics((Link("linear", (0, 0, 1), mass=10.0),))


def mean_square(trajectory, dynamics, window=None):
    """The largest root mean square over a window, by plain sums at 20 000 times."""
    t = np.linspace(0.0, trajectory.duration, 20_001)
    moment = trajectory.at(t)
    square = dynamics(moment.q, moment.qd, moment.qdd)[:-1] ** 2
    count = len(square) if window is None else round(window / t[1])
    heat = np.concatenate([np.zeros((1, square.shape[1])), np.cumsum(square, axis=0)])
    return np.sqrt((heat[count:] - heat[:-count]).max(axis=0) / count)


def limits_of(dynamics, speed=10.0, **rating):
    return Limits(speed, 100.0, 1e5, ("X",), torque_rows(dynamics, 150.0, ("X",), **rating))


def test_a_mass_moves_as_its_motor_may_continuously():
    trajectory = plan(METRE, limits_of(MASS, continuous=60.0))
    assert mean_square(trajectory, MASS)[0] == pytest.approx(60.0, rel=3e-3)
    # with constant forces 4 m / T^2; a force that falls evenly has the least, sqrt(12) m / T^2
    assert trajectory.duration == pytest.approx(np.sqrt(4.0 * 10.0 / 60.0), rel=5e-3)
    assert trajectory.duration < 1.08 * np.sqrt(np.sqrt(12.0) * 10.0 / 60.0)
    free = plan(METRE, limits_of(MASS))
    assert trajectory.lower_bound == free.lower_bound < free.duration
    assert trajectory.usage().rows["continuous force X"] == pytest.approx(1.0, abs=3e-3)
    assert trajectory.limited_by()["continuous force X"] > 0.9 and "nothing" not in trajectory.limited_by()
    assert trajectory.notes[-1].startswith("slowed for continuous force X: not the fastest that keeps it")
    with pytest.raises(UsageError, match="prices: the motion was slowed for a continuous rating"):
        trajectory.prices()


def test_a_rating_that_is_kept_changes_nothing():
    trajectory, free = (plan(METRE, limits_of(MASS, 1.5, **each)) for each in ({"continuous": 100.0}, {}))
    assert (trajectory.laws[0].cells == free.laws[0].cells).all() and trajectory.notes == free.notes
    share = trajectory.usage().rows["continuous force X"]
    assert 0.7 < share < 0.8 and share * 100.0 == pytest.approx(mean_square(free, MASS)[0], rel=1e-3)
    assert "continuous force X" not in trajectory.limits.names


@pytest.mark.parametrize("window", [0.05, 0.3])
def test_the_hottest_window_keeps_the_rating(window):
    trajectory = plan(METRE, limits_of(LIFT, continuous=120.0, window=window), bound=False)
    assert mean_square(trajectory, LIFT, window)[0] == pytest.approx(120.0, rel=3e-3)
    assert mean_square(trajectory, LIFT)[0] < 120.0


def test_weight_that_a_motor_cannot_hold_continuously_is_told():
    with pytest.raises(InfeasibleError, match=r"continuous force X: no motion found that keeps 95 N .* alone 98\.0665"):
        plan(METRE, limits_of(LIFT, continuous=95.0), bound=False)


def test_a_dwell_cools_a_motor_and_holds_a_weight():
    waiting = AxisPath(METRE.runs, METRE.joints, None, first_dwell=0.25)
    with_wait = plan(waiting, limits_of(MASS, continuous=60.0), bound=False)
    moving = with_wait.duration - 0.25
    # 4 m / T^2 for T of T + 0.25 s
    assert 40.0 / moving**2 * np.sqrt(moving / with_wait.duration) == pytest.approx(60.0, rel=5e-3)
    held = plan(waiting, limits_of(LIFT, continuous=149.0), bound=False).usage().rows["continuous force X"]
    square = mean_square(plan(METRE, limits_of(LIFT), bound=False), LIFT)[0] ** 2
    alone = plan(METRE, limits_of(LIFT), bound=False).duration
    mean = (square * alone + 0.25 * 98.0665**2) / (alone + 0.25)
    assert held == pytest.approx(np.sqrt(mean) / 149.0, rel=1e-3)


def test_a_machine_keeps_what_a_motor_bears_continuously():
    path = Path.paper_arc(feed=0.05)
    machine = heavy_machine(A=BODIES["A"] + "\ntorque_continuous = 24")
    trajectory = plan(path, machine, bound=False)
    found = verify(trajectory, machine)
    assert found.ok and {"continuous torque of A"} <= {check.name for check in found.checks}
    record = usage_record(trajectory)
    assert record.continuous == {"A": pytest.approx(1.0, abs=3.5e-3)} and record.worst <= 1.0001
    for said, wrong in ((record.continuous, []), ({"A": 0.9}, ["A"]), ({}, [""])):
        figures = UsageFigures({"usage": {"continuous": said}}, trajectory.sample(1e-3), machine, None, None, 1e-3)
        assert [check.joint for check in figures.of_ratings()] == wrong
    weaker = heavy_machine(A=BODIES["A"] + "\ntorque_continuous = 23.9")
    assert [check.name for check in verify(trajectory, weaker).findings] == ["continuous torque of A"]


def test_the_plan_of_a_program_keeps_the_rating():
    text = "G21 G90 G94 G43.4 H1\nG1 X0 Y0 Z50 A0 C0 F12000\nG1 X10 Y0 Z50 A-20\nM30\n"
    machine = heavy_machine(A=BODIES["A"] + "\ntorque_continuous = 36")
    program = read_text(text, machine)
    found = plan_program(program, machine, 1e-5, np.radians(0.05), effort="low").trajectory
    assert found.usage().rows["continuous torque A"] == pytest.approx(1.0, abs=3.5e-3)
    assert "continuous torque A" in found.limited_by() and found.notes[-1].startswith("slowed for")
    assert verify(found, machine, program).ok


def test_ratings_in_a_machine_file():
    body = BODIES["A"] + "\ntorque_continuous = 25.5\nthermal_window = 10"
    machine = heavy_machine(A=body)
    again = Machine.from_toml(machine.to_toml())
    assert again == machine and again.file == machine.file and "thermal_window = 10" in machine.to_toml()
    for old, new, message in (
        ("25.5", "70", "joint A: torque_continuous = 70 N m above torque = 60 N m; give the motor's largest"),
        ("25.5", "0", "joint A: torque_continuous = 0 N m; give a number above zero"),
        ("= 10", "= -1", "joint A: thermal_window = -1 s; give a time above zero"),
        ("torque_continuous = 25.5", "", "joint A: thermal_window without torque_continuous"),
        ("torque_continuous", "force_continuous", "joint A: force_continuous is not that of a rotary joint"),
        ("torque = 60\n", "", "joint A: torque_continuous = 25.5 N m without a limit"),
    ):
        with pytest.raises(MachineError, match=message):
            heavy_machine(A=body.replace(old, new, 1))
    for rating, message in (
        ({"continuous": 200.0}, "joint X has 200 continuously, above its largest, 150"),
        ({"continuous": -1.0}, "joint X has -1 continuously over inf s; give positive numbers"),
        ({"continuous": 9.0, "window": 0.0}, "joint X has 9 continuously over 0 s; give positive numbers"),
    ):
        with pytest.raises(UsageError, match=message):
            limits_of(MASS, **rating)
