"""The time law of a detour and of the motion after it, by the planner that is chosen.

direct     the detour as it was found, then the commanded law; the others fall back on it
genetic    from the rejoining to the next reference point anew (Wu et al. 2009, step 4)
optimal    detour and what follows it anew, where the detour loses time; so does a planner of one's own
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.common.errors import InfeasibleError, UsageError, did_you_mean
from toolpace.common.workers import UNTOLD, Progress, Workers
from toolpace.deflection.detour import DetourRun
from toolpace.deflection.motion_state import Stretch
from toolpace.machine.limits import Limits
from toolpace.motion.laws import ChainLaw, LawPiece, QuinticLaw, TimeLaw
from toolpace.motion.trajectory import Trajectory
from toolpace.path.axis_path import AxisPath
from toolpace.path.axis_run import AxisRun
from toolpace.planning.limit_tolerances import KEPT_INTERVAL, PROMISED
from toolpace.planning.planned_run import AT_REST, EndState, PlannedRun
from toolpace.planning.planner import Planner, planner_of

if TYPE_CHECKING:
    from toolpace.planning.genetic import Genetic

DIRECT = "direct"
"""Short name of no planner at all: the detour runs as made, and the rest as it was."""
PLANNERS = ("optimal", "genetic", DIRECT)
"""Short names of all that can time a detour."""
WORTH = 0.05
"""Time that a detour loses, up to which the optimal planner is not asked to win some of it: the detour is as short as
limits allow, and the law beyond it is the fastest already [s]."""
MOST_ITERATIONS = 3
"""Rounds in which limits between the nodes are held before the law is slowed down: of 160 detours twenty rounds won 90
and 7 ms on two, and took up to three times as long."""
LONGEST = 25.0
"""Time of a detour from which it is not timed anew either: its mesh takes over a second, and won 1 ms of 31 s [s]."""
BEYOND = 1e-12
"""How far behind the rejoining the next reference point lies at least, absolute and relative to s: else it is the same
but for rounding."""
MEETS = 1e-9
"""How far the law may begin and end from the states it shall, relative to their speed and acceleration: rounding."""
NEARLY_THERE = 0.05
"""Time left after the direct law is met, as a share of the detour, below which the rest is timed anew too."""


class Timing(NamedTuple):
    """A way of timing detours."""

    name: str
    """As trajectories tell it."""
    law: Callable[[DetourRun, Limits, TimeLaw], TimeLaw]
    """Takes a detour, the limits and the law under which the detour runs as made; returns the law it shall have."""


def worth_timing(run: DetourRun) -> bool:
    """Whether the optimal planner may save what its own time is worth: never where the joints rest at the end."""
    return run.detour.lost > WORTH and not run.ends_here and run.detour.duration <= LONGEST


def timing_of(planner: str | Planner, options: dict[str, object]) -> Timing:
    """What a planner, or the short name of one and its options, asks for. Raises UsageError."""
    if isinstance(planner, str) and planner not in PLANNERS:
        raise UsageError(f"replan: unknown planner '{planner}'; {did_you_mean(planner, PLANNERS)}")
    if planner == DIRECT:
        if options:
            raise UsageError(f"replan: the planner '{DIRECT}' has no options, but {', '.join(options)} is given")
        return Timing(DIRECT, lambda run, limits, direct: direct)
    # their compiled code is loaded here, where it is used
    from toolpace.planning.genetic import Genetic
    from toolpace.planning.optimal.planner import Optimal
    from toolpace.planning.second_order import SecondOrder

    chosen = planner_of(planner, options, "replan")
    if isinstance(chosen, SecondOrder):
        raise UsageError("replan: accelerations jump in plans of SecondOrder(); give Optimal() or Genetic()")
    if isinstance(chosen, Genetic):
        genetic = chosen
        return Timing(genetic.name, lambda run, limits, direct: genetic_law(run, limits, direct, genetic))
    other = OneTry(chosen.mesh, chosen.guard) if isinstance(chosen, Optimal) else chosen

    def anew(run: DetourRun, limits: Limits, direct: TimeLaw) -> TimeLaw:
        if isinstance(other, OneTry) and not worth_timing(run):
            return direct
        return planned_law(run, limits, direct, other)

    return Timing(other.name, anew)


@dataclass(frozen=True)
class OneTry:
    """The optimal planner without its fallback strategies and its bound: the detour itself is the fallback."""

    mesh: int | None
    guard: bool

    @property
    def name(self) -> str:
        """That of the planner whose motions these are."""
        return "optimal"

    def plan_run(
        self, run: AxisRun, limits: Limits, start: EndState, end: EndState, workers: Workers, progress: Progress
    ) -> PlannedRun:
        """The law of one run. Raises InfeasibleError."""
        from toolpace.planning.optimal.planner import fastest_law

        law, points = fastest_law(run, limits, self.mesh, start, end, self.guard, workers, progress, MOST_ITERATIONS)
        return PlannedRun(law, points)


def find_rejoin(run: DetourRun) -> QuinticLaw:
    """The law of the detour alone: its parameter is a cubic of time."""
    marks = run.detour.times
    p, v, a, jerk = run.parameter(marks)
    p[-1] = run.join
    return QuinticLaw(p, v, a, np.diff(marks), jerk[:-1])


def direct_law(run: DetourRun) -> TimeLaw:
    """The detour as made; then the commanded law goes on."""
    back = find_rejoin(run)
    if run.ends_here:
        return back
    law = run.detour.commanded.law
    rest = LawPiece(law, run.detour.rejoin, law.duration)
    return ChainLaw([LawPiece(back, 0.0, back.duration), rest])


def genetic_law(run: DetourRun, limits: Limits, direct: TimeLaw, planner: Genetic) -> TimeLaw:
    """The genetic algorithm on the interval from the rejoining to the next reference point.

    Speed and acceleration at both ends are those of the direct law, as the paper sets them to those of the reference
    path; from there on the direct law goes on.
    """
    if run.ends_here:
        return direct
    assert isinstance(direct, ChainLaw)
    back, remaining = direct.pieces
    after = next_point(run)
    if after is None:
        return direct
    begin = back.end
    end = begin + remaining.law.passing_time(after) - remaining.begin
    state = direct.at(np.array([begin, end]))
    # to the last digit, since the third derivative jumps there
    state[0] = run.join, after
    piece = shortened_piece(run, limits, LawPiece(direct, begin, end), state, planner)
    return ChainLaw([back, piece, LawPiece(remaining.law, remaining.begin + (end - begin), remaining.end)])


def next_point(run: DetourRun) -> float | None:
    """The reference point after the rejoining; None where it is the end."""
    from toolpace.planning.genetic import reference_points

    commanded = run.detour.commanded
    law = commanded.law
    points = law.s if isinstance(law, QuinticLaw) else reference_points(commanded.run, None)
    after = points[points > run.join * (1.0 + BEYOND) + BEYOND]
    return float(after[0]) if len(after) > 1 else None


def shortened_piece(run: DetourRun, limits: Limits, direct: LawPiece, ends: Floats, planner: Genetic) -> LawPiece:
    """One interval between two states (4, 2), in the shortest period that is found.

    Where that of the direct law is not within the limits as a quintic (the direct law need not be one there), or is
    no longer, the interval keeps the direct law.
    """
    from toolpace.planning.genetic import Intervals, Preset, interval_peaks, with_bred_periods

    s, v, a = ends[:3]
    parts = Intervals(run, limits, s.copy(), (False, False))
    quintic = Preset(v.copy(), a.copy(), np.array([direct.end - direct.begin]))
    if interval_peaks(parts, quintic).max() > KEPT_INTERVAL:
        return direct
    try:
        best = with_bred_periods(parts, quintic, planner)
    except InfeasibleError:
        return direct
    law = QuinticLaw(s.copy(), best.speed, best.acceleration, best.periods)
    return LawPiece(law, 0.0, law.duration) if law.duration < direct.end - direct.begin else direct


def planned_law(run: DetourRun, limits: Limits, direct: TimeLaw, planner: Planner) -> TimeLaw:
    """The law that the planner finds, or the direct one where that is as fast, or keeps to what the other does not."""
    if not (run.smooth or run.ends_here):
        return direct
    met = direct.duration if run.ends_here else min(2.0 * run.detour.duration, direct.duration)
    if direct.duration - met < NEARLY_THERE * run.detour.duration:
        met = direct.duration
    begin = direct.at(np.zeros(1))[:3, 0]
    end = direct.at(np.array([met]))[:3, 0]
    whole = met == direct.duration
    part = Stretch(run, run.s1 if whole else float(end[0]))
    try:
        last = AT_REST if whole else EndState(float(end[1]), float(end[2]))
        first = EndState(float(begin[1]), float(begin[2]))
        law = planner.plan_run(part, limits, first, last, Workers(), UNTOLD).law
    except InfeasibleError:
        return direct
    alike = all(
        np.allclose(law.at(np.array([t]))[1:3, 0], state[1:], rtol=MEETS, atol=MEETS * float(abs(state[1:]).sum()))
        for t, state in ((0.0, begin), *(() if whole else ((law.duration, end),)))
    )
    if not alike or law.duration >= met:
        return direct
    alone = AxisPath((part,), limits.joints, run.machine)
    if Trajectory(alone, limits, (law,)).usage().worst > PROMISED:
        return direct
    if whole:
        return law
    assert isinstance(direct, ChainLaw)
    remaining = direct.pieces[-1]
    rest = LawPiece(remaining.law, remaining.begin + (met - float(direct.times[-2])), remaining.end)
    return ChainLaw([LawPiece(law, 0.0, law.duration), rest])
