"""CasADi and IPOPT on path and pace together: a stretch of a motion between fixed states, inside the tube.

Unknown are the change of each joint, a quintic spline over knots even in the time of the motion at hand, and its
pace: z = (dt_old / dt_new)^2, a cubic spline over the same knots. The tip and the axis of the changed joints stay in
balls around the program at the same parameter, so that nothing shifts along the path: that is what the pace is for.
Position, velocity and acceleration of all joints, and the place on the path, are those of the motion at both ends.

Rows are held at a few places of each cell. Between these the answer is looked at closely, where it passes a limit there
are rows too, and IPOPT goes on from there; what then is left is paid for in time, for the answer is slowed down as a
whole until it holds. Its time is thus one that a motion within the limits takes, but for its ends, which are that much
slower.
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np
from scipy import sparse as sparse_arrays
from scipy.interpolate import BSpline

from testbed.ipopt import ANSWERED, dm
from toolpace.common.arrays import Floats
from toolpace.kernels.fit.polyline import circular, straight
from toolpace.kernels.kinematics.geometry import A0, C0, C1, C2, LINEAR, U1, U2
from toolpace.machine.machine import Machine
from toolpace.motion.trajectory import Trajectory
from toolpace.path.fit.polyline import PlaceTolerances, polylines
from toolpace.programs.toolpath import ToolPath

CELL = 8e-3
"""About the time between knots [s]."""
PLACES = 8
"""Places in each cell at which rows are held."""
LOOKS = 48
"""Places in each cell at which the answer is looked at."""
SOLVES = 3
"""Times that IPOPT goes on, at most, each with rows where the answer before passed a limit."""
ENOUGH = 1.002
"""Usage between the places that is not worth another, nor a row there."""
INSIDE = 0.995
"""Share of the tolerances that the tip and the axis may use at these places."""
UNIT = 1e-5, 1e-4
"""Of the changes of linear joints [m] and rotary joints [rad]."""


@dataclass(frozen=True)
class Stretch:
    """A motion between two times [s], the program that it follows, and how closely."""

    name: str
    trajectory: Trajectory
    toolpath: ToolPath
    machine: Machine
    tip_tolerance: float
    """[m]"""
    axis_tolerance: float
    """[rad]"""
    start: float
    end: float

    @property
    def duration(self) -> float:
        """Time that the motion takes for it [s]."""
        return self.end - self.start

    def program(self, t: Floats) -> tuple[Floats, Floats]:
        """Tips (n, 3) [m] and axes (n, 3) of the program at the parameters that the motion passes at t (n,)."""
        (line,) = polylines(
            self.toolpath, PlaceTolerances.of(self.toolpath, self.tip_tolerance, self.axis_tolerance), self.machine
        )
        s = self.trajectory.parameter(t) / self.tip_tolerance
        tip = self.tip_tolerance * straight(line.s, line.tip, s)
        if self.toolpath.rotary is None:
            return tip, circular(line.s, line.axis, s)
        return tip, self.machine.axis_at(straight(line.s, line.turn, s) * self.axis_tolerance)


@dataclass(frozen=True)
class Fastest:
    """What IPOPT found for a stretch."""

    duration: float
    """[s], once it is slowed down until all limits hold between the places too."""
    usage: float
    """Of the limits before it is."""
    used: float
    """Of the tolerances, between the places too."""
    answered: bool
    """Whether IPOPT says that it found a minimum."""


class Bases:
    """Values and derivatives 0 to 3 of the splines of a stretch, at times since its start."""

    def __init__(self, duration: float, t: Floats) -> None:
        knots = np.linspace(0.0, duration, cells_of(duration) + 1)
        self.t = t
        self.change = [values(knots, 5, order, t) for order in range(4)]
        self.pace = [values(knots, 3, order, t) for order in range(3)]


def cells_of(duration: float) -> int:
    """How many cells the splines of a stretch have."""
    return max(round(duration / CELL), 12)


def even(duration: float, places: int) -> Floats:
    """The middles of so many even parts of each cell."""
    count = places * cells_of(duration)
    return (np.arange(count) + 0.5) * (duration / count)


def values(knots: Floats, degree: int, order: int, t: Floats) -> Floats:
    """(n, functions) a derivative of the B-splines of a degree over the knots, at t (n,)."""
    padded = np.concatenate([np.repeat(knots[0], degree), knots, np.repeat(knots[-1], degree)])
    spline = BSpline(padded, np.eye(len(padded) - degree - 1), degree)
    return np.asarray(spline(t, nu=order))


def fastest(stretch: Stretch, say: bool = False) -> Fastest:
    """The fastest motion on the stretch that IPOPT finds from the one at hand."""
    looked = Bases(stretch.duration, even(stretch.duration, LOOKS))
    places = even(stretch.duration, PLACES)
    m = len(stretch.machine.joints)
    first = np.concatenate([np.zeros(m * looked.change[0].shape[1]), np.ones(looked.pace[0].shape[1])])
    best = Fastest(stretch.duration, 1.0, 0.0, False)
    for _ in range(SOLVES):
        first, answered = minimise(stretch, Bases(stretch.duration, places), first)
        found, used = judged(stretch, looked, first, answered)
        if say:
            print(found, len(places), flush=True)
        if found.used <= 1.0 and (found.duration < best.duration or not best.answered):
            best = found
        peak = (used[1:-1] > ENOUGH) & (used[1:-1] >= used[:-2]) & (used[1:-1] >= used[2:])
        if not peak.any():
            break
        places = np.union1d(places, looked.t[1:-1][peak])
    return best


def minimise(stretch: Stretch, bases: Bases, first: Floats) -> tuple[Floats, bool]:
    """Coefficients of changes and pace, from `first` on."""
    limits, m = stretch.machine.limits, len(stretch.machine.joints)
    t = stretch.start + bases.t
    motion = stretch.trajectory.at(t)
    count, paces = bases.change[0].shape[1], bases.pace[0].shape[1]
    x = ca.SX.sym("x", m * (count - 6) + paces - 4)
    unit = np.where(stretch.machine.is_rotary, UNIT[1], UNIT[0])

    def spline(values: list[Floats], at: slice, fixed: int, scale: float) -> list[ca.SX]:
        inner = slice(fixed, values[0].shape[1] - fixed)
        return [dm(sparse_arrays.csc_matrix(each[:, inner])) @ (x[at] * scale) for each in values]

    offset = [base[:, [0, 1, -2, -1]].sum(axis=1) for base in bases.pace]
    pace = spline(bases.pace, slice(m * (count - 6), None), 2, 1.0)
    z = [each + ca.DM(o) for each, o in zip(pace, offset)]
    root = ca.sqrt(z[0])
    rows, joints = [], []
    for j in range(m):
        change = spline(bases.change, slice(j * (count - 6), (j + 1) * (count - 6)), 3, unit[j])
        q = [
            each + ca.DM(np.ascontiguousarray(now[:, j]))
            for each, now in zip(change, (motion.q, motion.qd, motion.qdd, motion.qddd))
        ]
        joints.append(q[0])
        rows += [q[1] * root / limits.velocity[j]] if np.isfinite(limits.velocity[j]) else []
        rows.append((q[2] * z[0] + 0.5 * q[1] * z[1]) / limits.acceleration[j])
        jerk = q[3] * z[0] + 1.5 * q[2] * z[1] + 0.5 * q[1] * z[2]
        rows.append(jerk * root / limits.jerk[j])
    off = deviations(stretch, joints, t)
    inside = np.full(2 * len(t), INSIDE)
    g = ca.vertcat(*rows, *off, z[0])
    limit = np.ones(len(rows) * len(t))
    solver = ca.nlpsol(
        "ipopt", "ipopt", {"x": x, "f": ca.dot(ca.DM(shares(bases.t, stretch.duration)), 1.0 / root), "g": g},
        {"print_time": False, "ipopt": {
            "print_level": 0, "sb": "yes", "tol": 1e-5, "max_iter": 200, "mu_strategy": "adaptive",
            "nlp_scaling_method": "none",
        }},
    )  # fmt: skip
    inner = free(first, m, count, unit)
    answer = solver(
        x0=inner,
        lbg=np.concatenate([-limit, -np.inf * inside, np.full(len(t), 0.05)]),
        ubg=np.concatenate([limit, inside**2, np.full(len(t), np.inf)]),
    )
    found = np.asarray(answer["x"]).ravel()
    whole = first.copy()
    for j in range(m):
        whole[j * count + 3 : (j + 1) * count - 3] = unit[j] * found[j * (count - 6) : (j + 1) * (count - 6)]
    whole[m * count + 2 : -2] = found[m * (count - 6) :]
    return whole, solver.stats()["return_status"] in ANSWERED


def shares(t: Floats, duration: float) -> Floats:
    """(n,) of a duration, for each of the ascending times t (n,) in it: up to half way to its neighbours."""
    return np.diff(np.concatenate([[0.0], 0.5 * (t[1:] + t[:-1]), [duration]])) / duration


def free(whole: Floats, m: int, count: int, unit: Floats) -> Floats:
    """What is unknown of all coefficients, in its units: the ends stay."""
    changes = [whole[j * count + 3 : (j + 1) * count - 3] / unit[j] for j in range(m)]
    return np.concatenate([*changes, whole[m * count + 2 : -2]])


def deviations(stretch: Stretch, joints: list[ca.SX], t: Floats) -> list[ca.SX]:
    """Squared deviation of the tip and of the axis, in tolerances, of joints at the times t of the motion at hand."""
    tip, axis = forward(stretch.machine, joints)
    program_tip, program_axis = stretch.program(t)
    chord = 2.0 * np.sin(0.5 * stretch.axis_tolerance)
    return [
        sum(((a - ca.DM(np.ascontiguousarray(b))) / scale) ** 2 for a, b in zip(place, wanted.T))
        for place, wanted, scale in ((tip, program_tip, stretch.tip_tolerance), (axis, program_axis, chord))
    ]


def forward(machine: Machine, q: list[ca.SX]) -> tuple[list[ca.SX], list[ca.SX]]:
    """Tip and axis, each as its three coordinates, of joints; the chain is that of kernels/kinematics/chain.py."""
    frame, group, place = machine.geometry.frame, machine.geometry.group, machine.geometry.place
    angle = [q[place[0]], q[place[1]]]
    axis = turned(frame[U1], angle[0], turned(frame[U2], angle[1], [ca.SX(a) for a in frame[A0]]))
    tip = [ca.SX(c) for c in frame[C2]]
    for g in (2, 1, 0):
        for j in range(3):
            if group[j] == g:
                tip = [a + b * q[place[2 + j]] for a, b in zip(tip, frame[LINEAR + j])]
        if g > 0:
            tip = turned(frame[U1 if g == 1 else U2], angle[g - 1], tip)
        if g == 2:
            tip = [a + b for a, b in zip(tip, frame[C1])]
    return [a - b for a, b in zip(tip, frame[C0])], axis


def turned(u: Floats, angle: ca.SX, v: list[ca.SX]) -> list[ca.SX]:
    """v turned about the unit vector u."""
    sine, cosine = ca.sin(angle), ca.cos(angle)
    along = sum(a * b for a, b in zip(u, v)) * (1.0 - cosine)
    cross = (u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])
    return [cosine * a + sine * b + along * c for a, b, c in zip(v, cross, u)]


def judged(stretch: Stretch, bases: Bases, whole: Floats, answered: bool) -> tuple[Fastest, Floats]:
    """The answer looked at closely, and the largest use of a limit or tolerance at each place (n,)."""
    limits, m = stretch.machine.limits, len(stretch.machine.joints)
    motion = stretch.trajectory.at(stretch.start + bases.t)
    count = bases.change[0].shape[1]
    change = whole[: m * count].reshape(m, count).T
    now = (motion.q, motion.qd, motion.qdd, motion.qddd)
    q = [base @ change + each for base, each in zip(bases.change, now)]
    z = [(base @ whole[m * count :])[:, None] for base in bases.pace]
    felt = (
        q[1] * np.sqrt(z[0]),
        q[2] * z[0] + 0.5 * q[1] * z[1],
        (q[3] * z[0] + 1.5 * q[2] * z[1] + 0.5 * q[1] * z[2]) * np.sqrt(z[0]),
    )
    used = [
        np.abs(each / limit).max(axis=1)
        for each, limit in zip(felt, (limits.velocity, limits.acceleration, limits.jerk))
    ]
    slower = max(float(each.max()) ** (1.0 / order) for order, each in enumerate(used, 1))
    tip, axis = stretch.machine.forward(q[0])
    program_tip, program_axis = stretch.program(stretch.start + bases.t)
    angle = 2.0 * np.arcsin(0.5 * np.linalg.norm(axis - program_axis, axis=1))
    off = np.maximum(np.linalg.norm(tip - program_tip, axis=1) / stretch.tip_tolerance, angle / stretch.axis_tolerance)
    duration = float(np.mean(1.0 / np.sqrt(z[0]))) * stretch.duration * max(slower, 1.0)
    worst = np.max([*used, off], axis=0)
    return Fastest(duration, max(float(each.max()) for each in used), float(off.max()), answered), worst
