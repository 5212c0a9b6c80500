"""The model `linuxcnc`: interpreter and trajectory planner of LinuxCNC 2.9, cycle by cycle; of 2.10 with limited jerk.

Source: LinuxCNC's documents ("Trajectory Control", "G64 R" and section TRAJ of the ini file), and what its source does
(src/emc/task/emccanon.cc, src/emc/tp). Axis limits hold for the words: of a block, the least of limit over share of its
way. Held against its own runs in benchmarks/results/linuxcnc_times.md.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from toolpace.common.arrays import Bools, Floats, Ints
from toolpace.common.errors import UsageError
from toolpace.common.units import DEGREE, MILLIMETRE, MINUTE
from toolpace.programs.commanded import BLENDED, Commanded

if TYPE_CHECKING:
    from toolpace.kernels.linuxcnc.blocks import Blocks
    from toolpace.machine.machine import Machine

NONE = 1e-8
"""[mm, deg] less than this of an axis is no motion of it."""
LEAST_RATE = 0.1 / MINUTE
"""Least speed that inverse time comes to [mm/s]."""
AT_START = 0.0254
"""Tolerance of blending before the first G64 of a program [mm]: what its canon begins with, 0.001 inch."""
FAR = 1e9
"""In place of what nothing limits [mm, s]."""
MOST_CYCLES = 2e7
"""In which speeds change: about two seconds of work, for six hours of ramps. Of accelerations so small that there would
be more the cycles are longer: a block's end is then known to a cycle of these, of which the motion has so many."""


class Waits(NamedTuple):
    """How long motion rests beside its dwells where the interpreter waits for its end [s].

    Measured in real time, with outputs that answer at once: about the cycles of its task (1 ms) and its I/O (20 ms).
    """

    queue: float = 3e-3
    """For dwells."""
    switch: float = 22e-3
    """For spindle, coolant and other words that switch something."""
    tool: float = 100e-3
    """For another tool, with the words that stop and start the spindle."""


class Canon:
    """Moves as blocks in LinuxCNC's units, mm and deg, and back to the times of moves."""

    def __init__(self, moves: Commanded, machine: Machine, waits: Waits) -> None:
        self.moves = moves
        self.velocity, self.acceleration, self.jerk = _limits(moves, machine)
        rows = _Rows(moves, waits)
        self.ends = rows.ends()
        """Rows at which blocks end."""
        self.rows = rows
        self.blocks = self._blocks()

    def times(self, ended: Floats) -> Floats:
        """(n,) time of each move, dwells left out, from when blocks end [s]; moves of one block by their lengths."""
        rows = self.rows
        gone = np.concatenate([[0.0], np.cumsum(rows.size[1:])])
        done = gone[self.ends]
        at = np.interp(gone, np.concatenate([[0.0], done]), np.concatenate([[0.0], ended]))
        end = np.zeros(len(self.moves))
        end[rows.of] = at  # the last row of a move counts
        spent = np.diff(end, prepend=0.0)
        spent[2:] -= self.moves.dwell[1:-1]  # no block leads to the first entry
        return np.asarray(np.maximum(spent, 0.0))

    def _blocks(self) -> Blocks:
        from toolpace.kernels.linuxcnc.blocks import ARC, LINE, OF_WAIT, Blocks

        rows, last = self.rows, self.ends
        first = np.concatenate([[0], last[:-1]]) + 1
        way = rows.place[last] - rows.place[first] + rows.way[first]
        way[np.abs(way) < NONE] = 0.0
        xyz, arc = way[:, :3], rows.sweep[last] > 0.0
        size = np.linalg.norm(xyz, axis=1)
        stands = ~xyz.any(axis=1) & ~arc
        size = np.where(stands, np.linalg.norm(way[:, 3:], axis=1), size)
        size[arc] = rows.size[last[arc]]
        limits = self.velocity, self.acceleration, self.jerk
        least, slowest, sharpest = ((np.abs(way) / limit).max(axis=1) for limit in limits)
        self._bend(rows, last, arc, least, slowest, sharpest)
        with np.errstate(divide="ignore", invalid="ignore"):
            top = np.where(least > 0.0, np.minimum(size / least, FAR), FAR)
            acceleration = np.where(slowest > 0.0, np.minimum(size / slowest, FAR), FAR)
            jerk = np.where(sharpest > 0.0, size / sharpest, FAR)
            # where X, Y, Z stand its lines point to +X
            straight = np.where(stands[:, None], [1.0, 0.0, 0.0], xyz / np.linalg.norm(xyz, axis=1)[:, None])
        rate = np.where(stands, rows.turn[last], rows.speed[last])
        figures = np.column_stack([
            np.where(arc, ARC, LINE), rows.rapid[last], way[:, 3:].any(axis=1) * np.where(stands, 2.0, 1.0), size,
            np.where(rows.rapid[last], top, np.minimum(rate, top)), top, acceleration, rows.radius[last],
            rows.sweep[last], rows.joining[last], rows.tolerance[last], rows.wait[last], jerk,
        ])  # fmt: skip
        begin, end = (np.where(arc[:, None], each[last], straight) for each in (rows.begin, rows.end))
        corner = rows.place[last, :3] - xyz
        vectors = np.stack([begin, end, corner, rows.centre[last], rows.normal[last], rows.rise()[last]], axis=1)
        # what is joined to no way at all is left out, as the planner does; its wait stays with the block before it
        waits = figures[:, OF_WAIT]
        moving = (size > 0.0) | ((np.arange(len(size)) == 0) & (waits >= 0.0))
        at = np.maximum.accumulate(np.where(moving, np.arange(len(size)), 0))
        for still in np.flatnonzero(~moving & (waits >= 0.0)):
            waits[at[still]] = max(waits[at[still]], 0.0) + waits[still]
        self.ends = last[moving]
        return Blocks(figures[moving], np.ascontiguousarray(vectors[moving]))

    def _bend(self, rows: _Rows, last: Ints, arc: Bools, least: Floats, slowest: Floats, sharpest: Floats) -> None:
        """Arcs take the least limit of their plane's axes, everywhere."""
        if not arc.any():
            return
        at = last[arc]
        across = np.abs(rows.normal[at]) < 0.5
        velocity = np.where(across, self.velocity[:3], np.inf).min(axis=1)
        acceleration = np.where(across, self.acceleration[:3], np.inf).min(axis=1)
        around = rows.radius[at] * rows.sweep[at]
        fastest = np.minimum(velocity, np.sqrt(acceleration * np.sqrt(0.75) * rows.radius[at]))
        least[arc] = np.maximum(least[arc], around / fastest)
        slowest[arc] = np.maximum(slowest[arc], around / acceleration)
        sharpest[arc] = np.maximum(sharpest[arc], around / np.where(across, self.jerk[:3], np.inf).min(axis=1))


class _Rows:
    """Moves in mm and deg, in one frame throughout; arcs flatter than the tolerance of chains are two lines."""

    def __init__(self, moves: Commanded, waits: Waits) -> None:
        unit = np.array([MILLIMETRE] * 3 + [DEGREE] * (moves.words.shape[1] - 3))
        chained = np.where(np.isnan(moves.cam_tolerance), moves.tolerance, moves.cam_tolerance) / MILLIMETRE
        chained = np.where(np.isfinite(chained) & (moves.joining == BLENDED), chained, 0.0)
        sag = np.full(len(moves), np.inf)
        arc = (moves.sweep > 0.0) & (moves.sweep <= 2.0 * np.pi)
        sag[arc] = moves.radius[arc] / MILLIMETRE * (1.0 - np.cos(0.5 * moves.sweep[arc]))
        flat = (sag < chained) & (np.abs(moves.normal[:, 2]) > 0.5)
        self.of: Ints = np.repeat(np.arange(len(moves)), np.where(flat, 2, 1))
        of = self.of
        self.way = moves.way[of] / unit
        self._flatten(moves, flat)
        self.place = np.cumsum(self.way, axis=0)
        self.sweep = np.where(flat, 0.0, moves.sweep)[of]
        self.radius = np.where(self.sweep > 0.0, moves.radius[of] / MILLIMETRE, 0.0)
        self.normal = moves.normal[of]
        begins = moves.words - moves.way
        spoke = np.where(self.sweep[:, None] > 0.0, (moves.centre - begins[:, :3])[of] / MILLIMETRE, 0.0)
        self.centre = self.place[:, :3] - self.way[:, :3] + spoke
        self.begin, self.end = moves.begin[of], moves.end[of]
        xyz = np.linalg.norm(self.way[:, :3], axis=1)
        self.size = np.where(self.sweep > 0.0, moves.length[of] / MILLIMETRE, xyz)
        self.size = np.where(self.size > 0.0, self.size, np.linalg.norm(self.way[:, 3:], axis=1))
        self.rapid = moves.rapid[of]
        self.speed, self.turn = self._rates(moves)
        self.joining = moves.joining[of]
        within = np.where(np.isfinite(moves.tolerance), moves.tolerance / MILLIMETRE, 0.0)
        self.tolerance = np.where(np.isnan(moves.tolerance), AT_START, within)[of]
        self.chained = chained[of]
        is_last = np.append(of[1:] != of[:-1], True)
        self.wait = np.where(is_last, _waits(moves, waits)[of], -1.0)

    def _flatten(self, moves: Commanded, flat: Bools) -> None:
        """Halve the ways of flat arcs, by way of their middle; their normal is Z."""
        first = np.searchsorted(self.of, np.flatnonzero(flat))
        whole, half = self.way[first], 0.5 * moves.sweep[flat][:, None]
        spoke = (moves.words[flat, :3] - moves.way[flat, :3] - moves.centre[flat]) / MILLIMETRE
        aside = np.cross(moves.normal[flat], spoke)
        to_middle = 0.5 * whole
        to_middle[:, :2] = (spoke * (np.cos(half) - 1.0) + aside * np.sin(half))[:, :2]
        self.way[first], self.way[first + 1] = to_middle, whole - to_middle

    def _rates(self, moves: Commanded) -> tuple[Floats, Floats]:
        """What F comes to for each row: of lengths [mm/s], and of turns in place [deg/s]."""
        of = self.of
        timed = moves.time > 0.0
        stands = moves.length <= 0.0
        turned = np.linalg.norm(moves.way[:, 3:], axis=1) / DEGREE
        with np.errstate(divide="ignore", invalid="ignore"):
            rate = np.where(stands, turned, moves.length / MILLIMETRE) / moves.time
        rate = np.maximum(rate, LEAST_RATE)
        speed = np.where(timed, rate, np.minimum(moves.speed / MILLIMETRE, FAR))
        turn = np.where(timed, rate, np.minimum(moves.turn / DEGREE, FAR))
        return speed[of], turn[of]

    def rise(self) -> Floats:
        """(n, 3) of helices."""
        along = (self.way[:, :3] * self.normal).sum(axis=1)
        return np.asarray(along[:, None] * self.normal)

    def ends(self) -> Ints:
        """Rows at which blocks end."""
        from toolpace.kernels.linuxcnc.blocks import chain_ends

        turns = np.abs(self.way[:, 3:]).max(axis=1, initial=0.0) > NONE
        alone = self.rapid | turns | (self.sweep > 0.0)
        cut = self.wait >= 0.0
        for each in (self.speed, self.turn, self.joining, self.tolerance, self.chained):
            cut[:-1] |= each[1:] != each[:-1]
        return chain_ends(np.ascontiguousarray(self.place[:, :3]), self.chained, alone, cut)


def _limits(moves: Commanded, machine: Machine) -> tuple[Floats, Floats, Floats]:
    """(3 + rotary,) velocity, acceleration and jerk of the axes of X, Y, Z and the rotary words [mm, deg]."""
    named = [name for name in "XYZ" if name in machine.joints]
    linear = [machine.joints.index(name) for name in named] if len(named) == 3 else list(machine.linear)
    columns = [*linear, *(machine.joints.index(name) for name in moves.rotary_joints)]
    unit = np.array([MILLIMETRE] * 3 + [DEGREE] * len(moves.rotary_joints))
    limits = machine.limits
    return (
        np.minimum(limits.velocity[columns] / unit, FAR),
        np.minimum(limits.acceleration[columns] / unit, FAR),
        np.minimum(limits.jerk[columns] / unit, FAR),
    )


def _waits(moves: Commanded, waits: Waits) -> Floats:
    """(n,) how long motion rests at the end of each move, its dwell included [s]; below zero where it goes on."""
    found = np.where(moves.stop, waits.switch, -1.0)
    found = np.where(moves.dwell > 0.0, moves.dwell + waits.queue, found)
    tools = np.array([each.tool for each in moves.operations])[moves.operation]
    changed = np.flatnonzero((tools[1:] != tools[:-1]) & (tools[1:] != ""))
    found[changed] = np.maximum(found[changed], moves.dwell[changed] + waits.tool)
    return np.asarray(found)


@dataclass(frozen=True)
class LinuxCNC:
    """Settings of the controller, by the names of its ini file."""

    cycle: float = 1e-3
    """SERVO_PERIOD [s]."""
    path_velocity: float = 1e9
    """MAX_LINEAR_VELOCITY of TRAJ [mm/s]."""
    most_override: float = 1.0
    """MAX_FEED_OVERRIDE: corners are planned for feeds so much higher."""
    kink_ratio: float = 0.1
    """ARC_BLEND_KINK_RATIO."""
    depth: int = 50
    """ARC_BLEND_OPTIMIZATION_DEPTH."""
    gap_cycles: int = 4
    """ARC_BLEND_GAP_CYCLES."""
    ramp_frequency: float = 100.0
    """ARC_BLEND_RAMP_FREQ [Hz]."""
    planner: int = 0
    """PLANNER_TYPE: 1 with limited jerk (2.10), 0 without (2.9, 2.10)."""
    path_jerk: float = 0.0
    """MAX_LINEAR_JERK of TRAJ [mm/s^3]; 0: the greatest of X, Y and Z."""
    peak_scale: float = 1.0
    """SCURVE_PEAK_SCALE, or R of G64."""
    waits: Waits = field(default_factory=Waits)


def linuxcnc_times(moves: Commanded, machine: Machine, settings: LinuxCNC | None = None) -> Floats:
    """Time of each move (n,) [s], dwells left out: from the end of the one before, overlaps included.

    Raises UsageError for a block whose end the planner would not get to.
    """
    from toolpace.kernels.linuxcnc.blocks import Control
    from toolpace.kernels.linuxcnc.program import cycles_of
    from toolpace.kernels.linuxcnc.s_curves import s_curve_ends

    settings = settings or LinuxCNC()
    canon = Canon(moves, machine, settings.waits)
    if not len(canon.blocks.figures):
        return np.zeros(len(moves))
    jerk = (settings.path_jerk or float(canon.jerk[:3].max())) if settings.planner else 0.0
    cycle = settings.cycle * (1.0 if jerk else max(1.0, _ramped(canon.blocks) / (MOST_CYCLES * settings.cycle)))
    control = Control(
        cycle, canon.velocity[:3].copy(), canon.acceleration[:3].copy(), settings.path_velocity,
        settings.most_override, settings.kink_ratio, settings.depth, settings.gap_cycles, settings.ramp_frequency,
        jerk, settings.peak_scale,
    )  # fmt: skip
    ended = s_curve_ends(canon.blocks, control) if jerk else np.asarray(cycles_of(canon.blocks, control) * cycle)
    never = ~(ended >= 0.0)
    if never.any():
        row = canon.rows.of[canon.ends[int(np.argmax(never))]]
        raise UsageError(
            f"{moves.source}, line {moves.line[row]}: LinuxCNC would not get to the end of this block; check its F"
        )
    return canon.times(ended)


def _ramped(blocks: Blocks) -> float:
    """How long blocks need at most to speed up and slow down, each from rest to rest [s]."""
    from toolpace.kernels.linuxcnc.blocks import OF_ACCELERATION, OF_LENGTH, OF_TOP

    length, top, acceleration = (blocks.figures[:, column] for column in (OF_LENGTH, OF_TOP, OF_ACCELERATION))
    return float(2.0 * np.minimum(np.sqrt(length / acceleration), top / acceleration).sum())
