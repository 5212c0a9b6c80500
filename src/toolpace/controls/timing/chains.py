"""Short blocks that a control takes as one line, as its compressor does."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from toolpace.common.arrays import Bools, Floats, Ints
from toolpace.common.units import MILLIMETRE
from toolpace.controls.timing.axis_motion import AxisWays
from toolpace.controls.timing.blocks import MotionProfile, room_of
from toolpace.controls.timing.figures import ControlFigures
from toolpace.programs.commanded import Commanded

Driven = Callable[[AxisWays, Floats], MotionProfile]
"""The profile of moves, from their ways and the length (n,) of the straight way that each is part of."""


@dataclass(frozen=True)
class Chains:
    """Moves, and which of them go along one line together.

    A move that is one of several keeps its share of the line, and its own feed and time.
    """

    ways: AxisWays
    of: Ints
    """(n,) the chain that each move belongs to, from 0 on, in order."""
    step: Floats
    """(n, axes) change of the axes over each move."""
    line: Floats
    """(chains,) from end to end [m], or [rad] of turns in place."""
    joined: Bools
    """(chains,) whether the moves go along the line; else each goes its own way."""

    @classmethod
    def of_moves(cls, ways: AxisWays, moves: Commanded, stop: Bools, tolerance: Floats, way: Floats) -> Chains:
        """Chains of straight moves at feed without rest between them that stay within a tolerance of their line.

        stop: (n,) rest at the end. tolerance: (n,) [m]. way: (axes,) what a unit of an axis leaves of the path [m].
        """
        from toolpace.kernels.controls.chains import chains_of

        step = 0.5 * (ways.first + ways.last) * ways.length[:, None]
        turns = moves.length <= 0.0
        alone = moves.rapid | (moves.sweep > 0.0) | (ways.length <= 0.0)
        cut = stop.copy()
        cut[:-1] |= (turns[1:] != turns[:-1]) | (moves.tip_mode[1:] != moves.tip_mode[:-1])
        of = chains_of(np.cumsum(step * way, axis=0), tolerance, alone, cut)
        begin = np.flatnonzero(np.diff(of, prepend=-1))
        words = np.add.reduceat(moves.way, begin)
        line = np.where(turns[begin], np.linalg.norm(words[:, 3:], axis=1), np.linalg.norm(words[:, :3], axis=1))
        return cls(ways, of, step, line, (np.diff(begin, append=len(of)) > 1) & (line > 0.0))

    @cached_property
    def begin(self) -> Ints:
        """(chains,) the first move of each."""
        return np.asarray(np.flatnonzero(np.diff(self.of, prepend=-1)))

    @cached_property
    def share(self) -> Floats:
        """(chains,) length of the line over that of its moves."""
        path = np.add.reduceat(self.ways.length, self.begin)
        return np.asarray(np.where(self.joined, self.line / np.where(path > 0.0, path, 1.0), 1.0))

    def straight(self) -> tuple[AxisWays, Floats]:
        """The ways of the moves, and the length (n,) of the straight way that each is part of."""
        ways, of = self.ways, self.joined[self.of]
        rates = np.add.reduceat(self.step, self.begin) / np.where(self.joined, self.line, np.inf)[:, None]
        first, last = (np.where(of[:, None], rates[self.of], each) for each in (ways.first, ways.last))
        most = np.where(of[:, None], np.abs(rates)[self.of], ways.most)
        length = ways.length * self.share[self.of]
        found = replace(ways, length=length, first=first, last=last, most=most)
        return found, np.where(of, self.line[self.of], length)

    def faster(self, apart: Floats, together: Floats) -> Chains:
        """Those chains alone that take less time along their lines: a curve in short blocks stays one.

        apart, together: (n,) time of each move, where each goes its own way, and where all go along their lines.
        """
        before, now = (np.add.reduceat(times, self.begin) for times in (apart, together))
        return replace(self, joined=self.joined & (now < before))


def profile_along_chains(
    moves: Commanded, ways: AxisWays, stop: Bools, figures: ControlFigures, way: Floats, driven: Driven
) -> MotionProfile:
    """The profile of moves, each along one line with its neighbours where that is faster, as `Chains` says."""
    apart = driven(ways, ways.length)
    chains = Chains.of_moves(ways, moves, stop, merging_of(moves, figures), way)
    if not chains.joined.any():
        return apart
    straight = chains.faster(apart.times, driven(*chains.straight()).times).straight()
    return driven(*straight)._replace(ways=straight[0])


def merging_of(moves: Commanded, figures: ControlFigures) -> Floats:
    """(n,) tolerance within which moves are taken as one [m]: the program's, the control's, or that of corners."""
    if figures.compress is None:
        merging = room_of(moves, figures)
    else:
        merging = np.full(len(moves), figures.compress * MILLIMETRE)
    return np.where(np.isnan(moves.cam_tolerance), merging, moves.cam_tolerance)
