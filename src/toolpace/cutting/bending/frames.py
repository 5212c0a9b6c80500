"""The frames of cutting forces (feed, tool, workpiece) and the rotations between them.

workpiece: fixed to the part, as tips and tool axes are; a dynamometer under the part measures in it once it is turned
    with the part.
bed: fixed to the machine's bed; its x, y and z are those that the machine file is written in.
tool: fixed to the spindle housing, not to the spindle, so that it does not spin. z is the tool axis, from the tip to
    the spindle. With every rotary joint at zero x is the bed's x without its part along z; where that is nothing (a
    spindle along x), y is the bed's y. It turns with the rotary joints of the tool's chain. Compliance is in it.
"""

from __future__ import annotations

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.common.errors import UsageError, did_you_mean
from toolpace.machine.machine import Machine

FRAMES = ("workpiece", "bed", "tool")
ON_THE_TABLE = {"table-table": 2, "head-table": 1, "head-head": 0}
"""Rotary joints between the bed and the workpiece."""


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
