"""The joints at which the tool was found, from where its tip was measured."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from toolpace.arrays import Floats
from toolpace.deflect.commanded import CommandedMotion, moment
from toolpace.errors import InfeasibleError, ReachError, UsageError
from toolpace.machine.machine import Machine
from toolpace.trajectory import Trajectory


def deflected_pose(
    trajectory: Trajectory,
    time: float,
    deflection: npt.ArrayLike,
    machine: Machine | None = None,
    *,
    axis: npt.ArrayLike | None = None,
) -> Floats:
    """(m,) joints at which the tip is at `deflection` (3,) [m] and the tool axis at `axis`, by default as commanded.

    Of both solutions the one nearest to the commanded joints is taken. Raises InfeasibleError where the pose is out
    of reach or travel.
    """
    machine = machine or trajectory.axis_path.machine
    index, local = moment(trajectory, time)
    q = CommandedMotion.of(trajectory, index).motion(np.array([local]))[0]
    point = np.asarray(deflection, dtype=float)
    size = len(trajectory.joints) if machine is None else 3
    if point.shape != (size,) or not np.isfinite(point).all():
        what = "joints" if machine is None else "coordinates of the tip in metres"
        raise UsageError(f"deflection: {deflection!r}; give {size} finite {what}")
    if machine is None:
        return point
    rotary = q[:, machine.rotary] if axis is None else rotary_near(machine, q[:, machine.rotary], axis, time)
    try:
        pose = machine.joints_at(point[None, :], rotary)
        machine.check_travel(pose, trajectory.axis_path.runs[index].block_at(np.zeros(1)))
    except ReachError as error:
        raise InfeasibleError(f"deflection at {time:.6g} s: the pose cannot be commanded: {error}") from None
    out: Floats = pose[0]
    return out


def rotary_near(machine: Machine, rotary: Floats, axis: npt.ArrayLike, time: float) -> Floats:
    """(1, 2) rotary joints that give the tool axis, nearest to those given (1, 2) [rad]."""
    direction = np.asarray(axis, dtype=float)
    length = float(np.linalg.norm(direction)) if direction.shape == (3,) else 0.0
    if not (np.isfinite(length) and length > 0.0):
        raise UsageError(f"deflection: tool axis {axis!r}; give three numbers, not all zero")
    jets = np.zeros((4, 1, 3))
    jets[0, 0] = direction / length
    found: Floats = machine.rotary_jets(jets, rotary)[0]
    if not np.isfinite(found).all():
        raise InfeasibleError(
            f"deflection at {time:.6g} s: no rotary angles of {machine.name} give the tool axis"
            f" ({', '.join(f'{x:.6g}' for x in jets[0, 0])})"
        )
    return found


def offset_in_words(offset: Floats, joints: tuple[str, ...], machine: Machine | None) -> str:
    """How far the joints are off, for messages."""
    if machine is None:
        return ", ".join(f"{joint} {value:.4g}" for joint, value in zip(joints, offset))
    return ", ".join(
        f"{joint} {np.degrees(value):.4g} deg" if rotary else f"{joint} {1e3 * value:.4g} mm"
        for joint, value, rotary in zip(joints, offset, machine.is_rotary)
    )
