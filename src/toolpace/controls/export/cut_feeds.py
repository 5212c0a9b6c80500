"""A program with the feeds that its cut allows: the same text, other F words, long straight blocks in pieces.

    of each block the feeds on its way      one that hardly changes keeps its text
    one feed a block                        the lowest on its way
    pieces of a block                       where it is long, straight, and the time they gain is worth them
    written, and read back                  the same path, and feeds no higher than planned

What an F means is not worked out here: the program is read with one F everywhere, and its time tells.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.common.errors import VerificationError
from toolpace.controls.export.feed_words import LANGUAGES
from toolpace.controls.export.planned_feeds import CUT, PROBE, Job, strays
from toolpace.controls.export.program import Places as TextPlaces
from toolpace.controls.export.rewriting import Passes, ProgramText, Rewritten
from toolpace.cutting.feeds.feed_plan import FeedPlan
from toolpace.cutting.feeds.schedule import ends_of_pieces, own_feeds
from toolpace.machine.machine import Machine
from toolpace.programs.reading import ReadOptions, Source
from toolpace.programs.reading.languages import recognised
from toolpace.programs.toolpath import ToolPath

LEAST_CHANGE = 0.05
"""Share by which a feed changes at least, to be written."""
DIGITS = 3
"""Significant figures of an F: rounded down."""
SHORTEST_PIECE = 2e-3
"""Of a block that is divided [m]."""
WORTH = 0.2
"""Time that dividing a block gains at least [s]."""
ROUND = 1e-6
"""Share by which a value may be below a round one, and is taken for it: coordinates of pieces are rounded."""
CLOSE = 2e-6
"""Share by which a feed that is read back may be above the planned one: that, and rounding of the way."""


@dataclass(frozen=True)
class FeedProgram:
    """A program with other feeds."""

    data: bytes
    """The file."""
    toolpath: ToolPath
    """As it reads."""
    changed: int
    """Blocks whose feed changed."""
    divided: int
    """Blocks that were divided."""


def with_cut_feeds(
    source: Source,
    machine: Machine,
    dialect: str | None,
    options: ReadOptions,
    toolpath: ToolPath,
    plan: FeedPlan,
    divide: bool = True,
) -> FeedProgram:
    """The program with the feeds of a plan. Raises UsageError for a table of points, VerificationError where what was
    written does not read back to the same path with these feeds."""
    passes = Passes.of(toolpath)
    feeds = _BlockFeeds(toolpath, passes, plan)
    found = recognised(source, dialect, options)
    language = found.controller.language if found.controller is not None else found.dialect
    shares = feeds.divided(source) if divide and language in CUT and language in LANGUAGES else {}
    times = feeds.times(shares)
    if not (times > 0.0).any():
        return FeedProgram(source.data, toolpath, 0, 0)
    job = Job.beside(source, machine, dialect, options, toolpath, times)
    pieces = {line: text for line, (_, text) in shares.items() if line in job.lines}
    new, read = job.probe(pieces)
    wrong = {int(block) for block in passes.block[strays(job, new, read)]} & set(pieces)
    if wrong:
        pieces = {line: lines for line, lines in pieces.items() if line not in wrong}
        new, read = job.probe(pieces)
    words: dict[int, list[str]] = {}
    for line, probed in new.times(read).items():
        k = job.lines[line]
        wanted = feeds.piece_times(k, shares[line][0] if line in pieces else np.zeros(0))
        words[line] = [rounded_down(PROBE * float(a / b)) for a, b in zip(probed, wanted)]
    new = job.rewriting.write(words, pieces)
    again = job.read(new)
    check(job, feeds, new, again)
    return FeedProgram(new.data, again, len(words), len(pieces))


def rounded_down(value: float) -> str:
    """A feed in DIGITS significant figures, not above the value."""
    decimals = DIGITS - 1 - int(np.floor(np.log10(value)))
    text = f"{np.floor(value * 10.0**decimals * (1.0 + ROUND)) / 10.0**decimals:.{max(decimals, 0)}f}"
    return text.rstrip("0").rstrip(".") if "." in text else text


def check(job: Job, feeds: _BlockFeeds, new: Rewritten, again: ToolPath) -> None:
    """Raise VerificationError where the program leads elsewhere, or is faster than planned."""
    other = strays(job, new, again)
    if other.any():
        block = int(job.passes.block[int(np.argmax(other))])
        raise VerificationError(f"read back, block {block} of the new program leads elsewhere; nothing was written")
    times = new.times(again)
    for line, k in job.lines.items():
        least, found = feeds.least_time(k), float(times[line].sum())
        if found < least * (1.0 - CLOSE):
            raise VerificationError(
                f"read back, block {line} of the new program takes {found:.6g} s, and its feeds allow {least:.6g} s; "
                "nothing was written"
            )


class _BlockFeeds:
    """The feeds of a plan, block by block."""

    def __init__(self, toolpath: ToolPath, passes: Passes, plan: FeedPlan) -> None:
        self.toolpath, self.passes = toolpath, passes
        self.ends, self.values = ends_of_pieces(list(plan.places), list(plan.feeds))
        self.own = own_feeds(toolpath)
        self.way = np.concatenate([[0.0], np.cumsum(toolpath.way_length[1:])])

    def divided(self, source: Source) -> dict[int, tuple[Floats, list[str]]]:
        """Line to the shares of its way at which it is worth dividing, and the text of the pieces before the last."""
        lines = ProgramText.of(source.data).lines
        text = TextPlaces.of(lines)
        found = {}
        for k in np.flatnonzero(self.passes.once & ~self.passes.rapid & ~self.passes.mixed).tolist():
            line = int(self.passes.block[k])
            shares = self.worth_dividing(k)
            written = text.pieces(line, lines[line - 1], shares) if len(shares) and line <= len(lines) else None
            if written:
                found[line] = shares, written
        return found

    def times(self, divided: Collection[int]) -> Floats:
        """(k,) time of each pass at the lowest feed on its way [s]; 0 of those that keep their text."""
        found = np.zeros(len(self.passes.block))
        for k in range(len(found)):
            way, feeds = self.pieces_of(k)
            if not len(feeds) or self.passes.rapid[k] or self.passes.mixed[k]:
                continue
            own = float(self.own[self.passes.first[k] : self.passes.last[k] + 1].min())
            changes = abs(float(feeds.min()) / own - 1.0) >= LEAST_CHANGE
            if changes or int(self.passes.block[k]) in divided:
                found[k] = float(way.sum() / feeds.min())
        return found

    def pieces_of(self, k: int) -> tuple[Floats, Floats]:
        """Ways [m] and feeds [m/s] of the pieces of pass k; none where the tip stands, or a feed is not known."""
        begin, end = float(self.passes.first[k] - 1), float(self.passes.last[k])
        inside = self.ends[(self.ends > begin) & (self.ends < end)]
        edges = np.concatenate([[begin], inside, [end]])
        piece = np.searchsorted(self.ends, 0.5 * (edges[1:] + edges[:-1]), side="left")
        feeds = np.append(self.values, np.nan)[np.minimum(piece, len(self.values))]
        way = np.diff(np.interp(edges, np.arange(len(self.way)), self.way))
        there = way > 0.0
        if not there.any() or not np.isfinite(feeds[there]).all():
            return np.zeros(0), np.zeros(0)
        return way[there], feeds[there]

    def gain(self, way: Floats, feeds: Floats) -> float:
        """Time that pieces of their own take less than the lowest feed all along [s]."""
        return float(way.sum() / feeds.min() - (way / feeds).sum())

    def worth_dividing(self, k: int) -> Floats:
        """Shares of the way of pass k at which it is divided; none where it is not worth it."""
        if self.passes.first[k] != self.passes.last[k]:
            return np.zeros(0)
        way, feeds = self.pieces_of(k)
        while len(way) > 1:
            short = int(way.argmin())
            if way[short] >= SHORTEST_PIECE:
                break
            # what is too short goes with the slower of its neighbours
            beside = [j for j in (short - 1, short + 1) if 0 <= j < len(way)]
            to = min(beside, key=lambda j: float(feeds[j]))
            first = min(short, to)
            feeds[first] = min(feeds[short], feeds[to])
            way[first] += way[first + 1]
            way, feeds = np.delete(way, first + 1), np.delete(feeds, first + 1)
        if len(way) < 2 or self.gain(way, feeds) < WORTH:
            return np.zeros(0)
        shares: Floats = np.cumsum(way)[:-1] / way.sum()
        return shares

    def piece_times(self, k: int, shares: Floats) -> Floats:
        """Times of the pieces of pass k that is divided at shares of its way, each at the lowest feed on it [s]."""
        way, feeds = self.pieces_of(k)
        ends = np.cumsum(way) / way.sum()
        borders = np.concatenate([[0.0], shares, [1.0]])
        begins = np.concatenate([[0.0], ends[:-1]])
        times = []
        for a, b in pairwise(borders):
            on = (ends > a + 1e-9) & (begins < b - 1e-9)
            times.append((b - a) * way.sum() / feeds[on].min())
        return np.array(times)

    def least_time(self, k: int) -> float:
        """What the feeds of the plan allow pass k [s]."""
        way, feeds = self.pieces_of(k)
        return float((way / feeds).sum())
