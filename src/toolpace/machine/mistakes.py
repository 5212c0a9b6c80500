"""Chains that cannot be a five-axis machine, and the slip that most likely made them so."""

from __future__ import annotations

import numpy as np

from toolpace.arrays import Floats
from toolpace.errors import MachineError
from toolpace.machine.file import ChainFile, MachineFile
from toolpace.machine.leaning import leaning

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
        given = " and ".join(str(list(file.joints[name].direction)) for name in rotary)
        raise MachineError(
            f"{source}: rotary joints {first} and {second} are parallel; the tool could tilt one way only; correct one "
            f"of their directions {given}"
        )
    if parallel(frame[1], frame[2]):
        raise MachineError(
            f"{source}: rotary joint {second} turns about the tool axis and cannot tilt it: {_order(file, rotary)}; "
            f"as it stands {leaning(rotary, frame, 0)}, and {leaning(rotary, frame, 1)}"
        )


def _order(file: MachineFile, rotary: tuple[str, str]) -> str:
    """Where the joint that turns about the tool axis comes last, since the other one lies nearer to the workpiece."""
    first, second = rotary
    chain = file.chain
    for side, end in (("workpiece", "workpiece"), ("tool", "spindle")):
        order = _side(chain, side)
        if first in order and second in order:
            given, meant = (str(list(names)).replace("'", '"') for names in (order, order[::-1]))
            return f"[chain] {side} = {given} is the wrong way round? It goes from the bed to the {end}: {meant}"
    return f"[chain] has {first} and {second} on the wrong sides? {second} would carry the workpiece, {first} the tool"


def _side(chain: ChainFile, side: str) -> tuple[str, ...]:
    return chain.workpiece if side == "workpiece" else chain.tool


def lie_in_a_plane(file: MachineFile, names: list[str], directions: dict[str, Floats], source: str) -> MachineError:
    """The error for linear joints that do not span space."""
    why = ""
    for k, name in enumerate(names):
        for other in names[k + 1 :]:
            if parallel(directions[name], directions[other]):
                given = " and ".join(str(list(file.joints[each].direction)) for each in (name, other))
                why = f"; {name} and {other} have one line of motion, directions {given}: correct one"
    return MachineError(
        f"{source}: the directions of the linear joints {', '.join(names)} lie in one plane; they must span space{why}"
    )
