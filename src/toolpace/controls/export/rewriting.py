"""A program with feed words written anew, line by line; and the time at which each of its blocks is run."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from toolpace.common.arrays import Bools, Floats, Ints
from toolpace.common.errors import UsageError
from toolpace.controls.export.feed_words import FeedWords
from toolpace.motion.setpoints import SetPoints
from toolpace.programs.toolpath import ToolPath

AXIS = 0.1
"""Length [m] by which a change of the tool axis is weighed against one of the tip."""
_ENDS = re.compile(r"(\r\n|\r|\n)")
_MARK = b"\xef\xbb\xbf"
"""Of UTF-8, which some editors put before the text."""
FIGURES, LEAST_FIGURES = 6, 3
"""Significant figures of an F, and of one per turn or tooth, which is small, at least."""


@dataclass(frozen=True)
class Passes:
    """Stretches of points that belong to one block, in the order in which they are run; a loop's block has several."""

    block: Ints
    """(k,) line number."""
    first: Ints
    """(k,) first of its points; its way begins at the point before."""
    last: Ints
    """(k,) last of its points."""
    rapid: Bools
    """(k,) whether all of it is a rapid."""
    mixed: Bools
    """(k,) whether it has rapids and feeds: cycles do."""
    once: Bools
    """(k,) whether its block is run once only."""

    @classmethod
    def of(cls, toolpath: ToolPath) -> Passes:
        """The passes of a program; the first point, where it begins, belongs to none."""
        block, rapid = toolpath.block[1:], toolpath.rapid[1:]
        head = np.flatnonzero(np.diff(block, prepend=block[0] - 1)) + 1
        last = np.append(head[1:] - 1, len(block))
        rapids = np.add.reduceat(rapid.astype(np.int64), head - 1)
        count = last - head + 1
        names, runs = np.unique(toolpath.block[head], return_counts=True)
        once = np.isin(toolpath.block[head], names[runs == 1])
        return cls(toolpath.block[head], head, last, rapids == count, (rapids > 0) & (rapids < count), once)

    def asked_times(self, toolpath: ToolPath) -> Floats:
        """(k,) what the program's feeds make of each pass [s]: the least time that its ways can take."""
        least = np.maximum(toolpath.way_length[1:] / toolpath.feed[1:], toolpath.least_time[1:])
        times: Floats = np.add.reduceat(least, self.first - 1)
        return times

    def planned_times(self, toolpath: ToolPath, points: SetPoints) -> Floats:
        """(k,) how long the plan is on the way of each pass [s], dwells left out.

        Raises UsageError where the set-points name other blocks than the program.
        """
        ends = self.ends(toolpath, points)
        starts = np.concatenate([points.t[:1], ends[:-1]])
        waits = np.add.reduceat(toolpath.dwell[1:], self.first - 1)
        waits[0] += toolpath.dwell[0]
        times: Floats = ends - starts - waits
        return times

    def ends(self, toolpath: ToolPath, points: SetPoints) -> Floats:
        """(k,) when each pass ends [s], its dwell included: between two set-points, where the end of the block lies.

        Blocks shorter than a time step lie between the same two.
        """
        rows = self._last_rows(points)
        before, behind = pose(points.tip[rows], points.axis[rows]), rows + 1
        step = pose(points.tip[behind], points.axis[behind]) - before
        end = pose(toolpath.tip[self.last], toolpath.axis[self.last])
        length = (step**2).sum(axis=1)
        share = ((end - before) * step).sum(axis=1) / np.maximum(length, 1e-300)
        share = np.where(length > 0.0, np.clip(share, 0.0, 1.0), 0.5)
        times = points.t[rows] + share * (points.t[behind] - points.t[rows])
        times[-1] = points.t[-1]
        found: Floats = np.maximum.accumulate(times)
        return found

    def _last_rows(self, points: SetPoints) -> Ints:
        """(k,) the last set-point of each pass; of a pass that has none, that of the one before."""
        heads = np.flatnonzero(np.diff(points.block, prepend=points.block[0] - 1))
        tails = np.append(heads[1:], len(points)) - 1
        named = points.block[heads]
        rows = np.zeros(len(self.block), dtype=np.int64)
        run, row = 0, 0
        for k, block in enumerate(self.block.tolist()):
            if run < len(named) and named[run] == block:
                row = int(tails[run])
                run += 1
            rows[k] = row
        if run < len(named):
            raise UsageError(
                f"the set-points name block {int(named[run])} where the program has none: they are of another "
                "program; plan again"
            )
        return np.minimum(rows, len(points) - 2)


def pose(tip: Floats, axis: Floats) -> Floats:
    """(n, 6) tip and tool axis as one place [m]."""
    place: Floats = np.hstack([tip, AXIS * axis])
    return place


@dataclass(frozen=True)
class ProgramText:
    """Lines of a program, and what is needed to write them as they were."""

    lines: tuple[str, ...]
    """Without their ends."""
    ends: tuple[str, ...]
    """Of each line; empty where the last has none."""
    encoding: str
    marked: bool
    """Whether the mark of UTF-8 stands before it."""

    @classmethod
    def of(cls, data: bytes) -> ProgramText:
        """The text of a file: UTF-8, else one byte a character, as programs are read."""
        marked = data.startswith(_MARK)
        body = data.removeprefix(_MARK)
        encoding = "utf-8"
        try:
            text = body.decode(encoding)
        except UnicodeDecodeError:
            encoding = "latin-1"
            text = body.decode(encoding)
        parts = _ENDS.split(text)
        lines, ends = parts[::2], [*parts[1::2], ""]
        if len(lines) > 1 and not lines[-1]:
            lines.pop()
            ends.pop()
        return cls(tuple(lines), tuple(ends), encoding, marked)

    def with_lines(self, changed: Sequence[Sequence[str]]) -> bytes:
        """The file with each line replaced by one or more; those that are added end as the line does."""
        usual = next((end for end in self.ends if end), "\n")
        out: list[str] = []
        for lines, end in zip(changed, self.ends):
            out.append((end or usual).join(lines) + end)
        data = "".join(out).encode(self.encoding)
        return _MARK + data if self.marked else data


@dataclass(frozen=True)
class Rewriting:
    """A program, and which of its passes get a feed."""

    text: ProgramText
    words: FeedWords
    passes: Passes
    chosen: Bools
    """(k,) passes whose block gets an F of its own."""
    able: Bools
    """(k,) passes whose block could bear one: none of cycles, threads and statements."""
    inverse: bool
    """Whether by inverse times."""

    @classmethod
    def of(cls, text: ProgramText, words: FeedWords, passes: Passes, planned: Floats, inverse: bool) -> Rewriting:
        """Chosen are blocks that run once, whose motion is at feed, takes time, and can bear an F."""
        block = np.where(passes.block <= len(text.lines), passes.block, 0)
        able = np.array([False, *words.editable(text.lines)])[block]
        chosen = passes.once & ~passes.rapid & ~passes.mixed & able & (planned > 0.0)
        return cls(text, words, passes, chosen, able, inverse)

    @property
    def kept(self) -> Bools:
        """(k,) passes at feed whose block keeps its text."""
        return ~self.chosen & ~self.passes.rapid

    def restores(self) -> dict[int, str]:
        """Line to what must be written behind it, so that blocks that keep their text keep their feed too.

        Inverse times end behind the last block that has one: what the program leaves in force is as it was.
        """
        last = -1
        behind: list[int] = []
        for k in range(len(self.passes.block)):
            if self.chosen[k]:
                last = k
            elif last >= 0 and not self.passes.rapid[k]:
                if self.inverse or not self._has_feed(int(self.passes.block[k])):
                    behind.append(int(self.passes.block[last]))
                last = -1
        if self.inverse and last >= 0:
            behind.append(int(self.passes.block[last]))
        behind += self._before_skipped()
        if not behind:
            return {}
        found, feed, mode = {}, "", ""
        wanted = set(behind)
        for number, line in enumerate(self.text.lines, start=1):
            feed, mode = self.words.feed_in(line) or feed, self.words.mode_in(line) or mode
            if number in wanted and (feed or self.inverse):
                found[number] = self.words.alone(feed, mode, self.inverse)
        return found

    def _behind_one_more(self) -> set[int]:
        """Lines that get a feed and are run behind the line before, which gets one too: the same is not written."""
        if self.inverse:
            return set()
        block, chosen = self.passes.block, self.chosen
        return set(block[1:][chosen[1:] & chosen[:-1] & (block[1:] == block[:-1] + 1)].tolist())

    def _may_set_feed(self, line: str) -> bool:
        """Whether a line has an F of any kind, or changes what it means."""
        return "F" in line.upper() or self.words.mode_in(line) != ""

    def _has_feed(self, line: int) -> bool:
        """Whether a line bears an F of its own, so that none needs to be in force."""
        return 0 < line <= len(self.text.lines) and self.words.feed_in(self.text.lines[line - 1]) != ""

    def _before_skipped(self) -> list[int]:
        """Lines that got a feed, each the last before one that was not read as run and that a switch (/) lets run."""
        chosen, run = np.unique(self.passes.block[self.chosen]), set(self.passes.block.tolist())
        found = []
        for number, line in enumerate(self.text.lines, start=1):
            if line.lstrip().startswith("/") and number not in run and (at := np.searchsorted(chosen, number)) > 0:
                found.append(int(chosen[at - 1]))
        return found

    def write(self, feeds: Mapping[int, Sequence[str]], pieces: Mapping[int, Sequence[str]]) -> Rewritten:
        """The program with feeds: line to the F of each of its pieces (of blocks that are not cut: one), and the lines
        that stand before those that are cut."""
        restores, behind = self.restores(), self._behind_one_more()
        changed: list[list[str]] = []
        bearers: dict[int, list[int]] = {}
        back, in_force, modal = [0], "", ""
        for number, line in enumerate(self.text.lines, start=1):
            new: list[str] = []
            in_force = self.words.feed_in(line) or in_force
            if number not in feeds:
                new.append(line)
            elif number in behind and [*feeds[number]] == [modal] and not self._may_set_feed(line):
                new.append(line)
                bearers[number] = [len(back)]
            else:
                bearers[number] = []
                for piece, feed in zip([*pieces.get(number, ()), line], feeds[number], strict=True):
                    new += self.words.with_feed(piece, feed, self.inverse, in_force)
                    bearers[number].append(len(back) - 1 + len(new))
                # FB of Sinumerik is not in force behind its block
                modal = feeds[number][-1] if any(map(self.words.feed_in, new)) else ""
            if number in feeds and number in restores:
                new.append(restores[number])
            changed.append(new)
            back += [number] * len(new)
        return Rewritten(self.text.with_lines(changed), np.array(back), bearers)


@dataclass(frozen=True)
class Rewritten:
    """A program with other feeds."""

    data: bytes
    back: Ints
    """(new lines + 1,) the line that each was before; 0 for no line."""
    bearers: Mapping[int, list[int]]
    """Line to the new lines that bear its feeds, one a piece."""

    def times(self, toolpath: ToolPath) -> dict[int, Floats]:
        """Line to what its feeds make of each of its pieces [s], by the program read again."""
        least = np.maximum(toolpath.way_length[1:] / toolpath.feed[1:], toolpath.least_time[1:])
        by_line = np.zeros(len(self.back) + 1)
        np.add.at(by_line, toolpath.block[1:], least)
        return {line: by_line[new] for line, new in self.bearers.items()}


def places(value: float, decimals: int) -> int:
    """Decimals with which a feed is written: six figures and at most so many decimals, or three figures."""
    first = math.floor(math.log10(value))
    return max(min(FIGURES - 1 - first, decimals), LEAST_FIGURES - 1 - first, 0)


def figure(value: float, decimals: int) -> str:
    """A feed as text, without zeros behind; never zero."""
    count = places(value, decimals)
    text = f"{max(value, 10.0**-count):.{count}f}"
    return text.rstrip("0").rstrip(".") if "." in text else text


def rounding(value: float, decimals: int) -> float:
    """By what share of a feed its text may be off."""
    return 0.5 * 10.0 ** -places(value, decimals) / value
