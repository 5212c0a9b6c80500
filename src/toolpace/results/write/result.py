"""A job's result and inputs, from which the folder of a plan is written; and how its program was read, beside it."""

from __future__ import annotations

import hashlib
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Protocol
from zipfile import BadZipFile

import numpy as np

from toolpace.common import __version__
from toolpace.common.errors import UsageError, printable
from toolpace.cutting.tool_file import tool_bytes, tool_of_bytes
from toolpace.machine.cutting_tool import CuttingTool, EngagedDeflection
from toolpace.motion.sampling import each_block
from toolpace.motion.set_point_files import CompactWriter
from toolpace.motion.setpoints import Block, SetPointSource
from toolpace.motion.trajectory import operation_times
from toolpace.programs.reading.controllers.controller import Controller
from toolpace.programs.reading.coordinates.setup import SetUp
from toolpace.programs.reading.options import ReadOptions
from toolpace.programs.reading.setup_file import load_setup, setup_text
from toolpace.programs.tolerances import Tolerances
from toolpace.results.write.cut_limits import CutLimitsRecord
from toolpace.results.write.plan_json import (
    PLAN,
    BendingRecord,
    PlanRecord,
    ReadingRecord,
    by_place,
    cut_sums,
    finite_bound,
    iteration_records,
    largest_finite,
    open_place_records,
    operation_records,
    printable_counts,
    share_at_tolerance,
    usage_record,
    widest,
)

if TYPE_CHECKING:
    from toolpace.cutting.compensated_program import BendingCompensation
    from toolpace.cutting.simulation.simulate import CutSimulation
    from toolpace.judge import Verification
    from toolpace.machine.machine import Machine
    from toolpace.motion.trajectory import Trajectory
    from toolpace.planning.path_and_pace.alternating import Round
    from toolpace.programs.toolpath import ToolPath
    from toolpace.results.report.charts import Curves

_SUFFIX = re.compile(r"\.[A-Za-z0-9]{1,16}")
TOOL = "tool.toml"
"""Its name beside plan.json."""
ENGAGED = "engaged.npz"
"""The name of its deflection by what is cut of a stock."""
CONTROLLER = "controller.toml"
SETUP = "setup.toml"
"""Names of the files beside plan.json."""


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


class SetPointDigest:
    """What the folder of a plan holds of its set-points: the way of the tip, and where they are wanted the packed
    set-points and the curves of the report.

    Takes the set-points block by block, in any order and in any thread.
    """

    def __init__(self, packed: CompactWriter | None = None, curves: Curves | None = None) -> None:
        self.packed, self.curves = packed, curves
        self._lengths: dict[int, float] = {}

    @classmethod
    def of(
        cls, source: SetPointSource, packed: CompactWriter | None = None, curves: Curves | None = None
    ) -> SetPointDigest:
        """That of all set-points."""
        digest = cls(packed, curves)
        each_block(source, (digest.take,))
        return digest

    def take(self, block: Block) -> None:
        """Look at a block."""
        self._lengths[block.begin] = block.length
        for each in (self.packed, self.curves):
            if each is not None:
                each.take(block)

    @property
    def length(self) -> float:
        """Of the way of the tip [m]."""
        return sum(self._lengths[begin] for begin in sorted(self._lengths))


@dataclass(frozen=True, kw_only=True)
class PlanResult:
    """A plan with its set-points and its verification, and what was asked for, so that it can be judged by files alone.

    What there was not is None.
    """

    trajectory: Trajectory
    machine: Machine
    setpoints: SetPointSource
    digest: SetPointDigest | None = None
    """What the folder holds of the set-points, where these have been gone through already."""
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
    tip_tolerance: float | Tolerances | None = None
    """[m]"""
    axis_tolerance: float | Tolerances | None = None
    """[rad]"""
    aimed: BendingCompensation | None = None
    """Where the bending of the tool is compensated: by what, and for which tool."""
    prices: Mapping[str, float] = field(default_factory=dict)
    """What one percent more of each limit would gain [s], as `Trajectory.prices` tells it; empty where not asked."""
    cut: CutSimulation | None = None
    """What it cuts, where the set-up sheet names a stock."""
    cut_limits: tuple[CutLimitsRecord, bytes] | None = None
    """Where the cut held the speed: what plan.json says of it, and the bytes of its file."""
    step_s: Mapping[str, float] = field(default_factory=dict)
    """Times of the steps so far [s]."""

    @property
    def program_copy(self) -> str:
        """Name of the copy of the program; empty where there is none."""
        return copy_name(self.program) if self.program is not None else ""

    def record(self) -> PlanRecord:
        """The figures of plan.json. Deviations are what the judge measured, without one what the fit did."""
        trajectory, toolpath, verification = self.trajectory, self.toolpath, self.verification
        bound = finite_bound(trajectory)
        # Lines that only switch modes count as blocks read, but the report speaks of blocks that move.
        blocks = (toolpath.blocks or len(set(toolpath.block.tolist()))) if toolpath is not None else 0
        source = toolpath.source if toolpath is not None else ""
        times = operation_times(trajectory, toolpath) if toolpath is not None else []
        tip = widest(self.tip_tolerance, toolpath, "tip")
        axis = widest(self.axis_tolerance, toolpath, "axis")
        measured = [found for found in (verification, self.path) if found is not None][:1]
        count, digest = len(self.setpoints), self.digest
        t = self.setpoints.times(np.arange(min(count, 2)))
        length = digest.length if digest is not None else SetPointDigest.of(self.setpoints).length
        return PlanRecord(
            duration_s=float(trajectory.duration),
            lower_bound_s=bound,
            gap=None if bound is None else float(trajectory.duration) / bound - 1.0,
            solve_s=float(trajectory.solve_seconds),
            fit_s=float(self.path.fit_seconds) if self.path is not None else 0.0,
            mesh_points=int(trajectory.mesh_points),
            blocks=int(blocks),
            stops=len(trajectory.laws) - 1,
            usage=usage_record(trajectory),
            limited_by=trajectory.limited_by(),
            prices_s=dict(self.prices),
            tip_deviation_mm=largest_finite([source.tip_deviation for source in measured], 1e3),
            axis_deviation_deg=largest_finite([source.axis_deviation for source in measured], 180.0 / math.pi),
            machine=printable(self.machine.name),
            program=printable((self.program.name if self.program is not None else "") or source),
            toolpace_version=__version__,
            planner=trajectory.planner,
            dt_s=float(t[1] - t[0]) if len(t) > 1 else 0.0,
            set_points=len(self.setpoints),
            path_length_mm=length * 1e3 if self.setpoints.has_tool else None,
            tip_tolerance_mm=tip * 1e3 if tip is not None else None,
            axis_tolerance_deg=math.degrees(axis) if axis is not None else None,
            tip_tolerances=by_place(self.tip_tolerance, lambda value: f"{value * 1e6:.12g}um"),
            axis_tolerances=by_place(self.axis_tolerance, lambda value: f"{math.degrees(value):.12g}deg"),
            feed=self.feed,
            program_file=self.program_copy,
            verified=verification.ok if verification is not None else None,
            dialect=self.dialect,
            continuous_bound_s=trajectory.continuous_bound or None,
            lower_bound_of=None if bound is None else "this mesh",
            open_places=open_place_records(trajectory),
            bending=bending_record(self.aimed) if self.aimed is not None else None,
            effort=self.effort,
            rounds=iteration_records(self.rounds),
            tip_at_tolerance=share_at_tolerance(trajectory, 0, tip),
            axis_at_tolerance=share_at_tolerance(trajectory, 1, axis),
            cut=None if self.cut is None else cut_sums(self.cut),
            cut_limits=None if self.cut_limits is None else self.cut_limits[0],
            step_s=dict(self.step_s),
            controller=printable(toolpath.controller) if toolpath is not None else "",
            assumed=[printable(sentence) for sentence in toolpath.assumed] if toolpath is not None else [],
            skipped=printable_counts(toolpath.skipped) if toolpath is not None else {},
            reading=reading_record(self.options),
            operations=operation_records(times),
            cutting_s=sum(each.cutting for each in times) if times else None,
            rapid_s=sum(each.rapid for each in times) if times else None,
            dwell_s=sum(each.dwell for each in times) if times else None,
        )


def copy_name(program: Path) -> str:
    """Name of the copy of a program: the suffix tells its dialect, and is kept where it could."""
    return f"program{program.suffix if _SUFFIX.fullmatch(program.suffix) else ''}"


def bending_record(aimed: BendingCompensation) -> BendingRecord:
    """What plan.json says of it."""
    sha256 = hashlib.sha256(aimed.tool.data).hexdigest()
    engaged = ENGAGED if aimed.tool.engaged is not None else ""
    return BendingRecord(TOOL, sha256, 1e3 * aimed.largest, 1e6 * aimed.change, aimed.rounds, engaged)


def bent_tool(folder: Path, record: BendingRecord | None) -> CuttingTool | None:
    """The tool of a plan, from the file in its folder; None where none bends.

    Raises UsageError where plan.json and the file differ.
    """
    file = folder / TOOL
    there = file.exists()
    if record is None and not there:
        return None
    if record is None or record.tool_file != TOOL or not there:
        said = "nothing of a tool that bends" if record is None else f"tool_file {record.tool_file!r:.80}"
        raise UsageError(
            f"{folder / PLAN}: says {said}, and {TOOL} is {'' if there else 'not '}there; plan again to write it anew"
        )
    data = tool_bytes(file)
    if hashlib.sha256(data).hexdigest() != record.sha256:
        raise UsageError(f"{file}: is not the tool file that the plan was made with (sha256); plan again")
    tool = tool_of_bytes(data, str(file))
    if (ENGAGED if tool.from_stock else "") != record.engaged_file:
        raise UsageError(f"{folder / PLAN}: engaged_file is {record.engaged_file!r:.80}; plan again to write it anew")
    return tool if not tool.from_stock else replace(tool, engaged=read_engaged(folder / ENGAGED))


def write_engaged(file: Path, engaged: EngagedDeflection) -> None:
    """Write the deflection along a program."""
    np.savez_compressed(file, way=engaged.way, slope=engaged.slope, constant=engaged.constant)


def read_engaged(file: Path) -> EngagedDeflection:
    """The deflection along a program. Raises UsageError where the file is none."""
    try:
        with np.load(file, allow_pickle=False) as arrays:
            return EngagedDeflection(arrays["way"], arrays["slope"], arrays["constant"])
    except (OSError, ValueError, KeyError, EOFError, BadZipFile) as error:
        raise UsageError(f"{file}: cannot be read: {error}; plan again to write it anew") from None


def reading_record(options: ReadOptions) -> ReadingRecord:
    """What plan.json says of the options."""
    return ReadingRecord(
        controller_file=CONTROLLER if options.controller is not None else "",
        setup_file=SETUP if has_setup(options.setup) else "",
        skip_unknown=options.skip_unknown,
        lenient=options.lenient,
        compensation=options.compensation,
        max_blocks=options.most_blocks,
        columns=options.columns,
        units=options.units,
        others=tuple(other.name for other in options.others),
    )


def has_setup(setup: SetUp) -> bool:
    """Whether a sheet says anything."""
    return replace(setup, source="") != SetUp()


def write_reading_options(folder: Path, options: ReadOptions) -> None:
    """Put controller and set-up sheet beside the plan, with every figure exact."""
    if options.controller is not None:
        (folder / CONTROLLER).write_text(options.controller.to_toml(), encoding="utf-8")
    if has_setup(options.setup):
        (folder / SETUP).write_text(setup_text(options.setup), encoding="utf-8")


def read_again(folder: Path, record: ReadingRecord) -> ReadOptions:
    """The options from the files of a plan; UsageError where plan.json and the files of the folder differ."""
    for key, said, name in (
        ("controller_file", record.controller_file, CONTROLLER), ("setup_file", record.setup_file, SETUP)
    ):  # fmt: skip
        there = (folder / name).exists()
        if said not in ("", name) or bool(said) != there:
            raise UsageError(
                f"{folder / PLAN}: {key} of reading is {said!r}, and {name} is {'' if there else 'not '}there; "
                "plan again to write it anew"
            )
    options = ReadOptions.of(
        None,
        Controller.load(folder / CONTROLLER) if record.controller_file else None,
        load_setup(folder / SETUP) if record.setup_file else None,
        record.skip_unknown,
        True,
        record.compensation,
        record.max_blocks,
        record.lenient,
        record.columns,
        record.units,
    )
    if unknown := set(record.others) - set(Controller.names()):
        raise UsageError(f"{folder / PLAN}: others of reading names '{min(unknown)[:40]}'; plan again to write it anew")
    return replace(options, others=tuple(map(Controller.load, record.others)))
