"""Choice between both solutions of the inverse kinematics: half circle of the second rotary joint.

Both solutions for a tool axis lie on either side of the plane of the first rotary axis u1 and the second u2, by the
sign of (R2 a0) . (u1 x u2), which is a sine of the second joint's position. So one of them alone is left where that
joint keeps to one half of its circle, above one of the sine's zeros or below it: a narrower travel, which a machine
file can say.
"""

from __future__ import annotations

import math
from dataclasses import replace

import msgspec
import numpy as np

from toolpace.common.errors import ReachError
from toolpace.kernels.kinematics.geometry import A0, U1, U2
from toolpace.machine.geometry import Geometry
from toolpace.machine.machine import Machine

ROOM = math.radians(1.0)
"""Beyond the half circle, so that a smooth path may swing through the pole [rad]."""
NARROWEST = math.radians(2.5)
"""Travel that is worth a side of its own [rad]: less holds but what both sides share."""


def with_side(machine: Machine, side: int) -> Machine:
    """The machine with the travel of its second rotary joint narrowed to one side, 1 or -1; 0: as it is.

    Raises ReachError where its travel has nothing of that side.
    """
    if side == 0:
        return machine
    name = machine.geometry.rotary_joints[1]
    joint = machine.file.joints[name]
    low, high = half_circle(machine.geometry, side)
    if joint.travel is not None:
        low, high = max(low, joint.travel[0]), min(high, joint.travel[1])
    if high - low < NARROWEST:
        raise ReachError(f"machine {machine.name}: joint {name} has no travel on side {side:+d}; take the other side")
    narrowed = msgspec.structs.replace(joint, travel=(low, high), wrap=False)
    joints = {**machine.file.joints, name: narrowed}
    return replace(machine, file=msgspec.structs.replace(machine.file, joints=joints))


def half_circle(geometry: Geometry, side: int) -> tuple[float, float]:
    """Positions [rad] of the second rotary joint above (1) or below (-1) the zero next to the middle of its travel."""
    frame = geometry.frame
    across = np.cross(frame[U1], frame[U2])
    # (R2 a0) . across = a cos + b sin
    a, b = float(frame[A0] @ across), float(np.cross(frame[U2], frame[A0]) @ across)
    zero = math.atan2(-a, b)
    low, high = geometry.travel[geometry.rotary[1]]
    middle = 0.5 * (low + high) if math.isfinite(low) and math.isfinite(high) else 0.0
    zero += math.pi * round((middle - zero) / math.pi)
    return (zero - ROOM, zero + math.pi + ROOM) if side > 0 else (zero - math.pi - ROOM, zero + ROOM)
