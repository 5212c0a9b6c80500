"""A check of tool tip, tool axis and travel by forward kinematics."""

from __future__ import annotations

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.judge.verification import Check
from toolpace.machine.machine import Machine
from toolpace.motion.setpoints import SetPoints

TIP_AGREEMENT = 1e-8
"""How far the tip column may be from forward kinematics [m]."""
AXIS_AGREEMENT = 1e-8
"""How far the axis column may be from forward kinematics [rad]."""
TRAVEL_ROUNDING = 1e-9
"""How far out of travel a joint may be by rounding [m or rad]."""


def tool_checks(points: SetPoints, machine: Machine, tip: Floats, axis: Floats) -> list[Check]:
    """Travel of each joint; the tip and axis columns against `tip` and `axis`, the forward kinematics of
    `q`."""
    checks = []
    for j, joint in enumerate(points.joints):
        low, high = float(machine.travel[j, 0]), float(machine.travel[j, 1])
        unit = "rad" if machine.is_rotary[j] else "m"
        q = points.q[:, j]
        for bound, worst, at_least in ((high, int(np.argmax(q)), False), (low, int(np.argmin(q)), True)):
            if np.isfinite(bound):
                value = float(q[worst])
                over = bound - value if at_least else value - bound
                time, block = float(points.t[worst]), int(points.block[worst])
                ok = over <= TRAVEL_ROUNDING
                name = "lowest position" if at_least else "highest position"
                checks.append(Check(name, value, bound, unit, ok, time, block, joint, at_least=at_least))
    if points.has_tool:
        for name, told, true, limit, unit in (
            ("tip column", points.tip, tip, TIP_AGREEMENT, "m"),
            ("axis column", points.axis, axis, AXIS_AGREEMENT, "rad"),
        ):
            off = np.sqrt(((told - true) ** 2).sum(axis=1))
            worst = int(np.argmax(off))
            time, block = float(points.t[worst]), int(points.block[worst])
            ok = bool(off[worst] <= limit)
            note = "against forward kinematics"
            checks.append(Check(name, float(off[worst]), limit, unit, ok, time, block, note=note))
    return checks
