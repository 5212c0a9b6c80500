"""Our reading of LinuxCNC programs against LinuxCNC's own: the same places, order, feeds and dwells, the same refusals.

    python -m testbed.against_rs274 [--first SEED] [--programs N] [--contours] [FILE...]

Places are compared in machine coordinates, so that offsets, rotations and tool lengths count; a difference is a place
off the way that the interpreter commands, a time of a motion at feed, a dwell, a line, or a refusal by one of both.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable
from pathlib import Path

import numpy as np

from testbed.linuxcnc.canon import INCH, Motion
from testbed.linuxcnc.contours import random_contour
from testbed.linuxcnc.job import Cartesian, Job
from testbed.linuxcnc.programs import random_job
from testbed.linuxcnc.rs274 import judged
from testbed.linuxcnc.walk import Walk
from toolpace.errors import ToolpaceError
from toolpace.reading import read_text


def difference(job: Job) -> str:
    """What tells our reading from LinuxCNC's; empty where nothing does."""
    diameters = {n: 2.0 * radius / INCH for n, radius in job.radii.items()}
    lengths = {n: length / INCH for n, length in job.tools.items()}
    theirs = judged(job.text, job.parameters(), lengths, diameters)
    moving = any(_moves(motion) for motion in theirs.motions)
    try:
        ours = read_text(job.text, Cartesian(), controller="linuxcnc", setup=job.setup(), name="part.ngc")
    except ToolpaceError as error:
        if theirs.error or (not moving and "there is no motion" in str(error)):
            return ""
        return f"refused by us only: {error}"
    if theirs.error:
        return f"refused by rs274 only: {theirs.error}"
    return Walk(ours, theirs).difference()


def _moves(motion: Motion) -> bool:
    return motion.normal >= 0 or bool(np.abs(motion.end - motion.start).max() > 0.0)


def main(arguments: Iterable[str]) -> int:
    """Compare, print every difference, end with how many there are."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--first", type=int, default=0, help="seed of the first program")
    parser.add_argument("--programs", type=int, default=1000, help="how many")
    parser.add_argument("--contours", action="store_true", help="contours with cutter compensation")
    parser.add_argument("--show", type=int, default=5, help="how many different programs are printed whole")
    parser.add_argument("files", nargs="*", type=Path, help="programs to compare in place of random ones")
    given = parser.parse_args(list(arguments))
    job_of = random_contour if given.contours else random_job
    jobs = ((str(file), Job(file.read_text(errors="replace"))) for file in given.files) if given.files else (
        (f"seed {seed}", job_of(seed)) for seed in range(given.first, given.first + given.programs)
    )  # fmt: skip
    different = tried = 0
    for name, job in jobs:
        tried += 1
        found = difference(job)
        if found:
            different += 1
            print(f"{name}: {found}", flush=True)
            if different <= given.show and not given.files:
                print("    " + job.text.replace("\n", "\n    ").rstrip(), flush=True)
    print(f"{tried} programs, {different} different")
    return min(different, 1)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
