"""Our reading of LinuxCNC programs against LinuxCNC's own: the same places, order, feeds and dwells, the same refusals.

    python -m testbed.against_rs274 [--first SEED] [--programs N] [--contours | --loops] [FILE...]

Places are compared in machine coordinates, so that offsets, rotations and tool lengths count; a difference is a place
off the way that the interpreter commands, a time of a motion at feed, a dwell, a line, or a refusal by one of both.
"""

from __future__ import annotations

import argparse
import re
import sys
import tempfile
from collections import Counter
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

import numpy as np

from testbed.linuxcnc.canon import INCH, Judged, Motion
from testbed.linuxcnc.contours import random_contour
from testbed.linuxcnc.job import Cartesian, Job
from testbed.linuxcnc.nested import nested_job
from testbed.linuxcnc.programs import random_job
from testbed.linuxcnc.rs274 import NAME, copy_called, judged
from testbed.linuxcnc.walk import Walk
from toolpace.common.errors import ToolpaceError
from toolpace.programs.reading import read, read_text
from toolpace.programs.toolpath import ToolPath

SAME, BOTH, OURS, THEIRS, DIFFERENT, UNTOLD = (
    "same", "refused by both", "refused by us only", "refused by rs274 only", "different", "not told by rs274",
)  # fmt: skip
NO_END = "refused by both, the same up to an end that is missing"
AGREED = (SAME, BOTH, NO_END)
NO_END_SAID = "File ended with no percent sign"


class Verdict(NamedTuple):
    """What came of one program, read by both."""

    kind: str
    said: str = ""
    """What is different, or why it is refused."""


def compared(job: Job) -> Verdict:
    """Our reading of a program beside LinuxCNC's."""
    try:
        tools = {n: length / INCH for n, length in job.tools.items()}
        diameters = {n: 2.0 * radius / INCH for n, radius in job.radii.items()}
        theirs = judged(job.text, job.parameters(), tools, diameters, beside=job.beside)
    except ValueError as error:
        return Verdict(UNTOLD, str(error))
    moving = any(_moves(motion) for motion in theirs.motions)
    try:
        ours = read_job(job)
    except ToolpaceError as error:
        if not moving and not theirs.error and "there is no motion" in str(error):
            return Verdict(SAME)
        if not theirs.error:
            return Verdict(OURS, str(error))
        return _without_end(job, theirs, moving) if NO_END_SAID in theirs.error else Verdict(BOTH, theirs.error)
    if theirs.error:
        return Verdict(THEIRS, theirs.error)
    found = Walk(ours, theirs, numbered=job.numbered).difference()
    return Verdict(DIFFERENT, found) if found else Verdict(SAME)


def _without_end(job: Job, theirs: Judged, moving: bool) -> Verdict:
    """A program that has no end, read on to it by both."""
    try:
        ours = read_job(job, lenient=True)
    except ToolpaceError as error:
        kind = NO_END if not moving and "there is no motion" in str(error) else BOTH
        return Verdict(kind, f"{theirs.error}; {error}")
    found = Walk(ours, theirs, numbered=job.numbered).difference()
    return Verdict(DIFFERENT, found) if found else Verdict(NO_END, theirs.error)


def difference(job: Job) -> str:
    """What tells our reading from LinuxCNC's; empty where nothing does."""
    kind, said = compared(job)
    if kind == UNTOLD:
        raise ValueError(said)
    return "" if kind in AGREED else said if kind == DIFFERENT else f"{kind}: {said}"


KNOWN = {
    r"while G92 or G52 shifts": "a turned offset under G92: axes that are not named go elsewhere there",
    r"G(74|84) outside the plane of G17": "taps outside XY: other axes move there",
    r"is not read: set it before it is read": "a variable that nothing sets is zero there",
    r"is no number: check the expression": "what is infinite, or no number, goes on there",
    r"a remainder of a division by zero": "MOD 0 is no number there, and the block goes on with it",
    r"G92(?:\.\d)? and \S+ exclude|\S+ and G92\.\d exclude": "G92.1 beside another word of coordinates",
    r"M0 or M1 stands before an inside corner": "its interpreter gouges such a corner",
    r"closes but for a rounding": "a compensated circle that its planner may take for nothing",
    r"a change of the unit .* under cutter compensation": "G20 and G21 within a compensated contour",
    r"in LinuxCNC's interpreter this": "a loop that another one, which was left in its middle, changes there",
    r"may take the same letters": "M19, M61 or M66 beside a cycle, of which both use L, P, Q or R there",
    r"G43\.[12] and \S+ both take": "offsets of a tool beside a motion, both take its axes there",
    r"a full circle, or none": "an arc that is a circle on a machine in inch alone",
    r"its label stands in line \d+ already": "do with a label of a loop before goes back to that loop there",
}
"""Refusals of ours alone that are meant, by what they say, and why."""


def meant(verdict: Verdict) -> str:
    """What kind of agreement a verdict is, or why a refusal of ours alone is meant; empty where it is a surprise."""
    if verdict.kind in AGREED:
        return verdict.kind
    why = [why for pattern, why in KNOWN.items() if verdict.kind == OURS and re.search(pattern, verdict.said)]
    return f"{OURS}: {why[0]}" if why else ""


def surprise(job: Job) -> str:
    """A difference that is not meant."""
    verdict = compared(job)
    return "" if meant(verdict) else f"{verdict.kind}: {verdict.said}"


def read_job(job: Job, *, lenient: bool = False) -> ToolPath:
    """Our reading of a program, on the machine of the comparison. Raises ToolpaceError."""
    if job.beside is None:
        name = "part.ngc"
        return read_text(job.text, Cartesian(), controller="linuxcnc", setup=job.setup(), name=name, lenient=lenient)
    with tempfile.TemporaryDirectory(prefix="suite.") as folder:
        copy_called(job.beside, Path(folder))
        program = Path(folder) / NAME
        program.write_text(job.text, encoding="utf-8")
        return read(program, Cartesian(), controller="linuxcnc", setup=job.setup(), lenient=lenient)


def _moves(motion: Motion) -> bool:
    return motion.normal >= 0 or bool(np.abs(motion.end - motion.start).max() > 0.0)


def main(arguments: Iterable[str]) -> int:
    """Compare, print every difference, end with how many there are."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--first", type=int, default=0, help="seed of the first program")
    parser.add_argument("--programs", type=int, default=1000, help="how many")
    parser.add_argument("--contours", action="store_true", help="contours with cutter compensation")
    parser.add_argument("--loops", action="store_true", help="loops, conditions and calls within each other")
    parser.add_argument("--show", type=int, default=5, help="how many different programs are printed whole")
    parser.add_argument("files", nargs="*", type=Path, help="programs to compare in place of random ones")
    given = parser.parse_args(list(arguments))
    if given.files:
        jobs = ((str(file), Job(file.read_text(errors="replace"), numbered=False)) for file in given.files)
    else:
        job_of = random_contour if given.contours else nested_job if given.loops else random_job
        jobs = ((f"seed {seed}", job_of(seed)) for seed in range(given.first, given.first + given.programs))
    different = 0
    counts: Counter[str] = Counter()
    for name, job in jobs:
        verdict = compared(job)
        found = meant(verdict)
        counts[found or verdict.kind] += 1
        if not found:
            different += 1
            print(f"{name}: {verdict.kind}: {verdict.said}", flush=True)
            if different <= given.show and not given.files:
                print("    " + job.text.replace("\n", "\n    ").rstrip(), flush=True)
    for kind, count in counts.most_common():
        print(f"{count:6d} {kind}")
    print(f"{counts.total()} programs, {different} different")
    return min(different, 1)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
