"""Chain diagnosis: why a chain is no five-axis machine, and the most likely mistake."""

from __future__ import annotations

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.common.errors import MachineError
from toolpace.machine.file import MachineFile
from toolpace.machine.text import listed
from toolpace.machine.tilt_direction import leaning

PARALLEL = 1e-6
"""Sine below which two directions count as parallel."""


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
