"""The way back along the tool: by a length, or to the end of travel."""

from __future__ import annotations

import math

import numpy as np

from toolpace.reading.control.control import Control

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
        joints = poses.to_joints(place, placement.longer) if placement.tip_mode else place
        distance = room(control, joints[:3], way)
    step = axis if placement.tip_mode else way
    moved = [*(np.array(place[:3]) + distance * step).tolist(), *place[3:]]
    named = sum(1 << k for k in range(3) if abs(way[k]) > STILL)
    control.straight(placement.words(moved), named, rapid=rapid)


def room(control: Control, joints: list[float], way: np.ndarray) -> float:
    """How far [m] linear joints (3,) can go along a way (3,) a metre before one is at the end of its travel."""
    machine = control.poses.machine
    assert machine is not None
    travel = np.asarray(machine.travel)[list(control.poses.linear)]
    ends = [
        ((high if way[k] > 0.0 else low) - joints[k]) / way[k]
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
