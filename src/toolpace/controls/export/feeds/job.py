"""The feeds that give each block the time which the plan takes for it.

What an F means is not worked out here: the program is read with one F everywhere, and its time tells.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.common.errors import ToolpaceError, UsageError, VerificationError
from toolpace.controls.export.feeds.block_times import Passes
from toolpace.controls.export.feeds.languages import LANGUAGES
from toolpace.controls.export.feeds.rewriting import Rewriting, Rewritten, figure
from toolpace.controls.export.feeds.text import ProgramText
from toolpace.controls.export.motion import PlannedMotion
from toolpace.machine.machine import Machine
from toolpace.motion.setpoints import SetPoints
from toolpace.programs.reading import ReadOptions, Source, read_source
from toolpace.programs.reading.languages import recognised
from toolpace.programs.toolpath import ToolPath

PROBE = 100.0
"""The F with which the program is read to learn what one means."""
CUT = ("word-address", "sinumerik")
"""Languages whose blocks can be cut."""

Pieces = Mapping[int, Sequence[str]]
"""Line to the lines that stand before it where it is cut."""


@dataclass(frozen=True)
class Job:
    """A program that was read, its plan, and which of its blocks get a feed."""

    source: Source
    machine: Machine
    dialect: str | None
    options: ReadOptions
    toolpath: ToolPath
    passes: Passes
    planned: Floats
    """(k,) how long the plan is on the way of each pass [s]."""
    rewriting: Rewriting

    @classmethod
    def of(cls, motion: PlannedMotion, inverse: bool, cut: bool) -> Job:
        """Raises UsageError where there is no program, or none whose blocks can bear such an F."""
        if motion.source is None or motion.record is None:
            raise UsageError(f"--to program: {motion.name} has no program beside it; take --to table")
        record = motion.record
        toolpath = read_source(motion.source, motion.machine, record.dialect, motion.options, feed=record.feed)
        return cls.beside(
            motion.source, motion.machine, record.dialect, motion.options, toolpath, motion.setpoints, inverse, cut
        )

    @classmethod
    def beside(
        cls,
        source: Source,
        machine: Machine,
        dialect: str | None,
        options: ReadOptions,
        toolpath: ToolPath,
        plan: SetPoints | Floats,
        inverse: bool = False,
        cut: bool = False,
    ) -> Job:
        """A program beside set-points, or beside the time (k,) of each of its passes [s]. Raises UsageError."""
        found = recognised(source, dialect, options)
        language = found.controller.language if found.controller is not None else found.dialect
        words = LANGUAGES.get(language)
        if words is None:
            raise UsageError("--to program: a table of points has no blocks that could bear an F; take --to table")
        if inverse and not (words.inverse and _has_inverse_times(found.controller)):
            raise UsageError(f"--inverse-time: {toolpath.controller or language} has no inverse times; leave it out")
        if cut and language not in CUT:
            raise UsageError(f"--split: blocks of {language} are not cut; leave it out")
        passes = Passes.of(toolpath)
        planned = passes.planned_times(toolpath, plan) if isinstance(plan, SetPoints) else plan
        rewriting = Rewriting.of(ProgramText.of(source.data), words, passes, planned, inverse)
        if not rewriting.chosen.any():
            raise UsageError("--to program: no block of the program runs once at a feed of its own; take --to table")
        return cls(source, machine, dialect, options, toolpath, passes, planned, rewriting)

    @property
    def lines(self) -> dict[int, int]:
        """Line to the pass of each block that gets a feed."""
        return {int(self.passes.block[k]): int(k) for k in np.flatnonzero(self.rewriting.chosen)}

    def read(self, new: Rewritten) -> ToolPath:
        """The program with other feeds, as it reads. Raises VerificationError where it does not."""
        try:
            return read_source(Source.from_bytes(new.data, self.source.name), self.machine, self.dialect, self.options)
        except ToolpaceError as error:
            raise VerificationError(f"with the feeds of the plan the program cannot be read: {error}") from None

    def probe(self, pieces: Pieces) -> tuple[Rewritten, ToolPath]:
        """The program with one F everywhere, and how it reads."""
        feeds = {line: [f"{PROBE:g}"] * (1 + len(pieces.get(line, ()))) for line in self.lines}
        new = self.rewriting.write(feeds, pieces)
        return new, self.read(new)

    def feeds(self, pieces: Pieces) -> dict[int, list[str]]:
        """Line to the F of each of its pieces, which take equal times."""
        new, read = self.probe(pieces)
        times = new.times(read)
        controller = self.options.controller
        seconds = self.rewriting.inverse and controller is not None and controller.option("inverse_seconds", False)
        feeds = {}
        for line, k in self.lines.items():
            right = self.planned[k] / len(times[line])
            values = np.full(len(times[line]), right) if seconds else PROBE * times[line] / right
            feeds[line] = [figure(value, self.rewriting.words.decimals) for value in values.tolist()]
        return feeds


def _has_inverse_times(controller: object) -> bool:
    """Whether G93 is that for a controller; for some it shifts the datum."""
    meanings = getattr(controller, "meanings", {})
    return bool(meanings.get("G93", "inverse time") == "inverse time")
