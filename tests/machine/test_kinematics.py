"""Forward and inverse kinematics of every class of machine."""

from __future__ import annotations

import numpy as np
import pytest

from tests.support.machines import CLASSES, oracle, random_machine
from toolpace.common.errors import ReachError
from toolpace.machine.machine import Machine

SMALL = 1e-12


def random_joints(machine: Machine, rng: np.random.Generator, n: int) -> np.ndarray:
    return rng.uniform(np.maximum(machine.travel[:, 0], -3.0), np.minimum(machine.travel[:, 1], 3.0), (n, 5))


def nearest_error(solutions: np.ndarray, rotary: np.ndarray) -> np.ndarray:
    off = solutions - rotary[:, None]
    off -= 2 * np.pi * np.round(off / (2 * np.pi))
    return np.abs(off).max(axis=2).min(axis=1)


@pytest.mark.parametrize("name", Machine.names())
def test_built_in_forward_is_the_matrix_product(name: str) -> None:
    machine = Machine.load(name)
    q = random_joints(machine, np.random.default_rng(1), 100)
    tip, axis = machine.forward(q)
    for i in range(len(q)):
        expected_tip, expected_axis = oracle(machine, q[i])
        np.testing.assert_allclose(tip[i], expected_tip, atol=1e-13)
        np.testing.assert_allclose(axis[i], expected_axis, atol=1e-13)


@pytest.mark.parametrize("name", Machine.names())
def test_built_in_round_trip(name: str) -> None:
    machine = Machine.load(name)
    q = random_joints(machine, np.random.default_rng(2), 5000)
    if name.startswith("xyzbc-nutating"):
        # At the edge of reach, 90 degrees, the two solutions meet and a digit in the axis is half a digit in the joint.
        q = q[np.abs(np.abs(q[:, 3]) - np.pi) > 0.05]
    tip, axis = machine.forward(q)
    rotary = q[:, machine.rotary]
    solutions, pole = machine.rotary_solutions(axis)
    assert not pole.any() and np.isfinite(solutions).all()
    for side in range(2):
        np.testing.assert_allclose(machine.axis_at(solutions[:, side]), axis, atol=SMALL)
    assert nearest_error(solutions, rotary).max() < SMALL
    np.testing.assert_allclose(machine.joints_at(tip, rotary), q, atol=SMALL)


@pytest.mark.parametrize(
    "kind", [pytest.param(kind, marks=() if kind == "head-table" else pytest.mark.sweep) for kind in CLASSES]
)
def test_random_chains(kind: str) -> None:
    """A thousand chains of each class: matrix products forward, round trip back, both solutions right."""
    rng = np.random.default_rng(3)
    worst = 0.0
    for _ in range(1000):
        machine = random_machine(rng, kind)
        assert machine.kind == kind
        q = rng.uniform(-2.5, 2.5, (4, 5))
        tip, axis = machine.forward(q)
        expected = oracle(machine, q[0])
        np.testing.assert_allclose(tip[0], expected[0], atol=1e-12)
        np.testing.assert_allclose(axis[0], expected[1], atol=1e-13)
        solutions, _ = machine.rotary_solutions(axis)
        assert np.isfinite(solutions).all()
        for side in range(2):
            np.testing.assert_allclose(machine.axis_at(solutions[:, side]), axis, atol=1e-12)
        # Near the edge of reach the angles are worth half the digits of the axis; there the axis above must do.
        clear = np.abs(solutions[:, 0] - solutions[:, 1]).max(axis=1) > 0.05
        if clear.any():
            worst = max(worst, nearest_error(solutions, q[:, machine.rotary])[clear].max())
        try:
            back = machine.joints_at(tip, q[:, machine.rotary])
        except ReachError:
            continue
        forth, _ = machine.forward(back)
        scale = 1.0 + np.abs(back).max()
        np.testing.assert_allclose(forth, tip, atol=1e-12 * scale)
    assert worst < SMALL


def test_pole_keeps_all_digits() -> None:
    """The distance from the pole comes back to full relative accuracy, however small."""
    for name in ("xyzac-trunnion", "xyzbc-head", "xyzbc-nutating"):
        machine = Machine.load(name)
        for tilt in 10.0 ** -np.arange(1.0, 9.0):
            axis = np.array([[np.sin(tilt) * 0.6, np.sin(tilt) * 0.8, np.cos(tilt)]])
            solutions, pole = machine.rotary_solutions(axis)
            assert not pole[0]
            for side in range(2):
                back = machine.axis_at(solutions[:, side])
                np.testing.assert_allclose(back[0, :2], axis[0, :2], rtol=1e-7, atol=1e-15)


def test_pole_is_named() -> None:
    machine = Machine.load("xyzac-trunnion")
    solutions, pole = machine.rotary_solutions(np.array([[0.0, 0, 1], [0, 0, -1], [0, 1e-6, 1]]))
    assert pole.tolist() == [True, True, False]
    np.testing.assert_allclose(machine.axis_at(solutions[:2, 0]), [[0, 0, 1], [0, 0, -1]], atol=1e-15)


def test_unreachable_is_nan() -> None:
    machine = Machine.load("xyzbc-nutating")
    tilt = np.radians([80.0, 89.999, 90.001, 120.0])
    solutions, _ = machine.rotary_solutions(np.stack([np.sin(tilt), 0 * tilt, np.cos(tilt)], axis=1))
    assert np.isnan(solutions).all(axis=(1, 2)).tolist() == [False, False, True, True]


def test_linuxcnc_xyzac_closed_forms() -> None:
    """Tool axis and inverse kinematics of LinuxCNC's xyzac-trt (y offset 20 mm, z offset 10 mm)."""
    machine = Machine.load("linuxcnc-xyzac-trt")
    assert machine.joints == ("X", "Y", "Z", "A", "C")
    rng = np.random.default_rng(4)
    a, c = rng.uniform(-1.7, 0.8, 500), rng.uniform(-9, 9, 500)
    tip = rng.uniform(-0.1, 0.1, (500, 3))
    rotary = np.stack([c, a], axis=1)
    axis = np.stack([np.sin(c) * np.sin(a), np.cos(c) * np.sin(a), np.cos(a)], axis=1)
    np.testing.assert_allclose(machine.axis_at(rotary), axis, atol=1e-14)
    x, y, z = tip.T
    dy, dz = 0.020, 0.010
    across = np.sin(c) * x + np.cos(c) * y - dy
    expected = np.stack(
        [
            np.cos(c) * x - np.sin(c) * y,
            np.cos(a) * across - np.sin(a) * (z - dz) + dy,
            np.sin(a) * across + np.cos(a) * (z - dz) + dz,
            a,
            c,
        ],
        axis=1,
    )
    np.testing.assert_allclose(machine.joints_at(tip, rotary), expected, atol=1e-14)


def test_linuxcnc_bridge_mill_closed_forms() -> None:
    """5axiskins of LinuxCNC: tip = joints + s2r(L, C, 180 - B) + (0, 0, L), L being the pivot's 250 mm and the tool."""
    machine = Machine.load("linuxcnc-xyzbc-bridgemill")
    rng = np.random.default_rng(5)
    q = np.zeros((500, 5))
    place = {name: machine.joints.index(name) for name in "XYZBC"}
    q[:, [place["X"], place["Y"], place["Z"]]] = linear = rng.uniform(-0.1, 0.1, (500, 3))
    q[:, place["B"]], q[:, place["C"]] = b, c = rng.uniform(-2, 2, (2, 500))
    length = 0.25 + machine.tool_length
    polar = np.pi - b
    r = length * np.stack([np.sin(polar) * np.cos(c), np.sin(polar) * np.sin(c), np.cos(polar)], axis=1)
    tip, axis = machine.forward(q)
    np.testing.assert_allclose(tip, linear + r + [0.0, 0.0, length], atol=1e-15)
    np.testing.assert_allclose(axis, -r / length, atol=1e-15)


def test_singular_linear_joints_are_an_error() -> None:
    machine = Machine.load("paper-ab")
    with pytest.raises(ReachError, match=r"B = 90.000 deg.*linear joints cannot move"):
        machine.joints_at(np.zeros((2, 3)), np.array([[0.0, 0.0], [np.pi / 2, 0.0]]))


def test_joints_zero_is_the_workpiece_origin() -> None:
    for name in set(Machine.names()) - {"paper-ab"}:
        tip, axis = Machine.load(name).forward(np.zeros((1, 5)))
        np.testing.assert_allclose(tip[0], 0.0, atol=1e-15)
        np.testing.assert_allclose(axis[0], [0, 0, 1], atol=1e-15)


def test_tip_lever() -> None:
    """The part 100 mm off the C axis makes a linear joint move 100 mm a radian; A's lever is the way to its axis."""
    machine = Machine.load("xyzac-trunnion")
    lever = machine.tip_lever(np.array([[0.1, 0.0, 0.0]]), np.zeros((1, 2)))
    np.testing.assert_allclose(lever[0], [0.1, 0.07], atol=1e-15)


def test_mounted_part() -> None:
    """A part mounted upside down is reached where it was not."""
    machine = Machine.load("xyzac-trunnion").mounted(x=(1, 0, 0), z=(0, 0, -1))
    tip, axis = machine.forward(np.zeros((1, 5)))
    np.testing.assert_allclose(axis[0], [0, 0, -1], atol=1e-15)
    np.testing.assert_allclose(tip[0], 0.0, atol=1e-15)
    assert Machine.load("xyzac-trunnion").with_tool(0.1).forward(np.zeros((1, 5)))[0][0, 2] == pytest.approx(0.05)
