"""A job of a batch: program, machine and kind of work; its inputs read, with a key of them; and the row of results."""

from __future__ import annotations

import hashlib
import json
import math
import os
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import msgspec

from toolpace.common import __version__
from toolpace.common.errors import UsageError, did_you_mean, printable
from toolpace.common.units import (
    DEGREE,
    LONGEST_TOOL,
    METRES,
    MILLIMETRE,
    format_angle,
    format_length,
    format_time,
    refuse_other_unit,
)
from toolpace.jobs.job import AXIS_TOLERANCES, TIME_STEPS, TIP_TOLERANCES
from toolpace.machine.cutting_tool import CuttingTool
from toolpace.machine.machine import Machine
from toolpace.programs.reading.controllers.controller import Controller
from toolpace.programs.reading.coordinates.setup import SetUp
from toolpace.programs.reading.options import ReadOptions
from toolpace.programs.reading.setup_file import load_setup, setup_text
from toolpace.programs.reading.source import Source
from toolpace.programs.tolerances import Tolerances

KINDS = ("plan", "time", "inspect", "export")
"""What can be done with a program."""
WAITING, ERROR = "not run", "error"
GOOD = ("verified", "timed", "read")
BAD = ("failed",)
"""What a verdict may be; BAD: the motion broke something, and is written all the same."""
DIGITS = 10
"""Of the key, in the name of a folder."""
LONGEST_STEM = 60
"""Characters of a program's name in that of a folder."""
USUAL_TIP, USUAL_AXIS = 0.01 * MILLIMETRE, 0.05 * DEGREE
"""Tolerances of a plan where none are named [m], [rad]; less where the program asks for less."""


@dataclass(frozen=True, kw_only=True)
class BatchJob:
    """All that is asked of one job, in SI; files are named, and read when the batch begins. Raises UsageError."""

    program: str | os.PathLike[str]
    machine: str | os.PathLike[str] | Machine | None = None
    """A name, a machine file or a Machine; may be left out of `inspect` only: all built-in ones are tried then."""
    what: str = "plan"
    """plan; time: on its control, and the optimum; inspect: what it asks for; export: plan, and files for a control."""
    tip_tolerance: float | None = None
    """[m]. None: that of the program, else of its control, for `time`; for all else 0.01 mm, or less where the program
    asks for less."""
    axis_tolerance: float | None = None
    """[rad]. None: as of the tip, and 0.05 deg."""
    planner: str = "optimal"
    effort: str = "normal"
    """How much is done for a path that may be passed fast: low, normal or high."""
    prove_within: float | None = None
    """Time for raising the lower bound [s]; None: it stays as it is found with the plan."""
    feed: str | None = None
    """In place of the program's feeds: "120%", "3000mm/min", "none"."""
    tool_length: float | None = None
    """In place of the machine file's [m]."""
    bend: str | None = None
    """The file of a tool that bends."""
    dt: float = 1e-3
    """Time between set-points [s]."""
    csv: bool = False
    npz: str | bool = "auto"
    """How set-points are written: full, compact, auto or no; True is full, and False is no."""
    report: bool = True
    """Which other files are written beside plan.json."""
    dialect: str | None = None
    controller: str | None = None
    setup: str | None = None
    skip_unknown: bool = False
    lenient: bool = False
    compensation: str = ""
    max_blocks: int | None = None
    columns: str = ""
    units: str = ""
    """How the program is read: as the options of the commands."""
    model: str | None = None
    """Of `time`: how the control is thought to work, in place of what its file says."""
    optimum: bool = True
    """Of `time`: whether the fastest motion is planned too."""
    to: str | None = None
    """Of `export`: table, linuxcnc-hal, linuxcnc-g93, beckhoff-fifo or program."""
    export: Mapping[str, Any] = field(default_factory=dict)
    """Options of that target, as `tp.export` has them."""

    def __post_init__(self) -> None:
        from toolpace.motion.set_point_files import form_named
        from toolpace.planning.planner import PLANNERS
        from toolpace.planning.program_plan import EFFORTS

        refuse_unknown("what", self.what, KINDS)
        refuse_unknown("planner", self.planner, tuple(PLANNERS))
        refuse_unknown("effort", self.effort, EFFORTS)
        for name, bounds, show in (
            ("tip_tolerance", TIP_TOLERANCES, format_length),
            ("axis_tolerance", AXIS_TOLERANCES, format_angle),
        ):
            if getattr(self, name) is not None:
                refuse_beyond(name, getattr(self, name), bounds, show)
        refuse_beyond("dt", self.dt, TIME_STEPS, format_time)
        if self.tool_length is not None:
            refuse_other_unit(self.tool_length, LONGEST_TOOL, "tool_length", METRES)
        if self.prove_within is not None and not self.prove_within > 0.0:
            raise UsageError(f"prove_within = {self.prove_within!r:.40}: give a time above zero [s]")
        if self.machine is None and self.what != "inspect":
            raise UsageError(f"{self.program}: the machine is missing; name a built-in machine or a machine file")
        if self.prove_within is not None and self.planner != "optimal":
            raise UsageError(f"prove_within goes with the planner 'optimal'; '{self.planner}' has no lower bound")
        if (self.to is None) != (self.what != "export"):
            raise UsageError("what = export goes with `to`, the target, and `to` with it alone")
        object.__setattr__(self, "npz", form_named("npz =", self.npz))
        if self.what == "export" and self.npz == "no":
            raise UsageError("what = export needs set-points: leave npz as it is")
        self._check_words()

    def tolerances(self) -> tuple[float | Tolerances, float | Tolerances]:
        """Of a plan, tip [m] and tool axis [rad]; those not named are tighter where the program asks for that."""
        return (
            self.tip_tolerance or Tolerances(USUAL_TIP, tighter=True),
            self.axis_tolerance or Tolerances(USUAL_AXIS, tighter=True),
        )

    def widest_tolerances(self) -> tuple[float | None, float | None]:
        """Of tip [m] and tool axis [rad]; None of `time` where they are the program's."""
        if self.what == "time":
            return self.tip_tolerance, self.axis_tolerance
        return self.tip_tolerance or USUAL_TIP, self.axis_tolerance or USUAL_AXIS

    def _check_words(self) -> None:
        """Raise UsageError where a feed, a model or a target is none, before any job has begun."""
        if self.feed is not None:
            from toolpace.programs.reading.feeds import FeedChange

            FeedChange.parse(self.feed)
        if self.model is not None:
            from toolpace.controls.timing.figures import MODELS

            refuse_unknown("model", self.model, tuple(MODELS))
        if self.to is not None:
            from toolpace.controls.export import target_of

            target_of(self.to, dict(self.export))


def refuse_unknown(name: str, value: str, choices: tuple[str, ...]) -> None:
    """Raise UsageError where a word is none of these."""
    if value not in choices:
        raise UsageError(f"{name} = {str(value)[:40]!r} is not known; {did_you_mean(str(value), choices)}")


def refuse_beyond(name: str, value: float, bounds: tuple[float, float], show: Callable[[float], str]) -> None:
    """Raise UsageError where a figure is beyond its bounds."""
    if not (isinstance(value, (int, float)) and math.isfinite(value) and bounds[0] <= value <= bounds[1]):
        raise UsageError(f"{name} = {value!r:.40}: give a value from {show(bounds[0])} to {show(bounds[1])}")


class BatchRow(msgspec.Struct, frozen=True, kw_only=True):
    """One job and what came of it; what is not known, or not of this kind of job, is null."""

    program: str
    """As it was named."""
    machine: str
    what: str
    planner: str
    effort: str
    tip_tolerance_mm: float | None
    """Null: that of the program, or of its control."""
    axis_tolerance_deg: float | None
    feed: str | None = None
    verdict: str = WAITING
    """verified or failed (plan, export), timed, read; error; not run."""
    error: str = ""
    """One line."""
    duration_s: float | None = None
    """Of the plan; of `time`, on the control."""
    optimum_s: float | None = None
    """Of `time`: of the fastest motion."""
    air_s: float | None = None
    """Time at feed in which nothing is cut, where the set-up sheet names a stock."""
    material_s: float | None = None
    """Time at feed in which something is."""
    lower_bound_s: float | None = None
    gap: float | None = None
    limited_by: dict[str, float] = {}
    """Share of the duration in which each limit binds."""
    blocks: int | None = None
    folder: str = ""
    """Of its results, in that of the batch; empty where there are none."""
    report: bool = True
    """Whether a report was asked for, of what has one."""
    exported: str = ""
    """Of `export`: the folder of the files, beside it."""
    key: str = ""
    seconds: float = 0.0
    """Time that the job took, where it was done [s]."""
    worker: str = ""
    found: bool = False
    """Whether it was done before, and its folder found."""
    elsewhere: bool = False
    """Whether another worker may fare better: this one could not write."""

    @property
    def ok(self) -> bool:
        """Whether all is well."""
        return self.verdict in GOOD

    @property
    def limit(self) -> str:
        """What binds most, as `limited_by` names it; empty where that is not known."""
        limits = {name: share for name, share in self.limited_by.items() if name not in ("nothing", "dwell")}
        return max(limits, key=lambda name: limits[name]) if limits else ""

    @property
    def exit_code(self) -> int:
        """0: all is well; 1: a verification failed; 2: there is no result."""
        return 0 if self.ok else 1 if self.verdict in BAD else 2


def waiting(job: BatchJob) -> BatchRow:
    """The row of a job that has not begun."""
    machine = job.machine.name if isinstance(job.machine, Machine) else str(job.machine or "")
    tip, axis = job.widest_tolerances()
    return BatchRow(
        program=printable(str(job.program)),
        machine=printable(machine),
        what=job.what,
        planner=job.planner,
        effort=job.effort,
        tip_tolerance_mm=None if tip is None else tip / MILLIMETRE,
        axis_tolerance_deg=None if axis is None else axis / DEGREE,
        feed=job.feed,
        report=job.report or job.what not in ("plan", "export"),
    )


@dataclass(frozen=True)
class Prepared:
    """A job, checked and read."""

    job: BatchJob
    path: str
    """Of the program, from the root: subprograms lie beside it."""
    data: bytes
    """The program."""
    machines: tuple[Machine, ...]
    """The machine, with tool and part as the job has them; several of `inspect` without one."""
    options: ReadOptions
    tool: CuttingTool | None
    key: str
    """Hash of program, machine, options and version."""

    @property
    def machine(self) -> Machine:
        """The one that the job names."""
        return self.machines[0]

    @property
    def folder(self) -> str:
        """Name of the folder of its results: what a person reads, and what tells it from all others."""
        stem = re.sub(r"[^\w.+-]", "_", Path(self.path).stem)[:LONGEST_STEM].lstrip(".") or "program"
        return f"{stem}-{self.key[:DIGITS]}"

    @property
    def source(self) -> Source:
        """The program as text. Raises ProgramError."""
        return Source.from_bytes(self.data, self.path)

    @property
    def lines(self) -> int:
        """As many as blocks, or more."""
        return self.data.count(b"\n") + 1


class Loader:
    """Reads what jobs depend on, each file once."""

    def __init__(self) -> None:
        self._machines: dict[tuple[str, float | None], Machine] = {}
        self._controllers: dict[str, Controller] = {}
        self._setups: dict[str, SetUp] = {}
        self._tools: dict[str, CuttingTool] = {}
        self._texts: dict[int, tuple[Machine, str]] = {}

    def prepare(self, job: BatchJob) -> Prepared:
        """Read what a job depends on. Raises ToolpaceError."""
        source = Source.load(os.fspath(job.program))
        machines = self._on(job)
        options = self._how(job, machines[0] if job.machine is not None else None)
        part = options.setup.part
        machines = tuple(machine.mounted(**part) for machine in machines) if part else machines
        tool = None if job.bend is None else self._tool(job.bend)
        prepared = Prepared(job, str(Path(job.program).absolute()), source.data, machines, options, tool, "")
        return replace(prepared, key=self._key(prepared))

    def _on(self, job: BatchJob) -> tuple[Machine, ...]:
        if isinstance(job.machine, Machine):
            named: tuple[Machine, ...] = (job.machine,)
        elif job.machine is None:
            named = tuple(self._machine(name, None) for name in Machine.names())
        else:
            return (self._machine(os.fspath(job.machine), job.tool_length),)
        return named if job.tool_length is None else tuple(each.with_tool(job.tool_length) for each in named)

    def _machine(self, name: str, tool_length: float | None) -> Machine:
        if (name, tool_length) not in self._machines:
            machine = Machine.load(name)
            self._machines[name, tool_length] = machine if tool_length is None else machine.with_tool(tool_length)
        return self._machines[name, tool_length]

    def _how(self, job: BatchJob, machine: Machine | None) -> ReadOptions:
        if job.controller is not None and job.controller not in self._controllers:
            self._controllers[job.controller] = Controller.load(job.controller)
        if job.setup is not None and job.setup not in self._setups:
            self._setups[job.setup] = load_setup(job.setup)
        controller = None if job.controller is None else self._controllers[job.controller]
        setup = None if job.setup is None else self._setups[job.setup]
        return ReadOptions.of(
            machine, controller, setup, job.skip_unknown, True, job.compensation, job.max_blocks, job.lenient,
            job.columns, job.units,
        )  # fmt: skip

    def _tool(self, name: str) -> CuttingTool:
        if name not in self._tools:
            from toolpace.cutting.tool_file import load_tool

            self._tools[name] = load_tool(name)
        return self._tools[name]

    def _text(self, machine: Machine) -> str:
        if id(machine) not in self._texts:
            self._texts[id(machine)] = machine, machine.to_toml()
        return self._texts[id(machine)][1]

    def _key(self, prepared: Prepared) -> str:
        """Hash of all that a job depends on; two jobs with one key have one result."""
        job, options = prepared.job, prepared.options
        plain = {
            name: value for name, value in vars(job).items() if name not in ("machine", "bend", "setup", "controller")
        }
        parts: dict[str, object] = {
            **plain,
            "version": __version__,
            "program": Path(prepared.path).name,
            "sha256": hashlib.sha256(prepared.data).hexdigest(),
            "machines": [self._text(machine) for machine in prepared.machines],
            "controller": "" if options.controller is None else options.controller.to_toml(),
            "setup": setup_text(options.setup),
            "tool": "" if prepared.tool is None else hashlib.sha256(prepared.tool.data).hexdigest(),
        }
        return hashlib.sha256(json.dumps(parts, sort_keys=True, default=str).encode()).hexdigest()
