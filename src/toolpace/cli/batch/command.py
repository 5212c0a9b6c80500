"""The command `batch`."""

from __future__ import annotations

from toolpace.cli import options
from toolpace.cli.batch import options as many
from toolpace.cli.where import HERE, Where


def batch_command(
    programs: many.ProgramsOrJobs,
    /,
    *,
    machine: many.Machines = many.NO_MACHINES,
    what: many.What = "plan",
    to: many.Target = None,
    out: many.Out = "toolpace-batch",
    where: Where = HERE,
    memory: many.Memory = None,
    each: many.Each = many.AS_USUAL,
    files: options.Files = options.USUAL_FILES,
    reading: options.Reading = options.AS_WRITTEN,
) -> int:
    """Plan, time, inspect or export many programs on one or many machines, on all cores or on a cluster.

    Each job has its own folder in --out; batch.html and batch.parquet have one row
    for each job. The same command continues a batch that was stopped: it recognises
    finished jobs by the hash of program, machine, options and version. A program
    that is refused does not stop the others. Exit code 0 if all is planned and
    verified, 1 if a verification failed, 2 if a job has no result.
    docs: many programs.

    For example:

        toolpace batch parts/ -m xyzac-trunnion --out plans
        toolpace batch parts/ -m my-mill.toml -m xyzbc-head --tip-tolerance 5um --tip-tolerance 20um
        toolpace batch jobs.toml --cluster tcp://10.0.0.5:8786 --out /shared/plans
        toolpace batch parts/ --what inspect
        toolpace batch parts/ -m my-mill.toml --what export --to table
    """
    from toolpace.cli.batch.request import AskedBatch
    from toolpace.cli.batch.run import run_jobs

    client = where.client()
    asked = AskedBatch(programs, machine, what, to, each, files, reading)
    return run_jobs(asked.jobs(), out, client, memory)
