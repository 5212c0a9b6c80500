"""Batches: many programs, machines and tolerances in one table and page.

a batch, step by step:
  what there is to do                    BatchJob, from Python, the command line or a file of jobs
  read what each depends on              Prepared: program, machine, options, and the key that tells it from all others
  what was done before                   its folder is there, sealed and unchanged: its BatchRow is read from it
  all others                             carried out by workers, each into a folder that is whole or not there
  what came of them                      Rows: batch.json, batch.parquet, batch.html
"""

from __future__ import annotations

from toolpace.jobs.batch.job import BatchJob
from toolpace.jobs.batch.result_row import BatchRow
from toolpace.jobs.batch.running import Batch, batch

__all__ = ["Batch", "BatchJob", "BatchRow", "batch"]
