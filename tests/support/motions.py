"""An analytic five-axis motion to judge: a straight run, a pause, an arc; jerk-limited, known in closed
form."""

from __future__ import annotations

import copy
from dataclasses import dataclass, field

import numpy as np

from toolpace.machine.limits import Limits
from toolpace.machine.machine import Machine
from toolpace.motion import Motion
from toolpace.motion.setpoints import SetPoints
from toolpace.motion.trajectory import OpenPlace, Skipped
from toolpace.programs.toolpath import ToolPath

RADIUS = 0.02
LENGTHS = (0.04, np.pi * RADIUS)
DWELL = 0.25


@dataclass(frozen=True)
class Ramp:
    """Rest to rest over a length: jerk up, hold, jerk down, cruise, and the same back; speed, acceleration
    and jerk."""

    length: float
    speed: float = 0.05
    acceleration: float = 0.5
    jerk: float = 10.0

    @property
    def phases(self) -> list[tuple[float, float]]:
        j, a = self.jerk, self.acceleration
        rise = a / j
        hold = self.speed / a - rise
        used = self.speed * (2.0 * rise + hold)
        cruise = (self.length - used) / self.speed
        return [(rise, j), (hold, 0.0), (rise, -j), (cruise, 0.0), (rise, -j), (hold, 0.0), (rise, j)]

    @property
    def duration(self) -> float:
        return sum(time for time, _ in self.phases)

    def at(self, t):
        """(4, n) length, speed, acceleration, jerk."""
        out = np.zeros((4, len(t)))
        s, v, a, begin = 0.0, 0.0, 0.0, 0.0
        for time, j in self.phases:
            inside = t >= begin
            tau = np.minimum(t[inside] - begin, time)
            out[:, inside] = (
                s + v * tau + a * tau**2 / 2 + j * tau**3 / 6,
                v + a * tau + j * tau**2 / 2,
                a + j * tau,
                np.full(len(tau), j),
            )
            s, v, a = (
                s + v * time + a * time**2 / 2 + j * time**3 / 6,
                v + a * time + j * time**2 / 2,
                a + j * time,
            )
            begin += time
        rest = t >= begin
        out[0, rest], out[1:, rest] = self.length, 0.0
        return out


def curve(run, s):
    """Tip (4, n, 3) and rotary joints (4, n, 2) with derivatives along the length s of a run."""
    zero = np.zeros_like(s)
    if run == 0:
        tip = np.stack([np.stack([s, 0.5 * zero, zero], 1), np.stack([zero + 1.0, zero, zero], 1)])
        tip = np.concatenate([tip, np.zeros((2, len(s), 3))])
        slope = np.array([4.0, 3.0])
        rotary = np.array([0.3, 0.1]) + s[:, None] * slope
    else:
        angle = s / RADIUS
        x, y = np.sin(angle), 1.0 - np.cos(angle)
        dx, dy = np.cos(angle), np.sin(angle)
        r = RADIUS
        tip = np.stack(
            [
                np.stack([LENGTHS[0] + r * x, r * y, zero], 1),
                np.stack([dx, dy, zero], 1),
                np.stack([-x, dx, zero], 1) / r,
                np.stack([-dx, -dy, zero], 1) / r**2,
            ]
        )
        slope = np.array([-3.0, 5.0])
        rotary = np.array([0.3 + 4.0 * LENGTHS[0], 0.1 + 3.0 * LENGTHS[0]]) + s[:, None] * slope
    jets = np.zeros((4, len(s), 2))
    jets[0], jets[1] = rotary, slope
    return tip, jets


def in_time(jets, law):
    """Derivatives with respect to time, by the chain rule."""
    _, v, a, j = (x[:, None] for x in law)
    return np.stack(
        [
            jets[0],
            jets[1] * v,
            jets[2] * v**2 + jets[1] * a,
            jets[3] * v**3 + 3.0 * jets[2] * v * a + jets[1] * j,
        ]
    )


def machine():
    return Machine.load("xyzac-trunnion")


def program(spacing=5e-4, feed=0.05):
    """The tool path of both runs, sampled; a dwell between them."""
    model = machine()
    tips, rotaries = [], []
    for run, length in enumerate(LENGTHS):
        s = np.linspace(0.0, length, round(length / spacing) + 1)[1 if run else 0 :]
        tip, rotary = curve(run, s)
        tips.append(tip[0])
        rotaries.append(rotary[0])
    tip, rotary = np.concatenate(tips), np.concatenate(rotaries)
    n, corner = len(tip), len(tips[0]) - 1
    stop = np.zeros(n, dtype=bool)
    stop[[0, corner, -1]] = True
    dwell = np.zeros(n)
    dwell[corner] = DWELL
    return ToolPath(
        tip=tip,
        axis=model.axis_at(rotary),
        feed=np.full(n, feed),
        least_time=np.zeros(n),
        block=np.arange(n) + 10,
        stop=stop,
        dwell=dwell,
        rotary=rotary,
        rotary_joints=tuple(model.joints[i] for i in model.rotary),
        source="test",
    )


def joints_at(t, speed=0.05):
    """(4, n, joints) joints and derivatives at times t (n,) in order, and (n,) the length passed of each run."""
    model = machine()
    laws = [Ramp(length, speed=speed) for length in LENGTHS]
    begin = laws[0].duration + DWELL
    jets, lengths = [], []
    for run, (low, high) in enumerate(((-np.inf, begin), (begin, np.inf))):
        law = laws[run].at(t[(t >= low) & (t < high)] - max(low, 0.0))
        tip, rotary = curve(run, law[0])
        jets.append(model.linear_jets(in_time(tip, law), in_time(rotary, law)))
        lengths.append(law[0])
    return np.concatenate(jets, axis=1), lengths


def set_points(dt=1e-3, spacing=5e-4, speed=0.05):
    """The motion, sampled."""
    model = machine()
    duration = sum(Ramp(length, speed=speed).duration for length in LENGTHS) + DWELL
    t = np.arange(int(np.ceil(duration / dt)) + 1) * dt
    q, lengths = joints_at(t, speed)
    blocks, before = [], 10
    for run, length in enumerate(lengths):
        pieces = round(LENGTHS[run] / spacing)
        blocks.append(before + np.minimum(np.floor(length / LENGTHS[run] * pieces) + 1, pieces))
        before += pieces
    tip, axis = model.forward(np.ascontiguousarray(q[0]))
    block = np.concatenate(blocks).astype(np.int64)
    return SetPoints(t, *(np.ascontiguousarray(x) for x in q), tip=tip, axis=axis, block=block, joints=model.joints)


def with_limits(model, **kinds):
    """The same machine with other limits."""
    changed = copy.copy(model)
    now = model.limits
    values = {kind: kinds.get(kind, getattr(now, kind)) for kind in ("velocity", "acceleration", "jerk")}
    object.__setattr__(changed, "limits", Limits(**values, joints=now.joints))
    return changed


def peaks(points):
    """Largest velocity, acceleration and jerk of each joint."""
    return {
        "velocity": np.abs(points.qd).max(axis=0),
        "acceleration": np.abs(points.qdd).max(axis=0),
        "jerk": np.abs(points.qddd).max(axis=0),
    }


class Run:
    """One stretch of the path, as far as a report asks."""

    def __init__(self, length):
        self.s0, self.s1, self.dwell = 0.0, length, 0.0

    def speed_cap(self, s):
        return np.full(len(s), 0.05)

    def entries(self):
        return np.zeros(1), np.zeros(0, dtype=np.int64)

    def deviations(self):
        return None


class AxisPath:
    """Both stretches on the machine."""

    def __init__(self):
        self.machine = machine()
        self.runs = [Run(length) for length in LENGTHS]
        self.tool_lengths = np.full(2, np.nan)
        self.first_dwell = 0.0


class Trajectory:
    """The motion with the face of a planned one."""

    planner, mesh_points, solve_seconds = "analytic", 42, 0.01
    continuous_bound = 2.4
    open_places = (OpenPlace(0.5, 0.7, 0.1, 3),)
    skipped: tuple[Skipped, ...] = ()

    def __init__(self, lower_bound=2.5):
        self.laws = [Ramp(length) for length in LENGTHS]
        self.starts = np.array([0.0, self.laws[0].duration + DWELL])
        self.duration = float(self.starts[1] + self.laws[1].duration)
        self.lower_bound, self.gap = lower_bound, self.duration / lower_bound - 1.0 if lower_bound else np.inf
        self.axis_path = AxisPath()
        self.joints = self.axis_path.machine.joints
        points = set_points()
        self.limits = Limits(**peaks(points), joints=self.joints)

    def at(self, t):
        t = np.asarray(t)
        order = np.argsort(t, kind="stable")
        q = np.empty((4, len(t), len(self.joints)))
        q[:, order] = joints_at(t[order])[0]
        return Motion(*q)

    def run_at(self, t):
        return np.searchsorted(self.starts, t, side="right") - 1

    def sample(self, dt=1e-3):
        return set_points(dt=dt)

    def usage(self):
        ones = dict.fromkeys(self.joints, 1.0)
        return Usage(1.0, ones, ones, ones)

    def limited_by(self):
        return {"feed": 0.7, "jerk A": 0.15, "dwell": 0.1, "nothing": 0.05}


@dataclass(frozen=True)
class Usage:
    """Peak use of each limit."""

    feed: float
    velocity: dict[str, float]
    acceleration: dict[str, float]
    jerk: dict[str, float]
    rows: dict[str, float] = field(default_factory=dict)

    @property
    def worst(self):
        return 1.0
