"""Near a pole positions of a rotary joint are known badly: that is no jerk, and a real jerk there is still found."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import toolpace as tp
from toolpace.judge.tool import pole_rounding

STEP = 2.5e-4


@pytest.fixture(scope="module")
def machine() -> tp.Machine:
    return tp.Machine.load("xyzac-trunnion")


def by_the_pole(machine: tp.Machine, tilt: float, rounded: float = 1.0) -> tp.SetPoints:
    """Set-points of a tool that swings by the pole at a tilt [rad], with the rounding that the tool axis leaves."""
    t = STEP * np.arange(400)
    swing = 0.001 * np.sin(np.pi * (np.clip(t, 0.01, 0.09) - 0.01) / 0.08) ** 4
    q = np.zeros((len(t), 5))
    q[:, machine.joints.index("A")] = tilt
    q[:, machine.joints.index("C")] = swing
    rounding = np.random.default_rng(1).uniform(-0.5, 0.5, len(t)) * np.finfo(float).eps / np.sin(tilt)
    q[:, machine.joints.index("C")] += rounded * rounding
    qd = np.gradient(q, STEP, axis=0)
    qdd, tips = np.gradient(qd, STEP, axis=0), machine.forward(q)
    block = np.ones(len(t), dtype=np.int64)
    return tp.SetPoints(t, q, qd, qdd, np.gradient(qdd, STEP, axis=0), *tips, block, machine.joints)


def jerk_of(points: tp.SetPoints, machine: tp.Machine) -> bool:
    """Whether the jerk of C, by differences of positions, is found within its limit."""
    plain = replace(points, qddd=np.zeros_like(points.q))
    checks = tp.verify(plain, machine).checks
    return next(check.ok for check in checks if check.name == "jerk of C")


def most_jerk(points: tp.SetPoints) -> float:
    return float(np.abs(np.diff(points.q[:, points.joints.index("C")], 3)).max() / STEP**3)


def test_the_rounding_of_a_tool_axis_near_its_pole_is_no_jerk(machine):
    points, clean = by_the_pole(machine, 1e-6), by_the_pole(machine, 1e-6, rounded=0.0)
    assert most_jerk(points) > 1.01 * most_jerk(clean)
    assert jerk_of(points, machine.with_limits(limit_of_jerk(machine, most_jerk(clean))))


def test_a_jerk_that_is_more_than_rounding_is_found_at_the_pole_too(machine):
    points = by_the_pole(machine, 1e-6)
    assert not jerk_of(points, machine.with_limits(limit_of_jerk(machine, 0.8 * most_jerk(points))))


def test_far_from_the_pole_nothing_is_granted(machine):
    points = by_the_pole(machine, np.pi / 2)
    assert pole_rounding(points.q, machine).max() < 1e-15


def limit_of_jerk(machine: tp.Machine, jerk: float) -> tp.Limits:
    limits = machine.limits
    most = limits.jerk.copy()
    most[machine.joints.index("C")] = jerk
    return tp.Limits(limits.velocity, limits.acceleration, most, machine.joints)
