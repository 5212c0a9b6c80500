"""Torques and forces of a machine's joints at set-points, by Newton's and Euler's equations link by link.

From the bed outwards go velocities and accelerations, back to it forces and moments, each link in a frame of its own
that turns with it (Luh, Walker and Paul 1980). The planner has them by Lagrange (machine/dynamics), in the frame of
the bed; nothing of that is used here.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from toolpace.common.arrays import Bools, Floats
from toolpace.judge.motion import TOLERANCE
from toolpace.judge.seen_motion import Largest, SeenMotion
from toolpace.judge.verification import Check
from toolpace.machine.file import JointFile, MachineFile
from toolpace.machine.limits import CONTINUOUS
from toolpace.motion.setpoints import Block

STILL = 1e-9
"""Velocity up to which a joint stands, and its dry friction holds it without the motor [m/s or rad/s]."""


@dataclass(frozen=True)
class JointTorques:
    """The torques of the joints of a machine file, in the order of its columns."""

    file: MachineFile

    @property
    def held(self) -> Bools:
        """(m,) whether the motor of a joint has a limit."""
        return np.array([joint.motor is not None for joint in self.file.joints.values()])

    def limits(self, qd: Floats) -> Floats:
        """(n, m) the largest of each [N m, N] at velocities (n, m), straight between the corners of a motor's curve;
        inf where none is held."""
        out = np.full(qd.shape, np.inf)
        for k, joint in enumerate(self.file.joints.values()):
            if joint.motor is not None:
                out[:, k] = np.interp(np.abs(qd[:, k]), joint.motor.speed, joint.motor.limit)
        return out

    @property
    def rated(self) -> list[int]:
        """The joints whose motors have a continuous rating."""
        return [k for k, joint in enumerate(self.file.joints.values()) if joint.continuous is not None]

    def shares(self, q: Floats, qd: Floats, qdd: Floats) -> Floats:
        """(n, m) torques over their limits, without sign, of positions, velocities and accelerations (n, m)."""
        shares: Floats = np.abs(self.at(q, qd, qdd)) / self.limits(qd)
        return shares

    def largest(self, block: Block, begin: int, end: int) -> tuple[Largest, Floats]:
        """The largest share of each joint's limit in the rows from `begin` to `end` of a block; and there the torques
        (n, k) of those with a continuous rating."""
        q, qd, qdd = (block.columns(name, begin, end).T for name in ("q", "qd", "qdd"))
        values = self.at(q, qd, qdd)
        return Largest.of((np.abs(values) / self.limits(qd)).T, begin), values[:, self.rated]

    def at(self, q: Floats, qd: Floats, qdd: Floats) -> Floats:
        """(n, m) of positions, velocities and accelerations (n, m) [m or rad, s]."""
        out, names = np.empty(q.shape), list(self.file.joints)
        for side in (self.file.chain.workpiece, self.file.chain.tool):
            columns = [names.index(name) for name in side]
            out[:, columns] = self._of_chain(side, *(part[:, columns] for part in (q, qd, qdd)))
        return out

    def _of_chain(self, side: Sequence[str], q: Floats, qd: Floats, qdd: Floats) -> Floats:
        """(n, k) those of a chain from the bed, from its motion (n, k)."""
        n, count = q.shape
        joints = [self.file.joints[name] for name in side]
        spin, spin_gain = np.zeros((n, 3)), np.zeros((n, 3))
        gain = np.tile(-np.array(self.file.chain.gravity), (n, 1))
        origin = np.zeros(3)
        turns, arms, loads = [], [], []
        for k, joint in enumerate(joints):
            axis, point = _unit(joint.direction), np.array(joint.point)
            rate, rate_gain = qd[:, k, None] * axis, qdd[:, k, None] * axis
            rotary = joint.kind == "rotary"
            arm = np.tile(point - origin, (n, 1)) + (0.0 if rotary else q[:, k, None] * axis)
            gain = gain + np.cross(spin_gain, arm) + np.cross(spin, np.cross(spin, arm))
            turn = _turns(axis, q[:, k] if rotary else np.zeros(n))
            if rotary:
                before = _into(turn, spin)
                spin_gain = _into(turn, spin_gain) + np.cross(before, rate) + rate_gain
                spin, gain = before + rate, _into(turn, gain)
            else:
                gain = gain + 2.0 * np.cross(spin, rate) + rate_gain
            load = [_load(joint.mass, np.array(joint.centre) - point, joint.inertia, spin, spin_gain, gain)]
            part = self.file.workpiece
            if part is not None and side is self.file.chain.workpiece and k == count - 1:
                load.append(_load(part.mass, np.array(part.centre) - point, part.inertia, spin, spin_gain, gain))
            turns.append(turn)
            arms.append(arm)
            loads.append((sum(force for force, _ in load), sum(moment for _, moment in load)))
            origin = point
        out = np.empty((n, count))
        force, moment = np.zeros((n, 3)), np.zeros((n, 3))
        for k in range(count - 1, -1, -1):
            force, moment = force + loads[k][0], moment + loads[k][1]
            out[:, k] = (moment if joints[k].kind == "rotary" else force) @ _unit(joints[k].direction)
            force, moment = _out_of(turns[k], force), _out_of(turns[k], moment)
            moment = moment + np.cross(arms[k], force)
            out[:, k] += _of_drive(joints[k], qd[:, k], qdd[:, k])
        return out


def torque_checks(seen: SeenMotion, largest: Largest, torques: JointTorques, units: Sequence[str]) -> list[Check]:
    """Each joint's torque or force against its limit at the speed there, where most of it is taken."""
    checks = []
    for j in np.flatnonzero(torques.held).tolist():
        row = int(largest.row[j])
        time, block = seen.place(row)
        limit = float(torques.limits(seen.source.rows(row, row + 1).qd)[0, j])
        value = float(largest.value[j]) * limit
        what, unit = ("force", "N") if units[j] == "m" else ("torque", "N m")
        ok = value <= limit * (1.0 + TOLERANCE)
        checks.append(Check(what, value, limit, unit, ok, time, block, seen.joints[j]))
    return checks


def rated_shares(torques: JointTorques, t: Floats, values: Floats) -> list[float]:
    """The largest root mean square of each rated torque over its window, over the rating; of torques (n, m) at t (n,).

    The square is straight between set-points: a window begins or ends at one of them, or lies over all.
    """
    joints = list(torques.file.joints.values())
    return [
        largest_mean(t, values[:, k] ** 2, joints[k].thermal_window) ** 0.5 / (joints[k].continuous or math.inf)
        for k in torques.rated
    ]


def largest_mean(t: Floats, square: Floats, window: float) -> float:
    """The largest mean over a window of time of what is `square` (n,) at times t (n,), straight between them."""
    span = float(t[-1] - t[0]) if len(t) else 0.0
    if not span > 0.0:
        return float(square.max(initial=0.0))
    heat = np.zeros(len(t))
    np.cumsum(np.diff(t) * (square[1:] + square[:-1]) / 2.0, out=heat[1:])
    if not window < span:
        return float(heat[-1]) / span
    last, first = np.minimum(t + window, t[-1]), np.maximum(t - window, t[0])
    ahead = (np.interp(last, t, heat) - heat)[t + window <= t[-1]]
    behind = (heat - np.interp(first, t, heat))[t - window >= t[0]]
    return max(float(part.max(initial=0.0)) for part in (ahead, behind)) / window


def rating_checks(torques: JointTorques, t: Floats, values: Floats, units: Sequence[str]) -> list[Check]:
    """The root mean square of each rated torque (n, k) at times t (n,) against its rating."""
    checks, joints = [], list(torques.file.joints.items())
    whole = np.zeros((len(t), len(joints)))
    whole[:, torques.rated] = values
    for k, share in zip(torques.rated, rated_shares(torques, t, whole)):
        name, joint = joints[k]
        what, unit = ("force", "N") if units[k] == "m" else ("torque", "N m")
        rating, ok = joint.continuous or 0.0, share <= 1.0 + TOLERANCE
        note = "root mean square" + (f" over {joint.thermal_window:g} s" if math.isfinite(joint.thermal_window) else "")
        checks.append(Check(f"{CONTINUOUS}{what}", share * rating, rating, unit, ok, joint=name, note=note))
    return checks


def _of_drive(joint: JointFile, qd: Floats, qdd: Floats) -> Floats:
    """(n,) what rotor, friction and weight balance ask of the motor."""
    dry = np.where(np.abs(qd) > STILL, np.sign(qd), 0.0) * joint.dry_friction
    found: Floats = joint.rotor_inertia * qdd + joint.viscous_friction * qd + dry - joint.balance
    return found


def _load(
    mass: float, centre: Floats, inertia: Sequence[float], spin: Floats, spin_gain: Floats, gain: Floats
) -> tuple[Floats, Floats]:
    """Force on a body, and its moment about the origin of its frame (n, 3)."""
    xx, yy, zz, xy, xz, yz = (*inertia, 0.0, 0.0, 0.0)[:6]
    tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    force = mass * (gain + np.cross(spin_gain, centre) + np.cross(spin, np.cross(spin, centre)))
    moment = spin_gain @ tensor + np.cross(spin, spin @ tensor) + np.cross(centre, force)
    return force, moment


def _unit(direction: Sequence[float]) -> Floats:
    return np.array(direction) / math.hypot(*direction)


def _turns(axis: Floats, angle: Floats) -> Floats:
    """(n, 3, 3) rotations about an axis, from the link's frame to the one before it, by unit quaternions."""
    w, x, y, z = np.cos(angle / 2.0), *(np.sin(angle / 2.0) * each for each in axis)
    rows = [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
        [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), 2, 0)


def _into(turn: Floats, vector: Floats) -> Floats:
    """Vectors (n, 3) of the frame before, in the link's."""
    found: Floats = np.einsum("nji,nj->ni", turn, vector)
    return found


def _out_of(turn: Floats, vector: Floats) -> Floats:
    """Vectors (n, 3) of the link's frame, in the one before."""
    found: Floats = np.einsum("nij,nj->ni", turn, vector)
    return found
