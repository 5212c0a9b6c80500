"""The result of one job as a row of a table."""

from __future__ import annotations

import msgspec

from toolpace.common.errors import printable
from toolpace.common.units import DEGREE, MILLIMETRE
from toolpace.jobs.batch.job import BatchJob
from toolpace.machine.machine import Machine

WAITING, ERROR = "not run", "error"
GOOD = ("verified", "timed", "read")
BAD = ("failed",)
"""What a verdict may be: the motion broke something, and is written all the same."""


class BatchRow(msgspec.Struct, frozen=True, kw_only=True):
    """One job and what came of it; what is not known, or not of this kind of job, is null."""

    program: str
    """As it was named."""
    machine: str
    what: str
    planner: str
    effort: str
    tip_tolerance_mm: float
    axis_tolerance_deg: float
    feed: str | None = None
    verdict: str = WAITING
    """verified or failed (plan, export), timed, read; error; not run."""
    error: str = ""
    """One line."""
    duration_s: float | None = None
    """Of the plan; of `time`, on the control."""
    optimum_s: float | None = None
    """Of `time`: of the fastest motion."""
    lower_bound_s: float | None = None
    gap: float | None = None
    limited_by: dict[str, float] = {}
    """Share of the duration in which each limit binds."""
    blocks: int | None = None
    folder: str = ""
    """Of its results, in that of the batch; empty where there are none."""
    report: bool = True
    """Whether a report was asked for, of what has one."""
    exported: str = ""
    """Of `export`: the folder of the files, beside it."""
    key: str = ""
    seconds: float = 0.0
    """Time that the job took, where it was done [s]."""
    worker: str = ""
    found: bool = False
    """Whether it was done before, and its folder found."""
    elsewhere: bool = False
    """Whether another worker may fare better: this one could not write."""

    @property
    def ok(self) -> bool:
        """Whether all is well."""
        return self.verdict in GOOD

    @property
    def limit(self) -> str:
        """What binds most, as `limited_by` names it; empty where that is not known."""
        known = {name: share for name, share in self.limited_by.items() if name not in ("nothing", "dwell")}
        return max(known, key=lambda name: known[name]) if known else ""

    @property
    def exit_code(self) -> int:
        """0: all is well; 1: a verification failed; 2: there is no result."""
        return 0 if self.ok else 1 if self.verdict in BAD else 2


def waiting(job: BatchJob) -> BatchRow:
    """The row of a job that has not begun."""
    machine = job.machine.name if isinstance(job.machine, Machine) else str(job.machine or "")
    return BatchRow(
        program=printable(str(job.program)),
        machine=printable(machine),
        what=job.what,
        planner=job.planner,
        effort=job.effort,
        tip_tolerance_mm=job.tip_tolerance / MILLIMETRE,
        axis_tolerance_deg=job.axis_tolerance / DEGREE,
        feed=job.feed,
        report=job.report or job.what not in ("plan", "export"),
    )
