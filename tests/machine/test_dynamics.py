"""Torques of joints against pinocchio, closed forms, the judge's derivation and a function; files with masses."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from tests.support.heavy_machines import heavy_machine, heavy_text, pinocchio_torques, random_dynamics
from toolpace.common.errors import MachineError, UsageError
from toolpace.judge.torque import JointTorques
from toolpace.machine.dynamics import Dynamics, Link
from toolpace.machine.dynamics.torques import torque_rows
from toolpace.machine.machine import Machine


def close(found, wanted):
    return np.abs(found - wanted).max() <= 1e-12 * np.abs(wanted).max()


def as_pinocchio_has_it(seed):
    joints = 1 + seed % 7
    dynamics = random_dynamics(seed, joints, branched=seed % 2 == 1)
    moment = np.random.default_rng(1000 + seed).normal(size=(3, 4, joints))
    return close(dynamics(*moment), pinocchio_torques(dynamics, *moment))


@pytest.mark.parametrize("seed", range(14))
def test_torques_of_random_chains_and_trees_are_pinocchios(seed):
    assert as_pinocchio_has_it(seed)


@pytest.mark.thorough
def test_torques_of_a_thousand_random_chains_are_pinocchios():
    assert all(as_pinocchio_has_it(seed) for seed in range(100, 1100))


def test_two_links_in_closed_form():
    """Spong, Hutchinson and Vidyasagar (2006), equation 6.58; in the plane x z, with the weight along -z."""
    m1, m2, l1, r1, r2, i1, i2, g = 3.0, 2.0, 0.5, 0.2, 0.3, 0.04, 0.03, 9.80665
    arm = Dynamics((
        Link("rotary", (0, -1, 0), (0, 0, 0), m1, (r1, 0, 0), (i1, i1, i1)),
        Link("rotary", (0, -1, 0), (l1, 0, 0), m2, (l1 + r2, 0, 0), (i2, i2, i2)),
    ))  # fmt: skip
    q, v, a = np.random.default_rng(3).normal(size=(3, 10, 2))
    (q1, q2), (v1, v2), (a1, a2) = q.T, v.T, a.T
    d12 = m2 * (r2**2 + l1 * r2 * np.cos(q2)) + i2
    d11 = m1 * r1**2 + m2 * (l1**2 + r2**2 + 2 * l1 * r2 * np.cos(q2)) + i1 + i2
    h = m2 * l1 * r2 * np.sin(q2)
    g2 = m2 * r2 * g * np.cos(q1 + q2)
    wanted = [
        d11 * a1 + d12 * a2 - h * v2 * v1 - h * (v1 + v2) * v2 + (m1 * r1 + m2 * l1) * g * np.cos(q1) + g2,
        d12 * a1 + (m2 * r2**2 + i2) * a2 + h * v1**2 + g2,
    ]
    assert close(arm(q, v, a), np.stack(wanted, axis=1))


def test_a_workpiece_beside_the_axis_of_the_table_turns_the_cradle():
    """A table of 12 kg, 40 mm beside its axis: its weight times the lever that A and C make of it."""
    machine = heavy_machine(**dict.fromkeys("AC", "torque = 60\nrotor_inertia = 1"), X="", Y="", Z="")
    angle, turn = np.meshgrid(np.linspace(-1.0, 1.0, 5), np.linspace(0.0, 6.0, 7))
    q = np.zeros((angle.size, 5))
    q[:, machine.joints.index("A")], q[:, machine.joints.index("C")] = angle.ravel(), turn.ravel()
    still = np.zeros_like(q)
    found = JointTorques(machine.file).at(q, still, still)[:, machine.joints.index("A")]
    # A turns about -x, C about -z
    y, z = -0.04 * np.sin(turn.ravel()), 0.11
    wanted = 12.0 * 9.80665 * -(y * np.cos(angle.ravel()) + z * np.sin(angle.ravel()))
    assert np.abs(found - wanted).max() < 1e-12


def test_the_judges_derivation_is_the_planners():
    for machine in (heavy_machine(), head_head()):
        moment = np.random.default_rng(5).normal(size=(3, 50, 5))
        assert close(Dynamics.of_machine(machine.file)(*moment), JointTorques(machine.file).at(*moment))


def head_head():
    """A machine whose tool is turned by both rotary joints, on its head: a skew head and a sloping bed."""
    text = Machine.load("xyzbc-head").to_toml()
    text = text.replace("tool_length", "gravity = [3, -2, -9]\ntool_length", 1)
    for k, name in enumerate("XYZBC"):
        body = f"mass = {10 + k}\ncentre = [10, {20 * k}, 300]\ninertia = [1, 1.5, 1.2, 0.1, 0, 0.2]"
        limit = "force = 9e3" if name in "XYZ" else "torque = 9e3"
        text = text.replace(f"[joints.{name}]", f"[joints.{name}]\n{limit}\n{body}")
    return Machine.from_toml(text)


def test_a_function_for_torques_tells_the_same_coefficients():
    dynamics = random_dynamics(11, 4, friction=True)
    q = np.random.default_rng(2).normal(size=(4, 20, 4))
    names = ("a", "b", "c", "d")
    rows = torque_rows(dynamics, 1e3, names)
    same = torque_rows(lambda *moment: dynamics(*moment), 1e3, names, [row.unit == "N" for row in rows])
    for one, other in zip(rows, same, strict=True):
        assert one.name == other.name and np.allclose(one.shares(q), other.shares(q), rtol=1e-9, atol=1e-12)
        assert np.allclose(one.line_shares(q), other.line_shares(q), rtol=1e-9, atol=1e-12)
    wrong = torque_rows(lambda q, v, a: a + v**3, 1e3, names)
    with pytest.raises(UsageError, match="is not quadratic in the velocities"):
        wrong[0].shares(q)
    short = torque_rows(lambda q, v, a: a[:, 0], 1e3, names)
    with pytest.raises(UsageError, match=r"gives shape \(140,\) for 140 places; it must be \(140, 4\)"):
        short[0].shares(q)


def test_coefficients_along_a_path_make_the_torque_of_its_motion():
    dynamics = random_dynamics(6, 5, friction=True)
    q = np.random.default_rng(7).normal(size=(4, 30, 5))
    z, slope = 0.7, -0.3
    found = dynamics.along(q)
    torque = found.slope * slope + found.square * z + found.linear * math.sqrt(z) + found.constant
    assert close(torque, dynamics(q[0], q[1] * math.sqrt(z), q[2] * z + q[1] * slope / 2.0))


def test_machine_files_with_masses_are_written_as_they_were_read():
    for text in (heavy_text(), head_head().to_toml()):
        machine = Machine.from_toml(text)
        again = Machine.from_toml(machine.to_toml())
        assert again == machine and hash(again) == hash(machine) and again.file == machine.file
    machine = heavy_machine()
    assert machine.limits.names[-5:] == ["force X", "force Y", "force Z", "torque A", "torque C"]
    assert [rows.unit for rows in machine.limits.rows] == ["N", "N", "N", "N m", "N m"]
    assert machine.file.joints["C"].centre == (0.0, 0.0, 0.04) and machine.file.workpiece.centre == (0.04, 0.0, 0.11)
    assert heavy_machine(C="torque = 26\nmass = 40") != machine
    falling = heavy_machine(C="torque = [[0, 25], [90.1, 25], [180, 10.5]]\nmass = 40", X="mass = 9\nforce = [[0, 7]]")
    again = Machine.from_toml(falling.to_toml())
    assert again == falling and again.file == falling.file
    curve = falling.file.joints["C"].motor
    assert curve.limit.tolist() == [25, 25, 10.5] and np.allclose(curve.speed, np.radians([0, 90.1, 180]), rtol=1e-15)
    assert [row["torque"] for row in falling.summary() if row["joint"] == "C"] == ["25 .. 10.5 N m"]
    assert falling.file.joints["X"].force == 7.0 and falling.file.joints["X"].motor_curve is None
    assert not Machine.load("xyzac-trunnion").limits.rows


@pytest.mark.parametrize("old, new, message", [
    ("mass = 180", "mass = -1", r"joint X: mass = -1 kg; give a number from 0 to"),
    ("mass = 180", "mass = nan", r"joint X: mass = nan kg"),
    ("force = 2000", "force = 0", r"joint X: force = 0 N; give a number above zero"),
    ("force = 2000", "torque = 20", r"joint X: torque is not that of a linear joint; write force = ... in N"),
    ("inertia = [4, 3, 5]", "inertia = [4, 3, 9]", r"joint A: inertia = \[4.0, 3.0, 9.0\] is that of no body"),
    ("inertia = [4, 3, 5]", "inertia = [4, 3]", r"joint A: inertia has 2 figures; give xx, yy, zz, or"),
    ("inertia = [4, 3, 5]", "inertia = [4, 3, inf]", r"joint A: inertia = \[4.0, 3.0, inf\] kg m\^2; give finite"),
    ("centre = [0, 0, 20]", "centre = [0, 0, 2e9]", r"joint A: centre = .* none beyond 1000 m"),
    ("dry_friction = 5", "dry_friction = -5", r"joint A: dry_friction = -5; give a number of zero or more"),
    ("balance = 1400", "balance = inf", r"joint Z: balance = inf; give a finite torque or force"),
    ("viscous_friction = 120", "viscous_friction = 5e5", r"joint X: viscous_friction = 500000 takes all of 2000 of"),
    ("[chain]", "[chain]\ngravity = [0, 0, nan]", r"\[chain\] gravity = \[0.0, 0.0, nan\] m/s\^2; give three finite"),
    ("[chain]", "[chain]\ngravity = [0, 0, -9806.65]", r"\[chain\] gravity = .* at most 20 together"),
    ("torque = 25", "torque = [[0, 25], [9, 26]]", r"joint C: torque rises from 25 to 26 at speed 9"),
    ("torque = 25", "torque = [[0, 25], [9, 0]]", r"joint C: torque is 0 at speed 9; give limits above zero"),
    ("torque = 25", "torque = { upwards = 9 }", r"joint C: torque is \{'upwards': 9\}; give a number, or corners like"),
    ("force = 2000", "torque = [[0, 9]]", r"\[joints.X\] Expected `float \| null`, got `array`: key `torque`"),
    ("mass = 12", "mas = 12", r"\[workpiece\] unknown key 'mas'; did you mean 'mass'"),
    ("[workpiece]\nmass = 12", "[workpiece]", r"\[workpiece\] 'mass' is missing"),
])  # fmt: skip
def test_a_mistake_in_a_mass_is_told(old, new, message):
    assert old in heavy_text()
    with pytest.raises(MachineError, match=message) as caught:
        Machine.from_toml(heavy_text().replace(old, new, 1), "m.toml")
    assert str(caught.value).startswith("m.toml: ") and "\n" not in str(caught.value)


def test_mistakes_in_dynamics_are_told():
    link = Link("rotary", (0, 0, 1), mass=1.0, inertia=(1, 1, 1))
    with pytest.raises(MachineError, match="joint X has a limit of torque or force, and moves no mass"):
        Machine.from_toml(Machine.load("paper-ab").to_toml().replace("[joints.X]", "[joints.X]\nforce = 10"))
    for wrong, message in (
        (lambda: Link("round", (0, 0, 1)), "kind is 'round'"),
        (lambda: Link("rotary", (0, 0, 0)), "direction .* is none"),
        (lambda: replace(link, mass=-1.0), "link: mass is -1"),
        (lambda: replace(link, inertia=(1, 1, 3)), "link: inertia .* is that of no body"),
        (lambda: Dynamics(()), "give a tp.Link for each joint"),
        (lambda: Dynamics((link, link), (-1,)), "1 parents of 2 links"),
        (lambda: Dynamics((link, link), (1, 0)), "link 0 does not sit on the bed"),
        (lambda: torque_rows(Dynamics((link,)), 1.0, ("a", "b")), "dynamics of 1 joints for 2"),
        (lambda: torque_rows(Dynamics((link,)), 0.0, ("a",)), "that of joint a is 0; give a positive number"),
        (lambda: Dynamics((link,))(np.zeros((2, 1)), np.zeros((2, 2)), np.zeros((2, 1))), "dynamics: qd has shape"),
    ):
        with pytest.raises(UsageError, match=message):
            wrong()


def test_another_part_on_the_table():
    machine = heavy_machine()
    part = machine.file.workpiece
    assert machine.with_workpiece(part.mass, part.centre, part.inertia) == machine
    heavier = machine.with_workpiece(40.0, (0.1, 0.0, 0.1))
    q = np.zeros((1, 5))
    tilted = q + 0.5 * (np.arange(5) == machine.joints.index("A"))
    assert abs(heavier.dynamics(tilted, q, q) - machine.dynamics(tilted, q, q))[0, machine.joints.index("A")] > 1.0
    with pytest.raises(MachineError, match="with_workpiece: mass = -1 kg"):
        machine.with_workpiece(-1.0, (0, 0, 0))
    with pytest.raises(UsageError, match="with_workpiece: centre has shape"):
        machine.with_workpiece(1.0, (0, 0))
