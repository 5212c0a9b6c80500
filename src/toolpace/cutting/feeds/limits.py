"""Limits of the cut, and the most speed at which a tool keeps them in an engagement.

Each load is a convex function of the speed: forces are linear in it at each angle of the tool, and a peak is the
largest of their sizes. So is the largest share of a limit that any load takes, r. Where r(a) <= 1 <= r(b) the chord
between both lies above r, so that where it is 1 is safe; the line through two safe speeds lies below r beyond them, so
that where it is 1 is not below the root. Both ends close in on it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields, replace

import numpy as np

from toolpace.common.arrays import Floats, Ints, number
from toolpace.common.errors import UsageError
from toolpace.cutting.feeds.schedule import Places
from toolpace.cutting.forces.engaged import CutLoads, EngagedForces

TRIES = 30
"""Of closing in: each is two evaluations of all stations."""
CLOSE = 1e-4
"""Share of a speed within which it is found."""
LOWEST = 1e-3
"""Share of the highest speed below which none is looked for, or SLOWEST where that is less: a program may have F as
high as no tool cuts, in place of a rapid."""
SLOWEST = 1e-5
"""[m/s]"""
FEED, AIR, TAUGHT = "feed", "feed in air", "load of the teacher"


@dataclass(frozen=True)
class CutLimits:
    """Limits of one tool; None: none. Raises UsageError for what is no limit."""

    chip: float | None = None
    """Thickest chip over a turn [m]."""
    feed_per_tooth: float | None = None
    """[m]"""
    removal_rate: float | None = None
    """[m3/s]"""
    force: float | None = None
    """Largest size of the force over a turn [N]."""
    torque: float | None = None
    """Largest over a turn [N m]."""
    power: float | None = None
    """Mean over a turn [W]."""
    moment: float | None = None
    """Largest bending moment at the holder [N m]."""
    stress: float | None = None
    """Bending stress of the shank at the holder [Pa]."""
    deflection: float | None = None
    """Largest of the tip [m]."""
    surface_deflection: float | None = None
    """Largest that is left on the surface, too much or too little [m]."""
    compensated_deflection: float | None = None
    """Largest that is left on the surface where the path is compensated for the mean over the height: half of what it
    differs over it [m]."""
    feed_marks: float | None = None
    """Height of the marks that the feed leaves, f^2 / (8 R) [m]."""

    def __post_init__(self) -> None:
        for each in fields(self):
            value = getattr(self, each.name)
            if value is not None:
                number(value, f"limit of the cut: {each.name}", least=0.0, above=True)

    @property
    def compensated(self) -> CutLimits:
        """Those of a tool whose deflection on the surface is compensated: what is left of it is limited."""
        if self.surface_deflection is None:
            return self
        both = (self.surface_deflection, self.compensated_deflection)
        least = min(each for each in both if each is not None)
        return replace(self, surface_deflection=None, compensated_deflection=least)

    @property
    def names(self) -> tuple[str, ...]:
        """Those that there are."""
        return tuple(each.name for each in fields(self) if getattr(self, each.name) is not None)


OF_BENDING = {"moment", "stress", "deflection", "surface_deflection", "compensated_deflection"}
"""Limits that a tool without a stick-out tells nothing of."""
SOURCES = (FEED, AIR, TAUGHT, *(each.name.replace("_", " ") for each in fields(CutLimits)))
"""What can set the speed at a place."""


@dataclass(frozen=True)
class SpeedLimits:
    """Of n stations."""

    speed: Floats
    """(n,) most speed of the tip [m/s]."""
    holds: Ints
    """(n,) which of the limits' names holds it there; -1 where none does."""
    exceeded: Floats
    """(n,) by how much a limit is exceeded however slow the tool is, as a share of it; 0 where it is not."""


def speeds_within(
    forces: EngagedForces, places: Places, limits: CutLimits, most: float, turning: Floats | None = None
) -> SpeedLimits:
    """The most speed at each station, up to `most` [m/s], that keeps the limits of the cut.

    turning: (n, 2) turn of the axis per metre of the tip's way [rad/m], along feed and normal. Raises UsageError where
    a limit needs a figure of the tool that is missing.
    """
    names = limits.names
    n = len(forces.engagement.along)
    if not names or not n:
        return SpeedLimits(np.full(n, most), np.full(n, -1), np.zeros(n))
    if not forces.bends and OF_BENDING & set(names):
        raise UsageError(
            "limits of the cut: a deflection or a moment needs the tool's stick_out and its material; give both in the "
            'tool table, like stick_out = "40mm" and material = "carbide"'
        )
    section = forces.section_modulus
    step = np.diff(places.way, prepend=places.way[:1])
    per_way = np.divide(forces.engagement.removed, step, out=np.zeros(n), where=step > 0.0)

    def shares(speed: Floats) -> Floats:
        loads = forces.loads(speed, None if turning is None else turning * speed[:, None])
        return np.stack([_load(name, loads, forces, speed, per_way, section) / getattr(limits, name) for name in names])

    slow, fast = np.full(n, min(LOWEST * most, SLOWEST)), np.full(n, most)
    speed, worst = root_below(lambda each: shares(each).max(axis=0), slow, fast)
    at = shares(speed)
    holds = np.where((speed < most * (1.0 - CLOSE)) & (at.max(axis=0) > 1.0 - 0.02), at.argmax(axis=0), -1)
    return SpeedLimits(speed, holds, np.maximum(worst - 1.0, 0.0))


def root_below(share: Callable[[Floats], Floats], slow: Floats, fast: Floats) -> tuple[Floats, Floats]:
    """(n,) the largest speeds from `slow` to `fast` (n,) whose share is at most 1, to CLOSE, never above it; and (n,)
    the share at the slowest.

    share: convex and growing, of speeds (n,). Where it is above 1 at the slowest, that is what is returned.
    """
    low, high = slow.copy(), fast.copy()
    at_low, at_high = share(low), share(high)
    least = at_low.copy()
    done = at_high <= 1.0
    low[done] = high[done]
    done |= at_low >= 1.0
    before, at_before = low.copy(), at_low.copy()
    width = np.full(len(low), np.inf)
    for _ in range(TRIES):
        if done.all():
            break
        lags, width = high - low > 0.5 * width, high - low
        chord = low + (1.0 - at_low) * (high - low) / np.where(done, 1.0, at_high - at_low)
        safe = np.where(done, low, np.clip(chord, low, high))
        at_safe = share(safe)
        # rounding alone can put it above the root
        good = ~done & (at_safe <= 1.0)
        before[good], at_before[good] = low[good], at_low[good]
        low[good], at_low[good] = safe[good], at_safe[good]
        slope = (at_low - at_before) / np.where(low > before, low - before, np.inf)
        beyond = np.where((slope > 0.0) & ~done, low + (1.0 - at_low) / np.where(slope > 0.0, slope, 1.0), high)
        # where both ends hardly move, the middle is looked at
        beyond = np.where(lags, 0.5 * (low + high), np.clip(beyond * (1.0 + 0.1 * CLOSE), low, high))
        at_beyond = share(beyond)
        above = ~done & (at_beyond >= 1.0)
        high[above], at_high[above] = beyond[above], at_beyond[above]
        below = ~done & ~above
        low[below], at_low[below] = beyond[below], at_beyond[below]
        done |= (high - low <= CLOSE * high) | (1.0 - at_low <= 1e-9)
    return low, least


def _load(
    name: str, loads: CutLoads, forces: EngagedForces, speed: Floats, per_way: Floats, section: float
) -> Floats:
    """(n,) of the kind that a limit is of, in its unit."""
    per_tooth = speed / (forces.tooth_count * forces.turns_per_second)
    engaged = loads.chip > 0.0
    if name == "feed_per_tooth":
        return np.where(engaged, per_tooth, 0.0)
    if name == "removal_rate":
        return per_way * speed
    if name == "feed_marks":
        radius = forces.tool.corner_radius or 0.5 * forces.tool.diameter
        return np.where(engaged, (per_tooth * forces.tooth_count) ** 2 / (8.0 * radius), 0.0)
    if name == "stress":
        return np.nan_to_num(loads.moment) / section
    if name == "surface_deflection":
        left: Floats = np.abs(np.nan_to_num(loads.surface)).max(axis=1)
        return left
    if name == "compensated_deflection":
        differs: Floats = 0.5 * np.nan_to_num(loads.surface[:, 1] - loads.surface[:, 0])
        return differs
    kinds = {"chip": loads.chip, "force": loads.resultant, "torque": loads.torque, "power": loads.power}
    kinds |= {"moment": loads.moment, "deflection": loads.deflection}
    return np.asarray(np.nan_to_num(np.abs(kinds[name])), dtype=np.float64)
