"""The times at which the motion passes the program's points: least times, stops, dwells."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from toolpace.common.arrays import Floats, Ints
from toolpace.judge.matching.alignment import Alignment
from toolpace.judge.motion import TOLERANCE, still_step
from toolpace.judge.operations import Passages
from toolpace.judge.rows import MotionRow
from toolpace.judge.verification import Check
from toolpace.machine.machine import Machine
from toolpace.motion.setpoints import SetPoints
from toolpace.programs.toolpath import ToolPath

HIDDEN = 2
"""Steps of a dwell that sampling may hide: its first and its last."""
PASSING = 0.01
"""Share of a time step to which it is known when a place is passed."""
CREEP = 1e-3
"""Share of the first step out of rest that counts as standing still in a dwell."""


@dataclass(frozen=True)
class Passing:
    """Places of the motion at which each point of the program can be passed, in order."""

    points: SetPoints
    toolpath: ToolPath
    motion: MotionRow
    back: Alignment
    line: Ints
    """Pose of the program's line that each program point is."""

    def passages(self) -> Passages:
        """Between which times each point can be passed, in order."""
        early = self.motion.times(self.back.first[self.line], latest=False)
        late = self.motion.times(self.back.last[self.line], latest=True)
        return Passages(np.maximum.accumulate(early), np.minimum.accumulate(late[::-1])[::-1])

    def least_times(self, dt: float) -> list[Check]:
        """Any stretch of whole blocks takes at least the sum of their least times: the worst one is a drawdown."""
        least = np.where(np.isfinite(self.toolpath.least_time), self.toolpath.least_time, 0.0)
        if not (least > 0.0).any():
            return []
        early = self.motion.times(self.back.first[self.line], latest=False)
        late = self.motion.times(self.back.last[self.line], latest=True)
        due = np.cumsum(least)
        ahead = np.maximum.accumulate(early - due)
        short = ahead[:-1] - (late[1:] - due[1:])
        j = int(np.argmax(short)) + 1
        i = int(np.argmax((early - due)[:j]))
        value, limit = float(late[j] - early[i]), float(due[j] - due[i])
        noise = PASSING * dt
        ok = value >= limit * (1.0 - TOLERANCE) - noise
        block = int(self.toolpath.block[j])
        note = f"time for blocks {int(self.toolpath.block[i + 1])} to {block}"
        return [
            Check("least time", value, limit, "s", ok, float(early[i]), block, note=note, at_least=True, noise=noise)
        ]

    def stops(self, machine: Machine, dt: float) -> list[Check]:
        """At each program point with a stop a step of rest; at each dwell enough without motion, one after another."""
        dwell = self.toolpath.dwell
        asked = self.toolpath.stop | (dwell > 0.0)
        asked[[0, -1]] = dwell[[0, -1]] > 0.0
        stops = np.flatnonzero(asked)
        if not len(stops):
            return []
        # The step that holds a rest for an instant is at most the first one out of rest; within a dwell nothing moves.
        rests = still_runs(self.points, machine, dt, 1.0 + TOLERANCE)
        waits = still_runs(self.points, machine, dt, CREEP)
        found, at = np.zeros(len(stops)), np.zeros(len(stops))
        known = 0.0  # the set-point up to which standing still has been counted
        for k, stop in enumerate(stops):
            # What may be hidden whole shows as a stop for an instant does.
            shows = float(dwell[stop]) >= HIDDEN * dt
            need = max(float(dwell[stop]) / dt - HIDDEN, 1.0)
            begin, most = self.longest(self.line[stop], waits if shows else rests, known, need - 1e-6)
            found[k], at[k] = most * dt, self.points.t[min(int(begin), len(self.points) - 1)]
            if shows:
                known = max(known, begin + min(most, need))
        return self._judged(stops, found, at, dt)

    def _judged(self, stops: Ints, found: Floats, at: Floats, dt: float) -> list[Check]:
        """The worst stop and the worst dwell."""
        checks = []
        need = self.toolpath.dwell[stops]
        moving = (need <= 0.0) | (found <= 0.0)
        if moving.any():
            k = int(np.flatnonzero(moving)[np.argmin(found[moving])])
            ok = bool(found[k] > 0.0)
            block = int(self.toolpath.block[stops[k]])
            note = "" if ok else "the program stops here, the motion runs on"
            checks.append(
                Check("stillness at stops", float(found[k]), dt, "s", ok, float(at[k]), block, note=note, at_least=True)
            )
        if (need > 0.0).any():
            k = int(np.argmax(np.where(need > 0.0, need - found, -np.inf)))
            noise = HIDDEN * dt
            value, limit = float(found[k]), float(need[k])
            ok = value >= limit - noise * (1.0 + 1e-6)
            block = int(self.toolpath.block[stops[k]])
            checks.append(Check("dwell", value, limit, "s", ok, float(at[k]), block, at_least=True, noise=noise))
        return checks

    def longest(self, pose: int, runs: Ints, known: float, enough: float) -> tuple[float, float]:
        """The first stretch of standing still [set-points] at a pose of the program's line that is long enough, else
        the longest: its begin, and the number of steps. None of it lies before `known`.

        A step counts where its begin or its end can stand for the pose.
        """
        best, begin = 0.0, known
        for i in range(self.back.begin[pose], self.back.begin[pose + 1]):
            low, high = self.setpoint(self.back.low[i], latest=False), self.setpoint(self.back.high[i], latest=True)
            r = int(np.searchsorted(runs[:, 1], max(low, known), side="left"))
            while r < len(runs) and runs[r, 0] <= high:
                first = max(float(runs[r, 0]), np.floor(low), known)
                last = min(float(runs[r, 1]), np.ceil(high))
                if last - first > best:
                    best, begin = last - first, first
                if best >= enough:
                    return begin, best
                r += 1
        if best == 0.0:
            begin = max(self.setpoint(self.back.first[pose], latest=False), known)
        return begin, best

    def setpoint(self, place: float, *, latest: bool) -> float:
        """Steps from set-point to set-point, and a share of the next one, that have passed at a place of the motion."""
        time = float(self.motion.times(np.array([place]), latest=latest)[0])
        t = self.points.t
        k = min(int(np.searchsorted(t, time, side="right")) - 1, len(t) - 2)
        return k + min((time - float(t[k])) / float(t[k + 1] - t[k]), 1.0)


def still_runs(points: SetPoints, machine: Machine, dt: float, share: float) -> Ints:
    """(k, 2) first and last set-point of each stretch in which no step is longer than a share of the first one out of
    rest."""
    rounding = 8.0 * float(np.finfo(np.float64).eps) * np.maximum(np.abs(points.q).max(axis=0), 1.0)
    most = share * still_step(machine.limits, dt) + rounding
    still = (np.abs(np.diff(points.q, axis=0)) <= most).all(axis=1)
    edges = np.flatnonzero(np.diff(np.concatenate(([False], still, [False])).astype(np.int8)))
    return np.column_stack((edges[::2], edges[1::2]))
