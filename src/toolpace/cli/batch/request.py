"""The checked arguments of the command `batch`, and its jobs."""

from __future__ import annotations

import functools
import itertools
from dataclasses import dataclass
from typing import TYPE_CHECKING

from toolpace.cli import arguments, options
from toolpace.cli.batch.options import AS_USUAL, Each
from toolpace.common.errors import UsageError

if TYPE_CHECKING:
    from collections.abc import Callable

    from toolpace.jobs.batch import BatchJob


@dataclass(frozen=True)
class AskedBatch:
    """Programs, or a file of jobs, and what is to be done with each."""

    programs: list[str]
    machines: list[str]
    what: str = "plan"
    to: str | None = None
    """Target of an export."""
    each: Each = AS_USUAL
    files: options.Files = options.USUAL_FILES
    reading: options.Reading = options.AS_WRITTEN

    def jobs(self) -> list[BatchJob]:
        """The jobs of the file, or those that the options ask for. Raises UsageError."""
        tables = [program for program in self.programs if program.endswith(".toml")]
        if not tables:
            return self._combined()
        if len(self.programs) > 1:
            raise UsageError(f"{tables[0]}: a file of jobs names all programs itself; give it alone")
        if self != AskedBatch(self.programs, []):
            raise UsageError(
                f"{tables[0]}: what is asked of a job stands in the file, under [all] or [[jobs]], not beside it"
            )
        from toolpace.jobs.batch.jobs_file import jobs_of_file

        return jobs_of_file(tables[0])

    def _combined(self) -> list[BatchJob]:
        """A job of each program, machine, tolerance, planner, effort and feed."""
        each, named = self.each, self._programs()
        job = self._job()
        tips = [
            arguments.even_tolerances(options.Tolerances(tip_tolerance=tip))[0]
            for tip in each.tip_tolerance or [options.TIP_TOLERANCE]
        ]
        axes = [
            arguments.even_tolerances(options.Tolerances(axis_tolerance=axis))[1]
            for axis in each.axis_tolerance or [options.AXIS_TOLERANCE]
        ]
        planners = [arguments.planner_named(name) for name in each.planner or ["optimal"]]
        efforts = [arguments.effort_named(name) for name in each.effort or ["normal"]]
        feeds: list[str | None] = [arguments.feed_asked(feed) for feed in each.feed] if each.feed else [None]
        on: list[str | None] = [*self.machines] or [None]
        if not self.machines and self.what != "inspect":
            arguments.machine_named(None)
        combinations = itertools.product(named, on, tips, axes, planners, efforts, feeds)
        return [
            job(
                program=program, machine=machine, tip_tolerance=tip, axis_tolerance=axis, planner=planner,
                effort=effort, feed=feed,
            )
            for program, machine, tip, axis, planner, effort, feed in combinations
        ]  # fmt: skip

    def _programs(self) -> list[str]:
        from toolpace.jobs.batch.programs import programs_in

        found = []
        for program in self.programs:
            files = programs_in(program)
            if not files:
                raise UsageError(f"{program}: no program is there, or none whose name ends like that of a program")
            found += files
        return found

    def _job(self) -> Callable[..., BatchJob]:
        """A job with all that is the same for each."""
        from toolpace.common import units
        from toolpace.jobs.batch import BatchJob

        each, files, reading = self.each, self.files, self.reading
        return functools.partial(
            BatchJob,
            what=self.what,
            to=self.to,
            prove_within=arguments.time_to_prove(each.prove_within, "optimal") if each.prove else None,
            bend=each.bend,
            tool_length=None if each.tool_length is None else units.parse_length(each.tool_length),
            dialect=each.dialect,
            model=arguments.control_model(each.model),
            optimum=not each.no_optimum,
            dt=arguments.time_step(files.dt),
            csv=files.csv,
            npz=arguments.form_of_set_points(files.npz),
            report=not files.no_report,
            controller=reading.controller,
            setup=reading.setup,
            skip_unknown=reading.skip_unknown,
            lenient=reading.lenient,
            compensation=reading.compensation or "",
            max_blocks=reading.max_blocks,
            columns=reading.columns,
            units=reading.units,
        )
