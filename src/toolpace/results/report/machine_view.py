"""The chain of a machine as a page draws and moves it: lengths in mm, angles in rad, directions in the bed frame."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from toolpace.machine.geometry import workpiece_orientation

if TYPE_CHECKING:
    from toolpace.machine.machine import Machine


def machine_view(machine: Machine) -> dict[str, Any]:
    """Joints from the bed to the workpiece and to the tool, where the workpiece is, and the nose of the spindle."""
    chain = machine.file.chain
    axis = np.asarray(chain.tool_axis) / np.linalg.norm(chain.tool_axis)
    return {
        "workpiece": [_joint(machine, name) for name in chain.workpiece],
        "tool_chain": [_joint(machine, name) for name in chain.tool],
        "origin": _mm(chain.workpiece_origin),
        # columns are the workpiece's x, y and z
        "orientation": workpiece_orientation(machine.file, machine.name).T.ravel().tolist(),
        "nose": _mm(chain.spindle_nose),
        "axis": axis.tolist(),
        "length": chain.tool_length * 1e3,
    }


def _joint(machine: Machine, name: str) -> dict[str, object]:
    joint = machine.file.joints[name]
    direction = np.asarray(joint.direction) / np.linalg.norm(joint.direction)
    return {
        "column": machine.joints.index(name),
        "rotary": joint.kind == "rotary",
        "direction": direction.tolist(),
        "point": _mm(joint.point),
    }


def _mm(vector: Sequence[float]) -> list[float]:
    return [1e3 * float(each) for each in vector]
