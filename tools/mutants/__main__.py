"""See the package."""

from __future__ import annotations

import argparse
import json
import os
import random
import shutil
import sys
import tempfile
import time
from collections import defaultdict
from pathlib import Path

# What every child would else import for itself; nothing of toolpace, which is what changes.
import hypothesis  # noqa: F401
import msgspec  # noqa: F401
import numba  # noqa: F401
import numpy  # noqa: F401
import scipy.optimize  # noqa: F401

from tools.mutants.changes import Change, all_changes, changed_text
from tools.mutants.line_map import OUT, LineMap, record
from tools.mutants.reasons import reason_of
from tools.mutants.trial import SURVIVED, ChangedFile, tried

DEFLECTION = [f"deflection/{name}.py" for name in (
    "compensation", "detour", "detour_law", "feed", "measured_pose", "motion_state", "nearest_point", "new_trajectory",
    "projection", "rejoin_motion",
)]  # fmt: skip
ROOMS = {
    "judge": ["judge"], "guard": ["planning/optimal", "planning/peaks.py"], "bound": ["planning/bound"],
    "fit": ["path/fit"], "follower": ["deflection/following"],
    "deflection": [*DEFLECTION, "deflection/rejoin"],
    "reading": ["programs/reading"], "export": ["controls/export"], "sampling": ["motion"],
}  # fmt: skip
"""The rooms that keep promises, and where they are below src/toolpace."""
MOST_SECONDS = 90.0
"""Of the tests of one change, the quickest of those that run its line; --seconds sets it."""
RESULTS = OUT / "results.jsonl"


def files_of(room: str) -> list[str]:
    """Files of a room, below src."""
    found = []
    for place in ROOMS[room]:
        path = Path("src/toolpace") / place
        found += sorted(path.rglob("*.py")) if path.is_dir() else [path]
    return [path.relative_to("src").as_posix() for path in found]


def chosen(files: list[str], count: int, seed: int) -> list[tuple[str, Change]]:
    """Changes at random, of all files alike by their number of changes."""
    every = [(file, each) for file in files for each in all_changes((Path("src") / file).read_text(encoding="utf-8"))]
    return random.Random(seed).sample(every, min(count, len(every)))


def run(given: argparse.Namespace) -> int:
    """Try changes, and note what came of each."""
    if given.files:
        files = [path.resolve().relative_to(Path("src").resolve()).as_posix() for path in given.files]
        work = [("named", *each) for each in chosen(files, given.count, given.seed)]
    else:
        share = -(-given.count // len(ROOMS))
        work = [(room, *each) for room in ROOMS for each in chosen(files_of(room), share, given.seed)]
    done = {tuple(json.loads(line)["key"]) for line in RESULTS.read_text().splitlines()} if RESULTS.exists() else set()
    left = [each for each in work if (each[1], each[2].line, each[2].index, each[2].name) not in done]
    children = []
    for k in range(given.workers):
        child = os.fork()
        if child == 0:
            code = 1
            try:
                _try_all(left[k :: given.workers], given.seconds)
                code = 0
            finally:
                sys.stdout.flush()
                os._exit(code)
        children.append(child)
    return max(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) for child in children)


def _try_all(work: list[tuple[str, str, Change]], most: float) -> None:
    """Try changes one after the other in a copy of the tree, and note what came of each."""
    lines = LineMap()  # not before the fork: it is forgotten, file and all, by a process that did not open it
    with tempfile.TemporaryDirectory() as folder:
        tree = Path(folder) / "src"
        shutil.copytree("src", tree, ignore=shutil.ignore_patterns("__pycache__"))
        sys.path.insert(0, str(tree))
        sys.dont_write_bytecode = True
        for number, (room, file, change) in enumerate(work, 1):
            key = (file, change.line, change.index, change.name)
            began = time.perf_counter()
            outcome, count = _outcome(lines, tree / file, file, change, most)
            entry = {"key": key, "room": room, "code": change.code, "outcome": outcome, "tests": count}
            with RESULTS.open("a", encoding="utf-8") as stream:
                stream.write(json.dumps(entry) + "\n")
            print(f"{number}/{len(work)} {outcome} {file}:{change.line} {change.name}: {change.code}"
                  f" ({count} tests, {time.perf_counter() - began:.0f} s)", flush=True)  # fmt: skip


def _outcome(lines: LineMap, path: Path, file: str, change: Change, most: float) -> tuple[str, int]:
    """What came of a change, and on how many tests it was tried."""
    tests, seconds = [], 0.0
    for name in lines.tests_of(file, change.line):
        seconds += lines.seconds.get(name, 0.0)
        if tests and seconds > most:
            break
        tests.append(name)
    if not tests:
        return "run by no test", 0
    with ChangedFile(path, changed_text(path.read_text(encoding="utf-8"), change)):
        return tried(tests, 10.0 * seconds + 120.0), len(tests)


def _line(file: str, number: int) -> str:
    """The text of a line as it is now; empty where the file has become shorter."""
    lines = (Path("src") / file).read_text(encoding="utf-8").splitlines()
    return lines[number - 1] if number <= len(lines) else ""


def table() -> int:
    """The results by room, and every change that is left with the reason why it does no harm."""
    entries = [json.loads(line) for line in RESULTS.read_text(encoding="utf-8").splitlines()]
    counts: dict[str, dict[str, int]] = defaultdict(lambda: defaultdict(int))
    left = []
    for entry in entries:
        lives = entry["outcome"] in (SURVIVED, "run by no test")
        reason = reason_of(entry["key"][0], entry["code"], entry["key"][3], _line(*entry["key"][:2])) if lives else ""
        kind = ("harmless" if reason else "left") if lives else "killed"
        counts[entry["room"]][kind] += 1
        if lives:
            left.append((entry, reason))
    print("| room | changes | killed | harmless | left |\n|---|---|---|---|---|")
    for room, by in counts.items():
        print(f"| {room} | {sum(by.values())} | {by['killed']} | {by['harmless']} | {by['left']} |")
    print("\n| change | what is done | why it does no harm |\n|---|---|---|")
    for entry, reason in sorted(left, key=lambda each: each[0]["key"]):
        file, line, _, name = entry["key"]
        code = entry["code"].replace("|", "\\|")
        print(f"| `{file}:{line}` `{code}` | {name} | {reason or '**not known**'} |")
    return 0


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("command", choices=["map", "try", "table"])
    parser.add_argument("files", nargs="*", type=Path)
    parser.add_argument("--count", type=int, default=300)
    parser.add_argument("--seconds", type=float, default=MOST_SECONDS)
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--seed", type=int, default=20261124)
    given, rest = parser.parse_known_args()
    if given.command == "map":
        return record([*map(str, given.files), *rest])
    return run(given) if given.command == "try" else table()


if __name__ == "__main__":
    sys.exit(main())
