"""What a job came to and what it was made with: all that the folder of a plan is written from."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from toolpace.errors import printable
from toolpace.operations import operation_times
from toolpace.reading.options import ReadOptions
from toolpace.setpoints import SetPoints
from toolpace.version import __version__
from toolpace.write.bent_tool import bending_record
from toolpace.write.how_read import reading_record
from toolpace.write.plan_json import OpenPlaceRecord, OperationRecord, PlanRecord, RoundRecord, UsageRecord

if TYPE_CHECKING:
    from toolpace.bending.aim_off import AimedOff
    from toolpace.judge import Verification
    from toolpace.machine.machine import Machine
    from toolpace.planning.program_plan import Round
    from toolpace.toolpath import ToolPath
    from toolpace.trajectory import Trajectory


NEARLY = 0.9
"""Share of a tolerance from which it counts as used."""
_SUFFIX = re.compile(r"\.[A-Za-z0-9]{1,16}")


class Fitted(Protocol):
    """What is told of a path that was fitted to a program, as a Path tells it."""

    @property
    def tip_deviation(self) -> float:
        """[m]"""

    @property
    def axis_deviation(self) -> float:
        """[rad]"""

    @property
    def fit_seconds(self) -> float:
        """[s]"""


@dataclass(frozen=True, kw_only=True)
class PlanResult:
    """A plan with its set-points and its verification, and what was asked for, so that it can be judged by files alone.

    What there was not is None.
    """

    trajectory: Trajectory
    machine: Machine
    setpoints: SetPoints
    toolpath: ToolPath | None = None
    path: Fitted | None = None
    effort: str = "low"
    """How much was done for a fast path."""
    rounds: Sequence[Round] = ()
    """What came of it."""
    verification: Verification | None = None
    program: Path | None = None
    """The file of the program; a copy of it goes beside the plan."""
    program_bytes: bytes | None = None
    """What was read from it: a file may change meanwhile, a pipe is read but once. None: it is read for the copy."""
    dialect: str | None = None
    """What the program was to be read as, where that was said."""
    feed: str | None = None
    """What replaced the feeds of the program."""
    options: ReadOptions = field(default_factory=ReadOptions)
    """How the program was read, beside these two."""
    tip_tolerance: float | None = None
    """[m]"""
    axis_tolerance: float | None = None
    """[rad]"""
    aimed: AimedOff | None = None
    """Where the path is aimed off by what the tool bends: by what, and for which tool."""
    step_s: Mapping[str, float] = field(default_factory=dict)
    """Times of the steps so far [s]."""

    @property
    def program_copy(self) -> str:
        """Name of the copy of the program; empty where there is none."""
        return copy_name(self.program) if self.program is not None else ""

    def record(self) -> PlanRecord:
        """The figures of plan.json. Deviations are what the judge measured, without one what the fit did."""
        trajectory, toolpath, verification = self.trajectory, self.toolpath, self.verification
        usage = trajectory.usage()
        jerk = {joint: value if math.isfinite(value) else None for joint, value in usage.jerk.items()}
        bound = float(trajectory.lower_bound)
        known = math.isfinite(bound) and bound > 0.0
        # Lines that only switch modes count as blocks read, but the report speaks of blocks that move.
        blocks = (toolpath.blocks or len(set(toolpath.block.tolist()))) if toolpath is not None else 0
        source = toolpath.source if toolpath is not None else ""
        times = operation_times(trajectory, toolpath) if toolpath is not None else []
        measured = [found for found in (verification, self.path) if found is not None][:1]
        t = self.setpoints.t
        return PlanRecord(
            duration_s=float(trajectory.duration),
            lower_bound_s=bound if known else None,
            gap=float(trajectory.duration) / bound - 1.0 if known else None,
            solve_s=float(trajectory.solve_seconds),
            fit_s=float(self.path.fit_seconds) if self.path is not None else 0.0,
            mesh_points=int(trajectory.mesh_points),
            blocks=int(blocks),
            stops=len(trajectory.laws) - 1,
            usage=UsageRecord(float(usage.feed), usage.velocity, usage.acceleration, jerk),
            limited_by=trajectory.limited_by(),
            tip_deviation_mm=largest_known([source.tip_deviation for source in measured], 1e3),
            axis_deviation_deg=largest_known([source.axis_deviation for source in measured], 180.0 / math.pi),
            machine=printable(self.machine.name),
            program=printable((self.program.name if self.program is not None else "") or source),
            toolpace_version=__version__,
            planner=trajectory.planner,
            dt_s=float(t[1] - t[0]) if len(t) > 1 else 0.0,
            set_points=len(self.setpoints),
            path_length_mm=tip_length(self.setpoints),
            tip_tolerance_mm=self.tip_tolerance * 1e3 if self.tip_tolerance is not None else None,
            axis_tolerance_deg=math.degrees(self.axis_tolerance) if self.axis_tolerance is not None else None,
            feed=self.feed,
            program_file=self.program_copy,
            verified=verification.ok if verification is not None else None,
            dialect=self.dialect,
            continuous_bound_s=trajectory.continuous_bound or None,
            lower_bound_of="this mesh" if known else None,
            open_places=[
                OpenPlaceRecord(place.start, place.end, place.seconds, place.block) for place in trajectory.open_places
            ],
            bending=bending_record(self.aimed) if self.aimed is not None else None,
            effort=self.effort,
            rounds=[
                RoundRecord(each.duration, each.power, each.kept, math.degrees(each.axis_tolerance))
                for each in self.rounds
            ],
            tip_at_tolerance=share_at_tolerance(trajectory, 0, self.tip_tolerance),
            axis_at_tolerance=share_at_tolerance(trajectory, 1, self.axis_tolerance),
            step_s=dict(self.step_s),
            controller=printable(toolpath.controller) if toolpath is not None else "",
            assumed=[printable(sentence) for sentence in toolpath.assumed] if toolpath is not None else [],
            skipped=(
                {printable(word): count for word, count in toolpath.skipped.items()} if toolpath is not None else {}
            ),
            reading=reading_record(self.options),
            operations=[
                OperationRecord(
                    printable(each.name),
                    printable(each.tool),
                    each.time,
                    each.cutting,
                    each.rapid,
                    each.dwell,
                    each.stops,
                )
                for each in times
            ],
            cutting_s=sum(each.cutting for each in times) if times else None,
            rapid_s=sum(each.rapid for each in times) if times else None,
            dwell_s=sum(each.dwell for each in times) if times else None,
        )


def share_at_tolerance(trajectory: Trajectory, which: int, tolerance: float | None) -> float | None:
    """Share of the path's length where the tip (0) or the axis (1) is off by nearly its tolerance; None: not known."""
    found = [run.deviations() for run in trajectory.axis_path.runs]
    known = [each for each in found if each is not None]
    if tolerance is None or len(known) < len(found):
        return None
    length = sum(float(breaks[-1] - breaks[0]) for breaks, _, _ in known)
    near = sum(float((breaks[1:] - breaks[:-1])[off[which] > NEARLY * tolerance].sum()) for breaks, *off in known)
    return near / length


def copy_name(program: Path) -> str:
    """Name of the copy of a program: the suffix tells its dialect, and is kept where it could."""
    return f"program{program.suffix if _SUFFIX.fullmatch(program.suffix) else ''}"


def largest_known(deviations: Sequence[float], scale: float) -> float | None:
    """The largest known one, times a scale; None where none is known."""
    known = [float(value) * scale for value in deviations if math.isfinite(value)]
    return max(known) if known else None


def tip_length(setpoints: SetPoints) -> float | None:
    """Length of the way of the tip [mm]; None where there is no tool."""
    if not setpoints.has_tool:
        return None
    step = setpoints.tip[1:] - setpoints.tip[:-1]
    return float(((step**2).sum(axis=1) ** 0.5).sum()) * 1e3
