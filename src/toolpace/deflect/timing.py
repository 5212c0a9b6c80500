"""How a detour and the rest of its run are timed: by which planner."""

from __future__ import annotations

from collections.abc import Callable

from toolpace.deflect.detour import DetourRun
from toolpace.errors import UsageError
from toolpace.laws.law import TimeLaw
from toolpace.machine.limits import Limits

Timing = Callable[[DetourRun, Limits, TimeLaw], TimeLaw]
"""Takes a detour, the limits and the law under which the detour runs as made; returns the law that it shall have."""
PLANNERS = ("optimal", "genetic", "direct")


def timing_of(planner: str, options: dict[str, object]) -> Timing:
    """What a name and its options ask for. Raises UsageError."""
    if planner not in PLANNERS:
        raise UsageError(f"replan: unknown planner '{planner}'; known are {', '.join(PLANNERS)}")
    if planner == "genetic":
        return genetic_timing(options)
    if planner == "optimal":
        return optimal_timing(options)
    return lambda run, limits, direct: direct


def genetic_timing(options: dict[str, object]) -> Timing:
    from toolpace.deflect.genetic import genetic_law
    from toolpace.planning.genetic.planner import Genetic

    make: Callable[..., Genetic] = Genetic
    planner = make(**options)
    return lambda run, limits, direct: genetic_law(run, limits, direct, planner)


def optimal_timing(options: dict[str, object]) -> Timing:
    from toolpace.deflect.optimal import optimal_law

    law: Callable[..., TimeLaw] = optimal_law
    return lambda run, limits, direct: law(run, limits, direct, **options)
