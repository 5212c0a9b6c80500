"""The stock between the least and the largest that it may be, and what the tool meets of each."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple, Protocol, TypeVar

import numpy as np

from toolpace.common.arrays import Bools, Floats
from toolpace.common.workers import Workers
from toolpace.cutting.engagement.stations import Stations
from toolpace.cutting.engagement.table import EngagementTable
from toolpace.cutting.tool_profile import ToolProfile

Result = TypeVar("Result")
Solids = tuple[Floats, ...]
"""Convex solids of revolution, as a tool's profile has them."""


class Stock(Protocol):
    """Material that can be cut."""

    @property
    def resolution(self) -> float:
        """Size of a cell [m]."""
    def volume(self) -> float:
        """[m3]"""
    def copy(self) -> Stock: ...
    def cut(self, profile: ToolProfile, stations: Stations) -> EngagementTable: ...
    def depth_in_material(self, solids: Solids, stations: Stations) -> Floats: ...
    def triangles(self) -> Floats: ...


class Met(NamedTuple):
    """What the tool meets along n stations of one stock."""

    engagement: EngagementTable
    cutting: Floats
    """(n,) how deep the cutting part is in the stock as it was before these stations [m]; of rapids, else 0."""
    shank: Floats
    """(n,) how deep the shank is in it, when the station is reached [m]."""
    holder: Floats
    """(n,)"""
    removed_above: float
    """Volume that shank and holder took out of the stock [m3]."""


@dataclass(frozen=True)
class StockRange:
    """Three stocks, each within the next; the same one three times where there is no uncertainty."""

    smallest: Stock
    """Smaller by the uncertainty all round."""
    nominal: Stock
    """As its figures are."""
    largest: Stock
    """Larger by the uncertainty."""
    uncertainty: float = 0.0
    """How far the surface of the stock may be from where it is said to be [m]."""
    guessed: bool = False
    """Whether it is the box around all cutting moves, for want of a better one: nothing is concluded from it."""

    def copy(self) -> StockRange:
        """One that is cut by itself."""
        if self.smallest is self.nominal and self.largest is self.nominal:
            stocks = (self.nominal.copy(),) * 3
        else:
            stocks = self.smallest.copy(), self.nominal.copy(), self.largest.copy()
        return StockRange(*stocks, self.uncertainty, self.guessed)


def of_each(stocks: StockRange, work: Callable[[Stock], Result]) -> list[Result]:
    """What `work` returns of each of the three, in threads of their own: they have nothing in common."""
    if stocks.smallest is stocks.nominal and stocks.largest is stocks.nominal:
        return [work(stocks.nominal)] * 3
    return Workers().each(work, [stocks.smallest, stocks.nominal, stocks.largest])


def meet_all(stocks: StockRange, tool: ToolProfile, stations: Stations, rapid: bool, least: float) -> list[Met]:
    """Cut all three along stations, and tell what the tool met.

    What a shank or a holder is in by more than `least` [m] is removed at the end, so that a collision is told once;
    of all three alike, so that each stays within the next.
    """
    met = of_each(stocks, lambda stock: meet(stock, tool, stations, rapid))
    removed = [0.0, 0.0, 0.0]
    for solids, part in ((tool.shank, "shank"), (tool.holder, "holder")):
        where: Bools = np.max([getattr(each, part) for each in met], axis=0) > least
        if where.any():
            colliding = stations.where(where)
            taken = of_each(stocks, lambda stock: remove(stock, solids, colliding))  # noqa: B023
            removed = [before + more for before, more in zip(removed, taken)]
    return [each._replace(removed_above=volume) for each, volume in zip(met, removed)]


def remove(stock: Stock, solids: Solids, stations: Stations) -> float:
    """The volume that solids take out of a stock at stations [m3]."""
    return sum(float(stock.cut(ToolProfile(solid), stations).removed.sum()) for solid in solids)


def meet(stock: Stock, tool: ToolProfile, stations: Stations, rapid: bool) -> Met:
    """Cut a stock along stations, and tell what the tool met.

    At a rapid nothing may be met at all, so that all is measured in the stock as it was before: the depth is that of
    the whole collision. At feed what is before the shank changes from station to station.
    """
    if rapid:
        cutting, shank, holder = (
            stock.depth_in_material(solids, stations) for solids in ((tool.cutting,), tool.shank, tool.holder)
        )
        return Met(stock.cut(tool, stations), cutting, shank, holder, 0.0)
    engagement = stock.cut(tool, stations)
    shank, holder = engagement.penetration.T
    return Met(engagement, np.zeros(len(stations)), shank, holder, 0.0)
