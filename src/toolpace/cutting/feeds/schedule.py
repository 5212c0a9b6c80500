"""Feeds along a program: from the most speed at each station to a tool path with few changes of feed.

    the least over the margin before and behind each station        what is entered, and left, late
    rounded down to the next step                                   few values
    raised stretches that are shorter than the shortest             taken off

Nothing of that is above the speed that a station allows, nor above it within the margin.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from toolpace.common.arrays import Floats, Ints, number
from toolpace.cutting.engagement.stations import Stations
from toolpace.programs.toolpath import ToolPath

AT_A_POINT = 1e-6
"""Share of a way from its end within which a place is at the end itself."""


@dataclass(frozen=True)
class Steps:
    """How coarse feeds are."""

    margin: float = 1e-3
    """How far before and behind a place what it allows holds [m]."""
    ratio: float = 1.005
    """Between two values of the feed that are next to each other."""
    shortest: float = 1e-3
    """Of the stretches on which the feed is raised [m]. Raises UsageError for figures that make no sense."""

    def __post_init__(self) -> None:
        number(self.margin, "steps of the feed: margin", least=0.0, unit="m")
        number(self.ratio, "steps of the feed: ratio", least=1.0, above=True)
        number(self.shortest, "steps of the feed: shortest", least=0.0, unit="m")


PROGRAM_STEPS = Steps(ratio=1.05, shortest=2e-3)
"""Of F words: a programmer reads few changes, and a control reaches no other feed on less."""


@dataclass(frozen=True)
class Places:
    """n stations at feed as places of the program, in its order."""

    x: Floats
    """(n,) the point that the way leads to, less what is left of the way, as a share of it."""
    way: Floats
    """(n,) way of the tip up to each, over all of these stations [m]."""

    @classmethod
    def of(cls, toolpath: ToolPath, stations: Stations) -> Places:
        """Those of stations along a path that is within its tolerance of the program."""
        point, before = stations.point, np.maximum(stations.point - 1, 0)
        move = toolpath.tip[point] - toolpath.tip[before]
        square = np.einsum("nc,nc->n", move, move)
        along = np.einsum("nc,nc->n", stations.tip - toolpath.tip[before], move)
        # where the tip stands the axis turns: the share of its turn is that of the time, which is told by the order
        share = np.where(square > 0.0, along / np.where(square > 0.0, square, 1.0), 1.0)
        x = point - 1.0 + np.clip(share, 0.0, 1.0)
        # the smooth path cuts corners: where the next way begins, one ends
        ends = np.append(np.diff(point) != 0, True)
        x[ends] = point[ends]
        x[0] = point[min(1, len(x) - 1)] - 1.0
        steps = np.linalg.norm(np.diff(stations.tip, axis=0, prepend=stations.tip[:1]), axis=1)
        return cls(np.maximum.accumulate(x), np.cumsum(steps))


def stepped(places: Places, speed: Floats, steps: Steps) -> Floats:
    """(n,) feeds in steps on the way to each station, nowhere above the `speed` (n,) of a station within the margin."""
    least = over_window(places.way, speed, steps.margin, np.minimum)
    # counted from the highest, which so is kept as it is
    top = float(speed.max(initial=1e-12))
    level = np.floor(np.log(np.maximum(least, 1e-12) / top) / np.log(steps.ratio) + 1e-9)
    # a short stretch of a higher level is lowered to those beside it
    half = 0.5 * steps.shortest
    level = over_window(places.way, over_window(places.way, level, half, np.minimum), half, np.maximum)
    return np.minimum(top * steps.ratio**level, least)


def over_window(way: Floats, values: Floats, reach: float, extreme: np.ufunc) -> Floats:
    """(n,) the least or the largest value of the ways that come within `reach` of each; `way` (n,) ascends.

    Entry i of `values` holds on the way from station i - 1 to i. Without a reach each way has its own.
    """
    if reach <= 0.0:
        return values.copy()
    begin = np.concatenate([way[:1], way[:-1]])
    low = np.searchsorted(way, begin - reach, side="left")
    high = np.searchsorted(begin, way + reach, side="right")
    low = np.minimum(low, np.arange(len(way)))
    high = np.maximum(high, np.arange(len(way)) + 1)
    edges = np.stack([low, high], axis=1).ravel()
    found: Floats = extreme.reduceat(np.append(values, values[-1:]), edges)[::2]
    return found


def slowest_within(way: Floats, speed: Floats, reach: float) -> Ints:
    """(n,) of each way that which is the slowest (n,) of those that come within `reach` [m] of it."""
    order = np.argsort(speed, kind="stable")
    rank = np.empty(len(order))
    rank[order] = np.arange(len(order))
    found: Ints = order[over_window(way, rank, reach, np.minimum).astype(np.int64)]
    return found


def ends_of_pieces(places: list[Places], feeds: list[Floats], own: Floats) -> tuple[Floats, Floats]:
    """Where pieces of one feed end (k,), as places of the program, and their feeds (k,); nan where it stays.

    own: (points,) speed on the way to each point at the program's own feed [m/s]. A way that is too short to have a
    station keeps it, or gets what the way behind it is lowered to where that is slower.
    """
    x: list[Floats] = []
    values: list[Floats] = []
    for place, feed in zip(places, feeds):
        ends = np.flatnonzero(np.append(np.diff(feed[1:]) != 0.0, True)) + 1
        point = np.ceil(place.x - AT_A_POINT).astype(np.int64)
        before = np.append(point[:1], np.ceil(place.x[:-1] - AT_A_POINT).astype(np.int64))
        jumps = np.flatnonzero(point - before > 1)
        station = np.repeat(jumps, point[jumps] - before[jumps] - 1)
        skipped = np.concatenate([np.zeros(0, dtype=np.int64), *(np.arange(before[k] + 1, point[k]) for k in jumps)])
        cap = np.where(feed[station] < own[point[station]] * (1.0 - 1e-9), feed[station], np.inf)
        # up to the stretch, and up to what is skipped, the feed of the program, or that of the station before
        around = before[jumps].astype(np.float64)
        x += [place.x[:1], place.x[ends], around, skipped.astype(np.float64)]
        values += [np.array([np.nan]), feed[ends], feed[jumps - 1], np.minimum(own[skipped], cap)]
    ends_at, of = (np.concatenate([np.zeros(0), *each]) for each in (x, values))
    order = np.argsort(ends_at, kind="stable")
    return ends_at[order], of[order]
