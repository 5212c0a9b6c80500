"""A bent tool: the joints are as commanded, and the commands come to be off the path by what it bends."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from testbed import published
from toolpace import deflection
from toolpace.common.errors import UsageError
from toolpace.deflection.compensation import CompensatedRun
from toolpace.machine.limits import Limits
from toolpace.machine.machine import Machine
from toolpace.motion.laws import SlowedLaw
from toolpace.motion.trajectory import Trajectory
from toolpace.path.axis_path import AxisPath
from toolpace.path.axis_quintic import quintic_through
from toolpace.path.path import Path
from toolpace.planning.limit_tolerances import PROMISED
from toolpace.planning.planner import plan

BENDING = np.array([6e-5, -7e-5, 4e-5])
"""About 100 micrometres."""


@cache
def planned(name: str) -> Trajectory:
    if name == "study":
        machine = Machine.load("paper-ab")
        return plan(quintic_through(Path.paper_arc(), machine), machine, mesh=200, bound=False)
    path, machine = published.fan()
    return plan(path, machine, mesh=300, bound=False)


def bent_tip(trajectory: Trajectory, t, bending=BENDING):
    """Where the tip of a bent tool is: that of the kinematics and what it bends."""
    return trajectory.axis_path.machine.forward(trajectory.at(t).q)[0] + bending


def off_the_path(trajectory: Trajectory, points) -> float:
    """Largest distance of points to the path that was planned first, by a dense search with a parabola."""
    run = trajectory.axis_path.runs[0].run
    worst = 0.0
    for point in points:
        low, high = run.s0, run.s1
        for _ in range(12):
            s = np.linspace(low, high, 201)
            far = np.linalg.norm(run.evaluate(s).tip[0] - point, axis=1)
            k = int(np.argmin(far))
            low, high = s[max(k - 1, 0)], s[min(k + 1, 200)]
        worst = max(worst, float(far[k]))
    return worst


@pytest.mark.parametrize("name", ["study", "fan"])
@pytest.mark.parametrize("time", [0.0, 1.3, 3.1])
def test_a_bent_tip_lies_on_the_path_from_the_rejoining_to_the_end(name, time):
    old = planned(name)
    new = deflection.replan(old, time, bent_tip(old, [time])[0], cause="bending")
    first, before = new.at([0.0]), old.at([time])
    for kind, limit in (("q", 1.0), ("qd", old.limits.velocity), ("qdd", old.limits.acceleration)):
        jump = np.abs(getattr(first, kind) - getattr(before, kind)) / np.where(np.isfinite(limit), limit, 1.0)
        assert jump.max() < 1e-6, f"{kind} goes on without a jump"
    detour = new.axis_path.runs[0].detour.duration
    assert detour < 0.3
    assert off_the_path(old, bent_tip(old, [time])) > 3e-5, "before, the bent tip is off the path"
    t = np.linspace(detour, new.duration, 40)
    assert off_the_path(old, bent_tip(new, t)) < 1e-9
    assert new.usage().worst <= PROMISED
    assert new.duration < (old.duration - time) * 1.01 + detour


def test_the_same_bending_measured_again_changes_nothing_and_none_takes_the_aim_back():
    old = planned("study")
    once = deflection.replan(old, 1.0, bent_tip(old, [1.0])[0], cause="bending")
    for later in (0.02, 0.9):
        again = deflection.replan(once, later, bent_tip(once, [later])[0], cause="bending")
        t = np.linspace(0.0, again.duration, 60)
        np.testing.assert_allclose(again.at(t).q, once.at(t + later).q, atol=1e-12)
    straight = deflection.replan(once, 0.9, bent_tip(once, [0.9], 0.0)[0], cause="bending")
    t = np.linspace(straight.axis_path.runs[0].detour.duration, straight.duration, 20)
    assert off_the_path(old, bent_tip(straight, t, 0.0)) < 1e-9
    assert not isinstance(straight.axis_path.runs[0].rest_of, CompensatedRun)


def test_joints_displaced_while_the_tool_is_bent_come_back_to_the_aim():
    old = planned("study")
    bent = deflection.replan(old, 1.0, bent_tip(old, [1.0])[0], cause="bending")
    found = bent.tip([0.9])[0][0] + [1e-4, 0.0, 2e-4]
    new = deflection.replan(bent, 0.9, found)
    t = np.linspace(new.axis_path.runs[0].detour.duration, new.duration, 20)
    assert off_the_path(old, bent_tip(new, t)) < 1e-9


def test_the_runs_behind_are_aimed_off_too_and_joints_without_a_machine():
    def wave(s, order):
        return np.stack([np.sin(s + order * np.pi / 2), 2.0**order * np.cos(2 * s + order * np.pi / 2)], axis=-1)

    runs = [AxisPath.from_callable(wave, low, low + 1.0).runs[0] for low in (0.0, 1.0, 2.0)]
    limits = Limits([1.0, 1.0], [4.0, 4.0], [40.0, 40.0])
    old = plan(AxisPath(tuple(runs), ("q1", "q2")), limits)
    bending = np.array([2e-3, -1e-3])
    new = deflection.replan(old, 0.4, old.at(0.4).q + bending, cause="bending")
    np.testing.assert_allclose(new.at(new.duration).q + bending, old.at(old.duration).q, atol=1e-12)
    assert len(new.axis_path.runs) == 3 and new.usage().worst <= PROMISED
    np.testing.assert_allclose(new.at(0.0).q, old.at(0.4).q, atol=1e-12)


@pytest.mark.parametrize("order", [1, 2, 3])
def test_a_path_aimed_off_is_its_own_derivative(order):
    old = planned("fan")
    new = deflection.replan(old, 1.0, bent_tip(old, [1.0])[0], cause="bending")
    run = new.axis_path.runs[0].rest_of
    s, step = np.linspace(run.s0, run.s1, 40)[1:-1], 1e-6 * (run.s1 - run.s0)
    exact = run.evaluate(s)[order] - run.base.evaluate(s)[order]
    low, high = (run.evaluate(s + d)[order - 1] - run.base.evaluate(s + d)[order - 1] for d in (-step, step))
    np.testing.assert_allclose((high - low) / (2 * step), exact, atol=2e-4 * max(np.abs(exact).max(), 1e-12))


def test_a_slowed_law_takes_longer_and_is_its_own_derivative():
    law = planned("fan").laws[0]
    slowed = SlowedLaw(law, 1.25)
    assert slowed.duration == pytest.approx(1.25 * law.duration)
    t, step = np.linspace(0.1, slowed.duration - 0.1, 50), 1e-5
    for order in (1, 2):
        change = (slowed.at(t + step)[order - 1] - slowed.at(t - step)[order - 1]) / (2 * step)
        np.testing.assert_allclose(change, slowed.at(t)[order], atol=1e-4 * np.abs(slowed.at(t)[order]).max())
    assert sum(float(probe.share.sum()) for probe in slowed.probes()) == pytest.approx(slowed.duration)
    assert slowed.passing_time(0.03) == pytest.approx(1.25 * law.passing_time(0.03))


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"cause": "broken"}, "unknown cause 'broken'"), ({"cause": "bendin"}, "did you mean 'bending'"),
        ({"cause": "bending", "axis": (0, 0, 1)}, "leave axis out"), ({"axis_tolerance": -1.0}, "axis_tolerance is -1"),
    ],
)  # fmt: skip
def test_what_makes_no_sense_is_refused(options, words):
    old = planned("study")
    with pytest.raises(UsageError, match=words):
        deflection.replan(old, 1.0, bent_tip(old, [1.0])[0], **{"axis": None, **options})
