"""Retracts along the tool, and turns about a point of the tool."""

from __future__ import annotations

import math

import numpy as np

from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.coordinates.placement import INSIDE

SAG = 0.45e-6
"""Most distance of the tip from the chords of a turn [m]; as of arcs."""
MOST_CHORDS = 10_000
STILL = 1e-9
"""Share of a way that is rounding."""


def retract(control: Control, distance: float | None, *, rapid: bool) -> None:
    """Move from the part along the tool axis, by a distance [m], or with None until a linear joint is at the end of
    its travel. Raises ProgramError where there is no such end."""
    poses, placement = control.poses, control.placement
    place = placement.place(control.words)
    if poses.machine is None:
        if distance is None:
            control.findings.assumed("without a machine, retracts to the end of travel are passed over")
            return
        way, axis = np.array([0.0, 0.0, 1.0]), np.array([0.0, 0.0, 1.0])
    else:
        control.need_linear_joints()
        _, columns, axis = poses.linear_map(place[3:])
        way = np.linalg.solve(columns, axis)
    if distance is None:
        joints = poses.to_joints(place, placement.tool_length) if placement.tip_mode else place
        distance = room(control, joints[:3], way)
    step = axis if placement.tip_mode else way
    moved = [*(np.array(place[:3]) + distance * step).tolist(), *place[3:]]
    named = sum(1 << k for k in range(3) if abs(way[k]) > STILL)
    control.straight(placement.words(moved), named, rapid=rapid)


def room(control: Control, joints: list[float], way: np.ndarray) -> float:
    """How far [m] linear joints (3,) can go along a way (3,) a metre before one is at the end of its travel.

    The end is INSIDE short of it, as for reference points: a smooth path swings about its points ("M140 MB MAX" stops
    before the limit switch by the machine parameter moveBack, TNC 640 "M140").
    """
    machine = control.poses.machine
    assert machine is not None
    travel = np.asarray(machine.travel)[list(control.poses.linear)]
    ends = [
        ((high - INSIDE if way[k] > 0.0 else low + INSIDE) - joints[k]) / way[k]
        for k, (low, high) in enumerate(travel)
        if abs(way[k]) > STILL
    ]
    nearest = min(ends, default=math.inf)
    if not math.isfinite(nearest):
        control.source.fail(
            f"a retract to the end of travel, and machine '{machine.name}' has none along its tool: "
            "write a length, or give the machine its travel",
            control.line,
        )
    return max(float(nearest), 0.0)


def turn_about(control: Control, wanted: list[float], distance: float, *, rapid: bool) -> None:
    """Turn the rotary joints to words (rotary) [rad] while the point of the tool that is `distance` [m] above its tip
    keeps its place on the part."""
    poses, placement = control.poses, control.placement
    if poses.machine is None or not distance:
        control.straight([*control.words[:3], *wanted], 0, rapid=rapid)
        return
    present = control.words[3:]
    shift = placement.shift or (0.0,) * len(wanted)
    place = placement.place(control.words)
    tip = place[:3] if placement.tip_mode else poses.to_tip(place, placement.tool_length)[:3]
    pivot = np.array(tip) + distance * np.array(poses.axis(place[3:]))
    turned = math.dist(wanted, present)
    chords = math.ceil(turned / math.sqrt(8.0 * SAG / (abs(distance) + SAG))) or 1
    if chords > MOST_CHORDS:
        control.source.fail(
            f"a turn about a point {distance * 1e3:g} mm above the tip: check the distance", control.line
        )
    for k in range(1, chords + 1):
        rotary = [a + (b - a) * k / chords for a, b in zip(present, wanted)]
        joints = [a + b for a, b in zip(rotary, shift)]
        at = [*(pivot - distance * np.array(poses.axis(joints))).tolist(), *joints]
        at = at if placement.tip_mode else poses.to_joints(at, placement.tool_length)
        control.straight(placement.words(at), 0, rapid=rapid)
