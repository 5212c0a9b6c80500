"""Tilt direction of the tool axis as a rotary joint turns, which shows a wrong sign."""

from __future__ import annotations

import math

import numpy as np

from toolpace.common.arrays import Floats

SHOWN = math.radians(30.0)
"""The turn that is shown: small enough for most travels, large enough to be seen [rad]."""
STILL = 1e-6
"""How little the tool axis moves where it is said to stay."""


def turned(u: Floats, angle: float, v: Floats) -> Floats:
    """The vector v (3,) turned by an angle [rad] about the unit vector u (3,) (Rodrigues' formula)."""
    out: Floats = math.cos(angle) * v + math.sin(angle) * np.cross(u, v) + (1.0 - math.cos(angle)) * (u @ v) * u
    return out


def tool_axis(frame: Floats, first: float, second: float) -> Floats:
    """The tool axis (3,) in the workpiece frame at angles [rad] of both rotary joints; `frame` begins u1, u2, a0."""
    return turned(frame[0], first, turned(frame[1], second, frame[2]))


def leaning(names: tuple[str, str], frame: Floats, joint: int) -> str:
    """Where 30 degrees of rotary joint 0 or 1 take the tool axis, in words, seen from the workpiece.

    `names` are of both rotary joints, nearest the workpiece first; `frame` begins u1, u2, a0. A joint that turns about
    the tool axis shows what it does once the other one has tilted it.
    """
    turn, other = f"{names[joint]} +30 deg", names[1 - joint]
    after = tool_axis(frame, *(SHOWN * (k == joint) for k in range(2)))
    if np.linalg.norm(after - frame[2]) > STILL:
        return f"{turn} leans the tool axis to {shown(after)}"
    before, after = tool_axis(frame, SHOWN * joint, SHOWN * (1 - joint)), tool_axis(frame, SHOWN, SHOWN)
    if np.linalg.norm(after - before) > STILL:
        return f"{turn} turns the tool axis that {other} +30 leans to {shown(before)} on to {shown(after)}"
    return f"{turn} leaves the tool axis where it is"


def shown(vector: Floats) -> str:
    """A direction in three decimals at most."""
    return "(" + ", ".join(f"{figure:.3f}".rstrip("0").rstrip(".") for figure in np.round(vector, 3) + 0.0) + ")"
