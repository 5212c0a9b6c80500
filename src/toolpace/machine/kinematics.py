"""Positions and derivatives along the chain of a machine: forward, and closed-form inverse, point by point.

Arrays are in SI units; tips and tool axes are in the workpiece frame. Joint arrays (n, m) have one column a joint, in
the order of `Geometry.joints`; rotary arrays (n, 2) have one a rotary joint, nearest the workpiece first. Derivatives
0 to 3 along a path parameter stand in front, (4, n, ...). The formulas: docs/design/kinematics.md.
"""

from __future__ import annotations

import numpy as np

from toolpace.arrays import Bools, Floats, frozen
from toolpace.kernels.kinematics.geometry import Chain
from toolpace.machine.geometry import Geometry
from toolpace.machine.refusals import singular_pose

POLE = 1e-9
"""Sine of the angle between tool axis and pole below which the first rotary joint counts as free."""


def chain_of(geometry: Geometry) -> Chain:
    """The chain as the compiled functions take it."""
    return Chain(geometry.frame, geometry.group, geometry.place)


def forward(geometry: Geometry, q: Floats) -> tuple[Floats, Floats]:
    """Joint positions (n, m) to tips (n, 3) [m] and unit tool axes (n, 3)."""
    from toolpace.kernels.kinematics import chain

    q = frozen(q)
    tip, axis = np.empty((len(q), 3)), np.empty((len(q), 3))
    chain.forward(chain_of(geometry), q, tip, axis)
    return tip, axis


def axis_at(geometry: Geometry, rotary: Floats) -> Floats:
    """Rotary positions (n, 2) [rad] to unit tool axes (n, 3)."""
    from toolpace.kernels.kinematics import chain

    rotary = frozen(rotary)
    axis = np.empty((len(rotary), 3))
    chain.axes(geometry.frame, rotary, axis)
    return axis


def rotary_solutions(geometry: Geometry, axis: Floats, pole_tolerance: float = POLE) -> tuple[Floats, Bools]:
    """Tool axes (n, 3) to both rotary solutions (n, 2, 2) [point, solution, joint] and pole (n,).

    Angles lie in [-pi, pi]; nan where no angles, whatever the travel, give the axis. At the pole the first rotary
    joint is free; it is returned as zero there.
    """
    from toolpace.kernels.kinematics import chain

    axis = np.ascontiguousarray(axis, dtype=float)
    solutions, pole = np.empty((len(axis), 2, 2)), np.empty(len(axis), dtype=np.bool_)
    chain.rotary_solutions(geometry.frame, pole_tolerance, axis, solutions, pole)
    return solutions, pole


def joints_at(geometry: Geometry, tip: Floats, rotary: Floats) -> Floats:
    """Tips (n, 3) and rotary positions (n, 2) to joint positions (n, m), whatever their travel. Raises ReachError."""
    from toolpace.kernels.kinematics import chain

    tip, rotary = frozen(tip), frozen(rotary)
    q = np.empty((len(tip), len(geometry.joints)))
    singular = chain.joints_at(chain_of(geometry), tip, rotary, q)
    if singular >= 0:
        raise singular_pose(geometry, rotary[singular])
    return q


def linear_jets(geometry: Geometry, tip: Floats, rotary: Floats) -> Floats:
    """Derivatives of tip (4, n, 3) and rotary joints (4, n, 2) to those of all joints (4, n, m). Raises ReachError."""
    from toolpace.kernels.kinematics import jets

    tip, rotary = np.ascontiguousarray(tip, dtype=float), np.ascontiguousarray(rotary, dtype=float)
    q = np.empty((4, tip.shape[1], len(geometry.joints)))
    singular = jets.linear_jets(chain_of(geometry), tip, rotary, q)
    if singular >= 0:
        raise singular_pose(geometry, rotary[0, singular])
    return q


def rotary_jets(geometry: Geometry, axis: Floats, rotary: Floats) -> Floats:
    """Derivatives of the tool axis (4, n, 3) to those of the rotary joints (4, n, 2) near `rotary` (n, 2).

    At the pole the first rotary joint keeps its given position and rests. nan where the axis cannot be reached, and
    in the derivatives where it lies on the edge of reach.
    """
    from toolpace.kernels.kinematics import rotary_jets as near

    axis, rotary = np.ascontiguousarray(axis, dtype=float), np.ascontiguousarray(rotary, dtype=float)
    out = np.empty((4, axis.shape[1], 2))
    near.rotary_jets(geometry.frame, POLE, axis, rotary, out)
    return out


def axis_jets(geometry: Geometry, rotary: Floats) -> Floats:
    """Derivatives of the rotary joints (4, n, 2) to those of the tool axis (4, n, 3)."""
    from toolpace.kernels.kinematics import jets

    rotary = np.ascontiguousarray(rotary, dtype=float)
    out = np.empty((4, rotary.shape[1], 3))
    jets.axis_jets(geometry.frame, rotary, out)
    return out


def tip_lever(geometry: Geometry, tip: Floats, rotary: Floats) -> Floats:
    """(n, 2) most motion of a linear joint per unit of each rotary joint while the tip stands [m/rad]."""
    still, turning = np.zeros((4, len(tip), 3)), np.zeros((4, len(tip), 2))
    still[0], turning[0] = tip, rotary
    lever = np.empty((len(tip), 2))
    for joint in range(2):
        turning[1] = 0.0
        turning[1, :, joint] = 1.0
        lever[:, joint] = np.abs(linear_jets(geometry, still, turning)[1][:, geometry.linear]).max(axis=1)
    return lever
