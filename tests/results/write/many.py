"""Writes results from many processes at once: `python -m tests.results.write.many FOLDER PROCESSES ROUNDS PLACES`.

Each process writes so many folders of results over older ones, into as many places as there are, each with parents of
its own that vanish when a run fails, which every fourth does. Prints what went wrong otherwise, a line each.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path

from toolpace.common.errors import ToolpaceError
from toolpace.common.files import folder_to_write, whole_folder
from toolpace.common.files.seal import foreign


class MeantError(Exception):
    """Ends a run."""


def write(out: Path, text: str, fails: bool) -> None:
    """One run: looks at the place first, as a command does, then writes."""
    folder_to_write(out)
    with whole_folder(out, seal="plan.json") as folder:
        (folder / "data.bin").write_text(text)
        if fails:
            raise MeantError
        (folder / "plan.json").write_text('{"a": 1\n}\n')


def runs(place: Path, number: int, rounds: int, places: int) -> int:
    """All runs of one process; how many went wrong."""
    wrong = 0
    for k in range(rounds):
        out = place / f"parent{(number + k) % places}" / "out"
        try:
            write(out, f"{number} {k}", fails=k % 4 == 3)
        except MeantError:
            pass
        except (ToolpaceError, OSError) as error:
            wrong += 1
            print(f"{number} {k}: {type(error).__name__}: {error}", flush=True)
    return wrong


def main() -> int:
    """Fork, wait, and look at what is left."""
    place, processes, rounds, places = Path(sys.argv[1]), *map(int, sys.argv[2:])
    children = []
    for number in range(processes):
        child = os.fork()
        if child == 0:
            os._exit(min(runs(place, number, rounds, places), 255))
        children.append(child)
    wrong = sum(os.waitpid(child, 0)[1] != 0 for child in children)
    for out in place.glob("parent*/out"):
        if said := foreign(out):
            print(f"{out}: {said}")
            wrong += 1
    for left in place.rglob(".toolpace-*"):
        print(f"{left} is left")
        wrong += 1
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main())
