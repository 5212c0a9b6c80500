"""Which control programs are taken for, against the control that they were written for.

    python -m testbed.recognised [--bare] FOLDER...

Each folder is named for the true control and holds programs of it; `--bare` hides their names, as of programs that
were saved as .nc. Programs that are taken for another's are read as both: what matters is those that move otherwise,
and of them those of which nothing is said.
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

import toolpace as tp
from toolpace.errors import ToolpaceError
from toolpace.machine.machine import Machine
from toolpace.reading import read_source
from toolpace.reading.languages import recognised
from toolpace.reading.options import ReadOptions
from toolpace.reading.source import Source
from toolpace.toolpath import ToolPath

MACHINES = ("xyzac-trunnion", "xyzbc-trunnion")
"""Programs are read on the first of them that reads them as their true control's."""
READ: dict[str, Any] = {"skip_unknown": True, "compensation": "program"}
"""Words that are not read are passed over, so that what stands beside them is compared too."""
OUTCOMES = ("alike", "refused", "said", "unsaid", "not told")
"""Of a confused program: both read it alike; the control that it is taken for refuses it; they differ, and that is said,
or is not; the true control's reading refuses it, so that nothing can be compared."""


def outcome(source: Source, true: str, taken: str) -> str:
    """What comes of taking a program for another control's: one of OUTCOMES."""
    for name in MACHINES:
        machine = tp.Machine.load(name)
        meant = _read(source, machine, ReadOptions.of(controller=true, **READ))
        if meant is not None:
            break
    else:
        return "not told" if _read(source, machine, ReadOptions.of(controller=taken, **READ)) is not None else "refused"
    found = _read(source, machine, ReadOptions.of(**READ))
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
    """The control that a program is taken for, `none` where it is refused as a program."""
    try:
        found = recognised(source, None, ReadOptions())
    except ToolpaceError:
        return "none"
    return found.controller.name if found.controller is not None else found.dialect


def main(arguments: Iterable[str]) -> int:
    """Print the table of confusions; 1 where a program is read otherwise and nothing is said."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bare", action="store_true", help="hide the names of the programs")
    parser.add_argument("--list", action="store_true", help="name each confused program")
    parser.add_argument("folders", nargs="+", type=Path)
    given = parser.parse_args(list(arguments))
    confused: dict[tuple[str, str], Counter[str]] = {}
    programs: Counter[str] = Counter()
    for folder in given.folders:
        for file in sorted(path for path in folder.iterdir() if path.is_file()):
            try:
                source = Source.from_bytes(file.read_bytes(), "program.nc" if given.bare else file.name)
            except ToolpaceError:
                continue
            programs[folder.name] += 1
            taken = taken_for(source)
            if taken != folder.name:
                came = "refused" if taken == "none" else outcome(source, folder.name, taken)
                confused.setdefault((folder.name, taken), Counter())[came] += 1
                if given.list:
                    print(f"{folder.name} {taken} {came}: {file.name}", flush=True)
    print("| written for | programs | taken for | how many | " + " | ".join(OUTCOMES) + " |")
    print("|---|---|---|---|" + "---|" * len(OUTCOMES))
    for true, count in programs.items():
        rows = {taken: found for (name, taken), found in confused.items() if name == true}
        right = count - sum(found.total() for found in rows.values())
        print(f"| {true} | {count} | {true} | {right} |" + " |" * len(OUTCOMES))
        for taken, found in sorted(rows.items(), key=lambda item: -item[1].total()):
            print(f"| | | {taken} | {found.total()} | " + " | ".join(str(found[each] or "") for each in OUTCOMES) + " |")
    return min(1, sum(found["unsaid"] for found in confused.values()))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
