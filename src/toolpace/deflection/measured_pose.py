"""The tip and the joints at a deflection, from what was measured: a position or a vector, and a tool axis.

Position and vector are both three numbers in metres, and either may be given for the other by mistake. So each has its
own name, and what is further from the motion than a deflection can be is refused.
"""

from __future__ import annotations

import warnings

import numpy as np
import numpy.typing as npt

from toolpace.common.arrays import Floats, number, numbers
from toolpace.common.errors import InfeasibleError, ReachError, UsageError
from toolpace.common.units import RADIANS, format_length, refuse_other_unit
from toolpace.deflection.motion_state import MotionState
from toolpace.machine.machine import Machine
from toolpace.motion.trajectory import Trajectory

SAME_AXIS = 1e-5
"""Angle between two tool axes up to which they are the same: below what is measured, above rounding [rad]."""
COARSEST_AXIS = 0.1
"""Most that counts as the same axis [rad]."""
UNIT = 1e-2
"""By how much the length of a unit vector may be off: what figures of three digits leave."""
MOST = 5e-3
"""Deflection beyond which a figure is taken for a mistake: fifty times what bends in a finishing cut, and far less than
a part's coordinates [m]."""
CURE = "tip= is the position in the workpiece's frame [m], deflection= the vector from the motion's tip to it [m]"


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


def found_tip(
    motion_state: MotionState,
    machine: Machine | None,
    time: float,
    tip: npt.ArrayLike | None,
    deflection: npt.ArrayLike | None,
    most: float,
) -> Floats:
    """(3,) position of the tip in the workpiece's frame [m]; without a machine (m,) joints [m or rad].

    tip: that position itself. deflection: the vector from where the motion has the tip to it. Exactly one of both.
    most: of the distance between them [m]; without a machine of each joint [m or rad].

    Raises UsageError for none or both, for what is no such array, and for what is further off than `most`.
    """
    if (tip is None) == (deflection is None):
        both = "neither tip nor deflection" if tip is None else "both tip and deflection"
        raise UsageError(f"replan: {both} given; give one: {CURE}")
    most = number(most, "replan: most", least=0.0, above=True, endless=True, unit="m")
    q = motion_state.state()[0]
    own = q if machine is None else machine.forward(q[None])[0][0]
    unit = "m or rad, of the joints" if machine is None else "m"
    if tip is not None:
        position = numbers(tip, "tip", (len(own),), unit=unit)
    else:
        position = own + numbers(deflection, "deflection", (len(own),), unit=unit)
        position = _as_it_was(position, own, most, machine)
    off = _size(position - own, machine)
    if off > most:
        raise UsageError(_too_far(position, own, off, most, time, tip is not None, machine))
    return position


def _as_it_was(position: Floats, own: Floats, most: float, machine: Machine | None) -> Floats:
    """The position, of a `deflection` that may be meant as it was until now: as the position itself."""
    difference = position - own
    before, now = _size(difference - own, machine), _size(difference, machine)
    if before > most:
        return position
    # both make sense only where the tip is near the origin; the name then decides
    taken = "the vector" if now <= most else "the position, as until now,"
    warnings.warn(
        f"replan: deflection= is the vector from the motion's tip; {taken} is taken; give tip= for the position",
        DeprecationWarning,
        stacklevel=4,
    )
    return position if now <= most else difference


def _too_far(
    position: Floats, own: Floats, off: float, most: float, time: float, is_tip: bool, machine: Machine | None
) -> str:
    """One line that names what was probably meant."""
    value = position if is_tip else position - own
    name, other = ("tip", "deflection") if is_tip else ("deflection", "tip")
    as_other = _size(value if is_tip else value - own, machine)
    in_metres = position * 1e-3 - own if is_tip else value * 1e-3
    if as_other <= most:
        meant = f"that is {'a vector' if is_tip else 'a position'}: give it as {other}="
    elif _size(in_metres, machine) <= most:
        meant = "that is in mm: give metres"
    else:
        meant = CURE
    if machine is None:
        far, bound = f"{off:.4g} (m or rad) in one joint", f"{most:g}"
    else:
        far, bound = format_length(off), format_length(most)
    return (
        f"replan: {name} is {far} from the motion at {time:.6g} s, more than the {bound} of most: {meant};"
        " of a deflection that is so large raise most="
    )


def _size(offset: Floats, machine: Machine | None) -> float:
    """Of an offset of the tip [m], or the largest of the joints."""
    return float(np.abs(offset).max() if machine is None else np.linalg.norm(offset))
