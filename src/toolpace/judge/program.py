"""The motion against the program: nearness both ways and in order, feeds, least times, stops and dwells."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from toolpace.arrays import Floats, Ints
from toolpace.judge.motion import TOLERANCE, still_step
from toolpace.judge.rows import Matched, bends_of, program_line, running_length
from toolpace.judge.verification import Check
from toolpace.machine.machine import Machine
from toolpace.setpoints import SetPoints
from toolpace.toolpath import ToolPath

DOUBT = 2.0
"""How far along the program a place is uncertain [tolerances]: feeds change and blocks end within this."""
GRACE = 1e-3
"""Share of a tolerance granted for the rounding of arcs and rotations into short chords by reader and
judge."""
SPACING = 0.25
"""Distance below which set-points are left out of the row that the program is matched with [tolerances]."""


@dataclass(frozen=True)
class ProgramJudgement:
    """The checks, and the largest deviations of both directions."""

    checks: list[Check]
    tip_deviation: float
    axis_deviation: float


def program_checks(
    points: SetPoints,
    machine: Machine,
    toolpath: ToolPath,
    tip: Floats,
    axis: Floats,
    tip_tolerance: float,
    axis_tolerance: float,
    dt: float,
) -> ProgramJudgement:
    """Judge set-points, with their forward kinematics `tip` and `axis`, against the program."""
    from toolpace.kernels.judge.distance import match, thinned

    line, owner = program_line(toolpath, machine, tip_tolerance, axis_tolerance)
    # Set-points that stand still add nothing to a distance, but a long dwell would be walked over again and
    # again.
    poses = np.hstack((tip / tip_tolerance, axis / axis_tolerance))
    kept = np.flatnonzero(np.concatenate(([True], (points.q[1:] != points.q[:-1]).any(axis=1))))
    if len(kept) < 2:
        kept = np.array([0, len(points) - 1])
    moving = poses[kept]
    line_place = running_length(line)
    there = Matched.empty(len(moving))
    match(moving, line, np.zeros((len(line) - 1, 6)), line_place, *there.arrays)
    # A slow motion has hundreds of set-points within a tolerance; a few there are enough to come near.
    few = np.empty(len(moving), dtype=np.int64)
    few = few[: thinned(moving, SPACING, few)]
    chain, stations = moving[few], kept[few]
    chain_place = running_length(chain)
    back = Matched.empty(len(line))
    match(line, chain, bends_of(chain, points.t[stations], dt), chain_place, *back.arrays)

    judge = _Judge(points, toolpath, stations, owner, tip_tolerance, axis_tolerance, dt)
    checks = judge.nearness(there, back, kept)
    near = not any(not check.ok for check in checks)
    checks += judge.feeds(tip, kept, there.place(line_place), line_place)
    if near:
        # Times at program points mean something only on a motion that passes them.
        checks += judge.times(back.place(chain_place), chain_place, _still(points, machine, dt))
    worst_tip = max(float(there.tip.max()), float(back.tip.max())) * tip_tolerance
    worst_axis = max(float(there.axis.max()), float(back.axis.max())) * axis_tolerance
    return ProgramJudgement(checks, worst_tip, _angle(worst_axis))


@dataclass(frozen=True)
class _Judge:
    """What all comparisons with a program share."""

    points: SetPoints
    toolpath: ToolPath
    stations: Ints
    """Set-points of the chain that the program's points are looked for on."""
    owner: Ints
    """Program point of each point of the line."""
    tip_tolerance: float
    axis_tolerance: float
    dt: float

    def nearness(self, there: Matched, back: Matched, kept: Ints) -> list[Check]:
        """Both directions, tip and axis, and both ends."""
        points, blocks = self.points, self.toolpath.block
        checks = []
        forth_points, forth_owners = kept, self.owner[there.segment + 1]
        back_points, back_owners = self.stations[back.segment], self.owner
        for way, matched, at, owners in (
            ("set-points to program", there, forth_points, forth_owners),
            ("program to set-points", back, back_points, back_owners),
        ):
            for part, off, tolerance, unit in (
                ("tip", matched.tip, self.tip_tolerance, "m"),
                ("axis", matched.axis, self.axis_tolerance, "rad"),
            ):
                k = int(np.argmax(off))
                value = float(off[k]) * tolerance
                value = _angle(value) if part == "axis" else value
                ok = value <= tolerance * (1.0 + GRACE)
                time, block = float(points.t[at[k]]), int(blocks[owners[k]])
                checks.append(Check(f"{part}, {way}", value, tolerance, unit, ok, time, block))
        # The last program point may lie near the end of the motion and yet not be where it ends.
        last = there.segment[-1] + there.fraction[-1]
        left = float(np.abs(self.owner[-1] - self.owner[min(there.segment[-1] + 1, len(self.owner) - 1)]))
        if left > 0.0 and last < len(self.owner) - 1:
            remaining = int(self.owner[there.segment[-1] + 1])
            time, block = float(points.t[-1]), int(blocks[remaining])
            if max(there.tip[-1], there.axis[-1]) <= 1.0 and not self._ends_near(there):
                note = f"the motion ends {int(left)} points before the program does"
                checks.append(Check("end of the program", left, 0.0, "", False, time, block, note=note))
        return checks

    def _ends_near(self, there: Matched) -> bool:
        """Whether all that is left of the program lies within tolerance of the last set-point."""
        rest = self.toolpath.tip[self.owner[there.segment[-1] + 1] :]
        off = np.sqrt(((rest - rest[-1]) ** 2).sum(axis=1))
        return bool(off.max() <= 4.0 * self.tip_tolerance)

    def feeds(self, tip: Floats, kept: Ints, place: Floats, line_place: Floats) -> list[Check]:
        """The speed of the tip against the feed of the blocks within DOUBT of the place."""
        from toolpace.kernels.judge.distance import largest_between

        first, second = kept[:-1], kept[1:]
        # The chain leaves out set-points that stand still; a step of it ends at `second` and took one time
        # step.
        moved = np.sqrt(((tip[second] - tip[second - 1]) ** 2).sum(axis=1))
        steps = self.points.t[second] - self.points.t[second - 1]
        speed = moved / steps
        low = np.minimum(place[:-1], place[1:]) - DOUBT
        high = np.maximum(place[:-1], place[1:]) + DOUBT
        cap = np.empty(len(speed))
        largest_between(low, high, line_place, self.toolpath.feed[self.owner[1:]], cap)
        noise = 8.0 * float(np.finfo(np.float64).eps) * max(float(np.abs(tip).max()), 1.0) / steps
        over = np.where(np.isfinite(cap), (speed - noise) / cap, 0.0)
        if not len(over) or not np.isfinite(cap).any():
            return []
        k = int(np.argmax(over))
        ok = bool(over[k] <= 1.0 + TOLERANCE)
        time, block = float(self.points.t[first[k]]), int(self.points.block[second[k]])
        return [Check("feed", float(speed[k]), float(cap[k]), "m/s", ok, time, block, noise=float(noise[k]))]

    def times(self, crossing: Floats, chain_place: Floats, still: npt.NDArray[np.bool_]) -> list[Check]:
        """Least times, stops and dwells, from the times at which the motion passes the program points."""
        # Time as a function of running length, earliest and latest, with the doubt about the place of a
        # block's end.
        t, last = self.points.t, len(self.points) - 1
        ends = np.flatnonzero(np.concatenate((np.diff(self.owner) > 0, [True])))
        at = crossing[ends]
        early = self.stations[np.maximum(np.searchsorted(chain_place, at - DOUBT, side="left") - 1, 0)]
        late_chain = np.searchsorted(chain_place, at + DOUBT, side="right")
        # Up to the set-point before the chain's next one, so that standing still counts to the point it
        # happens at.
        after = self.stations[np.minimum(late_chain, len(self.stations) - 1)]
        late = np.where(late_chain < len(self.stations), after, last)
        return self._least_times(t[early], t[late]) + self._stops(early, late, still)

    def _least_times(self, early: Floats, late: Floats) -> list[Check]:
        """Any stretch of whole blocks takes at least the sum of their least times: the worst one is a
        drawdown."""
        least = np.where(np.isfinite(self.toolpath.least_time), self.toolpath.least_time, 0.0)
        if not (least > 0.0).any() or len(least) != len(early):
            return []
        due = np.cumsum(least)
        ahead = np.maximum.accumulate(early - due)
        short = ahead[:-1] - (late[1:] - due[1:])
        j = int(np.argmax(short)) + 1
        i = int(np.argmax((early - due)[:j]))
        value, limit = float(late[j] - early[i]), float(due[j] - due[i])
        ok = value >= limit * (1.0 - TOLERANCE) - 1e-12
        block = int(self.toolpath.block[j])
        note = f"time for blocks {int(self.toolpath.block[i + 1])} to {block}"
        return [Check("least time", value, limit, "s", ok, float(early[i]), block, note=note, at_least=True)]

    def _stops(self, early: Ints, late: Ints, still: npt.NDArray[np.bool_]) -> list[Check]:
        """Near each program point with a stop a step without motion; near each dwell enough of them."""
        stops = np.flatnonzero(self.toolpath.stop | (self.toolpath.dwell > 0.0))
        stops = stops[(stops > 0) & (stops < len(early) - 1) | (self.toolpath.dwell[stops] > 0.0)]
        stops = stops[stops < len(early)]
        if not len(stops):
            return []
        longest = np.zeros(len(stops))
        for k, stop in enumerate(stops):
            low, high = int(early[stop]), int(late[stop])
            while high < len(still) and still[high]:
                high += 1
            longest[k] = _longest_run(still[low:high]) * self.dt
        need = self.toolpath.dwell[stops]
        t = self.points.t
        checks = []
        if (self.toolpath.stop[stops] & (need <= 0.0)).any() or (longest <= 0.0).any():
            k = int(np.argmin(longest))
            ok = bool(longest[k] > 0.0)
            time, block = float(t[early[stops[k]]]), int(self.toolpath.block[stops[k]])
            note = "" if ok else "the program stops here, the motion runs on"
            found = float(longest[k])
            checks.append(Check("stillness at stops", found, self.dt, "s", ok, time, block, note=note, at_least=True))
        if (need > 0.0).any():
            k = int(np.argmax(need - longest))
            # Sampling may hide the first and the last step of a dwell.
            ok = bool(longest[k] >= need[k] - 2.0 * self.dt)
            time, block = float(t[early[stops[k]]]), int(self.toolpath.block[stops[k]])
            found, least = float(longest[k]), float(need[k])
            noise = 2.0 * self.dt
            checks.append(Check("dwell", found, least, "s", ok, time, block, at_least=True, noise=noise))
        return checks


def _still(points: SetPoints, machine: Machine, dt: float) -> npt.NDArray[np.bool_]:
    """(n - 1,) whether a step is no longer than the first one out of rest can be, twice over."""
    most = 8.0 * still_step(machine.limits, dt) + 8.0 * float(np.finfo(np.float64).eps) * np.maximum(
        np.abs(points.q).max(axis=0), 1.0
    )
    still: npt.NDArray[np.bool_] = (np.abs(np.diff(points.q, axis=0)) <= most).all(axis=1)
    return still


def _longest_run(flags: npt.NDArray[np.bool_]) -> int:
    """The longest run of true values."""
    edges = np.flatnonzero(np.diff(np.concatenate(([False], flags, [False])).astype(np.int8)))
    return int((edges[1::2] - edges[::2]).max()) if len(edges) else 0


def _angle(chord: float) -> float:
    """The angle between two unit vectors, from the length of the chord."""
    return 2.0 * math.asin(min(chord / 2.0, 1.0))
