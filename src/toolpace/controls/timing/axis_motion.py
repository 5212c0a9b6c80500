"""The share of each axis in the moves of a program, and what changes of it from a move to the next."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from toolpace.common.arrays import Bools, Floats, Ints
from toolpace.programs.commanded import Commanded
from toolpace.programs.reading.coordinates.kinematics import Poses

if TYPE_CHECKING:
    from toolpace.machine.machine import Machine

PIECES = 4
"""Pieces of a move between which rates are differences: joints bend where the words of a turning move are straight."""
CHUNK = 50_000
"""Moves that are looked at at a time, to keep memory low."""


@dataclass(frozen=True)
class AxisWays:
    """Moves by their length: the way of X, Y, Z, or the turn of the rotary words where these stand."""

    length: Floats
    """(n,) [m], or [rad] of turns in place."""
    first: Floats
    """(n, axes) change of each axis a unit of length at the start of the move."""
    last: Floats
    """(n, axes) the same at its end."""
    most: Floats
    """(n, axes) the largest on the way."""
    bend: Floats
    """(n, axes) largest change of the rates a unit of length."""
    bend_first: Floats
    """(n, axes) the same with its sign at the start of arcs; 0 of straight words."""
    bend_last: Floats
    """(n, axes) the same at their end."""

    def caps(self, velocity: Floats, acceleration: Floats) -> Floats:
        """Most speed (n,) of each move, by velocity and by the acceleration that bends ask for."""
        with np.errstate(divide="ignore"):
            steady = (velocity / self.most).min(axis=1, initial=np.inf)
            bent = np.sqrt((acceleration / self.bend).min(axis=1, initial=np.inf))
        return np.asarray(np.minimum(steady, bent))

    def along(self, limit: Floats) -> Floats:
        """Most second or third derivative (n,) along each move, where `limit` (axes,) holds for the axes."""
        with np.errstate(divide="ignore"):
            return np.asarray((limit / self.most).min(axis=1, initial=np.inf))


def axis_ways(moves: Commanded, machine: Machine, *, joints: bool) -> AxisWays:
    """Ways of the joints, or of the words X, Y, Z and the rotary ones themselves; columns in the machine's order.

    joints: whether the control keeps the limits of the joints where words are the tip.
    """
    parts = [_ways(moves, machine, slice(first, first + CHUNK), joints) for first in range(0, len(moves), CHUNK)]
    return AxisWays(*(np.concatenate(column) for column in zip(*parts)))


def _ways(moves: Commanded, machine: Machine, rows: slice, joints: bool) -> tuple[Floats, ...]:
    share = np.linspace(0.0, 1.0, PIECES + 1)
    places = _places(moves, rows, share)
    turned = np.linalg.norm(moves.way[rows, 3:], axis=1)
    length = np.where(moves.length[rows] > 0.0, moves.length[rows], turned)
    axes = _columns(machine, places)
    if joints:
        in_tip = np.flatnonzero(moves.tip_mode[rows])
        at = places[in_tip].reshape(-1, places.shape[2])
        lengths = np.repeat(moves.tool_length[rows][in_tip], len(share))
        found = machine.joints_at(np.ascontiguousarray(at[:, :3]), np.ascontiguousarray(at[:, 3:]), lengths)
        axes[in_tip] = found.reshape(len(in_tip), len(share), len(machine.joints))
    unit = np.where(length > 0.0, length, np.inf)[:, None, None]
    rates = np.diff(axes, axis=1) * PIECES / unit
    first, last, most = rates[:, 0].copy(), rates[:, -1].copy(), np.abs(rates).max(axis=1)
    bend = np.abs(np.diff(rates, axis=1)).max(axis=1) * PIECES / unit[:, 0]
    bend_first, bend_last = np.zeros_like(bend), np.zeros_like(bend)
    _arcs(moves, rows, machine, joints, (first, last, most, bend, bend_first, bend_last))
    return length, first, last, most, bend, bend_first, bend_last


def _places(moves: Commanded, rows: slice, share: Floats) -> Floats:
    """Words (moves, shares, 3 + rotary) along the moves."""
    end, way = moves.words[rows], moves.way[rows]
    places = (end - way)[:, None, :] + share[:, None] * way[:, None, :]
    arcs = np.flatnonzero(moves.sweep[rows] > 0.0)
    if len(arcs):
        start, normal = (end - way)[arcs, :3], moves.normal[rows][arcs]
        spoke = start - moves.centre[rows][arcs]
        across = np.cross(normal, spoke)
        angle = moves.sweep[rows][arcs][:, None] * share
        rise = (way[arcs, :3] * normal).sum(axis=1)[:, None] * normal
        turned = np.cos(angle)[..., None] * spoke[:, None] + np.sin(angle)[..., None] * across[:, None]
        places[arcs, :, :3] = moves.centre[rows][arcs][:, None] + turned + share[:, None] * rise[:, None]
    return places


def joint_places(moves: Commanded, machine: Machine, rows: Sequence[int]) -> Floats:
    """(rows, joints) places of the joints at the ends of moves."""
    axes = _columns(machine, moves.words[rows][:, None, :])[:, 0]
    in_tip = np.asarray(rows)[moves.tip_mode[rows]]
    if len(in_tip):
        tip, rotary = (np.ascontiguousarray(moves.words[in_tip, part]) for part in (slice(3), slice(3, None)))
        axes[moves.tip_mode[rows]] = machine.joints_at(tip, rotary, moves.tool_length[in_tip])
    return axes


def _columns(machine: Machine, places: Floats) -> Floats:
    """Words as axes in the order of the machine's joints."""
    axes = np.empty((*places.shape[:2], len(machine.joints)))
    axes[..., linear_columns(machine)] = places[..., :3]
    axes[..., list(machine.rotary)] = places[..., 3:]
    return axes


def linear_columns(machine: Machine) -> Ints:
    """(3,) columns of X, Y and Z among the joints."""
    named = Poses(machine).linear
    return np.array(named) if len(named) == 3 else machine.linear


def _arcs(
    moves: Commanded,
    rows: slice,
    machine: Machine,
    joints: bool,
    rates: tuple[Floats, ...],
) -> None:
    """Put in the tangents of arcs, which are known: a circle turns too fast for differences."""
    first, last, most, bend, bend_first, bend_last = rates
    still = np.abs(moves.way[rows, 3:]).max(axis=1, initial=0.0) == 0.0
    arcs = np.flatnonzero((moves.sweep[rows] > 0.0) & still)
    columns = np.ix_(arcs, linear_columns(machine))
    turned = _linear_map(machine, moves.words[rows][arcs], moves.tip_mode[rows][arcs] & joints)
    begin, end = moves.begin[rows][arcs], moves.end[rows][arcs]
    first[columns], last[columns] = (np.einsum("nij,nj->ni", turned, each) for each in (begin, end))
    # a long arc is passed along each axis of its plane somewhere; a short one is held by that, too
    normal = moves.normal[rows][arcs]
    in_plane = turned - np.einsum("nij,nj,nk->nik", turned, normal, normal)
    reach = np.linalg.norm(in_plane, axis=2)
    most[columns] = np.maximum(reach, np.abs(first[columns]))
    bend[columns] = reach / moves.radius[rows][arcs][:, None]
    for tangent, curvature in ((begin, bend_first), (end, bend_last)):
        planar = tangent - (tangent * normal).sum(axis=1)[:, None] * normal
        inward = np.cross(normal, planar) * np.linalg.norm(planar, axis=1)[:, None]
        curvature[columns] = np.einsum("nij,nj->ni", turned, inward / moves.radius[rows][arcs][:, None])


def _linear_map(machine: Machine, words: Floats, in_tip: Bools) -> Floats:
    """(n, 3, 3) change of the linear joints a unit of X, Y, Z, with the rotary joints where they are."""
    maps = np.broadcast_to(np.eye(3), (len(words), 3, 3)).copy()
    rows = np.flatnonzero(in_tip)
    rotary = np.ascontiguousarray(words[rows, 3:])
    here = machine.joints_at(np.zeros((len(rows), 3)), rotary)
    for k in range(3):
        unit = np.zeros((len(rows), 3))
        unit[:, k] = 1.0
        maps[rows, :, k] = (machine.joints_at(unit, rotary) - here)[:, linear_columns(machine)]
    return maps


@dataclass(frozen=True)
class Transitions:
    """The transitions at the ends of moves that the control does not rest at; the rows of others are zero."""

    kink: Floats
    """(n, axes) change of the rates: at a speed v the velocity of axis j changes by v kink_j."""
    bend: Floats
    """(n, axes) change of the curvature: its acceleration changes by v^2 bend_j."""
    longer: Floats
    """(n,) length of the longer one of both moves; inf where there is no transition."""
    mean: Floats
    """(n,) mean length of both; inf where there is no transition."""
    straight: Bools
    """(n,) whether both are straight."""

    @classmethod
    def of(cls, ways: AxisWays, stop: Bools, line: Floats) -> Transitions:
        """Those between moves with these ways; moves of length zero are passed over.

        line: (n,) length of the straight way that each move is part of.
        """
        count, axes = ways.first.shape
        kink, bend = np.zeros((count, axes)), np.zeros((count, axes))
        longer, mean = np.full(count, np.inf), np.full(count, np.inf)
        curved = (np.abs(ways.bend_first) + np.abs(ways.bend_last)).max(axis=1, initial=0.0) > 0.0
        straight = np.ones(count, dtype=bool)
        rows = np.flatnonzero(ways.length > 0.0)
        here, there = rows[:-1], rows[1:]
        resting = np.logical_or.reduceat(stop, rows)[:-1] if len(rows) else np.zeros(0, dtype=bool)
        here, there = here[~resting], there[~resting]
        kink[here] = np.abs(ways.first[there] - ways.last[here])
        bend[here] = np.abs(ways.bend_first[there] - ways.bend_last[here])
        longer[here] = np.maximum(line[here], line[there])
        mean[here] = 0.5 * (line[here] + line[there])
        straight[here] = ~curved[here] & ~curved[there]
        return cls(kink, bend, longer, mean, straight)


def least_ratio(limit: Floats, change: Floats) -> Floats:
    """(n,) the least limit over change of the axes (n, axes); inf where nothing changes."""
    with np.errstate(divide="ignore"):
        ratio = np.where(change > 0.0, limit / np.where(change > 0.0, change, 1.0), np.inf)
    return np.asarray(ratio.min(axis=1, initial=np.inf))
