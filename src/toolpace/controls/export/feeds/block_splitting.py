"""Straight blocks split into pieces."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.controls.export.feeds.block_times import pose
from toolpace.controls.export.feeds.comparison import strays
from toolpace.controls.export.feeds.job import Job
from toolpace.controls.export.feeds.word_address import code_of
from toolpace.motion.setpoints import SetPoints

DECIMALS = 6
"""Of coordinates between those of the program."""
_NUMBER = r"[-+]?(?:[0-9]++\.?[0-9]*+|\.[0-9]++)"
_STRAIGHT = re.compile(
    rf"[ \t]*(?:N[ \t]*[0-9]+[ \t]*)?(?:G[ \t]*0*1(?![0-9.])[ \t]*)?((?:[XYZABCUVW][ \t]*=?[ \t]*{_NUMBER}[ \t]*)+)"
    rf"(?:F[ \t]*{_NUMBER}[ \t]*)?"
)
_AXIS = re.compile(rf"(?<![A-Z_0-9\]])([XYZABCUVW])[ \t]*=?[ \t]*({_NUMBER})?")
_INCREMENTS = re.compile(r"(?<![A-Z_0-9])G[ \t]*9([01])(?![0-9.])")


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
                if value:
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
    return f"{value + 0.0:.{DECIMALS}f}".rstrip("0").rstrip(".")


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
