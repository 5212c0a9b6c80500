"""Path and motion of a whole program, from its tool path, tolerances and a machine.

for some tolerances of the tool axis, up to the one asked for: a path within a narrow one is within a wider
    a path within the tolerances, as smooth as its length allows                  (low: this one is planned)
    repeat
        the path fitted again, smoother where the motion is fast, less so where it is slow anyway
        the motion along it, with its limits held at the nodes: cheap, and it ranks paths as the whole plan does
        not faster by a thousandth?  enough; and none at all where feeds and dwells take nearly all the time
    of a short program one such round within the narrowest and the widest, and then path and pace changed together,
        once within the widest, and within the next narrower one while that is no slower               (normal)
of each run the fastest of these paths, planned in full; where that takes unusually longer than was hoped, and than is
hoped of another one, that one too: the best of each run is taken
before all that, path and pace of the fastest of many rounds changed together while that gains;       (high)
where its plan takes less than was hoped of all others, those of normal too, none of them is planned
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from toolpace.common.errors import InfeasibleError, ReachError, UsageError, did_you_mean
from toolpace.common.value_objects import counted, one_line
from toolpace.common.workers import Progress
from toolpace.machine.limits import Limits
from toolpace.machine.machine import Machine, check_machine
from toolpace.motion.torques_over_time import rated_torques
from toolpace.motion.trajectory import Trajectory
from toolpace.path.axis_path import AxisPath
from toolpace.path.fit.polyline import PlaceTolerances
from toolpace.path.path import Path
from toolpace.planning.continuous_torque import unrated, within_ratings
from toolpace.planning.optimal.planner import Optimal
from toolpace.planning.path_and_pace.alternating import (
    BROAD,
    SHARP,
    AlternatingOptimisation,
    Candidate,
    Fastest,
    Measure,
    Round,
)
from toolpace.planning.path_and_pace.candidate_evaluation import FULL, Alternative, BestOfRuns
from toolpace.planning.planner import Planner, plan, planner_of
from toolpace.programs.tolerances import Tolerances
from toolpace.programs.toolpath import ToolPath, check_toolpath

if TYPE_CHECKING:
    from toolpace.planning.path_and_pace.simultaneous import SimultaneousOptimisation


MEASURES: dict[str, tuple[Measure, ...]] = {"low": (), "normal": (BROAD, SHARP), "high": (BROAD, SHARP)}
"""By effort, one after the other."""
EFFORTS = tuple(MEASURES)
"""low: the path is fitted once; normal: a few iterations of path and speed, or one and a quick optimisation of both;
high: after the iterations both are optimised together."""
SHORT = 10_000
"""Points of a program up to which path and pace are changed together by "normal" too: for a longer one that takes more
time than all else."""
RUNGS = np.radians([0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 3.0, 5.0, 10.0, 20.0])
"""Tolerances of the tool axis that are tried within a wider one [rad]: those that people ask for."""
APART = 1.2
"""How much wider than these the one asked for must be, for them to be tried beside it."""
ROUNDS_DONE = 0.3
"""Share of a whole plan that the rounds take."""
CHANGED = 0.8
"""Share of what follows that is done once path and pace are changed together."""


@dataclass(frozen=True, eq=False, repr=False)
class FittedProgram:
    """The paths that a program may be planned on."""

    candidates: tuple[Candidate, ...]
    """Of each tolerance of the axis the fastest ones and the first."""
    first: Path
    """The one that knows no pace, within all of the tolerance."""
    effort: str
    rounds: tuple[Round, ...] = ()
    """The first path and each that followed; none where it was fitted once."""
    start: Candidate | None = None
    """From which path and pace are changed together."""
    together: SimultaneousOptimisation | None = None
    """What that takes, where it is asked for."""

    def __repr__(self) -> str:
        return one_line(self, f"effort {self.effort}", counted(max(len(self.rounds) - 1, 0), "round"))


@dataclass(frozen=True, eq=False, repr=False)
class ProgramPlan:
    """The path of a program, the motion along it, and what the rounds of path and pace gained."""

    path: Path
    trajectory: Trajectory
    effort: str
    """What was asked for, or "low" where the planner takes the path as it is."""
    rounds: tuple[Round, ...]
    """The first path and each that followed; none where it was fitted once."""

    def __repr__(self) -> str:
        rounds = counted(max(len(self.rounds) - 1, 0), "round")
        return one_line(self, f"{self.trajectory.duration:.6g} s", f"effort {self.effort}", rounds)


def plan_program(
    toolpath: ToolPath,
    machine: Machine,
    tip_tolerance: float | Tolerances = 10e-6,
    axis_tolerance: float | Tolerances = 1e-3,
    *,
    effort: str = "normal",
    planner: str | Planner = "optimal",
    progress: Callable[[float], None] | None = None,
) -> ProgramPlan:
    """The fastest motion of a tool path within the tolerances [m], [rad] and the limits of a machine.

    `effort` "low" fits the smoothest path and plans it; "normal" spends the tolerance where the motion is fast, in a
    few iterations of path and speed, and in a quick change of both; "high" optimises both together. Paths are ranked
    by motions with their limits held at the nodes, and the path of "low" is planned too where it may be the best.
    Another planner than the optimal one takes the path as "low" does. `progress` is told the share done. Raises
    UsageError for what makes no sense, PathError where no curve fits, InfeasibleError where no motion exists.
    """
    total = Progress(progress or (lambda share: None))
    chosen = planner_of(planner, {}, "plan_program")
    effort = effort_for(effort, chosen)
    fitted = fit_program(
        toolpath, machine, tip_tolerance, axis_tolerance, effort=effort, progress=total.part(0.0, ROUNDS_DONE)
    )
    return plan_fitted(fitted, machine, planner=chosen, progress=total.part(ROUNDS_DONE, 1.0))


def effort_for(effort: str, planner: str | Planner) -> str:
    """The effort that is made: the one asked for, or "low" with a planner of another pace. Raises UsageError."""
    if effort not in MEASURES:
        raise UsageError(f"effort is {str(effort)[:40]!r}; {did_you_mean(str(effort), EFFORTS)}")
    name = planner if isinstance(planner, str) else planner.name
    return effort if name == "optimal" else "low"


def fit_program(
    toolpath: ToolPath,
    machine: Machine,
    tip_tolerance: float | Tolerances,
    axis_tolerance: float | Tolerances,
    *,
    effort: str = "normal",
    progress: Callable[[float], None] | None = None,
) -> FittedProgram:
    """The path that may be passed the fastest, of those that an effort looks at. Raises as `Path.fit`."""
    check_toolpath(toolpath, "plan_program")
    check_machine(machine, "plan_program")
    total = Progress(progress or (lambda share: None))
    tolerances = PlaceTolerances.of(toolpath, tip_tolerance, axis_tolerance)
    if not MEASURES[effort]:
        path = Path.fit(toolpath, tip_tolerance, axis_tolerance, machine, total)
        return FittedProgram((Candidate(0.0, path, tolerances),), path, effort)
    allowed = Tolerances.of(axis_tolerance, "axis_tolerance")
    short = len(toolpath) <= SHORT
    # what normal finds is among what high chooses from: more effort never takes longer
    ways = [True, False] if short and effort == "high" else [short]
    made = [
        made_rounds(AlternatingOptimisation(toolpath, machine, tip_tolerance, part), allowed, quick, MEASURES[effort])
        for quick, part in zip(ways, total.split([1.0] * len(ways)))
    ]
    total(1.0)
    last = made[-1]
    together = None
    if effort == "high":
        from toolpace.planning.path_and_pace.simultaneous import SimultaneousOptimisation

        together = SimultaneousOptimisation(toolpath, tolerances, last.ramp)
    return FittedProgram(all_candidates(made), last.first, effort, all_rounds(made), last.candidates()[0], together)


def made_rounds(
    rounds: AlternatingOptimisation, allowed: Tolerances, quick: bool, measures: Sequence[Measure]
) -> AlternatingOptimisation:
    """The rounds within each tolerance of the axis up to those asked for; `quick`: one within the narrowest that a path
    fits in and one within the widest, and a quick change of what these found."""
    widest = float(allowed.axis_along(rounds.toolpath).max())
    # where nothing turns, all of them give the same path
    rungs = axis_tolerances(widest) if turns(rounds.toolpath) else [widest]
    narrow: Fastest | None = None
    within: list[float] = []
    for axis in rungs:
        last = axis == rungs[-1]
        if quick and not last and rounds.best is not None:
            within.append(axis)
            continue
        narrow = rounds.best
        rounds.within(allowed.within(axis), axis)
        rounds.begin(last=last)
        if rounds.leave_no_room():
            continue
        for measure in (BROAD,) if quick else measures:
            rounds.follow(rounds.motion, measure, 1 if quick else rounds.most)
            rounds.follow(rounds.elsewhere, measure, 1 if quick else rounds.most)
        if rounds.best is not None and not last:
            within.append(axis)
    if quick and not rounds.leave_no_room():
        change_once(rounds, allowed, within, narrow)
    return rounds


def change_once(
    rounds: AlternatingOptimisation, allowed: Tolerances, within: Sequence[float], narrow: Fastest | None
) -> None:
    """The quick change within the widest tolerance of the axis, and within those that are narrower, ascending, from the
    fastest path of these: the widest first, as long as that is no slower."""
    fastest = rounds.change(rounds.best)
    for axis in reversed(within):
        rounds.within(allowed.within(axis), axis)
        changed = rounds.change(narrow)
        # the room of a wider one nearly always gains: where it did, there is no more within
        if changed > fastest:
            return
        fastest = changed


def turns(toolpath: ToolPath) -> bool:
    """Whether the tool axis or a rotary joint moves anywhere along a tool path."""
    directions = toolpath.axis if toolpath.rotary is None else np.concatenate([toolpath.axis, toolpath.rotary], axis=1)
    return bool(np.any(directions != directions[0]))


def all_candidates(made: Sequence[AlternatingOptimisation]) -> tuple[Candidate, ...]:
    """Those of all, the fastest first, each once: what takes as long to the last digit is the same path."""
    candidates_by_time = {each.hoped: each for rounds in made for each in rounds.candidates() if each.hoped > 0.0}
    return (*(candidates_by_time[each] for each in sorted(candidates_by_time)), *made[-1].unknown)


def all_rounds(made: Sequence[AlternatingOptimisation]) -> tuple[Round, ...]:
    """One after the other, those that begin alike once."""
    iterations = list(made[0].done)
    for each in (each for rounds in made[1:] for each in rounds.done if each not in made[0].done):
        iterations.append(replace(each, kept=each.duration < min(before.duration for before in iterations)))
    return tuple(iterations)


def axis_tolerances(widest: float) -> list[float]:
    """The tolerance of the tool axis that is asked for, and those within it that are tried before [rad], ascending.

    A path within a narrower tolerance is one within a wider. As these are the same for all, and their fastest paths are
    candidates, what is gained within one of them is not lost to a wider one: in rounds never, by the quick change
    where times fall from each to the next.
    """
    return [*(float(rung) for rung in RUNGS if rung < widest / APART), widest]


def plan_fitted(
    fitted: FittedProgram,
    machine: Machine,
    *,
    planner: str | Planner = "optimal",
    progress: Callable[[float], None] | None = None,
    check: Callable[[AxisPath], None] = lambda axis_path: None,
) -> ProgramPlan:
    """The whole plan of a fitted program, on the path that turns out to be the best.

    `check` is given the joints along a path before they are planned, and raises ReachError where these will not do.
    Raises as `check` and `plan` do of the first path, where no other will do.
    """
    chosen = planner_of(planner, {})
    found = fastest_plan(fitted, machine, chosen, Progress(progress or (lambda share: None)), check)
    if not isinstance(chosen, Optimal) or not rated_torques(found.trajectory.limits):
        return found
    quick, path = replace(chosen, bound=False), found.trajectory.axis_path

    def within(limits: Limits) -> Trajectory:
        return replace(plan(path, unrated(limits), planner=quick), limits=limits)

    # paths are compared by motions that need not keep the continuous ratings of motors
    return replace(found, trajectory=within_ratings(found.trajectory, within))


def fastest_plan(
    fitted: FittedProgram, machine: Machine, chosen: Planner, total: Progress, check: Callable[[AxisPath], None]
) -> ProgramPlan:
    """The whole plan on the path that is the fastest within all limits at each instant; as `plan_fitted`."""
    changed = changed_plan(fitted, machine, check, total.part(0.0, CHANGED))
    if changed is not None and changed.trajectory.duration <= fitted.candidates[0].hoped:
        total(1.0)
        return changed
    try:
        found = planned_by_run(fitted, machine, chosen, check, total.part(CHANGED, 1.0) if fitted.together else total)
    except (InfeasibleError, ReachError):
        if changed is None:
            raise
        return changed
    return found if changed is None or found.trajectory.duration < changed.trajectory.duration else changed


def planned_by_run(
    fitted: FittedProgram, machine: Machine, planner: Planner, check: Callable[[AxisPath], None], progress: Progress
) -> ProgramPlan:
    """The whole plan of the path that takes of each run the best of all candidates. Raises as `check` and `plan`."""
    candidates = fitted.candidates
    joints = [each.joints or AxisPath.follow(each.path, machine) for each in candidates]
    first = next((k for k, each in enumerate(candidates) if each.path is fitted.first), 0)
    base = joints[first]
    if len(candidates) == 1:
        check(base)

    def alternatives(run: int) -> list[Alternative]:
        return [
            Alternative(
                each.run_times[run] if each.run_times else 0.0,
                along.runs[run],
                number,
                each.whole.get(along.runs[run]) if each.whole and planner == FULL else None,
            )
            for number, (each, along) in enumerate(zip(candidates, joints))
        ]

    best = BestOfRuns(
        planner,
        {run: alternatives(k) for k, run in enumerate(base.runs)},
        lambda run: check(replace(base, runs=(run,))) if len(candidates) > 1 else None,
    )
    trajectory = plan(base, machine, planner=best, progress=progress)
    taken = [best.taken[run] for run in base.runs]
    path = path_of_runs([candidates[each.candidate].path for each in taken])
    trajectory = replace(trajectory, axis_path=replace(base, runs=tuple(each.run for each in taken)))
    return ProgramPlan(path, trajectory, fitted.effort, fitted.rounds)


def path_of_runs(paths: Sequence[Path]) -> Path:
    """The path of which each run is that of another one: all of them go through the points at which they stop."""
    if all(path is paths[0] for path in paths):
        return paths[0]
    runs = tuple(path.runs[k] for k, path in enumerate(paths))
    off = [run.deviations() or (0.0, path.tip_deviation, path.axis_deviation) for run, path in zip(runs, paths)]
    tip, axis = (max(float(np.max(each[kind])) for each in off) for kind in (1, 2))
    return replace(paths[0], runs=runs, tip_deviation=tip, axis_deviation=axis)


def changed_plan(
    fitted: FittedProgram, machine: Machine, check: Callable[[AxisPath], None], progress: Progress
) -> ProgramPlan | None:
    """The plan of the path that is hoped to be the fastest, changed together with its pace; None where that is not
    asked for, or nothing was found."""
    start = fitted.start
    if fitted.together is None or start is None or start.hoped == 0.0:
        return None
    found = fitted.together.faster(start.path, start.tolerances, machine, check, progress)
    return None if found is None else ProgramPlan(*found, fitted.effort, fitted.rounds)
