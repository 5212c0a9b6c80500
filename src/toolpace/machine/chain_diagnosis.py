"""Errors in the rotary joints of a chain, with the most likely cause, and the tilt of the tool that shows them."""

from __future__ import annotations

import math

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.common.errors import MachineError
from toolpace.machine.file import MachineFile
from toolpace.machine.text import listed

PARALLEL = 1e-6
"""Sine below which two directions count as parallel."""
SHOWN = math.radians(30.0)
"""The turn that is shown: small enough for most travels, large enough to be seen [rad]."""
STILL = 1e-6
"""How little the tool axis moves where it is said to stay."""


def parallel(u: Floats, v: Floats) -> bool:
    """Whether two unit vectors (3,) lie along one line."""
    return bool(np.linalg.norm(np.cross(u, v)) < PARALLEL)


def check_rotary(file: MachineFile, rotary: tuple[str, str], frame: Floats, source: str) -> None:
    """Refuse rotary joints that cannot tilt the tool in all directions.

    `rotary` are the names of both, nearest the workpiece first; `frame` (3, 3) is u1, u2, a0 in the workpiece frame.
    """
    first, second = rotary
    if parallel(frame[0], frame[1]):
        raise MachineError(
            f"{source}: rotary joints {first} and {second} are parallel; the tool could tilt one way only; correct one "
            f"of their directions {_directions(file, rotary)}"
        )
    if parallel(frame[1], frame[2]):
        raise MachineError(
            f"{source}: rotary joint {second} turns about the tool axis and cannot tilt it: {_order(file, rotary)} "
            f"As it stands {leaning(rotary, frame, 0)}, and {leaning(rotary, frame, 1)}"
        )


def _order(file: MachineFile, rotary: tuple[str, str]) -> str:
    """The order that was most likely meant: what turns about the tool axis comes before what tilts it."""
    first, second = rotary
    for side, order in (("workpiece", file.chain.workpiece), ("tool", file.chain.tool)):
        if first in order and second in order:
            # Linear joints that come last tell of a list that begins at its other end.
            other = {first: second, second: first}
            backwards = file.joints[order[0]].kind == "rotary" and file.joints[order[-1]].kind == "linear"
            meant = order[::-1] if backwards else tuple(other.get(name, name) for name in order)
            return (
                f"[chain] {side} goes from the bed to the {side}, and is {listed(order)}; should it be {listed(meant)}?"
            )
    return f"should {second} be in [chain] workpiece, and {first} in tool?"


def _directions(file: MachineFile, names: tuple[str, str]) -> str:
    given = ([f"{figure:g}" for figure in file.joints[name].direction] for name in names)
    return " and ".join(f"[{', '.join(figures)}]" for figures in given)


def lie_in_a_plane(file: MachineFile, names: list[str], directions: dict[str, Floats], source: str) -> MachineError:
    """The error for linear joints that do not span space; those that move along one line are named."""
    pairs = ((one, other) for k, one in enumerate(names) for other in names[k + 1 :])
    alike = next((pair for pair in pairs if parallel(directions[pair[0]], directions[pair[1]])), None)
    why = ""
    if alike is not None:
        given = _directions(file, alike)
        why = f"; {alike[0]} and {alike[1]} move along one line, directions {given}: correct one of them"
    return MachineError(
        f"{source}: the directions of the linear joints {', '.join(names)} lie in one plane; they must span space{why}"
    )


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
