"""From the tool to the workpiece: rotations of both chains, joint by joint, from the bed out."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.machine.machine import Machine


def tool_in_workpiece(machine: Machine, q: Floats) -> Floats:
    """(n, 3, 3) columns x, y, z of the spindle housing as the part sees them, at joint positions (n, m).

    z is the tool axis; with all joints at zero x is the bed's x, as far as it is across.
    """
    chain = machine.file.chain
    part = _turned(machine, q, chain.workpiece) @ _columns(chain.workpiece_x, chain.workpiece_z)
    housing = _turned(machine, q, chain.tool) @ _housing(np.array(chain.tool_axis, dtype=float))
    found: Floats = np.swapaxes(part, 1, 2) @ housing
    return found


def _turned(machine: Machine, q: Floats, names: Sequence[str]) -> Floats:
    """(n, 3, 3) what the rotary joints of a chain turn, the one nearest the bed first."""
    turn = np.tile(np.eye(3), (len(q), 1, 1))
    for name in names:
        joint = machine.file.joints[name]
        if joint.kind != "rotary":
            continue
        u = np.array(joint.direction, dtype=float)
        u /= np.sqrt(u @ u)
        angle = q[:, machine.joints.index(name)]
        along = np.outer(u, u)
        beside = np.cross(u, np.eye(3)).T
        cosine, sine = np.cos(angle)[:, None, None], np.sin(angle)[:, None, None]
        turn = turn @ (along + cosine * (np.eye(3) - along) + sine * beside)
    return turn


def _columns(x: Sequence[float], z: Sequence[float]) -> Floats:
    """(3, 3) columns of a frame given by its x and z, made square."""
    k = np.array(z, dtype=float) / np.linalg.norm(z)
    j = np.cross(k, np.array(x, dtype=float))
    j /= np.linalg.norm(j)
    return np.column_stack([np.cross(j, k), j, k])


def _housing(axis: Floats) -> Floats:
    """(3, 3) columns of the frame of the spindle housing in the bed, at zero."""
    k = axis / np.linalg.norm(axis)
    j = np.cross(k, [1.0, 0.0, 0.0])
    j = j / np.linalg.norm(j) if np.linalg.norm(j) > 1e-6 else np.array([0.0, 1.0, 0.0])
    return np.column_stack([np.cross(j, k), j, k])
