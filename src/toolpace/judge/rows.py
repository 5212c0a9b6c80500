"""The program and the motion as rows of poses in units of the tolerances."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from toolpace.common.arrays import Bools, Floats, Ints
from toolpace.judge.seen_motion import each_block
from toolpace.machine.limits import Limits
from toolpace.machine.machine import Machine
from toolpace.motion.setpoints import Block, SetPoints
from toolpace.programs.toolpath import ToolPath

CHORD = 5e-4
"""Most distance of a chord from the curve of motion or tool axis that it stands for [tolerances]."""
TURN = 0.2
"""Turn of a joint between two places at which the tool axis is looked at to see how it curves [rad]."""
MOST_PIECES = 10_000
"""Most chords for one block."""
MOST_PARTS = 64
"""Most chords for the motion between two set-points."""
UNSEEN = 0.1
"""Share of a fourth difference by which a cubic through four set-points may miss the motion between them: 0.05 where
a jerk jumps, 0.065 where an acceleration does."""
MOST_UNSEEN = 0.5
"""Most that is granted for it [tolerances]."""


def program_line(
    toolpath: ToolPath, machine: Machine, tip_tolerance: float, axis_tolerance: float
) -> tuple[Floats, Ints]:
    """The program as a row of poses (m, 6) in tolerances, and for each the program point that it is or leads to.

    Where the axis turns on the way, points are put in between (great circle, or rotary joints in proportion)
    until a chord is within CHORD of its arc.
    """
    tip, begin = toolpath.tip, way_begins(toolpath)
    start = np.hstack((tip[:1] / tip_tolerance, toolpath.axis[:1] / axis_tolerance))
    if len(tip) == 1:
        return np.ascontiguousarray(np.repeat(start, 2, axis=0)), np.zeros(2, dtype=np.int64)
    turn = _angles(toolpath.axis[:-1], toolpath.axis[1:])
    if toolpath.rotary is not None:
        turn = np.maximum(turn, np.abs(np.diff(toolpath.rotary, axis=0)).max(axis=1))
    pieces = np.ceil(turn / TURN).astype(np.int64)
    # The arc of an angle h is h^2 / 8 from its chord, and the axis turns by no more than both joints do.
    turning = np.flatnonzero((2.0 * turn) ** 2 > 8.0 * CHORD * axis_tolerance)
    pieces = np.clip(pieces, 1, MOST_PIECES)
    if len(turning):
        pieces[turning] = _pieces(toolpath, machine, turning, pieces[turning], axis_tolerance)
    owner, share = _shares(np.arange(1, len(tip)), pieces)
    # where another tool takes its place, the tip is elsewhere before the way begins
    changed = np.flatnonzero((begin[1:] != tip[:-1]).any(axis=1)) + 1
    first = np.searchsorted(owner, changed)
    owner, share = np.insert(owner, first, changed), np.insert(share, first, 0.0)
    between_tip = begin[owner] + share[:, None] * (tip[owner] - begin[owner])
    between_axis = _axis_between(toolpath, machine, owner, share)
    exact = np.flatnonzero(share == 1.0)
    between_tip[exact] = tip[owner[exact]]
    line = np.vstack((start, np.hstack((between_tip / tip_tolerance, between_axis / axis_tolerance))))
    return np.ascontiguousarray(line), np.concatenate(([0], owner))


def way_begins(toolpath: ToolPath) -> Floats:
    """(n, 3) where the tip is before the way to each point: at the point before, nearer to the spindle by as much as
    the tool is shorter."""
    shorter = np.zeros(len(toolpath))
    shorter[1:] = toolpath.tool_length[:-1] - toolpath.tool_length[1:]
    before = np.maximum(np.arange(len(toolpath)) - 1, 0)
    begin: Floats = toolpath.tip[before] + np.nan_to_num(shorter)[:, None] * toolpath.axis[before]
    return begin


def _angles(a: Floats, b: Floats) -> Floats:
    """Angles (n,) between unit vectors (n, 3)."""
    found: Floats = 2.0 * np.arcsin(np.clip(np.sqrt(((b - a) ** 2).sum(axis=1)) / 2.0, 0.0, 1.0))
    return found


def _shares(owner: Ints, pieces: Ints) -> tuple[Ints, Floats]:
    """Each owner as often as it has pieces, and the share of the way at the end of each piece."""
    ends = np.cumsum(pieces)
    share = (np.arange(ends[-1]) - np.repeat(ends - pieces, pieces) + 1.0) / np.repeat(pieces, pieces)
    return np.repeat(owner, pieces), share


def _axis_between(toolpath: ToolPath, machine: Machine, owner: Ints, share: Floats) -> Floats:
    """The tool axis (n, 3) a share (n,) of the way to the program points `owner` (n,)."""
    share = share[:, None]
    if toolpath.rotary is not None:
        rotary = toolpath.rotary
        q = np.zeros((len(owner), len(machine.joints)))
        columns = [machine.joints.index(name) for name in toolpath.rotary_joints] or list(machine.rotary)
        q[:, columns] = rotary[owner - 1] + share * (rotary[owner] - rotary[owner - 1])
        return machine.forward(q)[1]
    before, after = toolpath.axis[owner - 1], toolpath.axis[owner]
    angle = _angles(before, after)[:, None]
    straight = angle < 1e-9
    sine = np.where(straight, 1.0, np.sin(angle))
    left = np.where(straight, 1.0 - share, np.sin((1.0 - share) * angle) / sine)
    right = np.where(straight, share, np.sin(share * angle) / sine)
    between: Floats = left * before + right * after
    exact = np.flatnonzero(share[:, 0] == 1.0)
    between[exact] = after[exact]
    return between


def _pieces(toolpath: ToolPath, machine: Machine, turning: Ints, looks: Ints, axis_tolerance: float) -> Ints:
    """Chords for each of the ways to the points 1 + `turning`, looked at in `looks` parts and in their middles."""
    owner, share = _shares(turning + 1, 2 * looks)
    axis = _axis_between(toolpath, machine, owner, share) / axis_tolerance
    first = np.concatenate(([0], np.cumsum(2 * looks)[:-1]))
    start = _axis_between(toolpath, machine, turning + 1, np.zeros(len(turning))) / axis_tolerance
    ends = axis[first + 2 * looks - 1]
    # All of it about as straight as a chord, however much a joint turns: the axis is near its pole.
    chord = start[np.repeat(np.arange(len(turning)), 2 * looks)]
    chord = chord + share[:, None] * (np.repeat(ends, 2 * looks, axis=0) - chord)
    away = np.maximum.reduceat(np.sqrt(((axis - chord) ** 2).sum(axis=1)), first)
    before = np.vstack((axis[:1], axis))[:-1]
    before[first] = start
    middle = np.arange(0, len(axis), 2)
    bulge = np.sqrt(((axis[middle] - 0.5 * (before[middle] + axis[middle + 1])) ** 2).sum(axis=1))
    bulge = np.maximum.reduceat(bulge, first // 2)
    pieces = looks * np.maximum(np.ceil(np.sqrt(1.2 * bulge / CHORD)), 1.0)
    return np.clip(np.where(away <= CHORD, 1, pieces), 1, MOST_PIECES).astype(np.int64)


@dataclass(frozen=True)
class MotionRow:
    """The motion as a row of poses: its set-points, those that stand still as one, and places between them."""

    poses: Floats
    """(r, 6) in tolerances."""
    allowance: Floats
    """(r,) how far the motion may be from where it is thought to be between set-points [tolerances]; 0 at these."""
    first: Ints
    """(r,) first set-point that is there, or the one before."""
    last: Ints
    """(r,) last set-point that is there."""
    early: Floats
    """(r,) when the motion comes there [s]."""
    late: Floats
    """(r,) when it leaves [s]."""
    row: Ints
    """(n,) the pose of each set-point."""

    def times(self, place: Floats, *, latest: bool) -> Floats:
        """The earliest or latest time [s] at places (k,) of the row."""
        last = len(self.poses) - 1
        k = np.minimum(np.floor(place).astype(np.int64), last)
        share, after = place - k, np.minimum(k + 1, last)
        on_the_way = self.late[k] + share * (self.early[after] - self.late[k])
        found: Floats = np.where(share == 0.0, (self.late if latest else self.early)[k], on_the_way)
        return found


def motion_row(points: SetPoints, poses: Floats, limits: Limits, dt: float) -> MotionRow:
    """The row of set-points with `poses` (n, 6)."""
    return joined(stretches_of(points, poses, limits, dt), points.t, poses[-1])


def stretches_of(points: SetPoints, poses: Floats, limits: Limits, dt: float) -> list[Stretch]:
    """The stretches of set-points with `poses` (n, 6), block by block."""

    def of_block(begin: int, end: int) -> Stretch:
        block = Block.of(points, begin, end)
        near = poses[block.first : block.first + len(block.near)]
        return Stretch.of(block, near, block.first, limits, dt, begin, end)

    return each_block(of_block, len(points) - 1)


class Chords(NamedTuple):
    """The ends of the chords of some steps, and the first set-point of all where they begin with it."""

    kept: Bools
    """(k,) whether a pose is another than the one before."""
    exact: Bools
    """(k,) whether it is a set-point."""
    setpoint: Ints
    """(k,) which, or the one before."""
    time: Floats
    """(k,) [s]"""
    allowance: Floats
    """(kept,)"""


class Stretch(NamedTuple):
    """The row of some steps, from the set-point that they begin with to that which they end with."""

    poses: Floats
    """(k, 6)"""
    begin: int
    """Its first set-point."""
    chords: Chords | None
    """None where each set-point is a pose, and there are no others."""
    changes: Ints
    """Steps in which the tool is changed, of its own."""

    @classmethod
    def of(
        cls, block: Block, poses: Floats, first_pose: int, limits: Limits, dt: float, begin: int, end: int
    ) -> Stretch:
        """That of the steps from `begin` to `end`, with the poses (k, 6) from the row `first_pose` on.

        Between two set-points the motion is taken as the cubic through four of them, in as many chords as it takes: at
        50 mm/s and 5 m/s2 the chord of a millisecond misses it by 0.6 micrometres. Where joints jump, it is the chord.
        Poses that are equal to the one before are left out.
        """
        n, t = block.of_all, block.near.t
        # the differences about a step reach to three set-points before it and behind it
        first, last = max(begin - 3, 0), min(end + 4, n)
        here = slice(first - block.first, last - block.first)
        t, near, lengths = t[here], poses[first - first_pose : last - first_pose], block.near.tool_length[here]
        mine = slice(begin - first, end - first)
        changes = np.flatnonzero(np.diff(lengths[mine.start : mine.stop + 1]))
        parts, second = np.ones(end - begin, dtype=np.int64), np.zeros((last - first, 6))
        if n >= 6:
            second[1:-1] = np.diff(near, n=2, axis=0)
            size = _size(second)
            size = np.maximum(size[:-1], size[1:])[mine]
            if size.max(initial=0.0) > 8.0 * CHORD:
                inner = _curved(block.near.q[here], limits, dt) & (np.abs(np.diff(t) - dt) <= 1e-6 * dt)
                inner = (inner & ~_beside(lengths, last - first))[mine]
                steps = np.arange(begin, end)
                inner &= (steps > 0) & (steps < n - 3)
                parts = np.where(inner, np.ceil(np.sqrt(size / (8.0 * CHORD))), 1.0).clip(1, MOST_PARTS)
                parts = parts.astype(np.int64)
        simple = near[mine.start : mine.stop + 1]
        new = (simple[1:] != simple[:-1]).any(axis=1)
        if new.all() and parts.max(initial=1) == 1:
            return cls(simple, begin, None, changes)
        return cls._of_chords(near, second, t, parts, first, begin, changes)

    @classmethod
    def _of_chords(
        cls, near: Floats, second: Floats, t: Floats, parts: Ints, first: int, begin: int, changes: Ints
    ) -> Stretch:
        """That of as many chords as there are `parts` (k,) of the steps from `begin` on; poses (m, 6), their second
        differences and times (m,) are those from the row `first` on."""
        end, last = begin + len(parts), first + len(near)
        after, share = _shares(np.arange(begin + 1, end + 1), parts)
        k = after - 1
        exact = share == 1.0
        row = np.concatenate((near[begin - first : begin - first + 1], near[after - first]))
        allowance = np.zeros(len(row))
        # of long motions most steps are one chord: what is worked out is what lies between set-points
        between = np.flatnonzero(~exact)
        if len(between):
            fourth = _size(np.diff(near, n=4, axis=0))
            low, high, u = k[between] - first, after[between] - first, share[between][:, None]
            bend = u * (1.0 - u) / 6.0 * ((2.0 - u) * second[low] + (1.0 + u) * second[high])
            row[1 + between] = near[low] + u * (near[high] - near[low]) - bend
            # of the step from k to k + 1: all differences that have both of them
            differences = (np.clip(k[between] - back, first, last - 5) - first for back in range(4))
            unseen = UNSEEN * np.max([fourth[each] for each in differences], axis=0)
            allowance[1 + between] = np.minimum(unseen, MOST_UNSEEN)
        left, right = t[k - first], t[after - first]
        on_the_way = np.where(exact, right, left + share * (right - left))
        time = np.concatenate((t[begin - first : begin - first + 1], on_the_way))
        setpoint = np.concatenate(([0], np.where(exact, after, k) - begin))
        kept = np.concatenate(([True], (row[1:] != row[:-1]).any(axis=1)))
        exact = np.concatenate(([True], exact))
        return cls(row[kept], begin, Chords(kept, exact, setpoint, time, allowance[kept]), changes)

    def detailed(self, t: Floats) -> Chords:
        """Its chords, of a motion whose set-points from its first one on come at t (n,)."""
        if self.chords is not None:
            return self.chords
        rows = np.arange(len(self.poses))
        every = np.ones(len(rows), dtype=bool)
        return Chords(every, every, rows, t[rows], np.zeros(len(rows)))


def joined(stretches: Sequence[Stretch], t: Floats, end: Floats) -> MotionRow:
    """The row of stretches in a row, whose set-points come at t (n,) and which end at the pose `end` (6,)."""
    start = stretches[0].begin
    poses = [stretches[0].poses, *(each.poses[1:] for each in stretches[1:])]
    changed = np.concatenate([each.begin - start + each.changes for each in stretches])
    if all(each.chords is None for each in stretches) and len(t) > 1:
        rows = np.arange(len(t))
        allowance, first, last, early, late, row = np.zeros(len(t)), rows, rows, t, t, rows
    else:
        parts = []
        for k, each in enumerate(stretches):
            chords, own = each.detailed(t[each.begin - start :]), slice(int(k > 0), None)
            setpoint = chords.setpoint[own] + (each.begin - start)
            parts.append((chords.kept[own], chords.exact[own], setpoint, chords.time[own], chords.allowance[own]))
        kept, exact, setpoints, time, allowances = (list(each) for each in zip(*parts))
        every, when, of_row = np.concatenate(kept), np.concatenate(time), np.concatenate(setpoints)
        if every.sum() < 2:
            # a row has two poses, even where nothing moves
            every[-1] = True
            poses.append(end[None])
            allowances.append(np.zeros(1))
        allowance, starts = np.concatenate(allowances), np.flatnonzero(every)
        ends = np.append(starts[1:], len(every)) - 1
        first, last, early, late = of_row[starts], of_row[ends], when[starts], when[ends]
        row = (np.cumsum(every) - 1)[np.concatenate(exact)]
    if len(changed):
        # when the tool is changed is known to a step
        early, late = early.copy(), late.copy()
        late[row[changed]], early[row[changed + 1]] = t[changed + 1], t[changed]
    return MotionRow(np.concatenate(poses), allowance, first, last, early, late, row)


def _beside(tool_length: Floats, n: int) -> Bools:
    """(n - 1,) whether differences about a step have tips of several tools in them."""
    near = np.zeros(n - 1, dtype=bool)
    for change in np.flatnonzero(np.diff(tool_length)):
        near[max(change - 3, 0) : change + 4] = True
    return near


def _curved(q: Floats, limits: Limits, dt: float) -> Bools:
    """(n - 1,) whether second differences on both sides of a step are those of a motion within its accelerations."""
    most = limits.acceleration * dt * dt * (1.0 + 1e-3) + 1e-12
    smooth = np.ones(len(q), dtype=bool)
    smooth[1:-1] = (np.abs(np.diff(q, n=2, axis=0)) <= most).all(axis=1)
    both: Bools = smooth[1:] & smooth[:-1]
    return both


def _size(poses: Floats) -> Floats:
    """(n,) the larger of the lengths of tip and axis."""
    square = np.maximum((poses[:, :3] ** 2).sum(axis=1), (poses[:, 3:] ** 2).sum(axis=1))
    size: Floats = np.sqrt(square)
    return size
