"""Periods of rows and cycles of a control's tasks."""

from __future__ import annotations

import math

from toolpace.common.errors import UsageError
from toolpace.common.units import format_time

CYCLES = (1e-6, 1.0)
"""Between which the cycles of controls lie [s]: the fastest current loops take some 10 us, and what is told where to be
less than once a second is not led along a path."""


def refuse_no_cycle(option: str, value: float | None) -> None:
    """Raise UsageError, named by the option, where a time that is given is no cycle of a control."""
    if value is None:
        return
    if not (isinstance(value, int | float) and CYCLES[0] <= value <= CYCLES[1]):
        raise UsageError(
            f"{option} {_shown(value)}: give a time from {format_time(CYCLES[0])} to {format_time(CYCLES[1])}; no "
            "control takes positions more often, or follows a path by fewer"
        )


def _shown(value: object) -> str:
    if not isinstance(value, int | float):
        return repr(value)[:40]
    ordinary = math.isfinite(value) and 1e-4 <= abs(value) < 1e6
    return format_time(value) if ordinary else f"{value:.6g} s"
