"""Where the tool shall be back on its path."""

from __future__ import annotations

from toolpace.common.arrays import Floats, number
from toolpace.common.errors import UsageError
from toolpace.deflection.replanning.commanded import CommandedMotion
from toolpace.deflection.replanning.compensation import CompensatedRun
from toolpace.deflection.replanning.projection import project
from toolpace.path.axispath.follow import FollowRun
from toolpace.path.path import Path


def rejoin_time(
    commanded: CommandedMotion,
    tip: Floats,
    rejoin: str | float,
    interval: tuple[float, float] | None,
) -> float | None:
    """When the commanded law passes the wanted point of rejoining [s]; None where it is free.

    `rejoin` is "fastest" (free), "projection" (of the `tip` (3,) [m] on the run, or on the `interval` of it) or a
    parameter of the run.
    """
    if interval is not None and rejoin != "projection":
        raise UsageError("replan: an interval is for a projection on it; give rejoin='projection', or leave it out")
    run = commanded.run
    on_path = run.base if isinstance(run, CompensatedRun) else run
    if rejoin == "fastest":
        return None
    if isinstance(rejoin, str):
        if rejoin != "projection":
            raise UsageError(f"replan: rejoin at '{rejoin}'; give 'fastest', 'projection' or a parameter")
        if not isinstance(on_path, FollowRun):
            raise UsageError("replan: a projection needs a path of tip and axis; give the parameter to rejoin at")
        s = project(Path((on_path.run,)), tip, interval=interval).s
    else:
        s = number(rejoin, "replan: rejoin")
        if not run.s0 <= s <= run.s1:
            raise UsageError(f"replan: rejoin at s = {s:g}; the run goes from {run.s0:g} to {run.s1:g}")
    return commanded.law.passing_time(s)
