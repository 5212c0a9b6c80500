"""Most speed of the tip along a tool path or a run, continuous from place to place, and what sets it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from toolpace.common.arrays import Bools, Floats, Ints, integers, numbers
from toolpace.common.errors import UsageError
from toolpace.common.value_objects import ByValue, counted, one_line


@dataclass(frozen=True, eq=False, repr=False)
class SpeedProfile(ByValue):
    """Most speed of the tip at k places, in proportion between them; where two places are one, it jumps.

    Raises UsageError for arrays that do not fit together.
    """

    place: Floats
    """(k,) ascending. Of a tool path: i - 1 + x at the share x of the way to point i; of a run: its parameter."""
    speed: Floats
    """(k,) [m/s], above zero; inf where nothing is limited."""
    limit: Ints
    """(k,) index in `names` of what sets the speed from a place to the next."""
    names: tuple[str, ...]
    """What can set the speed: "chip", "force", "feed", ..."""

    def __post_init__(self) -> None:
        place = numbers(self.place, "speed profile: place", ("k",))
        speed = numbers(self.speed, "speed profile: speed", (len(place),), finite=False, unit="m/s")
        limit = integers(self.limit, "speed profile: limit", (len(place),))
        if len(place) < 2 or (np.diff(place) < 0.0).any():
            raise UsageError("speed profile: places must ascend, and be two or more")
        if not (speed > 0.0).all():
            at = int(np.argmin(speed > 0.0))
            raise UsageError(f"speed profile: speed {at} is {speed[at]:g} m/s; give speeds above zero")
        if limit.min() < 0 or limit.max() >= len(self.names):
            raise UsageError(f"speed profile: limit goes beyond the {len(self.names)} names")
        for name, value in (("place", place), ("speed", speed), ("limit", limit)):
            value.flags.writeable = False
            object.__setattr__(self, name, value)

    def __repr__(self) -> str:
        return one_line(self, counted(len(self.place), "place"), ", ".join(self.names))

    @property
    def jumps(self) -> Floats:
        """(j,) places at which the speed jumps."""
        found: Floats = np.unique(self.place[1:][self._jumping])
        return found

    @property
    def _jumping(self) -> Bools:
        found: Bools = (np.diff(self.place) == 0.0) & (self.speed[1:] != self.speed[:-1])
        return found

    def at(self, place: Floats) -> Floats:
        """(n,) the speed at places (n,), from the right where it jumps [m/s]; at the last place from the left."""
        k = self._interval(place)
        low, high = self.place[k], self.place[k + 1]
        a, b = self.speed[k], self.speed[k + 1]
        share = np.clip((place - low) / np.where(high > low, high - low, 1.0), 0.0, 1.0)
        ends = np.isfinite(a) & np.isfinite(b)
        found: Floats = np.where(ends, np.where(ends, a, 0.0) * (1.0 - share) + np.where(ends, b, 0.0) * share, np.inf)
        return found

    def limit_at(self, place: Floats) -> Ints:
        """(n,) index in `names` of what sets the speed at places (n,)."""
        found: Ints = self.limit[self._interval(place)]
        return found

    def most_of_ways(self, count: int) -> Floats:
        """(count,) most speed on the way to each of the points of a tool path [m/s]; inf to the first."""
        ends = np.arange(1.0, count)
        found = np.full(count, np.inf)
        found[1:] = np.maximum(self.at(ends - 1.0), self.at(np.nextafter(ends, -np.inf)))
        inside = np.flatnonzero(np.ceil(self.place) != self.place)
        np.maximum.at(found, np.ceil(self.place[inside]).astype(np.int64), self.speed[inside])
        return found

    def _interval(self, place: Floats) -> Ints:
        last = int(np.searchsorted(self.place, self.place[-1], side="left")) - 1
        return np.clip(np.searchsorted(self.place, place, side="right") - 1, 0, max(last, 0)).astype(np.int64)

    def along(self, points: Floats, parameters: Floats) -> SpeedProfile:
        """The part of a tool path's profile along a run: the places `points` (b + 1,), ascending, are passed at the
        parameters (b + 1,), and between two of them both grow in proportion."""
        inside = (self.place > points[0]) & (self.place < points[-1])
        ends = np.array([points[0], np.nextafter(points[-1], -np.inf)])
        place = np.concatenate([ends[:1], self.place[inside], points[-1:]])
        speed = np.concatenate([self.at(ends[:1]), self.speed[inside], self.at(ends[1:])])
        first = self.limit_at(ends[:1])
        limit = np.concatenate([first, self.limit[inside], self.limit_at(ends[1:])])
        return SpeedProfile(np.interp(place, points, parameters), speed, limit, self.names)


def ways_between(entry: Ints) -> Floats:
    """(b + 1,) places of a tool path between which the ways to its points `entry` (b,) lie."""
    return np.concatenate([entry[:1] - 1.0, entry])
