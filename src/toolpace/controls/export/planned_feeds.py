"""The feeds that give each block the time which the plan takes for it, and the check that the path stays the same.

What an F means is not worked out here: the program is read with one F everywhere, and its time tells.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from toolpace.common.arrays import Bools, Floats, Ints
from toolpace.common.errors import ToolpaceError, UsageError, VerificationError
from toolpace.controls.export.feed_words import LANGUAGES
from toolpace.controls.export.rewriting import Passes, ProgramText, Rewriting, Rewritten, figure, pose
from toolpace.controls.export.target import PlannedMotion
from toolpace.machine.machine import Machine
from toolpace.motion.setpoints import SetPoints
from toolpace.programs.reading import ReadOptions, Source, read_source
from toolpace.programs.reading.languages import recognised
from toolpace.programs.toolpath import ToolPath

PROBE = 1.0
"""The F with which the program is read to learn what one means: per minute, turn or tooth, or as an inverse time."""
CUT = ("word-address", "sinumerik")
"""Languages whose blocks can be cut."""
SAME = 1e-9
"""Share by which the time of a block that keeps its text may differ: rounding."""

Pieces = Mapping[int, Sequence[str]]
"""Line to the lines that stand before it where it is cut."""
CUT_TIP, CUT_AXIS = 1e-6, 1e-5
"""How far places at which a block is cut may lie beside its way as it was read [m], [rad]."""


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
        job = cls.beside(
            motion.source, motion.machine, record.dialect, motion.options, toolpath, motion.setpoints, inverse, cut
        )
        if not job.rewriting.chosen.any():
            raise UsageError("--to program: no block of the program runs once at a feed of its own; take --to table")
        return job

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
        # read back, it is for the same control: what others would make of it has been said
        own = replace(options, controller=found.controller, others=())
        return cls(source, machine, dialect, own, toolpath, passes, planned, rewriting)

    def without(self, passes: Bools) -> Job:
        """The same, where some passes (k,) keep their text."""
        return replace(self, rewriting=replace(self.rewriting, chosen=self.rewriting.chosen & ~passes))

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

    def probe(self, pieces: Pieces, feed: float = PROBE) -> tuple[Rewritten, ToolPath]:
        """The program with one F everywhere, and how it reads."""
        feeds = {line: [f"{feed:g}"] * (1 + len(pieces.get(line, ()))) for line in self.lines}
        new = self.rewriting.write(feeds, pieces)
        return new, self.read(new)

    def feeds(self, pieces: Pieces) -> dict[int, list[str]]:
        """Line to the F of each of its pieces, which take equal times."""
        new, read = self.probe(pieces)
        times = new.times(read)
        planned = {
            line: np.full(len(times[line]), self.planned[k] / len(times[line])) for line, k in self.lines.items()
        }
        decimals = self.rewriting.words.decimals
        return {
            line: [figure(value, decimals) for value in values.tolist()]
            for line, values in self.values(times, planned, pieces).items()
        }

    def values(
        self, times: Mapping[int, Floats], planned: Mapping[int, Floats], pieces: Pieces
    ) -> dict[int, Floats]:
        """Line to the F with which each of its pieces takes a planned time (n,) [s], from the `times` with PROBE."""
        controller, longer = self.options.controller, {}
        if controller is not None and controller.option("inverse_seconds", False):
            # where F is the seconds of a block, twice the F is twice the time
            new, read = self.probe(pieces, 2.0 * PROBE)
            longer = {line: twice > times[line] for line, twice in new.times(read).items()}
        return {
            line: PROBE * np.where(longer.get(line, False), planned[line] / probed, probed / planned[line])
            for line, probed in times.items()
        }


def _has_inverse_times(controller: object) -> bool:
    """Whether G93 is that for a controller; for some it shifts the datum."""
    meanings = getattr(controller, "meanings", {})
    return bool(meanings.get("G93", "inverse time") == "inverse time")


def in_old_blocks(toolpath: ToolPath, new: Rewritten) -> ToolPath:
    """The path of a program that was written anew, its blocks named as they were before."""
    return replace(toolpath, block=new.back[toolpath.block])


def strays(job: Job, new: Rewritten, again: ToolPath) -> Bools:
    """(k,) passes whose way is another than before; all of them where it has other blocks."""
    old, again = job.toolpath, in_old_blocks(again, new)
    was, now = job.passes, Passes.of(again)
    if len(now.block) != len(was.block) or (now.block != was.block).any():
        return np.ones(len(was.block), dtype=np.bool_)
    found = np.zeros(len(was.block), dtype=np.bool_)
    for k, (a, b, c, d) in enumerate(zip(was.first, was.last, now.first, now.last)):
        before, behind = slice(a - 1, b + 1), slice(c - 1, d + 1)
        ends = old.stop[b] == again.stop[d] and old.dwell[b] == again.dwell[d] and was.rapid[k] == now.rapid[k]
        if b - a == d - c and (old.tip[before] == again.tip[behind]).all():
            same = bool((old.axis[before] == again.axis[behind]).all())
        else:
            tip, axis = off_the_way(old.tip[before], old.axis[before], again.tip[behind], again.axis[behind])
            same = tip <= CUT_TIP and axis <= CUT_AXIS
        found[k] = not (same and ends)
    return found


def off_the_way(tip: Floats, axis: Floats, tips: Floats, axes: Floats) -> tuple[float, float]:
    """How far points (n, 3) lie beside the polygon through (k, 3): distance [m] and angle [rad]; both end alike."""
    corners, points = pose(tip, axis), pose(tips, axes)
    step = np.diff(corners, axis=0)
    length = np.maximum((step**2).sum(axis=1), 1e-300)
    far = [float(np.linalg.norm(tips[-1] - tip[-1]))]
    turned = [float(np.linalg.norm(axes[-1] - axis[-1]))]
    for point, here, leaning in zip(points, tips, axes):
        share = np.clip(((point - corners[:-1]) * step).sum(axis=1) / length, 0.0, 1.0)
        near = corners[:-1] + share[:, None] * step
        k = int(((near - point) ** 2).sum(axis=1).argmin())
        far.append(float(np.linalg.norm(tip[k] + share[k] * (tip[k + 1] - tip[k]) - here)))
        turned.append(float(np.linalg.norm(axis[k] + share[k] * (axis[k + 1] - axis[k]) - leaning)))
    return max(far), max(turned)


def settled(job: Job, write: Callable[[Job], Rewritten]) -> tuple[Job, Rewritten, ToolPath]:
    """A job, as it is written and as that reads, with as many blocks as leave those that keep their text their feed.

    Where the text does not tell which feed is in force (a subprogram or a variable has changed it), the blocks before
    keep their text too. Raises VerificationError where that does not help.
    """
    while True:
        new = write(job)
        again = job.read(new)
        wrong = change_of_kept(job, new, again) > SAME
        if not wrong.any():
            return job, new, again
        before = job.rewriting.chosen & _before(wrong, job.rewriting.kept)
        if not before.any():
            raise VerificationError(
                f"read back, block {int(job.passes.block[int(np.argmax(wrong))])} keeps its text and has another feed; "
                "nothing was written"
            )
        job = job.without(before)


def _before(wrong: Bools, kept: Bools) -> Bools:
    """(k,) passes between one that is `wrong` (k,) and the last before it that is `kept` (k,)."""
    behind: Ints = np.cumsum(kept) - kept
    found: Bools = np.isin(behind, behind[wrong]) & ~kept
    return found


def largest_change_of_kept(job: Job, new: Rewritten, again: ToolPath) -> float:
    """Largest relative change of the time that the feeds make of blocks that keep theirs."""
    return float(change_of_kept(job, new, again).max(initial=0.0))


def change_of_kept(job: Job, new: Rewritten, again: ToolPath) -> Floats:
    """(k,) relative change of the time that the feeds make of each pass that keeps its text; 0 of the others."""
    before = job.passes.asked_times(job.toolpath)
    now = Passes.of(in_old_blocks(again, new)).asked_times(again)
    if len(now) != len(before):
        raise VerificationError("read back, the new program has other blocks; nothing was written")
    kept = job.rewriting.kept & np.isfinite(before) & (before > 0.0)
    return np.where(kept, np.abs(now / np.where(kept, before, 1.0) - 1.0), 0.0)
