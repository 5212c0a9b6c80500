"""The joint positions of a measured tool tip."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from toolpace.common.arrays import Floats, number, numbers
from toolpace.common.errors import InfeasibleError, ReachError, UsageError
from toolpace.common.units import RADIANS, refuse_other_unit
from toolpace.deflection.replanning.found_tip import MOST, found_tip
from toolpace.deflection.replanning.motion_state import MotionState
from toolpace.machine.machine import Machine
from toolpace.motion.trajectory import Trajectory

SAME_AXIS = 1e-5
"""Angle between two tool axes up to which they are the same: below what is measured, above rounding [rad]."""
COARSEST_AXIS = 0.1
"""Most that counts as the same axis [rad]."""
UNIT = 1e-2
"""By how much the length of a unit vector may be off: what figures of three digits leave."""


def deflected_pose(
    trajectory: Trajectory,
    time: float,
    tip: npt.ArrayLike | None = None,
    machine: Machine | None = None,
    *,
    deflection: npt.ArrayLike | None = None,
    most: float = MOST,
    axis: npt.ArrayLike | None = None,
    axis_tolerance: float = SAME_AXIS,
) -> Floats:
    """(m,) joints at which the tip is at the position `tip` (3,) [m] and the tool axis at `axis`, if given.

    In place of `tip`, `deflection` is the vector from the commanded tip to it; neither may be further off than `most`
    [m], see `replan`. Of both solutions the one nearest to the commanded joints is taken. Up to `axis_tolerance` [rad]
    the unit vector `axis` may be missed: where the rotary joints as commanded come so near, they stay, and beside the
    pole, where next to no change of the axis turns the first of them far, that one stays. Raises UsageError, and
    InfeasibleError where the pose is out of reach or travel.
    """
    motion_state = MotionState.of(trajectory, time)
    machine = motion_state.machine_with_tool(machine or trajectory.axis_path.machine)
    point = found_tip(motion_state, machine, time, tip, deflection, most)
    return pose_at(motion_state, machine, time, point, axis, axis_tolerance)


def pose_at(
    motion_state: MotionState,
    machine: Machine | None,
    time: float,
    tip: Floats,
    axis: npt.ArrayLike | None,
    axis_tolerance: float,
) -> Floats:
    """The pose of `deflected_pose`, of a tip (3,) that was checked; without a machine that of the joints (m,)."""
    if machine is None:
        return tip
    q = motion_state.state()[:1]
    axis_tolerance = number(axis_tolerance, "deflection: axis_tolerance", least=0.0, unit="rad")
    refuse_other_unit(axis_tolerance, COARSEST_AXIS, "deflection: axis_tolerance", RADIANS)
    rotary = (
        q[:, machine.rotary] if axis is None else rotary_near(machine, q[:, machine.rotary], axis, time, axis_tolerance)
    )
    try:
        pose = machine.joints_at(tip[None, :], rotary)
        machine.check_travel(pose, motion_state.original.run.block_at(np.array([motion_state.original.run.s0])))
    except ReachError as error:
        raise InfeasibleError(f"deflection at {time:.6g} s: the pose cannot be commanded: {error}") from None
    out: Floats = pose[0]
    return out


def rotary_near(machine: Machine, rotary: Floats, axis: npt.ArrayLike, time: float, tolerance: float) -> Floats:
    """(1, 2) rotary joints that give the tool axis to a tolerance, nearest to those given (1, 2) [rad]."""
    direction = numbers(axis, "deflection: tool axis", (3,))
    length = float(np.linalg.norm(direction))
    if abs(length - 1.0) > UNIT:
        raise UsageError(
            f"deflection: tool axis has the length {length:.4g}; give the unit vector from tip to spindle, not a change"
            " of it, nor angles"
        )
    jets = np.zeros((4, 1, 3))
    jets[0, 0] = direction / length
    if angle_to(machine, rotary, jets[0]) <= tolerance:
        return rotary
    found: Floats = machine.rotary_jets(jets, rotary)[0]
    if not np.isfinite(found).all():
        raise InfeasibleError(
            f"deflection at {time:.6g} s: no rotary angles of {machine.name} give the tool axis"
            f" ({', '.join(f'{x:.6g}' for x in jets[0, 0])})"
        )
    tilts = [found[0, 1], *machine.rotary_solutions(jets[0])[0][0, :, 1]]
    for tilt in sorted(tilts, key=lambda tilt: abs(tilt - rotary[0, 1])):
        kept = np.array([[rotary[0, 0], tilt]])
        if angle_to(machine, kept, jets[0]) <= tolerance:
            return kept
    return found


def angle_to(machine: Machine, rotary: Floats, axis: Floats) -> float:
    """Angle between the tool axis at rotary joints (1, 2) and another (1, 3) [rad]."""
    here = machine.axis_at(rotary)[0]
    return float(np.arctan2(np.linalg.norm(np.cross(here, axis[0])), here @ axis[0]))


def offset_in_words(offset: Floats, joints: tuple[str, ...], machine: Machine | None) -> str:
    """How far the joints are off, for messages."""
    if machine is None:
        return ", ".join(f"{joint} {value:.4g}" for joint, value in zip(joints, offset))
    return ", ".join(
        f"{joint} {np.degrees(value):.4g} deg" if rotary else f"{joint} {1e3 * value:.4g} mm"
        for joint, value, rotary in zip(joints, offset, machine.is_rotary)
    )
