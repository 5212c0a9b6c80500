"""The follower: a plan played live, with correction and change of pace."""

from __future__ import annotations

import math
import os
from typing import Any

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.common.errors import UsageError, did_you_mean
from toolpace.common.value_objects import one_line
from toolpace.deflection.following.figures import Figures, number
from toolpace.deflection.following.law import law_of, read_law, write_law
from toolpace.deflection.following.samples import FollowedJoints, followed_joints_of, samples_of
from toolpace.deflection.following.signals import Measurement, SetPoint, Status
from toolpace.kernels.follow import layout
from toolpace.machine.limits import Limits
from toolpace.machine.machine import Machine
from toolpace.motion.trajectory import Trajectory

ROUNDING = 2e-4
"""Share of a limit by which a plan may be said to pass it."""
MOVES = 1e-6
"""Velocity of a joint with which a plan begins in motion [m/s, rad/s]: more than rounding, less than anybody sees."""
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
        of the reserve is then for changes of pace.
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
        self._given, self._out = np.full(layout.INPUTS, np.nan), np.empty(layout.OUTPUTS)
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
        measurement.write(self._given, float(self.state[layout.NOW]), float(self.piece[layout.DEAD_TIME]))
        self._given[layout.OVERRIDE] = override
        step(self.piece, self.state, self._given, self._out)
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
