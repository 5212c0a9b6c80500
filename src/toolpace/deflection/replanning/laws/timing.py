"""The choice of the planner that times a detour."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

from toolpace.common.errors import UsageError, did_you_mean
from toolpace.common.workers import Progress, Workers
from toolpace.deflection.replanning.detour import DetourRun
from toolpace.machine.limits import Limits
from toolpace.motion.laws.law import TimeLaw
from toolpace.path.axis_run import AxisRun
from toolpace.planning.endstate import EndState
from toolpace.planning.planned_run import PlannedRun
from toolpace.planning.planner import Planner, planner_of

DIRECT = "direct"
"""Short name of no planner at all: the detour runs as made, and the rest as it was."""
PLANNERS = ("optimal", "genetic", DIRECT)
"""Short names of all that can time a detour."""
WORTH = 0.05
"""Time that a detour loses, up to which the optimal planner is not asked to win some of it: the detour is as short as
limits allow, and the law beyond it is the fastest already [s]."""
ROUNDS = 3
"""Rounds in which limits between the nodes are held before the law is slowed down: of 160 detours twenty rounds won 90
and 7 ms on two, and took up to three times as long."""
LONGEST = 25.0
"""Time of a detour from which it is not timed anew either: its mesh takes over a second, and won 1 ms of 31 s [s]."""


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
    from toolpace.deflection.replanning.laws.genetic import genetic_law
    from toolpace.deflection.replanning.laws.planned import planned_law
    from toolpace.planning.genetic.planner import Genetic
    from toolpace.planning.optimal.planner import Optimal
    from toolpace.planning.second_order.planner import SecondOrder

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

        law, points = fastest_law(run, limits, self.mesh, start, end, self.guard, workers, progress, ROUNDS)
        return PlannedRun(law, points)
