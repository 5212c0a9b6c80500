"""Tool paths from checked points and the tool lengths of a set-up sheet: the last step of every reader."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import NoReturn

import numpy as np

from toolpace.common.arrays import Bools, Floats, Ints
from toolpace.programs.reading.coordinates.kinematics import Kinematics
from toolpace.programs.reading.coordinates.setup import SetUp
from toolpace.programs.reading.feeds import LONGEST, SLOWEST, feed_fault
from toolpace.programs.reading.findings import Findings
from toolpace.programs.reading.source import Source
from toolpace.programs.stock_figures import WorkpieceFigures
from toolpace.programs.toolpath import Operation, ToolPath, no_normals, untold

SAME = 1e-12
"""ProgramPoints closer than this [m, rad] are the same point."""
FARTHEST = 1e3
"""Most of a coordinate [m]: more is a slip of units."""
AXIS_ROUNDING = 0.02
"""How far the length of a tool axis may be from 1: programs round it to three to six decimals."""
ONLY_TOOL = "the program names no tool: {}, the only one of the set-up sheet, is in the spindle"
NO_SHEET = (
    "no set-up sheet tells the lengths of tools: each is as long as the machine's own, {:g} mm on {} ([tools] of "
    "--setup FILE tells others)"
)
NO_TOOL = "the program names no tool, and the set-up sheet has several: it is as long as the machine's own"


@dataclass(frozen=True)
class ProgramPoints:
    """ProgramPoints in order, as ToolPath has them (see there for shapes and units)."""

    tip: Floats
    axis: Floats
    feed: Floats
    least_time: Floats
    block: Ints
    stop: Bools
    dwell: Floats
    rapid: Bools
    operation: Ints
    rotary: Floats | None = None
    rotary_joints: tuple[str, ...] = ()
    normal: Floats | None = None
    """(n, 3) unit vectors out of the part, nan where the program tells none."""
    tolerance: Floats | None = None
    """(n, 2) how far tip [m] and axis [rad] may stray by the program's words, nan where it tells nothing."""
    tool_length: Floats | None = None
    """(n,) of the tool whose tip is meant [m]; None: of the machine's own."""
    bow: Floats | None = None
    """(n,) most distance of the way to the point from the straight one [m]; None: all are straight."""
    spindle: Floats | None = None
    """(n,) turns per second [1/s], as ToolPath has them; None: nothing tells them."""

    def of_one_tool(self, axis: Floats) -> Floats:
        """(n, 3) the tips as they would be with the first tool at unit axes (n, 3): what joints move shows in them."""
        if self.tool_length is None:
            return self.tip
        tips: Floats = self.tip + (self.tool_length - self.tool_length[0])[:, None] * axis
        return tips


@dataclass(frozen=True)
class ProgramFacts:
    """What a program tells beside its points."""

    skipped: dict[str, int] = field(default_factory=dict)
    assumed: tuple[str, ...] = ()
    blocks: int = 0
    operations: tuple[Operation, ...] = (Operation(),)
    controller: str = ""
    workpiece: WorkpieceFigures = field(default_factory=WorkpieceFigures)

    @staticmethod
    def of(
        findings: Findings, blocks: int, operations: tuple[Operation, ...] = (), controller: str = ""
    ) -> ProgramFacts:
        """With what was found while it was read."""
        shapes = findings.tool_shapes
        shaped = [
            each if each.figures is not None or each.tool not in shapes else replace(each, figures=shapes[each.tool])
            for each in operations or (Operation(),)
        ]
        return ProgramFacts(
            dict(findings.skipped), findings.assumptions, blocks, tuple(shaped), controller, findings.workpiece
        )


def assemble(source: Source, points: ProgramPoints, facts: ProgramFacts) -> ToolPath:
    """ToolPath of points in order.

    A point equal to the one before is dropped: a repeated position takes no time. Its stop and its dwell move
    onto the point that stays. The first and the last point are stops, and where the length of the tool changes.
    """
    axis = unit_axes(source, points.axis, points.block)
    kept = np.flatnonzero(_moved(points.of_one_tool(axis), axis if points.rotary is None else points.rotary))
    if len(kept) < 2:
        refuse_still(source, len(points.tip))
    stop = np.logical_or.reduceat(points.stop, kept)
    stop[[0, -1]] = True
    tool_length = np.full(len(kept), np.nan) if points.tool_length is None else points.tool_length[kept]
    stop[:-1] |= np.abs(np.diff(tool_length)) > 0.0
    feed, least_time = points.feed[kept], points.least_time[kept]
    # Nothing leads to the first point.
    feed[0], least_time[0] = np.inf, 0.0
    tolerance = np.full((len(kept), 2), np.nan) if points.tolerance is None else points.tolerance[kept]
    _refuse_endless(source, feed, least_time, points.block[kept])
    return ToolPath(
        tip=np.ascontiguousarray(points.tip[kept]),
        axis=np.ascontiguousarray(axis[kept]),
        feed=feed,
        least_time=least_time,
        block=points.block[kept],
        stop=stop,
        dwell=np.add.reduceat(points.dwell, kept),
        rotary=None if points.rotary is None else np.ascontiguousarray(points.rotary[kept]),
        rotary_joints=points.rotary_joints,
        source=source.name,
        blocks=facts.blocks,
        skipped=facts.skipped,
        rapid=points.rapid[kept],
        operation=points.operation[kept],
        operations=facts.operations,
        controller=facts.controller,
        assumed=facts.assumed,
        tip_tolerance=np.ascontiguousarray(tolerance[:, 0]),
        axis_tolerance=np.ascontiguousarray(tolerance[:, 1]),
        tool_length=tool_length,
        bow=np.zeros(len(kept)) if points.bow is None else points.bow[kept],
        normal=no_normals() if points.normal is None else np.ascontiguousarray(points.normal[kept]),
        spindle=untold() if points.spindle is None else points.spindle[kept],
        workpiece=facts.workpiece,
    )


def _moved(tip: Floats, turned: Floats) -> Bools:
    """Whether each point (n,) differs from the one before, in its tip or in how it is turned."""
    moved = np.ones(len(tip), dtype=bool)
    if len(tip) > 1:
        moved[1:] = np.abs(np.diff(tip, axis=0)).max(axis=1) > SAME
        if turned.shape[1]:
            moved[1:] |= np.abs(np.diff(turned, axis=0)).max(axis=1) > SAME
    return moved


def _refuse_endless(source: Source, feed: Floats, least_time: Floats, block: Ints) -> None:
    """Refuse a block that takes longer than anybody waits: its numbers are a slip, and would swamp all others."""
    slowest, longest = int(np.argmin(feed)), int(np.argmax(least_time))
    if feed[slowest] < SLOWEST:
        source.fail(feed_fault(float(feed[slowest])), int(block[slowest]))
    if not least_time[longest] <= LONGEST:
        source.fail(f"this block takes {least_time[longest]:.3g} s, more than a year: correct F", int(block[longest]))


def refuse_still(source: Source, positions: int) -> NoReturn:
    """Raise the error of a program with fewer than two different positions."""
    where = ": it names one position only, and the path starts there" if positions else ""
    source.fail(f"there is no motion in the program{where}; is it complete, and is this its dialect?", 0)


def unit_axes(source: Source, axis: Floats, block: Ints) -> Floats:
    """Tool axes (n, 3) at length 1; ProgramError with the line of the first that is zero or no unit vector."""
    length = np.linalg.norm(axis, axis=1)
    wrong = np.flatnonzero(~(np.abs(length - 1) <= AXIS_ROUNDING))
    if len(wrong):
        first = wrong[0]
        line, found = int(block[first]), float(length[first])
        if found < 1e-6:
            source.fail("the tool axis i, j, k is zero: give the direction from the tip to the spindle", line)
        source.fail(
            f"the tool axis i, j, k has length {found:.6g}, not 1 (2 percent of rounding allowed): "
            "give a unit vector from the tip to the spindle",
            line,
        )
    return np.asarray(axis / length[:, None])


def programmed_lengths(lengths: Floats, machine: Kinematics | None) -> Floats | None:
    """Lengths (n,) of tools [m] as a tool path tells them; None where all are as long as the machine's own, whatever
    that is, and without a machine, where nobody knows."""
    return None if machine is None or (lengths == float(machine.tool_length)).all() else lengths


class ToolLengths:
    """The tool table of a set-up sheet, and the machine's own tool for what has no length on it."""

    def __init__(self, source: Source, setup: SetUp, machine: Kinematics | None, findings: Findings) -> None:
        self.source, self.setup, self.machine, self.findings = source, setup, machine, findings

    def lists(self, tool: str) -> bool:
        """Whether the sheet has this number or name."""
        return self.setup.tool(tool) is not None

    def along(self, operations: Sequence[Operation], operation: Ints, line: Ints) -> Floats | None:
        """(n,) length of the tool in the spindle on the way to each point [m], from its operation (n,).

        None where the sheet tells no lengths. `line` (n,) is for messages. Raises ProgramError where the sheet does not
        list a tool, and no machine tells another length.
        """
        self.findings.used.tools.update(dict.fromkeys(each.tool for each in operations if each.tool))
        if not self.setup.tells_lengths:
            if self.machine is not None:
                self.findings.assumed(NO_SHEET.format(float(self.machine.tool_length) * 1e3, self.machine.name))
            return None
        lengths = np.array([self._of(each.tool) for each in operations])
        unknown = np.isnan(lengths)[operation]
        if unknown.all():
            return None
        if unknown.any():
            at = int(np.argmax(unknown))
            self.source.fail(
                f"tool {operations[operation[at]].tool or 'without a name'} is not on the set-up sheet, and without a "
                "machine its length is not known: list it there, or give the machine",
                int(line[at]),
            )
        return lengths[operation] if self.machine is None else programmed_lengths(lengths[operation], self.machine)

    def _of(self, tool: str) -> float:
        """Length of a tool [m]; nan where nothing tells it."""
        tools = self.setup.tools
        if not tool and len(tools) == 1:
            (only,) = tools
            self.findings.assumed(ONLY_TOOL.format(only))
            tool = only
        found = self.setup.tool(tool)
        if found is not None and found.length is not None:
            return found.length
        self.findings.assumed(self.setup.length_doubt(tool) if tool else NO_TOOL)
        return np.nan if self.machine is None else float(self.machine.tool_length)
