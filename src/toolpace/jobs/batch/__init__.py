"""Batches: many programs, machines and tolerances in one table and page.

a batch, step by step:
  what there is to do                    BatchJob, from Python, the command line or a file of jobs
  read what each depends on              Prepared: program, machine, options, and the key that tells it from all others
  what was done before                   its folder is there, sealed and unchanged: its BatchRow is read from it
  all others                             carried out by workers, each into a folder that is whole or not there
  what came of them                      Rows: batch.json, batch.parquet, batch.html
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec

from toolpace.common.cluster import Outcome, Pool, open_pool
from toolpace.common.errors import ClusterError, ToolpaceError, UsageError, printable
from toolpace.common.files import finished
from toolpace.jobs.batch.folder import batch_folder, write_tables
from toolpace.jobs.batch.job import ERROR, WAITING, BatchJob, BatchRow, Loader, Prepared, waiting
from toolpace.jobs.batch.work import Place, do_job, done_before, failed

if TYPE_CHECKING:
    from distributed import Client

__all__ = ["Batch", "BatchJob", "BatchRow", "batch"]

Tell = Callable[[BatchRow, int], None]
"""Takes the row of a job that has ended, and how many have."""
BASE, LINE = 350e6, 28e3
"""Bytes of a process, and of each line. Planned were spirals of 100 to 80 000 blocks, with set-points each millisecond
and a report: 285 MB of 100, 308 of 1000, 490 of 5000, 617 of 20 000, 1753 of 80 000."""
READ_ONLY = 0.3
"""Share of that where nothing is planned."""


@dataclass(frozen=True)
class Batch:
    """What came of all jobs: a row each, in their order."""

    folder: Path
    rows: tuple[BatchRow, ...]
    files: tuple[str, ...] = ()
    """The tables in the folder, the page last."""

    def __len__(self) -> int:
        return len(self.rows)

    def __iter__(self) -> Iterator[BatchRow]:
        return iter(self.rows)

    @property
    def ok(self) -> bool:
        """Whether every job is done, and every motion verified."""
        return all(row.ok for row in self.rows)

    @property
    def exit_code(self) -> int:
        """0: all is well; 1: a verification failed; 2: a job has no result."""
        return max((row.exit_code for row in self.rows), default=0)


def batch(
    jobs: Iterable[BatchJob],
    out: str | os.PathLike[str] = "toolpace-batch",
    client: Client | str | int | None = None,
    *,
    memory: str | None = None,
    progress: Callable[[BatchRow, int], None] | None = None,
) -> Batch:
    """Carry out jobs on a cluster, into one folder; what is there from before, unchanged, is not done again.

    jobs: any number of `BatchJob`; two that ask for the same are done once.
    out: the folder; new, empty, or of a batch before. Workers must have the same under the same name.
    client: a dask.distributed.Client, the address of a scheduler, a number of workers on this computer (0: this
    process, one after the other), or None: a worker a core; this process where dask.distributed is not installed.
    memory: what each worker that is started here may take, like "4GB".
    progress: called with the row of each job that ends, and with how many have.

    Nothing that is wrong with a job is raised: its row says it. Raises UsageError where the folder is not fit, and
    ClusterError where the cluster goes away; the tables are then written all the same, and another batch with the
    same jobs goes on from there.
    """
    if isinstance(jobs, str | os.PathLike | BatchJob):
        raise UsageError(f"batch: {type(jobs).__name__} in place of jobs; give a list of BatchJob(program=...)")
    listed = tuple(jobs)
    for each in listed:
        if not isinstance(each, BatchJob):
            raise UsageError(f"batch: {type(each).__name__} in place of a job; give BatchJob(program=...)")
    with batch_folder(out) as place, open_pool(client, memory) as pool:
        return run_batch(listed, place, pool, progress)


def run_batch(jobs: Sequence[BatchJob], place: Place, pool: Pool, progress: Tell | None = None) -> Batch:
    """Carry out jobs in a folder that is held, on a pool that is open; see `batch`."""
    running = _Running(jobs, place, progress or (lambda row, done: None))
    folder = Path(place.folder)
    write_tables(folder, running.rows)
    try:
        running.go(pool)
    except ClusterError as error:
        running.stop(str(error))
        done = sum(row.verdict != WAITING for row in running.rows)
        raise ClusterError(
            f"{error}; {done} of {len(jobs)} jobs have ended, and the same command continues from there"
        ) from None
    finally:
        files = write_tables(folder, running.rows)
        # What is to be said at an interrupt: of folders there may be thousands, and other processes wrote them.
        finished[:] = [folder / files[-1]]
    return Batch(folder, tuple(running.rows), tuple(files))


@dataclass
class _Running:
    """A batch under way."""

    jobs: Sequence[BatchJob]
    place: Place
    tell: Tell
    rows: list[BatchRow] = field(init=False)
    avoid: set[str] = field(default_factory=set)
    """Workers that cannot write."""
    ended: int = 0

    def __post_init__(self) -> None:
        self.rows = [waiting(job) for job in self.jobs]
        self.again: list[tuple[int, Prepared]] = []
        self.same: dict[str, list[int]] = {}

    def go(self, pool: Pool) -> None:
        """All jobs once, and once more those that another worker may fare better with."""
        self._through(pool, self._to_do())
        again, self.again = self.again, []
        if again:
            self._through(pool, iter(again), last=True)

    def _to_do(self) -> Iterator[tuple[int, Prepared]]:
        """Jobs that are not done yet, read when a worker has room for them."""
        loader, folder = Loader(), Path(self.place.folder)
        for number, job in enumerate(self.jobs):
            try:
                prepared = loader.prepare(job)
            except ToolpaceError as error:
                row = waiting(job)
                self._end(number, msgspec.structs.replace(row, verdict=ERROR, error=" ".join(str(error).split())))
                continue
            except OSError as error:
                row = waiting(job)
                self._end(number, msgspec.structs.replace(row, verdict=ERROR, error=printable(str(error))))
                continue
            alike = self.same.setdefault(prepared.key, [])
            alike.append(number)
            if len(alike) > 1:
                # The first of them may have ended already.
                if self.rows[alike[0]].verdict != WAITING:
                    self._end(number, self.rows[alike[0]])
                continue
            if (row_before := done_before(folder, prepared)) is not None:
                self._end_all(prepared, row_before)
                continue
            yield number, prepared

    def _through(self, pool: Pool, items: Iterator[tuple[int, Prepared]], last: bool = False) -> None:
        outcomes = pool.each(_do, self.place, items, memory=_memory, avoid=self.avoid, ahead=0)
        for outcome in outcomes:
            self._take(outcome, last)

    def _take(self, outcome: Outcome[tuple[int, Prepared], BatchRow], last: bool) -> None:
        number, prepared = outcome.item
        row = outcome.value
        if row is None:
            row = msgspec.structs.replace(failed(prepared, ToolpaceError(outcome.error)), error=outcome.error)
        row = msgspec.structs.replace(row, seconds=outcome.seconds, worker=outcome.worker)
        if row.elsewhere and outcome.worker:
            self.avoid.add(outcome.worker)
            if not last:
                self.again.append((number, prepared))
                return
        self._end_all(prepared, row)

    def _end_all(self, prepared: Prepared, row: BatchRow) -> None:
        """A job has ended, and with it all that ask for the same."""
        for number in self.same[prepared.key]:
            if self.rows[number].verdict == WAITING:
                self._end(number, row)

    def _end(self, number: int, row: BatchRow) -> None:
        named = waiting(self.jobs[number])
        self.rows[number] = msgspec.structs.replace(row, program=named.program)
        self.ended += 1
        self.tell(self.rows[number], self.ended)

    def stop(self, why: str) -> None:
        """Say of all that have not ended why."""
        self.rows = [msgspec.structs.replace(row, error=why) if row.verdict == WAITING else row for row in self.rows]


def _do(place: Place, item: tuple[int, Prepared]) -> BatchRow:
    return do_job(place, item[1])


def _memory(item: tuple[int, Prepared]) -> float:
    return estimate(item[1])


def estimate(prepared: Prepared) -> float:
    """Bytes."""
    plans = prepared.job.what in ("plan", "export") or (prepared.job.what == "time" and prepared.job.optimum)
    return BASE + LINE * prepared.lines * (1.0 if plans else READ_ONLY)
