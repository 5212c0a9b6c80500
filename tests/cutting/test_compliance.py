"""Forces to deflections: beams, frames, and what is no spring."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad

import toolpace as tp
from tests.support.machines import motion, random_machine
from toolpace.common.errors import UsageError
from toolpace.cutting.compliance import FRAMES, to_workpiece
from toolpace.judge.bent_tip import tool_in_workpiece


def test_a_cantilever_bends_as_its_beam_does():
    """Castigliano: the tip goes by the integral of the moment of a unit force, squared, over E I."""
    diameter, length, modulus = 6e-3, 45e-3, 580e9
    inertia = np.pi / 4.0 * (0.5 * diameter) ** 4
    across = quad(lambda x: x * x / (modulus * inertia), 0.0, length)[0]
    along = length / (modulus * np.pi * (0.5 * diameter) ** 2)
    bending = tp.Bending.cantilever(diameter, length, modulus)
    np.testing.assert_allclose(bending.compliance, np.diag([across, across, along]), rtol=1e-12)


def side(machine, names, q):
    turn = np.eye(3)
    for name in names:
        turn = turn @ motion(machine.file.joints[name], q[machine.joints.index(name)])[:3, :3]
    return turn


@pytest.mark.parametrize("kind", ["table-table", "head-table", "head-head"])
def test_rotations_are_those_of_both_chains(kind):
    """Against rotations by scipy, joint by joint from the bed out; the judge's own against the same."""
    rng = np.random.default_rng(7)
    for _ in range(5):
        machine = random_machine(rng, kind)
        chain = machine.file.chain
        x, z = np.array(chain.workpiece_x), np.array(chain.workpiece_z)
        part = np.stack([x, np.cross(z, x), z], axis=1)
        axis = np.array(chain.tool_axis) / np.linalg.norm(chain.tool_axis)
        across = np.array([1.0, 0.0, 0.0]) - axis[0] * axis
        across /= np.linalg.norm(across)
        housing = np.stack([across, np.cross(axis, across), axis], axis=1)
        q = rng.uniform(-1.5, 1.5, (6, 5))
        tool, bed, own = (
            to_workpiece(machine, q, "tool"),
            to_workpiece(machine, q, "bed"),
            tool_in_workpiece(machine, q),
        )
        for k, each in enumerate(q):
            table, spindle = side(machine, chain.workpiece, each) @ part, side(machine, chain.tool, each) @ housing
            np.testing.assert_allclose(bed[k], table.T, atol=1e-12)
            np.testing.assert_allclose(tool[k], table.T @ spindle, atol=1e-12)
            np.testing.assert_allclose(own[k], table.T @ spindle, atol=1e-12)
        np.testing.assert_allclose(tool[:, :, 2], machine.forward(q)[1], atol=1e-12)


def test_a_spindle_along_x_has_the_beds_y():
    machine = tp.Machine.load("xyzbc-trunnion")
    turned = machine._with_chain(tool_axis=(1.0, 0.0, 0.0))
    for found in (to_workpiece(turned, np.zeros((1, 5)), "tool"), tool_in_workpiece(turned, np.zeros((1, 5)))):
        np.testing.assert_allclose(found[0] @ [0.0, 1.0, 0.0], [0.0, 1.0, 0.0], atol=1e-15)
        np.testing.assert_allclose(np.linalg.det(found[0]), 1.0)


@pytest.mark.parametrize("frame", FRAMES)
def test_a_force_bends_alike_in_whatever_frame_it_is_told(frame):
    machine = tp.Machine.load("xyzbc-head")
    rng = np.random.default_rng(3)
    bending = tp.Bending(1e-7 * (lambda a: a @ a.T)(rng.normal(size=(3, 3))))
    q, force = rng.uniform(-1.0, 1.0, (20, 5)), rng.normal(size=(20, 3))
    turn = to_workpiece(machine, q, frame)
    told = np.einsum("nba,nb->na", turn, force)
    bent = bending.deflection(told, machine, q, frame)
    np.testing.assert_allclose(bent, bending.deflection(force, machine, q), atol=1e-18)
    np.testing.assert_allclose(bent[4], bending.deflection(told[4], machine, q[4], frame), atol=1e-18)
    assert bending.deflection(told[4], machine, q[4], frame).shape == (3,)


def test_the_soft_direction_turns_with_the_head():
    """A tool soft along its own x, its head turned by B: a force along that x bends it, one along y does not."""
    machine = tp.Machine.load("xyzbc-head")
    soft = tp.Bending(np.diag([1e-7, 0.0, 0.0]))
    q = np.zeros(5)
    q[machine.joints.index("B")] = 0.7
    x = to_workpiece(machine, q[None], "tool")[0] @ [1.0, 0.0, 0.0]
    assert np.isclose(np.arccos(x[0]), 0.7) and x[1] == 0.0
    np.testing.assert_allclose(soft.deflection(100.0 * x, machine, q), 1e-5 * x, atol=1e-18)
    np.testing.assert_allclose(soft.deflection([0.0, 100.0, 0.0], machine, q), 0.0, atol=1e-18)


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: tp.Bending(np.eye(2)), r"compliance has shape .* give real numbers \(3, 3\)"),
        (lambda: tp.Bending(np.eye(3) * np.nan), "finite"),
        (lambda: tp.Bending(np.eye(3)), "check its unit"),
        (lambda: tp.Bending(1e-7 * np.array([[1, 0.5, 0], [0, 1, 0], [0, 0, 1.0]])), "not symmetric"),
        (lambda: tp.Bending(1e-7 * np.diag([1.0, -1.0, 1.0])), "towards the force"),
        (lambda: tp.Bending.cantilever(0.0, 0.05, 580e9), "diameter is 0"),
        (lambda: tp.Bending.of_stiffness(1e6, -1.0, 1e6), "along y"),
        (lambda: bent([1.0, 2.0]), r"force has shape \(2,\)"),
        (lambda: bent(np.zeros((3, 3)), q=np.zeros((2, 5))), r"q has shape .* for each of 3 forces"),
        (lambda: bent([0.0, 0.0, 1.0], frame="tol"), "did you mean 'tool'"),
    ],
)
def test_what_is_no_spring_or_no_force_is_one_error(make, says):
    with pytest.raises(UsageError, match=says) as caught:
        make()
    assert "\n" not in str(caught.value)


def bent(force, q=None, frame="workpiece"):
    machine = tp.Machine.load("xyzac-trunnion")
    return tp.Bending.of_stiffness(1e6, 1e6, 1e8).deflection(force, machine, np.zeros(5) if q is None else q, frame)


def test_nothing_gives_where_stiffness_is_infinite():
    np.testing.assert_array_equal(tp.Bending.of_stiffness(np.inf, np.inf, np.inf).compliance, np.zeros((3, 3)))
