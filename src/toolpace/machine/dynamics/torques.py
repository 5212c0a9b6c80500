"""Limits on the torques and forces of joints as rows along a path: from masses, or a function of one's own."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from toolpace.common.arrays import Floats, numbers
from toolpace.common.errors import MachineError, UsageError
from toolpace.machine.dynamics import Dynamics, TorqueTerms
from toolpace.machine.file import MachineFile
from toolpace.machine.limit_curves import LimitCurve
from toolpace.machine.limits import CONTINUOUS, MOTORS
from toolpace.machine.rows import Rows

ROUNDING = 1e-6
"""Share of the largest torque by which a function may miss what its others tell."""
HELD = 1.0 + 2e-5
"""Share of its limit up to which a torque counts as held: a fifth of what is promised."""
HALVINGS = 50
"""For a factor between 0 and 1 to within rounding."""
Torque = Callable[[Floats, Floats, Floats], npt.ArrayLike]
"""Torques (n, joints) at positions, velocities and accelerations (n, joints) of the joints."""


@dataclass(frozen=True)
class ContinuousRating:
    """The torque that a motor bears without end: the limit of the root mean square over any window of time."""

    torque: float
    """[N m, N]"""
    window: float = math.inf
    """[s]; a motion that is shorter counts as a whole, as if it were repeated."""

    def share(self, length: Floats, torque: Floats) -> float:
        """The largest root mean square over the rating, of torques (n,) for times (n,) [s] each."""
        t, heat = (np.concatenate([[0.0], np.cumsum(part)]) for part in (length, length * torque**2))
        window = min(self.window, float(t[-1]))
        if not window > 0.0:
            return 0.0
        begin = np.clip(np.concatenate([t, t - window]), 0.0, t[-1] - window)
        mean = (np.interp(begin + window, t, heat) - np.interp(begin, t, heat)) / window
        return math.sqrt(max(float(mean.max()), 0.0)) / self.torque


@dataclass(frozen=True, repr=False)
class JointTorque(Rows):
    """The limit on the torque or force of one joint, as a row of acceleration: weight and friction are taken off it."""

    terms: _JointTerms | None = None
    curve: LimitCurve | None = None
    """The limit over the speed of the joint [m/s or rad/s; N m, N]."""
    rating: ContinuousRating | None = None

    @classmethod
    def of(
        cls, terms: _JointTerms, name: str, unit: str, curve: LimitCurve, rating: ContinuousRating | None = None
    ) -> JointTorque:
        """That of a joint of dynamics that are shared by all joints [N m, N]."""
        room = _Room(terms, curve, name, unit)
        pieces = len(room.of_motor)
        turning = (terms.joint,) if terms.shared.dynamics.has_dry_friction(terms.joint) else ()
        return cls(
            name, unit, curve.largest, terms, lines=room, pieces=pieces, jumps_at_turns_of=turning,
            terms=terms, curve=curve, rating=rating,
        )  # fmt: skip

    def eased(self, share: float) -> Rows:
        """The row of a share of what weight and friction leave, by which a plan keeps the continuous rating."""
        assert isinstance(self.lines, _Room)
        lines, limit = _Share(self.lines, share), self.limit * share
        return Rows(
            CONTINUOUS + self.name, self.unit, limit, self.function, lines=lines, pieces=self.pieces,
            jumps_at_turns_of=self.jumps_at_turns_of,
        )  # fmt: skip

    def parts(self, q: Floats, state: Floats) -> Floats:
        """(3, n) the torque at the joints q (4, n, joints) and states (4, n) of s [N m, N]: what falls with the square
        of the speed, viscous friction, and weight, dry friction and balance."""
        assert self.terms is not None
        slope, square, linear, constant = self.terms.at(q)
        _, v, a, _ = state
        return np.stack([slope * 2.0 * a + square * v * v, linear * v, constant])

    def ratio(self, q: Floats, state: Floats) -> Floats:
        """(n,) |torque| over its limit at the joints q (4, n, joints) and states (4, n) of s.

        Where it is exceeded by more than rounding it is by how much (ds/dt)^2 must fall for the motor to bear it, where
        that is more: weight and dry friction stay as they are however slow the motion is.
        """
        assert self.terms is not None and self.curve is not None
        parts, speed = self.parts(q, state), q[1, :, self.terms.joint] * state[1]
        share: Floats = np.abs(parts.sum(axis=0)) / self.curve.at(speed)
        over = share > HELD
        if over.any():
            slower = self._slower(parts[:, over], speed[over])
            share[over] = np.maximum(share[over], slower**-2.0)
        return share

    def _slower(self, parts: Floats, speed: Floats) -> Floats:
        """(n,) the factor of ds/dt at which the motor bears the parts (3, n) of a torque, found by halving."""
        assert self.curve is not None
        square, viscous, constant = parts
        low, high = np.zeros(len(speed)), np.ones(len(speed))
        for _ in range(HALVINGS):
            factor = (low + high) / 2.0
            borne = np.abs((square * factor + viscous) * factor + constant) <= self.curve.at(speed * factor)
            low, high = np.where(borne, factor, low), np.where(borne, high, factor)
        return high


def torque_rows(
    dynamics: Dynamics | Torque,
    most: npt.ArrayLike | Sequence[float | LimitCurve],
    joints: Sequence[str],
    linear: Sequence[bool] | None = None,
    *,
    continuous: npt.ArrayLike | None = None,
    window: npt.ArrayLike = math.inf,
) -> tuple[Rows, ...]:
    """Limits on the torques of joints, as `plan(..., rows=...)` takes them, by the names "torque A" and "force X".

    `dynamics` is a `Dynamics`, or a function of one's own: torques (n, m) [N m, N] at positions, velocities and
    accelerations (n, m) of the joints, quadratic in the velocities but for dry and viscous friction. `most` (m,) is the
    largest torque of each, without sign, inf where none is held, or a `LimitCurve` over the speed of the joint [rad/s,
    m/s]; `linear` (m,) says which joints have a force (default: as the links of `dynamics` are). `continuous` (m,) is
    the largest root mean square of each over any `window` (m,) [s], of a motion that is shorter over all of it; inf
    where none is held. Raises UsageError.
    """
    curves = {k: each for k, each in enumerate(_each(most, len(joints))) if isinstance(each, LimitCurve)}
    if curves:
        most = [each.largest if isinstance(each, LimitCurve) else each for each in _each(most, len(joints))]
    limit = np.broadcast_to(numbers(most, "torques: most", (len(joints),), (), finite=False), len(joints))
    if linear is None:
        linear = [each.kind == "linear" for each in getattr(dynamics, "links", ())] or [False] * len(joints)
    if len(linear) != len(joints):
        raise UsageError(f"torques: dynamics of {len(linear)} joints for {len(joints)} ({', '.join(joints)})")
    for name, figure in zip(joints, limit):
        if not figure > 0.0:
            raise UsageError(f"torques: that of joint {name} is {figure:g}; give a positive number (or inf)")
    ratings = _ratings(continuous, window, joints, limit)
    shared = _Shared(dynamics if isinstance(dynamics, Dynamics) else _Fitted(dynamics))
    rows = []
    for k in np.flatnonzero(np.isfinite(limit)).tolist():
        kind, unit = (MOTORS[0], "N") if linear[k] else (MOTORS[1], "N m")
        curve = curves.get(k) or LimitCurve([[0.0, limit[k]]])
        rows.append(JointTorque.of(_JointTerms(shared, k), f"{kind} {joints[k]}", unit, curve, ratings[k]))
    return tuple(rows)


def _ratings(
    continuous: npt.ArrayLike | None, window: npt.ArrayLike, joints: Sequence[str], limit: Floats
) -> list[ContinuousRating | None]:
    """The continuous rating of each joint."""
    if continuous is None:
        return [None] * len(joints)
    most, span = (
        np.broadcast_to(numbers(each, f"torques: {name}", (len(joints),), (), finite=False), len(joints))
        for name, each in (("continuous", continuous), ("window", window))
    )
    for joint, figure, time, peak in zip(joints, most, span, limit):
        what = f"torques: joint {joint} has {figure:g} continuously"
        if not (figure > 0.0 and time > 0.0):
            raise UsageError(f"{what} over {time:g} s; give positive numbers")
        if peak < figure < math.inf:
            raise UsageError(f"{what}, above its largest, {peak:g}; give a larger one in `most`, or less")
        if figure < math.inf == peak:
            raise UsageError(f"{what}, and no largest; give it in `most`")
    rated = zip(most.tolist(), span.tolist())
    return [ContinuousRating(figure, time) if figure < math.inf else None for figure, time in rated]


def _each(most: object, count: int) -> list[Any]:
    """What stands for each joint."""
    if isinstance(most, np.ndarray):
        return list(np.atleast_1d(most))
    return list(most) if isinstance(most, Sequence) and not isinstance(most, str) else [most] * count


def machine_torques(file: MachineFile, source: str) -> tuple[Rows, ...]:
    """The limits on torques and forces that a machine file names; none where it names none. Raises MachineError."""
    joints = file.joints
    limited = {name for name, joint in joints.items() if joint.motor is not None}
    if not limited:
        return ()
    dynamics = Dynamics.of_machine(file)
    for k, (name, link) in enumerate(zip(joints, dynamics.links)):
        carried = [dynamics.links[chain[-1]] for chain in dynamics.chains if k in chain]
        moves = link.rotor_inertia or any(each.mass or any(each.inertia) for each in carried)
        if name in limited and not moves:
            raise MachineError(f"{source}: joint {name} has a limit of torque or force, and moves no mass; give mass")
    motors = [joint.motor or math.inf for joint in joints.values()]
    continuous = [joint.continuous or math.inf for joint in joints.values()]
    windows = [joint.thermal_window for joint in joints.values()]
    return torque_rows(dynamics, motors, list(joints), continuous=continuous, window=windows)


@dataclass(frozen=True)
class _JointTerms:
    """The terms of one joint's torque; as a function of rows, those of z' and z."""

    shared: _Shared
    joint: int

    def at(self, q: Floats) -> tuple[Floats, ...]:
        """Those of z', z, sqrt(z) and the constant, each (n,)."""
        return tuple(part[:, self.joint] for part in self.shared.along(q))

    def __call__(self, q: Floats) -> Floats:
        """(n, 2) from the joints q (4, n, joints)."""
        slope, square, _, _ = self.at(q)
        return np.stack([slope, square], axis=1)


@dataclass(frozen=True)
class _Room:
    """What weight and friction leave of a joint's limit, as lines of rows over ds/dt."""

    terms: _JointTerms
    curve: LimitCurve
    name: str
    unit: str

    @cached_property
    def of_motor(self) -> Floats:
        """(pieces, choices, 2) of the motor's curve: height at rest, and fall with the speed of the joint."""
        return self.curve.lines(math.inf, math.inf)

    def __call__(self, q: Floats) -> tuple[Floats, Floats]:
        """(n, 1, pieces, choices, 2) above and below zero: height at rest, and fall with ds/dt.

        Raises UsageError where there is no room at rest.
        """
        _, _, linear, constant = self.terms.at(q)
        if not (np.abs(constant) < self.curve.largest).all():
            at = int(np.argmax(np.abs(constant)))
            raise UsageError(
                f"{self.name}: weight and friction take {abs(constant[at]):.6g} of {self.curve.largest:.6g} "
                f"{self.unit} with the joints at {np.round(q[0, at], 6).tolist()} m or rad; give a stronger motor, or "
                "a weight balance"
            )
        speed = np.abs(q[1, :, self.terms.joint])
        motor = self.of_motor * np.stack([np.ones_like(speed), speed], axis=1)[:, None, None]
        taken = np.stack([constant, -linear], axis=1)[:, None, None]
        above, below = motor - taken, motor + taken
        return above[:, None], below[:, None]


@dataclass(frozen=True)
class _Share:
    """A share of the lines of a room."""

    room: _Room
    share: float

    def __call__(self, q: Floats) -> tuple[Floats, Floats]:
        """As those of the room."""
        above, below = self.room(q)
        return self.share * above, self.share * below


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

    def has_dry_friction(self, joint: int) -> bool:
        """Whether a joint has dry friction: nobody knows."""
        return True

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
