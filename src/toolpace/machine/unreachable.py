"""Error messages for tilts and positions that a machine cannot reach."""

from __future__ import annotations

import math

import numpy as np

from toolpace.common.arrays import Floats, Ints
from toolpace.common.errors import ReachError
from toolpace.machine.geometry import Geometry

SLACK = 1e-9
"""How far a position may pass the end of travel, rounding aside [m or rad]."""
UNLIKELY = 3.0
"""How many times its travel a joint must be asked for to make a slip of units more likely than a machine too small."""


def check_travel(geometry: Geometry, q: Floats, block: Ints, source: str = "") -> None:
    """Raise ReachError where joint positions (n, m) leave the travel, naming the worst joint and line."""
    if not np.isfinite(q).all():
        point = int(np.argmax(~np.isfinite(q).all(axis=1)))
        raise ReachError(f"{place(source, block[point])}joint positions are not finite")
    below = geometry.travel[:, 0] - SLACK - q
    above = q - geometry.travel[:, 1] - SLACK
    excess = np.maximum(below, above)
    if (excess <= 0.0).all():
        return
    out = excess > 0.0
    lines = np.unique(block[out.any(axis=1)])
    joint = int(np.argmax(np.max(excess / np.where(geometry.is_rotary, 1.0, 0.1), axis=0)))
    point = int(np.argmax(excess[:, joint]))
    high = bool(above[point, joint] > 0.0)
    limit = geometry.travel[joint, 1 if high else 0]
    unit, scale = _unit(geometry, joint)
    raise ReachError(
        f"{place(source, block[point])}joint {geometry.joints[joint]} would have to go to "
        f"{q[point, joint] * scale:.3f} {unit}, {'above' if high else 'below'} its limit of "
        f"{limit * scale:g} {unit}{_others(lines)}{_mirrored(geometry, joint, q[:, joint])}; "
        f"{_cure(geometry, joint, q[:, joint])}"
    )


def _mirrored(geometry: Geometry, joint: int, positions: Floats) -> str:
    """What to look at where a rotary joint would keep its travel at all positions (n,) if it turned the other way."""
    low, high = geometry.travel[joint]
    if not geometry.is_rotary[joint] or (positions < -high - SLACK).any() or (positions > -low + SLACK).any():
        return ""
    name = geometry.joints[joint]
    return (
        f"; is the sign of [joints.{name}] direction right? As it is "
        f"{geometry.leanings[geometry.rotary_joints.index(name)]}, and its travel is {math.degrees(low):g} .. "
        f"{math.degrees(high):g} deg"
    )


def unreachable_tilt(geometry: Geometry, axis: Floats, block: int, source: str = "") -> ReachError:
    """The error for a tool axis (3,) that no angles of the rotary joints give."""
    angle = math.degrees(math.acos(max(-1.0, min(1.0, float(_pole(geometry) @ axis)))))
    low, high = tilt_range(geometry)
    first = geometry.joints[geometry.rotary[0]]
    return ReachError(
        f"{place(source, block)}unreachable tilt: the tool axis ({axis[0]:.5f}, {axis[1]:.5f}, "
        f"{axis[2]:.5f}) stands at {angle:.3f} deg to the axis of joint {first}; {geometry.name} reaches "
        f"{low:.3f} to {high:.3f} deg; mount the part otherwise or take another machine"
    )


def tilt_range(geometry: Geometry) -> tuple[float, float]:
    """Least and most angle of the tool axis to the axis of the first rotary joint, by geometry [deg]."""
    frame = geometry.frame
    slant = math.acos(max(-1.0, min(1.0, float(_pole(geometry) @ frame[1]))))
    lean = math.acos(max(-1.0, min(1.0, float(frame[1] @ frame[2]))))
    most = slant + lean
    return math.degrees(abs(slant - lean)), math.degrees(most if most <= math.pi else 2.0 * math.pi - most)


def _pole(geometry: Geometry) -> Floats:
    """(3,) the axis of the first rotary joint, on the side where the tool is at joints zero."""
    frame = geometry.frame
    pole: Floats = frame[0] if frame[0] @ frame[2] >= 0.0 else -frame[0]
    return pole


def tilt_out_of_travel(geometry: Geometry, solutions: Floats, block: int, source: str = "") -> ReachError:
    """The error for a tool axis whose two rotary solutions (2, 2) both lie outside travel."""
    names = [geometry.joints[joint] for joint in geometry.rotary]
    bounds = geometry.travel[geometry.rotary]
    ways = []
    for angles in np.degrees(solutions):
        way = " ".join(f"{name} {angle:.3f}" for name, angle in zip(names, angles))
        if way not in ways:
            ways.append(way)
    travel = ", ".join(
        f"{name} {math.degrees(low):g} .. {math.degrees(high):g} deg"
        for name, (low, high) in zip(names, bounds)
        if math.isfinite(low)
    )
    return ReachError(
        f"{place(source, block)}the tool axis needs {' or '.join(ways)} deg, outside the travel of machine "
        f"{geometry.name} ({travel}){_turned_round(geometry, solutions)}; mount the part otherwise or take another "
        "machine"
    )


def _turned_round(geometry: Geometry, solutions: Floats) -> str:
    """What to look at where solutions (k, 2) would lie within travel if one rotary joint turned the other way round."""
    travel = geometry.travel[geometry.rotary]
    for joint in range(2):
        turned = np.where(np.arange(2) == joint, -solutions, solutions)
        # The lowest position at or above the lower end; an endless joint has every position.
        low = np.where(np.isfinite(travel[:, 0]), travel[:, 0], 0.0)
        lowest = low + np.mod(turned - low + SLACK, math.tau) - SLACK
        if (lowest <= travel[:, 1] + SLACK).all(axis=1).any():
            name = geometry.rotary_joints[joint]
            return (
                f"; is the sign of [joints.{name}] direction right? With the other one {name} would reach it; as it is "
                f"{geometry.leanings[joint]}"
            )
    return ""


def rotary_jump(
    geometry: Geometry, before: Floats, after: Floats, blocks: tuple[int, int], source: str = ""
) -> ReachError:
    """The error for rotary positions (2,) `before` and `after` that no motion within travel joins while cutting."""
    names = [geometry.joints[joint] for joint in geometry.rotary]
    travel = ", ".join(
        f"{name} {math.degrees(low):g} .. {math.degrees(high):g} deg"
        for name, (low, high) in zip(names, geometry.travel[geometry.rotary])
        if math.isfinite(low)
    )
    here, there = np.degrees(before), np.degrees(after)
    return ReachError(
        f"{place(source, blocks[1])}the rotary joints run out of travel ({travel}): between lines "
        f"{blocks[0]} and {blocks[1]} they would have to jump from "
        f"{names[0]} {here[0]:.3f} {names[1]} {here[1]:.3f} to {names[0]} {there[0]:.3f} {names[1]} "
        f"{there[1]:.3f} deg while cutting; split the program there with a retract (rapid), or give the "
        "joint more travel, or wrap = true"
    )


def singular_pose(geometry: Geometry, rotary: Floats) -> ReachError:
    """The error for rotary positions (2,) at which the linear joints act in one plane."""
    where = ", ".join(
        f"{geometry.joints[joint]} = {math.degrees(angle):.3f} deg" for joint, angle in zip(geometry.rotary, rotary)
    )
    return ReachError(
        f"machine {geometry.name}: at {where} the linear joints cannot move the tip in all directions; "
        "keep away from this tilt or limit the travel of the rotary joints"
    )


def place(source: str, block: int | np.int64) -> str:
    """Start of a message: file and line."""
    return f"{source}:{block}: " if source else f"line {block}: "


def _unit(geometry: Geometry, joint: int) -> tuple[str, float]:
    return ("deg", 180.0 / math.pi) if geometry.is_rotary[joint] else ("mm", 1e3)


def _others(lines: Ints) -> str:
    if len(lines) < 2:
        return ""
    shown = ", ".join(str(line) for line in lines[:3])
    return f" ({len(lines)} lines leave the travel: {shown}{', ...' if len(lines) > 3 else ''})"


def _cure(geometry: Geometry, joint: int, positions: Floats) -> str:
    """What to do about a joint that leaves its travel at some of its positions (n,)."""
    if geometry.is_rotary[joint]:
        return "mount the part otherwise, split the program there, or correct the travel in the machine file"
    used, there = float(np.ptp(positions)), float(np.ptp(geometry.travel[joint]))
    if used > there:
        units = (
            "see whether the program is in the unit that it says (inches, mm), or " if used > UNLIKELY * there else ""
        )
        return (
            f"the program uses {used * 1e3:.0f} mm of {geometry.joints[joint]}, which has {there * 1e3:g} mm; "
            f"{units}take a larger machine"
        )
    return "move the part (workpiece_origin), change the tool length, or correct the travel in the machine file"
