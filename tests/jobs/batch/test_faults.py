"""What may go wrong with a cluster, with real processes: every job ends, planned or with its reason, once.

Everything waits for what it needs and no longer, and is bounded in time.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import pytest

from tests.support.dask_by_hand import ByHand, by_hand
from toolpace.cli import demo_programs

pytest.importorskip("distributed")
pytestmark = pytest.mark.sweep

MACHINE = "xyzac-trunnion"
BLOCKS = (400, 500, 600, 700)
"""Of the programs: a second of work each or two, so that there is a middle of a job."""
LONG = 240.0
"""Most that a batch may take [s]."""


@pytest.fixture(scope="module")
def parts(tmp_path_factory):
    """Programs that take a second or two, and one that is refused."""
    return programs(tmp_path_factory.mktemp("faults") / "parts", BLOCKS)


def programs(folder: Path, counts: Sequence[int]) -> Path:
    """A folder with programs of so many blocks, and one that is refused."""
    folder.mkdir()
    for blocks in counts:
        (folder / f"part-{blocks}.ngc").write_text(demo_programs.spiral_program(blocks))
    (folder / "bad.ngc").write_text("G21 G90 G54\nG43.4 H1\nG1 X1 Y2 F100\nG900 X4\nM30\n")
    return folder


def start(parts: Path, out: Path, *words: str) -> subprocess.Popen[str]:
    """A batch as the command runs it."""
    command = [sys.executable, "-m", "toolpace", "batch", str(parts), "-m", MACHINE, "--no-report", "-o", str(out)]
    return subprocess.Popen([*command, *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def ended(process: subprocess.Popen[str]) -> tuple[int, str, str]:
    """Exit code, output and errors; a batch that does not end is a failure."""
    try:
        output, errors = process.communicate(timeout=LONG)
    except subprocess.TimeoutExpired:
        process.kill()
        pytest.fail(f"the batch did not end: {process.communicate()}")
    return process.returncode, output, errors


def until(what: Callable[[], Any], seconds: float = 90.0) -> Any:
    """Wait for something to be true, and return it."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if found := what():
            return found
        time.sleep(0.05)
    raise AssertionError("it did not come to pass")


def rows(out: Path) -> dict[str, dict[str, Any]]:
    found = json.loads((out / "batch.json").read_text())["jobs"]
    named = {Path(row["program"]).name: row for row in found}
    assert len(named) == len(found) == len(BLOCKS) + 1
    return named


def assert_all_planned(out: Path) -> None:
    """Each program once, but the one that is refused; nothing half-written is left."""
    found = rows(out)
    assert found.pop("bad.ngc")["error"].endswith("in 'G900 X4'")
    assert {name: (row["verdict"], row["error"]) for name, row in found.items()} == dict.fromkeys(
        found, ("verified", "")
    )
    folders = [path.name for path in out.iterdir() if path.is_dir()]
    assert sorted(folders) == sorted(row["folder"] for row in found.values())


def working(cluster: ByHand) -> int:
    """The process of a worker that is in the middle of a job, as soon as one is."""
    from distributed import Client

    with Client(cluster.address, timeout=30) as client:  # one for all looks: a job may be over before a second is there
        processes = client.run(os.getpid)

        def busy() -> list[str]:
            shown = client.processing().items()
            return [worker for worker, keys in shown if any(isinstance(key, tuple) for key in keys)]

        return int(processes[until(busy)[0]])


def test_a_worker_that_is_killed_in_mid_job(parts, tmp_path):
    with by_hand(2) as cluster:
        batch = start(parts, tmp_path / "out", "--cluster", cluster.address)
        os.kill(working(cluster), signal.SIGKILL)
        code, _, errors = ended(batch)
    assert code == 2, errors  # of the one that is refused
    assert_all_planned(tmp_path / "out")


def test_a_worker_of_its_own_that_is_killed(parts, tmp_path):
    """The local cluster: its workers are children of the command."""
    import psutil

    batch = start(parts, tmp_path / "out", "--workers", "2")

    def worker() -> psutil.Process | None:
        if not list((tmp_path / "out").glob("part-*")):
            return None
        children = [each for each in psutil.Process(batch.pid).children() if "spawn_main" in " ".join(each.cmdline())]
        return children[0] if children else None

    until(worker).kill()
    code, _, errors = ended(batch)
    assert code == 2, errors
    assert_all_planned(tmp_path / "out")


def test_a_scheduler_that_is_stopped_and_the_batch_started_again(parts, tmp_path):
    out = tmp_path / "out"
    with by_hand(2) as cluster:
        batch = start(parts, out, "--cluster", cluster.address)
        until(lambda: list(out.glob("part-*/plan.json")))
        cluster.scheduler.kill()
        code, _, errors = ended(batch)
    assert code == 2 and "the scheduler is gone" in errors and "the same command continues from there" in errors
    assert errors.count("\n") == 1
    before = rows(out)
    assert {row["verdict"] for row in before.values()} >= {"not run"}
    done = {path.parent.name: path.stat().st_mtime_ns for path in out.glob("part-*/plan.json")}
    assert 1 <= len(done) < len(BLOCKS)
    with by_hand(2) as cluster:
        code, output, errors = ended(start(parts, out, "--cluster", cluster.address))
    assert code == 2 and f"{len(done)} of them by an earlier batch" in output, (output, errors)
    assert_all_planned(out)
    after = {path.parent.name: path.stat().st_mtime_ns for path in out.glob("part-*/plan.json")}
    assert {name: after[name] for name in done} == done


def test_a_batch_that_is_killed_goes_on_where_it_was(parts, tmp_path):
    out = tmp_path / "out"
    batch = start(parts, out, "--workers", "2")
    until(lambda: list(out.glob("part-*/plan.json")))
    batch.kill()
    batch.communicate(timeout=60)
    done = [path.parent.name for path in out.glob("part-*/plan.json")]
    code, output, errors = ended(start(parts, out, "--workers", "2"))
    assert code == 2 and "by an earlier batch" in output, errors
    assert_all_planned(out)
    found = [row["folder"] for row in rows(out).values() if row["found"]]
    assert set(done) <= set(found)


def test_interrupted_it_says_what_there_is_and_how_to_go_on(parts, tmp_path):
    out = tmp_path / "out"
    batch = start(parts, out, "--workers", "2")
    until(lambda: list(out.glob("part-*/plan.json")))
    batch.send_signal(signal.SIGINT)
    code, output, errors = ended(batch)
    assert code == 130 and "interrupted; " in errors and "batch.html had been written" in errors, errors
    assert errors.count("\n") == 1 and "have ended; the same command continues" in output, (output, errors)
    # A job whose folder is there may not have been told of yet: the next batch finds it.
    assert "not run" in {row["verdict"] for row in rows(out).values()}


def test_a_worker_whose_disk_is_full(parts, tmp_path):
    """Of two workers one can write no set-points: the other one does all."""
    with by_hand(1) as cluster:
        full = cluster.worker("--name", "full", largest_file=100_000)
        cluster.wait(2)
        code, _, errors = ended(start(parts, tmp_path / "out", "--cluster", cluster.address))
        assert code == 2 and full.poll() is None, errors
    assert_all_planned(tmp_path / "out")
    assert len({row["worker"] for name, row in rows(tmp_path / "out").items() if name != "bad.ngc"}) == 1


def test_a_job_that_runs_out_of_memory_kills_its_worker_and_is_told_so(parts, tmp_path):
    """Blocks that take many minutes: more set-points than an estimate by blocks foresees."""
    mine = tmp_path / "parts"
    mine.mkdir()
    (mine / "part.ngc").write_text((parts / f"part-{BLOCKS[0]}.ngc").read_text())
    (mine / "slow.ngc").write_text(demo_programs.spiral_program(900).replace("F2500", "F60"))
    out = tmp_path / "out"
    code, output, errors = ended(start(mine, out, "--workers", "2", "--memory", "500MB"))
    found = {Path(row["program"]).name: row for row in json.loads((out / "batch.json").read_text())["jobs"]}
    assert code == 2 and found["part.ngc"]["verdict"] == "verified", (output, errors)
    assert "died each time" in found["slow.ngc"]["error"] and "memory limit is 0.5 GB" in found["slow.ngc"]["error"]
    assert not list(out.glob("slow*"))


def test_what_no_worker_can_hold_is_not_begun(tmp_path):
    parts = programs(tmp_path / "parts", (900, 1100, 1300, 1500))
    with by_hand(1, "--memory-limit", "300MB", "--resources", "memory=3e8") as cluster:
        code, _, errors = ended(start(parts, tmp_path / "out", "--cluster", cluster.address))
    assert code == 2, errors
    told = {row["error"] for name, row in rows(tmp_path / "out").items() if name != "bad.ngc"}
    assert all(each.startswith("takes about 0.3") and "the largest worker has 0.3 GB" in each for each in told)
