"""A program with the feeds that its cut allows: the same text, other F words, long straight blocks in pieces.

    of each block the feeds on its way      one that hardly changes keeps its text
    one feed a block                        the lowest on its way
    pieces of a block                       where it is long, straight, and the time they gain is worth them
    written, and read back                  the same path, feeds no higher than planned, those of other blocks as before
    raised without a gain on the control    such blocks keep their text, too

What an F means is not worked out here: the program is read with one F everywhere, and its time tells.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise

import numpy as np

from toolpace.common.arrays import Bools, Floats, Ints
from toolpace.common.errors import UsageError, VerificationError
from toolpace.common.units import format_time
from toolpace.controls.export.feed_words import LANGUAGES
from toolpace.controls.export.planned_feeds import CUT, Job, in_old_blocks, settled, strays
from toolpace.controls.export.program import Places as TextPlaces
from toolpace.controls.export.rewriting import Passes, ProgramText, Rewritten
from toolpace.cutting.feeds.feed_plan import FeedPlan
from toolpace.cutting.feeds.schedule import AT_A_POINT, ends_of_pieces
from toolpace.machine.machine import Machine
from toolpace.programs.reading import ReadOptions, Source
from toolpace.programs.reading.languages import recognised
from toolpace.programs.toolpath import ToolPath

LEAST_CHANGE = 0.05
"""Share by which a feed is raised at least, to be written; one that is lowered always is."""
DIGITS = 3
"""Significant figures of an F: rounded down."""
SHORTEST_PIECE = 2e-3
"""Of a block that is divided [m]."""
WORTH, PIECE_PAYS = 0.2, 0.05
"""Time that dividing a block gains at least, and that each piece of it does [s]."""
FIRST = 1e9
"""By which pieces that are too short come before others [s]."""
PAYS = 0.02
"""Time that neighbouring blocks with a higher feed gain together on the control at least [s]."""
ROUND = 1e-6
"""Share by which a value may be below a round one, and is taken for it: coordinates of pieces are rounded."""
CLOSE = 2e-6
"""Share by which a feed that is read back may be above the planned one: that, and rounding of the way."""
NEAR = 2e-6
"""By how much the end of a piece may be elsewhere by rounding [m]."""


Divisions = Mapping[int, tuple[Floats, list[str]]]
"""Line to the shares of its way at which it is divided, and the text of the pieces before the last."""


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
    above: tuple[int, ...] = ()
    """Lines that keep a feed above the planned one, since their motions have no single F."""
    below: tuple[int, ...] = ()
    """Lines that keep a feed below the planned one, somewhere on their way: of cycles and threads none."""
    missed: float = 0.0
    """Time that they take at most beyond that, by their feeds alone [s]."""
    back: Ints = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    """(new lines + 1,) the line that each was before."""

    def told(self, most: int) -> list[str]:
        """Sentences on lines that could not get the feed that is planned, with at most so many of them."""
        found = []
        if self.above:
            lines = _listed(self.above, most)
            found.append(f"faster than allowed, since their motions have no single F: lines {lines}")
        if self.below:
            lines, time = _listed(self.below, most), format_time(self.missed)
            found.append(
                f"up to {time} slower than allowed, where a block has one F for all of its motion or "
                f"none of its own (loops, subprograms): lines {lines}"
            )
        return found

    def points_at(self, before: ToolPath, x: Floats) -> Ints:
        """(n,) the point of the new program that the way leads to at places x (n,) of it as it was, see `Places`."""
        old, new = _progress(before), _progress(replace(self.toolpath, block=self.back[self.toolpath.block]))
        at = np.interp(x, np.arange(len(old)), old)
        found: Ints = np.searchsorted(new, at - AT_A_POINT).clip(max=len(new) - 1)
        return found


def with_cut_feeds(
    source: Source,
    machine: Machine,
    dialect: str | None,
    options: ReadOptions,
    toolpath: ToolPath,
    plan: FeedPlan,
    divide: bool = True,
    times: Callable[[ToolPath], Floats] | None = None,
) -> FeedProgram:
    """The program with the feeds of a plan. Raises UsageError for a table of points, VerificationError where what was
    written does not read back to the same path with these feeds.

    times: (points,) of the way to each point of a program on its control [s], by which a higher feed that gains nothing
    is left out.
    """
    passes = Passes.of(toolpath)
    feeds = _BlockFeeds(toolpath, passes, plan, machine)
    found = recognised(source, dialect, options)
    language = found.controller.language if found.controller is not None else found.dialect
    if language not in LANGUAGES:
        raise UsageError("feeds: a table of points has no blocks that could bear an F; give a program")
    shares = feeds.divided(source) if divide and language in CUT else {}
    job = Job.beside(source, machine, dialect, options, toolpath, feeds.times(shares))
    if wrong := _elsewhere(job, shares):
        shares = {line: each for line, each in shares.items() if line not in wrong}
        job = Job.beside(source, machine, dialect, options, toolpath, feeds.times(shares))

    def write(job: Job) -> Rewritten:
        return _written(job, feeds, shares)

    missed = np.where(job.rewriting.chosen | ~job.rewriting.able, 0.0, feeds.gains)
    job, new, again = settled(job, write)
    if times is not None:
        useless = _without_gain(job, feeds, times(toolpath), in_old_blocks(again, new), times(again))
        if useless.any():
            job, new, again = settled(job.without(useless), write)
    check(job, feeds, new, again)
    above = feeds.lowered & ~job.rewriting.chosen
    divided = len(set(shares) & set(job.lines))
    below = _lines(passes, missed >= PAYS)
    return FeedProgram(
        new.data, again, len(job.lines), divided, _lines(passes, above), below, float(missed.sum()), new.back
    )


def _elsewhere(job: Job, shares: Divisions) -> set[int]:
    """Lines whose pieces lead elsewhere than the block does."""
    pieces = {line: text for line, (_, text) in shares.items() if line in job.lines}
    if not pieces:
        return set()
    new, read = job.probe(pieces)
    wrong = {int(block) for block in job.passes.block[strays(job, new, read)]} & set(pieces)
    return wrong | _misplaced(new, read, {line: shares[line][0] for line in pieces})


def _written(job: Job, feeds: _BlockFeeds, shares: Divisions) -> Rewritten:
    """The program with its feeds, and with blocks in pieces."""
    pieces = {line: text for line, (_, text) in shares.items() if line in job.lines}
    new, read = job.probe(pieces)
    times = new.times(read)
    planned = {
        line: feeds.piece_times(k, shares[line][0]) if line in pieces else np.array([feeds.planned_time(k)])
        for line, k in job.lines.items()
    }
    values = job.values(times, planned, pieces)
    words = {line: [rounded_down(value) for value in found.tolist()] for line, found in values.items()}
    return job.rewriting.write(words, pieces)


def _without_gain(job: Job, feeds: _BlockFeeds, before: Floats, again: ToolPath, after: Floats) -> Bools:
    """(k,) passes with a higher feed that gain less than PAYS together with those beside them.

    before, after: (points,) time on the control, of the program and of it as it reads `again`.
    """
    gain = np.add.reduceat(before[1:], job.passes.first - 1)
    gain -= np.add.reduceat(after[1:], Passes.of(again).first - 1)
    raised = job.rewriting.chosen & ~feeds.lowered
    run = np.cumsum(~raised)
    gains = np.bincount(run[raised], gain[raised], minlength=int(run[-1]) + 1)
    return raised & (gains[run] < PAYS)


def _progress(toolpath: ToolPath) -> Floats:
    """(points,) the pass of each point and the share of its way up to it, which ascends along the program."""
    passes = Passes.of(toolpath)
    count = passes.last - passes.first + 1
    begin = np.concatenate([[0.0], np.cumsum(toolpath.way_length[1:])])
    whole = (begin[passes.last] - begin[passes.first - 1]).repeat(count)
    done = begin[1:] - begin[passes.first - 1].repeat(count)
    # where the tip stands by the number of the point
    number = np.arange(1, len(toolpath)) - passes.first.repeat(count) + 1
    share = np.where(whole > 0.0, done / np.where(whole > 0.0, whole, 1.0), number / count.repeat(count))
    return np.concatenate([[0.0], np.arange(len(count)).repeat(count) + share])


def _misplaced(new: Rewritten, read: ToolPath, shares: Mapping[int, Floats]) -> set[int]:
    """Lines whose pieces end elsewhere on their way than at the shares of it: another datum, say, was in force."""
    by_line = np.zeros(len(new.back) + 1)
    np.add.at(by_line, read.block, read.way_length)
    found = set()
    for line, share in shares.items():
        ends = np.cumsum(by_line[new.bearers[line]])
        if (np.abs(ends[:-1] - share * ends[-1]) > NEAR).any():
            found.add(line)
    return found


def _listed(lines: Sequence[int], most: int) -> str:
    return ", ".join(map(str, lines[:most])) + (", ..." if len(lines) > most else "")


def _lines(passes: Passes, chosen: Bools) -> tuple[int, ...]:
    return tuple(np.unique(passes.block[chosen]).tolist())


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
    now = Passes.of(in_old_blocks(again, new))
    way, speed = again.way_length, again.most_speed
    for line, k in job.lines.items():
        points = slice(now.first[k], now.last[k] + 1)
        above = feeds.share_above(k, way[points], speed[points])
        if above > CLOSE:
            raise VerificationError(
                f"read back, block {line} of the new program is faster than its feeds allow by {100.0 * above:.3g} %; "
                "nothing was written"
            )


def rotary_speed(toolpath: ToolPath, machine: Machine) -> Floats:
    """(points,) most speed of the tip on the way to each point by the velocity limits of the rotary joints [m/s]; inf
    where none turns, or the program does not tell where they are."""
    found = np.full(len(toolpath), math.inf)
    if toolpath.rotary is not None:
        limits = machine.limits.velocity[[machine.joints.index(name) for name in toolpath.rotary_joints]]
        times = (np.abs(np.diff(toolpath.rotary, axis=0)) / limits).max(axis=1, initial=0.0)
        np.divide(toolpath.way_length[1:], times, out=found[1:], where=times > 0.0)
    return found


class _BlockFeeds:
    """The feeds of a plan, block by block."""

    def __init__(self, toolpath: ToolPath, passes: Passes, plan: FeedPlan, machine: Machine) -> None:
        self.passes = passes
        speed = toolpath.most_speed
        ends, values = ends_of_pieces(list(plan.places), list(plan.feeds), speed)
        last = len(toolpath) - 1.0
        edges = np.unique(np.concatenate([np.arange(last + 1.0), ends[(ends > 0.0) & (ends < last)]]))
        middle = 0.5 * (edges[1:] + edges[:-1])
        point = np.ceil(middle).astype(np.int64)
        way = np.concatenate([[0.0], np.cumsum(toolpath.way_length[1:])])
        # pieces of one feed between two points: ways [m], feeds [m/s], the program's own speeds [m/s]
        self.way = np.diff(np.interp(edges, np.arange(last + 1.0), way))
        planned = np.append(values, np.nan)[np.minimum(np.searchsorted(ends, middle, side="left"), len(values))]
        self.own = speed[point]
        # an F that no rotary joint can follow is a promise that nothing keeps
        self.feed = np.minimum(planned, np.maximum(self.own, rotary_speed(toolpath, machine)[point]))
        # of a cycle the ways at feed
        self.moves = (self.way > 0.0) & ~toolpath.rapid[point]
        self.first, self.last = (np.searchsorted(edges, each) for each in (passes.first - 1.0, passes.last * 1.0))

    def divided(self, source: Source) -> Divisions:
        """Those that are worth it."""
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
        """(k,) time of each pass at the feeds on its way [s]; 0 of those that keep their text."""
        raised = (self.least_ratio >= 1.0 + LEAST_CHANGE) | np.isin(self.passes.block, list(divided))
        found = np.zeros(len(raised))
        for k in np.flatnonzero((self.lowered | raised) & np.isfinite(self.least_ratio)).tolist():
            found[k] = self.planned_time(k)
        return found

    @cached_property
    def lowered(self) -> Bools:
        """(k,) passes of which a feed is below the program's somewhere."""
        found: Bools = self.least_ratio < 1.0 - ROUND
        return found

    @property
    def gains(self) -> Floats:
        """(k,) what the feeds on the way of each pass would gain, if each of its motions had its own [s]."""
        known = self.moves & np.isfinite(self.feed) & (self.feed >= self.own * (1.0 + LEAST_CHANGE)) & (self.own > 0.0)
        gains = np.zeros(len(self.way))
        gains[known] = self.way[known] / self.own[known] - self.way[known] / self.feed[known]
        found: Floats = np.add.reduceat(gains, self.first)
        return found

    @cached_property
    def least_ratio(self) -> Floats:
        """(k,) the least ratio along each pass of a feed to the program's own; inf where none is planned.

        Where rotary joints set the pace the tip's own speed changes within a block, and one F scales all of it.
        """
        planned = np.isfinite(self.feed) & (self.feed > 0.0) & np.isfinite(self.own)
        ratio = np.full(len(planned), math.inf)
        np.divide(self.feed, self.own, out=ratio, where=self.moves & planned)
        unplanned = np.logical_or.reduceat(self.moves & ~planned, self.first)
        return np.where(unplanned | self.passes.rapid, math.inf, np.minimum.reduceat(ratio, self.first))

    def planned_time(self, k: int) -> float:
        """What pass k takes with the highest F that is nowhere above the plan [s]."""
        way, feeds, own = self.pieces_of(k)
        return float((way / own).sum() * (own / feeds).max())

    def pieces_of(self, k: int) -> tuple[Floats, Floats, Floats]:
        """Ways [m], feeds [m/s] and the program's own speeds [m/s] of the pieces of pass k, each of one feed between
        two points; none where the tip stands, or a feed is not known."""
        pieces = slice(self.first[k], self.last[k])
        there = self.moves[pieces]
        way, feeds, own = (each[pieces][there] for each in (self.way, self.feed, self.own))
        if not (np.isfinite(feeds) & (feeds > 0.0) & np.isfinite(own)).all():
            return np.zeros(0), np.zeros(0), np.zeros(0)
        return way, feeds, own

    def gain(self, way: Floats, feeds: Floats) -> float:
        """Time that pieces of their own take less than the lowest feed all along [s]."""
        return float(way.sum() / feeds.min() - (way / feeds).sum())

    def worth_dividing(self, k: int) -> Floats:
        """Shares of the way of pass k at which it is divided; none where it is not worth it."""
        if self.passes.first[k] != self.passes.last[k]:
            return np.zeros(0)
        way, feeds, _ = self.pieces_of(k)
        while len(way) > 1:
            least = np.minimum(feeds[:-1], feeds[1:])
            lost = (way[:-1] + way[1:]) / least - way[:-1] / feeds[:-1] - way[1:] / feeds[1:]
            short = np.minimum(way[:-1], way[1:]) < SHORTEST_PIECE
            first = int(np.where(short, lost - FIRST, lost).argmin())
            if not short[first] and lost[first] >= PIECE_PAYS:
                break
            feeds[first] = least[first]
            way[first] += way[first + 1]
            way, feeds = np.delete(way, first + 1), np.delete(feeds, first + 1)
        if len(way) < 2 or self.gain(way, feeds) < WORTH:
            return np.zeros(0)
        shares: Floats = np.cumsum(way)[:-1] / way.sum()
        return shares

    def piece_times(self, k: int, shares: Floats) -> Floats:
        """Times of the pieces of pass k that is divided at shares of its way, each at the lowest feed on it [s]."""
        way, feeds, _ = self.pieces_of(k)
        ends = np.cumsum(way) / way.sum()
        borders = np.concatenate([[0.0], shares, [1.0]])
        begins = np.concatenate([[0.0], ends[:-1]])
        times = []
        for a, b in pairwise(borders):
            on = (ends > a + 1e-9) & (begins < b - 1e-9)
            times.append((b - a) * way.sum() / feeds[on].min())
        return np.array(times)

    def share_above(self, k: int, ways: Floats, speeds: Floats) -> float:
        """By what share of the plan's feeds pass k is too fast that is read as ways (n,) [m] at speeds (n,) [m/s]."""
        way, feeds, _ = self.pieces_of(k)
        ends, tips = np.cumsum(way), np.cumsum(ways)
        worst = 0.0
        for length, tip, speed in zip(ways, tips * (ends[-1] / tips[-1]), speeds):
            slack = min(NEAR, 0.25 * length)
            on = (ends > tip - length + slack) & (ends - way < tip - slack)
            if length > 0.0:
                worst = max(worst, float(speed / feeds[on].min()) - 1.0)
        return worst
