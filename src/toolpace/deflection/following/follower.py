"""The follower: a plan played live, with correction and change of pace; its input and output at each step."""

from __future__ import annotations

import math
import os
from dataclasses import dataclass
from enum import IntFlag
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from toolpace.common.arrays import Floats
from toolpace.common.errors import UsageError, did_you_mean
from toolpace.common.value_objects import one_line
from toolpace.deflection.following.law import law_of, read_law, write_law
from toolpace.deflection.following.samples import FollowedJoints, followed_joints_of, samples_of
from toolpace.deflection.following.settings import Figures, number, numbers
from toolpace.kernels.follow import layout
from toolpace.kernels.follow.layout import AXIS, DEFLECTION, FORCE, MEASURED_AT, TIP
from toolpace.machine.limits import Limits
from toolpace.machine.machine import Machine
from toolpace.motion.trajectory import Trajectory

ROUNDING = 2e-4
"""Share of a limit by which a plan may be said to pass it."""
MOVES = 1e-6
"""Velocity of a joint with which a plan begins in motion [m/s, rad/s]: more than rounding, less than anybody sees."""


@dataclass(frozen=True, eq=False)
class Measurement:
    """Position of the tip or its deflection, direction of the tool, or force on it, at a time; what is not given was
    not measured.

    Any figures are taken, nan and absurd ones too: a follower says what it made of them, and goes on. The place of the
    tip counts before a force; an axis counts along with it.
    """

    t: float | None
    """When it was measured, on the follower's clock, which `SetPoint.t` tells [s]; None where the sensor does not say,
    and the follower's `dead_time` does."""
    tip: npt.ArrayLike | None = None
    """(3,) tool tip in the workpiece frame [m]."""
    axis: npt.ArrayLike | None = None
    """(3,) unit vector from the tip to the spindle, in the workpiece frame."""
    force: npt.ArrayLike | None = None
    """(3,) force on the tool, in the workpiece frame [N]; counts where the follower has a compliance."""
    deflection: npt.ArrayLike | None = None
    """(3,) how far the tip was from where it was commanded `delay` before, correction and all, in the workpiece frame
    [m]: what `tip` less that place would be, and taken in place of it."""

    def write(self, into: Floats, now: float, dead_time: float) -> None:
        """Write to an array (13,) as kernels/follow/layout.py has it, at a time `now` of the follower's clock [s].

        Raises UsageError for what is no number, or of a wrong shape, and for a time beside a dead time [s].
        """
        into[MEASURED_AT] = self._time(now, dead_time)
        for at, name, value in (
            (TIP, "tip", self.tip),
            (AXIS, "axis", self.axis),
            (FORCE, "force", self.force),
            (DEFLECTION, "deflection", self.deflection),
        ):
            if value is None:
                into[at : at + 3] = np.nan
                continue
            vector = numbers(value)
            if vector is None or vector.shape != (3,):
                what = f"is {value!r:.60}" if vector is None else f"has shape {vector.shape}"
                raise UsageError(f"measurement: {name} {what}; give three figures (x, y, z)")
            into[at : at + 3] = vector

    def _time(self, now: float, dead_time: float) -> float:
        """When it was measured [s]."""
        if self.t is None:
            return now - dead_time
        t = number(self.t)
        if t is None:
            raise UsageError(f"measurement: t is {self.t!r:.60}; give a time in seconds")
        if dead_time > 0.0 and not math.isnan(t):
            raise UsageError(
                f"measurement: t is {t:g} s, and the follower has a dead_time of {dead_time:g} s: the sensor would be"
                " late twice; give t = None, or a follower without dead_time"
            )
        return t


class Status(IntFlag):
    """What there is to say of a set-point; 0: all is well."""

    ENDED = layout.ENDED
    """The path has been gone through."""
    HELD = layout.HELD
    """The tool stands on its path: a feed of 0, or a stop; from the first step on where that is asked for then."""
    STALE = layout.STALE
    """Nothing that counts was measured of late (or no axis, where the rotary joints are corrected): the correction is
    held."""
    FADING = layout.FADED
    """Nothing was measured for so long that the correction is taken back."""
    AT_LIMIT = layout.AT_LIMIT
    """The correction would have to be larger than it may be."""
    STOPPING = layout.STOPPING
    """It was so for longer than patience: the tool is brought to a stop on its path, until `resume`."""
    NOT_A_NUMBER = layout.NOT_A_NUMBER
    """What was measured is not a number, or a force whose bending is not known: not counted."""
    LATE = layout.LATE
    """What was measured came out of order, too late, or from the future: not counted."""
    ABSURD = layout.ABSURD
    """What was measured is too far off to be believed: not counted."""
    JUMPED = layout.JUMPED
    """The joints were found displaced: the motion goes on from where they are."""
    SLOWED = layout.SLOWED
    """The pace is lowered, for a correction that adds to the feed or lags behind."""
    OVERRIDE_CUT = layout.OVERRIDE_CUT
    """The override is above 1.2 or below 0, and 1.2 or 0 is taken; or it is nan or infinite, and the tool holds."""


class SetPoint(NamedTuple):
    """Where the joints shall be one period later, and how they move there."""

    t: float
    """On the follower's clock [s]."""
    q: Floats
    """(m,) joints, path and correction together [m or rad]."""
    qd: Floats
    qdd: Floats
    qddd: Floats
    """(m,) their derivatives by time."""
    s: float
    """Parameter of the path."""
    path_time: float
    """Time of the plan that the path is at [s]."""
    pace: float
    """How fast it goes by, as a share of the pace that is the plan's own, less where the plan leaves no reserve."""
    correction: Floats
    """(4, m) what of q and its derivatives is correction."""
    status: Status


NOTHING = Measurement(math.nan)


class Follower:
    """Gives set-points one by one, along a trajectory at any pace, corrected by what is measured.

    Joints, path and correction together, keep the machine's limits of velocity, acceleration and jerk at all times,
    whatever is measured and whatever pace is asked for; the tip keeps its feed but for `feed_excess`.

    The path may use 1 - `reserve` of each limit: plan on `machine.reserved(reserve)`, or the plan is slowed down to
    it as a whole (`pace`). The correction has most of the reserve; what is left lets the pace change.

    It starts at rest, at the pace that the first step asks for; held from then on, no joint moves.
    """

    def __init__(self, trajectory: Trajectory, machine: Machine | Limits, **figures: Any) -> None:
        """Keyword arguments are the fields of follow.figures.Figures. Raises UsageError.

        Of Limits in place of a machine only the pace follows: without kinematics nothing can be measured of a tool. All
        of the reserve is then for changes of pace. Rows of one's own of the plan are not kept where the pace changes.
        """
        names = Figures.__dataclass_fields__
        for name in figures:
            if name not in names:
                raise UsageError(f"follower: unknown argument '{name}'; {did_you_mean(name, names)}")
        if not isinstance(trajectory, Trajectory):
            raise UsageError(
                f"follower: {type(trajectory).__name__} in place of a trajectory; give what plan returns"
            )
        check_at_rest(trajectory)
        driven, checked = followed_joints_of(machine, trajectory.joints), Figures(**figures)
        pace = pace_within(trajectory, driven, 1.0 - checked.reserve)
        samples = samples_of(trajectory, driven, checked.period, pace)
        self._take(law_of(samples, driven, checked, pace))
        second, third = (float(np.abs(np.diff(samples.q, k, axis=0)).max(initial=0.0)) for k in (2, 3))
        # between samples a second derivative is larger by what it changes from one to the next
        self.off_the_plan = (second + third) / 6.0
        """Most that the path followed leaves the plan by [m or rad]."""

    @classmethod
    def from_folder(
        cls, folder: str | os.PathLike[str], machine: Machine | Limits | None = None, **figures: Any
    ) -> Follower:
        """A follower of the plan in a folder that `toolpace plan --out` wrote, as Trajectory.load reads it.

        The machine is that of the folder unless one is given: plan on a machine with reserved limits and give the one
        that has all of them, or the plan is slowed down. Set-points of the plan are the samples of the path, which
        leaves them by `off_the_plan`: by a micrometre or two at steps of 1 ms, sixteen times less at a quarter of it.
        Raises UsageError.
        """
        trajectory = Trajectory.load(folder)
        driven = machine if machine is not None else trajectory.axis_path.machine
        assert driven is not None
        return cls(trajectory, driven, **figures)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Follower:
        """The follower that `save` wrote. Raises UsageError for what is no such file, or a damaged one."""
        follower = cls.__new__(cls)
        follower._take(read_law(path))
        follower.off_the_plan = math.nan
        return follower

    def _take(self, piece: Floats) -> None:
        self.piece = piece
        """Path, machine and figures as the kernel takes them: see kernels/follow/layout.py."""
        self.state = np.zeros(layout.STATE)
        """What the kernel remembers."""
        self.pace = float(piece[layout.NOMINAL])
        """Share of the plan's own pace that leaves the reserve; 1 where it was planned with it."""
        self.duration = float(piece[layout.DURATION])
        """Of the path without override [s]."""
        self.period = float(piece[layout.PERIOD])
        """Time between two set-points [s]."""
        self._used = int(piece[layout.USED])
        self._has_machine = bool(piece[layout.FRAME : layout.GROUP].any())
        self._input, self._out = np.full(layout.INPUTS, np.nan), np.empty(layout.OUTPUTS)
        self.reset()

    def __repr__(self) -> str:
        return one_line(self, f"{self.duration:.6g} s", f"a set-point every {self.period:g} s")

    @property
    def feed_excess(self) -> float:
        """Share of the feed by which a correction may make the tip faster than feed times override.

        For a moment while it moves, and by up to 2 percent for as long as it stands on a table that turns: for more
        than that the pace is lowered, ahead of the turning. Where joints are found displaced on a table that turns,
        the displacement is carried at once, until the pace has come down.
        """
        from toolpace.kernels.follow.step import LEAST

        turning = 2.0 if self.piece[layout.MOST_TURN] > 0.0 else 0.0
        return (math.sqrt(3.0) + turning) * float(self.piece[layout.FEED_SHARE]) + LEAST

    def reset(self) -> None:
        """Go back to the start of the path, at rest, without correction."""
        self.state[:] = 0.0

    def step(self, measurement: Measurement | None = None, feed: float = 1.0) -> SetPoint:
        """The next set-point; `feed` is the operator's override, 0 (hold) to 1.2.

        What is above or below is cut, and the status says so: Status.OVERRIDE_CUT. Raises UsageError for a measurement
        or a feed that is not made of numbers, or of a wrong shape, or for a measurement with a time beside a
        `dead_time`, and for nothing else.
        """
        from toolpace.kernels.follow.step import step

        if measurement is None:
            measurement = NOTHING
        if not isinstance(measurement, Measurement):
            raise UsageError(f"step: {type(measurement).__name__} in place of a measurement; give Measurement(t, ...)")
        if measurement is not NOTHING and not self._has_machine:
            raise UsageError(
                "step: a follower of limits alone knows no tool; give a Machine to correct what is measured"
            )
        override = number(feed)
        if override is None:
            raise UsageError(f"step: feed is {feed!r:.60}; give a share from 0 to 1.2")
        measurement.write(self._input, float(self.state[layout.NOW]), float(self.piece[layout.DEAD_TIME]))
        self._input[layout.OVERRIDE] = override
        step(self.piece, self.state, self._input, self._out)
        out = self._out
        q, qd, qdd, qddd = out[layout.Q : layout.OUT_CORRECTION].reshape(4, -1)[:, : self._used].copy()
        return SetPoint(
            float(out[layout.AT]),
            q,
            qd,
            qdd,
            qddd,
            float(out[layout.PARAMETER]),
            float(out[layout.PATH_TIME]),
            float(out[layout.OUT_PACE]),
            out[layout.OUT_CORRECTION :].reshape(4, -1)[:, : self._used].copy(),
            Status(int(out[layout.STATUS])),
        )

    def resume(self) -> None:
        """Go on after a stop for a correction at its limit."""
        self.state[layout.STOPPED] = self.state[layout.FULL_FOR] = 0.0

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write path, machine and figures as one flat file of float64, for control code: kernels/follow/layout.py."""
        write_law(path, self.piece)


def check_at_rest(trajectory: Trajectory) -> None:
    """Raise UsageError where a trajectory begins in motion, as one that was replanned does."""
    speed = np.abs(trajectory.at([0.0]).qd[0])
    if (speed > MOVES).any():
        joint = trajectory.joints[int(np.argmax(speed))]
        raise UsageError(
            f"follower: the trajectory begins in motion, {joint} at {speed.max():.3g} m/s or rad/s, and a follower"
            " starts at rest; give what plan returns, not replan: a follower corrects what it is told of a deflection"
        )


def pace_within(trajectory: Trajectory, driven: FollowedJoints, share: float) -> float:
    """The steady pace at which a trajectory uses no more than a share of each limit."""
    used, limits = trajectory.usage(), driven.limits[:, : driven.used]
    worst = []
    for kind, of_plan, own in (
        (used.velocity, trajectory.limits.velocity, limits[0]),
        (used.acceleration, trajectory.limits.acceleration, limits[1]),
        (used.jerk, trajectory.limits.jerk, limits[2]),
    ):
        with np.errstate(invalid="ignore"):
            ratio = np.array(list(kind.values())) * of_plan / (own * share)
        # a velocity without a limit uses nothing of it
        worst.append(float(np.where(np.isinf(own), 0.0, ratio).max()))
    if not np.isfinite(worst).all():
        raise UsageError("follower: accelerations jump in this plan, so that no jerk limit holds; plan with optimal")
    # what looks and rounding leave a plan on machine.reserved above its limits is no reason to slow it down
    return min(ratio ** (-1.0 / power) if ratio > 1.0 + ROUNDING else 1.0 for power, ratio in enumerate(worst, 1))
