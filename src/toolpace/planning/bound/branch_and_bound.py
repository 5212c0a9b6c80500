"""Branch and bound over ranges of speed at knots, tightened by the relaxation, within a budget of time or work.

piece: all z in a part of a run;   cut: what is to be proved
repeat
  for each knot that waits:  by the relaxation beyond some speed there, find a border beyond which all z take `cut`
  ranges <- up to those borders;  solve the relaxation in them: a better bound for what is left
  where that is of no use, split the range of a knot: two pieces; go on with the one of the lesser bound
the bound is the least of all pieces, or the cut
"""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from toolpace.common.arrays import Floats, Ints
from toolpace.common.workers import Progress, Workers
from toolpace.kernels.optimal import dual
from toolpace.planning.bound.gap_localisation import settled, surroundings
from toolpace.planning.bound.problem import Knots
from toolpace.planning.bound.relaxation import Relaxation, relaxed

KNOT_RAMPS = 2.0
"""How far around a knot whose range is asked for the multipliers may change, in times in which an acceleration builds
up."""
OPEN = 0.02
"""Share of the longest wait from which a knot is asked for its range."""
OPEN_BELOW_PLANES = 0.2
"""The same where planes stand for limits that depend on the speed: there many knots wait, and a fifth does as well."""
FIRST_UP, FIRST_DOWN = 1.02, 0.67
"""Speeds, as multiples of the relaxation's, from which it is first asked whether the best could lie beyond."""
NEXT_UP, NEXT_DOWN = 0.3, 0.5
"""How far between the relaxation's speed and the border of its range the next question lies."""
NOT_ZERO = 1e-4
"""Share of the relaxation's z below which no range from a z on is looked for."""
NECESSARY = 0.999
"""Share of what the best motion known loses at a place that is to be proved necessary."""
QUESTIONS = 3
"""Questions that a knot is asked in a round, at most."""
PROBE_TOLERANCE = 1e-4
"""Of the relaxation that answers a question: only its side of the cut counts."""
LEAST_PROGRESS = 0.2
"""Share of what is open that a round must close; else the range of a knot is split."""
PATIENCE, LEAST_GAIN = 2, 5e-3
"""After how many rounds that raise the bound by less than this share of what the plan loses a place is left."""


@dataclass
class Allowance:
    """How much may be spent on a proof: until when, or on how much work, which does not depend on the clock."""

    until: float = np.inf
    """By time.monotonic() [s]."""
    knots: float = np.inf
    """Knots of all the relaxations that are solved for it."""

    @property
    def is_spent(self) -> bool:
        """Whether nothing is left."""
        return self.knots <= 0 or time.monotonic() >= self.until

    def take(self, knots: int) -> bool:
        """Take so many knots off, if there are as many; else there are none any more."""
        enough = knots <= self.knots
        self.knots = self.knots - knots if enough else 0
        return enough


@dataclass(frozen=True)
class Part:
    """A part of a run around a place, on its own."""

    knots: Knots
    clock: Floats
    """(n,) when the plan passes the knots [s]."""
    found: Relaxation
    """Multipliers and motion of the relaxation of the whole run, and what those multipliers prove of the part."""


@dataclass(frozen=True)
class Box:
    """Everything with z in these ranges takes at least `value`."""

    value: float
    low: Floats
    high: Floats
    found: Relaxation
    """The relaxation within the ranges."""


class Neighbourhood:
    """The surroundings of a knot in a piece; beyond them, the multipliers of the piece stand."""

    def __init__(self, part: Part, piece: Box, k: int, ramp: float) -> None:
        low, high = surroundings(part.clock, np.array([k]), KNOT_RAMPS * ramp)
        mine = slice(int(low[0]), int(high[0]) + 1)
        found = piece.found
        self.knots = part.knots.part(mine.start, mine.stop - 1, found.c, found.dual, piece.low, piece.high)
        self.low, self.high, self.k = piece.low[mine], piece.high[mine], k - mine.start
        self.c = found.c[mine.start : mine.stop + 2]
        self.z = float(self.knots.state(self.c)[self.k, 0])
        # what is to be gained here, for the whole part to take at least what is wanted
        prices = part.knots.of_part(self.knots, mine.start, found.dual)
        self.offset = self.knots.value(prices, self.low, self.high) - found.value

    def border(self, upper: bool, enough: float) -> float:
        """A z such that everything in the piece with z beyond it at the knot takes at least `enough`; nan: none found.

        Asked is what the relaxation beyond some z takes; by the dual function of its multipliers the border may lie
        further in or out. Where no range was known yet, it is asked for once more, nearer to that border.
        """
        low, high, z = self.low[self.k], self.high[self.k], self.z
        if upper:
            above = z + NEXT_UP * (high - z) if low > 0.0 else min(FIRST_UP * z, 0.5 * (z + high))
            return self.beyond(above, True, enough)
        if low > 0.0:
            return self.beyond(z - NEXT_DOWN * (z - low), False, enough)
        border = self.beyond(FIRST_DOWN * z, False, enough)
        again = np.sqrt(FIRST_DOWN * z * border) if border > 0.0 else FIRST_DOWN**4 * z
        return float(np.fmax(border, self.beyond(again, False, enough))) if again < FIRST_DOWN * z else border

    def beyond(self, z: float, upper: bool, enough: float) -> float:
        """The border by the multipliers of the relaxation beyond z; nan where they do not show any."""
        low, high, k = self.low.copy(), self.high.copy(), self.k
        (low if upper else high)[k] = z
        if not low[k] < high[k]:
            return np.nan
        found = relaxed(self.knots, self.c, low, high, PROBE_TOLERANCE, enough + self.offset)
        value, kappa, theta = self.knots.dual(found.dual, low, high)
        wanted = enough + self.offset - value + dual.lowest(kappa[k], theta[k], low[k], high[k])
        if upper:
            low[k] = max(self.low[k], NOT_ZERO * self.z)
        else:
            high[k] = self.high[k]
        return dual.range_beyond(kappa[k], theta[k], low[k], high[k], wanted, upper)


def close(
    part: Part, lost: float, needed: float, allowance: Allowance, ramp: float, workers: Workers, progress: Progress
) -> float:
    """How much more than its multipliers say any motion takes in a part; `lost` is how much more the best known takes.

    Best first branch and bound, until as much as `needed` is proved: the piece with the least value is tightened, and
    split where that is of no use.
    """
    base = part.found.value
    cut = base + NECESSARY * lost
    enough = base + min(NECESSARY * lost, needed)
    low = np.zeros_like(part.knots.cap)
    pieces = [Box(base, low, part.knots.cap, part.found)]
    patience, best = PATIENCE, base
    while patience and not allowance.is_spent:
        worst = min(pieces, key=lambda piece: piece.value)
        patience = PATIENCE if worst.value > best + LEAST_GAIN * lost else patience - 1
        best = max(best, worst.value)
        progress(min(best, enough) - base)
        if best >= enough or not allowance.take(work(part, worst, ramp)):
            break
        tighter = tightened(part, worst, cut, allowance.until, ramp, workers)
        pieces.remove(worst)
        if tighter.value >= min(worst.value + LEAST_PROGRESS * (cut - worst.value), enough):
            pieces.append(tighter)
        else:
            pieces += [relaxed_in(part, low, high, tighter) for low, high in split_at_widest(tighter, part.knots)]
    return max(min(min(piece.value for piece in pieces), cut) - base, 0.0)


def work(part: Part, piece: Box, ramp: float) -> int:
    """Knots of all the relaxations that one round in a piece solves, at most."""
    low, high = surroundings(part.clock, open_knots(part.knots, piece), KNOT_RAMPS * ramp)
    return QUESTIONS * int((high - low + 1).sum()) + 3 * len(part.clock)


def tightened(part: Part, piece: Box, wanted: float, until: float, ramp: float, workers: Workers) -> Box:
    """The piece with the ranges of its open knots narrowed to what may take less than `wanted`.

    What is cut off takes at least that, as multipliers of its own prove. So it need not be looked at again.
    """
    low, high = piece.low.copy(), piece.high.copy()

    def narrow(k: int) -> tuple[int, float, float]:
        if time.monotonic() > until:
            return k, np.nan, np.nan
        near = Neighbourhood(part, piece, k, ramp)
        return k, near.border(False, wanted), near.border(True, wanted)

    for k, least, most in workers.each(narrow, open_knots(part.knots, piece).tolist()):
        low[k], high[k] = np.fmax(low[k], least), np.fmin(high[k], most)
    return relaxed_in(part, low, high, piece)


def open_knots(knots: Knots, piece: Box) -> Ints:
    """The knots that wait longest, and their neighbours."""
    seconds = knots.weight * piece.found.wait * knots.has_rows()
    share = OPEN_BELOW_PLANES if len(knots.one_sided) else OPEN
    is_open: npt.NDArray[np.bool_] = seconds > share * seconds.max()
    is_open[1:] |= is_open[:-1].copy()
    is_open[:-1] |= is_open[1:].copy()
    return np.flatnonzero(is_open)


def relaxed_in(part: Part, low: Floats, high: Floats, whole: Box) -> Box:
    """The relaxation within ranges that are part of those of a piece."""
    found = relaxed(part.knots, part.found.c, low, high)
    found = found._replace(dual=settled(part.knots, found.dual, low))
    if not found.value > whole.found.value:
        found = whole.found
    return Box(max(found.value, whole.value), low, high, found)


def split_at_widest(piece: Box, knots: Knots) -> list[tuple[Floats, Floats]]:
    """The ranges of a piece, that of the knot which waits longest split at its speed."""
    k = int(np.argmax(knots.weight * piece.found.wait * knots.has_rows()))
    z = knots.state(piece.found.c)[k, 0]
    out = []
    for upper in (False, True):
        low, high = piece.low.copy(), piece.high.copy()
        (low if upper else high)[k] = z
        out.append((low, high))
    return out
