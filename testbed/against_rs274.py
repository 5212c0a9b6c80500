"""Our reading of LinuxCNC programs against LinuxCNC's own: the same places, order, feeds and dwells, the same refusals.

    python -m testbed.against_rs274 [--first SEED] [--programs N] [FILE...]

Places are compared in machine coordinates, so that offsets, rotations and tool lengths count; a difference is a place
off the way that the interpreter commands, a time of a motion at feed, a dwell, a line, or a refusal by one of both.
"""

from __future__ import annotations

import argparse
import re
import sys
import tempfile
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

import numpy as np

from testbed.linuxcnc.canon import INCH, Motion
from testbed.linuxcnc.job import Cartesian, Job
from testbed.linuxcnc.programs import random_job
from testbed.linuxcnc.rs274 import copy_called, judged
from testbed.linuxcnc.walk import Walk
from toolpace.errors import ToolpaceError
from toolpace.reading import read, read_text
from toolpace.toolpath import ToolPath

SAME, BOTH, OURS, THEIRS, DIFFERENT, UNTOLD = (
    "same", "refused by both", "refused by us only", "refused by rs274 only", "different", "not told by rs274",
)  # fmt: skip


class Verdict(NamedTuple):
    """What came of one program, read by both."""

    kind: str
    said: str = ""
    """What is different, or why it is refused."""


def compared(job: Job) -> Verdict:
    """Our reading of a program beside LinuxCNC's."""
    try:
        tools = {n: length / INCH for n, length in job.tools.items()}
        theirs = judged(job.text, job.parameters(), tools, beside=job.beside)
    except ValueError as error:
        return Verdict(UNTOLD, str(error))
    moving = any(_moves(motion) for motion in theirs.motions)
    try:
        ours = _read(job)
    except ToolpaceError as error:
        if not moving and not theirs.error and "there is no motion" in str(error):
            return Verdict(SAME)
        return Verdict(BOTH, theirs.error) if theirs.error else Verdict(OURS, str(error))
    if theirs.error:
        return Verdict(THEIRS, theirs.error)
    found = Walk(ours, theirs, numbered=job.numbered).difference()
    return Verdict(DIFFERENT, found) if found else Verdict(SAME)


def difference(job: Job) -> str:
    """What tells our reading from LinuxCNC's; empty where nothing does."""
    kind, said = compared(job)
    if kind == UNTOLD:
        raise ValueError(said)
    return "" if kind in (SAME, BOTH) else said if kind == DIFFERENT else f"{kind}: {said}"


KNOWN = {
    r"while G92 or G52 shifts": "a turned offset under G92: axes that are not named go elsewhere there",
    r"G(74|84) outside the plane of G17": "taps outside XY: other axes move there",
    r"is not read: set it before it is read": "a variable that nothing sets is zero there",
    r"a remainder of a division by zero": "MOD 0 is no number there, and the block goes on with it",
    r"G92(?:\.\d)? and \S+ exclude|\S+ and G92\.\d exclude": "G92.1 beside another word of coordinates",
    r"its label stands in line \d+ already": "do with a label of a loop before goes back to that loop there",
}
"""Refusals of ours alone that are meant, by what they say, and why."""


def surprise(job: Job) -> str:
    """A difference that is not meant."""
    kind, said = compared(job)
    meant = kind in (SAME, BOTH) or (kind == OURS and any(re.search(pattern, said) for pattern in KNOWN))
    return "" if meant else f"{kind}: {said}"


def _read(job: Job) -> ToolPath:
    if job.beside is None:
        return read_text(job.text, Cartesian(), controller="linuxcnc", setup=job.setup(), name="part.ngc")
    with tempfile.TemporaryDirectory(prefix="suite.") as folder:
        copy_called(job.beside, Path(folder))
        program = Path(folder) / "part.ngc"
        program.write_text(job.text, encoding="utf-8")
        return read(program, Cartesian(), controller="linuxcnc", setup=job.setup())


def _moves(motion: Motion) -> bool:
    return motion.normal >= 0 or bool(np.abs(motion.end - motion.start).max() > 0.0)


def main(arguments: Iterable[str]) -> int:
    """Compare, print every difference, end with how many there are."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--first", type=int, default=0, help="seed of the first program")
    parser.add_argument("--programs", type=int, default=1000, help="how many")
    parser.add_argument("--show", type=int, default=5, help="how many different programs are printed whole")
    parser.add_argument("files", nargs="*", type=Path, help="programs to compare in place of random ones")
    given = parser.parse_args(list(arguments))
    if given.files:
        jobs = ((str(file), Job(file.read_text(errors="replace"), numbered=False)) for file in given.files)
    else:
        jobs = ((f"seed {seed}", random_job(seed)) for seed in range(given.first, given.first + given.programs))
    different = tried = 0
    for name, job in jobs:
        tried += 1
        found = surprise(job)
        if found:
            different += 1
            print(f"{name}: {found}", flush=True)
            if different <= given.show and not given.files:
                print("    " + job.text.replace("\n", "\n    ").rstrip(), flush=True)
    print(f"{tried} programs, {different} different")
    return min(different, 1)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
