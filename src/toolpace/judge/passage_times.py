"""The times at which a motion passes the program's points, with checks of least times, stops, dwells and operations.

Between which times a point is passed is known to what the tolerances leave open; where an operation begins and ends
at such a point, its time is known to that.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from toolpace.common.arrays import Floats, Ints
from toolpace.common.errors import printable
from toolpace.judge.alignment.sections import Section
from toolpace.judge.motion import TOLERANCE
from toolpace.judge.seen_motion import SeenMotion, still_step
from toolpace.judge.usage import wrong
from toolpace.judge.verification import Check
from toolpace.machine.machine import Machine
from toolpace.programs.toolpath import ToolPath

HIDDEN = 2
"""Steps of a dwell that sampling may hide: its first and its last."""
PASSING = 0.01
"""Share of a time step to which it is known when a place is passed."""
CREEP = 1e-3
"""Share of the first step out of rest that counts as standing still in a dwell."""
SAME = 1e-9
"""Share of the duration to which sums agree."""


@dataclass(frozen=True)
class Passing:
    """When the motion can pass the points of the program, in order, and between which set-points it can be at those
    that it waits at."""

    seen: SeenMotion
    toolpath: ToolPath
    early: Floats
    """(p,) the earliest time of each point [s]."""
    late: Floats
    """(p,) the latest one [s]."""
    stays: Mapping[int, Floats]
    """(k, 2) of each point that `waiting` names, in steps from set-point to set-point and shares of them."""

    def passages(self) -> Passages:
        """Between which times each point can be passed, in order."""
        return Passages(np.maximum.accumulate(self.early), np.minimum.accumulate(self.late[::-1])[::-1])

    def least_times(self, dt: float) -> list[Check]:
        """Any stretch of whole blocks takes at least the sum of their least times: the worst one is a drawdown."""
        least = np.where(np.isfinite(self.toolpath.least_time), self.toolpath.least_time, 0.0)
        if not (least > 0.0).any():
            return []
        early, late = self.early, self.late
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
        dwell, stops = self.toolpath.dwell, waiting(self.toolpath)
        if not len(stops):
            return []
        # The step that holds a rest for an instant is at most the first one out of rest; within a dwell nothing moves.
        rests = still_runs(self.seen, machine, dt, 1.0 + TOLERANCE)
        waits = still_runs(self.seen, machine, dt, CREEP)
        found, at = np.zeros(len(stops)), np.zeros(len(stops))
        used = 0.0  # the set-point up to which standing still has been counted
        for k, stop in enumerate(stops):
            # What may be hidden whole shows as a stop for an instant does.
            shows = float(dwell[stop]) >= HIDDEN * dt
            need = max(float(dwell[stop]) / dt - HIDDEN, 1.0)
            begin, most = self.longest(self.stays[int(stop)], waits if shows else rests, used, need - 1e-6)
            found[k], at[k] = most * dt, self.seen.time(min(int(begin), len(self.seen) - 1))
            if shows:
                used = max(used, begin + min(most, need))
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

    def longest(self, stays: Floats, runs: Ints, counted: float, enough: float) -> tuple[float, float]:
        """The first stretch of standing still [set-points] within `stays` (k, 2) that is long enough, else the longest:
        its begin, and the number of steps. None of it lies before `counted`.

        A step counts where its begin or its end can stand for the point.
        """
        best, begin = 0.0, counted
        for low, high in stays:
            r = int(np.searchsorted(runs[:, 1], max(low, counted), side="left"))
            while r < len(runs) and runs[r, 0] <= high:
                first = max(float(runs[r, 0]), np.floor(low), counted)
                last = min(float(runs[r, 1]), np.ceil(high))
                if last - first > best:
                    best, begin = last - first, first
                if best >= enough:
                    return begin, best
                r += 1
        if best == 0.0:
            begin = max(float(stays[0, 0]), counted)
        return begin, best


def waiting(toolpath: ToolPath) -> Ints:
    """(k,) points of a program at which a motion waits: stops and dwells, of its ends dwells alone."""
    waits = toolpath.stop | (toolpath.dwell > 0.0)
    waits[[0, -1]] = toolpath.dwell[[0, -1]] > 0.0
    return np.flatnonzero(waits)


class SectionPassages(NamedTuple):
    """When a section can be at the poses of its part of the program."""

    early: Floats
    """(m,) [s], infinite of poses that it cannot be at."""
    late: Floats
    """(m,) [s], the same with the other sign."""
    stays: Mapping[int, Floats]
    """(k, 2) as in `Passing`, of the whole motion; of some of the poses."""

    @classmethod
    def of(cls, section: Section, poses: Ints) -> SectionPassages:
        """That of a section, with the stays at `poses` (k,) of its part."""
        motion, back = section.motion, section.found.back
        some = np.flatnonzero(back.begin[1:] > back.begin[:-1])
        early, late = np.full(len(back.place), np.inf), np.full(len(back.place), -np.inf)
        early[some] = motion.times(back.low[back.begin[some]], latest=False)
        late[some] = motion.times(back.high[back.begin[some + 1] - 1], latest=True)
        stays = {}
        for pose in poses.tolist():
            part = slice(back.begin[pose], back.begin[pose + 1])
            times = (motion.times(back.low[part], latest=False), motion.times(back.high[part], latest=True))
            stays[pose] = section.begin + np.column_stack([_setpoints(section.steps.t, each) for each in times])
        return cls(early, late, stays)


def _setpoints(t: Floats, times: Floats) -> Floats:
    """Steps from set-point to set-point, which come at t (n,), and shares of the next one that have passed at times
    (k,)."""
    k: Ints = np.clip(np.searchsorted(t, times, side="right") - 1, 0, len(t) - 2)
    return np.asarray(k + np.minimum((times - t[k]) / (t[k + 1] - t[k]), 1.0))


def joined_stays(before: Floats, behind: Floats) -> Floats:
    """(k, 2) stays of two sections in a row: what ends where the first of the others begins goes on there."""
    if len(before) and len(behind) and behind[0, 0] <= before[-1, 1]:
        before, behind = before.copy(), behind.copy()
        behind[0, 0] = before[-1, 0]
        before = before[:-1]
    return np.concatenate((before, behind))


def still_runs(seen: SeenMotion, machine: Machine, dt: float, share: float) -> Ints:
    """(k, 2) first and last set-point of each stretch in which no step is longer than a share of the first one out of
    rest."""
    rounding = 8.0 * float(np.finfo(np.float64).eps) * np.maximum(seen.peaks.position, 1.0)
    most = share * still_step(machine.limits.largest, dt) + rounding
    still = seen.still.step[(seen.still.moved <= most).all(axis=1)]
    first = still[np.diff(still, prepend=-2) > 1]
    last = still[np.diff(still, append=len(seen) + 1) > 1]
    return np.column_stack((first, last + 1))


@dataclass(frozen=True)
class Passages:
    """Between which times the motion can be at each point of the program."""

    early: Floats
    """(n,) [s]"""
    late: Floats
    """(n,) [s]"""


@dataclass(frozen=True)
class OperationFigures:
    """The operations of plan.json, and what they are judged by."""

    said: Mapping[str, Any]
    """plan.json, key by key."""
    toolpath: ToolPath
    passages: Passages | None
    """None where the motion is not that of the program."""
    dt: float
    """[s]"""

    def checks(self) -> list[Check]:
        """Names, tools, stops and dwells as the program has them; times within what is known; sums."""
        said = self.said["operations"]
        path, count = self.toolpath, len(self.toolpath.operations)
        dwell = np.bincount(path.operation, path.dwell, count)
        stops = np.bincount(path.operation[1:-1], path.stop[1:-1], count)
        ways = np.bincount(path.operation[1:], minlength=count)
        listed = [k for k in range(count) if ways[k] or dwell[k] > 0.0]
        right = [(printable(path.operations[k].name), printable(path.operations[k].tool)) for k in listed]
        if [(each["name"], each["tool"]) for each in said] != right:
            return [wrong("operations", f"are not the {len(right)} of the program, in its order, with their tools")]
        checks = self._sums()
        for k, each in zip(listed, said):
            if each["stops"] != int(stops[k]) or abs(each["dwell_s"] - dwell[k]) > SAME * (1.0 + dwell[k]):
                note = f"the program has {int(stops[k])} stops and {dwell[k]:g} s of dwells in operation {k + 1}"
                checks.append(wrong("operations", note))
        if self.passages is not None:
            checks += self._times(listed)
        return checks

    def _sums(self) -> list[Check]:
        """Each operation is the sum of its parts, all of them are the totals, and these the duration."""
        said, duration = self.said["operations"], float(self.said["duration_s"])
        kinds = ("cutting_s", "rapid_s", "dwell_s")
        pairs = [(each["time_s"], sum(each[kind] for kind in kinds)) for each in said]
        pairs += [(_number(self.said[kind]), sum(each[kind] for each in said)) for kind in kinds]
        pairs.append((duration, sum(_number(self.said[kind]) for kind in kinds)))
        off = [abs(a - b) for a, b in pairs]
        ok = all(value <= SAME * max(duration, 1.0) for value in off) and all(
            each[kind] >= -SAME for each in said for kind in kinds
        )
        return [
            wrong("operations", "parts sum up to the duration" if ok else "parts do not sum up, or are negative", ok)
        ]

    def _times(self, listed: list[int]) -> list[Check]:
        """Time at feed and at rapid of each operation, against the least and the most that it can be; the worst."""
        least, most = self._bounds()
        worst, check = -np.inf, wrong("operations", "no operation moves", True)
        for row, kind in enumerate(("cutting_s", "rapid_s")):
            for k, each in zip(listed, self.said["operations"]):
                value, low, high = float(each[kind]), float(least[row, k]), float(most[row, k])
                beyond = max(low - value, value - high)
                if beyond > worst or not np.isfinite(value):
                    worst = beyond
                    name = each["name"] or each["tool"] or str(k + 1)
                    note = f"{kind} of operation {name}, from {low:.6g} s to {high:.6g} s"
                    check = Check("plan.json operations", value, high, "s", bool(beyond <= 0.0), note=note)
        return [check]

    def _bounds(self) -> tuple[Floats, Floats]:
        """(2, operations) least and most time at feed and at rapid."""
        path, passages = self.toolpath, self.passages
        assert passages is not None
        count, last = len(path.operations), len(path) - 1
        kind: Ints = path.operation[1:] + count * path.rapid[1:]
        first = np.flatnonzero(np.concatenate(([True], np.diff(kind) != 0)))
        begin, end = first, np.concatenate((first[1:], [last]))
        # A point that is waited at is there from its arrival to its departure.
        duration, dwell = float(self.said["duration_s"]), path.dwell
        noise = PASSING * self.dt
        early, late = passages.early - noise, passages.late + noise
        leave_first, leave_last = early + dwell, late.copy()
        come_first, come_last = early.copy(), late - dwell
        leave_first[0] = leave_last[0] = dwell[0]
        come_first[last] = come_last[last] = duration - dwell[last]
        waited = np.cumsum(dwell)
        inside = waited[end] - dwell[end] - waited[begin]
        rounding = 1e-12 * duration
        least = np.maximum(come_first[end] - leave_last[begin] - inside, 0.0) - rounding
        most = np.maximum(come_last[end] - leave_first[begin] - inside, 0.0) + rounding
        lowest, highest = np.zeros(2 * count), np.zeros(2 * count)
        np.add.at(lowest, kind[first], least)
        np.add.at(highest, kind[first], most)
        return lowest.reshape(2, count), highest.reshape(2, count)


def _number(value: float | None) -> float:
    return float("nan") if value is None else float(value)
