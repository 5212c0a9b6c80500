"""Torques and forces of the joints of a machine or a robot along a path, from its masses.

A chain of bodies is driven by its joints. Along a path q(s), with z = (ds/dt)^2 and primes for derivatives by s, a
joint's torque (of a linear joint: force) is

    tau = (M q'/2) z' + (M q'' + c(q, q')) z + F q' sqrt(z) + g(q) + R sign(q') - B

with the mass matrix M, the centrifugal and Coriolis terms c, viscous friction F, weight g, dry friction R and weight
balance B. Lagrange's form of d'Alembert's principle: with J the Jacobians of a body's centre and of its rotation,
and their derivatives J' along the path,

    M = sum m J'J + Jw'I Jw,    c = sum m J'(dJ/ds q') + Jw'(I dJw/ds q' + w x I w),    g = -sum m J'gravity

(Featherstone, Rigid Body Dynamics Algorithms, 2008, sections 2 and 5). `judge/torque.py` has the same by Newton and
Euler, link by link.
"""

from __future__ import annotations

from dataclasses import dataclass, field, fields, replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from toolpace.common.arrays import Floats, number, numbers
from toolpace.common.errors import MachineError, UsageError
from toolpace.common.value_objects import ByValue, one_line
from toolpace.machine.file import GRAVITY, MachineFile
from toolpace.machine.plausibility import check_inertia

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
        """The coefficients from the joints q (3 or 4, n, joints): positions and derivatives along the path."""
        first, second = q[1].T, q[2].T
        m, n = first.shape
        slope, square, constant = np.zeros((m, n)), np.zeros((m, n)), np.zeros((m, n))
        bodies = self._bodies(q[0].T, first)
        for body, chain in zip(bodies, self.chains):
            link = self.links[chain[-1]]
            if not link.mass and not any(link.inertia):
                continue
            columns = [self._column(body, bodies[i], i) for i in chain]
            tensor = np.einsum("ikn,kl,jln->ijn", body.turn, link.tensor, body.turn)
            # velocity and spin of the body by s, and what they change by where q'' is zero
            speed, spin = (sum(column[k] * first[i] for column, i in zip(columns, chain)) for k in (0, 1))
            change, twist = (sum(column[k] * first[i] for column, i in zip(columns, chain)) for k in (2, 3))
            bend, bent_spin = (sum(column[k] * second[i] for column, i in zip(columns, chain)) for k in (0, 1))
            moment = np.einsum("ijn,jn->in", tensor, spin)
            turning = np.einsum("ijn,jn->in", tensor, bent_spin + twist) + _cross(spin, moment)
            for (move, turn, _, _), i in zip(columns, chain):
                slope[i] += link.mass * _dot(move, speed) + _dot(turn, moment)
                square[i] += link.mass * _dot(move, bend + change) + _dot(turn, turning)
                constant[i] -= link.mass * _dot(move, np.array(self.gravity)[:, None])
        rotor, viscous, dry, balance = (
            np.array([getattr(each, name) for each in self.links])[:, None]
            for name in ("rotor_inertia", "viscous_friction", "dry_friction", "balance")
        )
        slope += rotor * first
        square += rotor * second
        constant += dry * np.sign(first) - balance
        return TorqueTerms(slope.T / 2.0, square.T, (viscous * first).T, constant.T)

    def _bodies(self, q: Floats, first: Floats) -> list[_Body]:
        """The bodies at positions and their derivatives along the path (m, n)."""
        found: dict[int, _Body] = {}
        for i in sorted(range(len(self.links)), key=lambda k: len(self.chains[k])):
            below = found.get(self.parents[i]) or _Body.at_rest(q.shape[1])
            found[i] = _Body.moved(below, self.links[i], q[i], first[i])
        return [found[i] for i in range(len(self.links))]

    def _column(self, body: _Body, joint: _Body, i: int) -> tuple[Floats, Floats, Floats, Floats]:
        """What a joint's motion does to a body: its centre and its rotation, (3, n) each, and what these change by
        along the path."""
        none = np.zeros_like(joint.axis)
        if self.links[i].kind == "linear":
            return joint.axis, none, joint.axis_change, none
        arm, arm_change = body.centre - joint.point, body.centre_change - joint.point_change
        change = _cross(joint.axis_change, arm) + _cross(joint.axis, arm_change)
        return _cross(joint.axis, arm), joint.axis, change, joint.axis_change


class _Body(NamedTuple):
    """A body at n places of a path, all in the frame of the bed; "change" is the derivative along the path."""

    turn: Floats
    """(3, 3, n) from directions with every joint at zero."""
    shift: Floats
    """(3, n) where the origin of the bed has gone with it."""
    spin: Floats
    """(3, n) rotation along the path."""
    shift_change: Floats
    axis: Floats
    """(3, n) of its joint."""
    axis_change: Floats
    point: Floats
    point_change: Floats
    centre: Floats
    """(3, n) of its mass."""
    centre_change: Floats

    @classmethod
    def at_rest(cls, n: int) -> _Body:
        """The bed."""
        turn, none = np.repeat(np.eye(3)[:, :, None], n, axis=2), np.zeros((3, n))
        return cls(turn, *(none,) * 9)

    def place(self, at: Vector) -> tuple[Floats, Floats]:
        """A point of the body (3, n), told with every joint at zero, and its change."""
        arm = np.einsum("ijn,j->in", self.turn, np.array(at))
        return arm + self.shift, _cross(self.spin, arm) + self.shift_change

    @classmethod
    def moved(cls, below: _Body, link: Link, q: Floats, first: Floats) -> _Body:
        """The body on `below` that a joint at positions q (n,) moves by `first` (n,) along the path."""
        direction = np.array(link.direction) / np.linalg.norm(link.direction)
        axis = np.einsum("ijn,j->in", below.turn, direction)
        axis_change = _cross(below.spin, axis)
        point, point_change = below.place(link.point)
        if link.kind == "linear":
            turn, spin = below.turn, below.spin
            shift = below.shift + axis * q
            shift_change = below.shift_change + axis_change * q + axis * first
        else:
            spin = below.spin + axis * first
            x, y, z = direction
            skew, along = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]]), np.outer(direction, direction)
            # Rodrigues' formula
            own = along[:, :, None] + (np.eye(3) - along)[:, :, None] * np.cos(q) + skew[:, :, None] * np.sin(q)
            turn = np.einsum("ijn,jkn->ikn", below.turn, own)
            arm = np.einsum("ijn,j->in", turn, np.array(link.point))
            shift, shift_change = point - arm, point_change - _cross(spin, arm)
        made = cls(turn, shift, spin, shift_change, axis, axis_change, point, point_change, shift, shift_change)
        centre, centre_change = made.place(link.centre)
        return made._replace(centre=centre, centre_change=centre_change)


def _cross(a: Floats, b: Floats) -> Floats:
    """The cross product of vectors (3, n)."""
    return np.stack([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def _dot(a: Floats, b: Floats) -> Floats:
    """The inner product (n,) of vectors (3, n)."""
    found: Floats = (a * b).sum(axis=0)
    return found


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
