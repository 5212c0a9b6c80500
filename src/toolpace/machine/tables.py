"""Tables of a machine in millimetres and degrees: its joints, and poses to compare with the real machine."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.common.errors import printable
from toolpace.common.units import DEGREE, MILLIMETRE
from toolpace.machine import kinematics
from toolpace.machine.file import MachineFile
from toolpace.machine.geometry import Geometry

STEP = 0.1
"""How far a linear joint goes [m]."""
TURNS = (30 * DEGREE, 90 * DEGREE)
"""How far a rotary joint turns [rad]; the other way where travel does not reach."""
LESS = (1.0, 0.5, 0.2)
"""Of that step for each linear joint where all move: no two alike, so that none is taken for another."""


def rows(file: MachineFile, kind: str) -> list[dict[str, str]]:
    """One row a joint of a machine of some class: machine, class, joint, kind, carries, travel, limits."""
    table = []
    for name, joint in file.joints.items():
        unit, scale = ("deg", 180.0 / math.pi) if joint.kind == "rotary" else ("mm", 1e3)
        low, high = joint.travel or (-math.inf, math.inf)
        table.append(
            {
                "machine": file.name,
                "class": kind,
                "joint": name,
                "kind": joint.kind,
                "carries": "workpiece" if name in file.chain.workpiece else "tool",
                "travel": "endless" if joint.wrap else f"{low * scale:g} .. {high * scale:g} {unit}",
                "velocity": f"{joint.velocity * scale:g} {unit}/s",
                "acceleration": f"{joint.acceleration * scale:g} {unit}/s^2",
                "jerk": f"{joint.jerk * scale:g} {unit}/s^3",
            }
        )
    return table


def title(file: MachineFile, kind: str) -> str:
    """Name, class and the chain from the workpiece over the bed to the tool."""
    chain = file.chain
    inward = " < ".join(["workpiece", *reversed(chain.workpiece), "bed"])
    outward = " > ".join(["", *chain.tool, "tool"])
    tool = f"tool length {chain.tool_length * 1e3:g} mm"
    return f"{file.name}: {kind}, {inward}{outward}, {tool}"


def poses(geometry: Geometry) -> Floats:
    """(n, m) joint positions [m or rad], all within travel.

    Every joint at zero (or as near as its travel lets it), each linear joint alone by 100 mm, each rotary joint alone
    at 30 and 90 degrees, and with the linear joints moved aside; both rotary joints, and all joints together.
    """
    zero = np.clip(0.0, geometry.travel[:, 0], geometry.travel[:, 1])
    turns = {int(joint): _positions(geometry, int(joint), TURNS) for joint in sorted(geometry.rotary)}
    steps = {int(joint): _positions(geometry, int(joint), (STEP,)) for joint in sorted(geometry.linear)}
    aside = {joint: share * there[0] for share, (joint, there) in zip(LESS, steps.items())}
    moves: list[dict[int, float]] = [{}]
    moves += [{joint: position} for each in (steps, turns) for joint, there in each.items() for position in there]
    moves += [{joint: there[0]} | aside for joint, there in turns.items()]
    one, other = turns
    pairs = [(turns[one][0], turns[other][0]), (turns[one][-1], turns[other][0]), (turns[one][0], turns[other][-1])]
    moves += [{one: first, other: second} for first, second in pairs]
    moves.append(moves[-1] | aside)
    q = np.tile(zero, (len(moves), 1))
    for row, move in zip(q, moves):
        for joint, position in move.items():
            row[joint] = position
    inside = np.clip(q, geometry.travel[:, 0], geometry.travel[:, 1])
    return np.array(list(dict.fromkeys(map(tuple, inside.tolist()))))


def _positions(geometry: Geometry, joint: int, wanted: tuple[float, ...]) -> list[float]:
    """What a joint reaches of the positions, forwards or else backwards; else the farther end of its travel.

    They count from zero, or from the end of a travel that zero lies outside of.
    """
    low, high = (float(end) for end in geometry.travel[joint])
    start = min(max(0.0, low), high)
    for way in (1.0, -1.0):
        reached = [start + way * position for position in wanted if low <= start + way * position <= high]
        if reached:
            return reached
    return [low if start - low > high - start else high]


def pose_table(geometry: Geometry) -> str:
    """The poses with their tips and tool axes in the part's frame, in mm and deg, as aligned columns of text.

    Ahead of them stands where each rotary joint leans the tool axis.
    """
    q = poses(geometry)
    tip, axis = kinematics.forward(geometry, q)
    scale = np.where(geometry.is_rotary, DEGREE, MILLIMETRE)
    units = ["deg" if rotary else "mm" for rotary in geometry.is_rotary]
    columns = [[printable(name), unit] for name, unit in zip(geometry.joints, units)]
    columns += [[f"tip {name}", "mm"] for name in "xyz"] + [[f"axis {name}", ""] for name in "xyz"]
    for joints, point, direction in zip(q / scale, tip / MILLIMETRE, axis):
        cells = [*(_short(figure) for figure in joints), *(_fixed(figure, 3) for figure in point)]
        for column, cell in zip(columns, [*cells, *(_fixed(figure, 5) for figure in direction)]):
            column.append(cell)
    return "\n".join([*reversed(geometry.leanings), "", *_aligned(columns)]) + "\n"


def _short(figure: float) -> str:
    """Three decimals at most."""
    return f"{round(figure, 3) + 0.0:.3f}".rstrip("0").rstrip(".")


def _fixed(figure: float, decimals: int) -> str:
    """As many decimals in each row, and no minus before zero."""
    return f"{round(figure, decimals) + 0.0:.{decimals}f}"


def _aligned(columns: list[list[str]]) -> Iterator[str]:
    widths = [max(map(len, column)) for column in columns]
    for row in zip(*columns):
        yield "  ".join(cell.rjust(width) for cell, width in zip(row, widths)).rstrip()
