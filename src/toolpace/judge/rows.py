"""Rows of poses in tolerances: the program as one, the set-points as another, and how they are matched."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from toolpace.arrays import Floats, Ints
from toolpace.machine.machine import Machine
from toolpace.toolpath import ToolPath

CHORD = 0.02
"""Most distance of a chord from the arc of the tool axis that it stands for [axis tolerances]; it is angle^2 / 8."""


def program_line(
    toolpath: ToolPath, machine: Machine, tip_tolerance: float, axis_tolerance: float
) -> tuple[Floats, Ints]:
    """The program as a row of poses (m, 6) in tolerances, and for each the program point that it is or leads
    to.

    Where the axis turns on the way, points are put in between (great circle, or rotary joints in proportion)
    until a chord is within CHORD of its arc.
    """
    tip, axis = toolpath.tip, toolpath.axis
    if len(tip) == 1:
        tip, axis = np.repeat(tip, 2, axis=0), np.repeat(axis, 2, axis=0)
        pose = np.hstack((tip / tip_tolerance, axis / axis_tolerance))
        return pose, np.zeros(2, dtype=np.int64)
    turn = 2.0 * np.arcsin(np.clip(np.sqrt(((axis[1:] - axis[:-1]) ** 2).sum(axis=1)) / 2.0, 0.0, 1.0))
    rotary = toolpath.rotary
    if rotary is not None:
        turn = np.maximum(turn, np.abs(np.diff(rotary, axis=0)).max(axis=1))
    pieces = np.clip(np.ceil(turn / math.sqrt(8.0 * CHORD * axis_tolerance)), 1, 10_000).astype(np.int64)
    owner = np.repeat(np.arange(1, len(tip)), pieces)
    ends = np.cumsum(pieces)
    share = (np.arange(ends[-1]) - np.repeat(ends - pieces, pieces) + 1.0) / np.repeat(pieces, pieces)
    share = share[:, None]
    between_tip = tip[owner - 1] + share * (tip[owner] - tip[owner - 1])
    if rotary is not None:
        q = np.zeros((len(owner), len(machine.joints)))
        columns = [machine.joints.index(name) for name in toolpath.rotary_joints] or list(machine.rotary)
        q[:, columns] = rotary[owner - 1] + share * (rotary[owner] - rotary[owner - 1])
        between_axis = machine.forward(q)[1]
    else:
        angle = turn[owner - 1][:, None]
        straight = angle < 1e-9
        sine = np.where(straight, 1.0, np.sin(angle))
        before = np.where(straight, 1.0 - share, np.sin((1.0 - share) * angle) / sine)
        after = np.where(straight, share, np.sin(share * angle) / sine)
        between_axis = before * axis[owner - 1] + after * axis[owner]
    exact = np.flatnonzero(share[:, 0] == 1.0)
    between_tip[exact] = tip[owner[exact]]
    if rotary is None:
        between_axis[exact] = axis[owner[exact]]
    start_axis = axis[:1]
    line = np.vstack(
        (
            np.hstack((tip[:1] / tip_tolerance, start_axis / axis_tolerance)),
            np.hstack((between_tip / tip_tolerance, between_axis / axis_tolerance)),
        )
    )
    return np.ascontiguousarray(line), np.concatenate(([0], owner))


def running_length(row: Floats) -> Floats:
    """Running length along a row of poses."""
    length: Floats = np.concatenate(([0.0], np.cumsum(np.sqrt(((row[1:] - row[:-1]) ** 2).sum(axis=1)))))
    return length


def bends_of(chain: Floats, t: Floats, dt: float) -> Floats:
    """Second differences on the steps of the chain, so that a curve sampled coarsely is not taken for its
    chords.

    Between two set-points the motion leaves the chord by u (1 - u) / 2 times the second difference, up to
    third differences: at 50 mm/s and 5 m/s2 this is 0.6 micrometres, what remains is far less.
    """
    second = np.zeros_like(chain)
    second[1:-1] = chain[2:] - 2.0 * chain[1:-1] + chain[:-2]
    # Across a pause or a shorter last step the differences mean nothing; there the motion is slow anyway.
    uneven = np.abs(np.diff(t) - dt) > 1e-6 * dt
    second[1:-1][uneven[1:] | uneven[:-1]] = 0.0
    bends: Floats = 0.5 * (second[1:] + second[:-1])
    return bends


@dataclass(frozen=True)
class Matched:
    """Where each pose of one row lies on the other, and how far off, in tolerances."""

    segment: Ints
    fraction: Floats
    tip: Floats
    axis: Floats

    @classmethod
    def empty(cls, n: int) -> Matched:
        return cls(np.zeros(n, dtype=np.int64), np.zeros(n), np.zeros(n), np.zeros(n))

    @property
    def arrays(self) -> tuple[Ints, Floats, Floats, Floats]:
        return self.segment, self.fraction, self.tip, self.axis

    def place(self, place: Floats) -> Floats:
        """Running length at the matches."""
        found: Floats = place[self.segment] + self.fraction * (place[self.segment + 1] - place[self.segment])
        return found
