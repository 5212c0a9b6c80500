"""plan.json: the figures of a plan for other programs, from a job's result."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec

from toolpace.common.errors import UsageError, in_short, printable
from toolpace.common.files import SEAL, reason, whole_file
from toolpace.common.units import MILLIMETRE
from toolpace.machine.limits import CONTINUOUS, MOTORS
from toolpace.programs.tolerances import Tolerances
from toolpace.results.write.cut_limits import CutLimitsRecord

if TYPE_CHECKING:
    from toolpace.cutting.simulation.simulate import CutSimulation
    from toolpace.motion.trajectory import OperationTime, Trajectory
    from toolpace.planning.path_and_pace.alternating import Round
    from toolpace.programs.toolpath import ToolPath

PLAN = "plan.json"
"""Its name in the folder of a plan."""
LARGEST = 1 << 26
"""Most bytes of it: those of a long program have some thousands."""
NEARLY = 0.9
"""Share of a tolerance from which it counts as used."""
MM3 = MILLIMETRE**3


class UsageRecord(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Peak value over limit; by joint where it is one's own."""

    feed: float
    velocity: dict[str, float]
    acceleration: dict[str, float]
    jerk: dict[str, float | None]
    """Null where the acceleration jumps (planner `second-order`): no number bounds the jerk, so its limit is exceeded.
    0 where the machine has no limit of it."""
    curves: dict[str, float] = {}
    """Of limits that fall with the speed of their joint, by name; above stand shares of their largest values."""
    motor: dict[str, float] = {}
    """Of the torque or force of its motor; only joints whose machine file has a limit of it."""
    continuous: dict[str, float] = {}
    """Of the continuous rating of its motor, the largest root mean square over the thermal window."""

    @property
    def worst(self) -> float:
        """The largest of all."""
        jerk = (math.inf if value is None else value for value in self.jerk.values())
        joints = *self.velocity.values(), *self.acceleration.values(), *jerk
        return max(self.feed, *joints, *self.curves.values(), *self.motor.values(), *self.continuous.values())


class OpenPlaceRecord(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A stretch of the motion where at most so much could be gained."""

    from_s: float
    to_s: float
    gain_s: float
    block: int


class OperationRecord(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """An operation of the program: time_s = cutting_s + rapid_s + dwell_s."""

    name: str
    tool: str
    time_s: float
    cutting_s: float
    rapid_s: float
    dwell_s: float
    stops: int


class ReadingRecord(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """How the program was read."""

    controller_file: str = ""
    """The file of its controller, beside this one; empty where it is for none."""
    setup_file: str = ""
    """The set-up sheet, beside this file; empty where there was none."""
    skip_unknown: bool = False
    lenient: bool = False
    compensation: str = ""
    max_blocks: int | None = None
    """Null where it was not said."""
    columns: str = ""
    units: str = ""
    """Of a table whose header does not tell them; empty where it does."""
    others: tuple[str, ...] = ()
    """Built-in controllers that the program may be for as well; none where its controller was named."""


class IterationRecord(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A path that was fitted on the way, and how fast it may be passed with limits held at the nodes."""

    duration_s: float
    power: float
    """Of the pace in the weight of its roughness; 0 for the first."""
    kept: bool
    """Whether it was the fastest so far."""
    axis_tolerance_deg: float
    """Of the tool axis, that it was fitted within: at most the one asked for."""


class BendingRecord(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The bending for which the path is compensated, so that the bent tool is on the program."""

    tool_file: str
    """The figures of the tool, beside this file."""
    sha256: str
    """Of that file."""
    largest_mm: float
    """Most that the tool bends."""
    change_um: float
    """Largest difference between the bending of this motion and the bending that is compensated."""
    rounds: int
    """How often it was planned with a shift."""
    engaged_file: str = ""
    """The deflection along the program by what is cut of the stock, beside this file; empty where the engagement is
    stated."""


class OperationCutRecord(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Time at feed of an operation by what the tool meets; rapids and dwells are in none of them."""

    name: str
    tool: str
    air_s: float
    """Nothing can be cut, wherever within its uncertainty the stock ends."""
    cutting_s: float
    """Something is cut in any case."""
    uncertain_s: float
    """Either, depending on where the stock ends."""
    removed_mm3: float


class CutRecord(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What the motion cuts of the stock that the set-up sheet names: the sums of `toolpace cut`."""

    air_s: float
    cutting_s: float
    uncertain_s: float
    stock_mm3: float
    removed_mm3: float
    left_mm3: float
    resolution_mm: float
    """Size of a cell of the stock."""
    uncertainty_mm: float
    """How far the surface of the stock may be from where the sheet has it."""
    collisions: int
    """How many `toolpace cut` lists."""
    operations: list[OperationCutRecord]
    """Those that move, in the order of the program."""


class PlanRecord(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """plan.json, key by key. What is not known is null. Keys may be added, never changed or taken away.

    A key that is not known here is refused: it could not be judged. Each key is listed in judge/figures.py.
    """

    duration_s: float
    lower_bound_s: float | None
    """No plan on this mesh is shorter."""
    gap: float | None
    """duration / lower bound - 1: how far from the best on this mesh."""
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
    """Where it differs from place to place, the widest that holds anywhere."""
    axis_tolerance_deg: float | None = None
    """The same."""
    tip_tolerances: str | None = None
    """Where they differ: the default and those of places, "20um,finish:5um"; null where one holds everywhere."""
    axis_tolerances: str | None = None
    """The same of the tool axis: "0.2deg,finish:0.05deg"."""
    feed: str | None = None
    """What replaced the program's feeds: "800 mm/min", "120%", "none"; null where they hold."""
    program_file: str = ""
    """The copy of the program beside this file."""
    verified: bool | None = None
    """Whether the motion passed its verification; null where none was made."""
    dialect: str | None = None
    """The dialect that was named for the program; null where its name and content told."""
    continuous_bound_s: float | None = None
    """No motion that keeps the limits all along the path is shorter, on no mesh; null where it is not known."""
    lower_bound_of: str | None = None
    """What lower_bound_s and gap are of: "this mesh"; null where there is no bound."""
    open_places: list[OpenPlaceRecord] = []
    """Where most of the gap lies, in the order of time."""
    controller: str = ""
    """What the program was read for; empty where it is for no controller."""
    assumed: list[str] = []
    """What the program leaves open and was taken for granted, a sentence each."""
    skipped: dict[str, int] = {}
    """Words without meaning for motion, and how often they stand in the program."""
    reading: ReadingRecord = msgspec.field(default_factory=ReadingRecord)
    """How the program was read, beside `dialect` and `feed`."""
    operations: list[OperationRecord] = []
    """The operations of the program with their tools, in its order; empty where there is no program."""
    cutting_s: float | None = None
    rapid_s: float | None = None
    dwell_s: float | None = None
    """Their sums."""
    bending: BendingRecord | None = None
    """The bending that is compensated; null where the tool is taken for stiff."""
    effort: str = "low"
    """How much was done for a path that may be passed fast: low, normal or high."""
    rounds: list[IterationRecord] = []
    """The first path and each fitted for the pace of those before it; empty where it was fitted once."""
    tip_at_tolerance: float | None = None
    """Share of the path's length where the tip is off by more than 90 % of its tolerance."""
    axis_at_tolerance: float | None = None
    """The same of the tool axis."""
    prices_s: dict[str, float] = {}
    """What one percent more of each limit would gain, by the names of `limited_by`; empty where not asked for."""
    cut: CutRecord | None = None
    """What it cuts, where the set-up sheet names a stock and its tools; else null."""
    cut_limits: CutLimitsRecord | None = None
    """By what the cut held the speed; null where the program's feeds did."""
    step_s: dict[str, float] = {}
    """Time of each step of the job: reading, fitting, planning, ...; of writing, the time until this file, the last."""


def write_plan(path: str | os.PathLike[str], record: PlanRecord) -> None:
    """Write plan.json, indented, whole or not at all."""
    with whole_file(path) as temporary:
        temporary.write_bytes(msgspec.json.format(msgspec.json.encode(record), indent=2) + b"\n")


def read_plan(path: str | os.PathLike[str]) -> PlanRecord:
    """Read plan.json, or the one of a folder. Raises UsageError naming the file and the key that is wrong."""
    source = Path(path)
    source = source / PLAN if source.is_dir() else source
    try:
        with source.open("rb") as stream:
            data = stream.read(LARGEST + 1)
        if len(data) > LARGEST:
            raise UsageError(f"{source}: not a plan: more than {LARGEST >> 20} MB; plan again, into a new folder")
        said = msgspec.json.decode(data)
        if isinstance(said, dict):
            said.pop(SEAL, None)  # of the folder, not of the plan
        return msgspec.convert(said, type=PlanRecord)
    except FileNotFoundError:
        raise UsageError(f"{source}: no such file; give the folder that `toolpace plan` wrote") from None
    except OSError as error:
        raise UsageError(f"{source}: cannot read: {reason(error)}") from None
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
        raise UsageError(f"{source}: not a plan: {in_short(error)}; plan again, into a new folder") from None


def finite_bound(trajectory: Trajectory) -> float | None:
    """What no motion along the path is faster than [s]; None where nothing is known."""
    bound = float(trajectory.lower_bound)
    return bound if math.isfinite(bound) and bound > 0.0 else None


def usage_record(trajectory: Trajectory) -> UsageRecord:
    """What the motion uses of the limits, at most."""
    usage = trajectory.usage()
    jerk = {joint: value if math.isfinite(value) else None for joint, value in usage.jerk.items()}
    curves = {each.name for each in trajectory.limits.constants.curves}
    of_curves = {name: value for name, value in usage.rows.items() if name in curves}
    names = {f"{kind} {joint}": joint for joint in trajectory.joints for kind in MOTORS}
    motor = {names[name]: value for name, value in usage.rows.items() if name in names}
    rated = {CONTINUOUS + name: joint for name, joint in names.items()}
    continuous = {rated[name]: value for name, value in usage.rows.items() if name in rated}
    return UsageRecord(float(usage.feed), usage.velocity, usage.acceleration, jerk, of_curves, motor, continuous)


def open_place_records(trajectory: Trajectory) -> list[OpenPlaceRecord]:
    """Stretches where at most so much could be gained."""
    return [OpenPlaceRecord(place.start, place.end, place.seconds, place.block) for place in trajectory.open_places]


def iteration_records(rounds: Sequence[Round]) -> list[IterationRecord]:
    """The duration after each iteration of path and speed."""
    return [IterationRecord(each.duration, each.power, each.kept, math.degrees(each.axis_tolerance)) for each in rounds]


def operation_records(times: Sequence[OperationTime]) -> list[OperationRecord]:
    """How long each operation takes, with names that can be printed."""
    return [
        OperationRecord(
            printable(each.name), printable(each.tool), each.time, each.cutting, each.rapid, each.dwell, each.stops
        )
        for each in times
    ]


def cut_sums(simulation: CutSimulation) -> CutRecord:
    """The sums of a simulated cut, in s and mm."""
    operations = [
        OperationCutRecord(
            printable(each.name), printable(each.tool), each.air, each.cutting, each.uncertain, each.removed / MM3
        )
        for each in simulation.operations
    ]
    return CutRecord(
        air_s=simulation.air,
        cutting_s=simulation.cutting,
        uncertain_s=float(sum(each.uncertain for each in simulation.operations)),
        stock_mm3=simulation.stock_volume / MM3,
        removed_mm3=simulation.removed_volume / MM3,
        left_mm3=simulation.left_volume / MM3,
        resolution_mm=simulation.resolution / MILLIMETRE,
        uncertainty_mm=simulation.uncertainty / MILLIMETRE,
        collisions=len(simulation.collisions),
        operations=operations,
    )


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
    measured = [each for each in found if each is not None]
    if tolerance is None or len(measured) < len(found):
        return None
    length = sum(float(breaks[-1] - breaks[0]) for breaks, _, _ in measured)
    near = sum(float((breaks[1:] - breaks[:-1])[off[which] > NEARLY * tolerance].sum()) for breaks, *off in measured)
    return near / length


def largest_finite(deviations: Sequence[float], scale: float) -> float | None:
    """The largest known one, times a scale; None where none is known."""
    measured = [float(value) * scale for value in deviations if math.isfinite(value)]
    return max(measured) if measured else None
