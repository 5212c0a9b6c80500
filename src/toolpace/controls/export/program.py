"""Target `program`: the program in its own dialect with the feeds of its plan, long blocks in pieces on demand.

Each block keeps its text, to the byte, but for its F: that which makes the dialect give the block the time that the
plan takes for it.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import ClassVar

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.common.errors import ToolpaceError, UsageError, VerificationError
from toolpace.common.units import format_time
from toolpace.common.value_objects import counted
from toolpace.controls.export.feed_words import NUMBER, code_of
from toolpace.controls.export.planned_feeds import SAME, Job, largest_change_of_kept, settled, strays
from toolpace.controls.export.rewriting import Rewritten, pose, rounding
from toolpace.controls.export.target import PlannedMotion, ReadBack, Written, provenance
from toolpace.controls.timing.program_time import figures_for, moves_of, time_of_moves
from toolpace.motion.setpoints import SetPoints
from toolpace.programs.reading import Source

DECIMALS, DIGITS = 5, 8
"""Of coordinates between those of the program, at most: no control takes fewer digits."""
_STRAIGHT = re.compile(
    rf"[ \t]*(?:N[ \t]*[0-9]+[ \t]*)?(?:G[ \t]*0*1(?![0-9.])[ \t]*)?((?:[XYZABCUVW][ \t]*=?[ \t]*{NUMBER}[ \t]*)+)"
    rf"(?:F(?:Z[ \t]*=)?[ \t]*{NUMBER}[ \t]*)?"
)
_AXIS = re.compile(rf"(?<![A-Z_0-9\]])([XYZABCUVW])[ \t]*=?[ \t]*({NUMBER})?")
_INCREMENTS = re.compile(r"(?<![A-Z_0-9])G[ \t]*9([01])(?![0-9.])")
HOW_TO = "how_to_use.txt"
SHORTEST_SPLIT = 1e-3
"""Of the pieces of blocks [s]."""
NAMED = 8
"""Lines that are named in a note."""


@dataclass
class Places:
    """The coordinate words in force before each line, as the text goes, and whether they are absolute."""

    before: dict[int, dict[str, float]] = field(default_factory=dict)
    """Line to the coordinates before it; lines that cannot be cut are missing."""

    @classmethod
    def of(cls, lines: Sequence[str]) -> Places:
        """Those of blocks that hold coordinates, G1 and F alone."""
        found, now, absolute = cls(), dict[str, float](), True
        for number, line in enumerate(lines, start=1):
            code = code_of(line)
            for mode in _INCREMENTS.findall(code):
                absolute = mode == "0"
            if absolute and _STRAIGHT.fullmatch(code.rstrip()):
                found.before[number] = dict(now)
            for letter, value in _AXIS.findall(code):
                if value and absolute:
                    now[letter] = float(value)
                else:
                    now.pop(letter, None)
        return found

    def pieces(self, number: int, line: str, shares: Floats) -> list[str] | None:
        """Lines that lead to shares of the way of a block; None where its beginning is not known."""
        before = self.before.get(number)
        match = _STRAIGHT.fullmatch(code_of(line).rstrip())
        if before is None or match is None:
            return None
        words = [(letter, float(value)) for letter, value in _AXIS.findall(match[1]) if value]
        if any(letter not in before for letter, _ in words):
            return None
        return [
            "G1 "
            + " ".join(f"{letter}{_number(before[letter] + share * (end - before[letter]))}" for letter, end in words)
            for share in shares.tolist()
        ]


def _number(value: float) -> str:
    """With its point, without which some controls count in their least increment."""
    decimals = max(min(DECIMALS, DIGITS - len(f"{abs(value):.0f}")), 0)
    text = f"{value + 0.0:.{decimals}f}"
    return text.rstrip("0") if "." in text else f"{text}."


def cut(job: Job, points: SetPoints, seconds: float) -> dict[int, list[str]]:
    """Line to what stands before it, so that it is done in pieces of about so many seconds: of blocks that are
    straight, of coordinates alone, and that read as they did before."""
    places, lines = Places.of(job.rewriting.text.lines), job.rewriting.text.lines
    ends = job.passes.ends(job.toolpath, points)
    pieces: dict[int, list[str]] = {}
    for line, k in job.lines.items():
        count = round(float(job.planned[k]) / seconds)
        if count < 2:
            continue
        waits = float(job.toolpath.dwell[job.passes.first[k] : job.passes.last[k] + 1].sum())
        start = float(ends[k]) - waits - float(job.planned[k])
        shares = shares_at(job, k, points, start + float(job.planned[k]) * np.arange(1, count) / count)
        found = None if shares is None else places.pieces(line, lines[line - 1], shares)
        if found:
            pieces[line] = found
    while pieces:
        wrong = {int(block) for block in job.passes.block[strays(job, *job.probe(pieces))]} & set(pieces)
        if not wrong:
            break
        pieces = {line: found for line, found in pieces.items() if line not in wrong}
    return pieces


def shares_at(job: Job, k: int, points: SetPoints, times: Floats) -> Floats | None:
    """(n,) how much of the straight way of pass k is done at times (n,) [s]; None where it does not go forward."""
    first, last = int(job.passes.first[k]) - 1, int(job.passes.last[k])
    ends = pose(job.toolpath.tip[[first, last]], job.toolpath.axis[[first, last]])
    way = ends[1] - ends[0]
    length = float(way @ way)
    if length <= 0.0:
        return None
    row = np.clip(np.searchsorted(points.t, times, side="right") - 1, 0, len(points) - 2)
    part = ((times - points.t[row]) / (points.t[row + 1] - points.t[row]))[:, None]
    here = pose(points.tip[row], points.axis[row])
    here = here + part * (pose(points.tip[row + 1], points.axis[row + 1]) - here)
    shares: Floats = (here - ends[0]) @ way / length
    forward = np.concatenate([[0.0], shares, [1.0]])
    return shares if (np.diff(forward) > 0.0).all() else None


@dataclass(frozen=True, kw_only=True)
class NewFeeds(Written):
    """The program that was written, and what it was made from."""

    job: Job = field(repr=False)
    new: Rewritten = field(repr=False)
    feeds: dict[int, list[str]] = field(repr=False)
    """Line to the F of each of its pieces."""


@dataclass(frozen=True, kw_only=True)
class Program:
    """The program with an F for each of its blocks."""

    name: ClassVar[str] = "program"
    inverse_time: bool = False
    """Whether F is the inverse of a block's time (G93)."""
    split: float | None = None
    """Straight blocks that take longer are cut into pieces of about this time [s]; None: none is."""

    def __post_init__(self) -> None:
        if self.split is not None and not self.split >= SHORTEST_SPLIT:
            raise UsageError(f"--split {self.split:g}s: pieces of less than 1 ms are none that a control reads in time")

    def write(self, motion: PlannedMotion, folder: Path) -> NewFeeds:
        """Write the program and how_to_use.txt. Raises UsageError where its dialect has no such feeds."""
        if motion.record is not None and motion.record.bending is not None:
            raise UsageError(
                f"{motion.name}: its path is compensated for the bending of the tool, and the points in the text of "
                "the program are not; export set-points: --to table, linuxcnc-hal or linuxcnc-g93"
            )
        job = Job.of(motion, self.inverse_time, self.split is not None)
        pieces = {} if self.split is None else cut(job, motion.setpoints, self.split)
        feeds = job.feeds(pieces)

        def write(job: Job) -> Rewritten:
            here = job.lines
            return job.rewriting.write(
                {line: found for line, found in feeds.items() if line in here},
                {line: found for line, found in pieces.items() if line in here},
            )

        job, new, _ = settled(job, write)
        feeds, pieces = (
            {line: each for line, each in found.items() if line in job.lines} for found in (feeds, pieces)
        )
        assert motion.record is not None
        file = motion.record.program_file
        (folder / file).write_bytes(new.data)
        notes = self._notes(motion, job, len(pieces), sum(map(len, pieces.values())))
        notes += [note] if (note := expected(job, new)) else []
        text = [*provenance(motion, "The program with the feeds of its plan"), "", *self._how_to_use(), "", *notes]
        (folder / HOW_TO).write_text("\n".join(text) + "\n", encoding="utf-8")
        return NewFeeds([file, HOW_TO], notes, job=job, new=new, feeds=feeds)

    def check(self, motion: PlannedMotion, folder: Path, written: Written) -> list[ReadBack]:
        """The same path must be read from it, in the planned times, and with the old feeds where blocks keep theirs."""
        assert isinstance(written, NewFeeds)
        job, new, file = written.job, written.new, folder / written.files[0]
        if file.read_bytes() != new.data:
            raise VerificationError(
                f"{file.name}: read back it is not what was written; nothing was written; is the disk sound?"
            )
        again = job.read(new)
        other = strays(job, new, again)
        if other.any():
            block = int(job.passes.block[int(np.argmax(other))])
            raise VerificationError(f"{file.name}: read back its block {block} leads elsewhere; nothing was written")
        worst, allowed, decimals = 0.0, SAME, job.rewriting.words.decimals
        lines, times = job.lines, new.times(again)
        for line, feeds in written.feeds.items():
            right = job.planned[lines[line]] / len(feeds)
            worst = max(worst, float(np.abs(times[line] / right - 1.0).max()))
            allowed = max(allowed, SAME + max(1.001 * rounding(float(feed), decimals) for feed in feeds))
        kept = largest_change_of_kept(job, new, again)
        return [
            ReadBack("largest relative difference of a block's time", worst, allowed).raise_if_failed(file),
            ReadBack("largest relative change of a time of blocks that keep their feed", kept, SAME).raise_if_failed(
                file
            ),
        ]

    def _notes(self, motion: PlannedMotion, job: Job, cuts: int, more: int) -> list[str]:
        rewriting = job.rewriting
        blocks, kept = int(rewriting.chosen.sum()), np.unique(job.passes.block[rewriting.kept]).tolist()
        notes = [
            f"{counted(blocks, 'block')} with F as planned" + (", as inverse times (G93)" if self.inverse_time else "")
        ]
        if kept:
            named = ", ".join(map(str, kept[:NAMED])) + (", ..." if len(kept) > NAMED else "")
            notes.append(
                f"{counted(len(kept), 'line')} with the old feed, since motions of cycles, loops, subprograms and "
                f"threads have no single one, and some follow an F that the text does not tell: {named}"
            )
        if self.split is not None:
            left = int((rewriting.chosen & (np.rint(job.planned / self.split) >= 2)).sum()) - cuts
            notes.append(
                f"{counted(cuts, 'block')} divided, {counted(more, 'line')} added"
                + (f"; {counted(left, 'longer block')} left whole, which hold more than coordinates" if left else "")
            )
        total = float(job.planned[rewriting.chosen].sum())
        notes.append(
            f"with these feeds the blocks take {format_time(total)} of the plan's {format_time(motion.duration)}; a "
            "control that slows down at the ends of blocks takes longer"
        )
        return notes

    def _how_to_use(self) -> list[str]:
        return [
            "The program is the one that was planned, block for block; only F is another: the speed that the "
            "plan has in",
            "the block on the mean" + (", as an inverse time (G93)." if self.inverse_time else "."),
            "",
            "1. Load it as the program before: same offsets, same tool, same tool-centre-point mode.",
            "2. Leave look-ahead and smoothing of the control as they are: the control plans this program "
            "itself, and its",
            "   own limits must be at least those of the machine file, or it will be slower.",
            "3. Feed override at 100 %. First without a workpiece, with the spindle off.",
            "What toolpace does not know: how this control rounds corners, and whether it stops at ends of "
            "blocks. Where",
            "blocks are short, an F of their own each may make a control slower than one F for all: compare the times.",
        ]


def expected(job: Job, new: Rewritten) -> str:
    """ "by the model linuxcnc the control takes 25.10 s with these feeds, 24.90 s with the old ones"; empty where the
    controller has no model."""
    try:
        figures = figures_for(job.options, None)
        if figures.model == "ideal":
            return ""
        times = []
        for source in (Source.from_bytes(new.data, job.source.name), job.source):
            moves = moves_of(source, job.machine, job.options, None, job.dialect)
            times.append(time_of_moves(moves, job.machine, figures, job.options.setup.tool_change).total)
    except ToolpaceError:
        # What was planned with --feed may have no feeds of its own to be timed by.
        return ""
    now, before = map(format_time, times)
    return f"by the model {figures.model} the control takes {now} with these feeds, {before} with the old ones"
