"""Kills processes that write plans over an old one: `python -m tests.results.write.crash FOLDER KILLS STRIDE`.

A process of its own, which forks: each child has all modules at hand and lives for some milliseconds only. Two plans
take turns; after every death the folder must be the one or the other, byte by byte. Prints a JSON object of counts.
"""

from __future__ import annotations

import json
import os
import random
import signal
import sys
import time
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

from tests.support import motions
from toolpace.results import write

PATH = SimpleNamespace(tip_deviation=3e-6, axis_deviation=1e-4, fit_seconds=0.5)
FILE_EVENTS = ("open", "os.", "shutil.", "ctypes.call_function", "fcntl.")


def result(turn: int) -> write.PlanResult:
    trajectory = motions.Trajectory()
    return write.PlanResult(
        trajectory=trajectory, machine=motions.machine(), setpoints=trajectory.sample(1e-3 * (1 + turn)), path=PATH,
        toolpath=motions.program(), program=Path("part.ngc"), program_bytes=b"G1 X1\n" * (1 + turn), feed=f"{turn}%",
    )  # fmt: skip


RESULTS = (result(0), result(1))


def write_one(out: Path, turn: int) -> None:
    # Only one of the two has a table: a mixture of both has a file too many, or too few,
    # and they hold their set-points in different files.
    write.write_folder(out, RESULTS[turn], csv=bool(turn), report=False, npz=("full", "compact")[turn])


def content(folder: Path) -> tuple[int, dict[str, bytes]]:
    """Which of the two a folder is, and its files; plan.json as far as it tells no time of writing."""
    files = {path.name: path.read_bytes() for path in folder.iterdir()}
    plan = json.loads(files.pop("plan.json"))
    del plan["step_s"], plan["seal"]["sha256"]
    return int(plan["feed"][:-1]), files | {"plan.json": json.dumps(plan).encode()}


def dies(work: Callable[[], None], kill: Callable[[int], None]) -> bool:
    """Whether a child that does the work dies by the signal it is sent."""
    child = os.fork()
    if child == 0:
        try:
            work()
        finally:
            os._exit(0)
    kill(child)
    return os.WIFSIGNALED(os.waitpid(child, 0)[1])


def at_every_step(out: Path, stride: int, check: Callable[[], None]) -> int:
    """Kill a child just before its first file operation, then a later one, and so on, until one comes through."""
    steps = 0

    def work() -> None:
        done, turn = 0, 1 - content(out)[0]

        def hook(event: str, arguments: object) -> None:
            nonlocal done
            if event.startswith(FILE_EVENTS) and event != "os.kill":
                done += 1
                if done > steps:
                    os.kill(os.getpid(), signal.SIGKILL)

        sys.addaudithook(hook)
        write_one(out, turn)

    while dies(work, lambda child: None):
        check()
        steps += stride
    return steps


def at_random(out: Path, kills: int, check: Callable[[], None]) -> int:
    """Kill children that write without end, some time after they began."""
    chance = random.Random(20261122)
    began = time.perf_counter()
    write_one(out, 0)
    write_one(out, 1)
    longest = 1.5 * (time.perf_counter() - began)

    def work() -> None:
        turn = 0
        while True:
            write_one(out, turn % 2)
            turn += 1

    for _ in range(kills):
        dies(work, lambda child: (time.sleep(chance.uniform(0.0, longest)), os.kill(child, signal.SIGKILL))[0])
        check()
    return kills


def main() -> None:
    out, kills, stride = Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3])
    whole = {}
    for turn in (0, 1):
        write_one(out, turn)
        found, whole[turn] = content(out)
        assert found == turn
    seen: list[int] = []
    stale = 0

    def check() -> None:
        nonlocal stale
        turn, files = content(out)
        assert files == whole[turn], f"neither the one nor the other: {sorted(files)}"
        seen.append(turn)
        left = [path.name for path in out.parent.iterdir() if path != out]
        # What one run leaves the next removes: it never grows.
        assert len(left) <= 1 and all(name.startswith(".toolpace-") for name in left), left
        stale += len(left)

    steps = at_every_step(out, stride, check)
    at_random(out, kills, check)
    write_one(out, 0)
    left = [path.name for path in out.parent.iterdir() if path != out]
    print(json.dumps({"steps": steps, "kills": len(seen), "seen": seen, "stale": stale, "left": left}))


if __name__ == "__main__":
    main()
