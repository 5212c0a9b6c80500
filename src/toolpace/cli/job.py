"""From a program to a folder of results, step by step."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from toolpace.cli.steps import Steps
from toolpace.machine.refusals import check_travel
from toolpace.planning.guarantee import PROMISED

if TYPE_CHECKING:
    from toolpace.judge import Verification
    from toolpace.machine.machine import Machine
    from toolpace.toolpath import ToolPath
    from toolpace.write import PlanRecord


@dataclass(frozen=True)
class Job:
    """All that a plan depends on, checked."""

    program: Path
    machine: Machine
    out: Path
    tip_tolerance: float
    axis_tolerance: float
    planner: str = "optimal"
    prove_within: float | None = None
    """Time for raising the lower bound [s]; None: it stays as it is found with the plan."""
    feed: str | None = None
    dialect: str | None = None
    dt: float = 1e-3
    csv: bool = False
    report: bool = True


def run(job: Job, steps: Steps) -> tuple[PlanRecord, Verification]:
    """Read, fit, plan, sample, verify and write; raises ToolpaceError, and then has written nothing."""
    from toolpace.reading import read

    warm_up(steps)
    with steps.step("reading") as tell:
        toolpath = read(job.program, job.machine, job.dialect, feed=job.feed)
        check_program(toolpath, job.machine)
        skipped = sum(toolpath.skipped.values())
        tell.note = f"{toolpath.blocks} blocks, {len(toolpath)} points" + (f", {skipped} skipped" if skipped else "")

    import msgspec

    from toolpace import write
    from toolpace.axispath.axispath import AxisPath
    from toolpace.judge import verify
    from toolpace.path.path import Path as SmoothPath
    from toolpace.planning.bound.prove import prove
    from toolpace.planning.planner import plan
    from toolpace.write.plan_json import PLAN

    with steps.step("fitting") as tell:
        path = SmoothPath.fit(toolpath, job.tip_tolerance, job.axis_tolerance, job.machine, progress=tell)
    with steps.step("planning") as tell:
        axis_path = AxisPath.follow(path, job.machine)
        trajectory = plan(axis_path, job.machine, planner=job.planner, progress=tell)
        tell.note = f"{trajectory.mesh_points} mesh points"
    if job.prove_within is not None:
        with steps.step("proving") as tell:
            before = trajectory.gap
            trajectory = prove(trajectory, within=job.prove_within, progress=tell)
            tell.note = f"gap {before:.3%}, now {trajectory.gap:.3%}"
    with steps.step("sampling") as tell:
        setpoints = trajectory.sample(job.dt)
        check_travel(job.machine, setpoints.q, setpoints.block, toolpath.source)
        trajectory.usage()
        tell.note = f"{len(setpoints)} set-points"
    with steps.step("verifying"):
        verification = verify(setpoints, job.machine, toolpath, job.tip_tolerance, job.axis_tolerance, job.dt)
    with steps.step("writing") as tell:
        record = write.write_all(
            job.out,
            trajectory,
            path,
            toolpath,
            job.machine,
            setpoints,
            job.program,
            csv=job.csv,
            report=job.report,
            progress=lambda what, share: tell(share),
            verification=verification,
            feed=job.feed,
            tip_tolerance=job.tip_tolerance,
            axis_tolerance=job.axis_tolerance,
            dialect=job.dialect,
            step_s=dict(steps.seconds),
        )
    record = msgspec.structs.replace(record, step_s=dict(steps.seconds))
    write.write_plan(job.out / PLAN, record)
    return record, verification


def check_program(toolpath: ToolPath, machine: Machine) -> None:
    """Raise ReachError where a point of the program itself is out of travel, before any long work."""
    rotary = machine.choose_rotary(toolpath) if toolpath.rotary is None else toolpath.rotary
    check_travel(machine, machine.joints_at(toolpath.tip, rotary), toolpath.block, toolpath.source)


def warm_up(steps: Steps) -> None:
    """On the first run of all, compile what the job will need, and say so."""
    from toolpace.kernels import warm

    if warm.is_warm():
        return
    with steps.step("compiling", "first run on this computer, may take a minute; kept for later runs") as tell:
        warm.warm_up(tell)


def written(job: Job) -> list[str]:
    """Names of the files of a plan, the one to look at last."""
    from toolpace import write
    from toolpace.write.plan_json import PLAN

    names = [PLAN, write.SET_POINTS, write.MACHINE, f"program{job.program.suffix}"]
    return names + [write.TABLE] * job.csv + [write.REPORT] * job.report


def exit_code(record: PlanRecord, verification: Verification) -> int:
    """0 where the motion passed, and kept every limit at any time too, not only at the set-points; else 1."""
    return 0 if verification.ok and record.usage.worst <= PROMISED else 1
