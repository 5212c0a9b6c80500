"""Deflection, section II.D of Wu, Li, Liu, Perez, ACC 2009: projection, way back in motion, deflection."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import pytest

from testbed import published
from toolpace import deflection
from toolpace.common.errors import InfeasibleError, UsageError
from toolpace.deflection.detour import DetourRun
from toolpace.judge import verify
from toolpace.machine.limits import Limits
from toolpace.machine.machine import Machine
from toolpace.motion.trajectory import Trajectory
from toolpace.path.axis_path import AxisPath
from toolpace.path.axis_quintic import quintic_through
from toolpace.path.path import Path
from toolpace.planning.genetic import Genetic
from toolpace.planning.limit_tolerances import PROMISED
from toolpace.planning.optimal.planner import Optimal
from toolpace.planning.planned_run import EndState
from toolpace.planning.planner import plan
from toolpace.planning.second_order import SecondOrder

MACHINE = Machine.load("paper-ab")
ARC = Path.paper_arc()
LENGTH = ARC.runs[0].s1
DEFLECTION = (0.059, 0.0568, 0.0589)
TWENTIETH = (19 * LENGTH / 31, 20 * LENGTH / 31)


@dataclass
class Case:
    """A path on a machine, with its plans made when asked for."""

    path: Path
    machine: Machine
    plans: dict[str, Trajectory] = field(default_factory=dict)

    def plan(self, planner: str) -> Trajectory:
        """The plan of a planner, once."""
        if planner not in self.plans:
            self.plans[planner] = plan(self.path, self.machine, planner=planner)
        return self.plans[planner]


CASES = {
    "study": Case(quintic_through(ARC, MACHINE), MACHINE),
    "flank": Case(*published.flank()),
    "fan": Case(*published.fan()),
}


@pytest.mark.parametrize("order", [1, 2, 3])
def test_detour_is_its_own_derivative(order: int) -> None:
    """Along the parameter, over the way back, the rejoining and beyond."""
    old = CASES["study"].plan("optimal")
    new = deflection.replan(old, 0.05, old.tip([0.05])[0][0] + [0, 1e-4, 1e-4], planner="direct")
    run = new.axis_path.runs[0]
    assert isinstance(run, DetourRun)
    s = np.linspace(run.s0, run.join + 0.5 * (run.join - run.s0), 60)[1:-1]
    step = 1e-5 * (run.join - run.s0)
    s = s[np.abs(s - run.join) > 2 * step]
    low, high = (run.evaluate(s + d)[order - 1] for d in (-step, step))
    exact = run.evaluate(s)[order]
    np.testing.assert_allclose((high - low) / (2 * step), exact, atol=1e-5 * np.abs(exact).max())


def test_detour_parameter_and_its_inverse() -> None:
    old = CASES["fan"].plan("optimal")
    for time in (0.02, 1.0, 3.5, 7.0):
        new = deflection.replan(old, time, old.tip([time])[0][0] + 1e-4, planner="direct")
        run = new.axis_path.runs[0]
        assert isinstance(run, DetourRun)
        t = np.linspace(0.0, run.detour.duration, 50)
        np.testing.assert_allclose(run.time_at(run.parameter(t)[0]), t, atol=1e-9)


@pytest.mark.parametrize("planner", ["optimal", "genetic", "direct"])
@pytest.mark.parametrize("rejoin", ["fastest", "projection"])
def test_study_deflection_is_replanned_in_motion(planner: str, rejoin: str) -> None:
    old = CASES["study"].plan("genetic" if planner == "genetic" else "optimal")
    time = old.laws[0].passing_time(TWENTIETH[0])
    interval = TWENTIETH if rejoin == "projection" else None
    new = deflection.replan(old, time, DEFLECTION, planner=planner, rejoin=rejoin, interval=interval)
    judge(old, new, time, np.array(DEFLECTION), old.tip([time])[1][0])
    assert new.usage().feed <= PROMISED
    run = new.axis_path.runs[0]
    assert isinstance(run, DetourRun)
    if rejoin == "projection":
        assert run.join == pytest.approx(TWENTIETH[0], abs=1e-9)
    assert np.abs(new.at([0.0]).qd).max() > 0.1, "the tool does not stop"
    assert new.duration < old.duration - time + (0.12 if rejoin == "fastest" else 0.35)


def judge(old: Trajectory, new: Trajectory, time: float, tip: np.ndarray, axis: np.ndarray) -> None:
    """Starts as deflected with the commanded velocities, keeps to the limits, rejoins the path and stays on it."""
    machine = new.axis_path.machine
    assert machine is not None
    before, after = old.at([time]), new.at([0.0])
    found = machine.forward(after.q)
    np.testing.assert_allclose(found[0][0], tip, atol=1e-9)
    np.testing.assert_allclose(found[1][0], axis, atol=1e-9)
    for kind, limit in (("qd", old.limits.velocity), ("qdd", old.limits.acceleration)):
        scale = np.where(np.isfinite(limit), limit, 1.0)
        assert (np.abs(getattr(before, kind) - getattr(after, kind)) <= 1e-6 * scale).all(), kind
    assert new.usage().worst <= PROMISED
    t = np.linspace(0.0, new.duration, 20001)
    motion = new.at(t)
    for value, limit in zip(
        (motion.qd, motion.qdd, motion.qddd), (old.limits.velocity, old.limits.acceleration, old.limits.jerk)
    ):
        assert (np.abs(value) / limit).max() <= PROMISED
    step = t[1]
    jump = np.abs(np.diff(motion.qdd, axis=0)).max(axis=0) / (old.limits.jerk * step)
    assert jump.max() <= 1.001, "acceleration is continuous"
    np.testing.assert_allclose(new.at([new.duration]).q[0], old.at([old.duration]).q[0], atol=1e-9)
    run = new.axis_path.runs[0]
    assert isinstance(run, DetourRun)
    if not run.ends_here:
        s = np.linspace(run.join, run.s1, 30)
        np.testing.assert_array_equal(run.evaluate(s)[0], old.axis_path.runs[0].evaluate(s)[0])


@pytest.mark.sweep
@pytest.mark.parametrize("planner", ["optimal", "genetic"])
@pytest.mark.parametrize("name", CASES)
def test_random_deflections_come_back(name: str, planner: str) -> None:
    """A few of the thousand of benchmarks/deflections.py."""
    case = CASES[name]
    old = case.plan(planner)
    random = np.random.default_rng(11)
    for _ in range(12):
        time = float(random.uniform(0.0, old.duration))
        tip, axis = (value[0] for value in old.tip([time]))
        way, turn = random.normal(size=3), np.cross(axis, random.normal(size=3))
        tip = tip + 10 ** random.uniform(-5, np.log10(5e-3)) * way / np.linalg.norm(way)
        angle = np.radians(random.uniform(0, 2))
        axis = np.cos(angle) * axis + np.sin(angle) * turn / np.linalg.norm(turn)
        judge(old, deflection.replan(old, time, tip, axis=axis, planner=planner), time, tip, axis)


def test_no_deflection_costs_next_to_nothing() -> None:
    old = CASES["fan"].plan("optimal")
    for time in (0.5, 3.0, 6.0):
        new = deflection.replan(old, time, old.tip([time])[0][0])
        assert new.duration == pytest.approx(old.duration - time, abs=2e-3)


@pytest.mark.parametrize("time", [0.0, 1e-6, 1e-3])
def test_at_rest_and_nearly_so(time: float) -> None:
    old = CASES["study"].plan("optimal")
    for instant in (time, old.duration - time):
        tip, axis = (value[0] for value in old.tip([instant]))
        judge(old, deflection.replan(old, instant, tip + 5e-4, planner="optimal"), instant, tip + 5e-4, axis)


def test_optimal_starts_in_the_state_it_is_given() -> None:
    start, end = EndState(0.02, 0.1), EndState(0.025, -0.1)
    trajectory = plan(ARC, MACHINE, start=start, end=end)
    assert trajectory.state(0.0)[1:] == pytest.approx((start.speed, start.acceleration))
    assert trajectory.state(trajectory.duration)[1:] == pytest.approx((end.speed, end.acceleration))


def test_optimal_is_no_slower_than_the_motion_it_starts_from() -> None:
    old = CASES["fan"].plan("optimal")
    for time in (0.7, 2.9, 4.4):
        tip = old.tip([time])[0][0] + [1e-3, 5e-4, -5e-4]
        direct, best = (deflection.replan(old, time, tip, planner=planner) for planner in ("direct", "optimal"))
        assert best.duration <= direct.duration


def test_joints_without_a_machine_and_several_runs() -> None:
    def wave(s: np.ndarray, order: int) -> np.ndarray:
        return np.stack([np.sin(s + order * np.pi / 2), 2.0**order * np.cos(2 * s + order * np.pi / 2)], axis=-1)

    one = AxisPath.from_callable(wave, 0.0, 1.0).runs[0]
    two = AxisPath.from_callable(wave, 1.0, 2.0).runs[0]
    limits = Limits([1.0, 1.0], [4.0, 4.0], [40.0, 40.0])
    old = plan(AxisPath((one, two), ("q1", "q2")), limits)
    for time in (0.4 * old.duration, 0.7 * old.duration, float(old.starts[1])):
        q = old.at([time]).q[0] + [0.01, -0.02]
        new = deflection.replan(old, time, q, most=0.05)
        assert new.usage().worst <= PROMISED
        np.testing.assert_allclose(new.at([0.0]).q[0], q, atol=1e-9)
        np.testing.assert_allclose(new.at([new.duration]).q[0], wave(np.array([2.0]), 0)[0], atol=1e-9)


def test_pose_out_of_travel_is_refused_with_figures() -> None:
    """The reason is confirmed: the joints of the deflected pose are out of travel."""
    old = CASES["study"].plan("optimal")
    far = old.tip([2.0])[0][0] + [1.2, 0, 0]
    with pytest.raises(InfeasibleError, match=r"deflection at 2 s: the pose cannot be commanded: .*X"):
        deflection.replan(old, 2.0, far, most=2.0)
    q = MACHINE.joints_at(far[None], old.at([2.0]).q[:, MACHINE.rotary])[0]
    assert abs(q[MACHINE.joints.index("X")]) > 1.0


def test_way_back_out_of_travel_is_refused_with_figures() -> None:
    """A joint that moves towards the end of its travel so fast that it cannot stop before it."""
    old = CASES["study"].plan("optimal")
    time = 2.6
    motion = old.at([time])
    b = MACHINE.joints.index("B")
    travel = float(motion.q[0, b]) - 1e-5
    text = MACHINE.to_toml()
    narrow = Machine.from_toml(text, "narrow")
    object.__setattr__(narrow, "travel", narrow.travel.copy())
    narrow.travel[b] = (travel, 1.4)
    assert motion.qd[0, b] ** 2 / (2 * MACHINE.limits.acceleration[b]) > 1e-5, "no motion stops it within the limits"
    with pytest.raises(InfeasibleError, match=r"no way back to the path within limits and travel; the joints are off"):
        deflection.replan(old, time, old.tip([time])[0][0] + 1e-6, narrow)


def test_axis_out_of_reach_is_refused() -> None:
    case = CASES["flank"]
    old = case.plan("optimal")
    tip = old.tip([1.0])[0][0]
    with pytest.raises(InfeasibleError):
        deflection.replan(old, 1.0, tip, axis=(0.0, 0.0, -1.0))


@pytest.mark.parametrize(
    "options, words",
    [
        ({"planner": "best"}, "unknown planner"),
        ({"planner": "genetik"}, "did you mean 'genetic'"),
        ({"planner": "genetic", "generation": 3}, "generations"),
        ({"planner": "direct", "guard": False}, "has no options, but guard"),
        ({"planner": SecondOrder()}, "accelerations jump"),
        ({"rejoin": "soon"}, "rejoin at 'soon'"),
        ({"rejoin": 5.0}, "rejoin at s = 5"),
        ({"axis": (0, 0, 0)}, "length 0; give the unit vector"),
    ],
)
def test_bad_arguments(options: dict[str, object], words: str) -> None:
    old = CASES["study"].plan("optimal")
    with pytest.raises(UsageError, match=words):
        deflection.replan(old, 1.0, DEFLECTION, most=0.1, **options)
    with pytest.raises(UsageError, match="not within"):
        deflection.replan(old, 99.0, DEFLECTION)
    with pytest.raises(UsageError, match=r"replan: time is .*; give seconds"):
        deflection.replan(old, DEFLECTION, 1.0)
    with pytest.raises(UsageError, match=r"give real numbers \(3,\)"):
        deflection.replan(old, 1.0, (0.0, 0.0))


def test_a_planner_object_is_what_its_short_name_asks_for() -> None:
    old = CASES["study"].plan("genetic")
    for given, name, options in (
        (Genetic(generations=2), "genetic", {"generations": 2}),
        (Optimal(mesh=300, bound=True), "optimal", {"mesh": 300}),
    ):
        one = deflection.replan(old, 1.0, DEFLECTION, most=0.1, rejoin="projection", planner=given)
        two = deflection.replan(old, 1.0, DEFLECTION, most=0.1, rejoin="projection", planner=name, **options)
        assert one.duration == two.duration and one.planner == two.planner == name


@pytest.mark.parametrize("name", CASES)
def test_independent_judge_finds_nothing_but_the_moving_start(name: str) -> None:
    case = CASES[name]
    old = case.plan("genetic")
    assert verify(old, case.machine).ok
    new = deflection.replan(old, 1.3, old.tip([1.3])[0][0] + 1e-3, planner="genetic")
    assert {check.what for check in verify(new, case.machine).findings if not check.ok} == {"rest at the start"}
