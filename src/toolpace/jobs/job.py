"""What a plan is asked for: program, machine, tolerances, and how its results are written."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

from toolpace.programs.reading.options import ReadOptions

if TYPE_CHECKING:
    from toolpace.jobs.cut_options import CutOptions
    from toolpace.machine.cutting_tool import CuttingTool
    from toolpace.machine.machine import Machine
    from toolpace.programs.reading import Source
    from toolpace.programs.tolerances import Tolerances
    from toolpace.programs.toolpath import ToolPath

TIP_TOLERANCES, AXIS_TOLERANCES = (1e-8, 0.1), (1e-6, 0.8)
"""Between which tolerances lie [m], [rad]: programs are rounded to more, and beyond nothing of a part is left."""
TIME_STEPS = (1e-9, 60.0)
"""Between which the time between set-points lies [s]."""


@dataclass(frozen=True)
class Job:
    """All that a plan depends on, checked."""

    program: Path
    machine: Machine
    out: Path
    tip_tolerance: float | Tolerances
    """[m]"""
    axis_tolerance: float | Tolerances
    """[rad]"""
    planner: str = "optimal"
    effort: str = "normal"
    """How much is done for a path that may be passed fast: low, normal or high."""
    prove_within: float | None = None
    """Time for raising the lower bound [s]; None: it stays as it is found with the plan."""
    prices: bool = False
    """Whether it is worked out what one percent more of each limit would gain."""
    feed: str | None = None
    dialect: str | None = None
    options: ReadOptions = field(default_factory=ReadOptions)
    """How the program is read, beside these two."""
    dt: float = 1e-3
    """[s]"""
    csv: bool = False
    report: bool = True
    npz: str = "auto"
    """How set-points are written: "full", "compact", "auto" or "no" (motion/set_point_files.py)."""
    tool: CuttingTool | None = None
    """The tool whose bending is compensated; None: it is stiff."""
    cut_options: CutOptions | None = None
    """By what the cut sets the speed; None: the program's feeds hold."""
    source: Source | None = None
    """The program, where it has been read already; else it is read from its file, once."""


def loaded(job: Job) -> Job:
    """The job with its program in memory, and its controller known: what is planned, judged and kept is what was read
    now."""
    from toolpace.programs.reading import Source
    from toolpace.programs.reading.languages import with_controller

    source = job.source if job.source is not None else Source.load(job.program)
    return replace(job, source=source, options=with_controller(source, job.dialect, job.options)[0])


def with_tolerances_in(job: Job, toolpath: ToolPath) -> Job:
    """The job with tolerances that are numbers where its program asks for nothing tighter."""
    from toolpace.programs.tolerances import Tolerances

    tip, axis = job.tip_tolerance, job.axis_tolerance
    return replace(
        job,
        tip_tolerance=tip.of_tip_in(toolpath) if isinstance(tip, Tolerances) else tip,
        axis_tolerance=axis.of_axis_in(toolpath) if isinstance(axis, Tolerances) else axis,
    )


def program_name(job: Job) -> str:
    """Of the program, for messages."""
    return job.source.name if job.source is not None else str(job.program)


def holds_all(job: Job, count: int) -> bool:
    """Whether so many set-points are in memory at once: where their file holds them as they are, and where a tool
    bends."""
    from toolpace.motion.set_point_files import form_of

    return job.tool is not None or form_of(job.npz, count, len(job.machine.joints)) == "full"


def refuse_without_room(job: Job, duration: float, what: str) -> None:
    """Raise UsageError where the results of a motion that takes a `duration` [s] at least would not fit into memory or
    on the disk, before the work that makes them."""
    from toolpace.common.errors import UsageError
    from toolpace.common.files import free_disk
    from toolpace.motion.set_point_files import form_of, full_size, size_of
    from toolpace.motion.setpoints import COPIES, STREAMED_COPIES, refuse_too_many

    joints, count = len(job.machine.joints), duration / job.dt
    copies = COPIES if holds_all(job, int(count)) else STREAMED_COPIES
    refuse_too_many(duration, job.dt, joints, what, copies)
    form = form_of(job.npz, int(count), joints)
    # Of a table every figure has about 20 characters; a report has at most 20 MB.
    wanted = size_of(form, count, joints) + 2.5 * job.csv * full_size(count, joints) + 5e6
    free = free_disk(job.out)
    if wanted > free:
        raise UsageError(
            f"--out {job.out}: the results take more than {wanted / 1e9:.3g} GB, and {free / 1e9:.3g} GB are free "
            "there; give a longer --dt, or a folder on another disk"
        )
