"""The bending of a tool's tip by a force, from its compliance matrix; and the frames of forces.

workpiece: fixed to the part, as tips and tool axes are; a dynamometer under the part measures in it once it is turned
    with the part.
bed: fixed to the machine's bed; its x, y and z are those that the machine file is written in.
tool: fixed to the spindle housing, not to the spindle, so that it does not spin. z is the tool axis, from the tip to
    the spindle. With every rotary joint at zero x is the bed's x without its part along z; where that is nothing (a
    spindle along x), y is the bed's y. It turns with the rotary joints of the tool's chain. Compliance is in it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from toolpace.common.arrays import Floats, number, numbers
from toolpace.common.errors import UsageError, did_you_mean
from toolpace.common.units import LONGEST_TOOL, METRES, WIDEST_TOOL, refuse_other_unit
from toolpace.common.value_objects import ByValue, one_line
from toolpace.machine.machine import Machine, check_machine

SYMMETRIC = 1e-6
"""Share of the largest entry by which a compliance may be lopsided, as measured figures are rounded."""
SOFTEST_MODULUS = 1e9
"""Of a tool [Pa]: half of that of nylon."""
SOFTEST = 1e-3
"""Most of an entry [m/N]: a millimetre a newton is a slip of units."""
FRAMES = ("workpiece", "bed", "tool")
ON_THE_TABLE = {"table-table": 2, "head-table": 1, "head-head": 0}
"""Rotary joints between the bed and the workpiece."""


@dataclass(frozen=True, eq=False, repr=False)
class Bending(ByValue):
    """Static, linear bending: the tip goes by `compliance` times the force that acts on it.

    Only the tip's place is told, not the turn of the tool's end. In the tool frame z points from
    the tip to the spindle, and x and y are fixed to the spindle housing. Raises UsageError for what no spring can be.
    """

    compliance: Floats
    """(3, 3) symmetric, positive semidefinite [m/N]."""

    def __post_init__(self) -> None:
        matrix = numbers(self.compliance, "compliance", (3, 3), unit="m/N")
        largest = float(np.abs(matrix).max())
        if largest > SOFTEST:
            raise UsageError(f"compliance of {largest:g} m/N is more than {SOFTEST:g} m/N: check its unit")
        if not np.allclose(matrix, matrix.T, rtol=0.0, atol=SYMMETRIC * largest):
            raise UsageError(
                "compliance is not symmetric: the tip goes as far along x by a force along y as along y by x"
            )
        matrix = 0.5 * (matrix + matrix.T)
        if np.linalg.eigvalsh(matrix)[0] < -SYMMETRIC * largest:
            raise UsageError("compliance has a direction in which the tip comes towards the force: check its signs")
        matrix.flags.writeable = False
        object.__setattr__(self, "compliance", matrix)

    @classmethod
    def cantilever(cls, diameter: float, length: float, youngs_modulus: float) -> Bending:
        """A round bar clamped at one end: 3 E I / L^3 with I = pi d^4 / 64 across, E A / L along (m, m, Pa).

        Flutes make a cutter softer than its diameter says: about 0.8 of it is the bar that bends alike (Kops and Vo,
        Determination of the equivalent diameter of an end mill based on its compliance, CIRP Annals 39, 1990).
        """
        for name, value in (("diameter", diameter), ("length", length), ("youngs_modulus", youngs_modulus)):
            number(value, f"cantilever: {name}", least=0.0, above=True)
        refuse_other_unit(diameter, WIDEST_TOOL, "cantilever: diameter", METRES)
        refuse_other_unit(length, LONGEST_TOOL, "cantilever: length", METRES)
        if youngs_modulus < SOFTEST_MODULUS:
            raise UsageError(f"cantilever: youngs_modulus is {youngs_modulus:g}; give Pa: 580 GPa is 580e9")
        across = 3.0 * youngs_modulus * (math.pi * diameter**4 / 64.0) / length**3
        along = youngs_modulus * (math.pi * diameter**2 / 4.0) / length
        return cls.of_stiffness(across, across, along)

    @classmethod
    def of_stiffness(cls, x: float, y: float, z: float) -> Bending:
        """Three springs along the axes of the tool frame [N/m]; inf where nothing gives."""
        for name, value in (("x", x), ("y", y), ("z", z)):
            number(value, f"stiffness along {name}", least=0.0, above=True, endless=True, unit="N/m")
        return cls(np.diag([1.0 / x, 1.0 / y, 1.0 / z]))

    def __repr__(self) -> str:
        shown = " ".join(f"{1e6 * value:.3g}" for value in np.diag(self.compliance))
        return one_line(self, f"{shown} um/N along x, y, z of the tool")

    def deflection(self, force: npt.ArrayLike, machine: Machine, q: npt.ArrayLike, frame: str = "workpiece") -> Floats:
        """How far the tip bends [m], in the workpiece frame, in the shape of `force`.

        force: (3,) or (n, 3) [N] that acts on the tool, measured or modelled, in `frame`: "workpiece", "bed" or "tool".
        q: joint positions (m,) for all, or (n, m). Raises UsageError where shapes do not fit.
        """
        check_machine(machine, "deflection")
        forces = numbers(force, "deflection: force", ("n", 3), (3,), unit="N")
        rows, m = np.atleast_2d(forces), len(machine.joints)
        cure = f"the joint positions of machine {machine.name}, for all or for each of {len(rows)} forces"
        joints = np.atleast_2d(numbers(q, "deflection: q", (m,), (len(rows), m), (1, m), unit="m, rad", cure=cure))
        from_tool = to_workpiece(machine, joints, "tool")
        to_tool = np.swapaxes(from_tool, 1, 2) @ to_workpiece(machine, joints, frame)
        bent: Floats = np.einsum("nab,nb->na", from_tool @ self.compliance @ to_tool, rows)
        return bent[0] if forces.ndim == 1 else bent


def to_workpiece(machine: Machine, q: Floats, frame: str) -> Floats:
    """Rotations (n, 3, 3) that take vectors of a frame to the workpiece frame, at joint positions (n, m).

    Raises UsageError for an unknown frame.
    """
    if frame not in FRAMES:
        raise UsageError(f"frame '{frame}' is not known; {did_you_mean(frame, FRAMES)}")
    rotary = q[:, machine.rotary]
    if frame == "workpiece":
        return np.broadcast_to(np.eye(3), (len(q), 3, 3)).copy()
    if frame == "bed":
        count = ON_THE_TABLE[machine.kind]
        return _turns(machine, rotary, count) @ _bed_at_zero(machine)
    return tool_to_workpiece(machine, rotary)


def tool_to_workpiece(machine: Machine, rotary: Floats) -> Floats:
    """Rotations (n, 3, 3) from the tool frame to the workpiece frame, at rotary positions (n, 2) [rad]."""
    return _turns(machine, rotary, 2) @ _bed_at_zero(machine) @ tool_frame_at_zero(machine)


def tool_frame_at_zero(machine: Machine) -> Floats:
    """(3, 3) columns x, y, z of the tool frame in the bed frame, with every joint at zero."""
    z = np.array(machine.file.chain.tool_axis, dtype=float)
    z /= np.linalg.norm(z)
    x = np.array([1.0, 0.0, 0.0]) - z[0] * z
    if np.linalg.norm(x) > 1e-6:
        x /= np.linalg.norm(x)
    else:
        x = np.cross([0.0, 1.0, 0.0], z)
    return np.stack([x, np.cross(z, x), z], axis=1)


def _bed_at_zero(machine: Machine) -> Floats:
    """(3, 3) from the bed frame to the workpiece frame, with every joint at zero."""
    chain = machine.file.chain
    x, z = np.array(chain.workpiece_x, dtype=float), np.array(chain.workpiece_z, dtype=float)
    z /= np.linalg.norm(z)
    x -= (x @ z) * z
    x /= np.linalg.norm(x)
    return np.stack([x, np.cross(z, x), z], axis=0)


def _turns(machine: Machine, rotary: Floats, count: int) -> Floats:
    """(n, 3, 3) what the first `count` rotary joints, nearest the workpiece first, turn; in the workpiece frame."""
    turned = np.broadcast_to(np.eye(3), (len(rotary), 3, 3))
    for joint in range(count):
        turned = turned @ about(machine.geometry.frame[joint], rotary[:, joint])
    return np.ascontiguousarray(turned)


def about(axis: Floats, angle: Floats) -> Floats:
    """Rotations (n, 3, 3) about a unit vector (3,) by angles (n,) [rad] (Rodrigues' formula)."""
    x, y, z = axis
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    sine, rest = np.sin(angle)[:, None, None], (1.0 - np.cos(angle))[:, None, None]
    found: Floats = np.eye(3) + sine * cross + rest * (cross @ cross)
    return found
