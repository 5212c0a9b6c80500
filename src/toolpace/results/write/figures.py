"""The figures of plan.json from a job's result."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING

from toolpace.common.errors import printable
from toolpace.programs.tolerances import Tolerances
from toolpace.results.write.plan_json import OpenPlaceRecord, OperationRecord, RoundRecord, UsageRecord

if TYPE_CHECKING:
    from toolpace.motion.operation_times import OperationTime
    from toolpace.motion.trajectory import Trajectory
    from toolpace.planning.path_and_pace.alternating import Round
    from toolpace.programs.toolpath import ToolPath

NEARLY = 0.9
"""Share of a tolerance from which it counts as used."""


def known_bound(trajectory: Trajectory) -> float | None:
    """What no motion along the path is faster than [s]; None where nothing is known."""
    bound = float(trajectory.lower_bound)
    return bound if math.isfinite(bound) and bound > 0.0 else None


def usage_record(trajectory: Trajectory) -> UsageRecord:
    """What the motion uses of the limits, at most."""
    usage = trajectory.usage()
    jerk = {joint: value if math.isfinite(value) else None for joint, value in usage.jerk.items()}
    return UsageRecord(float(usage.feed), usage.velocity, usage.acceleration, jerk)


def open_place_records(trajectory: Trajectory) -> list[OpenPlaceRecord]:
    """Stretches where at most so much could be gained."""
    return [OpenPlaceRecord(place.start, place.end, place.seconds, place.block) for place in trajectory.open_places]


def round_records(rounds: Sequence[Round]) -> list[RoundRecord]:
    """The duration after each iteration of path and speed."""
    return [RoundRecord(each.duration, each.power, each.kept, math.degrees(each.axis_tolerance)) for each in rounds]


def operation_records(times: Sequence[OperationTime]) -> list[OperationRecord]:
    """How long each operation takes, with names that can be printed."""
    return [
        OperationRecord(
            printable(each.name), printable(each.tool), each.time, each.cutting, each.rapid, each.dwell, each.stops
        )
        for each in times
    ]


def printable_counts(counts: Mapping[str, int]) -> dict[str, int]:
    """Words and how often they stand, with words that can be printed."""
    return {printable(word): count for word, count in counts.items()}


def widest(tolerance: float | Tolerances | None, toolpath: ToolPath | None, part: str) -> float | None:
    """The widest tolerance of the tip [m] or the axis [rad] that holds anywhere; None where none was given."""
    if not isinstance(tolerance, Tolerances):
        return tolerance
    if toolpath is None:
        return tolerance.default
    along = tolerance.tip_along(toolpath) if part == "tip" else tolerance.axis_along(toolpath)
    return float(along.max())


def by_place(tolerance: float | Tolerances | None, quantity: Callable[[float], str]) -> str | None:
    """The text of a tolerance that differs from place to place; None of another."""
    return tolerance.text(quantity) if isinstance(tolerance, Tolerances) and not tolerance.everywhere else None


def share_at_tolerance(trajectory: Trajectory, which: int, tolerance: float | None) -> float | None:
    """Share of the path's length where the tip (0) or the axis (1) is off by nearly its tolerance; None: not known."""
    found = [run.deviations() for run in trajectory.axis_path.runs]
    known = [each for each in found if each is not None]
    if tolerance is None or len(known) < len(found):
        return None
    length = sum(float(breaks[-1] - breaks[0]) for breaks, _, _ in known)
    near = sum(float((breaks[1:] - breaks[:-1])[off[which] > NEARLY * tolerance].sum()) for breaks, *off in known)
    return near / length


def largest_known(deviations: Sequence[float], scale: float) -> float | None:
    """The largest known one, times a scale; None where none is known."""
    known = [float(value) * scale for value in deviations if math.isfinite(value)]
    return max(known) if known else None
