"""Pruning of the records that dask's scheduler keeps of every task.

What a task is called is looked up in a cache of 100 000 names, and the span that tasks belong to notes of every
submission which kind of collection it was, for as long as the scheduler runs: together some 500 bytes a task. The
scheduler's logs keep their last thousand entries, and so grow over the first thousands of tasks only.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from distributed import Scheduler

OFTEN = 500
"""Tasks after which the notes are thrown away."""


def throw_away(dask_scheduler: Scheduler) -> None:
    """Done in the scheduler: of notes that are alike one is kept, and of looked-up names none."""
    from dask.utils import key_split

    key_split.cache_clear()
    spans = getattr(dask_scheduler.extensions.get("spans"), "spans", {})
    for span in spans.values():
        kinds = (span.metadata or {}).get("collections", [])
        unlike: list[object] = []
        for kind in kinds:
            if kind not in unlike:
                unlike.append(kind)
        kinds[:] = unlike
