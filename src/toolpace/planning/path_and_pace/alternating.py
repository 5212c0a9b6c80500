"""Alternating optimisation of path and speed law: each fit is weighted by the speed of the motions before it.

within the tolerances at hand
    the path that knows no pace, and the motion along it, with its limits held at the nodes: cheap, and it ranks paths
    repeat:  the path fitted again for that pace;  its motion;  not faster by a thousandth?  enough
    the fastest of these paths changed once together with its pace, where that is asked for
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from toolpace.common.errors import InfeasibleError, PathError
from toolpace.common.workers import UNTOLD, Progress
from toolpace.machine.machine import Machine
from toolpace.motion.trajectory import Trajectory
from toolpace.path.axis_path import AxisPath
from toolpace.path.axis_run import AxisRun
from toolpace.path.fit.polyline import PlaceTolerances
from toolpace.path.fit.speed_weights import SpeedWeights
from toolpace.path.fit.tolerance_tube import TubeFit
from toolpace.path.path import Path
from toolpace.planning.mesh.initial_guess import ramp_time
from toolpace.planning.path_and_pace.candidate_evaluation import CheapEvaluation, crawls
from toolpace.planning.planned_run import PlannedRun
from toolpace.planning.planner import plan
from toolpace.programs.tolerances import Tolerances
from toolpace.programs.toolpath import ToolPath


class Measure(NamedTuple):
    """How a pace weighs the roughness of the path that is fitted for it."""

    power: float
    """Of the pace."""
    smoothed: float
    """Time over which it is a mean, in the time in which an acceleration builds up."""


BROAD, SHARP = Measure(6.0, 0.3), Measure(4.0, 0.15)
"""The one finds far better paths than the first soon, the other goes on from the best of these."""
ROUNDS = 4
"""Most rounds with each of these."""
LONG = 40_000
"""Points of a program for which one round is made; of one that is shorter, as many more as take that long."""
ENOUGH = 1e-3
"""Share of the duration that a round must gain for another to follow."""
CANDIDATES = 3
"""Fastest paths within each tolerance that are kept: a motion that holds its limits at the nodes may not be held
between them at its pace."""
RAMPS = 0.02, 0.5
"""Between which that time is taken to be [s]."""
WORSE = 1.1
"""How much longer than the best a motion may take for its path to be worth another round."""
ROOM = 0.02
"""Share of the first motion's time, beyond what feeds and dwells alone take, below which no round is worth its time:
of what feeds leave, a round gains a part."""
FITTED = 0.6
"""Share of a round, for progress, that its fit takes."""


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
    joints: AxisPath | None = None
    """Along the path; None where nobody followed it."""
    whole: Mapping[AxisRun, PlannedRun] | None = None
    """Runs of these, among others, that are planned in whole already."""
    run_times: tuple[float, ...] = ()
    """How long the motion along each run was hoped to take [s]; none where nobody knows."""


class Fastest(NamedTuple):
    """A path that was fitted, and the motion along it, with limits held at the nodes."""

    motion: Trajectory
    candidate: Candidate


class AlternatingOptimisation:
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
        self.ranking = CheapEvaluation(whole={})
        self.tried = 0
        self.fit: TubeFit | None = None
        """Fits within the tolerance at hand, once there was one."""
        self.motion: Trajectory | None = None
        """The fastest within the tolerance at hand."""
        self.best: Fastest | None = None
        """Of all paths that were fitted."""
        self.elsewhere: Trajectory | None = None
        """The fastest within the tolerances before."""

    def within(self, tolerances: Tolerances, widest: float) -> None:
        """Take tolerances of the axis, `widest` [rad] at most, for those at hand."""
        self.tolerances, self.widest = tolerances, widest
        self.elsewhere, self.motion = None if self.best is None else self.best.motion, None
        self.fit = None
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

    def change(self, start: Fastest | None) -> float:
        """A path that was fitted, changed once together with its pace, within the tolerance at hand: the time of its
        motion [s], infinite where there is none."""
        from toolpace.planning.path_and_pace.local_refit import refitted
        from toolpace.planning.path_and_pace.segment import QUICK

        if start is None:
            return np.inf
        motion, path, fitted = start.motion, start.candidate.path, start.candidate.tolerances
        part = self._part()
        allowed = PlaceTolerances.of(self.toolpath, self.tip_tolerance, self.tolerances).counting_in(fitted)
        changing = part.part(0.0, FITTED)
        changed = refitted(self.toolpath, self.machine, path, motion, allowed, self.ramp, QUICK, changing)
        found = self._motion(changed, part.part(FITTED, 1.0))
        self._note(changed, found, 0.0, fitted)
        return np.inf if found is None else found.duration

    def follow(self, start: Trajectory | None, measure: Measure, most: int) -> None:
        """Rounds with one measure of the pace, `most` of them, from a motion on, while they gain; none from none."""
        if start is None:
            return
        fastest, speed_weights = start.duration, self._speed_weights(start, measure)
        for _ in range(most):
            try:
                path, motion = self._round(speed_weights)
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
            latest = self._speed_weights(motion, measure)
            speed_weights = [now.mean_with(before) for now, before in zip(latest, speed_weights)]

    def _note(self, path: Path, motion: Trajectory | None, power: float, fitted: PlaceTolerances | None = None) -> None:
        """Put a round down, and keep its path where it is among the fastest; `fitted`: in which tolerances it counts,
        where these are not those at hand."""
        if motion is None:
            return
        kept = motion.duration < min((each.duration for each in self.done), default=np.inf)
        self.done.append(Round(motion.duration, power, kept, self.widest))
        candidate = self._candidate(motion.duration, path)
        of_runs = tuple(law.duration for law in motion.laws)
        candidate = candidate._replace(joints=motion.axis_path, whole=self.ranking.whole, run_times=of_runs)
        if fitted is not None:
            # what was changed already is not changed again: it is rougher between the places where it was held
            self.levels[-1].append(candidate._replace(tolerances=fitted))
            return
        self.levels[-1].append(candidate)
        if self.best is None or motion.duration < self.best.motion.duration:
            self.best = Fastest(motion, candidate)

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

    def _speed_weights(self, motion: Trajectory, measure: Measure) -> list[SpeedWeights]:
        smoothed = measure.smoothed * self.ramp
        return [law.speed_weights(smoothed, self.ramp, measure.power) for law in motion.laws]

    def _round(self, speed_weights: Sequence[SpeedWeights] | None) -> tuple[Path, Trajectory | None]:
        """A path, and its motion with limits held at the nodes; None where there is none (a whole plan will say why),
        or none that tells how fast the path is."""
        part = self._part()
        begin = time.perf_counter()
        if self.fit is None:
            self.fit = TubeFit(self.toolpath, self.tip_tolerance, self.tolerances, self.machine)
        runs, tip, axis, wait = self.fit.runs(part.part(0.0, FITTED), speed_weights)
        path = Path(runs, tip, axis, time.perf_counter() - begin, wait)
        return path, self._motion(path, part.part(FITTED, 1.0))

    def _part(self) -> Progress:
        """The next part of the work: how many there will be nobody knows, and the first ones take the longest."""
        self.tried += 1
        return self.progress.part(1.0 - 0.5 ** (self.tried - 1), 1.0 - 0.5**self.tried)

    def _motion(self, path: Path, progress: Progress) -> Trajectory | None:
        """The motion along a path by which it is ranked; None where there is none, or none that tells."""
        try:
            motion = plan(path, self.machine, planner=self.ranking, progress=progress)
        except InfeasibleError:
            return None
        return None if any(map(crawls, motion.laws)) else motion


def hope(candidate: Candidate) -> float:
    """How long the motion along a path is hoped to take [s]."""
    return candidate.hoped
