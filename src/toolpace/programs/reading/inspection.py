"""The inspection of a program: what it is and needs, with unread words collected, not raised."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from toolpace.common.arrays import Bools, Floats, Ints
from toolpace.common.errors import FeedMissingError, ProgramError, ToolpaceError
from toolpace.programs.reading import read_source
from toolpace.programs.reading.control.state import EndlessError
from toolpace.programs.reading.coordinates.kinematics import Kinematics, Poses
from toolpace.programs.reading.findings import Findings, Refusal, Used
from toolpace.programs.reading.languages import CONTROLS, Recognised, recognised
from toolpace.programs.reading.options import ReadOptions
from toolpace.programs.reading.setup_file import with_cure_of_zero
from toolpace.programs.reading.source import Source
from toolpace.programs.stock_figures import WorkpieceFigures
from toolpace.programs.tool_figures import ToolFigures
from toolpace.programs.toolpath import ToolPath

TURNED = 1e-9
"""Change of a tool axis, or turn of a rotary joint [rad], from which a block turns the tool."""
STAND_IN_FEED = "3000mm/min"
"""With which a program without one is read: nothing that is told here depends on it."""
LONGEST_WORD = 40
"""Most characters of a block that stands for a word."""
Range = tuple[float, float]


class Candidate(Kinematics, Protocol):
    """A machine that a program may run on."""

    def choose_rotary(self, toolpath: ToolPath, /) -> Floats:
        """Rotary positions along a tool path, within travel. Raises ReachError."""


Follow = Callable[[Candidate, ToolPath], object]
"""Raises ToolpaceError where a machine cannot follow a tool path."""


def follow_points(machine: Candidate, toolpath: ToolPath) -> None:
    """The least that can be asked of a machine: that it can be at each point."""
    machine.choose_rotary(toolpath)


@dataclass(frozen=True)
class Inspection:
    """What was found of one program."""

    program: str
    dialect: str = ""
    """Name of its controller, `cldata` or `csv`; empty where that cannot be told."""
    reason: str = ""
    """Why it is taken for that."""
    blocks: int = 0
    """Blocks that are executed; where the program cannot be read whole, its lines that are not blank."""
    five_axis_blocks: int = 0
    """Blocks whose motion turns the tool."""
    arcs: int = 0
    rapids: int = 0
    stops: int = 0
    """Times at rest on the way."""
    dwells: int = 0
    dwell_s: float = 0.0
    tools: tuple[str, ...] = ()
    ignored: dict[str, int] = field(default_factory=dict)
    refused: tuple[Refusal, ...] = ()
    needs: tuple[str, ...] = ()
    """What must be given with the program to plan it, and is no fault of it: a feed; a sentence each."""
    assumed: tuple[str, ...] = ()
    tip: tuple[Range, Range, Range] | None = None
    """Extent of the tip in X, Y, Z of the part [m]."""
    tip_at_feed: tuple[Range, Range, Range] | None = None
    """The same of the moves at feed; None where there are none."""
    tilt: Range | None = None
    """Least and most angle between the tool and Z of the part [rad]."""
    rotary: dict[str, Range] = field(default_factory=dict)
    """Least and most of each rotary joint that the program names [rad]."""
    read_on: str = ""
    """The machine on which it was read for these figures; empty where none was needed."""
    machines: tuple[str, ...] = ()
    """Those that can run it, as far as it is read."""
    not_on: dict[str, str] = field(default_factory=dict)
    """The others, and why not."""
    used: Used = field(default_factory=Used)
    shapes: dict[str, ToolFigures] = field(default_factory=dict)
    """Shapes of tools that the program tells, by number or name."""
    workpiece: WorkpieceFigures = field(default_factory=WorkpieceFigures)
    """What the program tells of the workpiece."""


@dataclass(frozen=True)
class _Request:
    """What was said of the program, and what is asked of machines."""

    dialect: str | None
    feed: str | None
    follow: Follow


@dataclass(frozen=True)
class _Reading:
    """The program as read on one machine."""

    machine: Candidate | None
    findings: Findings
    toolpath: ToolPath | None
    fault: ToolpaceError | None = None
    """Why it cannot be read there, or the machine cannot follow it."""

    @property
    def rank(self) -> tuple[bool, bool, bool, int, bool]:
        """The greater, the more it tells of the program; last, whether X, Y, Z of the machine are those of the part."""
        line = self.fault.line if isinstance(self.fault, ProgramError) else 0
        of_machine = self.machine is not None and f"'{self.machine.name}'" in str(self.fault)
        return self.fault is None, self.toolpath is not None, not of_machine, line, _counts_as_the_part(self.machine)


def unreadable(program: str, error: ToolpaceError) -> Inspection:
    """The inspection of a file that is no program."""
    return Inspection(program, refused=(_refusal(error, program),))


def inspect_source(
    source: Source,
    options: ReadOptions,
    machines: Sequence[Candidate],
    dialect: str | None = None,
    feed: str | None = None,
    follow: Follow = follow_points,
) -> Inspection:
    """Read a program on each of the machines, as far as it goes, and tell what was found.

    follow: how it is tried whether a machine can follow what was read.
    Nothing that a program does wrong is raised: it is in `refused`, with its cure. UsageError is raised where options
    exclude each other.
    """
    try:
        found = recognised(source, dialect, options)
    except ProgramError as error:
        return unreadable(source.name, error)
    options = dataclasses.replace(options, controller=found.controller)
    request = _Request(dialect, feed, follow)
    readings = _readings(source, options, machines, found, request)
    best = max(readings, key=lambda reading: reading.rank)
    needs: tuple[str, ...] = ()
    if isinstance(best.fault, FeedMissingError):
        needs = (f"line {best.fault.line}: {_message(best.fault, source.name)}",)
        request = dataclasses.replace(request, feed=STAND_IN_FEED)
        readings = _readings(source, options, machines, found, request)
        best = max(readings, key=lambda reading: reading.rank)
    if found.others and best.toolpath is not None:
        in_doubt = dataclasses.replace(options, others=found.others, skip_unknown=True)
        best = dataclasses.replace(_read(source, best.machine, request, in_doubt), fault=best.fault)
    runs = tuple(r.machine.name for r in readings if r.machine is not None and r.fault is None)
    name = found.controller.name if found.controller is not None else found.dialect
    refusals = best.findings.refusals_under(options.skip_unknown, options.lenient)
    inspection = Inspection(
        program=source.name,
        dialect=name,
        reason=found.reason,
        blocks=sum(1 for line in source.lines if line.strip()),
        ignored=dict(best.findings.skipped),
        refused=_refused(best, refusals, source),
        needs=needs,
        assumed=best.findings.assumptions_without(refusals),
        read_on=best.machine.name if best.machine is not None and found.dialect == CONTROLS else "",
        machines=runs,
        not_on={r.machine.name: _why_not(r, best, source) for r in readings if r.machine is not None and r.fault},
        used=best.findings.used,
        arcs=best.findings.arcs,
        tools=tuple(best.findings.used.tools),
    )
    return inspection if best.toolpath is None else _with_motion(inspection, best.toolpath)


def _readings(
    source: Source, options: ReadOptions, machines: Sequence[Candidate], found: Recognised, request: _Request
) -> list[_Reading]:
    """The program on each machine; what is for no controller, or ends on none, is read but once."""
    skipping = dataclasses.replace(options, skip_unknown=True)
    if found.dialect != CONTROLS or not machines:
        once = _read(source, None, request, skipping)
        if once.toolpath is None or not machines:
            return [once]
        return [_followed(dataclasses.replace(once, machine=machine), request.follow) for machine in machines]
    readings: list[_Reading] = []
    for machine in machines:
        endless = next((each for each in readings if isinstance(each.fault, EndlessError)), None)
        reading = (
            dataclasses.replace(endless, machine=machine) if endless else _read(source, machine, request, skipping)
        )
        readings.append(_followed(reading, request.follow))
    return readings


def _counts_as_the_part(machine: Candidate | None) -> bool:
    """Whether X, Y and Z of a machine move the tip along those of the part, where its rotary joints are at zero."""
    poses = Poses(machine)
    if machine is None or len(poses.linear) < 3:
        return False
    _, columns, _ = poses.linear_map([0.0] * len(poses.rotary))
    return np.allclose(columns, np.eye(3), atol=TURNED)


def _read(source: Source, machine: Candidate | None, request: _Request, options: ReadOptions) -> _Reading:
    findings = Findings()
    try:
        toolpath = read_source(source, machine, request.dialect, options, feed=request.feed, findings=findings)
    except ToolpaceError as error:
        # without what was going on when it was raised, which holds all that was read
        return _Reading(machine, findings, None, error.with_traceback(None))
    if not findings.skipped:
        findings.skipped.update(toolpath.skipped)
    for sentence in toolpath.assumed:
        findings.assumed(sentence)
    return _Reading(machine, findings, toolpath)


def _followed(reading: _Reading, follow: Follow) -> _Reading:
    """With what keeps the machine from following it."""
    if reading.toolpath is None or reading.machine is None:
        return reading
    try:
        with with_cure_of_zero(reading.toolpath.assumed):
            follow(reading.machine, reading.toolpath)
    except ToolpaceError as error:
        return dataclasses.replace(reading, fault=error)
    return reading


def _refused(reading: _Reading, found: tuple[Refusal, ...], source: Source) -> tuple[Refusal, ...]:
    """The words that were found to be refused, and the error that ended the reading."""
    if reading.toolpath is None and reading.fault is not None:
        return (*found, _refusal(reading.fault, source.name))
    return found


def _refusal(error: ToolpaceError, program: str) -> Refusal:
    """An error as a refusal: the block stands for the word."""
    text, line = (error.text.strip(), error.line) if isinstance(error, ProgramError) else ("", 0)
    return Refusal(text[:LONGEST_WORD] or "the program", line, 1, _message(error, program))


def _message(error: ToolpaceError, program: str) -> str:
    """What an error says, without the program, line and block that it is listed under."""
    message = str(error)
    if isinstance(error, ProgramError):
        message = message.removesuffix(f" in '{error.text.strip()[:60]}'")
        return message.removeprefix(f"{program}:{error.line}: ").removeprefix(f"{program}: ")
    return message.removeprefix(f"{program}:").removeprefix(" ")


def _why_not(reading: _Reading, best: _Reading, source: Source) -> str:
    """Why a machine cannot run the program, in one line."""
    if best.toolpath is None and str(reading.fault) == str(best.fault):
        return "the program is not read whole: see what is refused"
    assert reading.fault is not None
    message = _message(reading.fault, source.name)
    if reading.machine is not None:
        message = message.replace(f"machine '{reading.machine.name}' has", "it has", 1)
    message = message.partition(", its joints are")[0]
    line = reading.fault.line if isinstance(reading.fault, ProgramError) else 0
    at = f"line {line}: " if line else "line " if message[:1].isdigit() else ""
    return at + message


def _with_motion(inspection: Inspection, toolpath: ToolPath) -> Inspection:
    """What the motion tells: counts of blocks, and extents."""
    tip, axis = toolpath.tip, toolpath.axis
    turns = np.abs(np.diff(axis, axis=0)).max(axis=1) > TURNED
    if toolpath.rotary is not None and toolpath.rotary.shape[1]:
        turns |= np.abs(np.diff(toolpath.rotary, axis=0)).max(axis=1) > TURNED
    tilt = np.arctan2(np.hypot(axis[:, 0], axis[:, 1]), axis[:, 2])
    tools = [operation.tool for operation in toolpath.operations if operation.tool]
    rotary = toolpath.rotary if toolpath.rotary is not None else np.zeros((len(tip), 0))
    feed = np.flatnonzero(~toolpath.rapid[1:] & (toolpath.way_length[1:] > 0.0)) + 1
    return dataclasses.replace(
        inspection,
        blocks=toolpath.blocks or inspection.blocks,
        five_axis_blocks=_blocks_with(turns, toolpath.block[1:]),
        rapids=_blocks_with(toolpath.rapid[1:], toolpath.block[1:]),
        stops=int(toolpath.stop[1:-1].sum()),
        dwells=int((toolpath.dwell > 0.0).sum()),
        dwell_s=float(toolpath.dwell.sum()),
        tools=tuple(dict.fromkeys([*inspection.tools, *tools])),
        shapes={each.tool: each.figures for each in toolpath.operations if each.tool and each.figures is not None},
        workpiece=toolpath.workpiece,
        tip=_extent(tip),
        tip_at_feed=_extent(np.concatenate([tip[feed], toolpath.way_start[feed]])) if len(feed) else None,
        tilt=_range(tilt),
        rotary={name: _range(rotary[:, k]) for k, name in enumerate(toolpath.rotary_joints) if rotary.shape[1] > k},
    )


def _blocks_with(which: Bools, block: Ints) -> int:
    """How many blocks have one of these ways (n,); a block counts each time that it is executed."""
    number = np.cumsum(np.diff(block, prepend=block[0]) != 0)
    return len(np.unique(number[which]))


def _extent(points: Floats) -> tuple[Range, Range, Range]:
    return _range(points[:, 0]), _range(points[:, 1]), _range(points[:, 2])


def _range(values: Floats) -> Range:
    return float(values.min()), float(values.max())
