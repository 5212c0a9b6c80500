"""Poses to compare with a real machine."""

from __future__ import annotations

import math

import msgspec
import numpy as np
import pytest

from tests.support.machines import CLASSES, oracle, random_machine
from toolpace.machine.file_writer import pose_table, poses
from toolpace.machine.machine import FOLDER, Machine


def table(machine: Machine) -> np.ndarray:
    """(n, 11) the figures of the table: joints, tip, axis."""
    lines = pose_table(machine.geometry).splitlines()
    return np.array([[float(cell) for cell in line.split()] for line in lines[5:]])


@pytest.mark.parametrize("name", Machine.names())
def test_figures_are_those_of_the_oracle(name: str) -> None:
    machine = Machine.load(name)
    figures = table(machine)
    q = poses(machine.geometry)
    scale = np.where(machine.is_rotary, math.degrees(1.0), 1e3)
    np.testing.assert_allclose(figures[:, :5], q * scale, atol=6e-4)
    for row, joints in zip(figures, q):
        tip, axis = oracle(machine, joints)
        np.testing.assert_allclose(row[5:8], 1e3 * tip, atol=6e-4)
        np.testing.assert_allclose(row[8:], axis, atol=6e-6)


@pytest.mark.parametrize("name", Machine.names())
def test_what_is_turned(name: str) -> None:
    """Zero, +30 and +90 (or what travel holds) of each rotary joint alone, and both together; none twice."""
    machine = Machine.load(name)
    q = np.degrees(poses(machine.geometry)[:, machine.rotary]).round(9).tolist()
    assert q[0] == [0.0, 0.0] and [30.0, 30.0] in q
    for k in range(2):
        for angle in (30.0, 90.0):
            if machine.travel[machine.rotary[k], 1] >= math.radians(angle):
                assert [angle * (k == j) for j in range(2)] in q
    moved = poses(machine.geometry)
    assert len(np.unique(moved, axis=0)) == len(moved) <= 14
    assert (moved[-1] != 0.0).all(), "the last one moves every joint"


@pytest.mark.parametrize("kind", CLASSES)
def test_poses_lie_within_any_travel(kind: str) -> None:
    """Also where zero lies outside, or where an end is infinite."""
    rng = np.random.default_rng(13)
    for _ in range(100):
        file = random_machine(rng, kind).file
        ends = np.sort(rng.normal(0.0, 1.0, (5, 2)), axis=1)
        ends[rng.random((5, 2)) < 0.2] = np.inf
        ends[:, 0] = np.where(np.isinf(ends[:, 0]), -np.inf, ends[:, 0])
        joints = {
            name: msgspec.structs.replace(joint, travel=(float(low), float(high)))
            for (name, joint), (low, high) in zip(file.joints.items(), ends)
        }
        machine = Machine(msgspec.structs.replace(file, joints=joints))
        q = poses(machine.geometry)
        assert (q >= machine.travel[:, 0]).all() and (q <= machine.travel[:, 1]).all() and len(q) > 5
        assert np.isfinite(q).all()
        assert len(table(machine)) == len(q)


def test_a_joint_that_turns_backwards_only_is_turned_backwards() -> None:
    text = (FOLDER / "xyzac-trunnion.toml").read_text().replace("[-130, 130]", "[-100, 10]")
    machine = Machine.from_toml(text)
    tilts = np.degrees(poses(machine.geometry)[:, machine.joints.index("A")]).round(9)
    assert set(tilts) == {0.0, -30.0, -90.0}


def test_columns_are_aligned_and_zero_has_no_sign() -> None:
    for name in Machine.names():
        lines = pose_table(Machine.load(name).geometry).splitlines()
        ends = [[i for i, c in enumerate(line + " ") if c == " " and i and line[i - 1] != " "] for line in lines[5:]]
        assert all(end == ends[0] for end in ends)
        assert "-0.000 " not in "\n".join(lines) and "-0.00000" not in "\n".join(lines)
        assert lines[3].split()[:5] == list(Machine.load(name).joints)
        assert lines[4].split() == ["deg" if turns else "mm" for turns in Machine.load(name).is_rotary] + ["mm"] * 3
