"""Forward and closed-form inverse kinematics of a machine, with derivatives, point by point.

Arrays are in SI units; tips and tool axes are in the workpiece frame. Joint arrays (n, m) have one column a joint, in
the order of `Geometry.joints`; rotary arrays (n, 2) have one a rotary joint, nearest the workpiece first. Derivatives
0 to 3 along a path parameter stand in front, (4, n, ...). The formulas: docs/design/kinematics.md.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from toolpace.common.arrays import Bools, Floats, frozen, numbers
from toolpace.common.errors import UsageError
from toolpace.kernels.kinematics.geometry import Chain
from toolpace.machine.geometry import Geometry
from toolpace.machine.unreachable import singular_pose

POLE = 1e-9
"""Sine of the angle between tool axis and pole below which the first rotary joint counts as free."""


UNIT = 1e-6
"""By how much the length of a tool axis that a caller gives may differ from 1."""


def chain_of(geometry: Geometry) -> Chain:
    """The chain as the compiled functions take it."""
    return Chain(geometry.frame, geometry.group, geometry.place)


def _writable(values: Floats) -> Floats:
    """The values in C order as they may be written to: the kind that the kernels of jets are compiled for."""
    return np.require(values, np.float64, ["C", "W"])


def forward(geometry: Geometry, q: Floats) -> tuple[Floats, Floats]:
    """Joint positions (n, m) to tips (n, 3) [m] and unit tool axes (n, 3)."""
    from toolpace.kernels.kinematics import chain

    q = frozen(q)
    tip, axis = np.empty((len(q), 3)), np.empty((len(q), 3))
    chain.forward(chain_of(geometry), q, tip, axis)
    return tip, axis


def axis_at(geometry: Geometry, rotary: Floats) -> Floats:
    """Rotary positions (n, 2) [rad] to unit tool axes (n, 3)."""
    from toolpace.kernels.kinematics import chain

    rotary = frozen(rotary)
    axis = np.empty((len(rotary), 3))
    chain.axes(geometry.frame, rotary, axis)
    return axis


def rotary_solutions(geometry: Geometry, axis: Floats, pole_tolerance: float = POLE) -> tuple[Floats, Bools]:
    """Tool axes (n, 3) to both rotary solutions (n, 2, 2) [point, solution, joint] and pole (n,).

    Angles lie in [-pi, pi]; nan where no angles, whatever the travel, give the axis. At the pole the first rotary
    joint is free; it is returned as zero there.
    """
    from toolpace.kernels.kinematics import chain

    axis = frozen(axis)
    solutions, pole = np.empty((len(axis), 2, 2)), np.empty(len(axis), dtype=np.bool_)
    chain.rotary_solutions(geometry.frame, pole_tolerance, axis, solutions, pole)
    return solutions, pole


def joints_at(geometry: Geometry, tip: Floats, rotary: Floats) -> Floats:
    """Tips (n, 3) and rotary positions (n, 2) to joint positions (n, m), whatever their travel. Raises ReachError."""
    from toolpace.kernels.kinematics import chain

    tip, rotary = frozen(tip), frozen(rotary)
    q = np.empty((len(tip), len(geometry.joints)))
    singular = chain.joints_at(chain_of(geometry), tip, rotary, q)
    if singular >= 0:
        raise singular_pose(geometry, rotary[singular])
    return q


def linear_jets(geometry: Geometry, tip: Floats, rotary: Floats) -> Floats:
    """Derivatives of tip (4, n, 3) and rotary joints (4, n, 2) to those of all joints (4, n, m). Raises ReachError."""
    from toolpace.kernels.kinematics import jets

    tip, rotary = _writable(tip), _writable(rotary)
    q = np.empty((4, tip.shape[1], len(geometry.joints)))
    singular = jets.linear_jets(chain_of(geometry), tip, rotary, q)
    if singular >= 0:
        raise singular_pose(geometry, rotary[0, singular])
    return q


def rotary_jets(geometry: Geometry, axis: Floats, rotary: Floats) -> Floats:
    """Derivatives of the tool axis (4, n, 3) to those of the rotary joints (4, n, 2) near `rotary` (n, 2).

    At the pole the first rotary joint keeps its given position and rests. nan where the axis cannot be reached, and
    in the derivatives where it lies on the edge of reach.
    """
    from toolpace.kernels.kinematics import jets as near

    axis, rotary = _writable(axis), _writable(rotary)
    out = np.empty((4, axis.shape[1], 2))
    near.rotary_jets(geometry.frame, POLE, axis, rotary, out)
    return out


def axis_jets(geometry: Geometry, rotary: Floats) -> Floats:
    """Derivatives of the rotary joints (4, n, 2) to those of the tool axis (4, n, 3)."""
    from toolpace.kernels.kinematics import jets

    rotary = _writable(rotary)
    out = np.empty((4, rotary.shape[1], 3))
    jets.axis_jets(geometry.frame, rotary, out)
    return out


def tip_lever(geometry: Geometry, tip: Floats, rotary: Floats) -> Floats:
    """(n, 2) most motion of a linear joint per unit of each rotary joint while the tip stands [m/rad]."""
    still, turning = np.zeros((4, len(tip), 3)), np.zeros((4, len(tip), 2))
    still[0], turning[0] = tip, rotary
    lever = np.empty((len(tip), 2))
    for joint in range(2):
        turning[1] = 0.0
        turning[1, :, joint] = 1.0
        lever[:, joint] = np.abs(linear_jets(geometry, still, turning)[1][:, geometry.linear]).max(axis=1)
    return lever


class Posed:
    """What a machine tells of poses: the functions above, behind the gate for the arrays of callers."""

    name: str
    joints: tuple[str, ...]
    tool_length: float
    geometry: Geometry

    def forward(self, q: npt.ArrayLike, tool_length: npt.ArrayLike | None = None) -> tuple[Floats, Floats]:
        """Joint positions (n, m) to tips (n, 3) [m] and unit tool axes (n, 3); of one pose (m,) both are (3,).

        `tool_length` (n,) or one for all [m]: of the tool in the spindle at each; the machine's own where it is nan,
        and where none is given. This and all other methods that take arrays raise UsageError for arrays of other
        shapes, for what are no real numbers, and for nan and infinity.
        """
        poses = self._poses(q, "q", len(self.joints), "m, rad")
        tip, axis = forward(self.geometry, poses)
        longer = self._longer(tool_length, len(poses))
        tip = tip if longer is None else tip - longer * axis
        return (tip, axis) if np.ndim(q) == 2 else (tip[0], axis[0])

    def axis_at(self, rotary: npt.ArrayLike) -> Floats:
        """Rotary positions (n, 2) [rad] to unit tool axes (n, 3); of one pose (2,) it is (3,)."""
        axis = axis_at(self.geometry, self._poses(rotary, "rotary", 2, "rad"))
        return axis if np.ndim(rotary) == 2 else axis[0]

    def rotary_solutions(self, axis: npt.ArrayLike, pole_tolerance: float = POLE) -> tuple[Floats, Bools]:
        """Tool axes (n, 3) to both rotary solutions (n, 2, 2) [point, solution, joint] and pole (n,).

        Of one axis (3,) they are (2, 2) and (). Angles lie in [-pi, pi]; nan where no angles, whatever the travel, give
        the axis. At the pole the first rotary joint is free; it is returned as zero there.
        """
        solutions, pole = rotary_solutions(self.geometry, self._axes(axis), pole_tolerance)
        return (solutions, pole) if np.ndim(axis) == 2 else (solutions[0], pole[0])

    def joints_at(self, tip: npt.ArrayLike, rotary: npt.ArrayLike, tool_length: npt.ArrayLike | None = None) -> Floats:
        """Tips (n, 3) and rotary positions (n, 2) to joint positions (n, m), whatever their travel.

        Of one tip (3,) and one pair of positions (2,) they are (m,). `tool_length` as in `forward`.
        """
        tips, turned = self._poses(tip, "tip", 3, "m"), self._poses(rotary, "rotary", 2, "rad")
        self._pair(tip, tips, rotary, turned)
        longer = self._longer(tool_length, len(tips))
        if longer is not None:
            tips = tips + longer * axis_at(self.geometry, turned)
        q = joints_at(self.geometry, tips, turned)
        return q if np.ndim(tip) == 2 else q[0]

    def _poses(self, value: npt.ArrayLike, name: str, width: int, unit: str) -> Floats:
        """Poses (n, width) of what was given, many of them or one (width,)."""
        poses = numbers(value, f"machine {self.name}: {name}", ("n", width), (width,), unit=unit)
        return poses if poses.ndim == 2 else poses[None]

    def _jets(self, value: npt.ArrayLike, name: str, width: int) -> Floats:
        return numbers(value, f"machine {self.name}: {name}", (4, "n", width))

    def _axes(self, axis: npt.ArrayLike) -> Floats:
        """Tool axes (n, 3), each of unit length."""
        axes = self._poses(axis, "axis", 3, "")
        length = np.linalg.norm(axes, axis=1)
        if (np.abs(length - 1.0) > UNIT).any():
            at = int(np.argmax(np.abs(length - 1.0)))
            raise UsageError(
                f"machine {self.name}: axis {at} has the length {length[at]:.9g}; divide it by its length: "
                "it is the unit vector from the tip to the spindle"
            )
        return axes

    def _pair(self, tip: npt.ArrayLike, tips: Floats, rotary: npt.ArrayLike, turned: Floats) -> None:
        """Raise UsageError where tips and rotary positions are not as many of each."""
        if np.ndim(tip) != np.ndim(rotary) or tips.shape[-2] != turned.shape[-2]:
            raise UsageError(
                f"machine {self.name}: tip has shape {np.shape(tip)} and rotary {np.shape(rotary)}; give as many rows "
                "of both"
            )

    def _longer(self, tool_length: npt.ArrayLike | None, count: int) -> Floats | None:
        """(n, 1) by how much tools are longer than the machine's own [m]; None where none is."""
        if tool_length is None:
            return None
        name = f"machine {self.name}: tool_length"
        lengths = numbers(tool_length, name, (count,), (), (0,), finite=False, unit="m")
        if not lengths.size:
            return None
        if np.isinf(lengths).any():
            raise UsageError(f"{name} is infinite; give lengths in metres, nan for its own")
        longer = np.where(np.isnan(lengths), 0.0, lengths - self.tool_length)
        return longer.reshape(-1, 1) if longer.any() else None

    def linear_jets(self, tip: npt.ArrayLike, rotary: npt.ArrayLike) -> Floats:
        """Derivatives 0..3 of tip (4, n, 3) and rotary joints (4, n, 2) to those of all joints (4, n, m)."""
        tips, turned = self._jets(tip, "tip", 3), self._jets(rotary, "rotary", 2)
        self._pair(tip, tips, rotary, turned)
        return linear_jets(self.geometry, tips, turned)

    def rotary_jets(self, axis: npt.ArrayLike, rotary: npt.ArrayLike) -> Floats:
        """Derivatives 0..3 of the tool axis (4, n, 3) to those of the rotary joints (4, n, 2) near `rotary` (n, 2).

        At the pole the first rotary joint keeps its given position and rests. nan where the axis cannot be
        reached, and in the derivatives where it lies on the edge of reach.
        """
        axes = self._jets(axis, "axis", 3)
        self._axes(axes[0])
        near = numbers(rotary, f"machine {self.name}: rotary", (axes.shape[1], 2), unit="rad")
        return rotary_jets(self.geometry, axes, near)

    def axis_jets(self, rotary: npt.ArrayLike) -> Floats:
        """Derivatives 0..3 of the rotary joints (4, n, 2) to those of the tool axis (4, n, 3)."""
        return axis_jets(self.geometry, self._jets(rotary, "rotary", 2))

    def tip_lever(self, tip: npt.ArrayLike, rotary: npt.ArrayLike) -> Floats:
        """(n, 2) most motion of a linear joint per unit of each rotary joint while the tip stands [m/rad].

        Tips are (n, 3), rotary positions (n, 2); of one tip (3,) and one pair (2,) it is (2,).
        """
        tips, turned = self._poses(tip, "tip", 3, "m"), self._poses(rotary, "rotary", 2, "rad")
        self._pair(tip, tips, rotary, turned)
        lever = tip_lever(self.geometry, tips, turned)
        return lever if np.ndim(tip) == 2 else lever[0]
