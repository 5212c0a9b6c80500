"""Target `program`: the program in its own dialect with the feeds of its plan, and its time on the control.

Each block keeps its text, to the byte, but for its F: that which makes the dialect give the block the time that the
plan takes for it.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import ClassVar

import numpy as np

from toolpace.common.errors import ToolpaceError, UsageError, VerificationError
from toolpace.common.units import format_time
from toolpace.common.value_objects import counted
from toolpace.controls.export.feeds.block_splitting import cut
from toolpace.controls.export.feeds.comparison import largest_change_of_kept, strays
from toolpace.controls.export.feeds.job import Job
from toolpace.controls.export.feeds.rewriting import Rewritten, rounding
from toolpace.controls.export.motion import PlannedMotion
from toolpace.controls.export.provenance import provenance
from toolpace.controls.export.target import ReadBack, Written
from toolpace.controls.timing.program import figures_for, moves_of
from toolpace.controls.timing.program_time import time_of_moves
from toolpace.programs.reading import Source

HOW_TO = "how_to_use.txt"
SAME = 1e-9
"""Relative rounding of times that are worked out twice."""
SHORTEST_SPLIT = 1e-3
"""Of the pieces of blocks [s]."""
NAMED = 8
"""Lines that are named in a note."""


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
        new = job.rewriting.write(feeds, pieces)
        assert motion.record is not None
        file = motion.record.program_file
        (folder / file).write_bytes(new.data)
        notes = self._notes(motion, job, len(pieces), sum(map(len, pieces.values())))
        notes += [told] if (told := expected(job, new)) else []
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
                f"threads have no single one: {named}"
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
