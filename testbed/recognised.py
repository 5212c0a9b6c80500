"""Which control programs are taken for, against the control that they were written for.

    python -m testbed.recognised [--bare] [--list] FOLDER...
    python -m testbed.recognised --random N

Each folder is named for the true control and holds programs of it; `--bare` hides their names, as of programs that
were saved as .nc. Programs that are taken for another's are read as both: what matters is those that move otherwise,
and of them those of which nothing is said. `--random` takes N random programs of each control in place of folders,
without names, and with the set-up sheet that they are written for.
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

import toolpace as tp
from testbed.one_program.generate import generate
from testbed.one_program.run import WRITERS, machine, set_up
from testbed.one_program.writer import CannotWriteError
from toolpace.common.errors import ToolpaceError
from toolpace.machine.machine import Machine
from toolpace.programs.reading import read_source
from toolpace.programs.reading.coordinates.setup import SetUp
from toolpace.programs.reading.languages import recognised
from toolpace.programs.reading.options import ReadOptions
from toolpace.programs.reading.source import Source
from toolpace.programs.toolpath import ToolPath

MACHINES = ("xyzac-trunnion", "xyzbc-trunnion")
"""Programs are read on the first of them that reads them as their true control's."""
READ: dict[str, Any] = {"skip_unknown": True, "compensation": "program"}
"""Words that are not read are passed over, so that what stands beside them is compared too."""
OUTCOMES = {
    "alike": "both read it alike",
    "refused": "refused, for the control that it is taken for",
    "said": "read otherwise, and that is said",
    "unsaid": "read otherwise, unsaid",
    "by both": "refused for both",
    "true only": "refused for the true control alone",
}
NO_PROGRAM = "no program"
RANDOM = ("fanuc", "haas", "linuxcnc", "mazak", "millplus", "sinumerik", "heidenhain")
"""Dialects of random programs: those of controls."""
Came = tuple[str, str, str]
"""Name of a program, the control that it is taken for, and `right` or a key of OUTCOMES."""


def outcome(source: Source, true: str, machines: Iterable[Machine], sheet: SetUp | None = None) -> str:
    """What comes of taking a program for another control's: a key of OUTCOMES."""
    for candidate in machines:
        meant, found = (
            _read(source, candidate, ReadOptions.of(controller=each, setup=sheet, **READ)) for each in (true, None)
        )
        if meant is not None:
            break
    if meant is None:
        return "by both" if found is None else "true only"
    if found is None:
        return "refused"
    if same(meant, found):
        return "alike"
    return "said" if any("--controller" in each and true in each for each in found.assumed) else "unsaid"


def same(one: ToolPath, other: ToolPath) -> bool:
    """Whether two tool paths have the same points to 0.1 micrometre, axes, feeds, times and dwells."""
    if len(one.tip) != len(other.tip):
        return False
    return all(
        np.allclose(getattr(one, name), getattr(other, name), rtol=1e-6, atol=1e-7)
        for name in ("tip", "axis", "feed", "least_time", "dwell", "rapid")
    )


def _read(source: Source, machine: Machine, options: ReadOptions) -> ToolPath | None:
    try:
        return read_source(source, machine, None, options)
    except ToolpaceError:
        return None


def taken_for(source: Source) -> str:
    """The control that a program is taken for; NO_PROGRAM where its dialect is not told."""
    try:
        found = recognised(source, None, ReadOptions())
    except ToolpaceError:
        return NO_PROGRAM
    return found.controller.name if found.controller is not None else found.dialect


def programs(folder: Path, bare: bool) -> Iterator[tuple[str, Source]]:
    """The text files of a folder, with their names; bare: as if they were called program.nc."""
    for file in sorted(path for path in folder.iterdir() if path.is_file()):
        try:
            yield file.name, Source.from_bytes(file.read_bytes(), "program.nc" if bare else file.name)
        except ToolpaceError:
            print(f"{file}: no text file", file=sys.stderr)


def outcomes_of_folder(folder: Path, bare: bool) -> Iterator[Came]:
    """Of each program of a folder that is named for its control."""
    machines = [tp.Machine.load(name) for name in MACHINES]
    for name, source in programs(folder, bare):
        taken = taken_for(source)
        yield name, taken, "right" if taken == folder.name else outcome(source, folder.name, machines)


def random_outcomes(dialect: str, seeds: Iterable[int]) -> Iterator[Came]:
    """Of random programs in a dialect, as far as it has words for them."""
    for seed in seeds:
        program = generate(seed)
        try:
            source = Source.from_text(WRITERS[dialect](program).write(), "program.nc")
        except CannotWriteError:
            continue
        taken = taken_for(source)
        sheet = set_up(program, dialect)
        right = taken == dialect
        yield str(seed), taken, "right" if right else outcome(source, dialect, [machine(program.machine)], sheet)


def table(true: str, outcomes: Iterable[Came], listed: bool) -> int:
    """Print the rows of programs of one control; how many move otherwise unsaid."""
    found: dict[str, Counter[str]] = {}
    for name, taken, came in outcomes:
        found.setdefault(taken, Counter())[came] += 1
        if listed and came != "right":
            print(f"{true} {taken} {came}: {name}", file=sys.stderr, flush=True)
    for taken, came_of in sorted(found.items(), key=lambda item: -item[1].total()):
        figures = "".join(f" {came_of[key] or ''} |" for key in OUTCOMES)
        print(f"| {true} | {taken} | {came_of.total()} |{figures}", flush=True)
    return sum(came_of["unsaid"] for came_of in found.values())


def main(arguments: Iterable[str]) -> int:
    """Print the table of confusions; 1 where a program is read otherwise and nothing is said."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bare", action="store_true", help="hide the names of the programs")
    parser.add_argument("--list", action="store_true", help="name each confused program")
    parser.add_argument("--random", type=int, default=0, help="how many random programs of each control")
    parser.add_argument("folders", nargs="*", type=Path)
    given = parser.parse_args(list(arguments))
    columns = "".join(f" {words} |" for words in OUTCOMES.values())
    print(f"| written for | taken for | programs |{columns}\n|---|---|---|{'---|' * len(OUTCOMES)}")
    unsaid = sum(table(folder.name, outcomes_of_folder(folder, given.bare), given.list) for folder in given.folders)
    if given.random:
        unsaid += sum(table(name, random_outcomes(name, range(given.random)), given.list) for name in RANDOM)
    return min(1, unsaid)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
