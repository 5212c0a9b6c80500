"""Checks of travel, tool tip and tool axis, and the rounding of joints near a pole, from forward kinematics."""

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
STEP = 1e-6
"""Angle by which a joint is turned to see what the tool axis and the tip do [rad]."""
UNITS = 1.0
"""Units in the last place of 1 by which a component of the tool axis may be off."""
LEAST = 1e-6
"""Least turn of the tool axis over that of the joint that counts: nearer to the pole the joint is free."""


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


def pole_rounding(q: Floats, machine: Machine) -> Floats:
    """(n, m) how far positions (n, m) may be off [m or rad] because a pole is near, beyond their own rounding.

    A joint that turns the tool axis by a share s of its own turn is known from an axis of 1e-16 to 1e-16 / s only, and
    the linear joints follow it, as the tip stays where it is.
    """
    out = np.zeros_like(q)
    for j in machine.rotary:
        turn = STEP * (np.arange(q.shape[1]) == j)
        (tip0, axis0), (tip1, axis1) = machine.forward(q - turn), machine.forward(q + turn)
        share = np.linalg.norm(axis1 - axis0, axis=1) / (2.0 * STEP)
        lever = np.linalg.norm(tip1 - tip0, axis=1) / (2.0 * STEP)
        off = UNITS * np.finfo(float).eps * (1.0 / np.clip(share, LEAST, 1.0) - 1.0)
        out[:, j] += off
        out[:, machine.linear] += (lever * off)[:, None]
    return out
