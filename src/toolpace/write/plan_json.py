"""plan.json: the figures of a plan that other programs read."""

from __future__ import annotations

import math
import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

import msgspec

from toolpace import __version__
from toolpace.errors import UsageError
from toolpace.files import reason, whole_file
from toolpace.setpoints import SetPoints

if TYPE_CHECKING:
    from toolpace.judge import Verification
    from toolpace.machine.machine import Machine
    from toolpace.toolpath import ToolPath
    from toolpace.trajectory import Trajectory

PLAN = "plan.json"


class UsageRecord(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Peak value over limit; by joint where it is one's own."""

    feed: float
    velocity: dict[str, float]
    acceleration: dict[str, float]
    jerk: dict[str, float | None]
    """Null where the acceleration jumps (planner `second-order`): no number bounds the jerk."""

    @property
    def worst(self) -> float:
        """The largest of all."""
        jerk = (math.inf if value is None else value for value in self.jerk.values())
        return max(self.feed, *self.velocity.values(), *self.acceleration.values(), *jerk)


class OpenPlaceRecord(msgspec.Struct, frozen=True):
    """A stretch of the motion where at most so much could be gained."""

    from_s: float
    to_s: float
    gain_s: float
    block: int


class PlanRecord(msgspec.Struct, frozen=True, kw_only=True):
    """plan.json, key by key. What is not known is null. Keys may be added, never changed or taken away."""

    duration_s: float
    lower_bound_s: float | None
    """No motion within the limits is shorter."""
    gap: float | None
    """duration / lower bound - 1."""
    solve_s: float
    fit_s: float
    mesh_points: int
    blocks: int
    stops: int
    """Times at rest on the way, both ends left out."""
    usage: UsageRecord
    limited_by: dict[str, float]
    """Share of the duration in which each limit binds."""
    tip_deviation_mm: float | None
    axis_deviation_deg: float | None
    machine: str
    program: str
    toolpace_version: str
    # What `toolpace verify` needs to judge again, beyond the contract's own keys.
    planner: str = "optimal"
    dt_s: float = 1e-3
    set_points: int = 0
    path_length_mm: float | None = None
    tip_tolerance_mm: float | None = None
    axis_tolerance_deg: float | None = None
    feed: str | None = None
    """What replaced the program's feeds: "800 mm/min", "120%", "none"; null where they hold."""
    program_file: str = ""
    """The copy of the program beside this file."""
    verified: bool | None = None
    """Whether the motion passed its verification; null where none was made."""
    dialect: str | None = None
    """The dialect that was named for the program; null where its name and content told."""
    continuous_bound_s: float | None = None
    """No motion that keeps the limits all along the path, on no mesh, is shorter; null where it was not asked for."""
    open_places: list[OpenPlaceRecord] = []
    """Where most of the gap lies, in the order of time."""
    step_s: dict[str, float] = {}
    """Time of each step of the job: reading, fitting, planning, ..."""

    def facts(self) -> dict[str, Any]:
        """All of it as plain values."""
        facts: dict[str, Any] = msgspec.to_builtins(self)
        return facts


def plan_record(
    trajectory: Trajectory,
    path: Any,
    toolpath: ToolPath | None,
    machine: Machine,
    setpoints: SetPoints,
    verification: Verification | None = None,
    *,
    program: str = "",
    program_file: str = "",
    feed: str | None = None,
    tip_tolerance: float | None = None,
    axis_tolerance: float | None = None,
    dialect: str | None = None,
    step_s: dict[str, float] | None = None,
) -> PlanRecord:
    """The record of a plan. Deviations are the larger of what the fit (`path`) and the judge measured."""
    usage = trajectory.usage()
    bounded = {joint: value if math.isfinite(value) else None for joint, value in usage.jerk.items()}
    bound = float(trajectory.lower_bound)
    known = math.isfinite(bound) and bound > 0.0
    # Lines that only switch modes count as blocks read, but the report speaks of blocks that move.
    blocks = (toolpath.blocks or len(set(toolpath.block.tolist()))) if toolpath is not None else 0
    return PlanRecord(
        duration_s=float(trajectory.duration),
        lower_bound_s=bound if known else None,
        gap=float(trajectory.duration) / bound - 1.0 if known else None,
        solve_s=float(trajectory.solve_seconds),
        fit_s=float(getattr(path, "fit_seconds", 0.0) or 0.0),
        mesh_points=int(trajectory.mesh_points),
        blocks=int(blocks),
        stops=len(trajectory.laws) - 1,
        usage=UsageRecord(float(usage.feed), usage.velocity, usage.acceleration, bounded),
        limited_by=trajectory.limited_by(),
        tip_deviation_mm=_deviation("tip_deviation", path, verification, 1e3),
        axis_deviation_deg=_deviation("axis_deviation", path, verification, 180.0 / math.pi),
        machine=machine.name,
        program=program or (toolpath.source if toolpath is not None else ""),
        toolpace_version=__version__,
        planner=trajectory.planner,
        dt_s=float(setpoints.t[1] - setpoints.t[0]) if len(setpoints) > 1 else 0.0,
        set_points=len(setpoints),
        path_length_mm=_length(setpoints),
        tip_tolerance_mm=tip_tolerance * 1e3 if tip_tolerance is not None else None,
        axis_tolerance_deg=math.degrees(axis_tolerance) if axis_tolerance is not None else None,
        feed=feed,
        program_file=program_file,
        verified=verification.ok if verification is not None else None,
        dialect=dialect,
        continuous_bound_s=trajectory.continuous_bound or None,
        open_places=[
            OpenPlaceRecord(place.start, place.end, place.seconds, place.block) for place in trajectory.open_places
        ],
        step_s=step_s or {},
    )


def _length(setpoints: SetPoints) -> float | None:
    """Length of the way of the tip [mm]."""
    if not setpoints.has_tool:
        return None
    step = setpoints.tip[1:] - setpoints.tip[:-1]
    return float(((step**2).sum(axis=1) ** 0.5).sum()) * 1e3


def _deviation(name: str, path: Any, verification: Verification | None, scale: float) -> float | None:
    """The largest known deviation of that name; None where none is known."""
    values = [getattr(source, name, math.nan) for source in (path, verification)]
    known = [float(value) * scale for value in values if value is not None and math.isfinite(value)]
    return max(known) if known else None


def write_plan(path: str | os.PathLike[str], record: PlanRecord) -> None:
    """Write plan.json, indented, whole or not at all."""
    with whole_file(path) as temporary:
        temporary.write_bytes(msgspec.json.format(msgspec.json.encode(record), indent=2) + b"\n")


def read_plan(path: str | os.PathLike[str]) -> PlanRecord:
    """Read plan.json, or the one of a folder. Raises UsageError naming the file and the key that is wrong."""
    source = Path(path)
    source = source / PLAN if source.is_dir() else source
    try:
        return msgspec.json.decode(source.read_bytes(), type=PlanRecord)
    except FileNotFoundError:
        raise UsageError(f"{source}: no such file; give the folder that `toolpace plan` wrote") from None
    except OSError as error:
        raise UsageError(f"{source}: cannot read: {reason(error)}") from None
    except (msgspec.DecodeError, UnicodeDecodeError) as error:
        raise UsageError(f"{source}: not a plan: {error}; plan again to write it anew") from None
