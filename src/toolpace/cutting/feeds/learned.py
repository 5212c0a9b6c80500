"""Feeds learned from the program: what the same tool at the same spindle speed takes somewhere, it may take elsewhere.

Let F(phi) = Kc A(phi) + Ke L(phi) be the force of a tool at the angle phi, with the area A of its chips and the length
L of the edge in material, and Kc, Ke >= 0 whatever they are. A place whose largest A and largest L over a turn are at
most those that another place, the teacher, has at one and the same angle, has F(phi) <= Kc A' + Ke L' <= the teacher's
largest force. With chips no thicker than the teacher's the edge sees nothing new either.

    of each station that is surely cut     area and edge at the angle of the largest area, and of the longest edge,
                                           thickest chip; the least of each over a stretch long enough
    teachers                               those that no other is above in all three
    at each station that may be cut        the largest speed of which some teacher is above
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from toolpace.common.arrays import Bools, Floats, Ints
from toolpace.cutting.feeds.schedule import over_window
from toolpace.cutting.forces.engaged import CutLoads, EngagedForces

TURNS, MARKS = 1.0, 3.0
"""A teacher takes its load for so many turns of the tool, and over so many feeds per tooth at least."""
MOST = 400
"""Teachers that are kept: of more, those with the smallest area of chips are left out."""
PART = 512
"""Stations that are compared with the teachers found so far at once."""


@dataclass(frozen=True)
class Teacher:
    """A place of a program whose load is taken as one that the tool bears."""

    line: int
    operation: str
    tool: str
    chip: float
    """[m]"""
    area: float
    """[m2]"""
    edge: float
    """[m]"""
    seconds: float = 0.0
    """How long the tool takes nine tenths of it at least, all three at one time [s]."""
    spindle_speed: float = 0.0
    """[1/s], below zero counterclockwise."""
    program: str = ""
    """Which, where it is another."""
    figures: Mapping[str, str] = field(default_factory=dict)
    """Of the tool, by name as text."""


@dataclass(frozen=True)
class Taken:
    """What n stations take: thickest chip [m], area of the chips [m2] and length of the edge [m] at one time."""

    chip: Floats
    area: Floats
    edge: Floats
    station: Ints
    """(n,) where."""

    def at(self, chosen: Bools | Ints) -> Taken:
        """Those of some stations."""
        return Taken(self.chip[chosen], self.area[chosen], self.edge[chosen], self.station[chosen])

    @classmethod
    def joined(cls, parts: Sequence[Taken]) -> Taken:
        """All of them."""
        chip, area, edge = (np.concatenate([np.zeros(0), *(getattr(each, name) for each in parts)])
                            for name in ("chip", "area", "edge"))  # fmt: skip
        station = np.concatenate([np.zeros(0, dtype=np.int64), *(each.station for each in parts)])
        return cls(chip, area, edge, station)

    def __len__(self) -> int:
        return len(self.chip)


def held_loads(forces: EngagedForces, speed: Floats, way: Floats, may_teach: Bools) -> Taken:
    """What is surely taken along a stretch of n stations, at the speeds that are really reached (n,) [m/s].

    Area and edge are those at the angle of the largest area, and once more those at the angle of the longest edge.
    way: (n,) of the tip [m]; may_teach: (n,) where contact is sure and wide enough to be told. Each load is the least
    within TURNS and MARKS of its station, so that it is held as long.
    """
    loads = forces.loads(speed)
    area, edge = forces.chips_together(speed)
    per_turn = speed / forces.turns_per_second
    reach = 0.5 * np.maximum(TURNS * per_turn, MARKS * per_turn / forces.tooth_count)
    held = np.where(may_teach, 1.0, 0.0)
    window = float(reach.max(initial=0.0))
    found = []
    for k in range(2):
        chip, a, e = (
            over_window(way, held * each, window, np.minimum) for each in (loads.chip, area[:, k], edge[:, k])
        )
        found.append(Taken(chip, a, e, np.arange(len(way))).at((chip > 0.0) & (a > 0.0)))
    return Taken.joined(found)


def best_of(taken: Taken) -> Taken:
    """Those that no other one is above in all three, the largest area first."""
    loads = np.stack([taken.chip, taken.area, taken.edge], axis=1)
    order = np.lexsort((taken.edge, taken.chip, taken.area))[::-1]
    kept = np.zeros(0, dtype=np.int64)
    for begin in range(0, len(order), PART):
        part = order[begin : begin + PART]
        below: Bools = np.all(loads[part, None] <= loads[None, kept], axis=2).any(axis=1)
        for k in part[~below].tolist():
            if len(kept) < MOST and not np.all(loads[k] <= loads[kept], axis=1).any():
                kept = np.append(kept, k)
    return taken.at(kept)


def without_heaviest(taken: Taken, seconds: Floats, share: float) -> Taken:
    """What is left without the stations with the largest area that are a share of all the time; seconds: (n,)."""
    order = np.argsort(-taken.area, kind="stable")
    behind = np.cumsum(seconds[order]) - 0.5 * seconds[order] > share * seconds.sum()
    return taken.at(np.sort(order[behind]))


def learned_speeds(loads: CutLoads, teacher: Taken, speed: Floats) -> tuple[Floats, Ints]:
    """(n,) the largest speed [m/s] at which a teacher is above all that each station takes, and which one it is.

    loads: at speeds (n,), any ones: chip and area grow in proportion to the speed, edge does not. 0 and -1
    where the edge is longer than any teacher's; inf where nothing is in material. Without runout exact; with runout, of
    which a share of the chip does not grow, the speed is below what it might be, since chip and area grow less.
    """
    taken = loads.chip > 0.0
    best, which = np.zeros(len(speed)), np.full(len(speed), -1)
    for k in range(len(teacher)):
        fits = loads.edge_length <= teacher.edge[k] * (1.0 + 1e-9)
        share = np.minimum(
            teacher.chip[k] / np.where(taken, loads.chip, 1.0), teacher.area[k] / np.where(taken, loads.chip_area, 1.0)
        )
        allowed = np.where(fits & taken, share * speed, 0.0)
        which[allowed > best] = k
        best = np.maximum(best, allowed)
    return np.where(taken, best, np.inf), which
