"""The steps of a job: from a program to a folder of results.

carry out a job:
  read the program                       ToolPath
  fit a path within tolerances           Path; with effort, again and again, as it may be passed the fastest
  plan the motion along it               Trajectory; where the tool bends, both again until the bending is compensated
  prove how close to the best it is      the same, with a higher lower bound; only where asked for
  cut the stock of the set-up sheet      CutSimulation; only where the sheet names a stock
  sample it at equal times               SetPoints
  verify these by the program alone      Verification
  write all of it                        the folder
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

from toolpace.common.units import format_length, format_time
from toolpace.common.value_objects import counted
from toolpace.jobs import TimedSteps, motion_cut
from toolpace.jobs.job import Job, holds_all, loaded, program_name, refuse_without_room, with_tolerances_in
from toolpace.machine.limits import CONTINUOUS
from toolpace.motion.active_limits import BINDING
from toolpace.planning.limit_tolerances import PROMISED

if TYPE_CHECKING:
    from collections.abc import Sequence

    from toolpace.cutting.compensated_program import BendingCompensation
    from toolpace.judge import MotionJudge, Verification
    from toolpace.motion.setpoints import Block, SetPointSource
    from toolpace.motion.trajectory import Trajectory
    from toolpace.planning.path_and_pace.alternating import Round
    from toolpace.planning.program_plan import FittedProgram, ProgramPlan
    from toolpace.programs.toolpath import ToolPath
    from toolpace.results.write import PlanRecord, PlanResult, SetPointDigest

NOTES = 3
"""Notes of a plan on what is left above its bound that are shown: each is of one run."""


def carry_out(job: Job, steps: TimedSteps) -> tuple[PlanRecord, Verification]:
    """Read, fit, plan, sample, verify and write; raises ToolpaceError, and then has written nothing."""
    from toolpace.programs.reading.setup_file import with_cure_of_zero
    from toolpace.results import write

    job = loaded(job)
    warm_up(steps)
    toolpath = read_program(job, steps)
    job = with_tolerances_in(job, toolpath)
    # a curve may cut corners, so half of the time is what is sure
    refuse_without_room(job, 0.5 * toolpath.least_duration, "the feeds of the program alone take more than")
    with with_cure_of_zero(toolpath.assumed):
        programmed, limits = toolpath, job.cut_options
        if limits is not None:
            within_cut = limits.plan(job, steps, toolpath, program_name(job))
            toolpath = within_cut.fed(toolpath)
        job = engaged_by_stock(job, steps, toolpath)
        compensation = compensated_for_bending(job, steps, toolpath)
        if compensation is not None:
            planned = program_plan_of(compensation)
        elif limits is not None:
            planned = within_cut.plan
        else:
            planned = plan_motion(job, steps, fit_path(job, steps, toolpath))
        trajectory = with_proof(job, steps, with_cheap_bound(job, steps, planned.trajectory))
        prices = priced(job, steps, trajectory)
        cut = motion_cut.cut_of_known_stock(job.options.setup, steps, trajectory, toolpath)
        say_tool_changes(job, steps, toolpath)
        refuse_without_room(job, trajectory.duration, "the motion takes")
        sampled = sample_motion(job, steps, trajectory, toolpath)
    verification = verify_motion(steps, sampled.judge)
    cut_limits = None
    if limits is not None:
        cut_limits = write.cut_part(within_cut, limits.rules, job.options.setup, limits.material)
        verification = limits.verified(job, steps, verification, sampled.points, programmed, toolpath, cut_limits)
    result = write.PlanResult(
        trajectory=trajectory,
        machine=job.machine,
        setpoints=sampled.points,
        digest=sampled.digest,
        toolpath=toolpath,
        path=planned.path,
        effort=planned.effort,
        rounds=planned.rounds,
        verification=verification,
        program=job.program,
        program_bytes=job.source.data if job.source is not None else None,
        dialect=job.dialect,
        feed=job.feed,
        options=job.options,
        tip_tolerance=job.tip_tolerance,
        axis_tolerance=job.axis_tolerance,
        aimed=compensation,
        prices=prices,
        cut=cut,
        cut_limits=cut_limits,
        step_s=dict(steps.seconds),
    )
    record = write_results(job, steps, result)
    return record, verification


def read_program(job: Job, steps: TimedSteps) -> ToolPath:
    """The program as a tool path that the machine can reach all points of."""
    from toolpace.programs.reading import read_source

    assert job.source is not None
    with steps.step("reading") as step:
        toolpath = read_source(job.source, job.machine, job.dialect, job.options, feed=job.feed)
        skipped = sum(toolpath.skipped.values())
        step.note = f"{toolpath.blocks} blocks, {len(toolpath)} points" + (f", {skipped} skipped" if skipped else "")
    return toolpath


def fit_path(job: Job, steps: TimedSteps, toolpath: ToolPath) -> FittedProgram:
    """A path within the tolerances that may be passed fast."""
    from toolpace.planning.program_plan import effort_for, fit_program

    with steps.step("fitting") as step:
        effort = effort_for(job.effort, job.planner)
        fitted = fit_program(toolpath, job.machine, job.tip_tolerance, job.axis_tolerance, effort=effort, progress=step)
        step.note = durations_in_words(fitted.rounds)
    return fitted


def durations_in_words(rounds: Sequence[Round]) -> str:
    """ "4 rounds, 23.2 s, then 20.1, 19.9, 19.8, 19.9": what each made of it; empty where the path was fitted once."""
    if len(rounds) < 2:
        return ""
    return f"{counted(len(rounds) - 1, 'iteration')}: {' > '.join(format_time(each.duration) for each in rounds)}"


def plan_motion(job: Job, steps: TimedSteps, fitted: FittedProgram) -> ProgramPlan:
    """The fastest motion along a path."""
    from toolpace.path.axis_path import check_travel
    from toolpace.planning.program_plan import plan_fitted

    with steps.step("planning") as step:
        planned = plan_fitted(
            fitted, job.machine, planner=job.planner, progress=step,
            check=lambda axis_path: check_travel(axis_path, program_name(job)),
        )  # fmt: skip
        step.note = f"{planned.trajectory.mesh_points} mesh points"
    return planned


def program_plan_of(compensation: BendingCompensation) -> ProgramPlan:
    """A program compensated for the bending, with its path fitted once in each iteration."""
    from toolpace.planning.program_plan import ProgramPlan

    return ProgramPlan(compensation.path, compensation.trajectory, "low", ())


def compensated_for_bending(job: Job, steps: TimedSteps, toolpath: ToolPath) -> BendingCompensation | None:
    """The program compensated for the bending of its tool, and planned; None where it is stiff."""
    if job.tool is None:
        return None
    from toolpace.cutting.compensated_program import compensate_bending, refuse_coarse
    from toolpace.path.axis_path import check_travel

    refuse_coarse(toolpath, job.tool, job.dt)
    with steps.step("compensating") as step:
        compensation = compensate_bending(
            toolpath, job.machine, job.tool, job.tip_tolerance, job.axis_tolerance, planner=job.planner, progress=step
        )
        check_travel(compensation.trajectory.axis_path, program_name(job))
        iterations = counted(compensation.rounds, "iteration")
        step.note = f"the tool bends by at most {format_length(compensation.largest)}, {iterations}"
    return compensation


def engaged_by_stock(job: Job, steps: TimedSteps, toolpath: ToolPath) -> Job:
    """The job with the deflection of its tool by what it cuts of the stock, where the tool file leaves the engagement
    to that. Raises UsageError where the set-up sheet names no stock, or lacks a figure of the tool."""
    if job.tool is None or not job.tool.from_stock:
        return job
    from toolpace.common.errors import UsageError
    from toolpace.cutting.forces.engaged_deflection import with_engaged_deflection

    setup = job.options.setup
    if setup.workpiece.stock is None:
        raise UsageError(
            f'{job.tool.source}: milling = "stock", and no set-up sheet names one; give it (--setup) with [stock], or '
            "write the engagement"
        )
    stiff = replace(job, tool=None, effort="low")
    trajectory = plan_motion(stiff, steps, fit_path(stiff, steps, toolpath)).trajectory
    simulation = motion_cut.cut_motion(setup, steps, trajectory, toolpath, finest=motion_cut.CELL_FOR_TIMES)
    tools = [setup.figures_of(each.tool, each.figures) for each in toolpath.operations]
    with steps.step("forces"):
        tool = with_engaged_deflection(job.tool, simulation, toolpath, tools)
    return replace(job, tool=tool)


def with_cheap_bound(job: Job, steps: TimedSteps, trajectory: Trajectory) -> Trajectory:
    """A motion with a lower bound of any motion, where that is cheap and none is to be proved."""
    from toolpace.planning.bound.continuous import is_cheap, with_continuous_bound

    if job.prove_within is not None or not is_cheap(trajectory):
        return trajectory
    with steps.step("bounding"):
        return with_continuous_bound(trajectory)


def with_proof(job: Job, steps: TimedSteps, trajectory: Trajectory) -> Trajectory:
    """A motion with its lower bound raised, where that was asked for; what is far from its bound then is said.

    Of what other tries have closed there is nothing to say.
    """
    from toolpace.planning.bound.prove import prove
    from toolpace.planning.optimal.fallback_strategies import FAR

    if job.prove_within is not None:
        with steps.step("proving") as step:
            before = trajectory.gap
            trajectory = prove(trajectory, within=job.prove_within, progress=step)
            step.note = f"gap {100.0 * before:.3f} %, now {100.0 * trajectory.gap:.3f} %"
    if trajectory.gap > FAR:
        for note in trajectory.notes[:NOTES]:
            steps.say(note)
        if len(trajectory.notes) > NOTES:
            steps.say(f"and so of {counted(len(trajectory.notes) - NOTES, 'more run')}")
    return trajectory


def priced(job: Job, steps: TimedSteps, trajectory: Trajectory) -> dict[str, float]:
    """What one percent more of each limit would gain [s]; nothing where that was not asked for."""
    if not job.prices:
        return {}
    if any(name.startswith(CONTINUOUS) and share >= BINDING for name, share in trajectory.usage().rows.items()):
        steps.say("no prices: the motion was slowed for the continuous rating of a motor, which has none")
        return {}
    with steps.step("pricing") as step:
        prices = trajectory.prices()
        step.note = f"{len(prices)} limits"
    return prices


def say_tool_changes(job: Job, steps: TimedSteps, toolpath: ToolPath) -> None:
    """What the tool changes of the set-up sheet take beside the motion, where it tells of them."""
    from toolpace.controls.timing.program_time import changes

    each, count = job.options.setup.tool_change, sum(changes(toolpath.operations))
    if each > 0.0 and count:
        steps.say(
            f"the duration is without {counted(count, 'tool change')} of {format_time(each)} (set-up sheet, [times]): "
            f"{format_time(count * each)} more"
        )


class Sampled(NamedTuple):
    """A motion at equal times, seen by the judge, with what its folder will hold of it."""

    points: SetPointSource
    judge: MotionJudge
    digest: SetPointDigest


def sample_motion(job: Job, steps: TimedSteps, trajectory: Trajectory, toolpath: ToolPath) -> Sampled:
    """Set-points at equal times, within travel, block by block: each goes from the trajectory to the judge and to the
    files. The use of the limits between them is looked at on the way."""
    from toolpace.common.errors import ReachError
    from toolpace.judge import motion_judge
    from toolpace.motion.sampling import Sampling, each_block
    from toolpace.motion.setpoints import in_memory
    from toolpace.programs.reading.setup_file import setup_text
    from toolpace.results import write

    with steps.step("sampling") as step:
        points: SetPointSource = Sampling(trajectory, job.dt, on_grid=True)
        if holds_all(job, len(points)):
            points = trajectory.sample(job.dt, on_grid=True)
        judge = motion_judge(
            points, job.machine, toolpath, job.tip_tolerance, job.axis_tolerance, job.tool,
            setup_text(job.options.setup),
        )  # fmt: skip
        digest = write.digest_of(job.machine, trajectory, points, toolpath, report=job.report, npz=job.npz)

        def check_travel(block: Block) -> None:
            job.machine.check_travel(block.points.q, block.points.block, toolpath.source)

        try:
            each_block(points, (check_travel, judge.take, digest.take), beside=(trajectory.usage,))
        except ReachError:
            every = in_memory(points)
            job.machine.check_travel(every.q, every.block, toolpath.source)
            raise
        step.note = f"{len(points)} set-points"
    return Sampled(points, judge, digest)


def verify_motion(steps: TimedSteps, judge: MotionJudge) -> Verification:
    """The judge's word on the set-points that it has seen."""
    with steps.step("verifying"):
        return judge.judged()[0]


def write_results(job: Job, steps: TimedSteps, result: PlanResult) -> PlanRecord:
    """The folder, whole or not at all."""
    from toolpace.results import write

    with steps.step(write.WRITING) as step:
        return write.write_folder(job.out, result, csv=job.csv, report=job.report, npz=job.npz, progress=step)


def warm_up(steps: TimedSteps) -> None:
    """On the first run of all, compile what the job will need, and say so."""
    from toolpace.kernels import ahead_of_time

    if ahead_of_time.is_warm():
        return
    with steps.step("compiling", "first run on this computer, may take a minute; kept for later runs") as tell:
        ahead_of_time.warm_up(tell)


def written(job: Job, record: PlanRecord) -> list[str]:
    """Names of the files of its folder, the one to look at last."""
    from toolpace.results.write import TRAJECTORY, written_files

    exact = (job.out / TRAJECTORY).exists()
    return written_files(job.program, record, csv=job.csv, report=job.report, npz=job.npz, trajectory=exact)


def exit_code(record: PlanRecord, verification: Verification) -> int:
    """0 where the motion passed, and kept every limit at any time too, not only at the set-points; else 1."""
    return 0 if verification.ok and record.usage.worst <= PROMISED else 1
