"""A machine with masses, and random chains of bodies with their model in pinocchio."""

from __future__ import annotations

import numpy as np

from toolpace.machine.dynamics import Dynamics, Link
from toolpace.machine.machine import FOLDER, Machine

BODIES = {
    "X": "mass = 180\nforce = 2000\ndry_friction = 80\nviscous_friction = 120",
    "Y": "mass = 220\nforce = 2500\ndry_friction = 80",
    "Z": "mass = 150\ncentre = [0, 0, 300]\nforce = 2500\nbalance = 1400",
    "A": "mass = 90\ncentre = [0, 0, 20]\ninertia = [4, 3, 5]\ntorque = 60\ndry_friction = 5\nrotor_inertia = 0.5",
    "C": "mass = 40\ncentre = [0, 0, 40]\ninertia = [0.5, 0.5, 0.9, 0.01, 0.02, -0.03]\ntorque = 25",
}
"""What is put below the headings of the trunnion's joints."""
WORKPIECE = "[workpiece]\nmass = 12\ncentre = [40, 0, 110]\ninertia = [0.1, 0.1, 0.1]\n\n"


def heavy_text(**bodies: str) -> str:
    """The machine file of a trunnion with masses; `bodies` in place of what stands above."""
    text = (FOLDER / "xyzac-trunnion.toml").read_text()
    for name, body in (BODIES | bodies).items():
        text = text.replace(f"[joints.{name}]\n", f"[joints.{name}]\n{body}\n")
    return text.replace("[joints.X]", f"{WORKPIECE}[joints.X]")


def heavy_machine(**bodies: str) -> Machine:
    """The trunnion with masses."""
    return Machine.from_toml(heavy_text(**bodies))


def random_dynamics(seed: int, joints: int, branched: bool = False, friction: bool = False) -> Dynamics:
    """A chain of bodies, each of six points of mass, on rotary joints and a few linear ones; or a tree of them."""
    rng = np.random.default_rng(seed)
    links = []
    for _ in range(joints):
        points, mass = 0.15 * rng.normal(size=(6, 3)), rng.uniform(0.2, 2.0, 6)
        centre = mass @ points / mass.sum()
        tensor = sum(m * (d @ d * np.eye(3) - np.outer(d, d)) for m, d in zip(mass, points - centre))
        elements = tensor[(0, 1, 2, 0, 0, 1), (0, 1, 2, 1, 2, 2)]
        rub = rng.uniform(0.0, 1.0, 4) if friction else np.zeros(4)
        kind, direction, point = "rotary" if rng.random() < 0.8 else "linear", rng.normal(size=3), rng.normal(size=3)
        place = tuple(centre + 0.3 * rng.normal(size=3))
        links.append(
            Link(kind, tuple(direction), tuple(0.3 * point), float(mass.sum()), place, tuple(elements.tolist()), *rub)
        )
    parents = tuple(int(rng.integers(-1, k)) if branched and k else k - 1 for k in range(joints))
    return Dynamics(tuple(links), parents, tuple(5.0 * rng.normal(size=3)))


def pinocchio_torques(dynamics: Dynamics, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray) -> np.ndarray:
    """(n, joints) by pinocchio, without what drives add: rotors, friction and balance. Skips where it is not there."""
    import pytest

    pin = pytest.importorskip("pinocchio")
    model, joints = pin.Model(), []
    model.gravity = pin.Motion(np.array(dynamics.gravity), np.zeros(3))
    for k, (link, parent) in enumerate(zip(dynamics.links, dynamics.parents)):
        kind = pin.JointModelRevoluteUnaligned if link.kind == "rotary" else pin.JointModelPrismaticUnaligned
        axis = np.array(link.direction) / np.linalg.norm(link.direction)
        below = np.zeros(3) if parent < 0 else np.array(dynamics.links[parent].point)
        place = pin.SE3(np.eye(3), np.array(link.point) - below)
        joints.append(model.addJoint(0 if parent < 0 else joints[parent], kind(axis), place, f"q{k}"))
        body = pin.Inertia(link.mass, np.array(link.centre) - np.array(link.point), link.tensor)
        model.appendBodyToJoint(joints[-1], body, pin.SE3.Identity())
    data = model.createData()
    return np.array([pin.rnea(model, data, *each) for each in zip(q, qd, qdd)])


def motor_torques(dynamics: Dynamics, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray) -> np.ndarray:
    """(n, joints) by pinocchio, with what drives add."""
    found = pinocchio_torques(dynamics, q, qd, qdd)
    for k, link in enumerate(dynamics.links):
        friction = link.viscous_friction * qd[:, k] + link.dry_friction * np.sign(qd[:, k])
        found[:, k] += link.rotor_inertia * qdd[:, k] + friction - link.balance
    return found
