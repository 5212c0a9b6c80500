"""The rounding error of joint positions near a pole of the rotary joints."""

from __future__ import annotations

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.machine.machine import Machine

STEP = 1e-6
"""Angle by which a joint is turned to see what the tool axis and the tip do [rad]."""
UNITS = 1.0
"""Units in the last place of 1 by which a component of the tool axis may be off."""
LEAST = 1e-6
"""Least turn of the tool axis over that of the joint that counts: nearer to the pole the joint is free."""


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
