"""Limits on the torques and forces of joints as rows along a path: from masses, or a function of one's own."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from toolpace.common.arrays import Floats, numbers
from toolpace.common.errors import MachineError, UsageError
from toolpace.machine.dynamics import Dynamics, TorqueTerms
from toolpace.machine.file import MachineFile
from toolpace.machine.limits import MOTORS
from toolpace.machine.rows import Rows

ROUNDING = 1e-6
"""Share of the largest torque by which a function may miss what its others tell."""
Torque = Callable[[Floats, Floats, Floats], npt.ArrayLike]
"""Torques (n, joints) at positions, velocities and accelerations (n, joints) of the joints."""


def torque_rows(
    dynamics: Dynamics | Torque, most: npt.ArrayLike, velocity: npt.ArrayLike, joints: Sequence[str],
    linear: Sequence[bool] | None = None,
) -> tuple[Rows, ...]:  # fmt: skip
    """Limits on the torques of joints, as `plan(..., rows=...)` takes them, by the names "torque A" and "force X".

    `dynamics` is a `Dynamics`, or a function of one's own: torques (n, m) [N m, N] at positions, velocities and
    accelerations (n, m) of the joints, quadratic in the velocities but for friction. `most` (m,) is the largest torque
    of each, without sign, inf where none is held; `velocity` (m,) the largest velocity, for viscous friction; `linear`
    (m,) says which joints have a force (default: as the links of `dynamics` are). Raises UsageError.
    """
    limit = np.broadcast_to(numbers(most, "torques: most", ("m",), (), finite=False), len(joints))
    fastest = np.broadcast_to(numbers(velocity, "torques: velocity", ("m",), (), finite=False), len(joints))
    if linear is None:
        linear = [each.kind == "linear" for each in getattr(dynamics, "links", ())] or [False] * len(joints)
    if len(linear) != len(joints):
        raise UsageError(f"torques: dynamics of {len(linear)} joints for {len(joints)} ({', '.join(joints)})")
    for name, figure in zip(joints, limit):
        if not figure > 0.0:
            raise UsageError(f"torques: that of joint {name} is {figure:g}; give a positive number (or inf)")
    shared = _Shared(dynamics if isinstance(dynamics, Dynamics) else _Fitted(dynamics))
    rows = []
    for k in np.flatnonzero(np.isfinite(limit)).tolist():
        name, unit = (MOTORS[0], "N") if linear[k] else (MOTORS[1], "N m")
        function = _JointTorque(shared, k, joints[k], float(limit[k]), float(fastest[k]))
        rows.append(Rows(f"{name} {joints[k]}", unit, float(limit[k]), function))
    return tuple(rows)


def machine_torques(file: MachineFile, source: str) -> tuple[Rows, ...]:
    """The limits on torques and forces that a machine file names; none where it names none. Raises MachineError."""
    joints = file.joints
    limited = {name for name, joint in joints.items() if math.isfinite(joint.most_torque)}
    if not limited:
        return ()
    dynamics = Dynamics.of_machine(file)
    for k, (name, link) in enumerate(zip(joints, dynamics.links)):
        carried = [dynamics.links[chain[-1]] for chain in dynamics.chains if k in chain]
        moves = link.rotor_inertia or any(each.mass or any(each.inertia) for each in carried)
        if name in limited and not moves:
            raise MachineError(f"{source}: joint {name} has a limit of torque or force, and moves no mass; give mass")
    return torque_rows(
        dynamics, [joint.most_torque for joint in joints.values()], [joint.velocity for joint in joints.values()],
        list(joints),
    )  # fmt: skip


@dataclass(frozen=True)
class _JointTorque:
    """The torque of one joint as a row."""

    shared: _Shared
    joint: int
    name: str
    limit: float
    velocity: float

    def __call__(self, q: Floats) -> Floats:
        """The coefficients (n, 2) of z' and z, as shares of what weight and friction leave of the limit."""
        slope, square, viscous, constant = (part[:, self.joint] for part in self.shared.along(q))
        with np.errstate(invalid="ignore"):
            friction = np.nan_to_num(np.abs(viscous / q[1, :, self.joint]) * self.velocity)
        room = self.limit - np.abs(constant) - friction
        if not (room > 0.0).all():
            at = int(np.argmin(room))
            raise UsageError(
                f"torque of {self.name}: weight and friction take {self.limit - room[at]:.6g} of {self.limit:.6g} with "
                f"the joints at {np.round(q[0, at], 6).tolist()}; give a stronger motor, or a weight balance"
            )
        return np.stack([slope, square], axis=1) * (self.limit / room)[:, None]


@dataclass(frozen=True)
class _Shared:
    """The coefficients of all joints at the places that were asked for last: each joint's limit asks for them."""

    dynamics: Dynamics | _Fitted
    _last: threading.local = field(default_factory=threading.local, init=False, compare=False, repr=False)

    def along(self, q: Floats) -> TorqueTerms:
        """As `Dynamics.along`."""
        last: tuple[Floats, TorqueTerms] | None = getattr(self._last, "found", None)
        if last is None or last[0].shape != q.shape or not np.array_equal(last[0], q):
            last = self._last.found = q.copy(), self.dynamics.along(q)
        return last[1]

    def __reduce__(self) -> tuple[type[_Shared], tuple[Dynamics | _Fitted]]:
        # what is remembered stays behind
        return type(self), (self.dynamics,)


@dataclass(frozen=True)
class _Fitted:
    """The coefficients of a function for torques: differences of what it tells at some velocities and accelerations."""

    torque: Torque

    def along(self, q: Floats) -> TorqueTerms:
        """As `Dynamics.along`. Raises UsageError for a function that is no torque of rigid bodies."""
        place, first, second = q[:3]
        still = np.zeros_like(first)
        speeds = (still, still, still, first, -first, 2.0 * first, 3.0 * first)
        gains = (still, first, second, still, still, still, still)
        n, joints = place.shape
        moment = (np.concatenate(each) for each in ((place,) * 7, speeds, gains))
        found = np.asarray(self.torque(*moment), dtype=float)
        if found.shape != (7 * n, joints):
            raise UsageError(
                f"torques: the function gives shape {found.shape} for {7 * n} places; it must be {(7 * n, joints)}"
            )
        if not np.isfinite(found).all():
            raise UsageError(f"torques: the function gives {found[~np.isfinite(found)][0]}; give finite numbers")
        rest, by_first, by_second, forth, back, twice, thrice = found.reshape(7, n, joints)
        square = 0.5 * (forth + back) - rest
        odd, odd_twice = 0.5 * (forth - back), twice - rest - 4.0 * square
        linear, constant = odd_twice - odd, 2.0 * odd - odd_twice
        off = np.abs(rest + constant + 3.0 * linear + 9.0 * square - thrice)
        if (off > ROUNDING * (1.0 + np.abs(thrice).max(initial=0.0))).any():
            raise UsageError("torques: the function is not quadratic in the velocities, but for its friction")
        return TorqueTerms(0.5 * (by_first - rest), by_second - rest + square, linear, rest + constant)
