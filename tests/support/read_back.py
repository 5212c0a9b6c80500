"""A machine that was read from its control's files beside the one that was written to them."""

from __future__ import annotations

import math
from collections.abc import Collection

import numpy as np
import pytest

from toolpace.machine.machine import Machine

SAME = 1e-9
"""[m], and share of a limit."""
KINDS = ("velocity", "acceleration", "jerk")


def sense(machine: Machine, name: str) -> float:
    """Of a joint against the control's axis, which counts as if the tool moved."""
    joint = machine.file.joints[name]
    if joint.kind == "rotary":
        return 1.0
    side = -1.0 if name in machine.file.chain.workpiece else 1.0
    return side * math.copysign(1.0, joint.direction["XYZ".index(name)])


def assert_comes_back(
    read: Machine,
    machine: Machine,
    zero: np.ndarray | tuple[float, ...],
    senses: np.ndarray | float = 1.0,
    stand_ins: Collection[str] = (),
) -> None:
    """Limits, travel, kind, and tip and axis in 20 poses.

    zero: where the control's machine zero is in the machine's frame (3,) [m]; senses: of the machine's joints against
    the control's axes; stand_ins: limits that the files lack, as "jerk of X".
    """
    chain = machine.file.chain
    origin = np.array(chain.workpiece_origin) - zero
    back = read.mounted(origin=origin, x=chain.workpiece_x, z=chain.workpiece_z).with_tool(machine.tool_length)
    columns = [machine.joints.index(each) for each in back.joints]
    for kind in KINDS:
        kept = [k for k, joint in enumerate(back.joints) if f"{kind} of {joint}" not in stand_ins]
        expected = getattr(machine.limits, kind)[columns][kept]
        assert getattr(back.limits, kind)[kept] == pytest.approx(expected, rel=SAME)
    assert back.travel == pytest.approx(machine.travel[columns], rel=SAME, abs=SAME)
    assert back.wrap.tolist() == machine.wrap[columns].tolist()
    q = np.random.default_rng(11).uniform(-0.4, 0.4, (20, 5))
    tip, axis = machine.forward(q * senses)
    tip_back, axis_back = back.forward(q[:, columns])
    assert np.abs(tip_back - tip).max() < SAME and np.abs(axis_back - axis).max() < SAME
    assert back.kind == machine.kind
