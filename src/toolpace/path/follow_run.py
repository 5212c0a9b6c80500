"""The joint run of a machine along a run of a path, on one branch of its inverse kinematics."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from toolpace.common.arrays import Bools, Floats, Ints
from toolpace.common.errors import PathError
from toolpace.machine import kinematics
from toolpace.machine.inverse import nearest_solution
from toolpace.path.axis_run import AxisRun
from toolpace.programs.toolpath import ToolPath

if TYPE_CHECKING:
    from toolpace.machine.machine import Machine
    from toolpace.path.path import Path
    from toolpace.path.run import PathJet, PathRun


GRID = 401
"""Points of a run, beside its breaks, at which the solution of the inverse kinematics is chosen at least."""
TURN_A_CELL = 0.3
"""Most turn of a rotary joint between two of them [rad]: the solutions are half a turn apart."""
SHORTEST_CELL = 1e-13
"""Shortest step of that grid, as a share of the run."""


@dataclass(frozen=True, eq=False)
class Branch:
    """Rotary joints on a grid along a run: which of both solutions, and which turn, is meant."""

    s: Floats
    rotary: Floats
    """(n, 2) [rad]"""

    def near(self, s: Floats) -> Floats:
        """(n, 2) rotary joints about s."""
        return np.column_stack([np.interp(s, self.s, self.rotary[:, i]) for i in range(2)])


def branches_of(path: Path, machine: Machine) -> list[Branch | None]:
    """The solution taken along each run: chosen once over the whole path, where the path gives tool axes only.

    Between two points of the grid the nearest solution is meant. So the grid is made finer, with the choice kept, where
    a joint turns far or the solution changes. Raises PathError where that does not end.
    """
    if path.runs[0].evaluate(path.runs[0].breaks[:1]).axis is None:
        return [None] * len(path.runs)
    grids = [resolved_grid(run, machine) for run in path.runs]
    rotary = machine.choose_rotary(_points(path, grids), kinematics.POLE)
    while True:
        ends = np.cumsum([len(s) for s in grids])
        points = _points(path, grids)
        parts = list(zip(np.split(rotary, ends[:-1]), np.split(_sides(machine, points.axis, rotary), ends[:-1])))
        finer, chosen = [], []
        for k, (s, (turns, side)) in enumerate(zip(grids, parts)):
            turn = np.diff(turns, axis=0)
            wide = np.abs(turn).max(axis=1) > TURN_A_CELL
            short = _short(s)
            if (wide & short).any():
                at = int(np.argmax(wide & short))
                raise _jump(path, machine, k, float(s[at]), turn[at])
            # a change of solution on the shortest way is the pole itself
            finer.append(_quartered(s, (wide | (side[1:] * side[:-1] < 0)) & ~short))
            chosen.append(np.searchsorted(finer[k], s) + sum(len(earlier) for earlier in finer[:k]))
        if all(len(new) == len(old) for new, old in zip(finer, grids)):
            return [Branch(s, turns) for s, (turns, _) in zip(grids, parts)]
        grids = finer
        rotary = machine.rotary_between(_points(path, grids), np.concatenate(chosen), rotary, kinematics.POLE)


def resolved_grid(run: PathRun, machine: Machine) -> Floats:
    """Parameters of a run so close that the choice between the solutions is sound (`rotary_between`)."""
    s = np.unique(np.concatenate([np.linspace(run.s0, run.s1, GRID), run.breaks]))
    while True:
        axis = run.evaluate(s).axis
        assert axis is not None
        finer = _quartered(s, (machine.turn_between(axis[0], kinematics.POLE) > TURN_A_CELL) & ~_short(s))
        if len(finer) == len(s):
            return s
        s = finer


def _short(s: Floats) -> Bools:
    """(n - 1,) which cells of a grid are too short to be cut."""
    return np.asarray(np.diff(s) < max(SHORTEST_CELL * (s[-1] - s[0]), 8.0 * float(np.spacing(np.abs(s).max()))))


def _quartered(s: Floats, which: Bools) -> Floats:
    """The grid with some of its cells (n - 1,) cut in four."""
    cells = np.flatnonzero(which)
    return np.union1d(s, s[cells, None] + np.diff(s)[cells, None] * np.array([0.25, 0.5, 0.75]))


def _sides(machine: Machine, axis: Floats, rotary: Floats) -> Ints:
    """(n,) 1 or -1: which of both solutions for the axes (n, 3) is taken; 0 at the pole."""
    solutions, pole = machine.rotary_solutions(axis, kinematics.POLE)
    return np.where(pole, 0, 1 - 2 * nearest_solution(solutions, rotary))


def _points(path: Path, grids: list[Floats]) -> ToolPath:
    """The path at the points of a grid of each run."""
    jets = [run.evaluate(s) for run, s in zip(path.runs, grids)]
    axes = [jet.axis[0] for jet in jets if jet.axis is not None]
    count = sum(map(len, grids))
    nothing = np.zeros(count)
    return ToolPath(
        np.concatenate([jet.tip[0] for jet in jets]),
        np.concatenate(axes),
        np.full(count, np.inf),
        nothing,
        np.concatenate([run.block_at(s) for run, s in zip(path.runs, grids)]),
        np.isin(np.arange(count), [0, count - 1]),
        nothing,
        tool_length=np.repeat([run.tool_length for run in path.runs], list(map(len, grids))),
    )


def _jump(path: Path, machine: Machine, run: int, s: float, turn: Floats) -> PathError:
    joint = int(np.abs(turn).argmax())
    block = int(path.runs[run].block_at(np.array([s]))[0])
    place = f"s = {s:.9g}" + (f" (block {block})" if block else "")
    name = machine.joints[machine.rotary[joint]]
    return PathError(
        f"path: at {place} joint {name} would have to turn by {np.degrees(abs(turn[joint])):.3g} deg at once;"
        " lead the tool axis around its pole, or give the joint more travel"
    )


class FollowRun(AxisRun):
    """The joints of a machine, with the tool that is in the spindle, along one run of a path."""

    def __init__(self, run: PathRun, machine: Machine, branch: Branch | None) -> None:
        self.run, self.machine, self.branch = run, machine, branch
        self.s0, self.s1, self.hints, self.dwell = run.s0, run.s1, run.breaks, run.dwell
        self.profile = run.speed_profile
        self.smooth_cap = self.profile is None
        self.tool_length = run.tool_length
        self.blocks = len(run.block)
        length = np.diff(run.block_start)
        self.pace = np.divide(length, run.least_time, where=run.least_time > 0.0, out=np.full(len(length), np.inf))
        """Most ds/dt in each block for the sake of its least time."""
        jumps = (run.feed[1:] != run.feed[:-1]) | (self.pace[1:] != self.pace[:-1])
        kinks = run.breaks[1:-1] if run.third_jumps else np.empty(0)
        self.breaks = np.union1d(run.block_start[1:-1][jumps], kinks)
        if self.profile is not None:
            inside = self.profile.place[(self.profile.place > run.s0) & (self.profile.place < run.s1)]
            self.hints = np.union1d(self.hints, inside)
            self.breaks = np.union1d(self.breaks, np.intersect1d(inside, self.profile.jumps))

    def evaluate(self, s: Floats) -> Floats:
        return self._joints(self.run.evaluate(s), s)

    def with_cap(self, s: Floats) -> tuple[Floats, Floats]:
        jet = self.run.evaluate(s)
        return self._joints(jet, s), self._cap(jet.tip[1], s)

    def speed_cap(self, s: Floats) -> Floats:
        return self._cap(self.run.tip_slope(s), s)

    def entries(self) -> tuple[Floats, Ints]:
        return self.run.block_start, self.run.entry

    def block_at(self, s: Floats) -> Ints:
        return self.run.block_at(s)

    def cap_names(self, s: Floats) -> tuple[Ints, tuple[str, ...]]:
        if self.profile is None:
            return super().cap_names(s)
        block = self.run.block_index(s)
        own = np.minimum(self.pace[block], self.run.feed[block]) < self.profile.at(s)
        names = self.profile.names
        return np.where(own, len(names), self.profile.limit_at(s)), (*names, "feed")

    def deviations(self) -> tuple[Floats, Floats, Floats] | None:
        return self.run.deviations()

    def _joints(self, jet: PathJet, s: Floats) -> Floats:
        """(4, n, joints) of the tip and tool axis, or the rotary joints, in a jet at s (n,)."""
        rotary = jet.rotary
        if rotary is None:
            assert jet.axis is not None and self.branch is not None
            rotary = kinematics.rotary_jets(self.machine.geometry, jet.axis, self.branch.near(s))
        return kinematics.linear_jets(self.machine.geometry, jet.tip, rotary)

    def _cap(self, slope: Floats, s: Floats) -> Floats:
        """(n,) the cap at s (n,), from the first derivative (n, 3) of the tip there."""
        block = self.run.block_index(s)
        feed = self.run.feed[block]
        if self.profile is not None:
            feed = np.minimum(feed, self.profile.at(s))
        cap: Floats = self.pace[block]
        if np.isfinite(feed).any():
            speed = np.linalg.norm(slope, axis=1)
            with np.errstate(divide="ignore", invalid="ignore"):
                cap = np.minimum(cap, np.where(speed > 0.0, feed / speed, np.inf))
        return cap
