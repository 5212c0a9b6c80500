"""From a program to its motion: path and pace, each from the other.

for some tolerances of the tool axis, up to the one asked for: a path within a narrow one is within a wider
    a path within the tolerances, as smooth as its length allows                  (low: this one is planned)
    repeat
        the path fitted again, smoother where the motion is fast, less so where it is slow anyway
        the motion along it, with its limits held at the nodes: cheap, and it ranks paths as the whole plan does
        not faster by a thousandth?  enough; and none at all where feeds and dwells take nearly all the time
    of a short program one such round, and then path and pace changed together, once                   (normal)
the fastest of these paths, planned in full
while another one was hoped to take less than that came to, it too: the best is taken
before all that, path and pace of the one that is hoped to be the fastest changed together,          (high)
while that gains; where its plan takes less than was hoped of all others, none of them is planned
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from toolpace.axispath.axispath import AxisPath
from toolpace.description import counted, one_line
from toolpace.errors import InfeasibleError, PathError, ReachError, ToolpaceError, UsageError, did_you_mean
from toolpace.laws.law import TimeLaw
from toolpace.machine.machine import Machine, check_machine
from toolpace.path.fit.haste import Haste
from toolpace.path.fit.polyline import PlaceTolerances
from toolpace.path.path import Path
from toolpace.planning.mesh.guess import ramp_time
from toolpace.planning.planner import Planner, plan, planner_of
from toolpace.tolerances.tolerances import Tolerances
from toolpace.toolpath import ToolPath
from toolpace.trajectory import Trajectory
from toolpace.workers import UNTOLD, Progress

if TYPE_CHECKING:
    from toolpace.planning.together.rounds import Together


class Measure(NamedTuple):
    """How a pace weighs the roughness of the path that is fitted for it."""

    power: float
    """Of the pace."""
    smoothed: float
    """Time over which it is a mean, in the time in which an acceleration builds up."""


BROAD, SHARP = Measure(6.0, 0.3), Measure(4.0, 0.15)
"""The one finds far better paths than the first soon, the other goes on from the best of these."""
MEASURES: dict[str, tuple[Measure, ...]] = {"low": (), "normal": (BROAD, SHARP), "high": (BROAD, SHARP)}
"""By effort, one after the other."""
EFFORTS = tuple(MEASURES)
"""low: the path is fitted once; normal: a few rounds of pace and fit, or one and a quick change of both; high: after
the rounds both are changed together."""
ROUNDS = 4
"""Most rounds with each of these."""
LONG = 40_000
"""Points of a program for which one round is made; of one that is shorter, as many more as take that long."""
SHORT = 10_000
"""Points of a program up to which path and pace are changed together by "normal" too: for a longer one that takes more
time than all else."""
ENOUGH = 1e-3
"""Share of the duration that a round must gain for another to follow."""
CANDIDATES = 3
"""Fastest paths within each tolerance that are kept: a motion that holds its limits at the nodes may not be held
between them at its pace."""
RAMPS = 0.02, 0.5
"""Between which that time is taken to be [s]."""
RUNGS = np.radians([0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 3.0, 5.0, 10.0, 20.0])
"""Tolerances of the tool axis that are tried within a wider one [rad]: those that people ask for."""
APART = 1.2
"""How much wider than these the one asked for must be, for them to be tried beside it."""
WORSE = 1.1
"""How much longer than the best a motion may take for its path to be worth another round."""
ROOM = 0.02
"""Share of the first motion's time, beyond what feeds and dwells alone take, below which no round is worth its time:
of what feeds leave, a round gains a part."""
CRAWLING, CRAWL_LOOKS = 1e-3, 256
"""Share of its mean pace below which a motion hardly moves, and how often it is looked at."""
FITTED = 0.6
"""Share of a round, for progress, that its fit takes."""
ROUNDS_DONE = 0.3
"""Share of a whole plan that the rounds take."""
CHANGED = 0.8
"""Share of what follows that is done once path and pace are changed together."""


@dataclass(frozen=True)
class Round:
    """One path on the way, and how fast it may be passed."""

    duration: float
    """Of its motion with limits held at the nodes [s]: the whole plan takes a little more."""
    power: float
    """Of the pace in the weight of its roughness; 0 for the first path, which knows no pace, and for one that was
    changed together with its own."""
    kept: bool
    """Whether it was the fastest so far."""
    axis_tolerance: float
    """Of the tool axis, that it was fitted within [rad]: at most the one asked for."""


class Candidate(NamedTuple):
    """A path that a program may be planned on."""

    hoped: float
    """How long its motion was hoped to take [s]; 0 where nobody knows."""
    path: Path
    tolerances: PlaceTolerances
    """That it was fitted within."""


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
    together: Together | None = None
    """What it takes to change path and pace together, where that is asked for."""

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
    few rounds of pace and fit, and in a quick change of both; "high" changes path and pace together. Paths are ranked
    by motions with their limits held at the nodes, and the path of "low" is planned too where it may be the best.
    Another planner than the optimal one takes the path as "low" does. `progress` is told the share done. Raises
    UsageError for what makes no sense, PathError where no curve fits, InfeasibleError where no motion exists.
    """
    told = Progress(progress or (lambda share: None))
    chosen = planner_of(planner, {}, "plan_program")
    effort = effort_for(effort, chosen)
    fitted = fit_program(
        toolpath, machine, tip_tolerance, axis_tolerance, effort=effort, progress=told.part(0.0, ROUNDS_DONE)
    )
    return plan_fitted(fitted, machine, planner=chosen, progress=told.part(ROUNDS_DONE, 1.0))


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
    check_machine(machine, "plan_program")
    told = Progress(progress or (lambda share: None))
    asked_for = PlaceTolerances.of(toolpath, tip_tolerance, axis_tolerance)
    if not MEASURES[effort]:
        path = Path.fit(toolpath, tip_tolerance, axis_tolerance, machine, told)
        return FittedProgram((Candidate(0.0, path, asked_for),), path, effort)
    asked = Tolerances.of(axis_tolerance, "axis_tolerance")
    rounds = PaceRounds(toolpath, machine, tip_tolerance, told)
    rungs = axis_tolerances(float(asked.axis_along(toolpath).max()))
    quick = effort == "normal" and len(toolpath) <= SHORT
    for axis in rungs:
        last = axis == rungs[-1]
        rounds.within(asked.within(axis), axis)
        if not quick or last or rounds.best is None:
            rounds.begin(last=last)
            if rounds.leave_no_room():
                continue
            for measure in (BROAD,) if quick else MEASURES[effort]:
                rounds.follow(rounds.motion, measure, 1 if quick else rounds.most)
                rounds.follow(rounds.elsewhere, measure, 1 if quick else rounds.most)
        if quick and not rounds.leave_no_room():
            rounds.change()
    told(1.0)
    together = None
    if effort == "high":
        from toolpace.planning.together.rounds import Together

        together = Together(toolpath, asked_for, rounds.ramp)
    return FittedProgram(rounds.candidates(), rounds.first, effort, tuple(rounds.done), together)


def axis_tolerances(widest: float) -> list[float]:
    """The tolerance of the tool axis that is asked for, and those within it that are tried before [rad], ascending.

    A path within a narrower tolerance is one within a wider. As these are the same for all, and all their fastest paths
    are candidates, what is gained within one of them is never lost to a wider one.
    """
    return [*(float(rung) for rung in RUNGS if rung < widest / APART), widest]


class PaceRounds:
    """Paths that follow each other, each fitted for the pace of those before it."""

    def __init__(
        self, toolpath: ToolPath, machine: Machine, tip_tolerance: float | Tolerances, progress: Progress = UNTOLD
    ) -> None:
        self.toolpath, self.machine, self.tip_tolerance, self.progress = toolpath, machine, tip_tolerance, progress
        self.ramp = float(np.clip(ramp_time(machine.limits), *RAMPS))
        self.most = int(np.clip(LONG // len(toolpath), 1, ROUNDS))
        self.done: list[Round] = []
        self.levels: list[list[Candidate]] = []
        self.unknown: list[Candidate] = []
        self.tried = 0
        self.motion: Trajectory | None = None
        """The fastest within the tolerance at hand."""
        self.best: Trajectory | None = None
        """The fastest of all on a path that was fitted."""
        self.best_path: Candidate | None = None
        """That it goes along."""
        self.elsewhere: Trajectory | None = None
        """The fastest within the tolerances before."""

    def within(self, tolerances: Tolerances, widest: float) -> None:
        """Take tolerances of the axis, `widest` [rad] at most, for those at hand."""
        self.tolerances, self.widest = tolerances, widest
        self.elsewhere, self.motion = self.best, None
        self.levels.append([])

    def begin(self, *, last: bool) -> None:
        """The path that knows no pace.

        One that cannot be had is passed over. Raises PathError where it is the last, and there was none before.
        """
        try:
            path, self.motion = self._round(None)
        except PathError:
            if last and not (self.unknown or any(self.levels)):
                raise
            return
        # the smoothest path within all of the tolerance is the one of "low", and the one whose problem is told
        self.first = path
        if self.motion is None:
            self.unknown.append(self._candidate(0.0, path))
        self._note(path, self.motion, 0.0)

    def leave_no_room(self) -> bool:
        """Whether feeds and dwells take nearly all of the time of the first motion."""
        return bool(self.done) and self.toolpath.least_duration > (1.0 - ROOM) * self.done[0].duration

    def change(self) -> None:
        """The fastest path that was fitted, changed once together with its pace, within the tolerance at hand."""
        from toolpace.planning.together.care import QUICK
        from toolpace.planning.together.refit import refitted

        if self.best is None or self.best_path is None:
            return
        _, path, fitted = self.best_path
        told = self._part()
        allowed = PlaceTolerances.of(self.toolpath, self.tip_tolerance, self.tolerances).counting_in(fitted)
        changing = told.part(0.0, FITTED)
        changed = refitted(self.toolpath, self.machine, path, self.best, allowed, self.ramp, QUICK, changing)
        self._note(changed, self._motion(changed, told.part(FITTED, 1.0)), 0.0, fitted)

    def follow(self, start: Trajectory | None, measure: Measure, most: int) -> None:
        """Rounds with one measure of the pace, `most` of them, from a motion on, while they gain; none from none."""
        if start is None:
            return
        fastest, hastes = start.duration, self._hastes(start, measure)
        for _ in range(most):
            try:
                path, motion = self._round(hastes)
            except PathError:
                return
            self._note(path, motion, measure.power)
            if motion is None:
                return
            gained = 1.0 - motion.duration / fastest
            fastest = min(fastest, motion.duration)
            if self.motion is None or motion.duration < self.motion.duration:
                self.motion = motion
            if gained < ENOUGH or motion.duration > WORSE * min(each.duration for each in self.done):
                return
            hastes = [now.mean_with(before) for now, before in zip(self._hastes(motion, measure), hastes)]

    def _note(self, path: Path, motion: Trajectory | None, power: float, fitted: PlaceTolerances | None = None) -> None:
        """Put a round down, and keep its path where it is among the fastest; `fitted`: in which tolerances it counts,
        where these are not those at hand."""
        if motion is None:
            return
        kept = motion.duration < min((each.duration for each in self.done), default=np.inf)
        self.done.append(Round(motion.duration, power, kept, self.widest))
        candidate = self._candidate(motion.duration, path)
        if fitted is not None:
            # what was changed already is not changed again: it is rougher between the places where it was held
            self.levels[-1].append(candidate._replace(tolerances=fitted))
            return
        self.levels[-1].append(candidate)
        if self.best is None or motion.duration < self.best.duration:
            self.best, self.best_path = motion, candidate

    def _candidate(self, hoped: float, path: Path) -> Candidate:
        within = PlaceTolerances.of(self.toolpath, self.tip_tolerance, self.tolerances)
        return Candidate(hoped, path, within)

    def candidates(self) -> tuple[Candidate, ...]:
        """Of each tolerance the fastest paths and the first: the fastest first.

        Nobody knows of one without a motion, and it may be the best: it comes last.
        """
        chosen: list[Candidate] = []
        for level in self.levels:
            best = sorted(level, key=hope)[:CANDIDATES]
            chosen += best if not level or any(each is level[0] for each in best) else [*best, level[0]]
        return (*sorted(chosen, key=hope), *self.unknown)

    def _hastes(self, motion: Trajectory, measure: Measure) -> list[Haste]:
        smoothed = measure.smoothed * self.ramp
        return [Haste.of_law(law, smoothed, self.ramp, measure.power) for law in motion.laws]

    def _round(self, hastes: Sequence[Haste] | None) -> tuple[Path, Trajectory | None]:
        """A path, and its motion with limits held at the nodes; None where there is none (a whole plan will say why),
        or none that tells how fast the path is."""
        told = self._part()
        path = Path.fit(
            self.toolpath, self.tip_tolerance, self.tolerances, self.machine, told.part(0.0, FITTED), hastes
        )
        return path, self._motion(path, told.part(FITTED, 1.0))

    def _part(self) -> Progress:
        """The next part of the work: how many there will be nobody knows, and the first ones take the longest."""
        self.tried += 1
        return self.progress.part(1.0 - 0.5 ** (self.tried - 1), 1.0 - 0.5**self.tried)

    def _motion(self, path: Path, progress: Progress) -> Trajectory | None:
        """The motion along a path with limits held at the nodes; None where there is none, or none that tells."""
        try:
            motion = plan(path, self.machine, guard=False, bound=False, progress=progress)
        except InfeasibleError:
            return None
        return None if any(map(crawls, motion.laws)) else motion


def hope(candidate: Candidate) -> float:
    """How long the motion along a path is hoped to take [s]."""
    return candidate.hoped


def crawls(law: TimeLaw) -> bool:
    """Whether a motion hardly moves for half of its time: held at the nodes only, its pace may fall to next to nothing
    between two of them, which the guard of a whole plan mends."""
    s = law.at(np.linspace(0.0, law.duration, CRAWL_LOOKS + 1))[0]
    slow = np.diff(s) < CRAWLING * (s[-1] - s[0]) / CRAWL_LOOKS
    return bool(2 * slow.sum() > CRAWL_LOOKS)


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

    told = Progress(progress or (lambda share: None))
    changed = changed_plan(fitted, machine, check, told.part(0.0, CHANGED))
    if changed is not None and changed.trajectory.duration <= fitted.candidates[0].hoped:
        told(1.0)
        return changed
    planning = told.part(CHANGED, 1.0) if fitted.together is not None else told

    def whole(path: Path) -> ProgramPlan:
        axis_path = AxisPath.follow(path, machine)
        check(axis_path)
        trajectory = plan(axis_path, machine, planner=planner, progress=planning)
        return ProgramPlan(path, trajectory, fitted.effort, fitted.rounds)

    best = changed
    problem: ToolpaceError | None = None
    for hoped, path, _ in fitted.candidates:
        if best is not None and best.trajectory.duration <= hoped:
            continue
        try:
            found = whole(path)
        except (InfeasibleError, ReachError) as error:
            if problem is None or path is fitted.first:
                problem = error
            continue
        if best is None or found.trajectory.duration < best.trajectory.duration:
            best = found
    if best is None:
        assert problem is not None
        raise problem
    return best


def changed_plan(
    fitted: FittedProgram, machine: Machine, check: Callable[[AxisPath], None], progress: Progress
) -> ProgramPlan | None:
    """The plan of the path that is hoped to be the fastest, changed together with its pace; None where that is not
    asked for, or nothing was found."""
    first = fitted.candidates[0]
    if fitted.together is None or first.hoped == 0.0:
        return None
    found = fitted.together.faster(first.path, first.tolerances, machine, check, progress)
    return None if found is None else ProgramPlan(*found, fitted.effort, fitted.rounds)
