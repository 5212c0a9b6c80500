"""Estimate of the memory that a job needs, from the number of lines of its program."""

from __future__ import annotations

from toolpace.jobs.batch.prepared_job import Prepared

BASE, LINE = 350e6, 28e3
"""Bytes of a process, and of each line. Planned were spirals of 100 to 80 000 blocks, with set-points each millisecond
and a report: 285 MB of 100, 308 of 1000, 490 of 5000, 617 of 20 000, 1753 of 80 000."""
READ_ONLY = 0.3
"""Share of that where nothing is planned."""


def estimate(prepared: Prepared) -> float:
    """Bytes."""
    plans = prepared.job.what in ("plan", "export") or (prepared.job.what == "time" and prepared.job.optimum)
    return BASE + LINE * prepared.lines * (1.0 if plans else READ_ONLY)
