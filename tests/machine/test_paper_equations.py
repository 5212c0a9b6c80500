"""Wu, Li, Liu, Perez (American Control Conference 2009), Eq. (1) to (6), on the built-in machine `paper-ab`.

The closed forms of the paper are the oracle, misprints corrected; each misprint has a test that the printed form fails.
"""

from __future__ import annotations

import numpy as np
import pytest

from toolpace.machine.machine import Machine

LT, Z1, Z2 = 0.05, 0.3, 0.03
COUNT = 2000


@pytest.fixture(scope="module")
def machine() -> Machine:
    return Machine.load("paper-ab")


@pytest.fixture(scope="module")
def joints(machine: Machine) -> np.ndarray:
    assert machine.joints == ("X", "Y", "Z", "A", "B")
    rng = np.random.default_rng(2009)
    return rng.uniform(machine.travel[:, 0], machine.travel[:, 1], (COUNT, 5))


def tool_in_ground(z: float, a: float) -> np.ndarray:
    """Eq. (1): from the tool frame to the lower ground."""
    c, s = np.cos(a), np.sin(a)
    return np.array([[1, 0, 0, 0], [0, c, -s, 0], [0, s, c, z + Z1], [0, 0, 0, 1]])


def ground_in_workpiece(x: float, y: float, b: float) -> np.ndarray:
    """Eq. (3): from the lower ground to the workpiece frame."""
    c, s = np.cos(b), np.sin(b)
    return np.array([[c, 0, -s, -x], [0, 1, 0, -y], [s, 0, c, -Z2], [0, 0, 0, 1]])


def eq5(q: np.ndarray) -> np.ndarray:
    x, y, z, a, b = q.T
    height = Z1 + z - LT * np.cos(a)
    return np.stack([-x - height * np.sin(b), LT * np.sin(a) - y, height * np.cos(b) - Z2], axis=1)


def eq6(tip: np.ndarray, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Eq. (6) with the third line corrected: + l_t cos A."""
    x, y, z = tip.T
    up = Z2 + z
    return np.stack([-x - up * np.tan(b), LT * np.sin(a) - y, up / np.cos(b) + LT * np.cos(a) - Z1], axis=1)


def test_eq1_tool_frame(machine: Machine, joints: np.ndarray) -> None:
    """With B, X, Y at rest the workpiece frame is the lower ground, lowered by z2."""
    for q in joints[:200]:
        z, a = q[2], q[3]
        tip, axis = machine.forward(np.array([[0.0, 0.0, z, a, 0.0]]))
        frame = tool_in_ground(z, a)
        np.testing.assert_allclose(tip[0] + [0, 0, Z2], (frame @ [0, 0, -LT, 1])[:3], atol=1e-15)
        np.testing.assert_allclose(axis[0], (frame @ [0, 0, 1, 0])[:3], atol=1e-15)


def test_eq2_tip_in_lower_ground(machine: Machine, joints: np.ndarray) -> None:
    z, a = joints[:, 2], joints[:, 3]
    still = np.zeros(COUNT)
    tip, _ = machine.forward(np.stack([still, still, z, a, still], axis=1))
    expected = np.stack([still, LT * np.sin(a), -LT * np.cos(a) + z + Z1 - Z2], axis=1)
    np.testing.assert_allclose(tip, expected, atol=1e-15)


def test_eq3_lower_ground_in_workpiece(machine: Machine, joints: np.ndarray) -> None:
    for q in joints[:200]:
        x, y, z, a, b = q
        tip, axis = machine.forward(q[None])
        frame = ground_in_workpiece(x, y, b) @ tool_in_ground(z, a)
        np.testing.assert_allclose(tip[0], (frame @ [0, 0, -LT, 1])[:3], atol=2e-15)
        np.testing.assert_allclose(axis[0], (frame @ [0, 0, 1, 0])[:3], atol=2e-15)


def test_eq4_eq5_forward(machine: Machine, joints: np.ndarray) -> None:
    tip, axis = machine.forward(joints)
    np.testing.assert_allclose(tip, eq5(joints), atol=1e-14)
    a, b = joints[:, 3], joints[:, 4]
    direction = np.stack([-np.sin(b) * np.cos(a), -np.sin(a), np.cos(b) * np.cos(a)], axis=1)
    np.testing.assert_allclose(axis, direction, atol=1e-15)


def test_eq6_inverse(machine: Machine, joints: np.ndarray) -> None:
    tip, _ = machine.forward(joints)
    a, b = joints[:, 3], joints[:, 4]
    assert [machine.joints[i] for i in machine.rotary] == ["B", "A"]
    q = machine.joints_at(tip, np.stack([b, a], axis=1))
    np.testing.assert_allclose(q[:, :3], eq6(tip, a, b), atol=1e-13)


def test_eq6_round_trip(machine: Machine, joints: np.ndarray) -> None:
    tip, axis = machine.forward(joints)
    np.testing.assert_allclose(machine.joints_at(tip, joints[:, machine.rotary]), joints, atol=1e-12)
    solutions, pole = machine.rotary_solutions(axis)
    assert not pole.any()
    off = np.abs(solutions - joints[:, None, machine.rotary]).max(axis=2).min(axis=1)
    assert off.max() < 1e-12


def test_eq6_derivatives(machine: Machine) -> None:
    """The velocities that II.B asks for: Eq. (6) differentiated, here by finite differences of the closed form."""

    def motion(u: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        return np.stack([0.1 * np.sin(u), 0.05 * u**2, 0.02 * np.cos(2 * u)], axis=1), 0.3 * np.sin(u), 0.5 * np.cos(u)

    h, u = 1e-5, np.linspace(0, 1, 11)
    tip = np.zeros((4, 11, 3))
    tip[0] = motion(u)[0]
    tip[1] = np.stack([0.1 * np.cos(u), 0.1 * u, -0.04 * np.sin(2 * u)], axis=1)
    rotary = np.zeros((4, 11, 2))
    rotary[0] = np.stack([0.5 * np.cos(u), 0.3 * np.sin(u)], axis=1)
    rotary[1] = np.stack([-0.5 * np.sin(u), 0.3 * np.cos(u)], axis=1)
    speed = (eq6(*motion(u + h)) - eq6(*motion(u - h))) / (2 * h)
    np.testing.assert_allclose(machine.linear_jets(tip, rotary)[1][:, :3], speed, atol=1e-9)


def test_errata_tool_point_has_a_minus(machine: Machine) -> None:
    """II.B prints P_t = (0, 0, l_t, 1); with Eq. (1) that is not Eq. (2), off by twice the tool length."""
    z, a = 0.1, 0.4
    right = np.array([0, LT * np.sin(a), -LT * np.cos(a) + z + Z1])
    printed = (tool_in_ground(z, a) @ [0, 0, LT, 1])[:3]
    assert np.linalg.norm(printed - right) == pytest.approx(2 * LT)
    tip, _ = machine.forward(np.array([[0, 0, z, a, 0.0]]))
    assert np.linalg.norm(printed - [0, 0, Z2] - tip[0]) == pytest.approx(2 * LT)


def test_errata_eq6_third_line_has_a_cosine(machine: Machine, joints: np.ndarray) -> None:
    """Eq. (6) prints + l_t sin A in its third line; inverting Eq. (5) gives + l_t cos A."""
    tip, _ = machine.forward(joints)
    a, b = joints[:, 3], joints[:, 4]
    printed = (Z2 + tip[:, 2]) / np.cos(b) + LT * np.sin(a) - Z1
    error = printed - joints[:, 2]
    np.testing.assert_allclose(error, LT * (np.sin(a) - np.cos(a)), atol=1e-13)
    assert np.abs(error).max() > 0.9 * LT * np.sqrt(2)


def test_reference_arc_stays_within_the_stated_angles(machine: Machine) -> None:
    """The tool axis at a constant lead angle of 45 degrees turns A within 30 and B within 35.3 degrees."""
    turned = np.linspace(-np.pi / 4, np.pi / 4, 181)[:, None]
    axis = np.cos(turned) * [0, 0, 1] + np.sin(turned) * np.array([1, 1, 0]) / np.sqrt(2)
    solutions, _ = machine.rotary_solutions(axis)
    near = solutions[:, int(np.abs(solutions).max(axis=(0, 2)).argmin())]
    np.testing.assert_allclose(np.degrees(np.abs(near).max(axis=0)), [35.2643897, 30.0], atol=1e-7)


def test_eq11_limits(machine: Machine) -> None:
    assert machine.limits.velocity.tolist() == [0.5] * 5
    assert machine.limits.acceleration.tolist() == [20.0] * 5
    assert machine.limits.jerk.tolist() == [200.0] * 5
