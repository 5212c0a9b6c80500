"""200 programs planned in one process, on two workers that the batch starts, and through a scheduler and workers
started by hand.

python -m benchmarks.cluster [--programs 200] [--turns 1] [--only WAY] [--folder FOLDER]
"""

from __future__ import annotations

import argparse
import contextlib
import gc
import json
import os
import random
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import psutil

from benchmarks.machine import RESULTS, written_by
from toolpace.cli import demo_programs

MACHINE = "xyzac-trunnion"
FEWEST, MOST = 500, 5000
"""Blocks of a program; as many of each size on a logarithmic scale."""
EMPTY = 1000
"""Items that do nothing, by which the overhead of one is measured."""
EVALUATIONS = 10_000
"""Small items in a row, over which memory is watched."""
WAYS = ("one process", "two workers of its own", "two workers by hand")


def main() -> None:
    """Measure and write benchmarks/results/cluster.json and .md."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--programs", type=int, default=200)
    parser.add_argument("--turns", type=int, default=1)
    parser.add_argument("--only", choices=[*WAYS, "small"])
    parser.add_argument("--folder", type=Path)
    asked = parser.parse_args()
    file = RESULTS / "cluster.json"
    found: dict[str, Any] = json.loads(file.read_text()) if file.exists() else {}
    with tempfile.TemporaryDirectory() as temporary:
        folder = asked.folder or Path(temporary)
        sizes = programs(folder / "programs", asked.programs)
        # One way after the other, several times: the load of the computer changes.
        for turn in range(asked.turns):
            for way in WAYS:
                if asked.only in (None, way):
                    row = planned(folder / str(turn), folder / "programs", way, sizes)
                    found[way] = [*(found.get(way, []) if turn else []), row]
                    print(way, row, flush=True)
        if asked.only in (None, "small"):
            found["small"] = {**small(), "written by": written_by("python -m benchmarks.cluster --only small")}
            print(found["small"], flush=True)
    if asked.only != "small":
        found["written by"] = written_by("python -m benchmarks.cluster")
    file.write_text(json.dumps(found, indent=1) + "\n")
    file.with_suffix(".md").write_text(page(found))


def programs(folder: Path, count: int) -> list[int]:
    """Write them; return how many blocks each has."""
    rng = random.Random(15)
    folder.mkdir(parents=True, exist_ok=True)
    sizes = []
    for k in range(count):
        blocks = round(FEWEST * (MOST / FEWEST) ** ((k + 0.5) / count))
        text = demo_programs.spiral_program(blocks, spacing=rng.uniform(0.2e-3, 0.8e-3), decimals=rng.choice((3, 4)))
        (folder / f"part-{k:03}.ngc").write_text(text)
        sizes.append(blocks)
    return sizes


def planned(folder: Path, parts: Path, way: str, sizes: list[int]) -> dict[str, float]:
    """Plan all in one way: wall time, time of the jobs themselves, most memory of the process that hands them out."""
    out = folder / way.replace(" ", "-")
    words = [sys.executable, "-m", "toolpace", "batch", str(parts), "-m", MACHINE, "--no-report"]
    words += ["--out", str(out)]
    with contextlib.ExitStack() as stack:
        scheduler, others = None, []
        if way == WAYS[2]:
            others, address = stack.enter_context(by_hand(2))
            scheduler = others[0]
            words += ["--cluster", address]
        else:
            words += ["--workers", "0" if way == WAYS[0] else "2"]
        began = time.perf_counter()
        with subprocess.Popen(words, stdout=subprocess.DEVNULL) as process:
            most, spent = {"client": 0.0, "scheduler": 0.0}, Spent([process.pid, *others])
            while process.poll() is None:
                spent.look()
                for name, pid in (("client", process.pid), ("scheduler", scheduler)):
                    with contextlib.suppress(psutil.Error):
                        most[name] = max(most[name], psutil.Process(pid).memory_info().rss / 1e6) if pid else 0.0
                time.sleep(0.2)
        wall = time.perf_counter() - began
    rows = json.loads((out / "batch.json").read_text())["jobs"]
    assert len(rows) == len(sizes) and all(row["verdict"] == "verified" for row in rows)
    return {
        "wall_s": wall,
        "jobs_s": sum(row["seconds"] for row in rows),
        "cpu_s": spent.seconds,
        "load": os.getloadavg()[1],
        "programs": len(sizes),
        "blocks": sum(sizes),
        "client_mb": most["client"],
        "scheduler_mb": most["scheduler"],
    }


class Spent:
    """Time of processors that processes and all below them have spent, however busy the computer is with others."""

    def __init__(self, roots: list[int]) -> None:
        self.roots = roots
        self.first: dict[int, float] = {}
        self.last: dict[int, float] = {}

    def look(self) -> None:
        """Note what each has spent; of one that ends, what it had at the last look counts."""
        for root in self.roots:
            with contextlib.suppress(psutil.Error):
                top = psutil.Process(root)
                for each in [top, *top.children(recursive=True)]:
                    with contextlib.suppress(psutil.Error):
                        times = each.cpu_times()
                        self.last[each.pid] = times.user + times.system
                        if not self.first or root != self.roots[0]:
                            self.first.setdefault(each.pid, self.last[each.pid])

    @property
    def seconds(self) -> float:
        """All of it since the first look."""
        return sum(self.last.values()) - sum(self.first.values())


@contextlib.contextmanager
def by_hand(workers: int) -> Iterator[tuple[list[int], str]]:
    """A scheduler and workers as one starts them from a shell; yields the processes, the scheduler's first, and its
    address."""
    port = free_port()
    address = f"tcp://127.0.0.1:{port}"
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    dask = [sys.executable, "-m", "dask"]
    with contextlib.ExitStack() as stack:
        words = [*dask, "scheduler", "--host", "127.0.0.1", "--port", str(port), "--dashboard-address", "127.0.0.1:0"]
        scheduler = subprocess.Popen(words, **quiet)
        stack.callback(scheduler.wait)
        stack.callback(scheduler.terminate)
        started = [scheduler.pid]
        for _ in range(workers):
            worker = subprocess.Popen(
                [*dask, "worker", address, "--nthreads", "1", "--resources", "memory=10e9", "--no-dashboard"], **quiet
            )
            stack.callback(worker.wait)
            stack.callback(worker.terminate)
            started.append(worker.pid)
        from distributed import Client

        with Client(address, timeout=30) as client:
            client.wait_for_workers(workers, timeout=60)
        yield started, address


def free_port() -> int:
    """One that nobody listens on."""
    with socket.socket() as server:
        server.bind(("127.0.0.1", 0))
        port: int = server.getsockname()[1]
        return port


def objects(dask_scheduler: object) -> int:
    """Blocks of memory that Python has given out in the scheduler, what is no longer needed thrown away."""
    gc.collect()
    return sys.getallocatedblocks()


def nothing(common: object, item: int) -> int:
    """Work that takes no time."""
    return item


def small() -> dict[str, Any]:
    """What an item costs beside its work, and memory of scheduler and client over many of them."""
    from distributed import Client

    from toolpace.common.cluster import open_pool

    with by_hand(2) as ((scheduler, *_), address), open_pool(address) as pool, Client(address) as observer:
        assert len(list(pool.each(nothing, None, range(100)))) == 100
        began = time.perf_counter()
        assert len(list(pool.each(nothing, None, range(EMPTY)))) == EMPTY
        each = (time.perf_counter() - began) / EMPTY
        memory, blocks = [], []
        common = bytes(2_000_000)
        for k, _ in enumerate(pool.each(nothing, common, range(EVALUATIONS))):
            if (k + 1) % (EVALUATIONS // 10) == 0:
                memory.append([psutil.Process(pid).memory_info().rss / 1e6 for pid in (scheduler, os.getpid())])
                blocks.append(observer.run_on_scheduler(objects))
    growth = 1e6 * np.polyfit(np.linspace(0.1, 1.0, 10)[4:] * EVALUATIONS, np.array(memory)[4:], 1)[0]
    return {
        "each_ms": 1e3 * each,
        "evaluations": EVALUATIONS,
        "scheduler_and_client_mb": memory,
        "scheduler_and_client_bytes_each": growth.tolist(),
        "scheduler_blocks": blocks,
    }


def page(found: dict[str, Any]) -> str:
    """The results in words."""
    lines = ["# Many programs on a cluster", "", found["written by"], ""]
    lines += [
        "Spirals of 500 to 5000 blocks on xyzac-trunnion, planned, bounded, judged, written without reports. The load "
        "is that of the computer at the end, on which others may work too: wall times are to be compared where it is "
        "alike, time of processors always. Workers that the batch starts have their scheduler in the client.",
        "",
        "| | programs | wall time | jobs, summed up | processors | load | client | scheduler |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for way in WAYS:
        for row in found.get(way, []):
            scheduler = f"{row['scheduler_mb']:.0f} MB" if row["scheduler_mb"] else ""
            cpu = f"{row['cpu_s']:.1f} s" if row["cpu_s"] is not None else "not noted"
            load = f"{row['load']:.1f}" if row["load"] is not None else "not noted"
            cells = [way, str(row["programs"]), f"{row['wall_s']:.1f} s", f"{row['jobs_s']:.1f} s", cpu, load]
            cells += [f"{row['client_mb']:.0f} MB", scheduler]
            lines.append(f"| {' | '.join(cells)} |")
    if "small" in found:
        memory = found["small"]["scheduler_and_client_mb"]
        growth = found["small"]["scheduler_and_client_bytes_each"]
        lines += [
            "",
            "## Small items",
            "",
            found["small"]["written by"],
            "",
            f"An item that does nothing takes {found['small']['each_ms']:.2f} ms on two workers. Over "
            f"{found['small']['evaluations']} of them, each tenth looked at, the scheduler has "
            f"{', '.join(f'{each[0]:.1f}' for each in memory)} MB, and the client "
            f"{', '.join(f'{each[1]:.1f}' for each in memory)} MB. Fitted over the second half, the scheduler grows "
            f"by {growth[0]:.0f} bytes an item, the client by {growth[1]:.0f}; before that, logs of 1000 entries "
            "fill up. Blocks of memory that Python holds in the scheduler, at the same places: "
            f"{', '.join(map(str, found['small']['scheduler_blocks']))}.",
        ]
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    main()
