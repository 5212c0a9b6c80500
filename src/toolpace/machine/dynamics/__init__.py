"""Torques and forces of the joints of a machine or a robot along a path, from its masses.

A chain of bodies is driven by its joints. Along a path q(s), with z = (ds/dt)^2 and primes for derivatives by s, a
joint's torque (of a linear joint: force) is

    tau = (M q'/2) z' + (M q'' + c(q, q')) z + F q' sqrt(z) + g(q) + R sign(q') - B

with the mass matrix M, the centrifugal and Coriolis terms c, viscous friction F, weight g, dry friction R and weight
balance B. Lagrange's form of d'Alembert's principle: with J the Jacobians of a body's centre and of its rotation,
and their derivatives J' along the path,

    M = sum m J'J + Jw'I Jw,    c = sum m J'(dJ/ds q') + Jw'(I dJw/ds q' + w x I w),    g = -sum m J'gravity

(Featherstone, Rigid Body Dynamics Algorithms, 2008, sections 2 and 5; `kernels/kinematics/torques.py`).
`judge/torque.py` has the same by Newton and Euler, link by link.
"""

from __future__ import annotations

from dataclasses import dataclass, field, fields, replace
from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import numpy.typing as npt

from toolpace.common.arrays import Floats, number, numbers
from toolpace.common.errors import MachineError, UsageError
from toolpace.common.value_objects import ByValue, one_line
from toolpace.machine.file import GRAVITY, MachineFile
from toolpace.machine.plausibility import check_inertia

if TYPE_CHECKING:
    from toolpace.kernels.kinematics.torques import Bodies

STILL = 1e-9
"""Share of the fastest joint's motion up to which another stands."""
Vector = tuple[float, float, float]


@dataclass(frozen=True)
class Link:
    """A joint, and the body that it moves. Points and directions are in the frame of the bed, every joint at zero."""

    kind: str
    """"linear" or "rotary"."""
    direction: Vector
    """In which the joint moves the body, or about which it turns it by the right-hand rule; of any length."""
    point: Vector = (0.0, 0.0, 0.0)
    """On the axis of a rotary joint [m]."""
    mass: float = 0.0
    """Of the body [kg]."""
    centre: Vector = (0.0, 0.0, 0.0)
    """Of its mass [m]."""
    inertia: tuple[float, ...] = (0.0, 0.0, 0.0)
    """About that centre [kg m^2]: xx, yy, zz, and where they are not zero the elements xy, xz, yz of the tensor."""
    rotor_inertia: float = 0.0
    """Of motor and gear, as the joint feels it: [kg m^2] times the square of the gear ratio, of a linear joint [kg]."""
    viscous_friction: float = 0.0
    """[N m s/rad, N s/m]"""
    dry_friction: float = 0.0
    """[N m, N]"""
    balance: float = 0.0
    """Torque or force by which a counterweight moves the joint forwards, wherever it is [N m, N]."""

    def __post_init__(self) -> None:
        if self.kind not in ("linear", "rotary"):
            raise UsageError(f"link: kind is {self.kind!r}; give 'linear' or 'rotary'")
        for name in ("direction", "point", "centre"):
            object.__setattr__(self, name, tuple(numbers(getattr(self, name), f"link: {name}", (3,)).tolist()))
        if not np.linalg.norm(self.direction) > 1e-9:
            raise UsageError(f"link: direction {list(self.direction)} is none; give e.g. (0, 0, 1)")
        for name in ("mass", "rotor_inertia", "viscous_friction", "dry_friction"):
            number(getattr(self, name), f"link: {name}", least=0.0)
        number(self.balance, "link: balance")
        figures = numbers(self.inertia, "link: inertia", ("k",)).tolist()
        object.__setattr__(self, "inertia", tuple(figures))
        try:
            check_inertia(self.inertia, "link")
        except MachineError as error:
            raise UsageError(str(error)) from None

    @property
    def tensor(self) -> Floats:
        """(3, 3) the inertia about the centre."""
        return tensor_of(self.inertia)


def tensor_of(inertia: tuple[float, ...]) -> Floats:
    """(3, 3) of the figures xx, yy, zz, and xy, xz, yz where they are told."""
    xx, yy, zz, xy, xz, yz = (*inertia, 0.0, 0.0, 0.0)[:6]
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


class TorqueTerms(NamedTuple):
    """Terms (n, joints) of torques along a path [N m, N]: tau = slope z' + square z + linear sqrt(z) + constant."""

    slope: Floats
    """Of z' = 2 d2s/dt2."""
    square: Floats
    """Of z = (ds/dt)^2."""
    linear: Floats
    """Of ds/dt: viscous friction."""
    constant: Floats
    """Weight, dry friction in the direction of the path, weight balance."""


@dataclass(frozen=True, eq=False, repr=False)
class Dynamics(ByValue):
    """Torques of a chain, or of a tree, of bodies that joints move. Raises UsageError for what is no such chain."""

    links: tuple[Link, ...]
    """(m,) in the order of the joints' columns."""
    parents: tuple[int, ...] = ()
    """(m,) the link that each sits on, -1 for the bed; without them each sits on the one before."""
    gravity: Vector = GRAVITY
    """[m/s^2]"""
    chains: tuple[tuple[int, ...], ...] = field(init=False, compare=False)
    """(m,) for each link the links from the bed to itself."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "links", tuple(self.links))
        if not self.links or not all(isinstance(each, Link) for each in self.links):
            raise UsageError("dynamics: give a tp.Link for each joint")
        parents = tuple(self.parents) or tuple(range(-1, len(self.links) - 1))
        object.__setattr__(self, "parents", parents)
        object.__setattr__(self, "gravity", tuple(numbers(self.gravity, "dynamics: gravity", (3,)).tolist()))
        if len(parents) != len(self.links):
            raise UsageError(f"dynamics: {len(parents)} parents of {len(self.links)} links; give one a link")
        chains = []
        for k in range(len(parents)):
            chain = [k]
            while parents[chain[0]] != -1:
                chain.insert(0, parents[chain[0]])
                if not 0 <= chain[0] < len(parents) or chain[0] in chain[1:]:
                    raise UsageError(f"dynamics: link {k} does not sit on the bed; its parents are {chain[:-1]}")
            chains.append(tuple(chain))
        object.__setattr__(self, "chains", tuple(chains))

    def __repr__(self) -> str:
        return one_line(self, f"of {len(self.links)} joints", f"{sum(each.mass for each in self.links):g} kg")

    def has_dry_friction(self, joint: int) -> bool:
        """Whether a joint has some: its torque jumps where it turns back."""
        return self.links[joint].dry_friction > 0.0

    @classmethod
    def of_machine(cls, file: MachineFile) -> Dynamics:
        """That of a machine file: its two chains from the bed, and the part on the last joint of the workpiece's."""
        names, chain = list(file.joints), file.chain
        below = {name: on for side in (chain.workpiece, chain.tool) for on, name in pairwise(("", *side))}
        links = []
        for name, joint in file.joints.items():
            link = Link(**{each.name: getattr(joint, each.name) for each in fields(Link)})
            if file.workpiece is not None and chain.workpiece[-1:] == (name,):
                link = _joined(link, file.workpiece.mass, file.workpiece.centre, file.workpiece.inertia)
            links.append(link)
        parents = tuple(names.index(below[name]) if below[name] else -1 for name in names)
        return cls(tuple(links), parents, chain.gravity)

    def __call__(self, q: npt.ArrayLike, qd: npt.ArrayLike, qdd: npt.ArrayLike) -> Floats:
        """Torques (n, joints) [N m, N] at positions, velocities and accelerations (n, joints) [m or rad, s]."""
        shape = ("n", len(self.links))
        moment = [numbers(each, f"dynamics: {name}", shape) for name, each in zip(("q", "qd", "qdd"), (q, qd, qdd))]
        _, square, linear, constant = self.along(np.stack(moment))
        return square + linear + constant

    def along(self, q: Floats) -> TorqueTerms:
        """The terms from the joints q (3 or 4, n, joints): positions and derivatives along the path."""
        from toolpace.kernels.kinematics import torques

        out = np.zeros((3, *q.shape[1:]))
        torques.along(self._as_bodies(), np.require(q, np.float64, ["C", "W"]), out)
        rotor, viscous, dry, balance = (
            np.array([getattr(each, name) for each in self.links])
            for name in ("rotor_inertia", "viscous_friction", "dry_friction", "balance")
        )
        first, second = q[1], q[2]
        slope, square = out[0] + rotor * first, out[1] + rotor * second
        # what a joint that stands moves by rounding has no direction
        stands = np.abs(first) <= STILL * np.abs(first).max(axis=1, initial=0.0)[:, None]
        rubs = dry * np.where(stands, 0.0, np.sign(first))
        return TorqueTerms(slope / 2.0, square, viscous * first, out[2] + rubs - balance)

    def _as_bodies(self) -> Bodies:
        """The bodies as the kernel takes them."""
        from toolpace.kernels.kinematics.torques import Bodies

        links = self.links
        axis = np.array([each.direction for each in links])
        return Bodies(
            np.array(sorted(range(len(links)), key=lambda k: len(self.chains[k]))),
            np.array(self.parents),
            np.array([each.kind == "rotary" for each in links]),
            axis / np.linalg.norm(axis, axis=1)[:, None],
            np.array([each.point for each in links]),
            np.array([each.mass for each in links]),
            np.array([each.centre for each in links]),
            np.array([each.tensor for each in links]),
            np.array(self.gravity),
        )


def _joined(link: Link, mass: float, centre: Vector, inertia: tuple[float, ...]) -> Link:
    """A link with a body fixed to it."""
    both, weights = np.array([link.centre, centre]), np.array([link.mass, mass])
    if not weights.any():
        return link
    middle = weights @ both / weights.sum()
    tensor = link.tensor + tensor_of(inertia)
    for weight, at in zip(weights, both - middle):
        # Steiner
        tensor = tensor + weight * (at @ at * np.eye(3) - np.outer(at, at))
    elements = tensor[(0, 1, 2, 0, 0, 1), (0, 1, 2, 1, 2, 2)]
    return replace(link, mass=float(weights.sum()), centre=tuple(middle.tolist()), inertia=tuple(elements.tolist()))
